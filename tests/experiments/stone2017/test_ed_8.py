"""Example routes: what is told of them against the paths that are kept, and small runs from simulation to verdicts."""

import numpy as np
import pytest

from insectnav.experiments.stone2017_path_integration import ed_8
from insectnav.experiments.stone2017_path_integration.ed_8 import N_DRAWN, Cell
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(preset="thesis", n_trials=14)


@pytest.fixture(scope="module")
def results():
    return simulated(ed_8, [SMALL, Cell(preset="code-2017", n_trials=14)])


def test_small_run_gives_all_verdicts(results):
    verdicts_of(ed_8, "stone2017-ed-8", results)


def test_same_seed_same_bits():
    assert same_bits(ed_8, Cell(preset="thesis", n_trials=2))


def test_ways_out_are_the_same_under_both_sets_of_constants(results):
    np.testing.assert_array_equal(results["path"][0, :, :1500], results["path"][1, :, :1500])
    assert not np.array_equal(results["path"][0], results["path"][1])


def test_arrival_and_closest_distance_are_those_of_the_paths(results):
    for _, arrays in results:
        for k in range(N_DRAWN):
            home = arrays["path"][k, 1499:].astype(float)
            distance = [float(np.hypot(x, y)) for x, y in home]
            assert arrays["closest_distance"][k] == pytest.approx(min(distance), rel=1e-4, abs=1e-4)
            first = next((step for step, d in enumerate(distance) if step > 0 and d <= 20.0), np.nan)
            assert arrays["arrival"][k] == pytest.approx(first, nan_ok=True)


def test_share_of_the_table(results):
    closest = results["closest_distance"][0]
    row = ed_8.summarise(results)[0]
    assert row["share_home"] == sum(float(c) <= 20.0 for c in closest) / 14
    assert row["n"] == 14
    assert row["n_drawn"] == N_DRAWN


def test_share_of_all_has_an_error_still():
    results = simulated(ed_8, [SMALL])
    results.arrays["closest_distance"][:] = 1.0
    row = ed_8.summarise(results)[0]
    assert row["share_home"] == 1.0
    assert row["share_home_standard_error"] == pytest.approx(1.0 / 14.0)  # as if one of n had failed, to first order
