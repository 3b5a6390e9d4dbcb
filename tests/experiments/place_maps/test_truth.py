"""Which matches are right, and what they amount to: by hand, and against scikit-learn."""

import io
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from sklearn.metrics import average_precision_score

from insectnav.checks import InputError
from insectnav.experiments.place_maps.locate import on_other_routes
from insectnav.experiments.place_maps.located import numbers, read_matches, write_rows
from insectnav.experiments.place_maps.truth import (
    between_key_frames,
    by_position,
    from_pairs,
    quantity,
    read_pairs,
    same_index,
)
from place_scenes import located

TEN = np.zeros(10, np.int64)  # places on one route


def test_same_index_within_each_route():
    routes = np.array([0, 0, 0, 0, 1, 1, 1])
    truth = same_index(np.array([0, 5, -1, 2, 6]), routes, 1.0)
    assert_array_equal(truth.error, [0, 0, np.nan, 1, np.nan])
    assert_array_equal(truth.is_right, [True, True, False, True, False])
    assert_array_equal(truth.is_in_map, [True, True, True, True, False])  # no route has a fifth place
    assert_array_equal(truth.reference, [0, 5, 2, 3, np.nan])


def test_same_index_of_routes_of_unequal_length():
    routes = np.array([0, 0, 1, 1, 1, 1])
    truth = same_index(np.array([0, 1, 1, -1]), routes, 1.0)
    assert_array_equal(truth.reference, [0, 1, 4, 5])  # the first route ends before queries 2 and 3


def test_a_query_beyond_the_map_has_no_right_match():
    reference = np.array([0, 1, 2, 2, 2])
    found = numbers(located(reference, None, same_index(reference, np.zeros(3, np.int64), 2.0), threshold=1.0))
    assert (found["can_be_matched"], found["kept_right"], found["recall_kept"]) == (3, 3, 1.0)
    assert (found["precision_kept"], found["precision_of_all"], found["error_largest"]) == (0.6, 0.6, 0.0)


def test_pairs_may_say_that_a_query_is_nowhere():
    truth = from_pairs(np.array([4, 2, 7]), {0: (5,), 1: ()}, 1.0, "by hand", TEN)
    assert_array_equal(truth.is_right, [True, False, False])
    assert_array_equal(truth.is_known, [True, True, False])
    assert_array_equal(truth.is_in_map, [True, False, False])
    with pytest.raises(InputError, match="pairs query 3 with place 0"):
        from_pairs(np.array([4, 2, 7]), {3: (0,)}, 1.0, "by hand", TEN)


def test_straight_lines_between_key_frames():
    keys = np.array([[1, 10], [3, 14], [4, np.nan]])
    truth = between_key_frames(np.array([9, 11, 12, 13, 13, 13]), keys, 1.0, "by eye", np.zeros(99, np.int64))
    assert_array_equal(truth.is_known, [False, True, True, True, True, False])
    assert_array_equal(truth.is_right, [False, True, True, True, False, False])
    assert_array_equal(truth.is_in_map, [False, True, True, True, False, False])


def test_key_frames_beyond_either_recording_are_refused():
    matched = np.array([0, 1, 2])
    for keys, words in (([[0, 0], [3, 2]], "key frames of the queries"), ([[0, 0], [2, 9]], "key frames of the map")):
        with pytest.raises(InputError, match=words):
            between_key_frames(matched, np.array(keys, float), 1.0, "by eye", np.zeros(9, np.int64))
    assert between_key_frames(matched, np.array([[0.0, 0.0], [2.0, 9.0]]), 1.0, "by eye", TEN).is_known.all()


def test_the_table_has_the_fraction_of_a_true_place():
    truth = between_key_frames(np.array([0, 1, 2, -1]), np.array([[0, 0], [2, 1], [3, np.nan]]), 1.0, "by eye", TEN)
    rows = located([0, 1, 2, -1], None, truth).rows()
    assert [row["true_reference"] for row in rows] == [0, 0.5, 1, ""]


