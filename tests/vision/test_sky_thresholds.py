"""Thresholds of histograms against OpenCV, plain implementations that try everything, and closed forms."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from insectnav.vision.sky_histogram_kernel import persistent_valley
from insectnav.vision.sky_thresholds import (
    LEFT_OUT,
    N_LEVELS,
    histogram,
    otsu,
    upper_of_three_classes,
    watershed_islands,
    watershed_merge,
)

WIDE = arrays(np.uint8, (7, 9), elements=st.integers(0, 255))


def level(shape: tuple) -> np.ndarray:
    return np.zeros(shape, np.uint8)


def of(values: np.ndarray, zoom: bool = False):
    return histogram(values, level(values.shape), zoom=zoom)


def mixture(*parts: tuple[float, float, int], seed: int = 0) -> np.ndarray:
    """Normal values of (mean, SD, number) as one row of float32."""
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.normal(mean, sd, n) for mean, sd, n in parts]).astype(np.float32)[None]


def between_classes(values: np.ndarray, thresholds: tuple) -> float:
    """Variance between the classes that thresholds divide values into, from the values themselves."""
    which = np.digitize(values, thresholds)
    return sum((which == k).mean() * (values[which == k].mean() - values.mean()) ** 2 for k in np.unique(which))


@settings(deadline=None)
@given(values=WIDE)
def test_otsu_divides_bytes_as_opencv_does(values):
    if np.ptp(values) == 0:
        assert of(values) is None
        return
    theirs, _ = cv2.threshold(values, 0, 255, cv2.THRESH_OTSU)
    ours = otsu(of(values))
    best = max(between_classes(values, (t + 0.5,)) for t in np.unique(values)[:-1])
    assert between_classes(values, (ours,)) == pytest.approx(best, rel=1e-9)
    assert between_classes(values, (theirs + 0.5,)) == pytest.approx(best, rel=1e-4)  # theirs in single precision


def test_otsu_between_two_values_is_their_middle():
    values = np.where(np.arange(100) < 30, 40, 201).astype(np.uint8)[None]
    assert otsu(of(values)) == pytest.approx(120.5)  # 120 and 121 serve alike


@settings(deadline=None)
@given(values=arrays(np.uint8, (5, 6), elements=st.integers(0, 11)))
def test_upper_threshold_of_three_classes_is_that_of_all_pairs_tried(values):
    occurring = np.unique(values)
    if len(occurring) < 4:
        return
    pairs = [(a + 0.5, b + 0.5) for a in occurring for b in occurring if a < b]
    best = max(between_classes(values, pair) for pair in pairs)
    ours = upper_of_three_classes(of(values), int(np.ptp(values)) + 1)  # a bin for each value
    reached = max(between_classes(values, (low + 0.5, ours)) for low in occurring if low + 0.5 < ours)
    assert reached == pytest.approx(best, rel=1e-9)


def test_upper_threshold_leaves_the_brightest_of_three_peaks_alone():
    values = mixture((40, 5, 3000), (120, 5, 3000), (220, 5, 3000))
    assert 140 < upper_of_three_classes(of(values)) < 200


def merged_by_hand(heights: np.ndarray) -> int:
    """Merge the shallowest valley, measured from the lower of its two peaks, until one is left."""
    turns = [k for k in range(len(heights)) if is_peak(heights, k)]
    if len(turns) < 2:
        return -1
    peaks = list(turns)
    valleys = [a + int(np.argmin(heights[a:b])) for a, b in pairwise(peaks)]
    while len(valleys) > 1:
        depth = [min(heights[peaks[k]], heights[peaks[k + 1]]) - heights[v] for k, v in enumerate(valleys)]
        k = int(np.argmin(depth))
        valleys.pop(k)
        peaks.pop(k if heights[peaks[k]] < heights[peaks[k + 1]] else k + 1)
    return valleys[0]


def is_peak(heights: np.ndarray, k: int) -> bool:
    around = [heights[j] for j in (k - 1, k + 1) if 0 <= j < len(heights)]
    return all(heights[k] > one for one in around)


@settings(deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_valley_is_what_merging_the_shallowest_leaves(seed):
    heights = np.random.default_rng(seed).random(30)
    order = np.argsort(-heights)
    found = persistent_valley(heights, order, np.empty(30, np.int64), np.empty(30))
    assert found == merged_by_hand(heights)


@pytest.mark.parametrize("method", [watershed_merge, watershed_islands])
def test_watershed_finds_the_valley_between_ground_and_sky(method):
    values = mixture((60, 10, 20000), (160, 12, 10000))
    assert 85 < method(of(values)) < 130


def test_watershed_is_robust_to_the_sun_where_otsu_is_not():
    values = mixture((60, 8, 12000), (130, 8, 6000), (2000, 20, 300))  # the last 1.6 %: the sun
    assert 80 < watershed_merge(of(values, zoom=True)) < 110
    assert otsu(of(values)) > 130


def test_one_peak_has_no_valley():
    triangle = np.random.default_rng(0).triangular(20, 60, 100, (1, 50000)).astype(np.float32)
    assert watershed_merge(of(triangle)) is None


@settings(deadline=None)
@given(scale=st.floats(1e-3, 1e3), shift=st.floats(0, 100))
def test_thresholds_follow_the_unit_of_the_picture(scale, shift):
    values = mixture((60, 10, 4000), (160, 12, 3000))
    for method in (otsu, watershed_merge, upper_of_three_classes):
        changed = method(of((values * scale + shift * scale).astype(np.float32)))
        assert changed == pytest.approx((method(of(values)) + shift) * scale, rel=0.02)


def test_pixels_left_out_have_no_part():
    values = np.where(np.arange(100) < 50, 40, 200).astype(np.uint8)[None]
    polluted = np.concatenate([values, np.full((1, 100), 255, np.uint8)])
    levels = level(polluted.shape)
    levels[1] = LEFT_OUT
    assert otsu(histogram(polluted, levels)) == otsu(of(values))
    single = polluted.astype(np.float32) / 7
    assert otsu(histogram(single, levels)) == pytest.approx(otsu(of(values.astype(np.float32) / 7)))


def test_histogram_counts_each_pixel_once_at_its_level():
    rng = np.random.default_rng(3)
    values = rng.uniform(0, 5, (40, 50)).astype(np.float32)
    levels = rng.integers(0, N_LEVELS, values.shape).astype(np.uint8)
    levels[:5] = LEFT_OUT
    found = histogram(values, levels)
    assert found.counts.sum(axis=1).tolist() == np.bincount(levels[5:].ravel(), minlength=N_LEVELS).tolist()
    place = np.floor((values[levels == 7] - found.low) / found.width)
    theirs = np.bincount(np.clip(place, 0, 1023).astype(int), minlength=1024)
    assert np.abs(found.counts[7] - theirs).sum() <= 2  # a value on an edge may fall to either side
