"""Ways down a surface that is known on a grid: bicubic interpolation and steepest descent."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_count, check_finite, check_range, check_shape
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
OUTCOMES = ("goal", "minimum", "edge", "unfinished")
STARTS_PER_TASK = 1024
ROUNDING = 1e-9  # of the extent of a grid, as in sums of its spacing
OUTSIDE = "outside the grid, whose first sample is at 0, 0"


class Descent(NamedTuple):
    """Where ways down a surface ended; arrays of the leading shape of the starts."""

    position: Reals  # (..., 2) [m] x, y
    outcome: NDArray[np.int64]  # (...) index into `OUTCOMES`
    n_steps: NDArray[np.int64]  # (...)


def interpolate_surface(surface: ArrayLike, spacing: float, positions: ArrayLike) -> tuple[Reals, Reals]:
    """Value (...) and gradient (..., 2) [per m] of the bicubic surface through the samples.

    Parameters
    ----------
    surface : (rows, columns) array
        Sample [i, j] lies at x = j · spacing, y = i · spacing.
    spacing : float [m]
    positions : (..., 2) array [m] of x, y
        Within the grid.

    Raises
    ------
    InputError
        If the surface is no finite grid of at least 3 × 3, or a position is outside.

    Notes
    -----
    Cubic convolution with a = −1/2, the Catmull-Rom spline: once differentiable, exact on the samples and for surfaces
    of second degree: Keys 1981, IEEE Trans. Acoust. Speech Signal Process. 29(6):1153, doi 10.1109/TASSP.1981.1163711,
    whose rule for the samples beyond the edge, 3 f_0 − 3 f_1 + f_2, we follow.
    """
    from insectnav.homing.descent_kernel import interpolate_all

    padded, spacing = _padded(surface), checked_spacing(spacing)
    places = _places("positions", positions, spacing, padded)
    values, slopes = np.empty(places.shape[:-1]), np.empty(places.shape)
    interpolate_all(padded, places.reshape(-1, 2), values.reshape(-1), slopes.reshape(-1, 2))
    return values[()], slopes / spacing


def descend(
    surface: ArrayLike,
    spacing: float,
    starts: ArrayLike,
    goal: ArrayLike | None = None,
    success_radius: float = 0.0,
    *,
    step: float | None = None,
    max_steps: int | None = None,
    workers: int | None = None,
) -> Descent:
    """Where steepest descent from each start ends, and why.

    Parameters
    ----------
    surface : (rows, columns) array
        Sample [i, j] lies at x = j · spacing, y = i · spacing.
    spacing : float [m]
    starts : (..., 2) array [m] of x, y
    goal : (2,) array [m] of x, y
        A way ends at the first step within `success_radius` of it. None: at a minimum or an edge.
    success_radius : float [m]
    step : float [m]
        Length of the steps; a quarter of the spacing if None.
    max_steps : int
        Where a way is given up as unfinished. If None, what would do to walk the circumference of the grid ten times.
    workers : int
        Threads; as many as there are processors if None. They change nothing but the time.

    Raises
    ------
    InputError
        If the surface is no finite grid of at least 3 × 3, or a start or the goal is outside.

    Notes
    -----
    Steps go down the gradient of the bicubic surface. One that would not lower the value, or would leave the grid, is
    halved and tried again, so that a way ends within 1/1000 step of a minimum ("minimum") or of the edge ("edge")
    instead of swinging about it.
    """
    from insectnav.homing.descent_kernel import descend_all

    padded, spacing = _padded(surface), checked_spacing(spacing)
    places = _places("starts", starts, spacing, padded)
    target = np.full(2, np.nan) if goal is None else _places("goal", goal, spacing, padded, (2,))
    check_range("success_radius", success_radius, 0.0, np.inf, "m")
    step, max_steps = _checked_steps(step, max_steps, spacing, padded)
    flat = places.reshape(-1, 2)
    ends, outcomes, n_steps = np.empty(flat.shape), np.empty(len(flat), np.int64), np.empty(len(flat), np.int64)

    def run_task(first: int, last: int) -> None:
        radius = success_radius / spacing
        descend_all(first, last, padded, flat, *target, radius, step / spacing, max_steps, ends, outcomes, n_steps)

    run_blocks(run_task, len(flat), STARTS_PER_TASK, workers)
    shape = places.shape[:-1]
    return Descent((ends * spacing).reshape(places.shape), outcomes.reshape(shape)[()], n_steps.reshape(shape)[()])


def _checked_steps(step: float | None, max_steps: int | None, spacing: float, padded: Reals) -> tuple[float, int]:
    """Length of a step [m] and the most of them, as given or by default."""
    step = spacing / 4.0 if step is None else step
    check_range("step", step, 1e-3 * spacing, 10.0 * spacing, "m", "steps are of the order of the spacing")
    if max_steps is None:
        max_steps = int(20.0 * (padded.shape[0] + padded.shape[1]) * spacing / step)
    check_count("max_steps", max_steps)
    return step, max_steps


def _padded(surface: ArrayLike) -> Reals:
    """Surface with one more sample on each side, such that second differences go on."""
    values = np.asarray(as_numbers("surface", surface), float)
    check_shape("surface", values, ("rows", "columns"))
    if min(values.shape) < 3:
        raise InputError(f"surface has shape {values.shape}, expected at least 3 × 3 samples")
    check_finite("surface", values)
    for axis in (0, 1):
        f = np.moveaxis(values, axis, 0)
        before, after = 3.0 * (f[:1] - f[1:2]) + f[2:3], 3.0 * (f[-1:] - f[-2:-1]) + f[-3:-2]
        values = np.moveaxis(np.concatenate([before, f, after]), 0, axis)
    return np.ascontiguousarray(values)


def checked_spacing(spacing: float) -> float:
    """Spacing of a grid [m] as a float; refuses what is no positive length."""
    check_shape("spacing", as_numbers("spacing", spacing), ())
    check_range("spacing", spacing, 1e-9, 1e9, "m")
    return float(spacing)


def _places(name: str, positions: ArrayLike, spacing: float, padded: Reals, shape: Any = (..., 2)) -> Reals:
    """Positions in units of the grid, within it."""
    array = np.asarray(as_numbers(name, positions), float)
    check_shape(name, array, shape)
    check_finite(name, array)
    extent = np.array([padded.shape[1] - 3, padded.shape[0] - 3])
    places = array / spacing
    nearest = np.clip(places, 0.0, extent)
    places = np.where(np.abs(places - nearest) < ROUNDING * extent, nearest, places)
    for axis, letter in enumerate("xy"):
        check_range(f"{letter} of {name}", places[..., axis] * spacing, 0.0, extent[axis] * spacing, "m", OUTSIDE)
    return places
