"""Stored vectors: what is loaded against the plain circuit, and paths against their summaries."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import oracle
from insectnav.central_complex import circuit_params
from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2017_path_integration import vector_navigation
from insectnav.experiments.stone2017_path_integration.vector_navigation import (
    TASKS,
    Cell,
    Feeder,
    find_feeder,
    fly_to_goal,
    unvisited_share,
)
from small_runs import explains_in_numbers, same_bits, simulated_grid, verdicts_of

N_TRIALS, SEED = 6, 2
CIRCUIT = circuit_params()
LOADED = {  # memory at the start of each flight, from those at A and B
    "outward": lambda a, b: 1.0 - a,
    "homebound": lambda a, b: a,
    "shortcut": lambda a, b: a - b + 0.5,
    "sequence": lambda a, b: np.clip(a, 0.0, 1.0) + b - 0.5,
}


@pytest.fixture(scope="module")
def results() -> Results:
    return simulated_grid(vector_navigation, n_trials=N_TRIALS)


@pytest.fixture(scope="module")
def feeders() -> tuple[Feeder, Feeder]:
    return tuple(find_feeder(N_TRIALS, CIRCUIT, 0.0, SEED, first_trial=first) for first in (0, N_TRIALS))


@pytest.mark.parametrize("task", TASKS)
def test_flight_begins_as_that_of_the_plain_circuit_with_the_loaded_memory(task: str, feeders):
    a, b = feeders
    cell = Cell(preset="thesis", noise=0.0, task=task, n_trials=N_TRIALS)
    path, goal = fly_to_goal(cell, CIRCUIT, a, b, SEED)
    from_place = {"outward": 0.0 * a.place, "homebound": a.place, "shortcut": a.place, "sequence": a.place + b.place}
    to_place = {"outward": a.place, "homebound": 0.0 * a.place, "shortcut": b.place, "sequence": 0.0 * a.place}
    assert_allclose(path[:, 0], from_place[task], atol=1e-3)
    assert_allclose(goal, to_place[task], atol=1e-3)
    for trial in range(2):
        memory = np.clip(LOADED[task](a.memory[trial].astype(float), b.memory[trial].astype(float)), 0.0, 1.0)
        tb1, velocity, theta = np.zeros(8), np.zeros(2), 0.0
        place = from_place[task][trial]
        if task == "shortcut":  # it comes along its route, with its velocity and its compass
            heading, moves = a.route[0][trial].astype(float), a.route[1][trial].astype(float)
            theta, velocity = heading[-1], moves[-1]
            for past in heading[-10:]:
                tb1 = oracle.compass(tb1, past, oracle.THESIS, 0.0, None)[2]
        else:  # the one step at rest
            tb1, memory, _ = oracle.step(tb1, memory, theta, velocity, oracle.THESIS)
        for step in range(60):
            tb1, memory, rates = oracle.step(tb1, memory, theta, velocity, oracle.THESIS)
            theta, velocity = oracle.move(theta, velocity, rates["motor"], 0.1, 0.15)
            place = place + velocity
            assert_allclose(path[trial, step + 1], place, atol=0.05)


def test_feeders_a_and_b_are_trips_of_different_trials(feeders):
    a, b = feeders
    assert_allclose(a.path, np.cumsum(a.route[1], axis=1), atol=1e-2)
    assert np.linalg.norm(a.place - b.place, axis=-1).min() > 1.0
    both = find_feeder(2 * N_TRIALS, CIRCUIT, 0.0, SEED, first_trial=0)
    assert_allclose(both.place[N_TRIALS:], b.place)


def test_summaries_are_those_of_the_path(feeders):
    cell = Cell(preset="thesis", noise=0.0, task="shortcut", n_trials=N_TRIALS)
    path, goal = fly_to_goal(cell, CIRCUIT, *feeders, SEED)
    arrays = vector_navigation.simulate(cell, SEED)
    assert_allclose(arrays["distance"][1], np.linalg.norm(goal - path[:, 0], axis=-1))
    assert_allclose(arrays["closest_distance"][1], np.sqrt(((path - goal[:, None]) ** 2).sum(-1)).min(axis=1))
    assert_allclose(arrays["path"][1][:, 1], path[:4, 5], atol=1e-4)


def test_stored_vectors_lead_to_their_goals(results: Results):
    for noise in (0.0, 0.1):
        cells = results.where(preset="thesis", noise=noise)
        # Without them half of the trials would be no nearer than they start: in the median at 190 steps.
        assert np.median(results["closest_distance"][cells]) < 20.0


def test_unvisited_share_of_a_line_half_along_a_route():
    along = np.zeros((1, 1500, 2))
    along[0, :, 0] = np.linspace(0.0, 100.0, 1500)
    far = np.full((1, 1500, 2), -1000.0)
    a, b = (Feeder((path[..., 0], path), path, np.zeros((1, 16))) for path in (along, far))
    share = unvisited_share(np.zeros((1, 2)), np.array([[220.0, 0.0]]), a, b)
    # 20 points at multiples of 220/19: the first 11 are nearer than 20 steps to the route, which ends at 100.
    assert share[0] == pytest.approx(9 / 20)


def test_same_bits():
    assert same_bits(vector_navigation, Cell(preset="thesis", noise=0.1, task="sequence", n_trials=4))


def test_figure_caption_and_verdicts(results: Results):
    verdicts = verdicts_of(vector_navigation, "stone2017-vector-navigation", results)
    assert explains_in_numbers(vector_navigation, "stone2017-vector-navigation", results)
    assert all(np.isfinite(verdict.ours) for verdict in verdicts)
    assert f"n = {results.cells[0].n_trials} " in vector_navigation.caption(results)
