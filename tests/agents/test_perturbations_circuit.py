"""Weights, speed filter and memory under an experimenter's hands: what is drawn, what is felt, what is exact."""

from dataclasses import replace

import numpy as np
import pytest
import xarray
from scipy import special, stats

from insectnav.agents import FilterSpeed, FreezeMemory, SetMemory, WeightNoise, random_routes, run_trials
from insectnav.central_complex import POPULATIONS, THESIS, circuit_params
from insectnav.central_complex.connectivity import PROJECTIONS, STANDARD_WIRING

N_OUT, N_HOME, N_TRIALS = 80, 60, 100
MOTOR_SIGNS = np.repeat([1.0, -1.0], 8)


@pytest.fixture(scope="module")
def routes() -> xarray.Dataset:
    return random_routes(N_TRIALS, N_OUT, seed=7)


def fly(routes: object, *perturbations, **options) -> xarray.Dataset:
    options = {"n_inbound": N_HOME, "noise": 0.1, "seed": 2, "dtype": "float64", "record": POPULATIONS} | options
    return run_trials(routes, perturbations=perturbations, **options)


def motor_factors(out: xarray.Dataset) -> np.ndarray:
    """How much each weight from CPU1 to the motor differs from the mean, (trial, 16), by linear algebra."""
    weights = []
    for rates, turns in zip(out.cpu1.values, out.motor.values, strict=True):
        found, _, rank, _ = np.linalg.lstsq(rates, turns)
        assert rank == 16
        np.testing.assert_allclose(rates @ found, turns, rtol=0, atol=1e-12)  # the same all through the trial
        weights.append(found)
    return np.array(weights) / (THESIS.motor_gain * MOTOR_SIGNS)


def compass_factors(out: xarray.Dataset) -> np.ndarray:
    """How much each weight from TL to CL1 differs from the mean, (trial, 16), from noise-free rates."""
    drive = (special.logit(out.cl1.values) + THESIS.cl1_bias) / THESIS.cl1_slope
    factors = -drive / out.tl.values
    np.testing.assert_allclose(factors, factors[:, :1].repeat(factors.shape[1], 1), rtol=0, atol=1e-9)
    return factors[:, 0]


def largest_gap_allowed(n: int) -> float:
    """Kolmogorov–Smirnov distance that chance exceeds once in a million (Dvoretzky, Kiefer & Wolfowitz; Massart)."""
    return np.sqrt(np.log(2e6) / (2.0 * n))


# Weights.


def test_weights_are_normal_around_their_means(routes: xarray.Dataset) -> None:
    factors = motor_factors(fly(routes, WeightNoise(sd=0.2, keep_signs=False, projections=["cpu1_to_motor"])))
    assert np.unique(factors.round(9)).size == factors.size  # every synapse of every trial its own
    assert stats.kstest(factors.ravel(), stats.norm(1.0, 0.2).cdf).statistic < largest_gap_allowed(factors.size)
    lag = np.corrcoef(factors[:, :-1].ravel(), factors[:, 1:].ravel())[0, 1]
    assert abs(lag) < 5.0 / np.sqrt(factors[:, 1:].size)


def test_signs_are_kept_unless_told_otherwise(routes: xarray.Dataset) -> None:
    only = {"sd": 1.0, "projections": ("tl_to_cl1",)}
    free = compass_factors(fly(routes, WeightNoise(keep_signs=False, **only), noise=0.0))
    kept = compass_factors(fly(routes, WeightNoise(**only), noise=0.0))
    np.testing.assert_allclose(kept, np.maximum(free, 0.0), rtol=0, atol=1e-9)
    n = free.size
    below = stats.norm(1.0, 1.0).cdf(0.0)
    assert abs(np.mean(free < 0.0) - below) < 5.0 * np.sqrt(below * (1.0 - below) / n)
    assert stats.kstest(free.ravel(), stats.norm(1.0, 1.0).cdf).statistic < largest_gap_allowed(n)


def test_a_synapse_draws_the_same_whichever_others_do(routes: xarray.Dataset) -> None:
    alone = WeightNoise(sd=0.1, projections=("cpu1_to_motor",))
    np.testing.assert_allclose(
        motor_factors(fly(routes, alone)), motor_factors(fly(routes, WeightNoise(sd=0.1))), rtol=0, atol=1e-9
    )


def test_drawn_weights_act_as_a_circuit_with_these_weights(routes: xarray.Dataset) -> None:
    noise = WeightNoise(sd=0.3, projections=("tl_to_cl1", "cpu1_to_motor"))
    drawn = fly(routes, noise, noise=0.0)
    at_compass, at_motor = compass_factors(drawn), motor_factors(fly(routes, noise))
    for trial in (0, 41):
        wiring = replace(
            STANDARD_WIRING,
            tl_to_cl1=STANDARD_WIRING.tl_to_cl1 * at_compass[trial],
            cpu1_to_motor=STANDARD_WIRING.cpu1_to_motor * at_motor[trial],
        )
        rebuilt = fly(routes.isel(trial=[trial]), circuit=replace(THESIS, connectivity=wiring), noise=0.0)
        for name in ("position", "memory", "tb1", "motor"):
            np.testing.assert_allclose(rebuilt[name][0], drawn[name][trial], rtol=0, atol=1e-7, err_msg=name)


