"""Patch-normalised grey: what SeqSLAM compares, blind to the light that falls on each part of a view."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, check_range
from insectnav.vision.descriptors.brightness import as_views
from insectnav.vision.descriptors.lanczos import resize

SIZE = (32, 64)  # [pixel] rows and columns, OpenSeqSLAM
PATCH = 8  # [pixel] OpenSeqSLAM
NEUTRAL = 127  # what a pixel of mean brightness becomes
NOTHING = 0  # what a patch without contrast becomes in OpenSeqSLAM v1, as dark as can be


def patch_normalised(
    views: ArrayLike,
    *,
    size: tuple[int, int] | None = SIZE,
    patch_px: int = PATCH,
    rounded: bool = False,
    flat_patch: int = NEUTRAL,
) -> NDArray[Any]:
    """Pixels as deviations from the mean of their patch, over its standard deviation, (..., rows · columns).

    Parameters
    ----------
    views : (..., rows, columns) array
        Grey pictures or panoramas of any type of pixel.
    size : pair of rows and columns [pixel]
        To which views are brought first, by `lanczos.resize`; None to leave them.
    patch_px : int
        Side of the square patches, which must fill the picture.
    rounded : bool
        Gives bytes, 127 + the deviation rounded to a whole number, as published code does. It throws away most of what
        is there: deviations are within ±3 as a rule.
    flat_patch : int
        Byte of the pixels of a patch without contrast, if rounded: 127 is neutral, OpenSeqSLAM v1 has 0. Not rounded,
        such pixels are 0, neutral.

    Returns
    -------
    array of float32, or of uint8 if rounded

    Raises
    ------
    InputError
        If these are no views, or the patches do not fill them.

    Notes
    -----
    Milford & Wyeth, ICRA 2012, doi 10.1109/ICRA.2012.6224623; the bytes are those of OpenSeqSLAM v1 (Sünderhauf,
    Neubert & Protzel 2013), standard deviation over n − 1, halves rounded away from 0. There a patch without contrast,
    such as clear sky or snow, becomes 0 and lies 127 from all others, and so outweighs all that can be seen.
    """
    check_count("patch_px", patch_px, minimum=2)
    check_range("flat_patch", flat_patch, 0, 255)
    array = as_views(views) if size is None else resize(views, size)
    rows, columns = array.shape[-2:]
    if rows % patch_px or columns % patch_px:
        raise InputError(
            f"views of {rows} × {columns} pixels cannot be filled with patches of {patch_px} × {patch_px}, "
            "expected whole multiples"
        )
    stack = np.ascontiguousarray(array.reshape(-1, rows, columns))
    if stack.dtype != np.uint8:  # one kernel for bytes, one for all else
        stack = stack.astype(np.float64)
    return _deviations(stack, patch_px, rounded, flat_patch).reshape(*array.shape[:-2], rows * columns)


def _deviations(stack: NDArray[Any], patch_px: int, rounded: bool, flat_patch: int) -> NDArray[Any]:
    from insectnav.vision.descriptors.patch_kernel import normalise_patches, normalise_patches_to_bytes

    if rounded:
        whole = np.empty(stack.shape, np.uint8)
        normalise_patches_to_bytes(stack, patch_px, flat_patch, whole)
        return whole
    deviations = np.empty(stack.shape, np.float32)
    normalise_patches(stack, patch_px, deviations)
    return deviations
