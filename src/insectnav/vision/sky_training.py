"""One threshold for all pictures, trained on some whose sky is known: for `segment(..., "fixed", threshold=...)`."""

from collections.abc import Iterable
from itertools import repeat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_range
from insectnav.vision.sky_channels import channel_name, checked_picture, full_scale, one_channel
from insectnav.vision.sky_geometry import checked_mask

N_VALUES = 1024  # steps from 0 to white in which a threshold is looked for

Counts = NDArray[np.int64]


def label_counts(
    image: ArrayLike, truth: ArrayLike, *, channels: str | None = None, valid: ArrayLike | None = None
) -> Counts:
    """Pixels of ground and of sky at each step of brightness, (2, step); add them up over pictures.

    Parameters
    ----------
    image : as for `segment`, of whole numbers, or of fractions of white
    truth : (rows, columns) array of bool, True for sky
    channels : one channel; None for the mean of all bands
    valid : (rows, columns) array of bool, False where the truth is unknown or the pixel shows nothing

    Raises
    ------
    InputError
        If sizes differ, or fractions exceed 1.
    """
    picture = checked_picture(image)
    if picture.dtype.kind == "f":
        check_range("image", picture.max(), 0.0, 1.0, slip="whole numbers that were made real?")
    values = one_channel(picture, channel_name(picture, channels, one=True))
    is_sky = checked_mask("truth", truth, values.shape)
    used = np.ones(values.shape, bool) if valid is None else checked_mask("valid", valid, values.shape)
    step = np.minimum(values.astype(np.float64) * (N_VALUES / full_scale(picture)), N_VALUES - 1).astype(np.int64)
    return np.stack([np.bincount(step[used & side], minlength=N_VALUES) for side in (~is_sky, is_sky)])


def best_threshold(counts: Counts) -> float:
    """The threshold, as a share of white, at which most pixels are labelled right; midway where several are as good.

    Raises
    ------
    InputError
        If there is only sky, or only ground.
    """
    ground, sky = counts
    if not ground.any() or not sky.any():
        raise InputError("the truths hold only one of sky and ground, expected both")
    n_right = np.cumsum(ground) + sky.sum() - np.cumsum(sky)  # with the threshold at the upper end of a step
    best = np.flatnonzero(n_right == n_right.max())
    return float((best[0] + best[-1]) / 2.0 + 1.0) / N_VALUES


def train_threshold(
    images: Iterable[ArrayLike],
    truths: Iterable[ArrayLike],
    *,
    channels: str | None = None,
    valid: Iterable[ArrayLike | None] | None = None,
) -> float:
    """The one threshold for all pictures that labels most of their pixels right, as a share of white.

    Parameters
    ----------
    images, truths, channels, valid : see `label_counts`, one for each picture

    Notes
    -----
    Sky is taken to be brighter. Multiply by 255 for pictures of bytes, by 65535 for those of 16 bits.
    """
    total = np.zeros((2, N_VALUES), np.int64)
    for image, truth, used in zip(images, truths, repeat(None) if valid is None else valid, strict=False):
        total += label_counts(image, truth, channels=channels, valid=used)
    return best_threshold(total)