def test_frames_are_counted_along_one_route_alone():
    """Neighbours by number may be a whole route apart: the last place of one and the first of the next."""
    routes = np.repeat([0, 1], 5)
    truth = from_pairs(np.array([5, 4, 6, 9, -1]), dict.fromkeys(range(5), (4,)), 2.0, "by hand", routes)
    assert_array_equal(truth.is_right, [False, True, False, False, False])
    assert_array_equal(truth.error, [np.nan, 0, np.nan, np.nan, np.nan])
    assert truth.is_known.all() and truth.is_in_map.all()
    found = located([5, 4, 6, 9, -1], None, truth, place_routes=routes)
    assert numbers(found)["precision_of_all"] == 0.25
    assert "3 matches lie on another route than the true place" in on_other_routes(found)[0]


def test_a_query_may_have_a_place_on_each_route():
    routes = np.repeat([0, 1], 5)
    truth = from_pairs(np.array([6, 1, -1]), {0: (1, 7), 1: (1, 7), 2: (1, 7)}, 0.0, "by hand", routes)
    assert_array_equal(truth.error, [1, 0, np.nan])
    assert_array_equal(truth.reference, [7, 1, 1])


def test_pairs_give_one_place_on_a_route(tmp_path):
    path, routes = tmp_path / "pairs.csv", np.repeat([0, 1], 5)
    names = ([f"q{k}" for k in range(3)], [f"p{k}" for k in range(10)])
    path.write_text("query,reference\nq0,p1\nq0,p7\nq1,\n0,1\n")
    assert read_pairs(path, *names, routes) == {0: (1, 7), 1: ()}
    for more in ("0,2\n", "0,-1\n", "1,3\n"):
        path.write_text("query,reference\n0,1\n0,7\n1,\n" + more)
        with pytest.raises(InputError, match=r"line 5 of .* another place than a line above, expected one for each on"):
            read_pairs(path, *names, routes)


@pytest.mark.parametrize(("line", "words"), [("0,-2", "names the place '-2'"), ("-1,2", "names the query '-1'")])
def test_numbers_below_0_are_refused_but_for_the_one_that_says_nowhere(tmp_path, line: str, words: str):
    path = tmp_path / "pairs.csv"
    path.write_text(f"query,reference\n1,-1\n{line}\n")
    with pytest.raises(InputError, match=rf"line 3 of .* {words}, expected a number from 0 or the name of one frame"):
        read_pairs(path, ["a", "b"], ["c", "d", "e"], np.zeros(3, np.int64))


def test_no_line_between_key_frames_leads_from_one_route_into_the_next():
    routes, keys = np.repeat([0, 1], 5), np.array([[0, 0], [2, 4], [4, 5], [6, 9]])
    truth = between_key_frames(np.array([0, 2, 5, 4, 5, 4, 9]), keys, 1.0, "by eye", routes)
    assert_array_equal(truth.is_known, [True, True, True, False, True, True, True])
    assert_array_equal(truth.reference, [0, 2, 4, np.nan, 5, 7, 9])
    assert_array_equal(truth.error, [0, 0, np.nan, np.nan, 0, np.nan, 0])
    assert_array_equal(truth.is_right, [True, True, False, False, True, False, True])


