"""The true match of a query: the nearest place within the tolerance, or between key frames."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.metrics.place_truth import true_matches_by_frames, true_matches_by_position
from insectnav.metrics.retrieval import precision_recall, right_matches


def test_nearest_reference_within_the_tolerance():
    reference = np.array([(0, 0), (10, 0), (np.nan, 0), (20, 0)])
    query = np.array([(1, 0), (6, 0), (14, 3), (20, 4), (np.nan, np.nan), (90, 0)])
    truth = true_matches_by_position(reference, query, tolerance_m=5.0)
    np.testing.assert_array_equal(truth.reference, [0, 1, 1, 3, np.nan, np.nan])
    np.testing.assert_array_equal(truth.can_be_matched, [True, True, True, True, False, False])
    np.testing.assert_array_equal(truth.is_known, [True, True, True, True, False, True])


def test_tolerance_includes_its_end():
    truth = true_matches_by_position([(0.0, 0.0, 0.0)], [(3.0, 4.0, 0.0)], 5.0)
    assert truth.reference == 0
    assert not true_matches_by_position([(0.0, 0.0, 0.0)], [(3.0, 4.0, 1.0)], 5.0).can_be_matched


def test_tolerance_includes_its_end_whatever_the_rounding():
    place = np.array([(0.0, float(f"5600000.{k}") if k < 10 else 5600001.0) for k in range(11)])  # every 10 cm
    apart = true_matches_by_position(place[:1], place[3:], 1.0)
    assert apart.can_be_matched.all()
    for steps in range(1, 8):
        for k in range(len(place) - steps):
            ends = place[[k]], place[[k + steps]]
            assert true_matches_by_position(*ends, float(f"0.{steps}")).can_be_matched
            assert not true_matches_by_position(*ends, float(f"0.{steps}") - 1e-6).can_be_matched


places = st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=1, max_size=20).map(np.array)


@settings(max_examples=100, deadline=None)
@given(places, places, st.floats(0, 50))
def test_agrees_with_all_distances(query: np.ndarray, reference: np.ndarray, tolerance: float):
    truth = true_matches_by_position(reference, query, tolerance)
    apart = np.linalg.norm(query[:, None] - reference, axis=-1)
    margin = 1e-9
    near, far = apart.min(axis=1) < tolerance - margin, apart.min(axis=1) > tolerance + margin
    assert truth.can_be_matched[near].all() and not truth.can_be_matched[far].any()
    rows = np.flatnonzero(truth.can_be_matched)
    np.testing.assert_allclose(apart[rows, truth.reference[rows].astype(int)], apart.min(axis=1)[rows], atol=margin)


@pytest.mark.parametrize(
    ("query", "reference", "tolerance", "says"),
    [
        ([(0, 0)], [(0, 0, 0)], 1.0, "reference_position has shape"),
        ([(0, 0)], [(np.nan, 0)], 1.0, "no reference has a position"),
        ([(0, 0)], [(0, 0)], -1.0, "tolerance"),
        ([(0,)], [(0,)], 1.0, "number of coordinates"),
    ],
)
def test_positions_that_cannot_be_compared_are_refused(query: list, reference: list, tolerance: float, says: str):
    with pytest.raises(InputError, match=says):
        true_matches_by_position(reference, query, tolerance)


def test_frames_between_key_frames_are_interpolated():
    # The other recording stood still over ten frames, then went at half the pace.
    truth = true_matches_by_frames([(10, 100), (20, 100), (40, 110)], [5, 10, 15, 20, 22, 40, 41])
    np.testing.assert_array_equal(truth.reference, [np.nan, 100, 100, 100, 101, 110, np.nan])
    np.testing.assert_array_equal(truth.is_known, [False, True, True, True, True, True, False])
    np.testing.assert_array_equal(truth.can_be_matched, truth.is_known)


def test_whole_frames_between_key_frames_are_whole():
    for last in range(2, 200):
        query = np.arange(last + 1)
        truth = true_matches_by_frames([(0, 7), (last, 7 + 3 * last)], query)
        np.testing.assert_array_equal(truth.reference, 7 + 3 * query)


def test_detour_that_is_not_in_the_map():
    truth = true_matches_by_frames([(0, 0), (10, 10), (20, np.nan), (30, 20), (40, 30)], [9, 10, 11, 20, 29, 30, 35])
    np.testing.assert_array_equal(truth.reference, [9, 10, np.nan, np.nan, np.nan, 20, 25])
    assert truth.is_known.all()
    np.testing.assert_array_equal(truth.can_be_matched, np.isfinite(truth.reference))


def test_numbers_of_frames_become_numbers_of_references():
    kept = [100, 110, 130]  # frames of which the map was made
    truth = true_matches_by_frames([(0, 100), (30, 130)], [0, 5, 10, 20, 30], reference_frame=kept)
    np.testing.assert_allclose(truth.reference, [0, 0.5, 1, 1.5, 2])  # of frames 100, 105, 110, 120, 130


def test_key_frames_are_joined_on_the_clock_of_the_references_however_densely_these_were_chosen():
    """Half way between key frames 0 and 100 is frame 50, which is reference 5, not the third of six steps."""
    truth = true_matches_by_frames([(0, 0), (100, 100)], [25, 50, 75], [0, 10, 20, 30, 40, 50, 100])
    np.testing.assert_allclose(truth.reference, [2.5, 5.0, 5.5])


def test_truth_serves_precision_and_recall():
    truth = true_matches_by_frames([(0, 0), (10, 20)], np.arange(12))
    matched = np.array([0, 2, 4, 6, 8, 10, 12, 3, 16, 18, 20, 5])
    right = right_matches(matched, truth.reference, tolerance=1)
    known = truth.is_known
    curve = precision_recall(right[known], np.zeros(known.sum()), truth.can_be_matched[known])
    assert (curve.precision[-1], curve.recall[-1]) == (10 / 11, 10 / 11)


@pytest.mark.parametrize(
    ("keys", "reference_frame", "says"),
    [
        ([(0, 0)], None, "1 key frames, expected two"),
        ([(0, 0), (0, 1)], None, "increase: rows out of order"),
        ([(10, 0), (0, 1)], None, "increase"),
        ([(np.nan, 0), (1, 1)], None, "key frames of the queries"),
        ([(0, 0, 0), (1, 1, 1)], None, "shape"),
        ([(0, 0), (10, 50)], [0, 10, 20], "another recording"),
        ([(0, 0), (10, 20)], [0, 20, 10], "does not increase"),
    ],
)
def test_key_frames_that_cannot_be_meant_are_refused(keys: list, reference_frame: list | None, says: str):
    with pytest.raises(InputError, match=says):
        true_matches_by_frames(keys, [1], reference_frame)
