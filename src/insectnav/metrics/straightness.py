"""How straight ways home are: how the distance to the nest shrinks along them, and tortuosity."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import check_finite, check_shape
from insectnav.metrics.path_integration import summary

Reals = NDArray[np.floating[Any]]


def distance_left_along(path: ArrayLike, shares: ArrayLike, *, nearest_so_far: bool = True) -> Reals:
    """Distance to the nest after walking given shares of the straight way, over that way, (trial, share).

    ``D[i, k] = min over steps up to s of |path[i]| / L``, s being the first sample of trial i at which it has walked
    ``shares[k] · L`` and L the straight distance at the start.

    Parameters
    ----------
    path : (trial, step, 2) array
        Ways home, from the turning point on; the nest is at 0, 0.
    shares : (share,) array
        Path lengths, over L.
    nearest_so_far : bool
        The smallest distance up to there; off, the distance there.

    Returns
    -------
    (trial, share) array
        NaN where a path is shorter, and for L = 0.

    Raises
    ------
    InputError
        If a shape is another or a share not finite.

    Notes
    -----
    The curve of Stone et al. 2017, Fig. 5e, doi 10.1016/j.cub.2017.08.052. Between two samples the nearest approach so
    far counts at the path length of the later one.
    """
    path, shares = np.asarray(path, float), np.asarray(shares, float)
    check_shape("path", path, ("trial", "step", 2))
    check_shape("shares", shares, ("share",))
    check_finite("shares", shares)
    steps = np.linalg.norm(np.diff(path, axis=1), axis=-1)
    left = np.full((len(path), len(shares)), np.nan)
    if not path.shape[1]:
        return left
    walked = np.concatenate([np.zeros((len(path), 1)), np.cumsum(steps, axis=1)], axis=1)
    distance = np.linalg.norm(path, axis=-1)
    straight = distance[:, 0]
    if nearest_so_far:
        distance = np.minimum.accumulate(distance, axis=1)
    for trial in np.flatnonzero(straight > 0.0):
        step = np.searchsorted(walked[trial], shares * straight[trial])
        is_reached = step < walked.shape[1]
        left[trial, is_reached] = distance[trial, step[is_reached]] / straight[trial]
    return left


def distance_left(path: ArrayLike) -> Reals:
    """Share of the way still to go when an agent has walked as far as the nest was, (trial,); 0 is a straight line.

    Parameters
    ----------
    path : (trial, step, 2) array
        Ways home, from the turning point on; the nest is at 0, 0.

    Returns
    -------
    (trial,) array
        `distance_left_along` at share 1: the smallest distance to the nest up to path length L, over L; NaN for a path
        shorter than L, or with L = 0.

    Notes
    -----
    The definition that Stone et al. 2017, Fig. 5e, plots.
    """
    return distance_left_along(path, [1.0])[:, 0]


def tortuosity(left: ArrayLike) -> float:
    """L/C of Stone et al. 2017, Fig. 5e: 1 / (1 − mean share of the way left); 1 is a straight line.

    Parameters
    ----------
    left : (trial,) array
        From `distance_left`; NaN are left out.
    """
    mean = summary(left).mean
    return float("inf") if mean >= 1.0 else 1.0 / (1.0 - mean)
