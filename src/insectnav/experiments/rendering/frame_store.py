"""Frames on disk while they are rendered: what is finished stays, whatever happens to the rest."""

import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from insectnav.checks import InputError, quoted
from insectnav.datasets.picture_files import write_picture
from insectnav.experiments.results import PROVENANCE, plain, replace_folder, to_json, written_to
from insectnav.experiments.store import locked

ABOUT = "render.json"  # all that the pictures follow from
TABLE = "frames.csv"
SHEET = "contact_sheet.png"
JOURNAL = ".finished.jsonl"  # a line for each frame whose pictures are on disk


class FrameStore:
    """A folder of pictures that lacks its name until it is complete.

    Parameters
    ----------
    final : Path
        Its name at the end.
    about : JSON object
        All that the pictures follow from: frames of another are not mixed with these.
    suffixes : name of each kind of picture → ending of its files
    """

    def __init__(self, final: Path, about: Mapping[str, Any], suffixes: Mapping[str, str]) -> None:
        self.final = final
        self.folder = unfinished(final)
        self._about = to_json(about) + "\n"
        self._suffixes = suffixes

    def open(self) -> dict[int, dict[str, Any]]:
        """Make the folder, or find what an earlier run has finished: rows of the table by number of frame.

        Raises
        ------
        InputError
            If what is there was made with other parameters, or the place cannot be written.
        """
        with written_to(self.final):
            if not (self.folder / ABOUT).is_file():
                shutil.rmtree(self.folder, ignore_errors=True)
                for kind in self._suffixes:
                    (self.folder / kind).mkdir(parents=True, exist_ok=True)
                (self.folder / ABOUT).write_text(self._about, encoding="utf-8")
            check_same(self.folder, self._about)
            rows = _journal(self.folder / JOURNAL)
            _end_line(self.folder / JOURNAL)
            for part in self.folder.rglob(".*.part"):  # of a process that was killed while it wrote
                part.unlink()
        return {index: row for index, row in rows.items() if self._is_there(index)}

    def path(self, kind: str, index: int) -> Path:
        """File of a picture of a frame."""
        return self.folder / kind / file_name(index, self._suffixes[kind])

    def write(self, index: int, pictures: Mapping[str, Any]) -> None:
        """Put the pictures of a frame on disk; `note` says that they are all there.

        Raises
        ------
        InputError
            If the disk is full, or the folder cannot be written.
        """
        with written_to(self.final):
            for kind, picture in pictures.items():
                write_picture(self.path(kind, index), picture)

    def note(self, rows: Mapping[int, Mapping[str, Any]]) -> None:
        """Note frames as finished, with what is known of them only after rendering."""
        lines = "".join(json.dumps({"frame": index, **plain(row)}) + "\n" for index, row in rows.items())
        with written_to(self.final), (self.folder / JOURNAL).open("a", encoding="utf-8") as file:
            file.write(lines)

    def complete(self, made: Mapping[str, Any]) -> None:
        """Give the folder its name; provenance comes last.

        Parameters
        ----------
        made : what it was made with, when and where
        """
        with written_to(self.final):
            (self.folder / PROVENANCE).write_text(to_json(made) + "\n", encoding="utf-8")
            (self.folder / JOURNAL).unlink(missing_ok=True)
            replace_folder(self.final, self.folder)

    def remove_if_empty(self) -> None:
        """Leave nothing behind where no frame is finished."""
        if not _journal(self.folder / JOURNAL):
            shutil.rmtree(self.folder, ignore_errors=True)

    def _is_there(self, index: int) -> bool:
        return all(self.path(kind, index).is_file() for kind in self._suffixes)


def unfinished(final: Path) -> Path:
    """The folder in which frames are gathered, beside the final one."""
    final = Path(os.path.realpath(final))
    return final.with_name(f".{final.name}.unfinished")


def finished_frames(final: Path) -> int:
    """Number of frames that an unfinished run has left for that destination."""
    return len(_journal(unfinished(final) / JOURNAL))


def file_name(index: int, suffix: str) -> str:
    """Name of the file of a frame: its number, with six digits."""
    return f"{index:06d}{suffix}"


