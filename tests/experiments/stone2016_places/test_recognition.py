"""Answers and their measures, against closed forms and a second way to the same thing."""

from typing import Any

import numpy as np
import pytest

from insectnav.experiments import load
from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE
from insectnav.experiments.stone2016_places import fig_5, recognition
from insectnav.experiments.stone2016_places.car_runs import BLUR, UNTESTED, median_precision
from insectnav.experiments.stone2016_places.fig_5 import worst_labelled
from insectnav.experiments.stone2016_places.frames import sky_grid
from insectnav.experiments.stone2016_places.recognition import (
    Recognised,
    by_rotation,
    in_sequences,
    jointly,
    neutral_patches,
    thirds_by_turn,
    turned_apart,
)
from insectnav.sweep import published_numbers
from insectnav.vision.descriptors import patch_normalised
from insectnav.vision.sphere import rotation_matrix


def answer(reference, score, truth=None) -> Recognised:
    truth = np.arange(len(score), dtype=float) if truth is None else truth
    return Recognised(reference=np.asarray(reference), score=np.asarray(score, float), truth=truth)


def test_neutral_patches_are_those_of_the_descriptor():
    pictures = np.random.default_rng(1).integers(0, 256, (3, 32, 64), dtype=np.uint8)
    pictures[0, 8:16, 24:40] = 200
    pictures[2, :8] = 0
    v1, neutral = (patch_normalised(pictures, size=None, rounded=True, flat_patch=flat) for flat in (0, 127))
    assert not np.array_equal(v1, neutral)
    np.testing.assert_array_equal(neutral_patches(v1), neutral)


def test_five_frames_off_is_right_and_six_is_wrong():
    found = answer([5, 6, -1, 3], [0.1, 0.2, np.nan, 0.3], np.array([0.0, 0.0, 2.0, 3.0]))
    np.testing.assert_array_equal(found.is_right, [True, False, False, True])
    np.testing.assert_array_equal(found.kept, [True, False, False, False])
    measured = found.findings()
    assert measured["recall_at_full_precision"] == pytest.approx(100 / 3)
    assert measured["precision_at_full_recall"] == pytest.approx(200 / 3)


def test_what_is_always_right_has_no_error():
    measured = answer(np.arange(200), np.linspace(0.1, 0.9, 200)).findings()
    for name in recognition.MEASURES:
        assert measured[name] == pytest.approx(100.0)
        assert measured[f"{name}_error"] == pytest.approx(0.0, abs=1e-9)


def test_error_of_blocks_is_that_of_independent_blocks():
    rng = np.random.default_rng(4)
    is_right = np.repeat(rng.random(50) < 0.5, 20)
    reference = np.where(is_right, np.arange(1000), 5000)
    error = answer(reference, rng.random(1000)).findings()["precision_at_full_recall_error"]
    # Fifty blocks, each right or wrong as a whole, drawn at any place: less than 50 / √50 % and more than half of it.
    assert 3.5 < error < 7.1


def test_a_true_diagonal_is_followed_at_every_length():
    n = 80
    matrix = np.abs(np.subtract.outer(np.arange(n), np.arange(n))).astype(float)
    matrix += np.random.default_rng(0).random((n, n))
    for length in (1, 10, 20):
        found = in_sequences(matrix, np.arange(n, dtype=float), length)
        known = np.isfinite(found.score)
        assert known.sum() == n - (0 if length == 1 else length)
        assert found.is_right[known].all()


def test_median_precision_weighs_recall():
    # Recall grows at precision 1, 1, 3/5 and 4/6 in equal steps; the second of these in order is 4/6.
    found = answer([0, 1, 90, 90, 4, 5], [1, 2, 3, 4, 5, 6])
    assert median_precision(found) == pytest.approx(100 * 4 / 6)
    assert median_precision(answer([90, 90], [1, 2])) == 0.0


def test_answers_of_the_same_queries_are_compared_block_by_block():
    rng = np.random.default_rng(5)
    one, other = (
        answer(np.where(rng.random(600) < share, np.arange(600), 5000), rng.random(600)) for share in (0.9, 0.6)
    )
    for measure in recognition.MEASURES:
        more, error = jointly(measure, np.subtract, one, other)
        assert more == pytest.approx(one.findings()[measure] - other.findings()[measure])
        assert error > 0.0
        assert jointly(measure, np.subtract, one, one) == (0.0, 0.0)
        alone = one.findings()
        assert jointly(measure, np.positive, one) == pytest.approx((alone[measure], alone[f"{measure}_error"]))
    # Both are right apart from one another: the error is nearly that of two which are drawn apart.
    errors = [found.findings()["precision_at_full_recall_error"] for found in (one, other)]
    assert jointly("precision_at_full_recall", np.subtract, one, other)[1] == pytest.approx(np.hypot(*errors), rel=0.3)
    with pytest.raises(ValueError, match="other lengths"):
        jointly("area", np.subtract, one, answer([0, 1], [1.0, 2.0]))


