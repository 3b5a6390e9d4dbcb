"""Zernike coefficients of panoramas: the view wrapped round the zenith, compared without regard to heading.

The panorama becomes a disk with the zenith at its centre, radius linear in the angle from the zenith and the lowest row
at the rim. A turn of the eye turns the disk, which changes the phases of its coefficients and leaves their amplitudes.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice
from insectnav.vision.descriptors.brightness import as_views, describe_batches
from insectnav.vision.descriptors.zernike_basis import (
    MAX_ORDER,
    check_order,
    radial_polynomials,
    zernike_pairs,
    zernike_weights,
)

Reals = NDArray[np.floating[Any]]
Complexes = NDArray[np.complexfloating[Any, Any]]
QUADRATURES = ("midpoint", "cells")


class PanoramaBasis(NamedTuple):
    """The functions e^(−imθ) and R_nm(r), each times its quadrature weight, at the pixels of a panorama."""

    angular: Reals  # (columns, 2 (order + 1)): the real parts for m = 0, 1, …, then the imaginary ones
    radial: tuple[Reals, ...]  # for each m, (rows, pairs of that m)
    places: tuple[NDArray[np.int64], ...]  # for each m, which pairs these are


def zernike_coefficients(views: ArrayLike, order: int = 16, *, quadrature: str = "midpoint") -> Complexes:
    """Integral of f R_nm(r) e^(−imθ) over the disk of each view, (..., pair) complex; see `zernike_pairs`.

    Parameters
    ----------
    views : (..., rows, columns) array
        Panoramas of 360°: row 0 at the zenith, equal steps in elevation, the middle column straight ahead. Bytes count
        as 0 to 1.
    order : int
        Highest n, up to 50 and at most half the number of columns.
    quadrature : str
        "midpoint" takes each pixel by its centre, as published numbers do; "cells" integrates the functions exactly
        over the area of each pixel.

    Returns
    -------
    (..., pair) array of complex128
        θ runs clockwise from straight ahead. The eye turned to the right by α: times e^(imα).

    Raises
    ------
    InputError
        If the views are not panoramas, or the order is out of range.

    Notes
    -----
    Polar pixels are what the integral wants: a Fourier sum along each row, then a sum over the rows, without a disk
    image between. Khotanzad & Hong 1990, IEEE Trans. PAMI 12(5):489, doi 10.1109/34.55109. In "cells" a constant view
    has exactly one coefficient; in "midpoint" those of n > 0 are of the order of (n / rows)².
    """
    check_order(order)
    check_choice("quadrature", quadrature, QUADRATURES)
    array = as_views(views)
    rows, columns = array.shape[-2:]
    if 2 * order > columns:
        raise InputError(f"Zernike order is {order}, expected at most half of the {columns} columns of the views")
    basis = panorama_basis(rows, columns, order, quadrature)
    return describe_batches(array, lambda values: _project(values, basis), sum(map(len, basis.places)), complex)


def zernike_amplitudes(
    views: ArrayLike, order: int = 16, *, weights: str = "stone", quadrature: str = "midpoint"
) -> Reals:
    """Weighted moduli of the Zernike coefficients of each view, (..., pair): the same for all headings.

    Parameters
    ----------
    views, order, quadrature
        As of `zernike_coefficients`.
    weights : str
        "stone", "orthonormal" or "raw": see `zernike_weights`.
    """
    return np.abs(zernike_coefficients(views, order, quadrature=quadrature)) * zernike_weights(order, weights)


@lru_cache(maxsize=8)
def panorama_basis(rows: int, columns: int, order: int, quadrature: str) -> PanoramaBasis:
    """Basis of panoramas of this size, made once."""
    m = np.arange(order + 1)
    azimuth = (np.arange(columns) + 0.5) * 2.0 * np.pi / columns - np.pi
    waves = np.exp(-1j * azimuth[:, None] * m) * 2.0 * np.pi / columns
    if quadrature == "cells":
        waves *= np.sinc(m / columns)  # mean of the wave over the width of a pixel
    radial = _midpoint_radial(rows, order) if quadrature == "midpoint" else _cell_radial(rows, order)
    places = tuple(np.flatnonzero(zernike_pairs(order)[1] == k) for k in m)
    basis = PanoramaBasis(
        np.concatenate([waves.real, waves.imag], axis=1),
        tuple(np.ascontiguousarray(radial[:, place]) for place in places),
        places,
    )
    for array in (basis.angular, *basis.radial, *places):
        array.flags.writeable = False
    return basis


def _midpoint_radial(rows: int, order: int) -> Reals:
    """R_nm r dr at the centre of each row, (rows, pair)."""
    radius = (np.arange(rows) + 0.5) / rows
    return radial_polynomials(order, radius) * radius[:, None] / rows


def _cell_radial(rows: int, order: int) -> Reals:
    """Integral of R_nm r dr over each row, (rows, pair): Gauss-Legendre with nodes enough to be exact."""
    nodes, node_weights = np.polynomial.legendre.leggauss(MAX_ORDER // 2 + 1)
    radius = (np.arange(rows)[:, None] + 0.5 + 0.5 * nodes) / rows
    values = radial_polynomials(order, radius) * (radius * node_weights * 0.5 / rows)[..., None]
    return np.asarray(values.sum(axis=1))


def _project(values: NDArray[np.float64], basis: PanoramaBasis) -> Complexes:
    """Coefficients (n, pair) of panoramas (n, rows, columns)."""
    n, rows, columns = values.shape
    waves = (values.reshape(-1, columns) @ basis.angular).reshape(n, rows, 2, -1)
    by_order = np.ascontiguousarray(waves.transpose(3, 2, 0, 1))  # (m, part, view, row)
    coefficients = np.empty((n, sum(map(len, basis.places))), complex)
    for parts, radial, place in zip(by_order, basis.radial, basis.places, strict=True):
        real, imaginary = parts @ radial
        coefficients[:, place] = real + 1j * imaginary
    return coefficients
