"""Migration: the bump in closed form, against the plain circuit, and the laws of the held course."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import oracle
from insectnav.central_complex import circuit_params
from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2017_path_integration import migration
from insectnav.experiments.stone2017_path_integration.migration import Cell, biased_circuit, memory_bump
from small_runs import explains_in_numbers, same_bits, simulated_grid, verdicts_of

GOALS = np.radians([-180.0, -100.0, -45.0, 0.0, 30.0, 90.0, 171.0])


@pytest.fixture(scope="module")
def results() -> Results:
    return simulated_grid(migration, n_trials=16)


def angle_deg(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """From one angle to another [deg], -180 to 180."""
    return np.angle(np.exp(1j * np.radians(np.asarray(a) - np.asarray(b))), deg=True)


@pytest.mark.parametrize("goal", GOALS)
def test_bump_is_the_vector_to_the_goal(goal: float):
    bearing, distance = oracle.decode(memory_bump(goal), oracle.THESIS)
    assert oracle.wrap(bearing - goal - np.pi) == pytest.approx(0.0, abs=1e-9)
    assert distance == pytest.approx(8.0 * 0.25 * np.cos(np.pi / 4) / (2.0 * 0.0025))
    assert memory_bump(goal).min() >= 0.25 - 1e-12


@pytest.mark.parametrize("goal", GOALS[:4])
def test_bump_is_what_a_flight_away_leaves_behind_in_the_idealised_circuit(goal: float):
    heading = np.full(500, oracle.wrap(goal + np.pi))
    velocity = 0.5 * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    flown = oracle.run_trial(heading, velocity, 0, oracle.variant_params("idealised"))
    amplitude = 0.0025 * 500 * 0.5 * np.cos(np.pi / 4) / 4.0  # h · flow / 4 in each step
    assert_allclose(memory_bump(goal, amplitude), flown["memory_at_turn"], atol=1e-12)


@pytest.mark.parametrize("goal", GOALS[:4])
def test_bump_of_weights_excites_steering_cells_as_the_bump_of_memory_does(goal: float):
    circuit = circuit_params()
    weights = biased_circuit(circuit, goal).connectivity.cpu4_to_cpu1
    even = oracle.sigmoid(np.full(16, 0.5), 5.0, 2.5)
    bump = oracle.sigmoid(memory_bump(goal), 5.0, 2.5)
    assert_allclose(weights @ even, oracle.WEIGHTS["W_CPU4_CPU1"] @ bump, atol=1e-12)
    assert_allclose(biased_circuit(circuit, goal).connectivity.pontine_to_cpu1, circuit.connectivity.pontine_to_cpu1)


def test_plain_circuit_holds_the_course_of_a_fixed_bump():
    goal, theta, velocity = 1.0, -2.0, np.zeros(2)
    tb1 = np.zeros(8)
    for _ in range(200):
        _, _, tb1 = oracle.compass(tb1, theta, oracle.THESIS, 0.0, None)
        turn = oracle.steering(tb1, memory_bump(goal), oracle.THESIS, 0.0, None)[3]
        theta, velocity = oracle.move(theta, velocity, turn, 0.1, 0.15)
    assert abs(np.degrees(oracle.wrap(theta - goal))) < 3.0


def test_course_without_noise_is_near_the_goal_and_the_same_in_all_octants(results: Results):
    cell = results.only(preset="thesis", noise=0.0)
    error = angle_deg(results["course"][cell], results["goal"][cell])
    assert np.abs(error).max() < 2.8125  # a sixteenth of a column
    # 16 goals are two in each octant; the start is another one in each, and forgotten after 100 steps.
    assert_allclose(error.reshape(8, 2), np.tile(error[:2], (8, 1)), atol=0.1)


def test_reversed_bump_reverses_the_course(results: Results):
    for cell in results.where(disturbance="reversal"):
        turn = angle_deg(results["course_after"][cell], results["course"][cell] + 180.0)
        assert np.abs(turn).max() < 10.0


def test_being_carried_off_changes_the_place_alone(results: Results):
    for preset in ("thesis", "code-2017"):
        normal, carried = (
            results.only(preset=preset, noise=0.1, store="memory", disturbance=name) for name in ("none", "carried")
        )
        moved = results["path"][carried] - results["path"][normal]
        before, after = moved[:, :150], moved[:, 151:]
        assert_allclose(before, 0.0, atol=1e-6)
        assert_allclose(after, np.broadcast_to([80.0, -60.0], after.shape), atol=1e-2)


def test_forced_turn_leaves_the_course_but_not_for_long(results: Results):
    cell = results.only(preset="thesis", disturbance="turned")
    path = results["path"][cell].astype(float)
    during = np.linalg.norm(path[:, 155] - path[:, 150], axis=-1)
    assert during.max() < 0.5 * 50 * 0.567  # it flies round: less than half the way of a straight flight
    assert np.abs(angle_deg(results["course_after"][cell], results["goal"][cell])).max() < 5.0


def test_same_bits():
    assert same_bits(migration, Cell(preset="thesis", noise=0.1, store="weights", n_trials=9))


def test_figure_caption_and_verdicts(results: Results):
    verdicts = verdicts_of(migration, "stone2017-migration", results)
    assert explains_in_numbers(migration, "stone2017-migration", results)
    assert all(np.isfinite(verdict.ours) for verdict in verdicts)
    assert f"n = {results.cells[0].n_trials} " in migration.caption(results)
