"""The only heading convention.

A heading is in radians, clockwise from +y, wrapped to [-π, π). Its unit vector is
(sin θ, cos θ); a positive turn is to the right. All functions keep float32.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.floating[Any]]

FULL_TURN = 2 * np.pi  # [rad]


def wrap(angle: npt.ArrayLike) -> Floats:
    """Angle in [-π, π).

    Parameters
    ----------
    angle : (...) array [rad]

    Returns
    -------
    (...) array [rad]; an angle already in the interval comes back unchanged to the last bit
    """
    # fmod and both corrections are exact in floating point, so the interval is never left.
    rest = np.fmod(angle, FULL_TURN)
    rest = np.where(rest >= np.pi, rest - FULL_TURN, rest)
    return np.where(rest < -np.pi, rest + FULL_TURN, rest)[()]


def unit_vector(heading: npt.ArrayLike) -> Floats:
    """Vector (sin θ, cos θ) that points along a heading.

    Parameters
    ----------
    heading : (...) array [rad]

    Returns
    -------
    (..., 2) array of x, y
    """
    return np.stack([np.sin(heading), np.cos(heading)], axis=-1)


def bearing(vector: npt.ArrayLike) -> Floats:
    """Heading along which a vector points; 0 for the null vector.

    Parameters
    ----------
    vector : (..., 2) array of x, y, in any unit

    Returns
    -------
    (...) array [rad]
    """
    vector = np.asarray(vector) + 0.0  # no negative zeros, which would turn the null vector round
    return wrap(np.arctan2(vector[..., 0], vector[..., 1]))


def circular_mean(angles: npt.ArrayLike, axis: int = -1) -> Floats:
    """Direction of the mean unit vector; meaningless where the vectors cancel.

    Parameters
    ----------
    angles : (..., n) array [rad]
    axis : the axis of n, which is removed

    Returns
    -------
    (...) array [rad]
    """
    return wrap(np.arctan2(np.mean(np.sin(angles), axis), np.mean(np.cos(angles), axis)))


def circular_std(angles: npt.ArrayLike, axis: int = -1) -> Floats:
    """Circular standard deviation sqrt(-2 ln R), with R the length of the mean unit vector.

    Parameters
    ----------
    angles : (..., n) array [rad]
    axis : the axis of n, which is removed

    Returns
    -------
    (...) array [rad], from 0 for equal angles to infinity where the vectors cancel

    Notes
    -----
    Mardia, Statistics of Directional Data (1972), Academic Press, London; `sd.circular` in R.
    """
    length = np.hypot(np.mean(np.sin(angles), axis), np.mean(np.cos(angles), axis))
    with np.errstate(divide="ignore"):
        deviation: Floats = np.sqrt(np.maximum(-2 * np.log(length), 0))
    return deviation


def from_math(angle: npt.ArrayLike) -> Floats:
    """Heading of an angle that is anticlockwise from +x, as mathematics and most trackers have it.

    Parameters
    ----------
    angle : (...) array [rad], anticlockwise from +x

    Returns
    -------
    (...) array [rad], clockwise from +y
    """
    return wrap(np.pi / 2 - np.asarray(angle))


def to_math(heading: npt.ArrayLike) -> Floats:
    """Angle anticlockwise from +x of a heading: the inverse of `from_math`.

    Parameters
    ----------
    heading : (...) array [rad], clockwise from +y

    Returns
    -------
    (...) array [rad], anticlockwise from +x
    """
    return wrap(np.pi / 2 - np.asarray(heading))
