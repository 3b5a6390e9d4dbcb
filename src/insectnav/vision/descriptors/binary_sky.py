"""The shape of the sky in few bits."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import check_count
from insectnav.vision.descriptors.sky_region import as_masks, middle_region
from insectnav.vision.descriptors.wrapped_disk import wrap_to_disk

Bools = NDArray[np.bool_]
SIZE = 90  # [pixel] Stone, Mangan, Ardin & Webb, RSS 2014, section II-F


def binary_sky(masks: ArrayLike, size: int = SIZE, *, isolate: bool = True, centre: bool = True) -> Bools:
    """Sky or not in size × size pixels, the sky's centre of gravity in the middle, (..., size²) bool.

    Parameters
    ----------
    masks : (..., rows, columns) array
        Seen by an eye that looks up, True or bright where there is sky.
    size : int
        Rows and columns of the result.
    isolate : bool
        Keeps only the connected region nearest to the middle.
    centre : bool
        Shifts the centre of gravity to the middle of the image, to the nearest pixel, which takes out small tilts; what
        leaves the image is lost.

    Returns
    -------
    array of bool
        Compare by the number of bits that differ. All False where there is no sky.

    Raises
    ------
    InputError
        If these are no views.

    Notes
    -----
    Stone, Mangan, Ardin & Webb, RSS 2014, section II-F. A pixel of the result is sky if more than half of its area is.
    A tilt shifts a sky only near the zenith; for larger ones take `harmonic_amplitudes`.
    """
    check_count("size", size)
    array = as_masks(masks)
    stack = array.reshape(-1, *array.shape[-2:])
    bits = np.empty((len(stack), size * size), bool)
    for mask, out in zip(stack, bits, strict=True):
        region = middle_region(mask) if isolate else mask
        out[:] = _reduced(_centred(region) if centre else region, size).ravel()
    return bits.reshape(*array.shape[:-2], size * size)


def panorama_binary_sky(views: ArrayLike, size: int = SIZE) -> Bools:
    """`binary_sky` of panoramas, by way of `wrap_to_disk`, (..., size²) bool.

    Parameters
    ----------
    views : (..., rows, columns) array
        Panoramas up to the zenith, bright where there is sky.
    size : int
        Rows and columns of the result.

    Raises
    ------
    InputError
        As of `wrap_to_disk`.

    Notes
    -----
    The disk has the 210 pixels that `wrap_to_disk` gives it; a pixel at least half as bright as can be is sky.
    """
    return binary_sky(wrap_to_disk(views) >= 0.5, size)


def _centred(region: Bools) -> Bools:
    """The region moved by whole pixels, its centre of gravity as near to the middle as can be."""
    rows, columns = np.nonzero(region)
    out = np.zeros_like(region)
    if rows.size:
        # A shift by half a pixel goes the same way on either side of the middle, so that a mirrored sky is mirrored.
        down, right = (
            int(np.trunc((n - 1) / 2.0 - places.mean() + np.copysign(0.5, (n - 1) / 2.0 - places.mean())))
            for n, places in zip(region.shape, (rows, columns), strict=True)
        )
        rows, columns = rows + down, columns + right
        inside = (rows >= 0) & (rows < region.shape[0]) & (columns >= 0) & (columns < region.shape[1])
        out[rows[inside], columns[inside]] = True
    return out


def _reduced(region: Bools, size: int) -> Bools:
    import cv2

    share = cv2.resize(region.astype(np.float32), (size, size), interpolation=cv2.INTER_AREA)
    return np.asarray(share > 0.5)
