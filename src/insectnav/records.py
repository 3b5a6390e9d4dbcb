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
    check_range,
    check_shape,
)

LENGTH_UNITS = ("m", "cm", "mm", "unit")
TIME_UNITS = ("s", "frame")
MAX_REACH = 4000.0  # [m] of a world from its origin; single precision then still tells 0.3 mm apart
MAX_TRIANGLES = 5_000_000
MIN_FLATNESS = 1e-7  # area over the square of the longest side, below which a triangle is a line


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """The surfaces of a world; arrays are read-only copies.

    Parameters
    ----------
    vertices : (triangle, 3, 3) array of corners, each x, y, z [m], z up; kept in single precision
    material : (triangle,) array of int, which of `materials` a triangle is of; None if all are of the first
    materials : names of the materials
    grey : (triangle,) array in 0…1, brightness where flat grey is drawn; None if not known
    name : what to call the world
    notes : what the user must be told

    Raises
    ------
    InputError
        If there are no triangles, a number is not finite or not sane, or shapes do not agree.

    Notes
    -----
    Triangles without area are left out, and `notes` then says how many.
    """

    vertices: npt.NDArray[Any]
    material: npt.NDArray[Any] | None = None
    materials: tuple[str, ...] = ("plant",)
    grey: npt.NDArray[Any] | None = None
    name: str = "world"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        vertices = as_numbers("vertices", self.vertices)
        check_shape("vertices", vertices, ("triangle", 3, 3))
        if not 0 < len(vertices) <= MAX_TRIANGLES:
            raise InputError(f"the mesh has {len(vertices)} triangles, expected 1 to {MAX_TRIANGLES}")
        check_finite("vertices", vertices)
        check_range(
            "vertices",
            vertices,
            -MAX_REACH,
            MAX_REACH,
            "m",
            "not in metres, or in map coordinates far from the origin?",
        )
        vertices = vertices.astype(np.float32)
        keep = _has_area(vertices)
        if not keep.any():
            raise InputError("no triangle of the mesh has an area, expected some")
        notes = tuple(self.notes)
        if not keep.all():
            notes += (f"triangles without area were left out: {int((~keep).sum())}",)
        material = np.zeros(len(keep), np.int32) if self.material is None else as_numbers("material", self.material)
        check_shape("material", material, (len(keep),))
        if material.dtype.kind == "f":
            raise InputError("material holds fractions, expected a whole number for each triangle")
        check_range("material", material, 0, len(self.materials) - 1, slip="a material without a name?")
        object.__setattr__(self, "vertices", read_only(vertices[keep], np.float32))
        object.__setattr__(self, "material", read_only(material[keep], np.int32))
        object.__setattr__(self, "materials", tuple(self.materials))
        object.__setattr__(self, "notes", notes)
        if self.grey is not None:
            grey = as_numbers("grey", self.grey)
            check_shape("grey", grey, (len(keep),))
            check_range("grey", grey, 0, 1, slip="in 0 to 255?")
            object.__setattr__(self, "grey", read_only(grey[keep], np.float32))

    @property
    def n_triangles(self) -> int:
        """Number of triangles."""
        return len(self.vertices)

    @property
    def bounds(self) -> Floats:
        """Least and greatest x, y, z (2, 3) [m]."""
        return np.stack([self.vertices.min(axis=(0, 1)), self.vertices.max(axis=(0, 1))]).astype(np.float64)


@dataclass(frozen=True, kw_only=True, eq=False)
class Poses:
    """Where an eye or a camera is, one row for each picture, and how it is turned; arrays are read-only copies.

    Parameters
    ----------
    position : (n, 3) array of x, y, z [m]
    heading, pitch, roll : (n,) arrays [rad], clockwise from +y, nose up, right side down; stored in [-π, π)
    distance : (n,) array [m], not decreasing, along the way
    time : (n,) array [s], not decreasing

    Raises
    ------
    InputError
        If shapes do not agree, a number is not finite, angles are in degrees, or distance or time go back.
    """

    position: Floats
    heading: Floats
    pitch: Floats
    roll: Floats
    distance: Floats
    time: Floats

    def __post_init__(self) -> None:
        position = _frozen_array("position", self.position, ("n", 3))
        if not len(position):
            raise InputError("there are no positions, expected at least one")
        object.__setattr__(self, "position", position)
        for name in ("heading", "pitch", "roll"):
            check_radians(name, getattr(self, name))
            object.__setattr__(self, name, _frozen_array(name, wrap(getattr(self, name)), (len(position),)))
        for name in ("distance", "time"):
            array = _frozen_array(name, getattr(self, name), (len(position),))
            back = np.flatnonzero(np.diff(array) < 0)
            if back.size:
                before, after = array[back[0]], array[back[0] + 1]
                raise InputError(
                    f"{name} goes back from {before:.10g} to {after:.10g} at index {back[0] + 1}: rows out of order?"
                )
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.position)


def _has_area(vertices: npt.NDArray[np.float32]) -> npt.NDArray[np.bool_]:
    corners = vertices.astype(np.float64)
    sides = corners[:, [1, 2, 0]] - corners
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=-1) / 2
    return np.asarray(area > MIN_FLATNESS * (sides**2).sum(axis=-1).max(axis=-1))


def read_only(values: npt.NDArray[Any], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """A copy in one piece of the type given, into which nothing can be written."""
    array = np.ascontiguousarray(values, dtype)
    if array.base is not None or array is values:
        array = array.copy()
    array.setflags(write=False)
    return array


def _frozen_array(name: str, values: npt.ArrayLike, shape: tuple[Any, ...]) -> Floats:
    array = np.array(as_numbers(name, values), dtype=np.float64)
    check_shape(name, array, shape)
    check_finite(name, array)
    array.setflags(write=False)
    return array
