"""The search: its measures on a path of the plain oracle, and small runs from simulation to verdicts."""

from dataclasses import replace

import numpy as np
import pytest

import oracle
from insectnav.experiments.stone2017_path_integration import search
from insectnav.experiments.stone2017_path_integration.search import MAX_LOOPS, WINDOW, Cell
from insectnav.metrics.search import NEVER, search_loops
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(preset="code-2017", noise=0.1, n_trials=6, n_inbound=1800)


@pytest.fixture(scope="module")
def results():
    cells = [replace(cell, n_trials=6, n_inbound=1800) for cell in search.grid("quick")]
    return simulated(search, cells)


def test_small_run_gives_all_verdicts(results):
    verdicts_of(search, "stone2017-search", results)


def test_same_seed_same_bits():
    assert same_bits(search, SMALL)


def test_routes_and_noise_are_those_of_fewer_trials():
    few, many = search.simulate(replace(SMALL, n_trials=3), 0), search.simulate(SMALL, 0)
    np.testing.assert_array_equal(few["loop_reach"][1], many["loop_reach"][1][:3])
    np.testing.assert_array_equal(few["path"][1], many["path"][1])


def test_arrival_and_distance_are_those_of_the_path(results):
    """Recomputed step by step from the one path that is kept."""
    for cell, arrays in results:
        distance = [float(np.hypot(x, y)) for x, y in arrays["path"].astype(float)]
        arrival = next((step for step, d in enumerate(distance) if d <= 20.0), NEVER)
        assert arrays["arrival"][0] == arrival
        if arrival != NEVER and arrival + WINDOW < cell.n_inbound:
            expected = sum(distance[arrival : arrival + WINDOW]) / WINDOW
            assert arrays["distance"][0, 0] == pytest.approx(expected, rel=1e-5)


def test_first_loops_are_numbered_within_their_trial():
    """Loops of length 50, 60 … of two trials, the first of which has more than are kept."""
    reaches = [50.0 + 10.0 * i for i in range(MAX_LOOPS + 3)]
    rounds = [[0.0, 0.0]] + [point for reach in reaches for point in ([reach, 0.0], [0.0, 0.0])]
    few = [[0.0, 0.0], [0.0, 70.0]] + [[0.0, 0.0]] * (len(rounds) - 2)
    direction, reach = search._first_loops(search_loops([rounds, few], 20.0, 40.0), np.array([0.0, np.pi / 2]))
    np.testing.assert_array_equal(reach[0], reaches[:MAX_LOOPS])
    np.testing.assert_allclose(direction[0], np.pi / 2)
    assert reach[1, 0] == 70.0
    assert direction[1, 0] == pytest.approx(-np.pi / 2)
    assert np.isnan(reach[1, 1:]).all()


def test_agent_of_the_oracle_searches_as_ours_does(results):
    """An independent implementation, with other noise: its loops have the size of ours, give or take half of it."""
    rng = np.random.default_rng(8)
    out = oracle.random_route(100, rng)
    path = oracle.run_trial(*out, 1500, oracle.CODE_2017, noise=0.1, rng=rng)["position"]
    reach = search_loops(path[None, 99:], 20.0, 40.0).reach
    ours = results["loop_reach"][results.only(preset="code-2017", noise=0.1, motor_gain=0.0)]
    assert len(reach) >= 2
    assert np.median(reach) == pytest.approx(np.nanmedian(ours), rel=0.5)


def test_quicker_turn_is_the_only_difference_of_the_extra_cell():
    extra = [cell for cell in search.grid("full") if cell.motor_gain != search.PRESETS_OWN]
    assert [cell.motor_gain for cell in extra] == [search.QUICKER_GAIN]
    as_preset = replace(SMALL, motor_gain=0.25)  # m of the 2017 code
    own = search.simulate(SMALL, 0)
    for name, (_, values, *_rest) in search.simulate(as_preset, 0).items():
        np.testing.assert_array_equal(values, own[name][1])
