"""Long, fast and smoothed routes: memories held against the plain oracle, and small runs to all verdicts."""

from dataclasses import replace

import numpy as np
import pytest

import oracle
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.experiments.stone2017_path_integration import ed_9bcd
from insectnav.experiments.stone2017_path_integration.ed_9bcd import LIMIT, N_POINTS, Cell
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(panel="d", preset="thesis", n_trials=3, noise=0.0)


@pytest.fixture(scope="module")
def results():
    return simulated(ed_9bcd, [replace(cell, n_trials=3) for cell in ed_9bcd.grid("quick")])


def test_small_run_gives_all_verdicts(results):
    verdicts_of(ed_9bcd, "stone2017-ed-9bcd", results)


def test_same_seed_same_bits():
    assert same_bits(ed_9bcd, replace(SMALL, panel="c", speed=3.0, noise=0.1))


@pytest.mark.parametrize("preset", ["thesis", "code-2017"])
def test_memory_of_a_fast_route_is_that_of_the_oracle(preset: str):
    arrays = ed_9bcd.simulate(replace(SMALL, panel="c", preset=preset, speed=2.6), 0)
    heading, velocity = (array[0].astype(float) for array in route_arrays(1, N_STEPS, RouteParams(), 0, "float32"))
    params = {"thesis": oracle.THESIS, "code-2017": oracle.CODE_2017}[preset]
    trial = oracle.run_trial(heading, 2.6 * velocity, 0, params, record=True)
    bearing, distance = oracle.decode(trial["memory_at_turn"], params)
    way = trial["position"][-1]
    assert arrays["distance"][1][0] == pytest.approx(np.hypot(*way), rel=1e-4)
    assert arrays["decoded_over_true"][1][0] == pytest.approx(distance / np.hypot(*way), rel=5e-3)
    assert arrays["bearing_error"][1][0] == pytest.approx(oracle.wrap(bearing - np.arctan2(*way)), abs=5e-3)
    memory = trial["memory"]
    is_full = (memory <= LIMIT) | (memory >= 1 - LIMIT)
    assert arrays["ever_saturated"][1][0] == is_full.any()
    assert arrays["saturated_at_turn"][1][0] == pytest.approx(is_full[-1].mean(), abs=1 / 16)


def test_long_route_fills_no_memory_that_it_cannot(results):
    """Shares are shares, and the shortest route, whose cells stay within bounds, decodes to about its length."""
    assert ((results["saturated_at_turn"] >= 0) & (results["saturated_at_turn"] <= 1)).all()
    for preset in ("thesis", "code-2017"):
        short = results.only(panel="b", preset=preset, n_outbound=1500)
        assert not results["ever_saturated"][short].any()
        np.testing.assert_allclose(results["decoded_over_true"][short], 1.1, atol=0.25)


def test_filter_of_one_step_displaces_nothing(results):
    for preset in ("thesis", "code-2017"):
        lengths = [1, 2, 5, 10, 20, 50]
        displaced = [results["displaced"][results.only(panel="d", preset=preset, filter_steps=n)] for n in lengths]
        np.testing.assert_array_equal(displaced[0], 0.0)
        assert (np.diff(np.median(displaced, axis=1)) > 0).all()
    assert np.isnan(results["displaced"][results.where(panel="b")]).all()


def test_drawn_tracks_and_paths_are_of_the_first_trial(results):
    index = results.only(panel="d", preset="thesis", filter_steps=1)
    _, velocity = route_arrays(1, N_STEPS, RouteParams(), 0, "float32")
    positions = np.cumsum(velocity[0], axis=0)
    assert results["true_track"].shape[1] == N_POINTS
    np.testing.assert_allclose(results["true_track"][index][0], positions[0], atol=1e-6)
    np.testing.assert_allclose(results["true_track"][index][-1], positions[-1], rtol=1e-4)
    np.testing.assert_allclose(results["out"][index][0][-1], results["home"][index][0][0])
    np.testing.assert_allclose(results["decoded_track"][index][-1], positions[-1], rtol=0.25)


def test_homed_distance_ends_where_the_agent_searches(results):
    """An agent that is home has covered the whole way, give or take the spread of its search."""
    index = results.only(panel="b", preset="thesis", n_outbound=1500)
    covered = np.abs(results["homed_over_true"][index] - 1.0) * results["distance"][index]
    assert (covered < 60.0).all()
