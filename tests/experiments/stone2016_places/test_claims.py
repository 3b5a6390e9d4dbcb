"""What words of the text stand for as numbers of a passage, against answers that are known."""

from typing import Any

import numpy as np
import pytest

from insectnav.experiments.stone2016_places.claims import (
    PRECISION,
    claimed,
    contrast,
    longest_gap,
    mean_of,
    of_answer,
    of_frames,
    sections_of_track,
    shares_right,
)
from insectnav.experiments.stone2016_places.recognition import (
    FABMAP,
    PLAIN,
    SKY,
    SKY_WHOLE,
    VANILLA,
    WATERSHED,
    Recognised,
)
from insectnav.experiments.stone2016_places.sites import Ground

# Straight on: the way is as long as its last y, and the sections end at 260 and 450 m.
STRAIGHT: Any = Ground(
    mesh=None, way=np.stack([np.zeros(1213), np.arange(0.0, 606.5, 0.5)], axis=-1), ground="grass"  # type: ignore[arg-type]
)  # fmt: skip


def answer(right: Any, unmatched: Any = ()) -> Recognised:
    n = len(right)
    score = np.where(np.isin(np.arange(n), unmatched), np.nan, 1.0)
    return Recognised(reference=np.where(right, np.arange(n), 5000), score=score, truth=np.arange(n, dtype=float))


def test_contrast_is_of_means_and_leaves_out_what_is_not_known():
    values = np.concatenate([np.full(300, 80.0), np.full(300, 30.0)])
    chosen = np.arange(600) < 300
    assert contrast(values, chosen) == pytest.approx((50.0, 0.0))
    values[:10] = np.nan
    assert contrast(values, chosen) == pytest.approx((50.0, 0.0))
    assert np.isnan(contrast(values, np.ones(600, bool))).all()
    assert mean_of(values, chosen) == pytest.approx((80.0, 0.0))
    assert np.isnan(mean_of(values, np.zeros(600, bool))).all()


def test_errors_are_of_blocks_of_neighbours():
    each = np.random.default_rng(3).integers(0, 2, 50).astype(float)
    blocks = np.repeat(each, 20)
    alone = np.random.default_rng(3).permutation(blocks)
    everywhere = np.ones(1000, bool)
    # Fifty blocks that are right or wrong as a whole: nearly √20 times the error of a thousand single frames.
    assert mean_of(blocks, everywhere)[1] > 2.5 * mean_of(alone, everywhere)[1]


def test_the_longest_gap_counts_frames_in_a_row_without_a_right_match():
    right = np.ones(30, bool)
    assert longest_gap(answer(right)) == 0
    right[[3, 4, 5, 10, 28, 29]] = False
    assert longest_gap(answer(right)) == 3
    assert longest_gap(answer(right, unmatched=[3])) == 2  # a frame that cannot be matched is none of either
    assert longest_gap(answer(np.zeros(30, bool))) == 30


def test_what_is_right_under_the_canopy_is_told_from_the_rest():
    distance = np.linspace(0.0, 600.0, 601)
    assert [int((sections_of_track(distance, STRAIGHT) == k).sum()) for k in range(3)] == [261, 190, 150]
    right = np.where(distance <= 260.0, np.arange(601) % 2 == 0, True)
    by_sky, turned = answer(np.arange(601) % 4 > 0), np.linspace(0.0, 1.0, 601)
    found = of_answer(answer(right), by_sky, {"distance": distance}, STRAIGHT, turned, is_track=True)
    assert found["right_under_canopy"] == pytest.approx(100 * 131 / 261)
    assert found["right_under_canopy_less_elsewhere"] == pytest.approx(100 * (131 / 261 - 1))
    assert found["right_in_last_third_less_before"] == pytest.approx(
        100 * (1 - shares_right(answer(right))[:400].mean() / 100)
    )
    assert found["right_in_last_third"] == 100.0
    assert found["right_in_last_third_less_sky"] == pytest.approx(100 * 51 / 201)  # every fourth of 400 to 600
    assert found["right_where_turned_least"] == pytest.approx(50.0, abs=0.5)
    assert found["right_where_turned_least_less_most"] == pytest.approx(-50.0, abs=0.5)
    elsewhere = of_answer(answer(right), by_sky, {"distance": distance}, STRAIGHT, turned, is_track=False)
    assert np.isnan(elsewhere["right_under_canopy"])


