"""Tracks of a GPX file, read as a stream: no tree is built that a file could make deep or large."""

from dataclasses import dataclass, field
from datetime import UTC, datetime
from xml.parsers import expat

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.datasets.gps_track import MAX_FIXES, GpsTrack

MAX_DEPTH = 50  # of elements in one another; GPX needs six
MAX_LETTERS = 100  # of a height or a time
POINT = ["gpx", "trk", "trkseg", "trkpt"]  # where a point of a track is


def parse_gpx(data: bytes) -> GpsTrack:
    """All tracks of a GPX file (1.0 or 1.1) in order of their times; each segment of each track is one of the result.

    Parameters
    ----------
    data : XML; times without a zone are taken as UTC, in which GPX has them

    Raises
    ------
    InputError
        If it is no GPX, declares a document type (and so perhaps entities), is nested too deeply, or holds no track.
    """
    reader = _Reader()
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.text
    parser.StartDoctypeDeclHandler = reader.refuse_document_type
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise InputError(f"no sound XML ({error}), expected GPX: truncated, or another kind of file?") from None
    return _track(reader)


@dataclass
class _Reader:
    """What has been read of a stream of elements."""

    path: list[str] = field(default_factory=list)
    segments: list[list[tuple[float, float, float, float]]] = field(default_factory=list)
    others: set[str] = field(default_factory=set)
    has_zone: bool = True
    n_points: int = 0
    _place: tuple[float, float] = (0.0, 0.0)
    _height: float = float("nan")
    _time: float = float("nan")
    _text: str = ""

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self.path.append(name.rpartition(" ")[2])  # without namespace
        if len(self.path) > MAX_DEPTH:
            raise InputError(f"elements are more than {MAX_DEPTH} deep in one another, expected GPX")
        if self.path[0] != "gpx":
            raise InputError(f"the file is {quoted(self.path[0])} in XML, expected gpx: export the track as GPX")
        self._text = ""
        if self.path == POINT[:3]:
            self.segments.append([])
        elif self.path == POINT:
            self._place = _number(attributes, "lat"), _number(attributes, "lon")
            self._height = self._time = float("nan")
            self.n_points += 1
            if self.n_points > MAX_FIXES:
                raise InputError(f"more than {MAX_FIXES} points, expected a single recording")
        elif len(self.path) == 2:
            self.others.add(self.path[1])

    def text(self, letters: str) -> None:
        if len(self._text) < MAX_LETTERS:
            self._text += letters

    def end(self, name: str) -> None:
        if self.path[:-1] == POINT and self.path[-1] == "ele":
            self._height = _number({"ele": self._text}, "ele") if self._text.strip() else float("nan")
        elif self.path[:-1] == POINT and self.path[-1] == "time":
            self._time = self._seconds()
        elif self.path == POINT:
            self.segments[-1].append((self._time, *self._place, self._height))
        self.path.pop()

    def refuse_document_type(self, *declaration: object) -> None:
        name = quoted(declaration[0])
        raise InputError(f"the file declares a document type ({name}), expected none: GPX has no use for it")

    def _seconds(self) -> float:
        """Seconds since 1970-01-01 UTC."""
        if not self._text.strip():
            return float("nan")
        try:
            moment = datetime.fromisoformat(self._text.strip())
            self.has_zone &= moment.tzinfo is not None
            return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
        except (ValueError, OverflowError):
            raise InputError(f"{quoted(self._text)} is no time, expected one like 2014-05-06T12:30:15Z") from None


def _number(attributes: dict[str, str], name: str) -> float:
    text = attributes.get(name, "").strip()
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"a point has {name} {quoted(text)}, expected a number") from None
    if not np.isfinite(value):
        raise InputError(f"a point has {name} {quoted(text)}, expected a finite number")
    return value


def _track(reader: _Reader) -> GpsTrack:
    pieces = [np.array(segment) for segment in reader.segments if segment]
    if not pieces:
        found = ", ".join(sorted(reader.others)[:8]) or "nothing"
        slip = ": a planned route or waypoints, not a recording?" if reader.others & {"rte", "wpt"} else ""
        raise InputError(f"no track with points in the file, which holds {found}, expected trk{slip}")
    if all(np.isfinite(piece[:, 0]).any() for piece in pieces):  # programs write the tracks of a day in any order
        pieces.sort(key=lambda piece: float(np.nanmin(piece[:, 0])))
    time, latitude, longitude, height = np.concatenate(pieces).T
    return GpsTrack(
        time=time,
        latitude_deg=latitude,
        longitude_deg=longitude,
        height=height,
        segment=np.repeat(np.arange(len(pieces)), list(map(len, pieces))),
        notes=() if reader.has_zone else ("times without a zone are taken as UTC",),
    )
