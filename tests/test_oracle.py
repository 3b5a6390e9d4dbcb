"""The plain reference circuit agrees with the published code's numbers and with the laws of the model."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from oracle import (
    CODE_2017,
    RATES,
    THESIS,
    VARIANTS,
    WEIGHTS,
    OracleParams,
    decode,
    initial_state,
    move,
    random_route,
    run_trial,
    step,
    unit_vector,
    variant_params,
    wrap,
)

GOLDEN_VARIANTS = ("partially-holonomic", "fully-holonomic")
GOLDEN_LAYERS = {name: name for name in RATES if name not in ("tl", "pontine")} | {"tl": "tl2"}
N_OUTBOUND = 1500


@pytest.fixture(
    scope="module", params=[(v, r) for v in GOLDEN_VARIANTS for r in (1, 2)], ids=lambda p: f"{p[0]}-{p[1]}"
)
def golden_trial(request: pytest.FixtureRequest, golden: Callable) -> tuple[dict, dict, OracleParams]:
    """Our trial, the published code's, and the parameters of both."""
    variant, route = request.param
    routes = golden("central_complex_routes")
    published = golden(f"central_complex_{variant.replace('-', '_')}")
    prefix = f"r{route}_"
    published = {key.removeprefix(prefix): value for key, value in published.items() if key.startswith(prefix)}
    params = variant_params(variant, CODE_2017)
    ours = run_trial(routes[f"heading_{route}"], routes[f"velocity_{route}"], N_OUTBOUND, params, record=True)
    return ours, published, params


@pytest.mark.data
def test_connection_matrices_are_the_published_ones(golden: Callable) -> None:
    for name, matrix in golden("central_complex_weights").items():
        np.testing.assert_allclose(WEIGHTS[name], matrix, rtol=0, atol=1e-15, err_msg=name)


