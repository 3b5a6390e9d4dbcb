"""Views as brightness from 0 to 1, whatever the type of their pixels."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_finite, check_shape

Reals = NDArray[np.floating[Any]]
PIXELS_AT_ONCE = 2500000  # of a batch: about 20 MB in double precision, of the order of a processor's cache


def brightness(views: ArrayLike) -> Reals:
    """Brightness of each pixel, in the shape given: floats as they are, integers over the largest of their type.

    Parameters
    ----------
    views : (..., rows, columns) array of bool, uint8, uint16, float32 or float64

    Returns
    -------
    (..., rows, columns) array
        float64 where float64 came, else float32.

    Raises
    ------
    InputError
        If the views are empty, not finite or of another type.
    """
    array = as_views(views)
    return array if array.dtype.kind == "f" else array.astype(np.float32) / np.float32(_white(array.dtype))


def as_views(views: ArrayLike) -> NDArray[Any]:
    """Views (..., rows, columns) as an array of the type given, checked as `brightness` says."""
    array = np.asarray(views)
    if array.dtype not in (np.bool_, np.uint8, np.uint16, np.float32, np.float64):
        raise InputError(
            f"views hold {array.dtype.name} values, expected floats, or integers of 8 or 16 bits as cameras give them"
        )
    check_shape("views", array, (..., "rows", "columns"))
    if 0 in array.shape[-2:]:
        raise InputError(f"views have shape {array.shape}, expected at least one pixel")
    if array.dtype.kind == "f":
        with np.errstate(invalid="ignore", over="ignore"):
            is_finite = bool(np.isfinite(np.sum(array)))
        if not is_finite:
            check_finite("views", array)
    return array


def _white(dtype: np.dtype[Any]) -> float:
    """The largest number of a type of whole numbers, or True."""
    return 1.0 if dtype.kind == "b" else float(np.iinfo(dtype).max)


def batches(views: NDArray[Any]) -> Iterator[tuple[slice, NDArray[np.float64]]]:
    """Slices of the views (n, rows, columns) and their brightness in double precision, a few views at a time."""
    size = max(1, PIXELS_AT_ONCE // max(1, views[:1].size))
    for first in range(0, len(views), size):
        piece = slice(first, min(first + size, len(views)))
        is_real = views.dtype.kind == "f"
        yield piece, views[piece].astype(np.float64, copy=False) if is_real else views[piece] / _white(views.dtype)


def describe_batches(
    views: ArrayLike, describe: Callable[[NDArray[np.float64]], NDArray[Any]], n_features: int, dtype: type = float
) -> NDArray[Any]:
    """Features (..., feature) of views (..., rows, columns), from a function of (n, rows, columns) in float64."""
    array = as_views(views)
    stack = array.reshape(-1, *array.shape[-2:])
    features: NDArray[Any] = np.empty((len(stack), n_features), dtype)
    for piece, values in batches(stack):
        features[piece] = describe(values)
    return features.reshape(*array.shape[:-2], n_features)
