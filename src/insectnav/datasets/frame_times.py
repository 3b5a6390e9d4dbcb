"""When frames were taken: from a table, from their names, from what the camera wrote, or from their rate."""

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path, PurePath

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_count, check_range, check_shape, quoted
from insectnav.datasets.clocks import WIDEST_ZONE_H, check_common_clock, rounding_of, zone_hours
from insectnav.datasets.exif_times import read_exif_time
from insectnav.datasets.image_folder import PICTURES, RAW, VIDEOS
from insectnav.datasets.table_columns import find_columns, likely_slip, listed
from insectnav.datasets.text_tables import open_table, read_columns
from insectnav.datasets.time_columns import FRAMES, NAMES, TIMES, whole_numbers
from insectnav.datasets.video import video_times

Names = Sequence[str | PathLike[str]]
ENDINGS = (*PICTURES, *RAW, *VIDEOS, ".bmp", ".ppm", ".pgm", ".npy")
# How many digits the whole part of a time since 1970 has in the years 2001 to 2286, and how many seconds its unit is.
UNIX_DIGITS = {13: 1e-3, 16: 1e-6, 19: 1e-9}
MISCOUNTED = 0.01  # of the frames of a film that programs which take them out leave out or repeat; ours
_NUMBER = re.compile(r"[0-9]+(?:\.[0-9]+)?")
_DATE = re.compile(
    r"(?<!\d)((?:19|20)\d\d)([-_:]?)(\d\d)\2(\d\d)[-_T ]?(\d\d)([-_:.]?)(\d\d)\6(\d\d)"
    r"(?:[-_.,]?(\d{1,9})(?![\d:]))?(?P<zone>[zZ](?![a-zA-Z])|[+-](?:0\d|1[0-4]):?(?:00|15|30|45))?(?!\d)",
    re.ASCII,
)


def frame_name(file: str | PathLike[str]) -> str:
    """Name of a frame: that of its file without folder and without the ending of a picture."""
    name = PurePath(str(file).replace("\\", "/")).name
    stem, dot, ending = name.rpartition(".")
    return stem if stem and (dot + ending).lower() in ENDINGS else name


def times_of_frames(
    source: str | PathLike[str] | float,
    *,
    names: Names | None = None,
    numbers: ArrayLike | None = None,
    offset_s: float = 0.0,
    utc_offset_h: float = 0.0,
) -> Floats:
    """Times (frame,) [s] at which frames were taken, NaN where not known.

    Parameters
    ----------
    source : where they come from

        - "names": numbers or dates in the names of the files, see `times_in_names`
        - "exif": what the camera wrote into the files, see `times_by_camera`
        - a number: frames per second; frame k was taken at k over this
        - a video: those at which it shows its frames, by their numbers, NaN for numbers that it does not hold; or
          those of pictures that another program took from it, if they are all of its frames, give or take 1 %
        - another file: a table of ``time_s`` (or ms, us, ns) and ``file`` or ``frame``, see `times_in_table`
    names : files of the frames
    numbers : (frame,) array, whole numbers of the frames; None counts the names from 0
    offset_s : what is added [s]: how far the clock of the positions is ahead of that of the frames
    utc_offset_h : hours by which a clock without time zone, of a date in a name or in a picture, is ahead of UTC

    Raises
    ------
    InputError
        If there are neither names nor numbers, or no frame has a time; one sentence that names the likely slip.
    """
    if names is None and numbers is None:
        raise InputError("neither names nor numbers of frames are given, expected one of them")
    counted: ArrayLike = np.arange(len(names or ())) if numbers is None else numbers
    check_range("offset", offset_s, -1e11, 1e11, "s")
    if isinstance(source, int | float | np.integer | np.floating):
        times = _at_rate(counted, float(source))
    elif source in ("names", "exif"):
        if names is None:
            raise InputError(f"times are to come from {source} but there are no names of frames, expected some")
        reader = times_in_names if source == "names" else times_by_camera
        times = reader(names, utc_offset_h=utc_offset_h)
    elif Path(source).suffix.lower() in VIDEOS:
        times = _of_video(counted, source, names)
    else:
        times = times_in_table(source, names=names, numbers=numbers)
    return times + offset_s


def times_in_table(
    path: str | PathLike[str], *, names: Names | None = None, numbers: ArrayLike | None = None
) -> Floats:
    """Times (frame,) [s] of a CSV or TSV file by name or number of the frames, NaN where they are not in it.

    Parameters
    ----------
    path : its header names ``time_s`` (or ms, us, ns; also "Time [s]"), and ``file`` (``filename``, ``name``) or
        ``frame``
    names : files of the frames; folders and endings do not matter
    numbers : (frame,) array of whole numbers

    Raises
    ------
    InputError
        If a column is missing, a frame is in it twice, or none of the frames is.
    """
    path = Path(path)
    try:
        return _looked_up(path, names, numbers)
    except InputError as error:
        raise InputError(f"{quoted(path, limit=200)}: {error}") from None


