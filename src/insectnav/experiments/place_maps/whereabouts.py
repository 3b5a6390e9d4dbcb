"""When and where frames were taken, from the files that say so."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import date
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_choice, check_range, counted, quoted
from insectnav.datasets.frame_times import times_of_frames
from insectnav.datasets.positions import MAX_GAP_S, Positions, is_gps, positions_of_frames, read_positions
from insectnav.datasets.ros_bag import CLOCKS, STAMP
from insectnav.experiments.place_maps.frames import NOWHERE, Frame, FrameSource, is_bag

Reals = NDArray[np.floating[Any]]
Names = Sequence[str | PathLike[str]]
Origin = tuple[float, float] | None


@dataclass(frozen=True, kw_only=True)
class Whereabouts:
    """Where times and positions come from.

    Parameters
    ----------
    times : "names", "exif", frames per second, or a file: see `insectnav.datasets.frame_times.times_of_frames`
    positions : a file, see `insectnav.datasets.positions.read_positions`, or the recording of a robot
    columns : of a table of positions without a header
    position_topic : of the positions in the recording of a robot; None for the only one
    clock : of the recording of a robot, "stamp" or "bag": see `insectnav.datasets.ros_bag`; None for "stamp"
    first_day : date of the log of a receiver that tells times of day alone, as 2014-05-06 [UTC]
    time_offset_s : added to the times of the frames [s]
    utc_offset_h : of clocks without time zone [h]
    max_gap_s : between two positions that is bridged [s]

    Raises
    ------
    InputError
        If the offset is no time, the first day no date, or the clock unknown.
    """

    times: str | None = None
    positions: str | None = None
    columns: tuple[str, ...] | None = None
    position_topic: str | None = None
    clock: str | None = None
    first_day: str | None = None
    time_offset_s: float = 0.0
    utc_offset_h: float = 0.0
    max_gap_s: float = MAX_GAP_S

    def __post_init__(self) -> None:
        check_range("time-offset", self.time_offset_s, -1e11, 1e11, "s")
        if self.clock is not None:
            check_choice("clock", self.clock, CLOCKS)
        if self.first_day is not None:
            _date(self.first_day)


def _date(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise InputError(f"--first-day is {quoted(text)}, expected a date as 2014-05-06") from None


class Placed(NamedTuple):
    """Frames with times and positions, the latitude and longitude of the origin, and what a person must know.

    Of a recording some notes come with its last frame.
    """

    source: FrameSource
    origin_deg: Origin
    notes: Sequence[str]


def placed(source: FrameSource, where: Whereabouts, origin_deg: Origin = None) -> Placed:
    """The same frames, with times and positions.

    Parameters
    ----------
    source : FrameSource
    where : Whereabouts
    origin_deg : of the map, for latitudes and longitudes; None for the first of these

    Raises
    ------
    InputError
        If a file cannot be read, or has nothing to say on these frames.
    """
    if where.clock is not None and source.kind != "bag":
        check_clock_of_positions(where)
    table = position_table(where, origin_deg)
    if source.kind == "bag":
        _check_recording(where, table)
        return _by_own_times(source, where, table)
    if where.time_offset_s and where.times is None and not source.has_times:
        raise InputError("--time-offset is given without --times, expected to know when the frames were taken")
    if where.times is None and table is None and not source.has_times:
        return Placed(source, None, ())
    is_own = source.has_times and where.times is None and (table is None or table.time is not None)
    if source.kind == "films" or not (source.total or is_own):
        raise InputError("--times and --positions want one film alone, or pictures alone, whose number is known")
    numbers = np.arange(source.total) * source.step
    times = _times(source, where, numbers)
    if is_own:
        if table is not None and source.total:  # other clocks are refused at once, by times at an even rate
            positions_of_frames(table, times=times, max_gap_s=where.max_gap_s)
        return _by_own_times(source, where, table)
    return _by_given_times(source, where, table, times, numbers)


def _by_given_times(
    source: FrameSource, where: Whereabouts, table: Positions | None, times: Reals | None, numbers: NDArray[np.int64]
) -> Placed:
    """Frames whose times, names or numbers are all known before one is read."""
    if times is not None:
        _check_forwards(times, source)
    places = None if table is None else _positions(source, where, table, times, numbers)
    is_own = source.has_times and where.times is None

    def frames() -> Iterator[Frame]:
        for k, frame in enumerate(source.frames):
            is_counted = k < source.total  # a film may hold more frames than it says
            time = float(times[k]) if times is not None and is_counted else float("nan")
            position = places[k] if places is not None and is_counted else NOWHERE
            yield replace(frame, time=frame.time + where.time_offset_s if is_own else time, position=position)

    if table is None or places is None:
        return Placed(replace(source, frames=frames()), None, ())
    return Placed(replace(source, frames=frames()), table.origin_deg, (*table.notes, *_remarks(places, where)))


def check_clock_of_positions(where: Whereabouts) -> None:
    """Refuse a choice of clocks where neither frames nor positions come from the recording of a robot.

    Parameters
    ----------
    where : Whereabouts
    """
    if where.clock is not None and (where.positions is None or not is_bag(Path(where.positions))):
        raise InputError("--clock is given, expected it with the recording of a robot alone")


def _remarks(places: Reals, where: Whereabouts) -> tuple[str, ...]:
    """What is to be said of the positions that were found."""
    if np.isfinite(places[:, :2]).all(axis=1).any():
        return ()
    return (f"no frame has a position, since {quoted(where.positions, 200)} has none of x and y for them",)


def position_table(where: Whereabouts, origin_deg: Origin) -> Positions | None:
    """Positions of a file, or of the recording of a robot; None if none are given.

    Parameters
    ----------
    where : Whereabouts
    origin_deg : of the map, for latitudes and longitudes; None for the first of these

    Raises
    ------
    InputError
        If they cannot be read, or are not of the kind that an option is for.
    """
    if where.positions is None:
        for option, value in (("--position-columns", where.columns), ("--position-topic", where.position_topic)):
            if value is not None:
                raise InputError(f"{option} is given without --positions, expected both")
        return None
    path = Path(where.positions)
    if is_gps(path) and not is_bag(path):
        return _dated_positions(path, where, origin_deg)
    if where.first_day is not None:
        raise InputError(f"--first-day is given with {quoted(path, 200)}, expected it with the log of a receiver alone")
    if where.columns is not None and is_bag(path):
        raise InputError(_no_table(path))
    if is_bag(path):
        from insectnav.datasets.ros_bag import bag_positions

        return bag_positions(path, where.position_topic, clock=where.clock or STAMP, origin_deg=origin_deg)
    if where.position_topic is not None:
        raise InputError(_no_recording())
    return read_positions(path, columns=where.columns, origin_deg=origin_deg)


def _dated_positions(path: Path, where: Whereabouts, origin_deg: Origin) -> Positions:
    """Positions of a GPX file or the log of a receiver, with the date that it lacks."""
    if where.columns is not None:
        raise InputError(_no_table(path))
    if where.position_topic is not None:
        raise InputError(_no_recording())
    table = read_positions(path, origin_deg=origin_deg)
    if table.time is not None and np.isfinite(table.time).any():
        if where.first_day is not None:
            raise InputError(f"--first-day is given with {quoted(path, 200)}, which tells its dates, expected none")
        return table
    if where.first_day is not None:
        table = read_positions(path, origin_deg=origin_deg, first_day=_date(where.first_day))
    if table.time is None or not np.isfinite(table.time).any():
        raise InputError(
            f"{quoted(path, 200)} tells of no position when it was, expected times: a log of times of day alone, for "
            "which --first-day gives the date, or a track that was saved without times?"
        )
    return table


def _no_table(path: Path) -> str:
    return f"--position-columns is given with {quoted(path, 200)}, which is no table, expected one"


def _no_recording() -> str:
    return "--position-topic is given, expected it with positions in the recording of a robot alone"


def _times(source: FrameSource, where: Whereabouts, numbers: NDArray[np.int64]) -> Reals | None:
    """Times of all frames (frame,) [s]; None if there are none."""
    if where.times is None:
        return numbers / source.frame_rate + where.time_offset_s if np.isfinite(source.frame_rate) else None
    try:
        given: str | float = float(where.times)
    except ValueError:
        given = where.times
    return times_of_frames(
        given,
        names=source.files or None,
        numbers=numbers.tolist(),
        offset_s=where.time_offset_s,
        utc_offset_h=where.utc_offset_h,
    )


def _check_forwards(times: Reals, source: FrameSource) -> None:
    """Refuse frames that are not in the order in which they were taken."""
    known = np.flatnonzero(np.isfinite(times))
    back = np.flatnonzero(np.diff(times[known]) < 0)
    if back.size:
        before, after = (int(known[back[0] + k]) for k in (0, 1))
        first, second = (quoted(source.files[k].stem if source.files else f"frame {k}") for k in (before, after))
        raise InputError(
            f"{second} was taken {times[before] - times[after]:.3g} s before {first}, which comes ahead of it, "
            "expected frames in the order of their times: names that do not follow the time, or the times of another "
            "recording?"
        )


def _positions(
    source: FrameSource, where: Whereabouts, table: Positions, times: Reals | None, numbers: NDArray[np.int64]
) -> Reals:
    """Positions of all frames (frame, 3) [m]."""
    places = positions_by_key(table, where, source.files or None, times, numbers)
    if places is not None:
        return places
    if table.time is None:
        raise InputError(
            f"{quoted(where.positions, 200)} has names of files, expected times or numbers of frames for those of a "
            "film or an array"
        )
    raise InputError(
        f"{quoted(where.positions, 200)} has times, expected --times to say when the frames were taken: names, exif, "
        "frames per second, or a table"
    )


def positions_by_key(
    table: Positions, where: Whereabouts, names: Names | None, times: Reals | None, numbers: NDArray[np.int64] | None
) -> Reals | None:
    """Positions (frame, 3) [m]: by name where the table has names, else by time, else by number; None if it has none.

    Parameters
    ----------
    table : Positions
    where : Whereabouts
    names, times, numbers : of the frames; None if unknown

    Raises
    ------
    InputError
        If no frame is in the table, or a gap is given to positions that are not found by time.
    """
    if table.name is not None and names is not None:
        _check_no_gap(where, "names")
        return positions_of_frames(table, names=names)
    if table.time is not None and times is not None:
        return positions_of_frames(table, times=times, max_gap_s=where.max_gap_s)
    if table.frame is not None and numbers is not None:
        _check_no_gap(where, "numbers")
        return positions_of_frames(table, frames=numbers)
    return None


def _check_no_gap(where: Whereabouts, key: str) -> None:
    """Refuse a longest gap where nothing is interpolated."""
    if where.max_gap_s != MAX_GAP_S:
        raise InputError(
            f"--max-gap is given with {quoted(where.positions, 200)}, which has the {key} of the frames, expected it "
            "with positions between which a time lies"
        )


def _check_recording(where: Whereabouts, table: Positions | None) -> None:
    """Refuse what does not go with a robot's recording, whose frames come with times."""
    if where.times is not None:
        raise InputError("--times is given, expected none with the recording of a robot, which has its own")
    if table is not None and table.time is None:
        raise InputError(f"{quoted(where.positions, 200)} has no times, expected some for the recording of a robot")


