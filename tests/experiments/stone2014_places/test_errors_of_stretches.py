"""Standard errors by stretches of the way: of shares, contrasts, and differences on the same frames."""

from typing import Any

import numpy as np
import pytest

from insectnav.experiments.stone2014_places.route_pairs import Pair, Run, contrast_of, less_of, share_of
from insectnav.matching import Matches


def run_with(right: Any, score: Any, distance: Any) -> Run:
    n = len(right)
    pair = Pair(reference_day="january", reference_start=0, query_day="april", query_start=0)
    matches = Matches(np.zeros(n, np.int64), np.asarray(score, float), np.ones(n))
    error = np.where(right, 1.0, 500.0)
    return Run(pair, np.zeros(1, np.int64), np.arange(n), matches, error, np.asarray(distance, float))


def test_standard_error_of_a_share_is_that_of_stretches():
    right = np.arange(400) % 5 > 0
    apart = share_of(right, 100.0 * np.arange(400))  # one trial in each stretch: √(p (1 − p) / n)
    assert apart[0] == pytest.approx(0.8)
    assert apart[1] == pytest.approx(np.sqrt(0.16 / 400), rel=0.15)
    blocks = np.repeat(np.arange(40) % 5 > 0, 10)
    together = share_of(blocks, 10.0 * np.arange(400))  # ten alike in each: as if there were 40 trials
    assert together[1] == pytest.approx(np.sqrt(0.16 / 40), rel=0.15)


def test_contrast_is_the_difference_of_means_and_its_error_that_of_stretches():
    rng = np.random.default_rng(0)
    chosen = np.arange(2000) % 2 == 0
    values = rng.standard_normal(2000) + 3.0 * chosen
    found_contrast = contrast_of(values, chosen, 100.0 * np.arange(2000))
    assert found_contrast[0] == pytest.approx(3.0, abs=0.15)
    assert found_contrast[1] == pytest.approx(np.sqrt(2.0 / 1000.0), rel=0.2)
    assert np.isnan(contrast_of(values, np.ones(2000, bool), np.arange(2000.0))[0])


def test_two_ways_on_the_same_frames_are_compared_stretch_by_stretch():
    rng = np.random.default_rng(1)
    fails = rng.random(400) < 0.5  # where both are wrong
    distance = 100.0 * np.arange(400)
    one = run_with(~fails, np.ones(400), distance)
    other = run_with(~fails & (np.arange(400) % 10 > 0), np.ones(400), distance)
    less, error = less_of([one], [other])
    n = np.count_nonzero(~fails & (np.arange(400) % 10 == 0))
    assert less == pytest.approx(n / 400)
    assert error == pytest.approx(np.sqrt(n / 400 * (1 - n / 400) / 400), rel=0.2)  # far below √(2 · 0.25 / 400)
    assert less_of([one], [one]) == (0.0, 0.0)
    assert less_of([one], [other], np.arange(400) % 10 > 0) == (0.0, 0.0)
    assert np.isnan(less_of([one], [other], np.zeros(400, bool))).all()
    assert less_of([one], [other], is_so=lambda run: ~run.is_right())[0] == pytest.approx(-n / 400)


def test_queries_that_only_one_way_matches_count_in_its_own_precision():
    distance = 100.0 * np.arange(4)
    one = run_with([True, True, False, False], [0.1, 0.2, np.nan, np.nan], distance)
    one = one._replace(matches=one.matches._replace(reference=np.array([0, 1, -1, -1])))
    other = run_with([True, False, False, False], [0.1, 0.2, 0.3, 0.4], distance)
    assert less_of([one], [other])[0] == pytest.approx(1.0 - 0.25)
    with pytest.raises(ValueError, match="other queries"):
        less_of([one], [other, other])