def times_in_names(names: Names, *, utc_offset_h: float = 0.0) -> Floats:
    """Times (frame,) [s] in names of files.

    A date with a time to the second at least (20140506_123015, 2014-05-06T12-30-15.250) gives seconds since 1970; a
    zone after it (Z, +02:00, +0200, -05:00) is followed, but four digits after a hyphen alone are a fraction. Otherwise
    the number in the name is taken as seconds, or the one that differs from name to name; numbers of 13, 16 and 19
    digits are milli-, micro- and nanoseconds since 1970.

    Parameters
    ----------
    names : of files
    utc_offset_h : hours by which dates are ahead of UTC that do not say so themselves

    Raises
    ------
    InputError
        If a name has no number or several differ, or the numbers only count the frames from 0 or 1.
    """
    check_range("offset from UTC", utc_offset_h, -WIDEST_ZONE_H, WIDEST_ZONE_H, "h")
    stems = [frame_name(name) for name in names]
    check_count("number of frames", len(stems))
    dates = [_date(stem, utc_offset_h) for stem in stems]
    if all(date is not None for date in dates):
        return np.array(dates, float)
    words = _differing(stems)
    if len({len(word) for word in words}) == 1 and "." not in "".join(words) and len(words[0]) in UNIX_DIGITS:
        return np.array([int(word) for word in words]) * UNIX_DIGITS[len(words[0])]
    times = np.array([float(word) for word in words])
    steps = np.diff(np.sort(times))
    if len(times) > 2 and times.min() in (0.0, 1.0) and (steps == steps[0]).all():
        raise InputError(
            f"the numbers in the names run from {times.min():g} in steps of {steps[0]:g}, expected times: numbers of "
            "frames, to be given times by their rate or a table?"
        )
    return times


def times_by_camera(files: Names, *, utc_offset_h: float = 0.0) -> Floats:
    """Times (frame,) [s] since 1970-01-01 UTC that a camera wrote into its pictures (EXIF), NaN where it did not.

    Parameters
    ----------
    files : JPEG, TIFF or PNG
    utc_offset_h : hours by which the camera's clock is ahead of UTC, for pictures that do not say so themselves

    Raises
    ------
    InputError
        If a file cannot be read, or none says when it was taken.
    """
    check_range("offset from UTC", utc_offset_h, -WIDEST_ZONE_H, WIDEST_ZONE_H, "h")
    check_count("number of frames", len(files))
    times = np.full(len(files), np.nan)
    for index, file in enumerate(files):
        if (found := read_exif_time(file)) is not None:
            zone = utc_offset_h if found.utc_offset_h is None else found.utc_offset_h
            times[index] = found.clock - 3600 * zone
    if np.isnan(times).all():
        raise InputError(
            f"none of {len(files)} pictures, such as {quoted(PurePath(files[0]).name)}, says when it was taken, "
            "expected EXIF with DateTimeOriginal: saved by a program that leaves it out?"
        )
    return times


def nearest_in_time(first: ArrayLike, second: ArrayLike, max_gap_s: float) -> npt.NDArray[np.int64]:
    """Index in `second` of the time nearest to each of `first`, (first,), −1 where none is within `max_gap_s`.

    For two cameras, or a camera and another sensor, that run at different rates. One of `second` may be given several
    times; of two as near it is the earlier.

    Parameters
    ----------
    first, second : (first,) and (second,) arrays [s] in any order, NaN where not known
    max_gap_s : longest time between the two [s]

    Raises
    ------
    InputError
        If the times are not of one clock, see `check_common_clock`.
    """
    asked, known = as_numbers("first", first).astype(float), as_numbers("second", second).astype(float)
    check_shape("first", asked, ("first",))
    check_shape("second", known, ("second",))
    check_range("longest gap", max_gap_s, 0.0, np.inf, "s")
    check_common_clock("the first", asked, "the second", known, max_gap_s)
    order = np.argsort(known, kind="stable")  # what is not known comes last
    order = order[: int(np.isfinite(known).sum())]
    after = np.searchsorted(known[order], asked).clip(0, len(order) - 1)
    before = np.maximum(after - 1, 0)
    is_before = asked - known[order[before]] <= known[order[after]] - asked
    nearest = order[np.where(is_before, before, after)]
    with np.errstate(invalid="ignore"):
        is_near = np.abs(asked - known[nearest]) <= max_gap_s + rounding_of(known)
        return np.where(is_near, nearest, -1)


