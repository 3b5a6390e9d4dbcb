"""The view itself as a descriptor: each pixel compared with the same pixel."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.vision.descriptors.brightness import brightness

Reals = NDArray[np.floating[Any]]


def retinotopic(views: ArrayLike) -> Reals:
    """Pixels of each view in one row, (..., rows · columns), over the square root of their number.

    Parameters
    ----------
    views : (..., rows, columns) array
        Bytes count as 0 to 1.

    Returns
    -------
    (..., rows · columns) array
        Of the precision of `brightness`; the distance of two of these is the root mean square pixel difference.

    Notes
    -----
    Zeil, Hofmann & Chahl 2003, J. Opt. Soc. Am. A 20(3):450, doi 10.1364/JOSAA.20.000450. Each pixel counts the same,
    as published, though those of a panorama near the zenith see less of the sky.
    """
    values = brightness(views)
    n_pixels = values.shape[-2] * values.shape[-1]
    scale = values.dtype.type(1.0 / np.sqrt(n_pixels))
    return np.asarray(values.reshape(*values.shape[:-2], n_pixels) * scale)
