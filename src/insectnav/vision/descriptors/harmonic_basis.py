"""Real spherical harmonics Y_lm: their degrees and orders, their values, and what is the same after any rotation."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_count, check_finite
from insectnav.vision.sphere import azimuth_elevation, check_directions

Reals = NDArray[np.floating[Any]]
MAX_DEGREES = 256


def harmonic_pairs(n_degrees: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Degrees l and orders m of the harmonics below degree `n_degrees`, two arrays (pair,) of n_degrees² pairs.

    l ascends, within it m = −l, …, l, so that l, m stands at the place l² + l + m.

    Raises
    ------
    InputError
        If the number is not a whole one from 1 to 256.
    """
    check_degrees(n_degrees)
    degree = np.repeat(np.arange(n_degrees), 2 * np.arange(n_degrees) + 1)
    return degree, np.arange(n_degrees**2) - degree * (degree + 1)


def check_degrees(n_degrees: int) -> None:
    """Refuse a number of degrees that is not a whole one from 1 to 256."""
    check_count("n_degrees", n_degrees)
    if n_degrees > MAX_DEGREES:
        raise InputError(f"n_degrees is {n_degrees}, expected at most {MAX_DEGREES}")


def legendre_functions(n_degrees: int, height: Reals) -> Iterator[Reals]:
    """For m = 0, 1, … in turn, Y_lm at each height where its cosine is 1: (l − m, height), l = m … n_degrees − 1.

    Parameters
    ----------
    n_degrees : int
    height : (n,) array, sin(elevation)

    Notes
    -----
    Associated Legendre functions, normalised, without the sign (−1)^m, by recursion in l at each m: Holmes &
    Featherstone 2002, J. Geodesy 76:279, doi 10.1007/s00190-002-0216-2, standard forward columns. Their starting values
    leave the range of double precision only where all that follows from them is too small to matter, up to degrees far
    above 256.
    """
    sine = np.sqrt((1.0 - height) * (1.0 + height))
    sectoral = np.full(height.shape, np.sqrt(1.0 / (4.0 * np.pi)))
    for m in range(n_degrees):
        if m:
            sectoral = sectoral * sine * np.sqrt((2 * m + 1) / (2 * m) * (2 if m == 1 else 1))
        table = np.empty((n_degrees - m, *height.shape))
        table[0] = sectoral
        below = 0.0
        for degree in range(m + 1, n_degrees):
            k, factor = degree - m, np.sqrt((4 * degree**2 - 1) / (degree**2 - m**2))
            table[k] = factor * height * table[k - 1]
            if k > 1:
                table[k] -= factor * below * table[k - 2]
            below = 1.0 / factor
        yield table


def real_harmonics(n_degrees: int, directions: ArrayLike) -> Reals:
    """Y_lm along each direction, (..., pair), orthonormal on the sphere; pairs as `harmonic_pairs` orders them.

    ``Y_lm = sqrt(2) N_lm P_lm(sin e) cos(m a)`` for m > 0, ``sqrt(2) N_l|m| P_l|m|(sin e) sin(|m| a)`` for m < 0,
    ``N_l0 P_l(sin e)`` for m = 0, with azimuth a and elevation e.

    Parameters
    ----------
    n_degrees : int
        Degrees 0 to n_degrees − 1.
    directions : (..., 3) array of unit vectors

    Raises
    ------
    InputError
        If these are no unit vectors or the number of degrees is out of range.

    Notes
    -----
    Stone, Differt, Milford & Webb, ICRA 2016, Eq. 1. The sign (−1)^m that some authors give P_lm is left out.
    """
    check_degrees(n_degrees)
    vectors = check_directions("directions", directions)
    azimuth = azimuth_elevation(vectors)[0].ravel()
    values = np.empty((azimuth.size, n_degrees**2))
    degree = np.arange(n_degrees)
    for m, table in enumerate(legendre_functions(n_degrees, vectors[..., 2].astype(float).ravel())):
        middle = degree[m:] ** 2 + degree[m:]
        values[:, middle + m] = (table * np.cos(m * azimuth)).T
        if m:
            values[:, middle - m] = (table * np.sin(m * azimuth)).T
    return values.reshape(*vectors.shape[:-1], n_degrees**2)


def amplitude_spectrum(coefficients: ArrayLike) -> Reals:
    """Amplitude of each degree, ``a_l = sqrt(sum_m c_lm²)``, (..., degree): the same after any rotation.

    Parameters
    ----------
    coefficients : (..., pair) array
        As `harmonic_pairs` orders them.

    Raises
    ------
    InputError
        If their number is not a square, or they are not finite.

    Notes
    -----
    Stone, Differt, Milford & Webb, ICRA 2016, Eq. 3. A rotation mixes harmonics of the same degree by an orthogonal
    matrix; Σ a_l² is the integral of the square of the band-limited function.
    """
    array = as_numbers("coefficients", coefficients)
    n_pairs = array.shape[-1] if array.ndim else 0
    n_degrees = round(n_pairs**0.5)
    if n_degrees < 1 or n_degrees**2 != n_pairs:
        raise InputError(f"coefficients have shape {array.shape}, expected L² of them for L degrees on the last axis")
    check_finite("coefficients", array)
    return degree_norms(array.astype(np.float64, copy=False), n_degrees)


def degree_norms(coefficients: Reals, n_degrees: int) -> Reals:
    """Root of the sum of squares of each degree, of coefficients that are known to be sound."""
    return np.sqrt(np.add.reduceat(coefficients * coefficients, np.arange(n_degrees) ** 2, axis=-1))


def fejer_weights(n_rings: int) -> Reals:
    """Weights (n,) by which Σ w_k f(θ_k) is ∫ f sin θ dθ over θ = 0 … π, with θ_k = (k + ½) π/n.

    Exact for polynomials in cos θ of degree below n.

    Notes
    -----
    Fejér's first rule: Waldvogel 2006, BIT 46:195, doi 10.1007/s10543-006-0045-4.
    """
    angle = (np.arange(n_rings) + 0.5) * np.pi / n_rings
    j = np.arange(1, n_rings // 2 + 1)
    return np.asarray(2.0 / n_rings * (1.0 - 2.0 * np.sum(np.cos(2 * j * angle[:, None]) / (4 * j * j - 1), axis=-1)))
