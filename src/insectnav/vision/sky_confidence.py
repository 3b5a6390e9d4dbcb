"""How far a mask of the sky is to be trusted, from the mask, the picture and the geometry alone.

Four things tell a mask from a random or arbitrary one: sky lies above ground; both hang together; the picture changes
across the skyline; and there is some of either. Each is a number from 0 to 1, and the confidence is their product.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.vision.sky_levels import LEFT_OUT
from insectnav.vision.sky_thresholds import N_LEVELS

Bools = NDArray[np.bool_]

SURE_ODDS = 0.75  # chance that sky is above ground from which on geometry leaves no doubt; assumed, as the next two
SURE_STEP = 0.5  # change across the skyline, as a share of the difference of the means, from which on it is an edge
SURE_SHARE = 0.01  # of the picture that sky and ground must each fill; less may be a speck
ENOUGH_PIXELS = 500_000  # of larger pictures every so many rows and columns are looked at
DOUBTFUL = 0.5  # a confidence below is worth a look; assumed


class Confidence(NamedTuple):
    """The confidence in a mask and what it is the product of."""

    total: float
    geometry: float
    coherence: float
    edge: float
    balance: float


def confidence(values: NDArray[Any], mask: Bools, levels: NDArray[np.uint8]) -> Confidence:
    """Confidence in a mask.

    Parameters
    ----------
    values : (rows, columns) array, the brightness of the picture
    mask : (rows, columns) array of bool, True for sky
    levels : (rows, columns) array of uint8, elevation levels, `LEFT_OUT` where a pixel does not count

    Notes
    -----
    With S the pixels of sky, geometry is (P − 1/2) / (3/4 − 1/2) within 0…1, where P is the chance that a pixel of sky
    lies above one of ground, a draw counting half. Coherence is |S opened by 3 × 3| / |S closed by 3 × 3|. Edge is the
    mean change of brightness across the skyline over half the difference of the means of sky and ground, at most 1 at
    each place. Balance is the share of the smaller of both over 1 %, at most 1.
    """
    from insectnav.vision.sky_histogram_kernel import steps_across, sum_classes

    stride = math.ceil(math.sqrt(mask.size / ENOUGH_PIXELS))
    if stride > 1:
        values, mask, levels = (np.ascontiguousarray(one[::stride, ::stride]) for one in (values, mask, levels))
    of_ground, of_sky = by_level = np.zeros((2, N_LEVELS), np.int64)
    ground_sum, sky_sum = sum_classes(values.ravel(), levels.ravel(), mask.ravel(), by_level)
    n_sky, n_ground = int(of_sky.sum()), int(of_ground.sum())
    balance = min(1.0, min(n_sky, n_ground) / (n_sky + n_ground) / SURE_SHARE)
    if not balance:
        return Confidence(0.0, 0.0, 0.0, 0.0, 0.0)
    geometry = (chance_of_being_higher(of_sky, of_ground) - 0.5) / (SURE_ODDS - 0.5)
    geometry = min(max(geometry, 0.0), 1.0)
    difference = abs(sky_sum / n_sky - ground_sum / n_ground)
    edge, _ = steps_across(values, levels, mask, max(difference, 1e-12) * SURE_STEP)
    edge = min(1.0, edge)
    coherence = _coherence(mask, levels != LEFT_OUT)
    return Confidence(geometry * coherence * edge * balance, geometry, coherence, edge, balance)


def _coherence(mask: Bools, counts: Bools) -> float:
    import cv2

    square, picture = np.ones((3, 3), np.uint8), mask.view(np.uint8)
    opened = cv2.morphologyEx(picture, cv2.MORPH_OPEN, square).view(np.bool_)
    closed = cv2.morphologyEx(picture, cv2.MORPH_CLOSE, square).view(np.bool_)
    n_closed = np.count_nonzero(closed & counts)
    return float(np.count_nonzero(opened & counts) / n_closed) if n_closed else 0.0


def chance_of_being_higher(one: NDArray[np.int64], other: NDArray[np.int64]) -> float:
    """Chance that a pixel of one class is above a pixel of the other, a draw counting half; 1/2 if a class is empty.

    Parameters
    ----------
    one, other : (level,) arrays, pixels of each class by elevation level
    """
    pairs = float(one.sum()) * float(other.sum())
    if not pairs:
        return 0.5
    below = np.cumsum(other) - other / 2.0
    return float((one * below).sum() / pairs)
