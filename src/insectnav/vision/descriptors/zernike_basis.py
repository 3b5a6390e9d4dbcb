"""Zernike functions R_nm(r) e^(−imθ) of the unit disk: their orders, radial polynomials and weights."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice, check_count, check_range

Reals = NDArray[np.floating[Any]]
MAX_ORDER = 50
WEIGHTS = ("raw", "stone", "orthonormal")


def zernike_pairs(order: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Degrees n and angular orders m of the functions up to degree `order`, two arrays (pair,).

    n ascends, within it m = n mod 2, …, n in twos: (0, 0), (1, 1), (2, 0), (2, 2), (3, 1), … Those with m < 0 are left
    out, as the amplitudes of a real picture are the same for −m.

    Raises
    ------
    InputError
        If the order is not a whole number from 0 to 50.
    """
    check_order(order)
    pairs = [(n, m) for n in range(order + 1) for m in range(n % 2, n + 1, 2)]
    n, m = np.array(pairs).T
    return n, m


def check_order(order: int) -> None:
    """Refuse an order that is not a whole number from 0 to 50."""
    check_count("Zernike order", order, minimum=0)
    if order > MAX_ORDER:
        raise InputError(f"Zernike order is {order}, expected at most {MAX_ORDER}")


def radial_polynomials(order: int, radius: ArrayLike) -> Reals:
    """R_nm at each radius, (..., pair), pairs as `zernike_pairs` orders them; 1 at the rim.

    Parameters
    ----------
    order : int
        Highest degree n, up to 50.
    radius : (...) array, 0 to 1

    Raises
    ------
    InputError
        If a radius is outside the disk or the order out of range.

    Notes
    -----
    R_nm = r (R_{n−1,|m−1|} + R_{n−1,m+1}) − R_{n−2,m}, with R = 0 where m > n: Shakibaei & Paramesran 2013, Optics
    Letters 38(14):2487, doi 10.1364/OL.38.002487. It errs by 1e-15 at n = 50, where the sum of factorials that defines
    R_nm (Zernike 1934; Born & Wolf, Principles of Optics, section 9.2.1) is wrong by 22 in double precision, and by
    0.004 at n = 40.
    """
    check_order(order)
    check_range("radius", radius, 0.0, 1.0)
    radius = np.asarray(radius, float)
    table = np.zeros((order + 1, order + 2, *radius.shape))  # rows n, columns m; one more for m + 1
    table[0, 0] = 1.0
    for n in range(1, order + 1):
        for m in range(n % 2, n + 1, 2):
            table[n, m] = radius * (table[n - 1, abs(m - 1)] + table[n - 1, m + 1])
            if n >= 2:
                table[n, m] -= table[n - 2, m]
    return np.moveaxis(table[zernike_pairs(order)], 0, -1)


def zernike_weights(order: int, weights: str) -> Reals:
    """Factor by which the amplitude of each pair is multiplied, (pair,).

    Parameters
    ----------
    order : int
    weights : str
        "raw": 1. "stone": n + 1, half of it for m = 0. "orthonormal": sqrt(n + 1), by which all R_nm e^(imθ) have the
        same norm, so that distances of coefficients are distances of pictures.

    Raises
    ------
    InputError
        If the name is none of these or the order out of range.

    Notes
    -----
    "stone" is what the code to Stone, Mangan, Wystrach & Webb 2018, Interface Focus 8:20180010, doi
    10.1098/rsfs.2018.0010, multiplies by; it stresses fine detail. ∫ |R_nm e^(imθ)|² over the disk is π/(n + 1); the π
    is left out of "orthonormal".
    """
    check_choice("Zernike weights", weights, WEIGHTS)
    n, m = zernike_pairs(order)
    if weights == "raw":
        return np.ones(len(n))
    if weights == "orthonormal":
        return np.sqrt(n + 1.0)
    return np.where(m == 0, 0.5, 1.0) * (n + 1.0)