@pytest.mark.data
def test_every_layer_is_the_published_one(golden_trial: tuple) -> None:
    ours, published, _ = golden_trial
    for name, theirs in GOLDEN_LAYERS.items():
        rates = ours[name]
        # Out of reach of the steering feedback nothing amplifies rounding.
        np.testing.assert_allclose(rates[:20], published[f"first20_{theirs}"], rtol=0, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(
            rates[:N_OUTBOUND:50], published[f"out50_{theirs}"], rtol=0, atol=1e-12, err_msg=name
        )
        np.testing.assert_allclose(
            rates[N_OUTBOUND + 49 :: 50], published[f"home50_{theirs}"], rtol=0, atol=1e-8, err_msg=name
        )


@pytest.mark.data
def test_memory_and_home_vector_are_the_published_ones(golden_trial: tuple) -> None:
    ours, published, params = golden_trial
    np.testing.assert_allclose(ours["memory_at_turn"], published["final_memory"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(ours["tb1"][N_OUTBOUND - 1], published["final_tb1"], rtol=0, atol=1e-12)
    mirrored_bearing, distance = published["decoded"]
    bearing, ours_distance = decode(ours["memory_at_turn"], params)
    assert abs(wrap(bearing + mirrored_bearing)) < 1e-12
    assert ours_distance == pytest.approx(distance, abs=1e-8)


@pytest.mark.data
def test_whole_way_home_is_the_published_one(golden_trial: tuple) -> None:
    ours, published, _ = golden_trial
    np.testing.assert_allclose(ours["heading"][N_OUTBOUND - 1 :], published["home_heading"], rtol=0, atol=1e-8)
    velocity = np.diff(ours["position"], axis=0)[N_OUTBOUND - 2 :]
    np.testing.assert_allclose(velocity, published["home_velocity"], rtol=0, atol=1e-8)


@pytest.mark.data
@pytest.mark.parametrize("route", [1, 2])
def test_published_routes_follow_the_route_rule(route: int, golden: Callable) -> None:
    routes = golden("central_complex_routes")
    heading, velocity = routes[f"heading_{route}"], routes[f"velocity_{route}"]
    forward = np.column_stack([np.sin(heading), np.cos(heading)])[1:]
    push = velocity[1:] / (1 - THESIS.drag) - velocity[:-1]
    acceleration = np.sum(push * forward, axis=1)
    np.testing.assert_allclose(push, acceleration[:, None] * forward, rtol=0, atol=1e-14)
    times = np.arange(N_OUTBOUND)[1:]
    basis = CubicSpline(np.linspace(0, N_OUTBOUND - 1, 30), np.eye(30))(times)
    values = np.linalg.lstsq(basis, acceleration, rcond=None)[0]
    np.testing.assert_allclose(basis @ values, acceleration, rtol=0, atol=1e-13)
    assert np.all((values >= 0) & (values <= 0.15))


@pytest.mark.parametrize("seed", range(3))
def test_idealised_memory_holds_the_exact_vector(seed: int) -> None:
    rng = np.random.default_rng(seed)
    heading, velocity = random_route(150, rng)
    velocity = np.linalg.norm(velocity, axis=1)[:, None] * np.column_stack([np.sin(heading), np.cos(heading)])
    params = variant_params("idealised")
    bearing, distance = decode(run_trial(heading, velocity, 0, params)["memory_at_turn"], params)
    np.testing.assert_allclose(distance * unit_vector(bearing), velocity.sum(axis=0), rtol=0, atol=0.01)


@pytest.mark.parametrize("variant", VARIANTS)
def test_memory_and_rates_stay_between_zero_and_one(variant: str) -> None:
    rng = np.random.default_rng(1)
    heading, velocity = random_route(150, rng)
    trial = run_trial(heading, 3 * velocity, 150, variant_params(variant), noise=0.4, rng=rng, record=True)
    for name in RATES[:-1]:
        assert trial[name].min() >= 0, name
        assert trial[name].max() <= 1, name


@pytest.mark.parametrize("variant", VARIANTS)
def test_turning_the_world_by_one_cell_rolls_the_memory(variant: str) -> None:
    heading, velocity = random_route(100, np.random.default_rng(2))
    params = variant_params(variant)
    straight = run_trial(heading, velocity, 0, params)["memory_at_turn"]
    s, c = np.sin(np.pi / 4), np.cos(np.pi / 4)
    turned_velocity = velocity @ np.array([[c, -s], [s, c]])  # clockwise, as headings grow
    turned = run_trial(heading + np.pi / 4, turned_velocity, 0, params)["memory_at_turn"]
    np.testing.assert_allclose(turned.reshape(2, 8), np.roll(straight.reshape(2, 8), 1, axis=1), rtol=0, atol=1e-12)


@pytest.mark.parametrize("variant", VARIANTS)
def test_mirrored_route_is_homed_along_the_mirrored_path(variant: str) -> None:
    heading, velocity = random_route(150, np.random.default_rng(3))
    params = variant_params(variant)
    trial = run_trial(heading, velocity, 100, params)
    mirrored = run_trial(-heading, velocity * [-1, 1], 100, params)
    np.testing.assert_allclose(mirrored["position"], trial["position"] * [-1, 1], rtol=0, atol=1e-7)


def test_noise_is_drawn_once_per_noisy_cell() -> None:
    class CountingGenerator:
        n_draws = 0

        def normal(self, mean: float, sigma: float, size: int) -> np.ndarray:
            assert (mean, sigma) == (0, 0.1)
            self.n_draws += size
            return np.zeros(size)

    expected = {
        "partially-holonomic": 90,
        "non-holonomic": 90,
        "fully-holonomic": 92,  # and TN1
        "no-pontine": 76,  # and TN1, without the pontine cells
        "idealised": 76,
    }
    for variant, n_draws in expected.items():
        rng = CountingGenerator()
        step(*initial_state(), 0.3, np.array([0.1, 0.2]), variant_params(variant), noise=0.1, rng=rng)
        assert rng.n_draws == n_draws, variant
        step(*initial_state(), 0.3, np.array([0.1, 0.2]), variant_params(variant), noise=0.0, rng=rng)
        assert rng.n_draws == n_draws, variant


def test_noisy_agent_comes_home() -> None:
    # Published code at 10 % noise: mean closest distance 2.4 steps, SD 2.4.
    n_trials = 4
    closest = []
    for seed in range(n_trials):
        rng = np.random.default_rng(seed)
        heading, velocity = random_route(N_OUTBOUND, rng)
        trial = run_trial(heading, velocity, N_OUTBOUND, CODE_2017, noise=0.1, rng=rng)
        closest.append(np.linalg.norm(trial["position"][N_OUTBOUND:], axis=1).min())
    assert np.mean(closest) < 2.4 + 4 * 2.4 / np.sqrt(n_trials)


@pytest.mark.parametrize(("acceleration", "terminal_speed"), [(0.1, 0.567), (0.15, 0.85)])
def test_straight_flight_reaches_the_terminal_speed(acceleration: float, terminal_speed: float) -> None:
    heading, velocity = 0.7, np.zeros(2)
    for _ in range(200):
        heading, velocity = move(heading, velocity, 0.0, acceleration, THESIS.drag)
    np.testing.assert_allclose(velocity, terminal_speed * unit_vector(0.7), rtol=0, atol=5e-4)


def test_route_turns_are_filtered_von_mises_noise() -> None:
    n_routes = 2000
    rng = np.random.default_rng(4)
    headings = np.array([random_route(5, rng)[0] for _ in range(n_routes)])
    assert np.all(headings[:, 0] == 0)
    variance = 0.01  # of von Mises noise at kappa = 100, to 1 %
    bound = 4 / np.sqrt(2 * n_routes) + 0.01  # four standard errors of a standard deviation
    first_turn = headings[:, 1]  # keeps 0.4 of the draw at time 0
    assert first_turn.std() / np.sqrt(1.16 * variance) == pytest.approx(1, abs=bound)
    turns = np.diff(headings, axis=1)
    innovations = turns[:, 1:] - 0.4 * turns[:, :-1]
    assert innovations.std() / np.sqrt(variance) == pytest.approx(1, abs=bound)


def test_wrap_is_half_open() -> None:
    assert wrap(np.pi) == -np.pi
    assert wrap(-np.pi) == -np.pi
    assert wrap(np.nextafter(-np.pi, -4)) < np.pi
    assert wrap(0.5 + 4 * np.pi) == pytest.approx(0.5, abs=1e-14)


def test_unknown_variant_is_refused() -> None:
    with pytest.raises(ValueError, match="expected one of"):
        OracleParams(variant="holonomic")
