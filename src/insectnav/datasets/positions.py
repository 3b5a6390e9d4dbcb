"""Where frames were taken: positions from tables and from satellite receivers, and which of them belong to a frame."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_range, check_shape, quoted
from insectnav.datasets.clocks import check_common_clock, rounding_of
from insectnav.datasets.frame_times import frame_name
from insectnav.datasets.gps import SNIFFED, gps_kind, local_plane, read_gps
from insectnav.datasets.gps_track import GpsTrack, check_degrees
from insectnav.datasets.table_columns import LENGTHS, find_columns, likely_slip, listed
from insectnav.datasets.text_tables import open_table, read_columns
from insectnav.datasets.time_columns import FRAMES, NAMES, TIMES, whole_numbers
from insectnav.records import read_only

MAX_GAP_S = 3.0  # [s] ours: a receiver gives a fix a second, and at a walk 3 s are 4 m
MAX_LENGTH = 1e7  # [m] of a position from its origin

_DEGREES = ("", "_deg")
COLUMNS: Mapping[str, Mapping[str, float]] = {
    **{axis: {f"{axis}{ending}": factor for ending, factor in LENGTHS.items()} for axis in "xyz"},
    "latitude": {f"{name}{ending}": 1.0 for name in ("latitude", "lat") for ending in _DEGREES},
    "longitude": {f"{name}{ending}": 1.0 for name in ("longitude", "lon", "lng", "long") for ending in _DEGREES},
    "height": {f"{name}_m": 1.0 for name in ("height", "altitude", "alt", "elevation", "ele")},
    "time": TIMES,
    "frame": FRAMES,
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Positions:
    """Where something was: at times, at numbered frames, or at named ones; arrays are read-only copies.

    Parameters
    ----------
    position : (n, 3) array of x, y, z [m], east, north and up where `origin_deg` is known; NaN where not known
    time : (n,) array [s], NaN where not known; None if there are no times
    frame : (n,) array of int; None if frames have no numbers
    name : of frames, without folder and ending; None if they have no names
    origin_deg : latitude and longitude of (0, 0); None if not known
    segment : (n,) array of int; nothing is known of the way from one segment to the next. None if there is but one
    notes : what the user must be told

    Raises
    ------
    InputError
        If shapes do not agree, or there is neither time, frame nor name.
    """

    position: Floats
    time: Floats | None = None
    frame: npt.NDArray[np.int64] | None = None
    name: tuple[str, ...] | None = None
    origin_deg: tuple[float, float] | None = None
    segment: npt.NDArray[np.int64] | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        position = as_numbers("position", self.position)
        check_shape("position", position, ("n", 3))
        check_range("position", position[np.isfinite(position)], -MAX_LENGTH, MAX_LENGTH, "m", "another unit?")
        if self.time is None and self.frame is None and self.name is None:
            raise InputError(
                "positions have neither times, numbers of frames nor names of frames, expected one of these"
            )
        object.__setattr__(self, "position", read_only(position, float))
        for key, dtype in {"time": float, "frame": np.int64, "segment": np.int64}.items():
            if (values := getattr(self, key)) is not None:
                array = as_numbers(key, values)
                check_shape(key, array, (len(position),))
                object.__setattr__(self, key, read_only(array, dtype))
        if self.name is not None and len(self.name) != len(position):
            raise InputError(f"there are {len(self.name)} names, expected {len(position)}, one for each position")

    @property
    def is_known(self) -> npt.NDArray[np.bool_]:
        """Whether x and y are known, (n,); heights may lack."""
        return np.asarray(np.isfinite(self.position[:, :2]).all(axis=-1))

    @cached_property
    def in_time(self) -> tuple[Floats, Floats, npt.NDArray[np.int64]]:
        """What is known in order of time: (n,) times, (n, 3) positions and (n,) segments; of several at one time one.

        Found once, since the frames of a recording ask one by one.
        """
        time = np.full(len(self.position), np.nan) if self.time is None else self.time
        segment = np.zeros(len(time), np.int64) if self.segment is None else self.segment
        usable = np.flatnonzero(self.is_known & np.isfinite(time))
        usable = usable[np.argsort(time[usable], kind="stable")]
        usable = usable[np.diff(time[usable], prepend=-np.inf) > 0]
        return time[usable], self.position[usable], segment[usable]


def read_positions(
    path: str | PathLike[str],
    *,
    columns: Sequence[str] | None = None,
    origin_deg: tuple[float, float] | None = None,
    first_day: date | None = None,
) -> Positions:
    """Positions in a table, a GPX file or the log of a receiver (NMEA 0183).

    The header of a table names x and y (``x_m``, ``x_cm``, ``x_mm``) and perhaps z, or ``latitude`` and ``longitude``
    in degrees and perhaps ``height_m``; and a time (``time_s``, ``time_ms``, ``t_s``, ``timestamp_ns``), the number of
    a ``frame``, or the name of its ``file``. A unit may also stand in brackets, ``x [cm]``. Other columns are ignored.

    Parameters
    ----------
    path : a file; what it holds decides, not its ending
    columns : names of the columns of a table without a header
    origin_deg : latitude and longitude of (0, 0), for latitudes and longitudes; None takes the first. What is to be
        compared needs one origin
    first_day : date of the first fix [UTC], for logs of a receiver that lack it

    Raises
    ------
    InputError
        One sentence that names the file, the row of a table as a spreadsheet shows it, and the likely slip.
    """
    path = Path(path)
    if is_gps(path):
        return gps_positions(read_gps(path, first_day=first_day), origin_deg)
    try:
        return _table_positions(path, columns, origin_deg)
    except InputError as error:
        raise InputError(f"{quoted(path, limit=200)}: {error}") from None


def gps_positions(track: GpsTrack, origin_deg: tuple[float, float] | None = None) -> Positions:
    """Positions of a track in the local plane; z is the height, or 0 throughout where the track has none.

    Parameters
    ----------
    track : of `read_gps`
    origin_deg : latitude and longitude of (0, 0); None takes the first fix

    Raises
    ------
    InputError
        If a fix is beyond the reach of the plane.
    """
    height = track.height if np.isfinite(track.height).any() else None
    position, origin = local_plane(track.latitude_deg, track.longitude_deg, height, origin_deg)
    return Positions(position=position, time=track.time, segment=track.segment, origin_deg=origin, notes=track.notes)


def positions_of_frames(
    positions: Positions,
    *,
    names: Sequence[str | PathLike[str]] | None = None,
    times: ArrayLike | None = None,
    frames: ArrayLike | None = None,
    max_gap_s: float = MAX_GAP_S,
) -> Floats:
    """Positions (frame, 3) [m] of frames by their names, times or numbers, NaN where they are not known.

    Times are interpolated linearly between the two positions around them, if these are at most `max_gap_s` apart and of
    one segment; there is no guess before the first and after the last. Names and numbers must be in the table.

    Parameters
    ----------
    positions : of `read_positions` and the like
    names : of files; folders and endings do not matter
    times : (frame,) array [s] on the clock of the positions, see `frame_times`; NaN where not known
    frames : (frame,) array of whole numbers
    max_gap_s : longest time between two positions that is interpolated [s]

    Raises
    ------
    InputError
        If not just one of names, times and frames is given, the positions lack it, or none of the frames is found.
    """
    given = [key for key, value in {"names": names, "times": times, "frames": frames}.items() if value is not None]
    if len(given) != 1:
        raise InputError(f"{' and '.join(given) or 'nothing'} given, expected one of names, times and frames")
    if times is not None:
        return _at_times(positions, as_numbers("times of the frames", times).astype(float), max_gap_s)
    if names is not None:
        if positions.name is None:
            raise InputError("the positions have no names of frames, expected a column file: match by time or number?")
        return _looked_up(positions, [frame_name(name) for name in names], positions.name, "name")
    if positions.frame is None:
        raise InputError("the positions have no numbers of frames, expected a column frame: match by time or name?")
    wanted = whole_numbers("frames", as_numbers("frames", frames if frames is not None else ()))
    return _looked_up(positions, wanted.tolist(), positions.frame.tolist(), "number")


def _at_times(positions: Positions, times: Floats, max_gap_s: float) -> Floats:
    check_shape("times of the frames", times, ("frame",))
    check_range("longest gap", max_gap_s, 0.0, np.inf, "s")
    if positions.time is None:
        raise InputError("the positions have no times, expected some: match by name or number of frames?")
    known, place, segment = positions.in_time
    if not known.size:
        raise InputError("no position is known at a known time, expected some")
    check_common_clock("the frames", times, "the positions", known[[0, -1]], max_gap_s)
    after = np.searchsorted(known, times).clip(0, len(known) - 1)  # the first that is not earlier
    before = np.where(known[after] == times, after, np.maximum(after - 1, 0))
    span = known[after] - known[before]
    share = np.divide(times - known[before], span, out=np.zeros_like(times), where=span > 0)
    found = (1 - share)[:, None] * place[before] + share[:, None] * place[after]
    is_exact = known[after] == times
    is_between = (known[before] <= times) & (times <= known[after])
    is_near = span <= max_gap_s + rounding_of(known[[0, -1]])
    is_found = is_exact | (is_between & is_near & (segment[before] == segment[after]))
    if not is_found.any():
        usual = float(np.median(np.diff(known))) if len(known) > 1 else 0.0
        slip = "milliseconds taken as seconds, or raise the longest gap?" if usual > max_gap_s else "another recording?"
        raise InputError(
            f"no frame lies between two positions at most {max_gap_s:g} s apart, which mostly are {usual:.3g} s apart, "
            f"expected some: {slip}"
        )
    return np.where(is_found[:, None], found, np.nan)


def _looked_up(positions: Positions, wanted: Sequence[Any], known: Sequence[Any], word: str) -> Floats:
    """Rows of the positions by a key, NaN where there is none."""
    row_of: dict[Any, int] = {}
    for row, key in enumerate(known):
        if row_of.setdefault(key, row) != row and not np.array_equal(
            positions.position[row], positions.position[row_of[key]], equal_nan=True
        ):
            raise InputError(f"the {word} {quoted(key)} has two positions, expected one: two recordings in one table?")
    rows = np.array([row_of.get(key, -1) for key in wanted], int)
    if len(rows) and (rows < 0).all():
        raise InputError(
            f"no frame has a {word} of the positions, such as {quoted(wanted[0])} here and {quoted(known[0])} there, "
            f"expected the same {word}s: the table of another recording?"
        )
    return np.where((rows >= 0)[:, None], positions.position[rows], np.nan)


def is_gps(path: Path) -> bool:
    """Whether a file is GPX or NMEA by its beginning; what cannot be read is left to the reader of tables to refuse."""
    try:
        with path.open("rb") as file:
            return gps_kind(file.read(SNIFFED)) is not None
    except OSError:
        return False


def _table_positions(path: Path, columns: Sequence[str] | None, origin_deg: tuple[float, float] | None) -> Positions:
    table = open_table(path, columns)
    chosen = find_columns(table.header, COLUMNS)
    named = find_columns(table.header, {"name": NAMES})
    _check_columns(table.header, {*chosen, *named})
    if "x" in chosen and "y" in chosen and chosen["x"][1] != chosen["y"][1]:
        raise InputError("x and y differ in unit, expected the same unit")
    rows, values, texts = read_columns(table, [index for index, _ in chosen.values()], [i for i, _ in named.values()])
    given = {meaning: column * factor for (meaning, (_, factor)), column in zip(chosen.items(), values.T, strict=True)}
    time, frame = given.get("time"), given.get("frame")
    for word in given.keys() & {"time", "frame"}:
        if (absent := np.flatnonzero(np.isnan(given[word]))).size:
            raise InputError(f"row {rows[absent[0]]}: the {word} is missing, expected one in every row")
    if time is not None and (back := np.flatnonzero(np.diff(time) < 0)).size:
        raise InputError(
            f"row {rows[back[0] + 1]}: the time goes back: rows out of order, or two recordings in one file?"
        )
    position, origin, notes = _places(given, origin_deg)
    return Positions(
        position=position,
        time=time,
        frame=None if frame is None else whole_numbers("frame", frame),
        name=tuple(map(frame_name, texts[0])) if texts else None,
        origin_deg=origin,
        notes=notes,
    )


def _places(
    given: Mapping[str, Floats], origin_deg: tuple[float, float] | None
) -> tuple[Floats, tuple[float, float] | None, tuple[str, ...]]:
    """Positions (n, 3), their origin and what is to be said, of the columns that there are."""
    if "x" in given:
        notes = ("latitude and longitude are ignored, since there are x and y",) if "latitude" in given else ()
        return np.column_stack([given["x"], given["y"], given.get("z", np.zeros(len(given["x"])))]), None, notes
    latitude, longitude = given["latitude"], given["longitude"]
    known = np.isfinite(latitude) & np.isfinite(longitude)
    check_degrees(latitude[known], longitude[known])
    position, origin = local_plane(latitude, longitude, given.get("height", given.get("z")), origin_deg)
    return position, origin, ()


def _check_columns(header: list[str], found: set[str]) -> None:
    is_placed = {"x", "y"} <= found or {"latitude", "longitude"} <= found
    if not is_placed:
        raise InputError(
            f"no columns of a position among {listed(header)}, expected x_m and y_m (or cm, mm), or latitude and "
            f"longitude{likely_slip(header, ('x', 'y'))}"
        )
    if not found & {"time", "frame", "name"}:
        raise InputError(
            f"no column of a time or a frame among {listed(header)}, expected time_s (or ms, ns), frame or file"
            f"{likely_slip(header, ('time', 't', 'timestamp'))}"
        )
