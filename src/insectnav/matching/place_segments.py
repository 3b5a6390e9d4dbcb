"""Places that were added to a map one after the other, each addition in a folder of its own; many small ones merge."""

import re
import shutil
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

from insectnav.checks import InputError
from insectnav.matching.place_about import MapAbout
from insectnav.matching.place_arrays import PlaceArrays, joined, read_places
from insectnav.matching.place_store import (
    DamagedError,
    remove_partial,
    shown,
    whole_folder,
    write_arrays,
    written,
)

SEGMENTS = "segments"
NAME = re.compile(r"(\d{8})-(\d{8})")  # numbers of the first and last addition in it
MERGED_AT_ONCE = 16
MOST_MERGED = 2**16  # [place] more are not moved about
Segments = dict[str, PlaceArrays]


def segment_names(folder: Path) -> list[str]:
    """Names of the segments that make up the map, in order; those that were merged into others are left out.

    Raises
    ------
    DamagedError
        If one is missing.
    """
    found: dict[int, tuple[int, str]] = {}
    try:
        names = [path.name for path in (folder / SEGMENTS).iterdir()]
    except OSError:
        raise DamagedError(f"the map {shown(folder)} lacks its folder {SEGMENTS!r}") from None
    for name in names:
        if match := NAME.fullmatch(name):
            first, last = int(match[1]), int(match[2])
            found[first] = max(found.get(first, (-1, "")), (last, name))
    chain, after = [], 0
    while after in found:
        last, name = found[after]
        chain.append(name)
        after = last + 1
    if found and (not chain or max(found) >= after):
        raise DamagedError(f"the map {shown(folder)} lacks what was added as number {after}")
    return chain


def read_segments(folder: Path, about: MapAbout, known: Mapping[str, PlaceArrays]) -> Segments:
    """All segments by name; those that are known are not read again.

    Raises
    ------
    DamagedError
        If they are not as they were written.
    """
    names = segment_names(folder)
    while True:
        try:
            segments = {name: known.get(name) or read_places(folder / SEGMENTS / name, about) for name in names}
        except DamagedError:
            # Another process may have merged some of them in the meantime.
            names, before = segment_names(folder), names
            if names == before:
                raise
        else:
            _check_kinds(folder, segments)
            return segments


def _check_kinds(folder: Path, segments: Segments) -> None:
    parts = list(segments.values())
    for before, after in pairwise(parts):
        if before.kind != after.kind or after.routes[0] - before.routes[-1] not in (0, 1):
            raise DamagedError(f"the segments of the map {shown(folder)} do not follow each other: damaged?")


def add_segment(folder: Path, about: MapAbout, segments: Segments, places: PlaceArrays) -> Segments:
    """All segments after one more; on disk when this returns. For the one writer.

    Raises
    ------
    InputError
        If the disk is full or the folder may not be written.
    """
    number = 1 + max((_last(name) for name in segments), default=-1)
    if number > 99_999_999:
        raise InputError(f"the map {shown(folder)} was added to 100 million times, expected fewer: freeze it")
    with written(folder):
        remove_partial(folder / SEGMENTS)
        segments = segments | _put(folder, about, number, number, places)
        while merged := _to_merge(segments):
            parts = [segments[name] for name in merged]
            whole = _put(folder, about, int(merged[0][:8]), _last(merged[-1]), joined(parts))
            segments = {name: part for name, part in segments.items() if name not in merged} | whole
            for name in merged:
                shutil.rmtree(folder / SEGMENTS / name)
    return segments


def _put(folder: Path, about: MapAbout, first: int, last: int, places: PlaceArrays) -> Segments:
    name = f"{first:08d}-{last:08d}"
    with whole_folder(folder / SEGMENTS / name) as temporary:
        write_arrays(temporary, places.as_arrays())
    return {name: read_places(folder / SEGMENTS / name, about)}


def _last(name: str) -> int:
    return int(name[9:])


def _to_merge(segments: Segments) -> list[str]:
    """The newest segments, if there are enough of one size and their places are few."""
    names = list(segments)[-MERGED_AT_ONCE:]
    spans = {_last(name) - int(name[:8]) for name in names}
    is_due = len(names) == MERGED_AT_ONCE and len(spans) == 1
    return names if is_due and sum(len(segments[name].times) for name in names) <= MOST_MERGED else []
