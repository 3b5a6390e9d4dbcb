import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from sklearn.metrics import average_precision_score, precision_recall_curve

from insectnav.checks import InputError
from insectnav.metrics.retrieval import (
    area_under_curve,
    position_error,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
    right_matches,
)

ANSWERS = st.lists(st.tuples(st.booleans(), st.integers(0, 12)), min_size=1, max_size=60)


def test_a_case_by_hand():
    right = np.array([True, True, False, True, False, True])
    score = np.array([0.1, 0.3, 0.3, 0.5, np.nan, 0.9])
    able = np.array([True, True, False, True, True, True])
    curve = precision_recall(right & ~np.isnan(score), score, able)
    assert_array_equal(curve.threshold, [0.1, 0.3, 0.5, 0.9])
    assert_allclose(curve.precision, [1, 2 / 3, 3 / 4, 4 / 5])
    assert_allclose(curve.recall, [1 / 5, 2 / 5, 3 / 5, 4 / 5])
    assert recall_at_full_precision(curve) == 1 / 5
    assert precision_at_full_recall(curve) == 4 / 5
    assert_allclose(area_under_curve(curve), (1 + 2 / 3 + 3 / 4 + 4 / 5) / 5)


@settings(deadline=None)
@given(ANSWERS)
def test_agrees_with_scikit_learn(answers):
    right, score = (np.array(column) for column in zip(*answers, strict=True))
    if not right.any():
        return
    curve = precision_recall(right, score)
    share = right.mean()  # there recall is a share of the right matches, here of all queries
    precision, recall, threshold = precision_recall_curve(right, -score)
    assert_allclose(curve.precision[::-1], precision[:-1], rtol=1e-12)
    assert_allclose(curve.recall[::-1], recall[:-1] * share, rtol=1e-12)
    assert_allclose(curve.threshold[::-1], -threshold)
    assert_allclose(area_under_curve(curve), average_precision_score(right, -score) * share, rtol=1e-12)


@settings(deadline=None)
@given(ANSWERS, st.integers(0, 20))
def test_queries_that_are_not_matched_lower_recall_alone(answers, n_more):
    right, score = (np.array(column) for column in zip(*answers, strict=True))
    curve = precision_recall(right, score)
    more = precision_recall(
        np.append(right, np.zeros(n_more, bool)),
        np.append(score, np.full(n_more, np.nan)),
        np.ones(len(score) + n_more, bool),
    )
    assert_array_equal(more.precision, curve.precision)
    assert_allclose(more.recall, curve.recall * len(score) / (len(score) + n_more))


@settings(deadline=None)
@given(ANSWERS)
def test_recall_rises_and_order_does_not_matter(answers):
    right, score = (np.array(column) for column in zip(*answers, strict=True))
    curve, turned = precision_recall(right, score), precision_recall(right[::-1], score[::-1])
    assert (np.diff(curve.recall) >= 0).all()
    assert (np.diff(curve.threshold) > 0).all()
    assert 0 <= area_under_curve(curve) <= curve.recall[-1]
    for a, b in zip(curve, turned, strict=True):
        assert_array_equal(a, b)


def test_perfect_hopeless_and_silent():
    perfect = precision_recall(np.ones(9, bool), np.arange(9))
    assert (recall_at_full_precision(perfect), precision_at_full_recall(perfect), area_under_curve(perfect)) == (
        1,
        1,
        1,
    )
    hopeless = precision_recall(np.zeros(9, bool), np.arange(9))
    assert (recall_at_full_precision(hopeless), precision_at_full_recall(hopeless)) == (0, 0)
    assert area_under_curve(hopeless) == 0
    silent = precision_recall(np.zeros(9, bool), np.full(9, np.nan), np.ones(9, bool))
    assert (recall_at_full_precision(silent), area_under_curve(silent)) == (0, 0)
    assert np.isnan(precision_at_full_recall(silent))


def test_a_wrong_match_with_the_best_score_leaves_no_full_precision():
    assert recall_at_full_precision(precision_recall(np.array([False, True, True]), np.array([1, 2, 3]))) == 0
    # the best score shared by a right and a wrong match
    assert recall_at_full_precision(precision_recall(np.array([False, True]), np.array([1, 1]))) == 0


def test_right_matches_within_the_tolerance():
    matched, truth = [3, 4, -1, 9, 0], [5, 7, 0, np.nan, 0.5]
    assert_array_equal(right_matches(matched, truth, 2), [True, False, False, False, True])
    assert_array_equal(right_matches(matched, truth, 0), False)


@pytest.mark.parametrize("kind", ["u1", "i1", "u8", "f4", ">f8"])
def test_numbers_of_any_type_are_subtracted_as_numbers(kind: str):
    matched, truth = np.array([1, 5, 100], kind), np.array([3, 4, 0], kind)
    assert_array_equal(right_matches(matched, truth, 2), [True, True, False])
    places = np.array([[0, 0], [3, 4], [100, 0]], kind)
    assert_array_equal(position_error(places, places[[1, 0]], [0, 2]), [5, 100])


def test_nothing_is_matched_with_a_map_without_places_or_with_a_part_of_a_place():
    assert_array_equal(position_error(np.ones((0, 2)), np.zeros((2, 2)), [-1, -1]), [np.nan, np.nan])
    with pytest.raises(InputError, match=r"matched is 0\.5 for query 1, expected the whole number of a reference"):
        position_error(np.ones((3, 2)), np.zeros((2, 2)), [1, 0.5])


def test_position_error_is_the_distance():
    error = position_error([[0, 0], [0, 10]], [[0, 0], [3, 4], [np.nan, 0], [1, 1]], [0, 0, 1, -1])
    assert_array_equal(error, [0, 5, np.nan, np.nan])
    assert_array_equal(position_error([[0, 0, 0]], [[1, 2, 2]], [0]), [3])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: precision_recall([1, 0], [1, 2]), "is_right holds int64 values, expected True or False"),
        (lambda: precision_recall([True], [1, 2]), r"is_right has shape \(1,\), expected \(2,\)"),
        (lambda: precision_recall([True], [np.nan]), "no query can be matched"),
        (lambda: precision_recall([True], [1.0], [False]), "query 0 is matched rightly but is said to be none"),
        (lambda: right_matches([1], [1], -1), "tolerance is -1, expected at least 0"),
        (lambda: right_matches([1, 2], [1], 1), "truth has shape"),
        (lambda: position_error([[0, 0]], [[0, 0]], [1]), "matched reaches 1, expected -1 to 0: .* another map"),
        (lambda: position_error([[0, 0, 0]], [[0, 0]], [0]), "reference_position has shape"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()


def test_a_single_wrong_match_among_thousands_ends_full_precision():
    right = np.arange(4000) != 3000
    curve = precision_recall(right, np.arange(4000.0), np.ones(4000, bool))
    assert recall_at_full_precision(curve) == 3000 / 4000