def _by_own_times(source: FrameSource, where: Whereabouts, table: Positions | None) -> Placed:
    """Frames of a recording or a film, which tell their times as they are read."""
    times: list[float] = []
    notes = list(table.notes) if table is not None else []

    def frames() -> Iterator[Frame]:
        is_placed = False
        for frame in source.frames:
            times.append(frame.time + where.time_offset_s)
            place = NOWHERE
            if table is not None:
                # Before the first or after the last position one frame tells nothing of the clocks.
                with suppress(InputError):
                    place = positions_of_frames(table, times=np.array(times[-1:]), max_gap_s=where.max_gap_s)[0]
            is_placed |= bool(np.isfinite(place[:2]).all())
            yield replace(frame, time=times[-1], position=place)
        notes.extend(_remarks_on_recording(np.array(times), table, is_placed, where))

    return Placed(replace(source, frames=frames()), None if table is None else table.origin_deg, notes)


def _remarks_on_recording(times: Reals, table: Positions | None, is_placed: bool, where: Whereabouts) -> Iterator[str]:
    """What is to be said of the frames of a recording when all have come."""
    n_back = int((np.diff(times[np.isfinite(times)]) < 0).sum())
    if n_back:
        some = counted(n_back, "frame was taken before the one", "frames were taken before those")
        yield f"{some} ahead in the recording: frames come in the order in which they arrived"
    if table is not None and not is_placed:
        try:
            positions_of_frames(table, times=times, max_gap_s=where.max_gap_s)
        except InputError as error:
            yield f"no frame has a position: {error}"
        else:
            yield from _remarks(np.full((1, 3), np.nan), where)
