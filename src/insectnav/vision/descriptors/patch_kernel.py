"""Patches of pictures less their mean, over their standard deviation, compiled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.lanes.compiled import kernel, lane_function

Array = NDArray[Any]
FLAT = 1e-9  # of its mean: a patch with less deviation than that holds rounding alone


@lane_function
def share_within_patches(sums: Array, side: int) -> None:
    """Put in each column the sum over all columns of its patch."""
    for left in range(0, len(sums), side):
        total = 0.0
        for j in range(left, left + side):
            total += sums[j]
        sums[left : left + side] = total


@lane_function
def scale_strip(image: Array, top: int, side: int, strip: Array, mean: Array, deviation: Array) -> None:
    """Fill a strip of patches (side, columns) with scaled deviations; 0, and deviation 0, where a patch is flat."""
    columns = strip.shape[1]
    mean[:] = 0.0
    for i in range(side):
        for j in range(columns):
            strip[i, j] = image[top + i, j]
            mean[j] += strip[i, j]
    share_within_patches(mean, side)
    deviation[:] = 0.0
    for j in range(columns):
        mean[j] /= side * side
    for i in range(side):
        for j in range(columns):
            strip[i, j] -= mean[j]
            deviation[j] += strip[i, j] * strip[i, j]
    share_within_patches(deviation, side)
    for j in range(columns):
        root = np.sqrt(deviation[j] / (side * side - 1))
        deviation[j] = root if root > FLAT * abs(mean[j]) else 0.0
    for i in range(side):
        for j in range(columns):
            strip[i, j] = strip[i, j] / deviation[j] if deviation[j] > 0.0 else 0.0


@kernel
def normalise_patches(images: Array, side: int, out: Array) -> None:
    """Fill ``out`` with the scaled deviations of each patch from its mean; 0 where there are none."""
    columns = images.shape[2]
    strip, mean, deviation = np.empty((side, columns)), np.empty(columns), np.empty(columns)
    for k in range(len(images)):
        for top in range(0, images.shape[1], side):
            scale_strip(images[k], top, side, strip, mean, deviation)
            for i in range(side):
                for j in range(columns):
                    out[k, top + i, j] = strip[i, j]


@kernel
def normalise_patches_to_bytes(images: Array, side: int, flat_patch: int, out: Array) -> None:
    """Fill ``out`` with 127 + the scaled deviations, halves rounded away from 127; ``flat_patch`` where none."""
    columns = images.shape[2]
    strip, mean, deviation = np.empty((side, columns)), np.empty(columns), np.empty(columns)
    for k in range(len(images)):
        for top in range(0, images.shape[1], side):
            scale_strip(images[k], top, side, strip, mean, deviation)
            for i in range(side):
                for j in range(columns):
                    whole = np.trunc(strip[i, j] + np.copysign(0.5, strip[i, j]))
                    out[k, top + i, j] = min(max(127.0 + whole, 0.0), 255.0) if deviation[j] > 0.0 else flat_patch
