"""Von Mises turns from normal random numbers, through a series that compiled code evaluates."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

LARGEST_NORMAL = 6.8  # beyond what `insectnav.lanes.random.normal_pair` can give
TOLERANCE = 1e-9  # [rad]
MAX_TERMS = 1025


@lru_cache(maxsize=64)
def von_mises_series(concentration: float) -> NDArray[np.float64]:
    """Chebyshev coefficients of the turn [rad] that has the same quantile as a normal number z.

    The turn is ``z · Σ_k c_k T_k(2 (z / LARGEST_NORMAL)² − 1)``, von Mises distributed around 0 with the given
    concentration κ if z is standard normal.

    Parameters
    ----------
    concentration : float
        κ, greater than 0.

    Returns
    -------
    (n,) array

    Notes
    -----
    Inversion of the distribution function, F⁻¹(Φ(z)), instead of the usual rejection (Best & Fisher 1979): one normal
    number makes one turn, so all trials stay in step. The upper tail is integrated by Gauss–Legendre quadrature and
    inverted by Newton's method at the Chebyshev nodes; terms are doubled until the last ones are below 1e-9 rad.
    """
    n_terms = 16
    while True:
        nodes = np.cos(np.pi * (np.arange(n_terms) + 0.5) / n_terms)
        normals = LARGEST_NORMAL * np.sqrt((nodes + 1.0) / 2.0)
        ratio = _turn_of_normal(normals, concentration) / normals
        angle = np.pi * np.outer(np.arange(n_terms), np.arange(n_terms) + 0.5) / n_terms
        coefficients = 2.0 / n_terms * np.cos(angle) @ ratio
        coefficients[0] /= 2.0
        significant = np.flatnonzero(np.abs(coefficients) > TOLERANCE / LARGEST_NORMAL / n_terms)
        if significant[-1] < n_terms - 2 or n_terms >= MAX_TERMS:
            series = np.ascontiguousarray(coefficients[: significant[-1] + 1])
            series.flags.writeable = False
            return series
        n_terms *= 2


def _turn_of_normal(normals: NDArray[np.float64], concentration: float) -> NDArray[np.float64]:
    """Turns with the same upper-tail probability as the given positive normal numbers."""
    log_tail = np.log([0.5 * math.erfc(z / math.sqrt(2.0)) for z in normals])
    log_total = np.log(2.0) + _log_tail_integral(np.zeros(1), concentration)
    turn = np.minimum(normals / np.sqrt(concentration), 0.9 * np.pi)
    for _ in range(100):
        integral = _log_tail_integral(turn, concentration)
        slope = -np.exp(concentration * (np.cos(turn) - 1.0) - integral)
        before, turn = turn, turn - (integral - log_total - log_tail) / slope
        turn = np.clip(turn, 0.0, np.pi * (1.0 - 1e-13))
        if np.max(np.abs(turn - before)) < 1e-14:
            break
    return turn


def _log_tail_integral(turn: NDArray[np.float64], concentration: float) -> NDArray[np.float64]:
    """Ln ∫ e^(κ (cos t − 1)) dt from each turn to π."""
    nodes, weights = np.polynomial.legendre.leggauss(96)
    width = np.minimum(np.pi - turn, 9.0 / np.sqrt(concentration))  # beyond 9 standard deviations nothing is left
    angles = turn[:, None] + width[:, None] * (nodes + 1.0) / 2.0
    exponents = concentration * (np.cos(angles) - np.cos(turn)[:, None])
    return np.log(width / 2.0 * (np.exp(exponents) @ weights)) + concentration * (np.cos(turn) - 1.0)
