"""Body turned from the course: stored vectors against the plain circuit and closed forms; where the search is."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import oracle
from insectnav.central_complex import circuit_params
from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2017_path_integration import ed_10def
from insectnav.experiments.stone2017_path_integration.body_offsets import (
    RANDOM,
    search_place,
    southward_flight,
    stored_bearing_error,
    turned_body,
)
from insectnav.experiments.stone2017_path_integration.ed_10def import Cell
from insectnav.experiments.stone2017_path_integration.straight_flights import fly
from small_runs import explains_in_numbers, same_bits, simulated_grid, verdicts_of


@pytest.fixture(scope="module")
def results() -> Results:
    return simulated_grid(ed_10def, n_trials=4)


def test_flight_is_800_steps_due_south():
    position = fly(southward_flight(2), circuit_params()).position
    assert_allclose(position[:, -1], [[0.0, -200.0]] * 2, atol=1e-3)
    assert_allclose(np.diff(position[:, :, 1], axis=1), -0.25, atol=1e-4)


@pytest.mark.parametrize("variant", ["non-holonomic", "partially-holonomic", "fully-holonomic"])
@pytest.mark.parametrize("offset", [-45.0, 30.0, 90.0])
def test_stored_vector_is_that_of_the_plain_circuit(variant: str, offset: float):
    params = oracle.variant_params(variant)
    velocity = np.tile(0.25 * oracle.unit_vector(np.pi), (800, 1))
    body = np.full(800, oracle.wrap(np.pi + np.radians(offset)))
    bearing, distance = oracle.decode(oracle.run_trial(body, velocity, 0, params)["memory_at_turn"], params)
    error, ratio = stored_bearing_error(circuit_params(variant), offset)
    assert ratio == pytest.approx(distance / 200.0, abs=1e-9)
    if distance > 1.0:  # else the bearing is that of rounding errors
        assert error == pytest.approx(oracle.wrap(bearing - np.pi), abs=1e-7)


@pytest.mark.parametrize(
    ("variant", "offset", "expected"),
    [
        # One speed for both sides: the flight is stored along the body.
        ("non-holonomic", 45.0, 45.0), ("non-holonomic", -45.0, -45.0),
        # Flow along one of the two axes alone is stored along it: the course is 45° aside of the body's axis.
        ("partially-holonomic", 90.0, 45.0), ("partially-holonomic", -90.0, -45.0),
        # Both signs of flow count: the course is stored, whatever the body does.
        ("fully-holonomic", 45.0, 0.0), ("fully-holonomic", 135.0, 0.0), ("fully-holonomic", 180.0, 0.0),
    ],
)  # fmt: skip
def test_error_of_the_stored_bearing_by_symmetry(variant: str, offset: float, expected: float):
    error, ratio = stored_bearing_error(circuit_params(variant), offset)
    assert np.degrees(error) == pytest.approx(expected, abs=1e-6)
    assert 0.5 < ratio < 1.3


@pytest.mark.parametrize("variant", ["non-holonomic", "partially-holonomic"])
def test_backward_flow_alone_stores_nothing(variant: str):
    assert stored_bearing_error(circuit_params(variant), 180.0)[1] < 1e-9


def test_random_offsets_change_every_25_steps_and_lie_all_round():
    heading = fly(southward_flight(40), circuit_params(), perturbations=[turned_body(RANDOM)]).heading
    pieces = heading.reshape(40, 32, 25)
    assert np.all(pieces == pieces[:, :, :1])
    drawn = pieces[:, :, 0].ravel()
    assert np.unique(drawn).size > 1200
    # The mean of n unit vectors in random directions has a length below 3 / sqrt(n) but once in 8000 times.
    assert np.abs(np.exp(1j * drawn.astype(float)).mean()) < 3.0 / np.sqrt(drawn.size)


@pytest.mark.parametrize(("angle", "share"), [(0.0, 0.5), (np.pi / 2, 1.0), (-np.pi / 4, 0.25)])
def test_search_place_finds_a_search_of_known_place(angle: float, share: float):
    n_steps = 1800
    position = np.zeros((1, n_steps, 2))
    start = np.array([0.0, -200.0])
    position[0, :800] = start * np.linspace(0.0, 1.0, 800)[:, None]
    round_and_round = np.exp(2j * np.pi * np.arange(1000) / 50.0)  # 300 steps are six full circles
    centre = start + 200.0 * share * oracle.unit_vector(angle)
    position[0, 800:] = centre + 7.0 * np.stack([round_and_round.real, round_and_round.imag], axis=-1)
    found_angle, found_share = search_place(position)
    assert_allclose([found_angle[0], found_share[0]], [angle, share], atol=1e-9)


def test_table_counts_what_it_says(results: Results):
    rows = ed_10def.summarise(results)
    for row, (cell, arrays) in zip(rows, results, strict=True):
        assert row["share_home"] == np.mean(arrays["closest_distance"] < 20.0)
        assert (row["variant"], row["n"]) == (cell.variant, 4)
        vectors = np.exp(1j * np.radians(arrays["bearing_error"]))
        assert row["bearing_error_deg"] == pytest.approx(np.angle(vectors.mean(), deg=True), abs=1e-3)


def test_same_bits():
    assert same_bits(ed_10def, Cell(preset="thesis", variant="fully-holonomic", offset_deg=RANDOM, n_trials=3))


def test_figure_caption_and_verdicts(results: Results):
    verdicts = verdicts_of(ed_10def, "stone2017-ed-10def", results)
    assert explains_in_numbers(ed_10def, "stone2017-ed-10def", results)
    assert all(np.isfinite(verdict.ours) for verdict in verdicts)
    assert f"n = {results.cells[0].n_trials} " in ed_10def.caption(results)
