"""Route pairs, pooled precision and recall, the compass, and what the experiments say of given results."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.experiments import load
from insectnav.experiments.experiment import Results
from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE
from insectnav.experiments.stone2014_places import descriptors_walk, fig_4ab, fig_4cd, walk_sensitivity
from insectnav.experiments.stone2014_places.compass_runs import absolute_turns, found
from insectnav.experiments.stone2014_places.mirror import mirror_pixels, unwrapped
from insectnav.experiments.stone2014_places.route_pairs import (
    Pair,
    Run,
    begins_at_first,
    pooled,
    route_pairs,
    run_pair,
)
from insectnav.experiments.stone2014_places.sequence_ways import DESCRIPTORS, MAJORITY, MASKED, OTHERS, UV, VISIBLE
from insectnav.experiments.stone2014_places.walks import Walk, walk_of
from insectnav.matching import Matches, TurnMatrix, turn_matrix
from insectnav.sweep import published_numbers
from insectnav.vision.descriptors import contour_amplitudes, harmonic_amplitudes, zernike_amplitudes


def walk_with(day: str, arrays: Mapping[str, Any], every: int = 1) -> Walk:
    n = len(next(iter(arrays.values())))
    along = 1.5 * np.arange(n)
    whole = {
        "number": every * np.arange(n),
        "position": np.stack([along, np.zeros(n)], axis=-1),
        "distance": along,
        "heading": np.full(n, np.pi / 2),
        "course": np.full(n, np.pi / 2),
    }
    return Walk(day=day, every=every, mirror_size=9, arrays=whole | dict(arrays))


def run_with(right: Any, score: Any, distance: Any) -> Run:
    n = len(right)
    pair = Pair(reference_day="january", reference_start=0, query_day="april", query_start=0)
    matches = Matches(np.zeros(n, np.int64), np.asarray(score, float), np.ones(n))
    error = np.where(right, 1.0, 500.0)
    return Run(pair, np.zeros(1, np.int64), np.arange(n), matches, error, np.asarray(distance, float))


# Route pairs.


def test_there_are_nineteen_route_pairs_each_in_both_directions():
    pairs = route_pairs()
    assert len(pairs) == len(set(pairs)) == 38

    def sets(pair: Pair) -> frozenset[tuple[str, int]]:
        return frozenset({(pair.reference_day, pair.reference_start), (pair.query_day, pair.query_start)})

    unordered = {sets(pair) for pair in pairs}
    assert len(unordered) == 19
    assert all(sum(sets(pair) == one for pair in pairs) == 2 for one in unordered)
    assert all(0 in (pair.reference_start, pair.query_start) for pair in pairs)
    first = [pair for pair in pairs if begins_at_first(pair)]
    assert len(first) == 20  # ten test sets on either day
    assert {pair.query_start for pair in first if pair.query_day == "april"} == set(range(10))


def test_seqslam_finds_a_walk_in_itself_and_counts_metres():
    rng = np.random.default_rng(0)
    bits = rng.random((400, 64)) < 0.5
    walks = {day: walk_with(day, {"bits": bits}) for day in ("january", "april")}
    features = {day: walk["bits"] for day, walk in walks.items()}
    pair = Pair(reference_day="january", reference_start=0, query_day="april", query_start=0)
    run = run_pair(walks, features, "hamming", pair)
    assert len(run.queries) == len(run.references) == 40
    assert_array_equal(np.flatnonzero(~run.is_matched), [0, 1, 2, 3, 4, 35, 36, 37, 38, 39])
    assert_allclose(run.error[run.is_matched], 0.0)
    assert run.is_right().sum() == 30


def test_a_set_begins_where_it_is_said_to_and_has_a_frame_every_ten_seconds():
    walk = walk_with("april", {"x": np.arange(60)}, every=1)
    assert walk.sampled(3, 10).tolist() == [3, 13, 23, 33, 43, 53]
    sparse = walk_with("april", {"x": np.arange(12)}, every=5)
    assert sparse.sampled(5, 10).tolist() == [1, 3, 5, 7, 9, 11]


def test_pooled_numbers_are_those_counted_by_hand():
    score = [0.1, 0.2, 0.3, 0.4, 0.5]
    runs = [run_with([True] * 5, score, range(5)), run_with([True, True, True, True, False], score, range(5))]
    found_score = pooled(runs)
    assert found_score.precision == pytest.approx(0.9)
    assert found_score.recall == pytest.approx(0.8)  # eight are better than the wrong one, or as good
    perfect = pooled(runs[:1])
    assert (perfect.recall, perfect.precision) == (1.0, 1.0)
    assert perfect.recall_error == perfect.precision_error == 0.0


# What is compared.


def test_majority_of_three_frames_takes_out_what_is_seen_once():
    bits = np.zeros((6, 90 * 90), bool)
    bits[:, 0] = True
    bits[3, 5] = True  # a branch, in one frame
    bits[2, 0] = False  # a hole, in one frame
    walk = walk_with("april", {"binary_sky": np.packbits(bits, axis=1)})
    smoothed = OTHERS[0].features(walk)
    assert not smoothed[:, 5].any()
    assert smoothed[:, 0].all()
    assert smoothed.shape == bits.shape


def test_turning_the_rig_by_half_a_turn_turns_skies_and_grey_alone():
    rng = np.random.default_rng(1)
    skies = rng.random((3, 90, 90)) < 0.5
    grey = rng.integers(0, 255, (3, 16, 16), dtype=np.uint8)
    arrays = {"binary_sky": np.packbits(skies.reshape(3, -1), axis=1), "grey": grey}
    walk = walk_with("april", arrays)
    turned = walk_with("april", {
        "binary_sky": np.packbits(np.rot90(skies, 2, axes=(1, 2)).reshape(3, -1), axis=1),
        "grey": np.ascontiguousarray(np.rot90(grey, 2, axes=(1, 2))),
    })  # fmt: skip
    for way in (UV, VISIBLE):
        assert way.turned is not None
        assert_array_equal(way.turned(walk), way.features(turned))
    assert all(way.turned is None for way in DESCRIPTORS if "UV, " in way.name and way is not UV)


def test_turns_by_absolute_differences_are_those_of_a_plain_loop():
    rng = np.random.default_rng(2)
    reference = rng.integers(0, 255, (4, 3, 12), dtype=np.uint8)
    query = np.roll(reference[:3], 4, axis=2)  # turned left by a third of a turn
    query[0, 0, 0] ^= 7
    found_turns = absolute_turns(reference, query, n_turns=6)
    for r in range(4):
        for q in range(3):
            each = [
                np.abs(reference[r].astype(float) - np.roll(query[q], -2 * k, axis=1).astype(float)).mean()
                for k in range(6)
            ]
            assert found_turns.difference[r, q] == pytest.approx(min(each), abs=1e-5)
    assert_allclose(np.diagonal(found_turns.turn[:3]), 2.0 * np.pi / 3.0)
    as_known = turn_matrix(reference, query)  # the sign is that of the library
    assert_allclose(np.diagonal(as_known.turn[:3]), 2.0 * np.pi / 3.0)


def test_the_compass_advises_the_course_where_it_is_right():
    reference, query = (walk_with(day, {"x": np.arange(50)}) for day in ("january", "april"))
    queries = np.array([10, 20, 30])
    query["heading"][queries] = np.pi / 2 - 0.3  # held a little to the left
    difference = np.abs(np.arange(50)[:, None] - queries).astype(float)
    run = found(reference, query, queries, TurnMatrix(difference, np.full((50, 3), 0.3)))
    assert_array_equal(run.reference, queries)
    assert run.is_right().all()
    assert_allclose(run.astray, 0.0, atol=1e-12)


def test_a_walk_is_put_together_in_order_without_what_is_padded():
    cells = [fig_4ab.Cell(day=day, first=first, n_frames=3) for day in ("january", "april") for first in (0, 3)]
    number = np.array([[0, 1, 2], [3, 4, -1], [0, 1, 2], [3, -1, -1]])
    results = Results(cells, {"number": number, "x": number * 10.0})
    assert walk_of(results, "january")["x"].tolist() == [0.0, 10.0, 20.0, 30.0, 40.0]
    assert walk_of(results, "april")["number"].tolist() == [0, 1, 2, 3]


# Verdicts.


def verdicts(name: str, table: Any) -> dict[str, Any]:
    experiment = load(name)
    return {v.quantity: v for v in experiment.compare(table, published_numbers(experiment, name))}


def sequence_row(way: str, recall: float, precision: float, **changed: float) -> dict[str, Any]:
    row: dict[str, Any] = {
        "way": way, "runs": "all", "n_frames": 2789, "recall_at_full_precision": recall, "recall_error": 1.0,
        "precision_at_full_recall": precision, "precision_error": 0.5, "right_pixels_where_right": 99.0,
    }  # fmt: skip
    row |= {f"precision_within_{t:.0f}_m": precision for t in fig_4ab.TOLERANCES}
    row |= {
        "mean_recall_of_runs": recall,
        "lowest_precision_of_runs": precision,
        "highest_precision_of_runs": precision,
    }
    row |= {f"{name}_{word}": 1.0 for name in ("tree_share", "sky_share") for word in ("where_right", "where_wrong")}
    seen = ("tree_share", "sky_share", "sky_change")
    row |= {f"{name}_{word}": 1.0 for name in seen for word in ("wrong_less_right", "error")}
    row |= {"precision_less_uv": precision - 94.0, "precision_less_uv_error": 0.5}
    return row | changed


def test_verdicts_of_seqslam_follow_from_the_table():
    better = (MAJORITY.name, MASKED[1].name)  # than skies of bits: smoothed, and the better of two masked greys
    others = [sequence_row(way.name, 50.0, 96.0 if way.name in better else 80.0) for way in OTHERS]
    trees = {"tree_share_wrong_less_right": 2.0, "sky_share_wrong_less_right": -5.0}
    table = [sequence_row(UV.name, 80.0, 94.0, **trees), sequence_row(VISIBLE.name, 60.0, 97.0), *others]
    as_printed = verdicts("stone2014-fig-4ab", table)
    agreed = {name for name, verdict in as_printed.items() if verdict.verdict == AGREES}
    assert set(as_printed) - agreed == set(fig_4ab.UNTESTED)
    for name, reason in fig_4ab.UNTESTED.items():
        assert (as_printed[name].verdict, as_printed[name].why) == (NOT_COMPARABLE, reason)
    table[0] = sequence_row(UV.name, 40.0, 70.0, tree_share_wrong_less_right=-5.0, sky_change_wrong_less_right=-9.0)
    table[2] = sequence_row(OTHERS[0].name, 40.0, 60.0)
    other = verdicts("stone2014-fig-4ab", table)
    assert other["precision at 100 % recall, majority of three frames less one, UV"].ours == -34.0
    assert other["sky changed from frame to frame, wrong less right matches, UV"].verdict == DIFFERS
    assert other["recall at 100 % precision, UV"].verdict == DIFFERS
    assert other["trees above the horizon, wrong less right matches, UV"].verdict == DIFFERS
    assert "rendered" in other["recall at 100 % precision, UV"].why
    short = verdicts("stone2014-fig-4ab", [row | {"n_frames": 168} for row in table])
    assert {verdict.verdict for verdict in short.values()} == {NOT_COMPARABLE}


def test_verdicts_of_the_compass_take_the_better_of_grey_and_colour():
    def row(way: str, precision: float, away: float) -> dict[str, Any]:
        return {
            "way": way, "queries_of": "both", "n_frames": 2789, "precision": precision, "precision_error": 1.0,
            "precision_within_10_m": precision, "leads_away": away, "leads_away_error": 1.0, "median_astray_deg": 4.0,
            "precision_less_uv": precision - 84.0, "precision_less_uv_error": 1.5, "leads_away_less_uv": away - 5.0,
            "leads_away_less_uv_error": 1.5,
            "wrong_far_away": 90.0, "wrong_far_away_error": 2.0,
        }  # fmt: skip

    table = [row(way, 84.0, 5.0) for way in fig_4cd.WAYS]
    table[fig_4cd.WAYS.index(fig_4cd.UV_AFTER)] = row(fig_4cd.UV_AFTER, 95.0, 2.0)
    table[fig_4cd.WAYS.index(fig_4cd.GREY)] = row(fig_4cd.GREY, 30.0, 40.0)
    table[fig_4cd.WAYS.index(fig_4cd.COLOUR)] = row(fig_4cd.COLOUR, 45.0, 30.0)
    given = verdicts("stone2014-fig-4cd", table)
    assert {verdict.verdict for verdict in given.values()} == {AGREES}
    assert given["precision, visible"].ours == 45.0
    less = given["precision, UV less visible"], given["directions that lead away, visible less UV"]
    assert [(one.ours, one.uncertainty) for one in less] == [(39.0, 1.5), (25.0, 1.5)]
    assert given["precision, SeqSLAM first less compass alone, UV"].ours == 11.0
    table[0] |= {"wrong_far_away": 20.0}
    near = verdicts("stone2014-fig-4cd", table)["wrong matches more than 100 m away, UV"]
    assert near.verdict == DIFFERS  # 20 ± 2 where more than half are claimed


def test_verdicts_of_descriptors_and_variations_follow_from_the_table():
    def row(name: str, precision: float, under: float) -> dict[str, Any]:
        return {
            "descriptor": name, "rig": "as carried", "n_frames": 2789, "precision_at_full_recall": precision,
            "precision_error": 0.5, "precision_under_trees": under, "precision_under_trees_error": 0.5,
            "precision_elsewhere": precision,
            "under_trees_less_elsewhere": under - precision, "under_trees_error": 0.01,
            "precision_less_contour": precision - 70.0, "precision_less_contour_error": 0.5,
            "precision_less_binary_sky": precision - 94.0, "precision_less_binary_sky_error": 0.5,
            "precision_under_trees_less_binary_sky": under - 60.0, "precision_under_trees_less_binary_sky_error": 0.5,
        }  # fmt: skip

    names = descriptors_walk.NAMES
    table = [row(name, precision, 60.0) for name, precision in zip(names, (94.0, 70.0, 97.0, 90.0, 95.0), strict=True)]
    given = verdicts("stone2014-descriptors-walk", table)
    assert {name for name, verdict in given.items() if verdict.verdict != AGREES} == set(descriptors_walk.UNTESTED)
    table[2] = row(names[2], 40.0, 60.0)
    found_words = verdicts("stone2014-descriptors-walk", table)
    assert found_words["precision, Zernike less Fourier contour"].verdict == DIFFERS

    def varied(name: str, uv: float, visible: float, under: float) -> dict[str, Any]:
        shares = {"uv_precision": uv, "visible_precision": visible, "compass_precision": 80.0}
        for key in ("uv", "visible", "contour", "zernike"):
            shares |= {f"{key}_on_stretches": under, f"{key}_on_stretches_less_elsewhere": under - uv}
        shares |= {"uv_precision_less_as_set": uv - 90.0, "visible_precision_less_as_set": visible - 80.0}
        return {"variation": name} | shares | {f"{column}_error": 0.5 for column in shares}

    table = [varied("as set", 90.0, 80.0, 85.0), varied("one weather and sun", 91.0, 95.0, 85.0)]
    given = verdicts("stone2014-walk-sensitivity", table)
    assert given["precision, one weather less as set, UV"].verdict == AGREES
    assert given["precision, bare trees on both days less as set, UV"].verdict == NOT_COMPARABLE
    crowns = varied("crowns over the way", 80.0, 80.0, 40.0) | {
        f"{name}{end}": value if not end else 0.5
        for name, value in (
            ("uv_on_stretches_less_without_trees", -50.0),
            ("visible_on_stretches_less_uv", 20.0),
            ("zernike_on_stretches_less_contour", 15.0),
        )
        for end in ("", "_error")
    }
    table += [varied("no trees over the way", 90.0, 80.0, 90.0), crowns]
    given = verdicts("stone2014-walk-sensitivity", table)
    expected = {
        "precision there with crowns over the way less without trees, UV": -50.0,
        "precision under crowns less elsewhere, UV": -40.0,
        "precision under crowns, visible less UV": 20.0,
        "precision under crowns less elsewhere, Fourier contour": -40.0,
        "precision under crowns, Zernike less Fourier contour": 15.0,
    }
    assert {name: given[name].ours for name in expected} == expected
    assert {given[name].verdict for name in expected} == {AGREES}
    (untested,) = walk_sensitivity.UNTESTED
    assert given[untested].verdict == NOT_COMPARABLE


def test_precision_on_the_stretches_with_crowns_is_of_the_queries_there():
    day = "april"
    share = np.arange(0, 1452, 12) / 1451
    walk = walk_with(day, {"number": np.arange(0, 1452, 12)})
    is_there = (
        ((share >= 0.1) & (share <= 0.2)) | ((share >= 0.42) & (share <= 0.52)) | ((share >= 0.74) & (share <= 0.84))
    )
    run = run_with(~is_there, np.ones(len(share)), 1932.0 * share)
    there, less = walk_sensitivity._on_stretches([run], {day: walk})
    assert (there[0], less[0]) == (0.0, -1.0)


def test_sensitivity_varies_one_thing_at_a_time_over_the_whole_walk():
    cells = walk_sensitivity.grid("full")
    assert {cell.every for cell in cells} == {10}
    assert len({(cell.variation, cell.resolution_deg) for cell in cells}) == len(walk_sensitivity.VARIATIONS) + 1
    assert len({cell.variation for cell in walk_sensitivity.grid("quick")}) == 2


# Captions.


def test_the_caption_of_the_compass_counts_the_queries_that_are_drawn(monkeypatch: pytest.MonkeyPatch):
    walks = {day: walk_with(day, {"x": np.arange(n)}) for day, n in (("january", 40), ("april", 70))}
    runs = []
    for reference, query in (("january", "april"), ("april", "january")):
        queries = walks[query].sampled(0, 10)
        turns = TurnMatrix(
            np.zeros((len(walks[reference]), len(queries))), np.zeros((len(walks[reference]), len(queries)))
        )
        runs.append(found(walks[reference], walks[query], queries, turns))
    monkeypatch.setattr(fig_4cd, "both_walks", lambda results: walks)
    monkeypatch.setattr(fig_4cd, "_all_runs", lambda results: {fig_4cd.UV: runs, fig_4cd.GREY: runs})
    results: Any = None
    assert fig_4cd.drawn_run(results, fig_4cd.UV).query_day == "april"
    assert "in c and d 7 of April with 40 of January" in fig_4cd.caption(results)


def test_amplitudes_stay_when_the_mirror_picture_is_turned_by_half_a_turn():
    rng = np.random.default_rng(5)
    pixels = mirror_pixels(173, 3.0)
    row, column = np.indices((173, 173)) - 86.0
    edge = 40.0 + 3.0 * sum(
        rng.standard_normal() * np.cos(k * np.arctan2(row, column) + rng.uniform(0.0, 6.3)) for k in range(1, 8)
    )
    sky = np.hypot(row, column) < edge
    turned = np.ascontiguousarray(sky[::-1, ::-1])
    assert_allclose(contour_amplitudes(turned), contour_amplitudes(sky), atol=1e-12)
    first, second = (unwrapped(mask, pixels) for mask in (sky, turned))
    assert_allclose(zernike_amplitudes(second), zernike_amplitudes(first), atol=1e-12)
    assert_allclose(harmonic_amplitudes(second, n_degrees=60), harmonic_amplitudes(first, n_degrees=60), atol=1e-12)


def test_words_on_trees_in_visible_light_are_held_against_both_lights():
    names = descriptors_walk.NAMES

    def row(name: str, under: float) -> dict[str, Any]:
        return {
            "descriptor": name, "rig": "as carried", "n_frames": 2789, "precision_at_full_recall": 90.0,
            "precision_error": 0.5, "precision_under_trees": under, "precision_under_trees_error": 1.0,
            "precision_elsewhere": 90.0, "under_trees_less_elsewhere": under - 90.0, "under_trees_error": 1.0,
        } | {
            f"{what}_less_{other}{end}": value
            for what, less in (("precision", 0.0), ("precision_under_trees", under - 80.0))
            for other in ("contour", "binary_sky")
            for end, value in (("", less), ("_error", 1.5))
        }  # fmt: skip

    quantity = "precision under trees, visible less UV, binary sky"
    for visible, expected in ((85.0, AGREES), (60.0, DIFFERS)):
        table = [row(name, visible if name == VISIBLE.name else 80.0) for name in names]
        verdict = verdicts("stone2014-descriptors-walk", table)[quantity]
        assert verdict.verdict == expected
        assert (verdict.ours, verdict.uncertainty) == (visible - 80.0, 1.5)
