"""Catchment areas: from how far around does descent of a distance surface lead home."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import as_numbers, check_count, check_range, check_shape
from insectnav.homing.descent import OUTCOMES, checked_spacing, descend

Reals = NDArray[np.floating[Any]]


class Catchment(NamedTuple):
    """How much of the grid leads home."""

    area: float  # [m²]
    is_inside: NDArray[np.bool_]  # (y, x) for each start, as `cell_centres` orders them


def cell_centres(shape: tuple[int, int], spacing: float, starts_per_cell: int = 1) -> Reals:
    """Starts spread evenly over the cells of a grid, (y, x, 2) [m] of x, y.

    Parameters
    ----------
    shape : (rows, columns) of the samples
    spacing : float [m]
    starts_per_cell : int
        Along x and along y: 1 gives the centres, k gives k² starts in each cell.
    """
    check_count("starts_per_cell", starts_per_cell)
    y, x = ((np.arange((n - 1) * starts_per_cell) + 0.5) * spacing / starts_per_cell for n in shape)
    return np.stack(np.meshgrid(x, y), axis=-1)


def catchment_area(
    surface: ArrayLike,
    spacing: float,
    goal: ArrayLike,
    success_radius: float,
    *,
    step: float | None = None,
    starts_per_cell: int = 1,
    workers: int | None = None,
) -> Catchment:
    """Area [m²] of the grid from which steepest descent comes within the success radius of the goal, and the starts.

    Parameters
    ----------
    surface : (rows, columns) array
        Distances of the views, or of their descriptors, from the remembered one at the goal: sample [i, j] was taken at
        x = j · spacing, y = i · spacing.
    spacing : float [m]
    goal : (2,) array [m] of x, y
        From the first sample, as all positions here.
    success_radius : float [m]
        How near is home; at least a step.
    step : float [m]
        Length of a step of the descent; a quarter of the spacing if None.
    starts_per_cell : int
        Along x and y. More of them make the edge of the area finer, not the surface.
    workers : int
        Threads; as many as there are processors if None.

    Returns
    -------
    Catchment
        `area, is_inside = catchment_area(...)`. The area is the number of starts that come home, times the area that
        each stands for: the cells of the grid are cut into `starts_per_cell`² equal squares, a start is the centre of
        one. A grid that leads home from everywhere has the area of its outline.

    Raises
    ------
    InputError
        If the surface is no finite grid, the goal lies outside or the step is longer than the success radius.

    Notes
    -----
    Zeil, Hofmann & Chahl 2003, J. Opt. Soc. Am. A 20(3):450, doi 10.1364/JOSAA.20.000450; with bicubic interpolation,
    Stone et al. 2018, Interface Focus 8:20180010, doi 10.1098/rsfs.2018.0010. The area depends on the spacing, as finer
    grids show more local minima, and on the success radius: state both. Parts that are not connected to the goal's
    count too, if the way from them leads home.
    """
    samples, spacing = as_numbers("surface", surface), checked_spacing(spacing)
    check_shape("surface", samples, ("rows", "columns"))
    step = spacing / 4.0 if step is None else step
    check_range("success_radius", success_radius, step, np.inf, "m", "shorter than a step, which could pass over it")
    starts = cell_centres((samples.shape[0], samples.shape[1]), spacing, starts_per_cell)
    found = descend(samples, spacing, starts, goal, success_radius, step=step, workers=workers)
    is_inside = found.outcome == OUTCOMES.index("goal")
    return Catchment(float(is_inside.sum()) * (spacing / starts_per_cell) ** 2, is_inside)
