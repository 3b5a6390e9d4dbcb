"""Tables of the poses of a camera, one row for each frame."""

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

import numpy as np

from insectnav.angles import Floats, bearing, wrap
from insectnav.checks import InputError, check_radians, check_range, quoted
from insectnav.datasets.table_columns import LENGTHS, find_columns, likely_slip, listed
from insectnav.datasets.text_tables import open_table, read_numbers
from insectnav.records import Poses

# Names of columns, and how many of the record's unit one of theirs is.
ANGLES = {"_deg": np.pi / 180, "_rad": 1.0}
COLUMNS: Mapping[str, Mapping[str, float]] = {
    "x": {f"x{ending}": factor for ending, factor in LENGTHS.items()},
    "y": {f"y{ending}": factor for ending, factor in LENGTHS.items()},
    "z": {f"z{ending}": factor for ending, factor in LENGTHS.items()},
    "heading": {f"heading{ending}": factor for ending, factor in ANGLES.items()},
    "pitch": {f"pitch{ending}": factor for ending, factor in ANGLES.items()},
    "roll": {f"roll{ending}": factor for ending, factor in ANGLES.items()},
    "time": {"t_s": 1.0, "time_s": 1.0},
    "distance": {"distance_m": 1.0},
}
NEEDED = ("x", "y")
MAX_POSES = 1_000_000
DECIMALS = 6  # of metres and degrees in a table that is written: a micrometre, a millionth of a degree


def read_poses(path: str | PathLike[str], *, speed: float) -> tuple[Poses, bool]:
    """Poses in a CSV or TSV file, and whether it gives their height.

    The header names x and y (``x_m``, ``x_cm``, ``x_mm``) and perhaps ``z_m``, ``heading_deg``, ``pitch_deg``,
    ``roll_deg`` (or ``_rad``), ``time_s`` (or ``t_s``) and ``distance_m``; other columns are ignored.

    Parameters
    ----------
    path : file of text in UTF-8, separated by tab, comma or semicolon
    speed : [m/s], at which the time is counted where the table has none

    Returns
    -------
    poses : Poses
        z is 0 where the table has none; headings that it lacks point to the next position that differs, pitch and roll
        that it lacks are 0, and distances that it lacks are straight from row to row
    has_height : bool

    Raises
    ------
    InputError
        One sentence that names the file, the row as a spreadsheet shows it, and the likely slip.
    """
    check_range("speed", speed, 1e-6, 1e4, "m/s")
    path = Path(path)
    try:
        return _read(path, speed)
    except InputError as error:
        raise InputError(f"{quoted(path, limit=200)}: {error}") from None


def pose_columns(poses: Poses) -> dict[str, Floats]:
    """Columns (n,) of a table of poses by name, rounded to micrometres, microseconds and millionths of a degree."""
    columns = {f"{axis}_m": poses.position[:, index] for index, axis in enumerate("xyz")}
    columns |= {f"{name}_deg": np.rad2deg(getattr(poses, name)) for name in ("heading", "pitch", "roll")}
    columns |= {"distance_m": poses.distance, "time_s": poses.time}
    return {name: np.round(values, DECIMALS) + 0.0 for name, values in columns.items()}


def as_tabled(poses: Poses) -> Poses:
    """The poses that `read_poses` finds in a table of `pose_columns`, to the last bit."""
    columns = pose_columns(poses)
    return Poses(
        position=np.stack([columns[f"{axis}_m"] for axis in "xyz"], axis=-1),
        distance=columns["distance_m"],
        time=columns["time_s"],
        **{name: columns[f"{name}_deg"] * ANGLES["_deg"] for name in ("heading", "pitch", "roll")},
    )


def _read(path: Path, speed: float) -> tuple[Poses, bool]:
    table = open_table(path)
    chosen = _choose_columns(table.header)
    rows, values = read_numbers(table, [index for index, _ in chosen.values()])
    check_range("number of positions", len(rows), 1, MAX_POSES)
    given = {}
    for (meaning, (index, factor)), column in zip(chosen.items(), values.T, strict=True):
        label = quoted(table.header[index].strip())
        absent = np.flatnonzero(np.isnan(column))
        if absent.size:
            raise InputError(f"row {rows[absent[0]]}, column {label}: the {meaning} is missing, expected one")
        if meaning in ("heading", "pitch", "roll"):
            _check_angles(f"column {label}", column, factor)
        elif meaning in ("time", "distance") and (back := np.flatnonzero(np.diff(column) < 0)).size:
            raise InputError(
                f"row {rows[back[0] + 1]}, column {label}: the {meaning} goes back from {column[back[0]]:.10g} to "
                f"{column[back[0] + 1]:.10g}: rows out of order?"
            )
        given[meaning] = column * factor
    return _completed(given, speed), "z" in given


def _completed(given: dict[str, Floats], speed: float) -> Poses:
    """Poses from the columns that there are."""
    x, y = given["x"], given["y"]
    nothing = np.zeros(len(x))
    position = np.column_stack([x, y, given.get("z", nothing)])
    steps = np.diff(position, axis=0)
    walked = np.concatenate([[0.0], np.cumsum(np.sqrt((steps**2).sum(axis=-1)))])
    distance = given.get("distance", walked)
    return Poses(
        position=position,
        heading=wrap(given["heading"]) if "heading" in given else _headings_onwards(position[:, :2]),
        pitch=given.get("pitch", nothing),
        roll=given.get("roll", nothing),
        distance=distance,
        time=given.get("time", (distance - distance[0]) / speed),
    )


def _headings_onwards(position: Floats) -> Floats:
    """Heading (n,) from each position (n, 2) to the next that differs; the last ones keep the heading before them."""
    steps = np.diff(position, axis=0)
    moving = np.flatnonzero((steps != 0).any(axis=-1))
    if not moving.size:
        raise InputError("there is no heading, expected a column heading_deg where the camera does not move")
    following = np.minimum(np.searchsorted(moving, np.arange(len(position))), moving.size - 1)
    return bearing(steps[moving[following]])


def _choose_columns(header: list[str]) -> dict[str, tuple[int, float]]:
    """Index of the column of each meaning, and the factor of its unit."""
    chosen = find_columns(header, COLUMNS)
    absent = [meaning for meaning in NEEDED if meaning not in chosen]
    if absent:
        raise InputError(
            f"no column for {' and '.join(absent)} among {listed(header)}, expected x_m and y_m (or cm, mm)"
            f"{likely_slip(header, absent)}"
        )
    if chosen["x"][1] != chosen["y"][1]:
        raise InputError("x and y differ in unit, expected the same unit")
    return chosen


def _check_angles(name: str, values: Floats, factor: float) -> None:
    if factor == 1.0:
        check_radians(name, values)
    else:
        check_range(name, values, -360.0, 360.0, "degrees", "another unit, or unwrapped over many turns?")
