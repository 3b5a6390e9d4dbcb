"""The average landmark vector: a place remembered as one arrow."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import unit_vector
from insectnav.checks import InputError, check_finite, check_radians, check_shape

Reals = NDArray[np.floating[Any]]


def average_landmark_vector(landmarks: ArrayLike, heading: ArrayLike = 0.0) -> Reals:
    """Mean of the unit vectors towards all that is landmark, (..., 2): x, y in the world; NaN where there is none.

    Parameters
    ----------
    landmarks : (..., rows, columns) array of bool
        Which pixels of a panorama of 360° are landmark, the middle column straight ahead: objects seen against the sky,
        or edges. All rows count the same; a skyline or a ring of one row will do.
    heading : (...) array [rad]
        Of the animal, by its compass, one for each mask or one for all: landmark vectors compare only in the frame of
        the world.

    Returns
    -------
    (..., 2) array

    Raises
    ------
    InputError
        If the landmarks are not a mask, or there is not a heading for each.

    Notes
    -----
    Lambrinos, Möller, Labhart, Pfeifer & Wehner 2000, Robotics and Autonomous Systems 30(1-2):39, doi
    10.1016/S0921-8890(99)00064-0.
    """
    mask, angle = np.asarray(landmarks), np.asarray(heading, float)
    if mask.dtype != np.bool_:
        raise InputError(f"landmarks hold {mask.dtype.name} values, expected a mask of true and false")
    check_shape("landmarks", mask, (..., "rows", "columns"))
    check_finite("heading", angle)
    check_radians("heading", angle)
    if angle.ndim:
        check_shape("heading", angle, mask.shape[:-2])
    columns = mask.shape[-1]
    count = mask.sum(axis=-2).astype(float)
    azimuth = (np.arange(columns) + 0.5) * 2.0 * np.pi / columns - np.pi + angle[..., None]
    total = count.sum(axis=-1)[..., None]
    return (count[..., None, :] @ unit_vector(azimuth))[..., 0, :] / np.where(total > 0.0, total, np.nan)


def landmark_home_vector(current: ArrayLike, remembered: ArrayLike) -> Reals:
    """Vector that points home, (..., 2): the average landmark vector here less the one remembered from there.

    Parameters
    ----------
    current, remembered : (..., 2) arrays
        From `average_landmark_vector`.

    Notes
    -----
    Lambrinos et al. 2000. Its length is no distance. An average landmark vector is, but for its sign, the slope of the
    mean distance to the landmarks, a convex function of place: where the same points are seen from both places, this
    vector never points more than 90° away from home.
    """
    difference: Reals = np.asarray(current, float) - np.asarray(remembered, float)
    return difference
