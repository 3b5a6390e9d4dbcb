"""Frames of a route one after the other, each read when it is needed: pictures, films, arrays, recordings of robots."""

from __future__ import annotations

import glob
import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_count, check_range, counted, quoted
from insectnav.datasets.clocks import rounding_of
from insectnav.datasets.image_folder import PICTURES, RAW, VIDEOS, as_text, find_images, named, natural_order
from insectnav.datasets.video import video_facts
from insectnav.experiments.picture_sources import count_frames_of, count_pictures, given, sources

Reals = NDArray[np.floating[Any]]
ARRAYS = (".npy", ".zarr")
BAGS = (".bag", ".mcap", ".db3")
MAX_VECTORS = 100_000_000  # of an array
MAX_FEATURES = 1_000_000  # of a vector
VECTORS_AT_ONCE = 256
SAFE_CODECS = frozenset(  # of zarr; others may run what is in a file, as pickle does
    {"bytes", "transpose", "sharding_indexed", "crc32c", "blosc", "zstd", "gzip", "zlib", "lz4", "bz2", "lzma"}
)
SOUND = 0.98  # share of the frames that a film says it has, and has if it is sound; some tell about how many; assumed
UNCOUNTED = (".mkv", ".webm", ".mpg", ".mpeg")  # which say how long they are, not of how many frames
MAX_FILES = 10_000_000  # of a pattern
NOWHERE: Reals = np.full(3, np.nan)


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """One frame to come.

    Parameters
    ----------
    name : of its file, or of its source with its number
    number : among all frames of its source, from 0
    time : [s], NaN if unknown
    position : (3,) [m] east, north, up; NaN if unknown
    read : gives the picture (rows, columns) or (rows, columns, 3), or the vector (feature,)
    """

    name: str
    number: int
    read: Callable[[], NDArray[Any]]
    time: float = float("nan")
    position: Reals = field(default_factory=NOWHERE.copy)


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameSource:
    """Frames of a route.

    Parameters
    ----------
    frames : in the order in which they were taken
    total : how many there are, as far as the files say; 0 if nobody knows
    kind : "pictures", "film", "films" (or pictures and films), "array" or "bag"
    skipped : names of files that are none, with the reason
    files : of pictures, in the order of the frames
    frame_rate : of a film [1/s]
    step : of its frames every so many come
    remarks : what a person must know of them, filled as they are read
    """

    frames: Iterator[Frame]
    total: int
    kind: str
    skipped: tuple[tuple[str, str], ...] = ()
    files: tuple[Path, ...] = ()
    frame_rate: float = float("nan")
    step: int = 1
    remarks: Sequence[str] = ()

    @property
    def is_vectors(self) -> bool:
        """Whether the frames are features already."""
        return self.kind == "array"

    @property
    def has_times(self) -> bool:
        """Whether the frames tell themselves when they were taken."""
        return self.kind == "bag" or bool(np.isfinite(self.frame_rate))


@dataclass(frozen=True, kw_only=True)
class Thinning:
    """Which frames are taken: every so many, or those far enough from the one taken before, in metres or seconds.

    Raises
    ------
    InputError
        If more than one of them is given, or one makes no sense.
    """

    step: int | None = None  # [frame]
    every_m: float | None = None  # [m]
    every_s: float | None = None  # [s]

    def __post_init__(self) -> None:
        given = [name for name, value in vars(self).items() if value is not None]
        if len(given) > 1:
            names = " and ".join("--" + name.replace("_", "-") for name in given)
            raise InputError(f"{names} are given, expected one of them")
        if self.step is not None:
            check_count("step", self.step)
        for name in ("every_m", "every_s"):
            if getattr(self, name) is not None:
                check_range(name, getattr(self, name), 1e-9, np.inf)

    @property
    def in_words(self) -> str:
        """Which frames are taken, for a person."""
        if self.every_m is not None:
            return f"frames at least {self.every_m:g} m from the one taken before"
        if self.every_s is not None:
            return f"frames at least {self.every_s:g} s after the one taken before"
        step = self.step or 1
        return "every frame" if step == 1 else f"every {step}{_ordinal(step)} frame"