def test_draws_without_any_match_are_left_out():
    score = np.where(np.arange(60) < 20, 0.5, np.nan)
    found = answer(np.where(np.isfinite(score), np.arange(60), -1), score)
    assert np.isnan(found.drawn).any()
    assert found.findings()["area_error"] == pytest.approx(0.0, abs=1e-9)
    assert jointly("area", np.subtract, found, found) == (0.0, 0.0)


def test_what_is_lost_and_kept_is_told_of_a_method_and_of_skies():
    n, rng = 400, np.random.default_rng(6)
    score = rng.random(n)
    level, tilted, sky, tilted_sky = (
        answer(np.where(np.arange(n) % k == k - 1, 5000, np.arange(n)), score) for k in (50, 2, 100, 4)
    )
    found = fig_5._lost([level, tilted, sky, tilted_sky])
    area = [one.findings()["area"] for one in (level, tilted, sky, tilted_sky)]
    assert found["area_lost"] == pytest.approx(area[0] - area[1])
    assert found["area_less_sky"] == pytest.approx(area[1] - area[3])
    assert found["area_lost_less_sky"] == pytest.approx(area[0] - area[1] - area[2] + area[3])
    assert found["area_kept_less_sky"] == pytest.approx(100 * area[1] / area[0] - 100 * area[3] / area[2])
    assert all(0.0 < found[f"{name}_error"] < 5.0 for name in ("area_lost", "area_less_sky", "area_kept_less_sky"))


