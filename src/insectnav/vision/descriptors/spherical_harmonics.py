"""Spherical harmonics of views: coefficients, and amplitudes that no rotation of the eye changes.

A view is a function on the sphere. What is seen is expanded; what is not seen counts as one stated value.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import FULL_TURN
from insectnav.checks import InputError, check_choice, check_finite
from insectnav.vision.descriptors.brightness import as_views, describe_batches
from insectnav.vision.descriptors.harmonic_basis import (
    check_degrees,
    degree_norms,
    fejer_weights,
    legendre_functions,
)
from insectnav.vision.sphere import SphereGrid, azimuth_elevation, directions, elevation_range

Reals = NDArray[np.floating[Any]]
Project = Callable[[NDArray[np.float64]], Reals]
N_DEGREES = 120  # Stone, Differt, Milford & Webb, ICRA 2016, section IV
ELEVATION_DEG = (-15.0, 90.0)  # [°] of the panoramas of `insectnav.worlds.render_panorama`
QUADRATURES = ("fejer", "cells")
_NODES_PER_ROW = 16  # Gauss-Legendre within a row; enough for any row that the degrees resolve
_VIEWS_AT_ONCE = 8  # whose waves stay in a processor's cache
_NEGLIGIBLE = 1e-20  # of the largest function of the same order


class RowBasis(NamedTuple):
    """Harmonics on rows of equal elevation, as `harmonic_kernel.project_rows` takes them."""

    table: Reals  # for each m the functions (row, l − m) times their weight, one after the other
    starts: NDArray[np.int64]  # (m,) where those of m begin
    spans: NDArray[np.int64]  # (m, 2) first row, and one past the last, in which they are not negligible
    factors: NDArray[np.complexfloating[Any]]  # (m,) width of a column times the phase of the first one


def harmonic_coefficients(
    views: ArrayLike,
    n_degrees: int = N_DEGREES,
    *,
    elevation_deg: tuple[float, float] = ELEVATION_DEG,
    unseen: float = 0.0,
    quadrature: str = "fejer",
) -> Reals:
    """Coefficients c_lm of each panorama, (..., pair); see `harmonic_pairs`.

    Parameters
    ----------
    views : (..., rows, columns) array
        Panoramas of 360°: the highest row first, equal steps in elevation, the middle column straight ahead. Bytes
        count as 0 to 1.
    n_degrees : int
        Degrees 0 to n_degrees − 1; at most 180° over the height of a row, and half the number of columns.
    elevation_deg : pair [°]
        Elevations of the lower and upper edge of the views.
    unseen : float
        Brightness of the sphere outside the view.
    quadrature : str
        "fejer" takes the values at the centres of pixels and is exact where the degrees of view and harmonic add up to
        less than 180° over the height of a row; rows must be those of a sphere from pole to pole, or some of them.
        "cells" takes each pixel as an area of one brightness and integrates over it exactly; it takes any rows.

    Returns
    -------
    (..., pair) array of float64
        Of the harmonics of `real_harmonics`, in the frame of the eye.

    Raises
    ------
    InputError
        If the views are not panoramas, have too few pixels for the degrees, or do not fit the elevations.

    Notes
    -----
    A Fourier transform of each row, then for each m a weighted sum over the rows. Driscoll & Healy 1994, Adv. Appl.
    Math. 15:202, doi 10.1006/aama.1994.1008, show that samples at equal angles suffice. The difference from `unseen` is
    what is expanded, so a view that equals it is exact. Of views that a renderer averages over pixels "fejer" is the
    more accurate, of such with one ray a pixel "cells", which blurs by another pixel.
    """
    array, project = _of_panoramas(views, n_degrees, elevation_deg, unseen, quadrature)
    return describe_batches(array, project, n_degrees**2)


def harmonic_amplitudes(
    views: ArrayLike,
    n_degrees: int = N_DEGREES,
    *,
    elevation_deg: tuple[float, float] = ELEVATION_DEG,
    unseen: float = 0.0,
    quadrature: str = "fejer",
) -> Reals:
    """Amplitude of each degree of each panorama, (..., degree): the same for all headings, and tilts that lose nothing.

    Parameters
    ----------
    views, n_degrees, elevation_deg, unseen, quadrature
        As of `harmonic_coefficients`.

    Notes
    -----
    Stone, Differt, Milford & Webb, ICRA 2016. A tilt moves some of the world out of a view that is not the whole
    sphere; what it does to the amplitudes is what that part was above `unseen`.
    """
    array, project = _of_panoramas(views, n_degrees, elevation_deg, unseen, quadrature)
    return describe_batches(array, lambda values: degree_norms(project(values), n_degrees), n_degrees)


def sphere_coefficients(
    values: ArrayLike, grid: SphereGrid, n_degrees: int = N_DEGREES, *, unseen: float = 0.0
) -> Reals:
    """Coefficients c_lm of values on the directions of a grid, (..., pair): ``sum_n w_n f_n Y_lm(n)``.

    Parameters
    ----------
    values : (..., direction) array, or (..., rows, columns) of a grid of rows
        Bytes count as 0 to 1.
    grid : SphereGrid
        `gauss_legendre` of at least n_degrees rings is exact for functions of these degrees. Grids of single points,
        as `thesis`, are summed plainly, as published, and alias where they are too sparse.
    n_degrees : int
        Degrees 0 to n_degrees − 1; on rows at most π over their spacing and half the number of columns.
    unseen : float
        Brightness of the sphere outside the grid.

    Returns
    -------
    (..., pair) array of float64

    Raises
    ------
    InputError
        If the values do not fit the grid, or the grid's rows do not carry the degrees.

    Notes
    -----
    Of points without rows all harmonics are evaluated anew in each call, which takes far longer than the sums over one
    view: give them in batches. 2000 points for 120 degrees, 14 400 harmonics, are the published choice. What a plain
    sum over n points makes of a harmonic they do not carry has L²/n times its power, spread over all L degrees.
    Fourier transforms are slow where half the number of columns has a large prime factor: 240 rings rather than 241.
    """
    array, project = _of_grid(values, grid, n_degrees, unseen)
    return describe_batches(array, project, n_degrees**2)


def sphere_amplitudes(values: ArrayLike, grid: SphereGrid, n_degrees: int = N_DEGREES, *, unseen: float = 0.0) -> Reals:
    """Amplitude of each degree of values on the directions of a grid, (..., degree): the same after any rotation.

    Parameters
    ----------
    values, grid, n_degrees, unseen
        As of `sphere_coefficients`.
    """
    array, project = _of_grid(values, grid, n_degrees, unseen)
    return describe_batches(array, lambda part: degree_norms(project(part), n_degrees), n_degrees)


def _of_panoramas(
    views: ArrayLike, n_degrees: int, elevation_deg: tuple[float, float], unseen: float, quadrature: str
) -> tuple[NDArray[Any], Project]:
    """Checked views, and what gives the coefficients (n, pair) of some of them."""
    check_degrees(n_degrees)
    check_choice("quadrature", quadrature, QUADRATURES)
    low, high = elevation_range(elevation_deg)
    array = as_views(views)
    rows, columns = array.shape[-2:]
    _check_resolution(n_degrees, columns, (high - low) / rows)
    basis = panorama_basis(rows, columns, n_degrees, (low, high), quadrature)
    return array, _above(unseen, lambda values: _project(values, basis))


def _of_grid(values: ArrayLike, grid: SphereGrid, n_degrees: int, unseen: float) -> tuple[NDArray[Any], Project]:
    """Checked values (..., rows, columns), points in one row, and what gives the coefficients of some of them."""
    check_degrees(n_degrees)
    array = np.asarray(values)
    is_flat = array.shape[-1:] == (grid.n_directions,)
    if not is_flat and (grid.shape is None or array.shape[-2:] != grid.shape):
        rows = f" or (..., {grid.shape[0]}, {grid.shape[1]})" if grid.shape else ""
        raise InputError(
            f"values have shape {array.shape}, expected (..., {grid.n_directions}){rows}, as the grid {grid.name}"
        )
    lead = array.shape[: -1 if is_flat else -2]
    array = as_views(array.reshape(*lead, *(grid.shape or (1, grid.n_directions))))
    if grid.shape is None:
        return array, _above(unseen, lambda part: _sum_over_points(part[:, 0], grid, n_degrees))
    height, weights = grid_rows(grid)
    _check_resolution(n_degrees, grid.shape[1], float(np.rad2deg(grid.spacing)))
    basis = grid_basis(height.tobytes(), weights.tobytes(), grid.shape[1], n_degrees)
    return array, _above(unseen, lambda part: _project(part, basis))


def _above(unseen: float, project: Project) -> Project:
    """The projection of what differs from `unseen`, and that of the sphere of that brightness."""
    check_finite("unseen", unseen)
    if unseen == 0.0:
        return project

    def project_difference(values: NDArray[np.float64]) -> Reals:
        coefficients = project(values - unseen)
        coefficients[:, 0] += unseen * np.sqrt(4.0 * np.pi)
        return coefficients

    return project_difference


def _check_resolution(n_degrees: int, columns: int, step_deg: float) -> None:
    """Refuse degrees whose waves are shorter than two pixels."""
    most = min((columns + 1) // 2, int(180.0 / step_deg + 1e-6))
    if n_degrees > most:
        raise InputError(
            f"n_degrees is {n_degrees}, expected at most {most} for {columns} columns and rows {step_deg:.3g}° apart"
        )


@lru_cache(maxsize=8)
def panorama_basis(
    rows: int, columns: int, n_degrees: int, elevation_deg: tuple[float, float], quadrature: str
) -> RowBasis:
    """Basis of panoramas of this size, made once."""
    low, high = elevation_deg
    step = (high - low) / rows
    if quadrature == "cells":
        width = np.sinc(np.arange(n_degrees) / columns)  # mean of the wave over the width of a pixel
        edges = np.sin(np.deg2rad(high - step * np.arange(rows + 1)))
        return _row_basis(_cell_functions(n_degrees, edges), columns, width)
    n_rings, above = 180.0 / step, (90.0 - high) / step
    if abs(n_rings - round(n_rings)) > 1e-6 or abs(above - round(above)) > 1e-6:
        raise InputError(
            f"{rows} rows from {low:g}° to {high:g}° are not rows of a sphere from pole to pole, "
            "which the quadrature 'fejer' expects: give elevation_deg as rendered, or the quadrature 'cells'"
        )
    weights = fejer_weights(round(n_rings))[round(above) :][:rows]
    height = np.sin(np.deg2rad(high - step * (np.arange(rows) + 0.5)))
    return _row_basis([table.T * weights[:, None] for table in legendre_functions(n_degrees, height)], columns)


def _cell_functions(n_degrees: int, edges: Reals) -> list[Reals]:
    """Integral over each row of the functions of each m, (row, l − m)."""
    nodes, node_weights = np.polynomial.legendre.leggauss(_NODES_PER_ROW)
    middle, half = (edges[1:] + edges[:-1]) / 2, (edges[:-1] - edges[1:]) / 2
    height = (middle[:, None] + half[:, None] * nodes).ravel()
    share = half[:, None] * node_weights
    return [
        np.einsum("krn,rn->rk", table.reshape(len(table), len(middle), -1), share)
        for table in legendre_functions(n_degrees, height)
    ]


@lru_cache(maxsize=8)
def grid_rows(grid: SphereGrid) -> tuple[Reals, Reals]:
    """Sine of the elevation of each row of a grid, and the weight of the row, (rows,) each."""
    rows, columns = grid.shape or (0, 0)
    elevation = azimuth_elevation(grid.directions)[1].reshape(rows, columns)[:, 0]
    azimuth = (np.arange(columns) + 0.5) * FULL_TURN / columns - np.pi
    expected = directions(azimuth, elevation[:, None]).reshape(-1, 3)
    weights = grid.weights.reshape(rows, columns)
    if not np.allclose(grid.directions, expected, rtol=0, atol=1e-9) or np.ptp(weights, axis=1).max() > 1e-12:
        raise InputError(
            f"the grid {grid.name} has a shape, expected rows of equal elevation, evenly divided as in equirectangular"
        )
    return np.sin(elevation), weights.sum(axis=1) / FULL_TURN


@lru_cache(maxsize=8)
def grid_basis(height: bytes, weights: bytes, columns: int, n_degrees: int) -> RowBasis:
    """Basis of a grid of rows, made once for all grids that hold the same numbers."""
    row_weights = np.frombuffer(weights)[:, None]
    return _row_basis([t.T * row_weights for t in legendre_functions(n_degrees, np.frombuffer(height))], columns)


def _row_basis(functions: list[Reals], columns: int, width: Reals | float = 1.0) -> RowBasis:
    """Basis of functions (row, l − m) for each m, on columns that begin at the back of the head."""
    spans = []
    for table in functions:
        largest = np.abs(table).max(axis=1)
        rows = np.flatnonzero(largest > _NEGLIGIBLE * largest.max())
        spans.append((rows[0], rows[-1] + 1) if rows.size else (0, 0))
    m, first = np.arange(len(functions)), np.pi / columns - np.pi
    starts = np.cumsum([0, *(table.size for table in functions)])[:-1]
    basis = RowBasis(
        np.concatenate([table.ravel() for table in functions]),
        starts,
        np.array(spans, dtype=np.int64),
        np.exp(-1j * m * first) * (width * FULL_TURN / columns),
    )
    for array in basis:
        array.flags.writeable = False
    return basis


def _project(values: NDArray[np.float64], basis: RowBasis) -> Reals:
    """Coefficients (n, pair) of values (n, rows, columns)."""
    from insectnav.vision.descriptors.harmonic_kernel import project_rows

    coefficients = np.empty((len(values), len(basis.factors) ** 2))
    for first in range(0, len(values), _VIEWS_AT_ONCE):
        some = slice(first, first + _VIEWS_AT_ONCE)
        project_rows(np.fft.rfft(values[some], axis=-1), *basis, coefficients[some])
    return coefficients


def _sum_over_points(values: NDArray[np.float64], grid: SphereGrid, n_degrees: int) -> Reals:
    """Coefficients (n, pair) of values (n, point): weighted sums."""
    azimuth, _ = azimuth_elevation(grid.directions)
    weighted = values * grid.weights
    coefficients, degree = np.empty((len(values), n_degrees**2)), np.arange(n_degrees)
    for m, table in enumerate(legendre_functions(n_degrees, grid.directions[:, 2])):
        middle = degree[m:] ** 2 + degree[m:]
        coefficients[:, middle + m] = (weighted * np.cos(m * azimuth)) @ table.T
        if m:
            coefficients[:, middle - m] = (weighted * np.sin(m * azimuth)) @ table.T
    return coefficients