def open_frames(
    places: Sequence[str | os.PathLike[str]], *, step: int = 1, topic: str | None = None, clock: str | None = None
) -> FrameSource:
    """Frames of folders, patterns of names, files, films, one array of features, or one recording of a robot.

    Parameters
    ----------
    places : what the user named; pictures and films in the order given, those of a folder in natural order
    step : of a film every so many frames alone are decoded
    topic : of the pictures in a recording; None for the only one
    clock : of a recording, "stamp" or "bag"; None for "stamp"

    Raises
    ------
    InputError
        If there is nothing that can be read.
    """
    paths = [path for place in places for path in _matching(place)]
    kinds = {_kind(path) for path in paths}
    if kinds - {"pictures"} and len(paths) > 1:
        raise InputError(
            f"{len(paths)} places are given, expected one alone where it is an array or the recording of a robot, such "
            f"as {quoted(next(path for path in paths if _kind(path) != 'pictures'), 200)}"
        )
    if kinds == {"array"}:
        return _of_array(paths[0])
    if kinds == {"bag"}:
        return _of_bag(paths[0], topic, clock)
    if topic is not None:
        raise InputError(f"--topic is {quoted(topic)}, expected it with the recording of a robot alone")
    return _of_pictures(paths, step)


def thinned(frames: Iterator[Frame], thinning: Thinning, left_out: list[str]) -> Iterator[Frame]:
    """Those of the frames that are to be taken.

    Parameters
    ----------
    frames : with their times and positions
    thinning : Thinning
    left_out : gets the names of frames that have no time or position to decide by
    """
    if thinning.every_m is None and thinning.every_s is None:
        step = thinning.step or 1
        yield from (frame for k, frame in enumerate(frames) if k % step == 0)
        return
    last: Frame | None = None
    for frame in frames:
        if not _is_decidable(frame, thinning):
            left_out.append(frame.name)
        elif last is None or _is_far(frame, last, thinning):
            last = frame
            yield frame


def _is_decidable(frame: Frame, thinning: Thinning) -> bool:
    return bool(np.isfinite(frame.time if thinning.every_m is None else frame.position[:2]).all())


def _is_far(frame: Frame, last: Frame, thinning: Thinning) -> bool:
    if thinning.every_s is not None:
        least, apart, rounding = thinning.every_s, frame.time - last.time, rounding_of([frame.time, last.time])
    else:
        least, places = thinning.every_m or 0.0, np.stack([frame.position[:2], last.position[:2]])
        apart, rounding = float(np.hypot(*(places[0] - places[1]))), rounding_of(places)
    return apart >= least - min(rounding, least / 2)


def _matching(place: str | os.PathLike[str]) -> list[Path]:
    """The place itself, or all files that a pattern such as walk/left_*.png stands for, in natural order."""
    path = named(place)
    if path.exists() or not glob.has_magic(str(place)):
        return [path]
    found = sorted((Path(name) for name in glob.iglob(str(place))), key=lambda one: natural_order(one.name))
    if not found:
        raise InputError(f"no file is called as {quoted(place, 200)}, expected a folder, a film or a pattern of names")
    if len(found) > MAX_FILES:
        raise InputError(f"{len(found)} files are called as {quoted(place, 200)}, expected at most {MAX_FILES:.0e}")
    return found


def _kind(path: Path) -> str:
    if path.suffix.lower() in ARRAYS or (path / "zarr.json").exists():
        return "array"
    return "bag" if is_bag(path) else "pictures"


def is_bag(path: Path) -> bool:
    """Whether a place is the recording of a robot, of ROS 1 or 2, by its name."""
    return path.suffix.lower() in BAGS or (path / "metadata.yaml").exists()


def _of_pictures(paths: list[Path], step: int) -> FrameSource:
    found = find_images(paths, (*PICTURES, *RAW, *VIDEOS))
    films = [path for path in found.files if path.suffix.lower() in VIDEOS]
    if not films:
        listed = [
            Frame(name=as_text(source.name), number=number, read=source.read)
            for number, source in enumerate(sources(found, 1))
        ]
        return FrameSource(
            frames=iter(listed), total=len(listed), kind="pictures", skipped=found.skipped, files=found.files
        )
    is_one = len(found.files) == 1
    step = step if is_one else 1
    remarks: list[str] = []

    def frames() -> Iterator[Frame]:
        seen: Counter[Path] = Counter()
        last_s: dict[Path, float] = {}
        for number, source in enumerate(sources(found, step)):
            seen[source.file] += 1
            last_s[source.file] = source.time
            time = source.time if is_one else float("nan")  # of several films each begins at 0
            yield Frame(name=as_text(source.name), number=number * step, read=source.read, time=time)
        remarks.extend(_cut_short(film, seen[film], last_s.get(film, 0.0), step) for film in films)
        remarks[:] = filter(None, remarks)

    return FrameSource(
        frames=frames(),
        total=count_pictures(found, step),
        kind="film" if is_one else "films",
        skipped=found.skipped,
        frame_rate=_frame_rate(films[0]) if is_one else float("nan"),
        step=step,
        remarks=remarks,
    )


