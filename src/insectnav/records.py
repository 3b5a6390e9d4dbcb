"""Small frozen records that several parts share."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats, wrap
from insectnav.checks import (
    InputError,
    as_numbers,
    check_choice,
    check_count,
    check_finite,
    check_radians,
    check_shape,
)

LENGTH_UNITS = ("m", "cm", "mm", "unit")
TIME_UNITS = ("s", "frame")


def plural_unit(unit: str) -> str:
    """A unit of length or time as it stands after a number or on an axis."""
    return {"step": "steps", "unit": "units", "frame": "frames"}.get(unit, unit)


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """Where an animal was, and when; arrays are read-only copies.

    Parameters
    ----------
    time : (n,) array [time_unit], strictly increasing
    position : (n, 2) array of x, y [length_unit]
    heading : (n,) array [rad] clockwise from +y, stored wrapped to [-π, π); None if not recorded
    length_unit : "m", "cm", "mm", or "unit" where nothing names one
    time_unit : "s" or "frame"
    name : what to call the track in figures and tables
    n_interpolated : missing samples that were filled in between neighbours or cut off at the ends
    notes : what the user must be told
    """

    time: Floats
    position: Floats
    heading: Floats | None = None
    length_unit: str
    time_unit: str
    name: str
    n_interpolated: int = 0
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_choice("length_unit", self.length_unit, LENGTH_UNITS)
        check_choice("time_unit", self.time_unit, TIME_UNITS)
        check_count("n_interpolated", self.n_interpolated, minimum=0)
        time = _frozen_array("time", self.time, ("n",))
        if not time.size:
            raise InputError("time is empty, expected at least one sample")
        back = np.flatnonzero(np.diff(time) <= 0)
        if back.size:
            after, before = time[back[0] + 1], time[back[0]]
            raise InputError(
                f"time goes from {before:.10g} to {after:.10g} at index {back[0] + 1}, expected it to increase"
            )
        position = _frozen_array("position", self.position, (time.size, 2))
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "notes", tuple(self.notes))
        if self.heading is not None:
            check_radians("heading", self.heading)
            heading = _frozen_array("heading", wrap(self.heading), (time.size,))
            object.__setattr__(self, "heading", heading)

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return int(self.time.size)

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [time_unit]."""
        return float(self.time[-1] - self.time[0])

    def reversed(self) -> Self:
        """The track flown backwards, from time 0; a recorded heading turns by π."""
        note = "flown backwards"
        heading = None
        if self.heading is not None:
            heading = wrap(self.heading[::-1] + np.pi)
            note += ", so that recorded headings are turned by 180°"
        return replace(
            self,
            time=self.time[-1] - self.time[::-1],
            position=self.position[::-1],
            heading=heading,
            name=f"{self.name}, reversed",
            notes=(*self.notes, note),
        )


def _frozen_array(name: str, values: npt.ArrayLike, shape: tuple[Any, ...]) -> Floats:
    array = np.array(as_numbers(name, values), dtype=np.float64)
    check_shape(name, array, shape)
    check_finite(name, array)
    array.setflags(write=False)
    return array
