"""Tracks of a GPX file, after a look at it that the parser of XML does not take."""

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any
from xml.etree.ElementTree import ParseError

import numpy as np

from insectnav.checks import InputError
from insectnav.datasets.gps_track import MAX_FIXES, GpsTrack

MAX_BYTES = 128 * 2**20  # about a million fixes
MAX_TAGS = 8_000_000  # of elements, opened and closed; each takes some 100 bytes of memory
MAX_DEPTH = 50  # of elements in one another; GPX needs six
_DECLARATION = re.compile(r"<!\s*(?:DOCTYPE|ENTITY|ELEMENT|ATTLIST|NOTATION)", re.IGNORECASE)
_TAG = re.compile(r"<(/?)[A-Za-z_][^<>]*?(/?)>")


def parse_gpx(text: str) -> GpsTrack:
    """All tracks of a GPX file in order of their times; each segment of each track is one of the result.

    Parameters
    ----------
    text : XML; times without a zone are taken as UTC

    Raises
    ------
    InputError
        If it is no GPX, declares entities, is nested too deeply, or holds no track.
    """
    _check_harmless(text)
    segments = [segment for segment in _segments(text) if segment]
    if not segments:
        raise InputError("no track with points, expected one at least: waypoints or a planned route alone?")
    if sum(map(len, segments)) > MAX_FIXES:
        raise InputError(f"more than {MAX_FIXES} points, expected a single recording")
    pieces = [_numbers(segment) for segment in segments]
    with_times = [piece for piece in pieces if np.isfinite(piece[:, 0]).any()]
    if len(with_times) == len(pieces):  # programs write the tracks of a day in any order
        pieces.sort(key=lambda piece: float(np.nanmin(piece[:, 0])))
    values = np.concatenate(pieces)
    has_zone = all(point.time is None or point.time.tzinfo is not None for segment in segments for point in segment)
    return GpsTrack(
        time=values[:, 0],
        latitude_deg=values[:, 1],
        longitude_deg=values[:, 2],
        height=values[:, 3],
        segment=np.repeat(np.arange(len(pieces)), list(map(len, pieces))),
        notes=() if has_zone else ("times without a zone are taken as UTC",),
    )


def _check_harmless(text: str) -> None:
    """Refuse what could make the parser slow or large: entities, deep nesting, very many elements."""
    if found := _DECLARATION.search(text):
        raise InputError(
            f"the file declares {found[0].lstrip('<! ').upper()}, which GPX does not need and could do harm: delete it"
        )
    depth = 0
    for number, tag in enumerate(_TAG.finditer(text)):
        depth += -1 if tag[1] else 0 if tag[2] else 1
        if depth > MAX_DEPTH or number > MAX_TAGS:
            raise InputError(
                f"more than {MAX_DEPTH} elements in one another or {MAX_TAGS} in all, expected a GPX track"
            )


def _segments(text: str) -> list[list[Any]]:
    """Points of each segment as gpxpy has them."""
    import gpxpy

    try:
        file = gpxpy.parse(text)
        return [segment.points for track in file.tracks for segment in track.segments]
    except (gpxpy.gpx.GPXException, ParseError, ValueError, TypeError, KeyError, OverflowError) as error:
        why = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        raise InputError(f"no sound GPX ({why}), expected XML of tracks: another kind of file, or truncated?") from None


def _numbers(points: list[Any]) -> Any:
    rows: Iterator[tuple[float, ...]] = (
        (_seconds(point.time), point.latitude, point.longitude, np.nan if point.elevation is None else point.elevation)
        for point in points
    )
    try:
        values = np.array(list(rows), float)
    except (TypeError, ValueError):
        raise InputError("a point has no latitude or longitude, expected both") from None
    if not np.isfinite(values[:, 1:3]).all():
        raise InputError("a latitude or longitude is no finite number, expected degrees")
    return values


def _seconds(moment: datetime | None) -> float:
    """Seconds since 1970-01-01 UTC; a moment without zone counts as UTC."""
    if moment is None:
        return float("nan")
    return (moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)).timestamp()