@contextmanager
def prepared(final: Path, about: Mapping[str, Any], *, resume: bool, replaces: bool) -> Iterator[bool]:
    """Hold the destination for this process alone; whether the same frames are there already.

    Raises
    ------
    InputError
        If it holds anything that would be lost, is being written by another process, or cannot be written.
    """
    with ExitStack() as held:
        with written_to(final):
            final.parent.mkdir(parents=True, exist_ok=True)
            held.enter_context(locked(final.with_name(f".{final.name}.lock")))
        is_there = _check_final(final, to_json(about) + "\n", resume, replaces)
        waiting = unfinished(final)
        if not is_there and not resume and (n := finished_frames(final)):
            if not replaces:
                raise InputError(
                    f"{quoted(waiting, 200)} holds {n} frames of an unfinished run: add --resume to go on with it, or "
                    "--replace to begin anew"
                )
            shutil.rmtree(waiting, ignore_errors=True)
        elif not resume:
            shutil.rmtree(waiting, ignore_errors=True)
        yield is_there


def check_same(folder: Path, about: str) -> None:
    """Refuse frames that were made with other parameters; names the first that differs.

    Parameters
    ----------
    folder : with a file ABOUT
    about : text of that file as it would be now

    Raises
    ------
    InputError
    """
    try:
        earlier = (folder / ABOUT).read_text(encoding="utf-8")
        if earlier == about:
            return
        before, now = (dict(_leaves(json.loads(text))) for text in (earlier, about))
    except (OSError, ValueError):
        raise InputError(f"{quoted(folder / ABOUT, 200)} cannot be read, expected a new name for --out") from None
    names = [name for name in now if before.get(name) != now[name]] + [name for name in before if name not in now]
    name = names[0] if names else "the order of parameters"
    if name in ("code", "insectnav"):
        raise InputError(
            f"{quoted(folder, 200)} was rendered by another version of insectnav, whose pictures may differ: "
            "the same version as before, or another --out?"
        )
    raise InputError(
        f"{quoted(folder, 200)} was rendered with {name} {quoted(before.get(name))}, now {quoted(now.get(name))}: "
        "the same options as before, or another --out?"
    )


def _leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted names and values of an object within objects."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _leaves(item, f"{name}.{key}" if name else str(key))
    else:
        yield name, value


def _check_final(final: Path, about: str, resume: bool, replaces: bool) -> bool:
    """Whether the destination holds these very frames, finished; refuses what must not be lost."""
    shown = quoted(final, limit=200)
    with written_to(final):
        if final.exists() and not final.is_dir():
            raise InputError(f"--out {shown} is a file, expected a folder or a new name")
        if not final.exists() or not any(final.iterdir()):
            if not os.access(final.parent, os.W_OK | os.X_OK):
                raise InputError(f"--out {shown} cannot be written, expected a place where you may make a folder")
            return False
        strangers = [item.name for item in sorted(final.iterdir()) if not _is_ours(item)]
    if strangers or not (final / ABOUT).is_file():
        example = quoted(strangers[0]) if strangers else f"no {ABOUT}"
        raise InputError(f"--out {shown} holds other files, such as {example}, expected a new name or an empty folder")
    if resume:
        check_same(final, about)
        return True
    if not replaces:
        raise InputError(f"--out {shown} holds finished frames, expected another name, or --replace to do without them")
    return False


def _is_ours(item: Path) -> bool:
    """Whether a thing in the destination is one that this program leaves there."""
    from insectnav.experiments.rendering.pictures import PICTURES

    return item.name in {ABOUT, TABLE, SHEET, PROVENANCE} or (item.is_dir() and item.name in PICTURES)


def _end_line(path: Path) -> None:
    """End a line that was cut off, so that the next does not continue it."""
    if path.is_file() and not path.read_bytes().endswith(b"\n"):
        with path.open("a", encoding="utf-8") as file:
            file.write("\n")


def _journal(path: Path) -> dict[int, dict[str, Any]]:
    """What was noted, by number of frame; a line that was cut off counts for nothing."""
    try:
        lines: Sequence[str] = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return {}
    rows = {}
    for line in lines:
        try:
            row = json.loads(line)
            rows[int(row.pop("frame"))] = row
        except (ValueError, LookupError, TypeError, AttributeError):
            continue
    return rows