def test_turned_and_tilted_skies_are_found_with_their_tilt():
    rng = np.random.default_rng(7)
    grid = sky_grid()
    axes = rng.standard_normal((6, 5, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)

    def skies(rotation):
        looks = grid.directions @ rotation.T
        caps = (np.einsum("nd,pkd->pkn", looks, axes) > 0.8).any(axis=1)
        return np.packbits(~caps & (looks[:, 2] > 0.1), axis=-1)

    tilt = np.deg2rad(20.0)
    reference, query = {"sky": skies(np.eye(3))}, {"sky": skies(rotation_matrix(0.7, tilt, 0.0))}
    found = by_rotation(reference, query, np.arange(6.0), 64)
    np.testing.assert_array_equal(found.single.reference, np.arange(6))
    np.testing.assert_allclose(np.rad2deg(found.tilt), 20.0, atol=1.0)
    np.testing.assert_array_equal(np.argmin(found.matrix, axis=0), np.arange(6))
    assert ((found.matrix >= 0.0) & (found.matrix <= 1.0)).all()


def test_single_frames_with_contrast_over_all_references_are_the_nearest():
    matrix = np.random.default_rng(3).random((60, 25))
    found = in_sequences(matrix, np.zeros(25), 1, whole_contrast=True)
    np.testing.assert_array_equal(found.reference, np.argmin(matrix, axis=0))
    assert not np.array_equal(in_sequences(matrix, np.zeros(25), 1).reference, np.argmin(matrix, axis=0))


def test_cameras_are_turned_apart_by_the_difference_of_their_headings_or_pitches():
    level = np.zeros((40, 3))
    reference = {"distance": np.arange(40.0), "orientation": level}
    for angle in (0, 1, 2):
        orientation = level.copy()
        orientation[20:, angle] = 0.3
        turned = turned_apart(reference, {"orientation": orientation}, np.arange(40.0))
        np.testing.assert_allclose(turned[:15], 0.0, atol=1e-9)
        np.testing.assert_allclose(turned[25:], 0.3, atol=1e-9)
        assert turned[20] == pytest.approx(0.3 * 6 / 11)  # frames 15 to 25, of which six are turned


def test_thirds_are_those_turned_least_and_most():
    turned = np.linspace(0.0, 1.0, 9)
    found = answer([0, 1, 2, 90, 90, 5, 90, 90, -1], [*[1.0] * 8, np.nan])
    least, most = thirds_by_turn(found, turned)
    np.testing.assert_array_equal(np.flatnonzero(least), [0, 1, 2])
    np.testing.assert_array_equal(np.flatnonzero(most), [5, 6, 7])


def test_words_on_misaligned_views_are_held_against_the_thirds_turned_least_and_most():
    columns = [f"{name}{end}" for name in recognition.MEASURES for end in ("", "_error")]

    def row(method: str, length: int, least: float, most: float, n_frames: int = 1000) -> dict[str, Any]:
        turned = {
            "right_where_turned_least": least, "right_where_turned_most": most,
            "right_where_turned_least_less_most": least - most, "right_where_turned_least_less_most_error": 2.0,
        }  # fmt: skip
        others = dict.fromkeys(("median_precision", "in_right_section", "sky_labelled_right"), 50.0)
        words = (
            "right_in_last_third_less_before", "right_under_canopy", "right_under_canopy_less_elsewhere",
            "mislabelled_by_flare", "mislabelled_where_sunlit", "mislabelled_in_shade", "precision_less_sky",
            "right_in_last_third_less_sky",
        )  # fmt: skip
        others |= dict.fromkeys([f"{name}{end}" for name in words for end in ("", "_error")], 50.0)
        about = {"method": method, "sequence_length": length, "passages": "whole way", "site": "BMX Track"}
        about |= {"n_frames": n_frames}
        return about | dict.fromkeys(columns, 50.0) | others | turned

    methods = (
        recognition.VANILLA, recognition.NEUTRAL, recognition.SKY, recognition.POINTS, recognition.TRUE,
        recognition.SKY_WHOLE, recognition.SINGLE, recognition.FABMAP, recognition.PLAIN, recognition.WATERSHED,
    )  # fmt: skip
    fig_8 = load("stone2016-fig-8")
    for least, most, expected in ((30.0, 6.0, AGREES), (6.0, 30.0, DIFFERS)):
        table = [row(method, length, least, most) for method in methods for length in (1, 10, 20)]
        given = {v.quantity: v for v in fig_8.compare(table, published_numbers(fig_8, "stone2016-fig-8"))}
        verdict = given["share right where turned apart least less most, vanilla"]
        assert (verdict.verdict, verdict.ours) == (expected, least - most)
    table = [row(method, length, 30.0, 6.0, 40) for method in methods for length in (1, 10, 20)]
    short = fig_8.compare(table, published_numbers(fig_8, "stone2016-fig-8"))
    assert {verdict.verdict for verdict in short} == {NOT_COMPARABLE}
    assert given[BLUR].why == UNTESTED[BLUR]
    assert "40 frames of a part of the way, expected all 1000" in short[0].why


def test_a_part_of_the_city_is_not_held_against_the_paper():
    measures = (*recognition.MEASURES, "area_lost", "area_less_sky", "area_lost_less_sky", "area_kept_less_sky")

    def table(n_frames: int) -> list[dict[str, Any]]:
        methods = (recognition.VANILLA, recognition.SKY, recognition.TRUE, recognition.SINGLE)
        numbers = dict.fromkeys([f"{name}{end}" for name in measures for end in ("", "_error")], 20.0)
        about = {"passages": "whole way", "n_frames": n_frames, "sky_labelled_right": 99.0, "longest_gap": 30}
        rows = [
            {"tilt_difference_deg": apart, "method": method} | about | numbers
            for apart in range(0, 61, 10)
            for method in methods
        ]
        level = [row for row in rows if row["tilt_difference_deg"] == 0]
        return rows + [row | {"passages": name} for name in fig_5.VARIATIONS for row in level]

    published = published_numbers(fig_5, "stone2016-fig-5")
    assert {verdict.verdict for verdict in fig_5.compare(table(32), published)} == {NOT_COMPARABLE}
    whole = {verdict.quantity: verdict for verdict in fig_5.compare(table(520), published)}
    assert {name for name, one in whole.items() if one.verdict == NOT_COMPARABLE} == set(fig_5.UNTESTED)
    aside = [row | {"area_lost": 15.0} if row["passages"] == "2 m aside" else row for row in table(520)]
    moved = {verdict.quantity: verdict for verdict in fig_5.compare(aside, published)}
    assert moved["area of sky, 2 m aside less as ridden"].ours == -15.0


def test_frames_with_many_wrong_pixels_are_counted_in_the_worse_passage():
    accuracy = {0: np.array([[99.0, 97.5], [96.0, 98.0]]), 1: np.array([[90.0, 99.0], [96.9, 100.0]])}
    assert worst_labelled(accuracy, (0, 1)) == 50.0
    assert worst_labelled(accuracy, (0, 0)) == 25.0
