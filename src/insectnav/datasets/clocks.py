"""Clocks: zones of time, and whether two streams of times are of one clock."""

import re

import numpy as np
from numpy.typing import ArrayLike

from insectnav.angles import Floats
from insectnav.checks import InputError

GNSS_EPOCH = 315_964_800.0  # [s] 1980-01-06 on the clock that counts from 1970
WEEKS_1024 = 1024 * 604_800.0  # [s] after which the week of a satellite receiver starts anew
LEAP_SECONDS = 18.0  # by which satellites are ahead of UTC since 2017
WIDEST_ZONE_H = 14.0  # [h] ahead of UTC
WIDEST_ZONES = 26.0  # [h] from UTC−12 to UTC+14
UNITS = {1e3: "milliseconds", 1e6: "microseconds", 1e9: "nanoseconds"}
UNIX = 1e9  # [s] and later: a time since 1970, in the years that there are recordings of
_ZONE = re.compile(r"([+-])(\d\d):?([0-5]\d)", re.ASCII)


def zone_hours(text: str) -> float | None:
    """Hours by which a zone is ahead of UTC, of Z, +02:00 or -0500; None where it is no zone of the Earth."""
    if text in ("z", "Z"):
        return 0.0
    found = _ZONE.fullmatch(text)
    if found is None:
        return None
    hours = int(found[2]) + int(found[3]) / 60
    return None if hours > WIDEST_ZONE_H else -hours if found[1] == "-" else hours


def rounding_of(values: ArrayLike) -> float:
    """By how much a difference of two such values may be off; of times since 1970 [s] it is a microsecond.

    Parameters
    ----------
    values : (...) array of times or places in any unit, NaN where not known
    """
    known = np.abs(np.asarray(values, float))
    return float(4 * np.spacing(np.max(known, where=np.isfinite(known), initial=0.0)))


def check_common_clock(first_name: str, first: Floats, second_name: str, second: Floats, margin_s: float = 0.0) -> None:
    """Refuse times that cannot be of one clock, as their ranges do not overlap or one is a thousand times the other.

    Parameters
    ----------
    first_name, second_name : in the plural, as "the frames"
    first, second : (n,) arrays [s], NaN where not known; `second` is what is looked up for `first`
    margin_s : by which the ranges may miss each other [s]

    Raises
    ------
    InputError
        One sentence with both ranges and the likely slip.
    """
    ranges = []
    for name, values in ((first_name, first), (second_name, second)):
        known = values[np.isfinite(values)]
        if not known.size:
            raise InputError(f"no time of {name} is known, expected some")
        ranges.append((float(known.min()), float(known.max())))
    one, other = ranges
    is_apart = one[0] > other[1] + margin_s or other[0] > one[1] + margin_s
    length, known_length = one[1] - one[0], other[1] - other[0]
    is_scaled = any(0.5 < length / (known_length * unit) < 2.0 for unit in UNITS if known_length > 0)
    if is_apart or is_scaled:
        raise InputError(
            f"the times of {first_name} run from {one[0]:.10g} to {one[1]:.10g} s and those of {second_name} from "
            f"{other[0]:.10g} to {other[1]:.10g} s, expected ranges of one clock that overlap: {_slip(one, other)}"
        )


def _slip(one: tuple[float, float], other: tuple[float, float]) -> str:
    """Why two ranges may be apart."""
    for factor, unit in UNITS.items():
        if any(_is_like(a, (factor * b[0], factor * b[1])) for a, b in ((one, other), (other, one))):
            return f"seconds against {unit}?"
    apart = max(one[0] - other[1], other[0] - one[1])
    between = abs(one[0] - other[0])
    if abs(between - GNSS_EPOCH) < 86_400:
        return f"one clock counts from 1980, as satellites do: an offset of {GNSS_EPOCH - LEAP_SECONDS:.0f} s?"
    if between > 1 and abs(between - WEEKS_1024 * round(between / WEEKS_1024)) < 86_400 < between:
        return f"a receiver whose count of weeks has started anew: an offset of {between:.0f} s?"
    if min(one[0], other[0]) < UNIX <= max(one[0], other[0]):
        return "one counts from its start or the week, the other from 1970: which offset?"
    if apart <= WIDEST_ZONES * 3600:
        return "clocks of two time zones, or another recording?"
    return "two recordings, or a clock that was not set?"


def _is_like(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two ranges overlap by half of the shorter, and neither is more than ten times as long."""
    lengths = one[1] - one[0], other[1] - other[0]
    common = min(one[1], other[1]) - max(one[0], other[0])
    return common >= 0.5 * min(lengths) and max(lengths) <= 10 * min(lengths)
