"""Six disturbances: each does what it says, held against the plain oracle, closed forms and symmetry."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

import oracle
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.experiments.stone2017_path_integration import ed_9a
from insectnav.experiments.stone2017_path_integration.ed_9a import CONSTANT_FLOW, VALUES, Cell, filter_noise
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(panel="noise", value=0.1, preset="thesis", noise=0.1, n_trials=4)
NONE = {"compass": 0.0, "flow": 45.0, "weights": 0.0, "speed": 1.0, "filter": 1.0}
FORM = {"weights": "signs kept", "filter": "clean"}


@pytest.fixture(scope="module")
def results():
    return simulated(ed_9a, [replace(cell, n_trials=4) for cell in ed_9a.grid("quick")])


def test_small_run_gives_all_verdicts(results):
    verdicts_of(ed_9a, "stone2017-ed-9a", results)


def test_same_seed_same_bits():
    assert same_bits(ed_9a, replace(SMALL, panel="weights", value=0.2, form="unclipped"))


def test_full_grid_has_the_published_size():
    cells = ed_9a.grid("full")
    assert {cell.n_trials for cell in cells} == {1000}
    for panel, values in VALUES.items():
        assert {cell.value for cell in cells if cell.panel == panel} == set(values)
        noises = {cell.noise for cell in cells if cell.panel == panel}
        assert noises == ({0.0, 0.1, 0.2, 0.3, 0.4} if panel == "noise" else {0.0, 0.1})


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("panel", NONE)
def test_no_disturbance_is_the_plain_circuit(panel: str, noise: float):
    plain = ed_9a.simulate(replace(SMALL, value=noise, noise=noise), 3)
    none = replace(SMALL, panel=panel, value=NONE[panel], form=FORM.get(panel, ""), noise=noise)
    np.testing.assert_array_equal(ed_9a.simulate(none, 3)["closest_distance"][1], plain["closest_distance"][1])


def test_both_filters_are_one_without_noise():
    """The slip of the 2017 code is about noise alone."""
    clean, slip = (
        ed_9a.simulate(replace(SMALL, panel="filter", value=10.0, noise=0.0, form=form), 0)
        for form in ("clean", "code-2017")
    )
    np.testing.assert_array_equal(clean["closest_distance"][1], slip["closest_distance"][1])
    assert clean["tn2_sd"][1] == pytest.approx(0.0, abs=1e-6)


def clipped_sd(sd: float) -> float:
    """SD of a normal rate about the middle of 0 to 1, clipped there: ∫ x² over the middle, and the two ends."""
    c = 0.5 / sd
    inside = sd**2 * (2.0 * norm.cdf(c) - 1.0 - 2.0 * c * norm.pdf(c))
    return float(np.sqrt(inside + 2.0 * 0.25 * norm.sf(c)))


@pytest.mark.parametrize("n_steps", [1.0, 2.0, 5.0, 10.0, 20.0])
def test_noise_of_tn2_is_that_of_an_autoregression(n_steps: float):
    """Noise that goes into the filter's state grows to σ / √(1 − (1 − 1/n)²); behind a clean filter it stays σ."""
    assert CONSTANT_FLOW == 0.5
    assert filter_noise(1.0, 0.1) == pytest.approx(0.1)
    cell = replace(SMALL, panel="filter", value=n_steps, n_trials=1)
    clean, slip = (float(ed_9a.simulate(replace(cell, form=form), 0)["tn2_sd"][1]) for form in ("clean", "code-2017"))
    n_samples = 2 * ed_9a.N_LISTENED * (ed_9a.LISTENED - ed_9a.SETTLING)
    n_independent = n_samples / (2.0 * n_steps)  # correlated over n steps
    assert clean == pytest.approx(clipped_sd(0.1), rel=4.0 / np.sqrt(2.0 * n_samples))
    assert slip == pytest.approx(clipped_sd(filter_noise(n_steps, 0.1)), rel=4.0 / np.sqrt(2.0 * n_independent))


def oracle_trial(velocity_times: float, phi_tn: float) -> tuple[float, np.ndarray]:
    """Closest distance and decoded over true distance of route 0, without noise, by the plain implementation."""
    heading, velocity = (array[0].astype(float) for array in route_arrays(1, N_STEPS, RouteParams(), 0, "float32"))
    params = oracle.OracleParams(phi_tn=phi_tn)
    trial = oracle.run_trial(heading, velocity * velocity_times, 0, params)
    _, distance = oracle.decode(trial["memory_at_turn"], params)
    return distance / np.hypot(*trial["position"][N_STEPS - 1])


@pytest.mark.parametrize(
    ("panel", "value", "speed", "phi_tn"), [("speed", 1.8, 1.8, np.pi / 4), ("flow", 67.5, 1.0, 0.375 * np.pi)]
)
def test_decoded_distance_is_that_of_the_oracle(panel: str, value: float, speed: float, phi_tn: float):
    arrays = ed_9a.simulate(replace(SMALL, panel=panel, value=value, noise=0.0, n_trials=1), 0)
    assert arrays["decoded_over_true"][1][0] == pytest.approx(oracle_trial(speed, phi_tn), rel=2e-3)


def test_variance_is_the_square_of_the_sd():
    """0.04 as a variance is 0.2 as an SD, bit for bit."""
    sd = ed_9a.simulate(replace(SMALL, panel="weights", value=0.2, form="signs kept"), 0)
    variance = ed_9a.simulate(replace(SMALL, panel="weights", value=0.2**2, form="variance"), 0)
    np.testing.assert_allclose(variance["closest_distance"][1], sd["closest_distance"][1], rtol=1e-3)


def test_table_gives_mean_and_spread_of_the_trials(results):
    for row, distance in zip(ed_9a.summarise(results), results["closest_distance"].astype(float), strict=True):
        mean = sum(distance) / len(distance)
        assert row["mean"] == pytest.approx(mean)
        assert row["sd"] == pytest.approx(np.sqrt(sum((d - mean) ** 2 for d in distance) / (len(distance) - 1)))


def test_best_angle_is_uncertain_where_two_means_are_equal():
    flat = {angle: {"mean": 5.0, "mean_standard_error": 1.0} for angle in ed_9a.ANGLES_DEG}
    _, error = ed_9a._best(flat)
    assert error == pytest.approx(np.std(ed_9a.ANGLES_DEG), rel=0.15)  # any of the nine; 400 draws
    clear = flat | {22.5: {"mean": -5.0, "mean_standard_error": 0.1}}
    assert ed_9a._best(clear) == (22.5, 0.0)
