"""Scores of masks against scikit-learn, SciPy, NumPy, closed forms and hand-made cases."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from sklearn.metrics import accuracy_score, jaccard_score

from insectnav.checks import InputError
from insectnav.metrics.segmentation import (
    accuracy,
    intersection_over_union,
    label_correlation,
    label_entropy,
    skyline,
    skyline_error,
)

MASKS = arrays(bool, (4, 5))


@given(mask=MASKS, truth=MASKS, valid=MASKS)
def test_accuracy_and_overlap_are_those_of_scikit_learn(mask, truth, valid):
    if not valid.any():
        assert np.isnan(accuracy(mask, truth, valid))
        return
    one, other = truth[valid], mask[valid]
    assert accuracy(mask, truth, valid) == pytest.approx(accuracy_score(one, other))
    expected = jaccard_score(one, other) if (one | other).any() else 1.0
    assert intersection_over_union(mask, truth, valid) == pytest.approx(expected)


def test_batch_is_as_one_by_one():
    rng = np.random.default_rng(0)
    masks, truth = rng.random((3, 6, 7)) < 0.5, rng.random((6, 7)) < 0.5
    for measure in (accuracy, intersection_over_union):
        assert_allclose(measure(masks, truth), [measure(mask, truth) for mask in masks])


def above(row: int, rows: int = 20, columns: int = 12) -> np.ndarray:
    return np.repeat(np.arange(rows)[:, None] < row, columns, axis=1)


@pytest.mark.parametrize("shift", [0, 1, 3, 7])
def test_straight_skyline_is_off_by_its_shift(shift):
    assert skyline_error(above(5), above(5 + shift)) == pytest.approx(shift)
    assert skyline_error(above(5).T, above(5 + shift).T) == pytest.approx(shift)


@given(mask=MASKS, truth=MASKS)
def test_skyline_error_is_symmetric_and_zero_for_itself(mask, truth):
    assert skyline_error(mask, truth) == skyline_error(truth, mask)
    assert skyline_error(mask, mask) == 0.0
    assert skyline_error(~mask, ~truth) == skyline_error(mask, truth)


def test_skyline_error_by_hand():
    mask, truth = np.zeros((2, 5, 9), bool)
    mask[2, 2], truth[2, 5] = True, True  # two single pixels, each with four sides
    sides = np.array([[0, -0.5], [0, 0.5], [-0.5, 0], [0.5, 0]])
    to_left = [np.hypot(*(side + np.array([0, 3]) - sides).T).min() for side in sides]
    to_right = [np.hypot(*(side - np.array([0, 3]) - sides).T).min() for side in sides]
    assert skyline_error(mask, truth) == pytest.approx(np.mean(to_left + to_right))
    assert len(skyline(mask)) == 4


def test_a_side_of_the_skyline_counts_if_both_its_pixels_do():
    for row in (4, 5):  # the last of the sky, the first of the ground
        valid = np.ones((20, 12), bool)
        valid[row] = False
        assert len(skyline(above(5), valid)) == 0
    for column in (4, 5):
        valid = np.ones((12, 20), bool)
        valid[:, column] = False
        assert len(skyline(above(5).T, valid)) == 0


def test_skyline_that_is_missing():
    nothing = np.zeros((5, 5), bool)
    assert skyline_error(nothing, nothing) == 0.0
    assert skyline_error(nothing, above(2, 5, 5)) == np.inf


def test_skyline_ends_where_pixels_do_not_count():
    valid = np.ones((20, 12), bool)
    valid[:, 6:] = False
    assert len(skyline(above(5), valid)) == 6
    mixed = above(5)
    mixed[:, 6:] = above(15)[:, 6:]
    assert skyline_error(mixed, above(5), valid) == 0.0


@pytest.mark.parametrize(("n_sky", "bits"), [(0, 0.0), (1, 0.811278), (2, 1.0), (3, 0.811278), (4, 0.0)])
def test_entropy_in_closed_form(n_sky, bits):
    masks = np.arange(4)[:, None, None] < np.full((2, 3), n_sky)
    assert_allclose(label_entropy(masks), bits, atol=1e-6)  # H2(1/4) = 2 − 3/4 log2 3


def test_correlation_is_that_of_numpy():
    masks = np.random.default_rng(1).random((5, 8, 9)) < 0.4
    assert_allclose(label_correlation(masks), np.corrcoef(masks.reshape(5, -1).astype(float)), atol=1e-6)
    both = label_correlation(np.stack([masks[0], ~masks[0], np.ones((8, 9), bool)]))
    assert both[0, 1] == pytest.approx(-1.0)
    assert np.isnan(both[2]).all()


@given(st.sampled_from([accuracy, intersection_over_union, skyline_error]))
def test_what_are_no_two_masks_is_refused(measure):
    mask = np.ones((4, 5), bool)
    with pytest.raises(InputError, match="resized"):
        measure(mask, np.ones((5, 4), bool))
    with pytest.raises(InputError, match="compare with 0 first"):
        measure(mask, np.ones((4, 5), np.uint8))
    with pytest.raises(InputError, match=r"expected \(rows, columns\)"):
        measure(mask[0], mask[0])


def test_time_lapse_needs_frames():
    for measure in (label_entropy, label_correlation):
        with pytest.raises(InputError, match="frame, rows, columns"):
            measure(np.ones((4, 5), bool))