def _of_video(numbers: ArrayLike, path: str | PathLike[str], names: Names | None) -> Floats:
    counted = _frame_numbers(numbers)
    times, film = video_times(path), quoted(PurePath(path).name, 200)
    is_held = (counted >= 0) & (counted < len(times))
    if not is_held.any():
        raise InputError(
            f"{film} holds {len(times)} frames and none of those numbers, expected some from 0: another film?"
        )
    is_all = names is not None and np.array_equal(counted, np.arange(len(names)))
    if is_all and abs(len(counted) - len(times)) > MISCOUNTED * len(times):
        raise InputError(
            f"{film} holds {len(times)} frames and {len(counted)} pictures are given, expected all of its frames: "
            "pictures of every few of them, to be given times by their rate?"
        )
    return np.where(is_held, times[np.where(is_held, counted, 0)], np.nan)


def _at_rate(numbers: ArrayLike, frames_per_second: float) -> Floats:
    counted = _frame_numbers(numbers)
    check_range("frames per second", frames_per_second, 1e-6, 1e6)
    return counted / frames_per_second


def _frame_numbers(numbers: ArrayLike) -> npt.NDArray[np.int64]:
    counted = whole_numbers("numbers of frames", as_numbers("numbers of frames", numbers))
    check_shape("numbers of frames", counted, ("frame",))
    return counted


def _looked_up(path: Path, names: Names | None, numbers: ArrayLike | None) -> Floats:
    table = open_table(path)
    found = find_columns(table.header, {"time": TIMES, "frame": FRAMES})
    named = find_columns(table.header, {"name": NAMES})
    if "time" not in found:
        slip = likely_slip(table.header, ("time", "t", "timestamp"))
        raise InputError(f"no column of a time among {listed(table.header)}, expected time_s (or ms, us, ns){slip}")
    by_name = bool(named) and names is not None
    if not by_name and ("frame" not in found or numbers is None):
        wanted = "file" if numbers is None else "frame"
        raise InputError(f"no column of a {wanted} among {listed(table.header)}, expected one to find the frames by")
    rows, values, texts = read_columns(table, [index for index, _ in found.values()], [i for i, _ in named.values()])
    time = values[:, 0] * found["time"][1]
    if by_name:
        keys, wanted_keys = list(map(frame_name, texts[0])), list(map(frame_name, names or ()))
    else:
        keys = whole_numbers("frame", values[:, 1]).tolist()
        wanted_keys = whole_numbers(
            "numbers of frames", as_numbers("numbers", () if numbers is None else numbers)
        ).tolist()
    time_of: dict[str | int, float] = {}
    for row, key, seconds in zip(rows, keys, time.tolist(), strict=True):
        before = time_of.setdefault(key, seconds)
        if before != seconds and not (np.isnan(before) and np.isnan(seconds)):
            raise InputError(f"row {row}: the frame {quoted(key)} is there twice, at two times, expected it once")
    times = np.array([time_of.get(key, np.nan) for key in wanted_keys])
    if np.isnan(times).all():
        raise InputError(
            f"no frame is in the table, such as {quoted(wanted_keys[0])} here and {quoted(keys[0])} there, expected "
            "the same names or numbers: the table of another recording?"
        )
    return times


def _date(stem: str, utc_offset_h: float) -> float | None:
    """Seconds since 1970 of a date and time in a name, which are ahead of UTC by as much unless the name says so."""
    found = _DATE.search(stem)
    if found is None:
        return None
    year, month, day, hour, minute, second = (int(found[k]) for k in (1, 3, 4, 5, 7, 8))
    try:
        whole = datetime(year, month, day, hour, minute, second, tzinfo=UTC).timestamp()
    except ValueError:
        return None
    zone = utc_offset_h if found["zone"] is None else zone_hours(found["zone"])
    return None if zone is None else whole + float("0." + (found[9] or "0")) - 3600 * zone


def _differing(stems: Sequence[str]) -> list[str]:
    """The number in each name that tells the frames apart."""
    numbers = [_NUMBER.findall(stem) for stem in stems]
    counts = {len(found) for found in numbers}
    if len(counts) != 1 or counts == {0}:
        odd = next(
            (stem for stem, found in zip(stems, numbers, strict=True) if len(found) != len(numbers[0])), stems[0]
        )
        raise InputError(
            f"the names, such as {quoted(stems[0])} and {quoted(odd)}, have no number each in the same place, expected "
            "times in all of them: another file among the frames?"
        )
    columns = list(zip(*numbers, strict=True))
    varying = [column for column in columns if len(set(column)) > 1] or columns
    if len(varying) > 1:
        raise InputError(
            f"{len(varying)} numbers in the names may be times, such as {' and '.join(c[0] for c in varying[:2])} in "
            f"{quoted(stems[0])}, expected one: seconds and their fraction apart, or a date without seconds?"
        )
    return list(varying[0])