def _cut_short(film: Path, n_seen: int, last_s: float, step: int) -> str:
    """That much of a film could not be read, if so: where nothing says of how many frames it is, by its length."""
    said = count_frames_of(film, step)
    if n_seen >= SOUND * said - 1:
        return ""
    if film.suffix.lower() in UNCOUNTED and n_seen > 1:
        facts, length_s = video_facts(film), last_s * n_seen / (n_seen - 1)
        if length_s * facts.frames_per_second >= SOUND * facts.n_frames:
            return ""
    return f"{quoted(film.name, 200)} should give {said} frames, {n_seen} could be read: cut short, or damaged?"


def _frame_rate(path: Path) -> float:
    try:
        rate = video_facts(path).frames_per_second
    except InputError:  # is told when it is read
        return float("nan")
    return rate if rate > 0 else float("nan")


def _of_array(path: Path) -> FrameSource:
    """Vectors (frame, feature) of a file of NumPy, or a zarr array; nothing in them is run."""
    array = _open_array(path)
    if array.ndim != 2 or 0 in array.shape or np.dtype(array.dtype).kind not in "biuf":
        raise InputError(
            f"{quoted(path.name, 200)} holds an array of shape {tuple(array.shape)} and type {array.dtype}, expected "
            "real numbers (frame, feature): one descriptor a row"
        )
    n_vectors = int(array.shape[0])
    if n_vectors > MAX_VECTORS or array.shape[1] > MAX_FEATURES:
        raise InputError(
            f"{quoted(path.name, 200)} holds {counted(n_vectors, 'vector')} of {counted(array.shape[1], 'feature')}, "
            f"expected at most {MAX_VECTORS:.0e} of {MAX_FEATURES:.0e}"
        )
    stem = as_text(path.stem)

    def frames() -> Iterator[Frame]:
        for first in range(0, n_vectors, VECTORS_AT_ONCE):  # a chunk of a zarr array is not read for each of its rows
            for k, vector in enumerate(np.asarray(array[first : first + VECTORS_AT_ONCE])):
                yield Frame(name=f"{stem}_{first + k:06d}", number=first + k, read=partial(given, vector))

    return FrameSource(frames=frames(), total=n_vectors, kind="array")


def _open_array(path: Path) -> Any:
    name = quoted(path.name, 200)
    try:
        if path.suffix.lower() == ".npy":
            return np.load(path, mmap_mode="r", allow_pickle=False)
        import zarr

        opened = zarr.open(path, mode="r")
    except FileNotFoundError:
        raise InputError(f"{name} does not exist, expected an array of features") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{name} cannot be read as an array ({_first_line(error)}): damaged, or of objects?") from None
    arrays = [opened] if isinstance(opened, zarr.Array) else [one for _, one in opened.arrays() if one.ndim == 2]
    if len(arrays) != 1:
        raise InputError(
            f"{name} holds {len(arrays)} arrays (frame, feature), expected one: name it, as in FILE.zarr/NAME"
        )
    if unsafe := _codecs(arrays[0]) - SAFE_CODECS:
        raise InputError(f"{name} is packed by {quoted(min(unsafe))}, expected one of {', '.join(sorted(SAFE_CODECS))}")
    return arrays[0]


def _codecs(array: Any) -> set[str]:
    """Names of what packs a zarr array, of format 2 or 3."""
    about = array.metadata.to_dict()
    parts = [*(about.get("codecs") or ()), about.get("compressor"), *(about.get("filters") or ())]
    return {str(part.get("name") or part.get("id")) for part in parts if part}


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0][:120] if str(error) else type(error).__name__


def _of_bag(path: Path, topic: str | None, clock: str | None) -> FrameSource:
    from insectnav.datasets.ros_bag import STAMP, bag_frames

    remarks: list[str] = []

    def frames() -> Iterator[Frame]:
        for number, frame in enumerate(bag_frames(path, topic, clock=clock or STAMP)):
            if frame.remark and frame.remark not in remarks:
                remarks.append(frame.remark)
            yield Frame(name=f"{as_text(path.stem)}_{number:06d}", number=number, read=frame.read, time=frame.time)

    return FrameSource(frames=frames(), total=0, kind="bag", remarks=remarks)


def _ordinal(number: int) -> str:
    if number % 100 in (11, 12, 13):
        return "th"
    return {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
