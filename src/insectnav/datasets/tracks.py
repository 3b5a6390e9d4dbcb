"""Recorded tracks of animals, read from tables of text."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
import numpy.typing as npt

from insectnav.angles import FULL_TURN, Floats, from_math
from insectnav.checks import (
    InputError,
    check_choice,
    check_count,
    check_radians,
    check_range,
    quoted,
)
from insectnav.datasets.table_columns import likely_slip, listed
from insectnav.datasets.text_tables import open_table, read_numbers
from insectnav.datasets.track_gaps import GapLimits, Samples, fill_gaps
from insectnav.records import Track

MIN_SAMPLES = 10
MIN_EXTENT = 1e-9  # of the largest coordinate

TIME_COLUMNS = {"t_s": "s", "time_s": "s", "time": "s", "frame": "frame"}
LENGTH_UNITS = {"_m": "m", "_cm": "cm", "_mm": "mm", "": "unit"}
X_COLUMNS = {f"x{ending}": unit for ending, unit in LENGTH_UNITS.items()}
Y_COLUMNS = {f"y{ending}": unit for ending, unit in LENGTH_UNITS.items()}
HEADING_COLUMNS = {"heading_rad": "rad", "heading_deg": "deg"}
HEADING_CONVENTIONS = ("compass", "math")


@dataclass(frozen=True, kw_only=True)
class ReadingParams:
    """How a track is read; see `read_track`.

    Raises
    ------
    InputError
        If the convention is unknown or a limit is negative.
    """

    heading_convention: str = "compass"
    max_gap_s: float = 1.0  # [s] ours
    max_gap_samples: int = 20  # ours

    def __post_init__(self) -> None:
        check_choice("heading convention", self.heading_convention, HEADING_CONVENTIONS)
        check_range("longest gap to fill", self.max_gap_s, 0, np.inf, "s")
        check_count("longest gap to fill in samples", self.max_gap_samples, minimum=0)


def read_track(
    path: str | PathLike[str],
    *,
    heading_convention: str = "compass",
    max_gap_s: float = 1.0,
    max_gap_samples: int = 20,
) -> Track:
    """Track in a CSV or TSV file.

    The header names a time (``t_s``, ``time_s``, ``time``, ``frame``), x and y (``x_m``, ``x_cm``, ``x_mm``,
    ``x``) and perhaps a heading (``heading_rad``, ``heading_deg``); other columns are ignored. An
    empty cell, ``nan`` and ``NA`` are missing. Short gaps are filled by interpolation.

    Parameters
    ----------
    path : file of text in UTF-8, separated by tab, comma or semicolon
    heading_convention : "compass" for headings clockwise from +y, "math" for anticlockwise from +x
    max_gap_s : longest time between two complete samples that is filled [s]; ignored for frames
    max_gap_samples : the same in median intervals; a gap has to pass both limits

    Raises
    ------
    InputError
        One sentence that names the file, the row as a spreadsheet shows it, and the likely slip.
    """
    params = ReadingParams(heading_convention=heading_convention, max_gap_s=max_gap_s, max_gap_samples=max_gap_samples)
    limits = GapLimits(max_gap_s=max_gap_s, max_gap_samples=min(max_gap_samples, 10**9))
    path = Path(path)
    try:
        return _read(path, params.heading_convention, limits)
    except InputError as error:
        raise InputError(f"{quoted(path, limit=200)}: {error}") from None


def _read(path: Path, convention: str, limits: GapLimits) -> Track:
    table = open_table(path)
    columns = _choose_columns(table.header)
    rows, values = read_numbers(table, columns.indices)
    time, position = values[:, 0], values[:, 1:3]
    _check_time(time, rows, columns)
    heading: Floats | None = values[:, 3] if columns.heading else None
    notes = _notes(columns, heading, convention)
    if columns.heading and heading is not None:
        heading = _to_compass(heading, columns.heading, convention)
    samples = Samples(row=rows, time=time, position=position, heading=heading, time_unit=columns.time.unit)
    _check_enough(samples)
    filled = fill_gaps(samples, limits)
    if filled.n_cut:
        notes.append(f"incomplete samples at the ends of the track were cut off: {filled.n_cut}")
    return Track(
        time=filled.time,
        position=filled.position,
        heading=filled.heading,
        length_unit=columns.x.unit,
        time_unit=columns.time.unit,
        name="".join(letter if letter.isprintable() else "?" for letter in path.stem),
        n_interpolated=filled.n_filled + filled.n_cut,
        notes=tuple(notes),
    )


@dataclass(frozen=True)
class _Column:
    index: int
    name: str  # in lower case
    label: str  # as written, safe inside a sentence
    unit: str


@dataclass(frozen=True)
class _Columns:
    time: _Column
    x: _Column
    y: _Column
    heading: _Column | None

    @property
    def indices(self) -> list[int]:
        chosen = (self.time, self.x, self.y, self.heading)
        return [column.index for column in chosen if column]


def _choose_columns(header: list[str]) -> _Columns:
    times = (_find(header, {name: unit}) for name, unit in TIME_COLUMNS.items())
    found = {
        "time": next(filter(None, times), []),
        "x": _find(header, X_COLUMNS),
        "y": _find(header, Y_COLUMNS),
    }
    absent = [meaning for meaning, columns in found.items() if not columns]
    if absent:
        raise InputError(
            f"no column for {' and '.join(absent)} among {listed(header)}, expected a time (t_s, time_s, time or "
            f"frame), x and y (x_m, x_cm, x_mm or x, and y alike){likely_slip(header)}"
        )
    time, x, y = (_only(meaning, columns) for meaning, columns in found.items())
    if x.unit != y.unit:
        raise InputError(f"x and y differ in unit (columns {x.label} and {y.label}), expected the same unit")
    heading = _find(header, HEADING_COLUMNS)
    return _Columns(time, x, y, _only("heading", heading) if heading else None)


def _find(header: list[str], names: dict[str, str]) -> list[_Column]:
    plain = [name.strip().lower() for name in header]
    return [
        _Column(index, name, quoted(header[index].strip()), names[name])
        for index, name in enumerate(plain)
        if name in names
    ]


def _only(meaning: str, found: list[_Column]) -> _Column:
    if len(found) > 1:
        labels = " and ".join(column.label for column in found[:2])
        raise InputError(f"both {labels} could be the {meaning} column, expected one: delete the other")
    return found[0]


def _check_time(time: Floats, rows: npt.NDArray[np.int64], columns: _Columns) -> None:
    absent = np.flatnonzero(np.isnan(time))
    if absent.size:
        row, label = rows[absent[0]], columns.time.label
        raise InputError(f"row {row}, column {label}: the time is missing, expected one in every row")
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        before, after = time[back[0]], time[back[0] + 1]
        slip = "a row twice?" if before == after else "rows out of order, or two tracks in one file?"
        raise InputError(
            f"row {rows[back[0] + 1]}, column {columns.time.label}: the time goes from {before:.10g} "
            f"to {after:.10g}, expected it to increase: {slip}"
        )


def _notes(columns: _Columns, heading: Floats | None, convention: str) -> list[str]:
    notes = []
    if columns.time.name == "time":
        notes.append(f"column {columns.time.label} is taken as seconds")
    if columns.x.unit == "unit":
        notes.append(f"columns {columns.x.label} and {columns.y.label} name no unit of length")
    if heading is None:
        if convention != "compass":
            notes.append(f"the heading convention {convention} has no effect: there is no heading column")
    elif columns.heading and columns.heading.unit == "deg":
        known = heading[~np.isnan(heading)]
        if known.size and np.ptp(known) > 0 and np.abs(known).max() <= FULL_TURN:
            notes.append(f"column {columns.heading.label} stays within ±2π degrees: is it in radians?")
    return notes


def _to_compass(heading: Floats, column: _Column, convention: str) -> Floats:
    """Heading [rad] clockwise from +y, of a column in its own unit and convention."""
    name = f"column {column.label}"
    if column.unit == "deg":
        known = heading[~np.isnan(heading)]
        check_range(name, known, -720, 720, "degrees", "another unit, or unwrapped over many turns?")
        heading = np.deg2rad(heading)
    else:
        check_radians(name, heading)
    return from_math(heading) if convention == "math" else heading


def _check_enough(samples: Samples) -> None:
    complete = samples.is_complete
    n_complete, n_rows = int(complete.sum()), samples.time.size
    if n_complete < MIN_SAMPLES:
        wanted = "a position" if samples.heading is None else "a position and a heading"
        raise InputError(f"{n_complete} of {n_rows} rows hold {wanted}, expected at least {MIN_SAMPLES} points")
    position = samples.position[complete]
    if np.ptp(position, axis=0).max() <= MIN_EXTENT * np.abs(position).max():
        x, y = position[0]
        raise InputError(
            f"the animal does not move: all positions are at ({x:g}, {y:g}), expected a track: the wrong columns?"
        )
