"""Straightness of the way home: numbers recomputed step by step from the paths, and small runs to the verdicts."""

import math
from itertools import pairwise

import numpy as np
import pytest

from insectnav.central_complex import circuit_params
from insectnav.experiments.stone2017_path_integration import fig_5e
from insectnav.experiments.stone2017_path_integration.fig_5e import Cell
from insectnav.experiments.stone2017_path_integration.trips import random_trips
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(preset="thesis", n_trials=8)


@pytest.fixture(scope="module")
def results():
    return simulated(fig_5e, [SMALL, Cell(preset="code-2017", n_trials=8)])


def test_small_run_gives_all_verdicts(results):
    verdicts_of(fig_5e, "stone2017-fig-5e", results)


def test_same_seed_same_bits():
    assert same_bits(fig_5e, SMALL)


def test_numbers_are_those_of_the_paths(results):
    """Walked one step at a time, without arrays."""
    trips = random_trips(8, circuit_params(preset="thesis"), noise=fig_5e.NOISE, seed=0)
    lefts, ways, gains = [], [], []
    for path in trips.position[:, 1499:].astype(float).tolist():
        straight = nearest = math.hypot(*path[0])
        walked = 0.0
        for before, after in pairwise(path):
            walked += math.dist(before, after)
            nearest = min(nearest, math.hypot(*after))
            if walked >= straight:
                lefts.append(nearest / straight)
                ways.append(straight)
                gains.append(straight - math.hypot(*after))
                break
    row = fig_5e.summarise(results)[0]
    np.testing.assert_allclose(results["distance_left"][0], lefts, rtol=1e-9)
    assert row["n"] == 8
    assert row["tortuosity"] == pytest.approx(1.0 / (1.0 - sum(lefts) / 8))
    assert row["mean_way_over_mean_gain"] == pytest.approx(sum(ways) / sum(gains))
    assert results["curve_mean"][0, 100] == pytest.approx(sum(lefts) / 8)
    assert results["curve_mean"][0, 0] == 1.0


def test_error_of_a_ratio_is_its_spread_over_samples():
    """Against many samples of the same two-dimensional distribution."""
    rng = np.random.default_rng(3)
    ways = rng.uniform(50.0, 400.0, (2000, 100))
    ends = ways * rng.uniform(0.0, 0.3, ways.shape)
    ratios = [fig_5e._way_over_gain(way, end) for way, end in zip(ways, ends, strict=True)]
    errors = [fig_5e._ratio_error(way, end) for way, end in zip(ways, ends, strict=True)]
    # The SD of 2000 samples is known to 1 in √4000, each estimate to 1 in √200.
    assert np.mean(errors) == pytest.approx(np.std(ratios), rel=4.0 * (1.0 / np.sqrt(4000.0) + 0.01))


def test_trial_too_short_for_its_way_counts_for_nothing():
    straight, end = np.array([100.0, 50.0, 80.0]), np.array([10.0, np.nan, 20.0])
    assert fig_5e._way_over_gain(straight, end) == 180.0 / 150.0
