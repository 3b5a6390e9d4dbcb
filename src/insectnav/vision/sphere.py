"""Directions on the sphere: one frame for eyes and cameras, rotations, and grids that cover the sphere.

A direction is a unit vector (x, y, z) in the frame of the eye: +x to the right, +y straight ahead, +z up. In a level
eye of heading 0 these are the axes of the world: +x east, +y north, +z up. Azimuth is in radians clockwise from
straight ahead, seen from above, as headings are; elevation is up from the horizontal plane.

An eye is turned by its heading, then its pitch, then its roll, each about its own axes as they then lie. Heading is
positive clockwise (to the right), pitch nose up, roll right side down.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import FULL_TURN, bearing
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

Reals = NDArray[np.floating[Any]]

WHOLE_SPHERE_DEG = (-90.0, 90.0)
GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))  # [rad]
THESIS_N_POINTS = 2000
THESIS_READINGS = ("hemisphere", "sphere")
_UNIT_TOLERANCE = 1e-3  # half-precision vectors pass, positions do not


def check_directions(name: str, values: ArrayLike) -> Reals:
    """Array (..., 3) of unit vectors, as given; refuses other shapes, other lengths, NaN.

    Raises
    ------
    InputError
        If the last axis is not x, y, z, or a vector is not of length 1.
    """
    array = as_numbers(name, values)
    check_shape(name, array, (..., 3))
    check_finite(name, array)
    lengths = np.linalg.norm(array, axis=-1)
    off = np.abs(lengths - 1.0) > _UNIT_TOLERANCE
    if off.any():
        worst = np.ravel(lengths)[np.argmax(np.abs(np.ravel(lengths) - 1.0))]
        raise InputError(f"{name} has a vector of length {worst:.4g}, expected unit vectors: positions, or angles?")
    return array if array.dtype.kind == "f" else array.astype(np.float64)


def azimuth_elevation(directions: ArrayLike) -> tuple[Reals, Reals]:
    """Azimuth and elevation of directions: the inverse of `directions`.

    Parameters
    ----------
    directions : (..., 3) array of vectors of any length but 0

    Returns
    -------
    azimuth : (...) array [rad] clockwise from straight ahead, in [-π, π); 0 at the zenith and the nadir
    elevation : (...) array [rad] up from the horizontal plane, in [-π/2, π/2]
    """
    vectors = as_numbers("directions", directions)
    check_shape("directions", vectors, (..., 3))
    level = np.hypot(vectors[..., 0], vectors[..., 1])
    return bearing(vectors[..., :2]), np.arctan2(vectors[..., 2], level)


def directions(azimuth: ArrayLike, elevation: ArrayLike) -> Reals:
    """Unit vectors (sin a cos e, cos a cos e, sin e) of azimuth a and elevation e.

    Parameters
    ----------
    azimuth : (...) array [rad] clockwise from straight ahead
    elevation : (...) array [rad] up from the horizontal plane

    Returns
    -------
    (..., 3) array of x to the right, y ahead, z up

    Raises
    ------
    InputError
        If angles are given in degrees, or an elevation is beyond ±π/2.
    """
    check_radians("azimuth", azimuth)
    check_range("elevation", elevation, -np.pi / 2 - 1e-9, np.pi / 2 + 1e-9, "rad", "degrees?")
    a, e = np.broadcast_arrays(np.asarray(azimuth), np.asarray(elevation))
    return np.stack([np.sin(a) * np.cos(e), np.cos(a) * np.cos(e), np.sin(e)], axis=-1)


def rotation_matrix(heading: ArrayLike, pitch: ArrayLike = 0.0, roll: ArrayLike = 0.0) -> Reals:
    """Rotation of an eye, world ← eye: ``R = Rz(-heading) Rx(pitch) Ry(roll)``.

    Parameters
    ----------
    heading : (...) array [rad] clockwise from +y
    pitch : (...) array [rad], nose up
    roll : (...) array [rad], right side down

    Returns
    -------
    (..., 3, 3) array; its columns are where the eye's right, ahead and up point in the world

    Notes
    -----
    Intrinsic order: heading, then pitch, then roll. ``scipy.spatial.transform.Rotation.from_euler("ZXY", [-heading,
    pitch, roll])`` is the same. With heading h and pitch p the eye looks along (sin h cos p, cos h cos p, sin p).
    """
    for name, angle in (("heading", heading), ("pitch", pitch), ("roll", roll)):
        check_finite(name, angle)
        check_radians(name, angle)
    h, p, r = np.broadcast_arrays(*(np.asarray(angle, dtype=np.float64) for angle in (heading, pitch, roll)))
    sh, ch, sp, cp, sr, cr = np.sin(h), np.cos(h), np.sin(p), np.cos(p), np.sin(r), np.cos(r)
    rows = [
        [ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr],
        [-sh * cr + ch * sp * sr, ch * cp, -sh * sr - ch * sp * cr],
        [-cp * sr, sp, cp * cr],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def to_world(vectors: ArrayLike, rotation: ArrayLike) -> Reals:
    """Vectors of the eye's frame in that of the world: ``world[i] = sum_j rotation[i, j] eye[j]``.

    Parameters
    ----------
    vectors : (..., 3) array
    rotation : (..., 3, 3) array of `rotation_matrix`; leading axes are broadcast against those of the vectors

    Returns
    -------
    (..., 3) array
    """
    product: Reals = np.einsum("...ij,...j->...i", np.asarray(rotation), np.asarray(vectors))
    return product


def to_eye(vectors: ArrayLike, rotation: ArrayLike) -> Reals:
    """Vectors of the world's frame in that of the eye: the inverse of `to_world`.

    Parameters
    ----------
    vectors : (..., 3) array
    rotation : (..., 3, 3) array of `rotation_matrix`; leading axes are broadcast against those of the vectors

    Returns
    -------
    (..., 3) array
    """
    product: Reals = np.einsum("...ji,...j->...i", np.asarray(rotation), np.asarray(vectors))
    return product


def great_circle_angle(first: ArrayLike, second: ArrayLike) -> Reals:
    """Angle between directions, exact for small and for nearly opposite ones, too.

    Parameters
    ----------
    first, second : (..., 3) array of unit vectors

    Returns
    -------
    (...) array [rad] in [0, π]

    Notes
    -----
    ``2 atan2(|a − b|, |a + b|)``: Kahan, How futile are mindless assessments of roundoff in floating-point
    computation? (2006), section 12.
    """
    a, b = np.asarray(first), np.asarray(second)
    return 2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


@dataclass(frozen=True, kw_only=True, eq=False)
class SphereGrid:
    """Directions that cover the sphere, or a band of it, each with its share; arrays are read-only copies.

    Parameters
    ----------
    name : what to call the grid in tables and figures
    directions : (n, 3) array of unit vectors
    weights : (n,) array [sr], the solid angle that each direction stands for
    shape : (rows, columns) of the picture that the directions make, row 0 nearest the zenith; None if they make none
    """

    name: str
    directions: Reals
    weights: Reals
    shape: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        vectors = np.array(check_directions("directions", self.directions), dtype=np.float64)
        weights = np.array(as_numbers("weights", self.weights), dtype=np.float64)
        check_shape("directions", vectors, ("n", 3))
        check_shape("weights", weights, (len(vectors),))
        check_range("weights", weights, 0.0, np.inf, "sr")
        if self.shape is not None and self.shape[0] * self.shape[1] != len(vectors):
            raise InputError(f"shape is {self.shape}, expected {len(vectors)} directions in all")
        for name, array in (("directions", vectors), ("weights", weights)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def n_directions(self) -> int:
        """Number of directions."""
        return len(self.weights)

    @property
    def solid_angle(self) -> float:
        """Solid angle that the grid covers [sr]."""
        return float(self.weights.sum())

    @property
    def spacing(self) -> float:
        """Angle between neighbours [rad]: of rows if there are any, else as if the directions lay in hexagons."""
        if self.shape is not None and self.shape[0] > 1:
            first, last = azimuth_elevation(self.directions[[0, -1]])[1]
            return float(first - last) / (self.shape[0] - 1)
        return float(np.sqrt(2.0 / np.sqrt(3.0) * self.solid_angle / self.n_directions))

    @property
    def acceptance(self) -> Reals:
        """Full width at half maximum of the field of each direction, (n,) [rad]: the spacing of the grid."""
        return np.full(self.n_directions, self.spacing)

    def integral(self, values: ArrayLike) -> Reals:
        """Integral over the covered part of the sphere: ``sum_n weights[n] values[..., n]``.

        Parameters
        ----------
        values : (..., n) array

        Returns
        -------
        (...) array [unit of the values · sr]
        """
        array = np.asarray(values)
        check_shape("values", array, (..., self.n_directions))
        return array @ self.weights


def _divisions(name: str, extent_deg: float, resolution_deg: float) -> int:
    """Number of pixels over an extent; refuses a part of a pixel."""
    count = round(extent_deg / resolution_deg)
    if count < 1 or abs(count * resolution_deg - extent_deg) > 1e-6 * resolution_deg:
        raise InputError(f"resolution_deg is {resolution_deg:g}, expected to divide {extent_deg:g}° of {name}")
    return count


def elevation_range(elevation_deg: tuple[float, float]) -> tuple[float, float]:
    """Lower and upper limit in degrees, checked.

    Raises
    ------
    InputError
        If they are no two elevations, the lower one first.
    """
    bounds = as_numbers("elevation_deg", elevation_deg)
    check_shape("elevation_deg", bounds, (2,))
    check_range("elevation_deg", bounds, -90.0, 90.0, "degrees")
    if not bounds[0] < bounds[1]:
        raise InputError(f"elevation_deg goes from {bounds[0]:g} to {bounds[1]:g}, expected the lower limit first")
    return float(bounds[0]), float(bounds[1])


def panorama_shape(resolution_deg: float, elevation_deg: tuple[float, float] = WHOLE_SPHERE_DEG) -> tuple[int, int]:
    """Rows and columns of a panorama whose pixels are as wide as they are high; refuses parts of a pixel.

    Parameters
    ----------
    resolution_deg : width and height of a pixel
    elevation_deg : lowest and highest elevation
    """
    check_range("resolution_deg", resolution_deg, 1e-3, 180.0, "degrees")
    low, high = elevation_range(elevation_deg)
    return _divisions("elevation", high - low, resolution_deg), _divisions("azimuth", 360.0, resolution_deg)


def equirectangular(resolution_deg: float = 1.0, elevation_deg: tuple[float, float] = WHOLE_SPHERE_DEG) -> SphereGrid:
    """Grid of the pixels of a panorama, with their exact solid angles.

    Row r has elevation ``top − (r + ½) resolution``, column c azimuth ``(c + ½) resolution − 180°``: row 0 is next to
    the zenith, straight ahead is in the middle, left of it is the left half.

    Parameters
    ----------
    resolution_deg : width and height of a pixel; must divide 360 and the range of elevations
    elevation_deg : lowest and highest elevation
    """
    rows, columns = panorama_shape(resolution_deg, elevation_deg)
    edges = np.deg2rad(elevation_deg[1] - resolution_deg * np.arange(rows + 1))
    azimuth = np.deg2rad((np.arange(columns) + 0.5) * resolution_deg - 180.0)
    band = -np.diff(np.sin(edges)) * FULL_TURN / columns
    elevation = (edges[1:] + edges[:-1]) / 2
    return _grid_of_rows(f"equirectangular {resolution_deg:g}°", elevation, azimuth, band)


def gauss_legendre(n_rings: int = 120) -> SphereGrid:
    """Grid that integrates every spherical harmonic of degree below 2 n_rings exactly.

    Products of two harmonics of degree below n_rings are therefore orthonormal on it.

    Parameters
    ----------
    n_rings : rings of equal elevation, at the roots of the Legendre polynomial; each has 2 n_rings directions

    Notes
    -----
    Driscoll & Healy, Adv. Appl. Math. 15, 202 (1994), doi 10.1006/aama.1994.1008, treat sampling theorems on the
    sphere; the nodes are those of Gauss's quadrature in sin(elevation). Columns lie as in `equirectangular`.
    """
    check_count("n_rings", n_rings)
    nodes, weights = np.polynomial.legendre.leggauss(n_rings)
    columns = 2 * n_rings
    azimuth = (np.arange(columns) + 0.5) * FULL_TURN / columns - np.pi
    return _grid_of_rows(
        f"gauss-legendre {n_rings}", np.arcsin(nodes[::-1]), azimuth, weights[::-1] * FULL_TURN / columns
    )


def _grid_of_rows(name: str, elevation: Reals, azimuth: Reals, weights: Reals) -> SphereGrid:
    """Grid of all pairs, given the weight of a direction in each row."""
    vectors = directions(azimuth[None, :], elevation[:, None])
    shape = (len(elevation), len(azimuth))
    return SphereGrid(name=name, directions=vectors.reshape(-1, 3), weights=np.repeat(weights, shape[1]), shape=shape)


def fibonacci(n_points: int = 2000, elevation_deg: tuple[float, float] = WHOLE_SPHERE_DEG) -> SphereGrid:
    """Grid of equal weights on a spiral that turns by the golden angle from point to point.

    Parameters
    ----------
    n_points : number of directions
    elevation_deg : lowest and highest elevation; the band between them is divided evenly

    Notes
    -----
    González, Math. Geosci. 42, 49 (2010), doi 10.1007/s11004-009-9257-x, with heights ``z_i = high − (i + ½) (high −
    low)/n``. On the whole sphere nearest neighbours are 3.09/√n rad apart. The quadrature is not exact: measured with
    2000 points, the mean of a harmonic of degree up to 20 and 40 is off by at most 0.001 and 0.003 of its root mean
    square, and from degree 80 on the spiral aliases. On the hemisphere the integrals of x, y, z and their
    products are off by at most 0.002 sr.
    """
    check_count("n_points", n_points)
    low, high = np.sin(np.deg2rad(elevation_range(elevation_deg)))
    index = np.arange(n_points)
    height = high - (index + 0.5) * (high - low) / n_points
    azimuth = np.fmod(index * GOLDEN_ANGLE, FULL_TURN)
    weights = np.full(n_points, FULL_TURN * (high - low) / n_points)
    return SphereGrid(name=f"fibonacci {n_points}", directions=directions(azimuth, np.arcsin(height)), weights=weights)


def thesis(points_on: str = "hemisphere") -> SphereGrid:
    """The 2000 directions of the published skyline codes.

    Parameters
    ----------
    points_on : {"hemisphere", "sphere"}
        Whether the 2000 directions lie on the upper hemisphere or on the whole sphere.

    Notes
    -----
    Stone, Differt, Milford & Webb, ICRA 2016: "2000 pixels to sample the upper hemisphere" (section IV), but also "m =
    2000 visual points equally distributed over the sphere" (section V-E). We follow the first; the other is kept behind
    `points_on`. How the points were spread evenly is not said: the spiral of `fibonacci` is our choice. 2000 directions
    cannot carry the 120 bands that were computed from them without aliasing.
    """
    check_choice("points_on", points_on, THESIS_READINGS)
    band = fibonacci(THESIS_N_POINTS, (0.0, 90.0) if points_on == "hemisphere" else WHOLE_SPHERE_DEG)
    return SphereGrid(name=f"thesis {points_on}", directions=band.directions, weights=band.weights)


GRIDS: dict[str, Callable[..., SphereGrid]] = {
    "equirectangular": equirectangular,
    "gauss-legendre": gauss_legendre,
    "fibonacci": fibonacci,
    "thesis": thesis,
}
