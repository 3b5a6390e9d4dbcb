"""Dances: read-outs of sinusoids in closed form, of random trips against the plain decoder, and the mirror image."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import oracle
from insectnav.central_complex import circuit_params, decode_waggle_dance
from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2017_path_integration import waggle_dance
from insectnav.experiments.stone2017_path_integration.straight_flights import fly, straight_flight
from insectnav.experiments.stone2017_path_integration.waggle_dance import Cell, mirrored_bearing, peak_bearing
from small_runs import explains_in_numbers, same_bits, simulated_grid, verdicts_of

BEARINGS = np.radians([-170.0, -90.0, -20.0, 0.0, 17.0, 44.0, 135.0])


@pytest.fixture(scope="module")
def results() -> Results:
    return simulated_grid(waggle_dance, n_trials=5)


def sinusoid(bearing: float, amplitude: float = 0.2) -> np.ndarray:
    """Memory that holds a place in a bearing, seen from 45° aside by each half."""
    columns = np.arange(8) * np.pi / 4
    halves = [columns + np.pi / 4 - bearing, columns - np.pi / 4 - bearing]
    return 0.5 + amplitude * np.cos(np.concatenate(halves))


@pytest.mark.parametrize("bearing", BEARINGS)
def test_sinusoid_is_read_in_closed_form(bearing: float):
    memory = sinusoid(bearing)
    assert oracle.decode(memory, oracle.THESIS)[0] == pytest.approx(bearing)  # that the sinusoid is what it should be
    assert oracle.wrap(float(mirrored_bearing(memory)) + bearing) == pytest.approx(0.0, abs=1e-9)
    assert abs(oracle.wrap(float(peak_bearing(memory)) - bearing)) <= np.pi / 8 + 1e-9
    assert float(peak_bearing(memory)) % (np.pi / 4) == pytest.approx(0.0, abs=1e-9)


def test_flights_along_columns_are_read_by_their_peak():
    headings = np.array([0.0, np.pi / 4, np.pi / 2, -3 * np.pi / 4])
    memory = fly(straight_flight(headings, 300, 0.5), circuit_params()).memory_at_turn
    assert_allclose(peak_bearing(memory), headings, atol=1e-9)


def test_read_outs_are_those_of_the_plain_circuit():
    arrays = waggle_dance.simulate(Cell(preset="thesis", variant="no-pontine", noise=0.0, n_trials=2), 5)
    from insectnav.agents.routes import RouteParams, route_arrays

    heading, velocity = route_arrays(2, 1500, RouteParams(), 5)
    params = oracle.variant_params("no-pontine")
    for trial in range(2):
        plain = oracle.run_trial(heading[trial], velocity[trial], 0, params)
        bearing, distance = oracle.decode(plain["memory_at_turn"], params)
        assert arrays["bearing"][1][trial] == pytest.approx(np.degrees(bearing), abs=1e-6)
        assert arrays["distance"][1][trial] == pytest.approx(distance, rel=1e-8)
        x, y = plain["position"][-1]
        assert arrays["true_distance"][1][trial] == pytest.approx(np.hypot(x, y), rel=1e-9)
        assert arrays["true_bearing"][1][trial] == pytest.approx(np.degrees(np.arctan2(x, y)), abs=1e-7)
        error = np.hypot(x - distance * np.sin(bearing), y - distance * np.cos(bearing))
        assert arrays["place_error"][1][trial] == pytest.approx(error, abs=1e-6)


def test_idealised_circuit_is_exact(results: Results):
    exact = results.where(variant="idealised", noise=0.0)
    assert results["place_error"][exact].max() < 1e-8
    assert results["place_error"][results.where(variant="partially-holonomic", noise=0.0)].max() > 1.0


def test_only_flights_with_a_way_home_have_a_search(results: Results):
    for cell, arrays in results:
        assert np.isfinite(arrays["search_angle"]).all() == (cell.trip == "turned body")


def test_dance_of_a_known_memory_has_the_errors_that_the_table_gives(results: Results):
    for row, (_, arrays) in zip(waggle_dance.summarise(results), results, strict=True):
        error = np.angle(np.exp(1j * np.radians(arrays["bearing"] - arrays["true_bearing"])), deg=True)
        assert row["absolute_bearing_error_deg"] == pytest.approx(np.median(np.abs(error)), abs=1e-9)
        assert row["distance_ratio"] == pytest.approx(np.median(arrays["distance"] / arrays["true_distance"]))


def test_decoder_of_the_package_is_not_the_mirror_image():
    memory = sinusoid(0.7)
    assert float(decode_waggle_dance(memory, circuit_params()).bearing) == pytest.approx(0.7)
    assert float(mirrored_bearing(memory)) == pytest.approx(-0.7)


def test_same_bits():
    assert same_bits(waggle_dance, Cell(preset="thesis", variant="fully-holonomic", noise=0.1, n_trials=3))


def test_figure_caption_and_verdicts(results: Results):
    verdicts = verdicts_of(waggle_dance, "stone2017-waggle-dance", results)
    assert explains_in_numbers(waggle_dance, "stone2017-waggle-dance", results)
    assert all(np.isfinite(verdict.ours) for verdict in verdicts)
    assert f"n = {results.cells[0].n_trials} " in waggle_dance.caption(results)
