"""A strip of the view along the horizon, as Fourier coefficients."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, check_finite
from insectnav.vision.descriptors.brightness import as_views, describe_batches

Reals = NDArray[np.floating[Any]]


def frequency_strip(
    views: ArrayLike,
    n_frequencies: int = 16,
    *,
    strip_deg: tuple[float, float] = (-15.0, 15.0),
    elevation_deg: tuple[float, float] = (-15.0, 90.0),
    keep_phase: bool = False,
) -> Reals:
    """Amplitudes of the horizon's brightness at 0, 1, …, n frequencies around the circle, (..., n + 1).

    Parameters
    ----------
    views : (..., rows, columns) array
        Panoramas of 360°, the highest row first. Bytes count as 0 to 1.
    n_frequencies : int
        Highest number of cycles around the circle; less than half the number of columns.
    strip_deg : pair [°]
        Elevations between which the rows are averaged; a row belongs to it if its centre does.
    elevation_deg : pair [°]
        Elevations of the lower and upper edge of the views.
    keep_phase : bool
        Gives the coefficients themselves, (..., 2 n + 1): the mean, the n cosines and the n sines, for views that are
        aligned.

    Returns
    -------
    array of float64
        Scaled so that the distance of two vectors with phase is the root mean square difference of the two low-pass
        strips, and of two vectors without it the least that turning each frequency by itself could make of it.

    Raises
    ------
    InputError
        If there are too few columns for the frequencies or no row in the strip.

    Notes
    -----
    Stürzl & Mallot 2006, Robotics and Autonomous Systems 54(4):300, doi 10.1016/j.robot.2005.12.001, compress the ring
    of brightness along a robot's horizon to few Fourier coefficients; low ones reach far, high ones are precise.
    Without the phases the code does not depend on heading. The strip of ±15° about the horizon is our choice.
    """
    array = as_views(views)
    check_count("n_frequencies", n_frequencies, minimum=0)
    rows, columns = array.shape[-2:]
    if 2 * n_frequencies >= columns:
        raise InputError(f"n_frequencies is {n_frequencies}, expected less than half of the {columns} columns")
    rows_in_strip = _rows_in_strip(rows, strip_deg, elevation_deg)
    scale = np.full(n_frequencies + 1, np.sqrt(2.0))
    scale[0] = 1.0

    def describe(values: NDArray[np.float64]) -> Reals:
        coefficients = np.fft.rfft(values.mean(axis=1), axis=-1)[:, : n_frequencies + 1]
        coefficients *= scale / columns
        if not keep_phase:
            return np.abs(coefficients)
        return np.concatenate([coefficients.real, coefficients.imag[:, 1:]], axis=-1)

    return describe_batches(
        array[..., rows_in_strip, :], describe, 2 * n_frequencies + 1 if keep_phase else n_frequencies + 1
    )


def _rows_in_strip(rows: int, strip_deg: tuple[float, float], elevation_deg: tuple[float, float]) -> NDArray[np.int64]:
    check_finite("strip_deg", strip_deg)
    check_finite("elevation_deg", elevation_deg)
    low, high = elevation_deg
    centre = high - (np.arange(rows) + 0.5) * (high - low) / rows
    inside = np.flatnonzero((centre > strip_deg[0]) & (centre < strip_deg[1]))
    if not inside.size:
        raise InputError(
            f"strip_deg is {strip_deg[0]:g} to {strip_deg[1]:g}, expected some rows of views from {low:g}° to {high:g}°"
        )
    return inside
