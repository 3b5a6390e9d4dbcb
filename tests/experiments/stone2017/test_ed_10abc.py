"""Injected current: stored vectors against the plain circuit, mirror images, and turning against headings."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import oracle
from insectnav.central_complex import circuit_params
from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2017_path_integration import ed_10abc
from insectnav.experiments.stone2017_path_integration.ed_10abc import Cell
from insectnav.experiments.stone2017_path_integration.straight_flights import fly, straight_flight
from small_runs import explains_in_numbers, same_bits, simulated_grid, verdicts_of

FIRST, LAST, N_STEPS, SPEED = 150, 350, 500, 0.5


@pytest.fixture(scope="module")
def results() -> Results:
    return simulated_grid(ed_10abc, n_trials=3)


def plain_dance(params: oracle.OracleParams, population: str, cell: int, heading: float) -> tuple[float, float]:
    """Decoded bearing minus heading [rad], and distance, of the plain circuit with one cell held at 1."""
    tb1, memory = oracle.initial_state()
    velocity = SPEED * oracle.unit_vector(heading)
    for step in range(N_STEPS):
        is_held = FIRST <= step < LAST
        _, _, tb1 = oracle.compass(tb1, heading, params, 0.0, None)
        tn1, tn2 = oracle.flow_neurons(heading, velocity, params, 0.0, None)
        rates = {"tb1": tb1, "tn2": tn2}
        if is_held and population in rates:
            rates[population][cell] = 1.0
        memory = oracle.update_memory(memory, tb1, tn1, tn2, params)
    bearing, distance = oracle.decode(memory, params)
    return oracle.wrap(bearing - heading), distance


@pytest.mark.parametrize(("preset", "params"), [("thesis", oracle.THESIS), ("code-2017", oracle.CODE_2017)])
@pytest.mark.parametrize(("population", "cell", "heading"), [("tb1", 3, 180.0), ("tb1", 4, 180.0), ("tn2", 1, 0.0)])
def test_stored_vector_is_that_of_the_plain_circuit(preset, params, population, cell, heading):
    ours = ed_10abc.simulate(
        Cell(preset=preset, population=population, first_cell=cell, heading_deg=heading, n_trials=2), 0
    )
    shift, distance = plain_dance(params, population, cell, np.radians(heading))
    assert_allclose(ours["shift_without_noise"][1], np.degrees(shift), atol=1e-6)
    assert_allclose(ours["distance_without_noise"][1], distance, rtol=1e-9)


def test_mirror_images_shift_the_other_way(results: Results):
    tb1 = results["shift_without_noise"][results.where(preset="thesis", population="tb1", leg="out")]
    # The flight is due south, along column 4: columns 4 + k and 4 - k lie on either side of it.
    assert_allclose(tb1[[5, 6, 7]], -tb1[[3, 2, 1]], atol=1e-9)
    assert_allclose(tb1[[0, 4]], 0.0, atol=1e-9)
    right, left = results["shift_without_noise"][results.where(preset="thesis", population="tn2", heading_deg=180.0)]
    assert right == pytest.approx(-left) != pytest.approx(0.0, abs=1.0)


def test_half_turn_of_the_flight_turns_the_stored_vector(results: Results):
    south, north = (results.where(population="tn2", heading_deg=heading) for heading in (180.0, 0.0))
    assert_allclose(results["shift_without_noise"][south], results["shift_without_noise"][north], atol=1e-9)
    assert_allclose(results["distance_without_noise"][south], results["distance_without_noise"][north])
    table = [row for row in ed_10abc.summarise(results) if row["population"] == "tn2" and row["preset"] == "thesis"]
    east = {(row["heading_deg"], row["first_cell"]): row["stored_east"] for row in table}
    assert east[180.0, 0] * east[0.0, 0] < 0.0
    assert east[180.0, 0] * east[180.0, 1] < 0.0


def test_angle_turned_is_the_sum_of_the_changes_of_heading():
    cell = Cell(preset="code-2017", population="cpu1", leg="home", first_cell=7, n_cells=2, n_trials=4)
    trials = fly(
        straight_flight(np.full(4, np.pi), N_STEPS, SPEED),
        circuit_params(preset="code-2017"),
        n_inbound=400,
        noise=0.1,
        seed=9,
        perturbations=cell.clamps(),
    )
    # No single turn comes near half a turn: at most m · 8 = 2 rad.
    changes = np.diff(np.unwrap(trials.heading[:, 599:800].astype(float), axis=1), axis=1)
    assert_allclose(ed_10abc.simulate(cell, 9)["turned"][1], changes.sum(axis=1) / (2.0 * np.pi), atol=1e-4)


def test_cells_are_counted_round_within_their_side():
    (clamp,) = Cell(preset="thesis", population="cpu1", leg="home", first_cell=6, n_cells=4).clamps()
    assert (clamp.cells, clamp.rate) == ((6, 7, 0, 1), 1.0)
    assert (clamp.first_step, clamp.end_step) == (600, 800)
    assert Cell(preset="thesis", population="none").clamps() == []


def test_same_bits():
    assert same_bits(ed_10abc, Cell(preset="thesis", population="cpu1", leg="home", n_trials=3))


def test_figure_caption_and_verdicts(results: Results):
    verdicts = verdicts_of(ed_10abc, "stone2017-ed-10abc", results)
    assert explains_in_numbers(ed_10abc, "stone2017-ed-10abc", results)
    assert all(np.isfinite(verdict.ours) for verdict in verdicts)
    assert f"n = {results.cells[0].n_trials} " in ed_10abc.caption(results)
