"""Pictures moved onto the pixels of others, and how much the ones then tell of the others."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Reals = NDArray[np.floating[Any]]
MOST_COUNTED = 250_000  # pixels in a joint histogram
EDGE = 1e-6  # [pixel] of rounding at the edge of a picture


def warp(moving: ArrayLike, matrix: ArrayLike, shape: tuple[int, ...]) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """A picture on other pixels, linearly interpolated, in its own type, and where it shows something.

    Parameters
    ----------
    moving : (rows, columns) or (rows, columns, band) array
    matrix : (2, 3) array
        From the result to the picture, as of `insectnav.vision.registration.Alignment`.
    shape : rows and columns of the result
    """
    array = np.asarray(moving)
    places, valid = _places(np.asarray(matrix, float), shape, array.shape)
    bands = array.reshape(*array.shape[:2], -1)
    found = np.empty((*shape, bands.shape[2]), array.dtype)
    for band in range(bands.shape[2]):
        values = _interpolated(bands[..., band], places)
        found[..., band] = np.where(valid, values if array.dtype.kind == "f" else np.rint(values), 0)
    return found.reshape(*shape, *array.shape[2:]), valid


def mutual_information(fixed: Reals, moving: Reals, matrix: Reals, n_bins: int) -> float:
    """Mutual information [nat] of the joint histogram of pixels that both show, a quarter of a million at most.

    Parameters
    ----------
    fixed, moving : (rows, columns) arrays in 0…1
    matrix : (2, 3) array
        From fixed to moving, as of `insectnav.vision.registration.Alignment`.
    n_bins : of each picture's brightness
    """
    stride = int(np.ceil(np.sqrt(fixed.size / MOST_COUNTED)))
    places, valid = _places(matrix, fixed.shape, moving.shape, stride)
    if not valid.any():
        return 0.0
    pair = fixed[stride // 2 :: stride, stride // 2 :: stride][valid], _interpolated(moving, places)[valid]
    joint = np.histogram2d(*pair, bins=n_bins, range=((0, 1), (0, 1)))[0]
    joint /= joint.sum()
    apart = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
    return float((joint[joint > 0] * np.log(joint[joint > 0] / apart[joint > 0])).sum())


def _places(
    matrix: Reals, shape: tuple[int, ...], moving_shape: tuple[int, ...], stride: int = 1
) -> tuple[Reals, NDArray[np.bool_]]:
    """Rows and columns in the moving picture of each pixel of the fixed one, and which are within it."""
    row = (np.arange(stride // 2, shape[0], stride) + 0.5)[:, None]
    column = np.arange(stride // 2, shape[1], stride) + 0.5
    x = matrix[0, 0] * column + matrix[0, 1] * row + matrix[0, 2] - 0.5
    y = matrix[1, 0] * column + matrix[1, 1] * row + matrix[1, 2] - 0.5
    last_row, last_column = moving_shape[0] - 1, moving_shape[1] - 1
    valid = (x >= -EDGE) & (x <= last_column + EDGE) & (y >= -EDGE) & (y <= last_row + EDGE)
    return np.stack([np.clip(y, 0, last_row), np.clip(x, 0, last_column)]), valid


def _interpolated(picture: NDArray[Any], places: Reals) -> Reals:
    from scipy.ndimage import map_coordinates

    exact = np.float32 if np.can_cast(picture.dtype, np.float32) else np.float64
    return np.asarray(map_coordinates(picture.astype(exact), places, np.float64, order=1, mode="nearest"))
