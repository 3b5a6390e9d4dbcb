"""From waves along rows to coefficients of spherical harmonics, compiled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.lanes.compiled import kernel, lane_function

Array = NDArray[Any]


@lane_function
def add_rows(waves: Array, m: int, table: Array, first: int, last: int, real: Array, imaginary: Array) -> None:
    """Add the waves of order m in rows first … last − 1, each times the functions of its row; four rows at a time."""
    row = first
    while row + 4 <= last:
        a, b, c, d = waves[row, m], waves[row + 1, m], waves[row + 2, m], waves[row + 3, m]
        for k in range(table.shape[1]):
            p, q, r, s = table[row, k], table[row + 1, k], table[row + 2, k], table[row + 3, k]
            real[k] += a.real * p + b.real * q + c.real * r + d.real * s
            imaginary[k] += a.imag * p + b.imag * q + c.imag * r + d.imag * s
        row += 4
    while row < last:
        a = waves[row, m]
        for k in range(table.shape[1]):
            real[k] += a.real * table[row, k]
            imaginary[k] += a.imag * table[row, k]
        row += 1


@kernel
def project_rows(waves: Array, table: Array, starts: Array, spans: Array, factors: Array, coefficients: Array) -> None:
    """Fill the coefficients (view, pair) of waves (view, row, m): sums over rows, one view after the other.

    ``table`` holds for each m, from ``starts[m]`` on, the functions (row, l − m) times their quadrature weight, which
    are not negligible in the rows ``spans[m]``; the wave of order m is to be multiplied by ``factors[m]``.
    """
    n_rows, n_degrees = waves.shape[1], len(factors)
    real, imaginary = np.empty(n_degrees), np.empty(n_degrees)
    for m in range(n_degrees):
        n = n_degrees - m
        functions = table[starts[m] : starts[m] + n_rows * n].reshape(n_rows, n)
        cosine, sine = factors[m].real, factors[m].imag
        for view in range(len(waves)):
            real[:n] = 0.0
            imaginary[:n] = 0.0
            add_rows(waves[view], m, functions, spans[m, 0], spans[m, 1], real, imaginary)
            for k in range(n):
                middle = (m + k) * (m + k + 1)
                coefficients[view, middle - m] = -(real[k] * sine + imaginary[k] * cosine)
                coefficients[view, middle + m] = real[k] * cosine - imaginary[k] * sine
