"""Pictures at another size, by Lanczos's window."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, quoted
from insectnav.vision.descriptors.brightness import as_views

Reals = NDArray[np.floating[Any]]
LOBES = 3  # of the window on each side


def check_size(name: str, size: tuple[int, int]) -> None:
    """Refuse anything but a pair of whole numbers of rows and columns."""
    if not isinstance(size, tuple | list) or len(size) != 2:
        raise InputError(f"{name} is {quoted(size)}, expected a pair of rows and columns")
    for part in size:
        check_count(name, part)


def resize(views: ArrayLike, size: tuple[int, int]) -> NDArray[Any]:
    """Views at the given size, (..., rows, columns), of the type given; integers are rounded, bits become bytes.

    Parameters
    ----------
    views : (..., rows, columns) array
    size : rows and columns wanted

    Raises
    ------
    InputError
        If these are no views, or the size is no pair of whole numbers.

    Notes
    -----
    Lanczos's window of three lobes, rows and columns apart, as wide as a pixel of the larger grid, so that nothing
    aliases when a view is made smaller; at the edges weights are scaled up to a sum of 1. The window is usual for
    SeqSLAM since OpenSeqSLAM.
    """
    check_size("size", size)
    array = as_views(views)
    if array.dtype.kind == "b":
        array = array.astype(np.uint8) * np.uint8(255)
    if array.shape[-2:] == tuple(size):
        return array
    rows, columns = (
        _weights(old, new).astype(array.dtype if array.dtype.kind == "f" else np.float64)
        for old, new in zip(array.shape[-2:], size, strict=True)
    )
    values = rows @ array @ columns.T
    if array.dtype.kind == "f":
        return np.asarray(values)
    return np.clip(np.floor(values + 0.5), 0, np.iinfo(array.dtype).max).astype(array.dtype)


@lru_cache(maxsize=16)
def _weights(n_old: int, n_new: int) -> Reals:
    """Share of each old pixel in each new one, (new, old)."""
    width = max(1.0, n_old / n_new)
    centre = (np.arange(n_new)[:, None] + 0.5) * n_old / n_new
    apart = (np.arange(n_old) + 0.5 - centre) / width
    window = np.where(np.abs(apart) < LOBES, np.sinc(apart) * np.sinc(apart / LOBES), 0.0)
    return np.asarray(window / window.sum(axis=1, keepdims=True))
