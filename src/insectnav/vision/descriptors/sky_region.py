"""The one region of a mask that is the sky above the eye."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.vision.descriptors.brightness import as_views, brightness

Bools = NDArray[np.bool_]


def as_masks(masks: ArrayLike) -> Bools:
    """Masks (..., rows, columns) of bool: what is at least half as bright as can be is sky.

    Raises
    ------
    InputError
        If these are no views.
    """
    array = as_views(masks)
    return array if array.dtype.kind == "b" else np.asarray(brightness(array) >= 0.5)


def middle_region(mask: Bools) -> Bools:
    """The connected region nearest to the middle of a mask (rows, columns); nothing if there is none.

    Pixels that touch by a side or a corner are connected. Of regions equally near, the largest.

    Notes
    -----
    Stone, Mangan, Ardin & Webb, RSS 2014, section II-F, isolated the sky by tracing its boundary from the middle of the
    image. Holes stay holes here.
    """
    import cv2

    _, labels, statistics, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    row, column = (np.arange(n) - (n - 1) / 2.0 for n in mask.shape)
    squares = row[:, None] ** 2 + column**2
    squares[~mask] = np.inf
    nearest = squares.min()
    if not np.isfinite(nearest):
        return np.zeros(mask.shape, bool)
    candidates = np.unique(labels[squares <= nearest + 1e-9])
    areas: NDArray[Any] = statistics[candidates, cv2.CC_STAT_AREA]
    return np.asarray(labels == candidates[np.argmax(areas)])
