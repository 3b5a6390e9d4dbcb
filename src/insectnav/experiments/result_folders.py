"""Reading folders of results that may come from anyone: what they hold is data, bounded in size and checked."""

from __future__ import annotations

import csv
import json
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

from insectnav.checks import InputError, quoted
from insectnav.experiments.experiment import SCALES
from insectnav.experiments.published import Verdict, read_verdicts
from insectnav.experiments.results import PROVENANCE
from insectnav.experiments.verdict_words import VERDICTS

Content = TypeVar("Content")
MEGABYTE = 2**20
FIGURE_LIMIT = 20 * MEGABYTE
TEXT_LIMIT = MEGABYTE
MOST_PIXELS = 10**8  # what a figure may unpack to
MOST_VERDICTS = 1000  # of one experiment
PNG_START, PNG_END = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", b"\x00\x00\x00\x00IEND\xaeB`\x82"


class _UnusableError(Exception):
    """A file that cannot be shown; says why, as the end of a sentence."""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure as it is embedded."""

    png: bytes
    width: int  # [pixel]
    height: int


@dataclass(frozen=True, kw_only=True)
class Run:
    """A finished run, as its provenance tells of it.

    Parameters
    ----------
    folder : relative to the folder of all results
    finished : time at which it was written
    scale, seed, n_cells, key, code, seconds : of the run
    n_earlier_cells : cells that came from an earlier run, which was resumed
    made_with : version and machine
    """

    folder: Path
    finished: datetime
    scale: str
    seed: int
    n_cells: int
    n_earlier_cells: int
    key: str
    code: str
    seconds: float
    made_with: str


@dataclass(frozen=True, kw_only=True)
class Result:
    """What a run left, as far as the page shows it.

    Parameters
    ----------
    run : Run
    picture : None where there is none that can be shown
    caption, verdicts : empty where they are missing
    notes : sentences on what is missing
    """

    run: Run
    picture: Picture | None
    caption: str
    verdicts: Sequence[Verdict]
    notes: Sequence[str]


def finished_runs(out: Path, name: str) -> tuple[list[Run], list[str]]:
    """All finished runs of an experiment, and a sentence on each folder that is none.

    Parameters
    ----------
    out : Path
        Folder of all results, which `insectnav.sweep.run_experiment` wrote to.
    name : str
        Of the experiment.
    """
    runs, notes = [], []
    for folder in _folders(out / name):
        try:
            runs.append(_run(folder / PROVENANCE, name, folder.name))
        except _UnusableError as error:
            notes.append(f"{quoted(Path(name, folder.name), 200)} is left out: {error}")
    return runs, notes


def read_result(out: Path, run: Run) -> Result:
    """What a run left; what is missing or cannot be shown is noted.

    Parameters
    ----------
    out : Path
        Folder of all results.
    run : Run
    """
    notes: list[str] = []

    def noted(read: Callable[[Path], Content], file: str, otherwise: Content) -> Content:
        try:
            return read(out / run.folder / file)
        except _UnusableError as error:
            notes.append(f"{quoted(run.folder / file, 200)} {error}")
            return otherwise

    return Result(
        run=run,
        picture=noted(_picture, "figure.png", None),
        caption=noted(_text, "caption.txt", ""),
        verdicts=noted(_verdicts, "comparison.csv", ()),
        notes=notes,
    )


def _folders(parent: Path) -> Iterator[Path]:
    """Folders of results; hidden ones are unfinished."""
    try:
        yield from sorted(item for item in parent.iterdir() if item.is_dir() and not item.name.startswith("."))
    except OSError:  # the experiment was never run
        return


def _content(path: Path, limit: int) -> bytes:
    """A regular file, if it is no larger than that."""
    try:
        if not path.is_file():  # a pipe would never end
            raise _UnusableError("is missing")
        with path.open("rb") as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise _UnusableError(f"cannot be read ({error.strerror})") from None
    if len(content) > limit:
        raise _UnusableError(f"is larger than {limit // MEGABYTE} MB, which is too large to be shown")
    return content


def _text(path: Path) -> str:
    try:
        return _content(path, TEXT_LIMIT).decode("utf-8").strip()
    except UnicodeDecodeError:
        raise _UnusableError("is not text") from None


def _picture(path: Path) -> Picture:
    """A whole PNG of reasonable size."""
    png = _content(path, FIGURE_LIMIT)
    if not png.startswith(PNG_START) or not png.endswith(PNG_END):
        raise _UnusableError("is not a whole PNG image")
    width, height = struct.unpack(">II", png[16:24])
    if not 0 < width * height <= MOST_PIXELS:
        raise _UnusableError(f"has {width} × {height} pixels, which is not a size that can be shown")
    return Picture(png=png, width=width, height=height)


def _verdicts(path: Path) -> list[Verdict]:
    columns, _, _ = _content(path, TEXT_LIMIT).partition(b"\n")
    if columns.strip() != ",".join(field.name for field in fields(Verdict)).encode():
        raise _UnusableError("has other columns than a table of published numbers and ours")
    try:
        verdicts = read_verdicts(path)
    except (InputError, LookupError, csv.Error):
        raise _UnusableError("cannot be read, expected a table of published numbers and ours") from None
    words = ("quantity", "unit", "verdict", "why", "source", "how_read")
    for verdict in verdicts:
        if verdict.verdict not in VERDICTS or not all(isinstance(getattr(verdict, word), str) for word in words):
            raise _UnusableError("cannot be read, expected a verdict in each row")
    if len(verdicts) > MOST_VERDICTS:
        raise _UnusableError(f"has {len(verdicts)} rows, expected at most {MOST_VERDICTS}")
    return verdicts


def _run(path: Path, name: str, key: str) -> Run:
    """What provenance.json tells."""
    try:
        content = json.loads(_text(path))
    except _UnusableError as error:
        raise _UnusableError(f"{path.name} {error}") from None
    except (ValueError, RecursionError):
        raise _UnusableError(f"{path.name} is not JSON") from None
    if not isinstance(content, dict) or content.get("experiment") != name:
        raise _UnusableError(f"{path.name} is not of this experiment")
    wrong = [field for field, is_right in _FIELDS.items() if not is_right(content.get(field))]
    if wrong:
        raise _UnusableError(f"{path.name} does not tell {', '.join(wrong)}")
    return Run(
        folder=Path(name, key),
        finished=datetime.fromisoformat(content["finished"]).astimezone(),
        scale=content["scale"],
        seed=content["seed"],
        n_cells=content["cells"],
        n_earlier_cells=content["cells_from_earlier_run"],
        key=key,
        code=content["code"],
        seconds=float(content["seconds"]),
        made_with=_made_with(content),
    )


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**63


def _is_time(value: object) -> bool:
    return isinstance(value, int | float) and 0 <= value < 1e9


def _is_moment(value: object) -> bool:
    try:
        return isinstance(value, str) and datetime.fromisoformat(value).astimezone().year > 1
    except (ValueError, OverflowError):
        return False


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 100


_FIELDS = {  # what provenance.json has to hold
    "scale": lambda value: isinstance(value, str) and value in SCALES,
    "seed": _is_count,
    "cells": _is_count,
    "cells_from_earlier_run": _is_count,
    "code": _is_name,
    "insectnav": _is_name,
    "python": _is_name,
    "finished": _is_moment,
    "seconds": _is_time,
}


def _made_with(content: Mapping[str, Any]) -> str:
    """Version and machine of a run, as far as they are told."""
    machine = content.get("machine")
    told = [machine.get(part) for part in ("system", "processor")] if isinstance(machine, dict) else []
    words = [str(word) for word in told if _is_name(word)]
    if isinstance(machine, dict) and _is_count(machine.get("cores")):
        words.append(f"{machine['cores']} cores")
    versions = [f"insectnav {content['insectnav']}", f"Python {content['python']}"]
    return ", ".join(versions + words)