def test_precision_is_less_than_that_of_skies_on_the_same_blocks():
    fails = np.repeat(np.arange(30) % 3 == 0, 20)  # where both are wrong
    by_sky, other = answer(~fails), answer(~fails & (np.arange(600) % 20 > 0))
    found = of_answer(other, by_sky, {"distance": np.arange(600.0)}, STRAIGHT, np.arange(600.0), is_track=False)
    assert found["precision_less_sky"] == pytest.approx(-100 * 20 / 600)
    alone = other.findings()["precision_at_full_recall_error"]
    assert 0.0 < found["precision_less_sky_error"] < 0.4 * alone
    same = of_answer(by_sky, by_sky, {"distance": np.arange(600.0)}, STRAIGHT, np.arange(600.0), is_track=False)
    assert (same["precision_less_sky"], same["precision_less_sky_error"]) == (0.0, 0.0)


def test_flare_counts_where_the_sun_shines_in():
    distance, is_sunlit = np.linspace(0.0, 600.0, 601), np.arange(601) < 200
    accuracy = np.where(is_sunlit, 90.0, 99.0)
    query = {
        "distance": distance, "is_sunlit": is_sunlit, "accuracy": accuracy, "plain_accuracy": np.full(601, 99.5),
        "sky_share": np.where(distance <= 260.0, 0.2, 0.6),
    }  # fmt: skip
    found = of_frames(query, STRAIGHT, is_track=True)
    assert found["mislabelled_by_flare"] == found["mislabelled_by_flare_under_canopy"] == pytest.approx(9.5)
    assert np.isnan(of_frames(query, STRAIGHT, is_track=False)["mislabelled_by_flare_under_canopy"])
    assert (found["mislabelled_where_sunlit"], found["mislabelled_in_shade"]) == pytest.approx((10.0, 1.0))
    assert (found["sky_under_canopy"], found["sky_elsewhere"]) == pytest.approx((20.0, 60.0))


def test_claims_are_differences_of_the_rows_they_name():
    words = (
        "right_in_last_third_less_before", "right_under_canopy", "right_under_canopy_less_elsewhere",
        "mislabelled_by_flare", "median_precision", "in_right_section", "right_where_turned_least_less_most",
        "right_in_last_third_less_sky",
    )  # fmt: skip

    def row(precision: float, error: float = 1.0) -> dict[str, float]:
        return dict.fromkeys([f"{name}{end}" for name in words for end in ("", "_error")], 1.0) | {
            PRECISION: precision, f"{PRECISION}_error": 3.0,
            "precision_less_sky": precision - 80.0, "precision_less_sky_error": error,
        }  # fmt: skip

    rows = {
        (SKY, 10): row(80.0), (VANILLA, 10): row(60.0), (FABMAP, 1): row(10.0, 2.0), (SKY, 20): row(85.0),
        (SKY_WHOLE, 1): row(70.0), (PLAIN, 10): row(82.0), (WATERSHED, 10): row(79.0),
    }  # fmt: skip
    track = {(SKY, 10): row(90.0), (VANILLA, 10): row(65.0), (FABMAP, 1): row(30.0)}
    found = claimed(rows, track)
    less_than_sky = {
        "sky less vanilla": 20.0, "sky less FAB-MAP": 70.0, "sky, w = 20 less w = 10": 5.0,
        "sky, w = 10 less single images": 10.0, "sky, no flare less flare": 2.0, "sky, watershed less Otsu": -1.0,
    }  # fmt: skip
    assert {name: found[f"precision at full recall, {name}"][0] for name in less_than_sky} == less_than_sky
    assert found["precision at full recall, sky less FAB-MAP"][1] == 2.0
    assert found["precision at full recall, sky, less than on the BMX Track"][1] == pytest.approx(3.0 * np.sqrt(2.0))
    less = [
        found[f"precision at full recall, {who}, less than on the BMX Track"][0]
        for who in ("sky", "vanilla", "FAB-MAP")
    ]
    assert less == [-10.0, -5.0, -20.0]
    assert np.isnan(claimed(rows, {})["precision at full recall, sky, less than on the BMX Track"]).all()
