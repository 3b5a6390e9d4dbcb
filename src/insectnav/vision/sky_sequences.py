"""Masks of a sequence: what moves fast is taken out by a vote over recent frames.

Proposed in the discussion of Stone, Mangan, Ardin & Webb (2014), RSS, doi 10.15607/RSS.2014.X.047: "smoothing over
recent frames to filter out fast moving shapes".
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count

Bools = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class RecentMasks:
    """The last masks of a sequence, oldest first, and how many of them say sky at each pixel."""

    masks: tuple[Bools, ...] = ()
    votes: NDArray[Any] | None = None


def smooth(recent: RecentMasks, mask: ArrayLike, n_frames: int) -> tuple[RecentMasks, Bools]:
    """The masks to go on with, and the majority of the last `n_frames` of them; the newest decides a draw.

    Parameters
    ----------
    recent : `RecentMasks()` at the start
    mask : (rows, columns) array of bool, the newest
    n_frames : how many frames vote; fewer at the start of the sequence

    Raises
    ------
    InputError
        If the mask has another size than those before it.
    """
    check_count("n_frames", n_frames)
    newest = np.asarray(mask, dtype=bool)
    if recent.masks and recent.masks[-1].shape != newest.shape:
        raise InputError(
            f"mask has shape {newest.shape}, expected {recent.masks[-1].shape} as the frames before it: another camera?"
        )
    votes = newest.astype(np.int32) if recent.votes is None else recent.votes + newest
    masks = (*recent.masks, newest)
    while len(masks) > n_frames:
        votes, masks = votes - masks[0], masks[1:]
    majority = np.where(2 * votes == len(masks), newest, 2 * votes > len(masks))
    return RecentMasks(masks=masks, votes=votes), majority


def smoothed(masks: Iterable[ArrayLike], n_frames: int) -> Iterator[Bools]:
    """Each mask of a sequence replaced by the majority of it and the frames before it; see `smooth`."""
    recent = RecentMasks()
    for mask in masks:
        recent, majority = smooth(recent, mask, n_frames)
        yield majority
