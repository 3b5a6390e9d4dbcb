"""Closest distance against length: trips against the plain oracle, and small runs from simulation to verdicts."""

from dataclasses import replace

import numpy as np
import pytest

import oracle
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.experiments.stone2017_path_integration import fig_5c
from insectnav.experiments.stone2017_path_integration.fig_5c import RANDOM_WALK, Cell, saturation_length
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(agent="code-2017", noise=0.1, n_steps=60, n_trials=4)


@pytest.fixture(scope="module")
def results():
    cells = [cell for cell in fig_5c.grid("quick") if cell.n_steps in (10, 379, 1500)]
    return simulated(fig_5c, [replace(cell, n_trials=4) for cell in cells])


def test_small_run_gives_all_verdicts(results):
    verdicts = verdicts_of(fig_5c, "stone2017-fig-5c", results)
    long_trips = [v for v in verdicts if "any length" in v.quantity or "saturated" in v.quantity]
    assert len(long_trips) == 6
    assert all(v.verdict == "not comparable" and "10000 steps" in v.why for v in long_trips)


def test_same_seed_same_bits():
    assert same_bits(fig_5c, SMALL)
    assert same_bits(fig_5c, replace(SMALL, agent=RANDOM_WALK, noise=0.0))


def test_parts_are_as_the_whole(monkeypatch: pytest.MonkeyPatch):
    for cell in (SMALL, replace(SMALL, agent=RANDOM_WALK)):
        whole = fig_5c.simulate(cell, 2)
        with monkeypatch.context() as patch:
            patch.setattr(fig_5c, "PART", 3)
            parts = fig_5c.simulate(cell, 2)
        for name, (_, values, *_) in whole.items():
            np.testing.assert_array_equal(parts[name][1], values)


@pytest.mark.parametrize(("preset", "params"), [("thesis", oracle.THESIS), ("code-2017", oracle.CODE_2017)])
def test_trips_are_those_of_the_oracle(preset: str, params: oracle.OracleParams):
    heading, velocity = route_arrays(3, 60, RouteParams(), 1, "float32")
    got = fig_5c.simulate(Cell(agent=preset, noise=0.0, n_steps=60, n_trials=3), 1)
    for k in range(3):
        trial = oracle.run_trial(heading[k].astype(float), velocity[k].astype(float), 60, params)
        distance = np.linalg.norm(trial["position"][59:], axis=-1)
        assert got["distance_at_turn"][1][k] == pytest.approx(distance[0], rel=1e-4)
        assert got["closest_distance"][1][k] == pytest.approx(distance.min(), rel=1e-3, abs=1e-2)
        decoded = oracle.decode(trial["memory_at_turn"], params)[1]
        assert got["decoded_over_true_distance"][1][k] == pytest.approx(decoded / distance[0], rel=1e-3)
        assert got["saturated_memory"][1][k] == 0.0


def test_memory_is_saturated_where_the_oracle_has_it_at_its_limits():
    cell = Cell(agent="code-2017", noise=0.0, n_steps=2500, n_trials=1)
    heading, velocity = route_arrays(1, 2500, RouteParams(), 1, "float32")
    trial = oracle.run_trial(heading[0].astype(float), velocity[0].astype(float), 0, oracle.CODE_2017)
    expected = np.mean((trial["memory_at_turn"] == 0.0) | (trial["memory_at_turn"] == 1.0))
    got = fig_5c.simulate(cell, 1)
    assert got["saturated_memory"][1][0] == np.float32(expected) > 0.0
    assert got["empty_memory"][1][0] == np.float32(np.mean(trial["memory_at_turn"] == 0.0))


def test_random_walk_is_a_route_that_goes_on():
    _, velocity = route_arrays(4, 120, RouteParams(), 7, "float64")
    distance = np.hypot(*np.cumsum(velocity, axis=1)[:, 59:].transpose(2, 0, 1))
    got = fig_5c.simulate(replace(SMALL, agent=RANDOM_WALK), 7)
    np.testing.assert_allclose(got["closest_distance"][1], distance.min(axis=1), rtol=1e-4)
    np.testing.assert_allclose(got["distance_at_turn"][1], distance[:, 0], rtol=1e-4)


def test_statistics_of_the_table(results):
    rows = fig_5c.summarise(results)
    assert len(rows) == len(results.cells)
    for row in rows:
        index = results.only(agent=row["agent"], noise=row["noise"], n_steps=row["n_steps"])
        values = sorted(results["closest_distance"][index].astype(float).tolist())
        mean = sum(values) / 4
        assert row["mean"] == pytest.approx(mean)
        assert row["median"] == pytest.approx((values[1] + values[2]) / 2)
        assert row["sd"] == pytest.approx((sum((v - mean) ** 2 for v in values) / 3) ** 0.5)


@pytest.mark.parametrize(
    ("shares", "expected"),
    [
        ([0.0, 0.2, 0.4], np.nan),
        ([0.6, 0.8, 1.0], 100.0),
        ([0.0, 0.5, 1.0], 1000.0),
        ([0.0, 0.25, 0.75], 10**3.5),  # half-way between the logarithms
        ([0.0, 1.0, 0.3], 10**2.5),
    ],
)
def test_length_of_saturation_by_hand(shares: list, expected: float):
    got = saturation_length(np.array([100, 1000, 10_000]), np.array(shares))
    assert got == pytest.approx(expected, nan_ok=True)