def test_distance_over_the_ground():
    places = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 90.0], [np.nan, np.nan, np.nan]])
    queries = np.array([[0.0, 0.0, 5.0], [0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [np.nan] * 3, [3.0, 3.0, 0.0]])
    truth = by_position(np.array([0, 1, 1, 0, 2]), queries, places, 5.0, "tracking")
    assert_allclose(truth.error, [0.0, 5.0, np.hypot(27, 4), np.nan, np.nan])
    assert_array_equal(truth.is_right, [True, True, False, False, False])
    assert_array_equal(truth.is_known, [True, True, True, False, False])
    assert_array_equal(truth.is_in_map, [True, True, False, False, True])
    with pytest.raises(InputError, match="no place of the map has a position"):
        by_position(np.array([0]), queries[:1], places[2:], 5.0, "tracking")


def test_matches_just_as_far_as_the_tolerance_are_right_whatever_the_rounding():
    places = np.array([(0.0, float(f"{k // 10}.{k % 10}")) for k in range(100)])  # every 10 cm
    matched = np.arange(97) + 3
    truth = by_position(matched, places[:97], places, 0.3, "tracking")
    assert truth.is_right.all() and truth.is_in_map.all()
    assert_allclose(truth.error, 0.3)
    assert not by_position(matched, places[:97], places, 0.2999, "tracking").is_right.any()


def test_numbers_are_those_of_scikit_learn():
    rng = np.random.default_rng(3)
    n = 200
    query = np.arange(n)
    reference = np.where(rng.random(n) < 0.7, query, (query + 50) % n)
    score = np.where(reference == query, rng.normal(0.4, 0.1, n), rng.normal(0.6, 0.1, n))
    truth = same_index(reference, np.zeros(n, np.int64), 0.0)
    found = numbers(located(reference, score, truth, n_places=n))
    share = (reference == query).mean()
    assert found["area"] == pytest.approx(average_precision_score(reference == query, -score) * share)
    assert found["precision_of_all"] == found["recall_of_all"] == pytest.approx(share)
    best_wrong = score[reference != query].min()
    assert found["recall_at_full_precision"] == pytest.approx(((score < best_wrong) & (reference == query)).sum() / n)
    assert found["threshold_of_full_precision"] < best_wrong


def test_a_threshold_keeps_the_better_matches():
    truth = same_index(np.array([0, 1, 5, -1]), np.zeros(10, np.int64), 0.0)
    found = numbers(located([0, 1, 5, -1], [0.1, 0.7, 0.3, np.nan], truth, threshold=0.5))
    assert (found["matched"], found["kept"], found["kept_right"]) == (3, 2, 1)
    assert found["precision_kept"] == 0.5
    assert found["recall_kept"] == 0.25
    assert found["error_largest"] == 3.0


def test_queries_without_a_sequence_or_a_truth_count_for_nothing():
    truth = from_pairs(np.array([-1, 1, 2, 3, -1]), {k: (k,) for k in (0, 1, 2, 4)}, 0.0, "by hand", TEN)
    found = numbers(located([-1, 1, 2, 3, -1], None, truth, half_sequence=1))
    assert (found["judged"], found["can_be_matched"], found["recall_of_all"], found["precision_of_all"]) == (2, 2, 1, 1)


def test_the_table_reads_back(tmp_path):
    places = np.stack([np.arange(10.0), 2 * np.arange(10.0), np.zeros(10)], axis=1)
    truth = same_index(np.array([-1, 1, 7, -1]), np.zeros(10, np.int64), 1.0)
    found = located([-1, 1, 7, -1], [0, 0.123456789, 0.9, 0], truth, half_sequence=1, place_positions=places)
    path = tmp_path / "m.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        write_rows(file, found.rows())
    again = read_matches(path)
    assert_array_equal(again.reference, found.reference)
    assert_allclose(again.score, found.score)
    assert_array_equal(again.has_sequence, found.has_sequence)
    assert_array_equal(again.positions, found.positions)
    assert again.names == found.names
    text = io.StringIO()
    write_rows(text, found.rows())
    path.write_text(text.getvalue().replace("q2", "q2").replace("\n2,", "\n3,"), encoding="utf-8")
    with pytest.raises(InputError, match="does not number its queries"):
        read_matches(path)


def test_times_and_scores_of_a_table_are_those_that_were_found(tmp_path):
    # Seconds since 1970 have ten digits before the point, and scores that differ may share their first nine.
    times, scores = 1.7e9 + np.array([0.25, 1.125]), np.array([1 / 3, 1 / 3 + 1e-12])
    found = located([0, 1], scores)
    path = tmp_path / "matches.csv"
    with path.open("w", newline="") as file:
        write_rows(file, replace(found, times=times).rows())
    again = read_matches(path)
    np.testing.assert_array_equal(again.times, times)
    np.testing.assert_array_equal(again.score, scores)


def test_quantities_as_a_person_writes_them():
    assert [quantity(*one) for one in ((1.0, "frames"), (2.0, "frames"), (0.25, "m"), (1.0, "m"))] == [
        "1 frame", "2 frames", "0.25 m", "1 m"
    ]  # fmt: skip