def test_speed_and_pontine_synapses_have_no_noise_unless_named(routes: xarray.Dataset) -> None:
    assert set(WeightNoise(sd=0.1).projections) == set(PROJECTIONS) - {
        "tn_to_cpu4", "cpu4_to_pontine", "pontine_to_cpu1",
    }  # fmt: skip
    few = routes.isel(trial=slice(0, 9))
    for projections, is_exact in ((None, True), (("cpu4_to_pontine",), False)):
        out = fly(few, WeightNoise(sd=0.2, projections=projections), noise=0.0)
        expected = special.expit(THESIS.pontine_slope * out.cpu4.values - THESIS.pontine_bias)
        assert (np.abs(out.pontine.values - expected).max() < 1e-12) == is_exact


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("none", [WeightNoise(sd=0.0), WeightNoise(sd=3.0, projections=())])
def test_no_noise_of_weights_changes_not_a_bit(none: WeightNoise, dtype: str, routes: xarray.Dataset) -> None:
    xarray.testing.assert_equal(fly(routes, none, dtype=dtype), fly(routes, dtype=dtype))


def test_weights_depend_on_the_seed_and_not_on_the_noise_of_cells(routes: xarray.Dataset) -> None:
    few, noise = routes.isel(trial=slice(0, 5)), WeightNoise(sd=0.2)
    expected = motor_factors(fly(few, noise))
    np.testing.assert_allclose(motor_factors(fly(few, noise, noise=0.05)), expected, rtol=0, atol=1e-9)
    assert np.abs(motor_factors(fly(few, noise, seed=3)) - expected).min() > 1e-6


# Speed filter: TN1 without noise shows what TN2 is given, s = 1 − 2 · TN1; TN2's noise is what it shows above that.


@pytest.mark.parametrize("form", ["clean", "code-2017"])
def test_filtered_flow_follows_its_recursion(form: str, routes: xarray.Dataset) -> None:
    n = 6
    options = {"noise": {"tn2": 0.02}, "n_inbound": 0}
    flow = 1.0 - 2.0 * fly(routes, **options).tn1.values
    out = fly(routes, FilterSpeed(n_steps=n, form=form), **options)
    given, shown = 1.0 - 2.0 * out.tn1.values, out.tn2.values
    np.testing.assert_allclose(given[:, 0], flow[:, 0] / n, rtol=0, atol=1e-12)
    is_unclipped = (shown > 0.0) & (shown < 1.0) & (out.tn1.values > 0.0) & (out.tn1.values < 1.0)
    is_unclipped = is_unclipped[:, :-1] & (flow[:, 1:] < 1.0) & (out.tn1.values[:, 1:] < 1.0)
    kept = shown if form == "code-2017" else given
    expected = flow[:, 1:] / n + (1.0 - 1.0 / n) * kept[:, :-1]
    assert is_unclipped.mean() > 0.5
    np.testing.assert_allclose(given[:, 1:][is_unclipped], expected[is_unclipped], rtol=0, atol=1e-12)


@pytest.mark.parametrize("form", ["clean", "code-2017"])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_filter_of_one_step_changes_not_a_bit(form: str, dtype: str, routes: xarray.Dataset) -> None:
    xarray.testing.assert_equal(fly(routes, FilterSpeed(n_steps=1, form=form), dtype=dtype), fly(routes, dtype=dtype))


def test_forms_of_the_filter_differ_in_noise_alone(routes: xarray.Dataset) -> None:
    clean, published = FilterSpeed(n_steps=9), FilterSpeed(n_steps=9, form="code-2017")
    xarray.testing.assert_equal(fly(routes, clean, noise=0.0), fly(routes, published, noise=0.0))
    # Noise that stays: the variance of s adds up to σ² Σ (1 − 1/n)^(2k) = σ² q / (1 − q), q = (1 − 1/n)², at rest.
    at_rest = np.zeros((N_TRIALS, 200)), np.zeros((N_TRIALS, 200, 2))
    given = 1.0 - 2.0 * fly(at_rest, published, n_inbound=0, noise={"tn2": 0.01}).tn1.values[:, -1]
    upper = given[given > 0.0]  # TN1 is clipped below
    q = (8.0 / 9.0) ** 2
    variance = 1e-4 * q / (1.0 - q)
    assert abs(np.mean(upper**2) / variance - 1.0) < 5.0 * np.sqrt(2.0 / upper.size)


