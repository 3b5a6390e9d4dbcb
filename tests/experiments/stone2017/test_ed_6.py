"""Responses and connections: against the equations and matrices of the plain oracle; small runs to the verdicts."""

import numpy as np
import pytest

import oracle
from insectnav.central_complex import THESIS
from insectnav.central_complex.connectivity import PROJECTIONS
from insectnav.experiments.stone2017_path_integration import ed_6
from insectnav.experiments.stone2017_path_integration.connection_signs import measure_signs
from insectnav.experiments.stone2017_path_integration.ed_6 import POPULATIONS, Cell, fit_sigmoid
from small_runs import same_bits, simulated, verdicts_of

N_SAMPLES = 600
# Sign and matrix of each projection as the methods of the paper have them.
EXPECTED_SIGNS = {
    "tl_to_cl1": -np.eye(16),
    "cl1_to_tb1": oracle.WEIGHTS["W_CL1_TB1"],
    "tb1_to_tb1": -oracle.WEIGHTS["W_TB1_TB1"],
    "tn_to_cpu4": oracle.WEIGHTS["W_TN_CPU4"],
    "tb1_to_cpu4": -oracle.WEIGHTS["W_TB1_CPU4"],
    "cpu4_to_pontine": oracle.WEIGHTS["W_CPU4_pontin"],
    "cpu4_to_cpu1": oracle.WEIGHTS["W_CPU4_CPU1"],
    "pontine_to_cpu1": -oracle.WEIGHTS["W_pontin_CPU1"],
    "tb1_to_cpu1": -oracle.WEIGHTS["W_TB1_CPU1"],
    "cpu1_to_motor": oracle.WEIGHTS["W_motor"] * [[1.0], [-1.0]],
}


@pytest.fixture(scope="module")
def results():
    return simulated(ed_6, [Cell(noise=noise, n_samples=N_SAMPLES) for noise in (0.0, 0.1)])


def test_small_run_gives_all_verdicts(results):
    verdicts = verdicts_of(ed_6, "stone2017-ed-6", results)
    assert all(v.verdict == "agrees" for v in verdicts)  # all is exact but the noise, which has an error


def test_same_seed_same_bits():
    assert same_bits(ed_6, Cell(noise=0.1, n_samples=20))


@pytest.mark.parametrize("population", [name for name in POPULATIONS if name != "tn2"])
def test_responses_without_noise_are_the_sigmoids_of_the_oracle(results, population: str):
    rank = POPULATIONS.index(population)
    slope, bias = (getattr(oracle.THESIS, f"{word}_{population}") for word in ("slope", "bias"))
    expected = oracle.sigmoid(results["input"][0, rank], slope, bias)
    np.testing.assert_allclose(results["output"][0, rank], expected, atol=1e-12)


def test_flow_cells_are_rectified(results):
    rank = POPULATIONS.index("tn2")
    flow = results["input"][0, rank]
    assert flow.min() < -0.5
    assert flow.max() > 0.5
    np.testing.assert_allclose(results["output"][0, rank], np.maximum(flow, 0.0), atol=1e-12)


@pytest.mark.parametrize(("slope", "bias"), [(6.8, 3.0), (3.0, -0.5), (7.5, -1.0)])
def test_fit_finds_the_sigmoid(slope: float, bias: float):
    current = np.random.default_rng(1).uniform(-1.0, 1.0, 50)
    assert fit_sigmoid(current, oracle.sigmoid(current, slope, bias)) == pytest.approx((slope, bias), rel=1e-9)


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_measured_signs_are_those_of_the_methods(projection: str):
    np.testing.assert_array_equal(measure_signs()[projection], np.sign(EXPECTED_SIGNS[projection]))
    np.testing.assert_array_equal(getattr(THESIS.connectivity, projection), np.abs(EXPECTED_SIGNS[projection]))


def test_synapses_are_counted(results):
    rows = {row["population"]: row for row in ed_6.summarise(results)}
    counts = {name: (row["n_excitatory_synapses"], row["n_inhibitory_synapses"]) for name, row in rows.items()}
    # CPU4 to 16 pontine and 16 CPU1 cells; TB1 to 7 others each and twice to 16; half of CPU1 turns to either side.
    expected = {"tl": (0, 16), "cl1": (16, 0), "tb1": (0, 88), "cpu4": (32, 0), "pontine": (0, 16), "cpu1": (8, 8)}
    assert counts == expected | {"tn2": (16, 0)}


def test_noise_is_that_of_the_cell(results):
    for row in ed_6.summarise(results):
        # SD of n normal numbers: known to 1 in √(2 n); four such errors, and 1 % for what is clipped
        assert row["noise_sd"] == pytest.approx(0.1, rel=4.0 / np.sqrt(2.0 * row["n_noise"]) + 0.01)
