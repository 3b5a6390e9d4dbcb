"""How an animal searches when it is home and has not found the nest: arrival, loops, centre, turns towards home."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import bearing, wrap
from insectnav.checks import InputError, check_range, check_shape

Reals = NDArray[np.floating[Any]]
Steps = NDArray[np.int64]
NEVER = -1  # in place of a step


class Loops(NamedTuple):
    """Closed loops of all paths, path after path and in order of time."""

    trial: Steps  # (loop,) which path
    start: Steps  # (loop,) last step within the inner circle before leaving it
    apex: Steps  # (loop,) step of the farthest point
    end: Steps  # (loop,) first step within the inner circle again
    direction: Reals  # (loop,) [rad] of the farthest point from the centre, clockwise from +y
    reach: Reals  # (loop,) distance of the farthest point from the centre


def first_arrival(path: ArrayLike, radius: float) -> Steps:
    """First step at which a path is within a radius of the nest, (trial,); -1 where it never is.

    Parameters
    ----------
    path : (trial, step, 2) array
        The nest is at 0, 0.
    radius : float
        In the unit of the path.
    """
    is_home = np.linalg.norm(_checked(path), axis=-1) <= radius
    return np.where(is_home.any(axis=1), np.argmax(is_home, axis=1), NEVER)


def search_loops(path: ArrayLike, inner: float, outer: float) -> Loops:
    """Excursions that leave an inner circle round 0, 0, reach an outer one and come back to the inner one.

    Parameters
    ----------
    path : (trial, step, 2) array
        A path that begins outside is on no loop before it has been within the inner circle.
    inner, outer : float
        Radii, in the unit of the path; two of them, so that hovering on the edge is not counted.

    Raises
    ------
    InputError
        If the path has another shape, or the outer circle is not the larger one.

    Notes
    -----
    Loops of searching desert ants: Wehner & Srinivasan (1981), J. Comp. Physiol. 142:315, doi 10.1007/BF00605445. A
    loop that the path ends on is not closed and not counted.
    """
    path = _checked(path)
    check_range("inner", inner, 0.0, np.inf)
    if not outer > inner:
        raise InputError(f"the outer circle has a radius of {outer:g}, expected more than the inner one's {inner:g}")
    distance = np.linalg.norm(path, axis=-1)
    found = [_loops_of(distance[trial], trial, inner, outer) for trial in range(len(path))]
    trial, start, apex, end = np.concatenate([np.empty((0, 4), np.int64), *found]).T
    return Loops(trial, start, apex, end, bearing(path[trial, apex]), distance[trial, apex])


def _loops_of(distance: Reals, trial: int, inner: float, outer: float) -> Steps:
    """Rows trial, start, apex, end of one path: stretches between visits of the inner circle."""
    visits = np.flatnonzero(distance <= inner)
    gaps = np.flatnonzero(np.diff(visits) > 1)
    rows = []
    for start, end in zip(visits[gaps], visits[gaps + 1], strict=True):
        apex = start + int(np.argmax(distance[start:end]))
        if distance[apex] >= outer:
            rows.append((trial, start, apex, end))
    return np.array(rows, np.int64).reshape(-1, 4)


def search_centre(path: ArrayLike, first_step: ArrayLike) -> Reals:
    """Mean position of each path from its first step of search on, (trial, 2); NaN where that is -1.

    Parameters
    ----------
    path : (trial, step, 2) array
    first_step : (trial,) array of int
        As of `first_arrival`.
    """
    path = _checked(path)
    is_search = searching(path.shape[1], first_step)
    n_steps = is_search.sum(axis=1)[:, None]
    total = np.sum(path, axis=1, where=is_search[..., None], dtype=float)
    return np.divide(total, n_steps, out=np.full_like(total, np.nan), where=n_steps > 0)


def searching(n_steps: int, first_step: ArrayLike) -> NDArray[np.bool_]:
    """Whether the search is on, (trial, step): from its first step to the end, and never where that is -1."""
    first = np.asarray(first_step)[:, None]
    return (np.arange(n_steps) >= first) & (first != NEVER)


def homeward_turn(path: ArrayLike, edges: ArrayLike, where: ArrayLike | None = None) -> Reals:
    """Mean turn of the course towards home in a step, (bin,) [rad], by distance from home; NaN for an empty bin.

    Parameters
    ----------
    path : (trial, step, 2) array
        Home is at 0, 0.
    edges : (bin + 1,) array
        Ascending distances, in the unit of the path.
    where : (trial, step) array of bool, optional
        Steps to count, told by the place of the turn; all by default.

    Returns
    -------
    (bin,) array [rad]
        Positive where the course turns to the side on which home lies, negative where it turns away; 0 for straight
        paths and for turns without regard to home.
    """
    path, edges = _checked(path), np.asarray(edges, float)
    course = bearing(np.diff(path, axis=1))
    turn = wrap(np.diff(course, axis=1))
    here = path[:, 1:-1]
    home_side = np.sign(wrap(bearing(-here) - course[:, :-1]))
    distance = np.linalg.norm(here, axis=-1)
    is_counted = np.ones(turn.shape, bool) if where is None else np.asarray(where, bool)[:, 1:-1]
    total, _ = np.histogram(distance[is_counted], edges, weights=(turn * home_side)[is_counted])
    n_turns, _ = np.histogram(distance[is_counted], edges)
    return np.divide(total, n_turns, out=np.full(total.shape, np.nan), where=n_turns > 0)


def _checked(path: ArrayLike) -> Reals:
    path = np.asarray(path)
    check_shape("path", path, ("trial", "step", 2))
    return path if path.dtype.kind == "f" else path.astype(float)  # differences of unsigned numbers wrap
