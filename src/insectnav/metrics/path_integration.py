"""How well a path integrator came home: distances summarised, decoded vectors, direction of departure."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import bearing, wrap
from insectnav.checks import check_shape

Reals = NDArray[np.floating[Any]]


class Summary(NamedTuple):
    """Location and spread of a sample; NaN where there is none."""

    mean: float
    median: float
    sd: float  # of the sample, n − 1
    p90: float  # 90th percentile
    n: int


def summary(values: ArrayLike) -> Summary:
    """Mean, median, SD and 90th percentile of the finite values of an array."""
    finite = np.asarray(values, float).ravel()
    finite = finite[np.isfinite(finite)]
    if finite.size == 0:
        return Summary(np.nan, np.nan, np.nan, np.nan, 0)
    spread = float(np.std(finite, ddof=1)) if finite.size > 1 else np.nan
    middle, high = np.percentile(finite, [50.0, 90.0]).tolist()
    return Summary(float(finite.mean()), middle, spread, high, finite.size)


def bearing_error(decoded: ArrayLike, true: ArrayLike) -> Reals:
    """Angle from the true to the decoded vector, (...) [rad] in [−π, π), positive clockwise; NaN where one is null.

    Parameters
    ----------
    decoded, true : (..., 2) arrays
    """
    lengths = np.linalg.norm(decoded, axis=-1) * np.linalg.norm(true, axis=-1)
    return np.where(lengths > 0.0, wrap(bearing(decoded) - bearing(true)), np.nan)[()]


def length_ratio(decoded: ArrayLike, true: ArrayLike) -> Reals:
    """Length of the decoded over that of the true vector, (...); NaN where the true one is null.

    Parameters
    ----------
    decoded, true : (..., 2) arrays
    """
    length = np.linalg.norm(true, axis=-1)
    return np.linalg.norm(decoded, axis=-1) / np.where(length > 0.0, length, np.nan)


def departure_error(path: ArrayLike, radius: float) -> Reals:
    """Angle from the direction of the nest to that of the point where a path leaves a circle round its start, (trial,).

    Parameters
    ----------
    path : (trial, step, 2) array
        Ways home, from the turning point on; the nest is at 0, 0.
    radius : float
        Of the circle, in the unit of the path.

    Returns
    -------
    (trial,) array [rad] in [−π, π)
        Positive clockwise; NaN where a path never leaves the circle or starts at the nest.

    Notes
    -----
    Stone et al. 2017, Fig. 5d, with a radius of 20 steps. The crossing lies on the straight line between two samples.
    """
    path = np.asarray(path, float)
    check_shape("path", path, ("trial", "step", 2))
    if path.shape[1] < 2:
        return np.full(len(path), np.nan)
    start = path[:, :1]
    away = path - start
    is_outside = np.linalg.norm(away, axis=-1) >= radius
    last = np.maximum(np.argmax(is_outside, axis=1), 1)
    inside, outside = away[np.arange(len(path)), last - 1], away[np.arange(len(path)), last]
    step = outside - inside
    # |inside + share · step| = radius
    a, b = np.sum(step**2, -1), np.sum(inside * step, -1)
    c = np.sum(inside**2, -1) - radius**2
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (-b + np.sqrt(b**2 - a * c)) / a
    error = bearing_error(inside + share[:, None] * step, -start[:, 0])
    return np.where(is_outside.any(axis=1), error, np.nan)