# Memory.


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_memory_put_back_at_the_turn_leads_the_same_way_home(dtype: str, routes: xarray.Dataset) -> None:
    plain = fly(routes, dtype=dtype)
    forgotten = SetMemory(memory=np.linspace(0.0, 1.0, 16), step=40)
    put_back = SetMemory(memory=plain.memory_at_turn.values, step=N_OUT)
    out = fly(routes, forgotten, put_back, dtype=dtype)
    assert not np.array_equal(out.memory[:, 40], plain.memory[:, 40])
    for name in ("heading", "position", "closest_distance"):
        np.testing.assert_array_equal(out[name], plain[name], err_msg=name)
    np.testing.assert_array_equal(out.memory[:, N_OUT:], plain.memory[:, N_OUT:])


@pytest.mark.parametrize("mode", ["replace", "add", "subtract"])
def test_memory_is_set_at_the_start_of_its_step(mode: str, routes: xarray.Dataset) -> None:
    memory = np.random.default_rng(1).uniform(0.0, 1.0, (N_TRIALS, 16))
    out = fly(routes, FreezeMemory(), SetMemory(memory=memory, step=33, mode=mode))  # frozen, it shows what was set
    expected = {"replace": memory, "add": memory, "subtract": 1.0 - memory}[mode]  # M = ½ before
    np.testing.assert_array_equal(out.memory[:, :33], 0.5)
    np.testing.assert_allclose(out.memory[:, 33], expected, rtol=0, atol=1e-15)
    assert (out.memory[:, 33:] == out.memory[:, 33]).all()


def test_memory_stays_in_its_range(routes: xarray.Dataset) -> None:
    some = SetMemory(memory=np.repeat([0.9, 0.1], 8), mode="add")
    out = fly(routes, FreezeMemory(), some, some, some)
    np.testing.assert_array_equal(out.memory[0, 0], np.repeat([1.0, 0.0], 8))


def still(n_trials: int) -> tuple[np.ndarray, np.ndarray]:
    """Routes that end where they begin: a single step at rest."""
    return np.zeros((n_trials, 1)), np.zeros((n_trials, 1, 2))


def test_subtracted_memory_leads_from_the_nest_to_the_feeder() -> None:
    trip = run_trials(random_routes(100, 600, seed=1), n_inbound=0, seed=1)
    feeder, memory = trip.position.values[:, -1], trip.memory_at_turn.values
    options = {"n_inbound": 600, "seed": 2}
    found = run_trials(still(100), perturbations=[SetMemory(memory=memory, step=1, mode="subtract")], **options)
    closest = np.linalg.norm(found.position.values - feeder[:, None], axis=-1).min(axis=1)
    assert np.median(np.linalg.norm(feeder, axis=-1)) > 40.0
    assert np.median(closest) < 20.0
    lost = run_trials(still(100), perturbations=[SetMemory(memory=memory, step=1, mode="add")], **options)
    assert np.median(np.linalg.norm(lost.position.values - feeder[:, None], axis=-1).min(axis=1)) > 20.0


def test_subtracted_memory_makes_a_shortcut_between_feeders() -> None:
    other = run_trials(random_routes(100, 600, seed=1), n_inbound=0, seed=1)
    feeder, routes = other.position.values[:, -1], random_routes(100, 600, seed=5)
    shortcut = SetMemory(memory=other.memory_at_turn.values, step=600, mode="subtract")
    found = run_trials(routes, perturbations=[shortcut], n_inbound=800, seed=2).position.values[:, 599:]
    closest = np.linalg.norm(found - feeder[:, None], axis=-1).min(axis=1)
    assert np.median(np.linalg.norm(found[:, 0] - feeder, axis=-1)) > 60.0
    assert np.median(closest) < 20.0


@pytest.mark.parametrize("variant", ["partially-holonomic", "fully-holonomic", "no-pontine"])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_frozen_memory_changes_not_a_bit(variant: str, dtype: str, routes: xarray.Dataset) -> None:
    frozen = FreezeMemory(first_step=30, end_step=100), FreezeMemory(first_step=120)
    memory = fly(routes, *frozen, dtype=dtype, circuit=circuit_params(variant)).memory.values
    free = fly(routes, dtype=dtype, circuit=circuit_params(variant)).memory.values
    np.testing.assert_array_equal(memory[:, :30], free[:, :30])
    assert (memory[:, 30:100] == memory[:, 29:30]).all()
    assert (memory[:, 100] != memory[:, 99]).any(axis=1).all()
    assert (memory[:, 120:] == memory[:, 119:120]).all()


def test_fixed_memory_makes_a_migrant_hold_its_heading() -> None:
    bump = 0.5 + 0.2 * np.cos(np.arange(16) % 8 * np.pi / 4)
    fixed = [SetMemory(memory=bump), FreezeMemory()]
    path = run_trials(still(50), perturbations=fixed, n_inbound=1000, seed=4).position.values
    length = np.linalg.norm(np.diff(path, axis=1), axis=-1).sum(axis=1)
    straightness = np.linalg.norm(path[:, -1], axis=-1) / length
    assert straightness.min() > 0.8
    free = run_trials(still(50), perturbations=[SetMemory(memory=bump)], n_inbound=1000, seed=4).position.values
    assert np.linalg.norm(free[:, -1], axis=-1).max() < 0.5 * np.linalg.norm(path[:, -1], axis=-1).min()
