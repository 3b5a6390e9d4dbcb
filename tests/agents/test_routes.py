"""Random foraging trips: the published recursion, its statistics, and streams that depend on the trial alone."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from scipy import stats
from scipy.interpolate import CubicSpline

from insectnav.agents import MotionParams, RouteParams, move, random_routes
from insectnav.checks import InputError

N_STEPS = 1500
DRAG = 0.15


def accelerations(heading: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Thrust of each step but the first, along the heading; fails where some of it points elsewhere."""
    forward = np.stack([np.sin(heading), np.cos(heading)], axis=-1)[..., 1:, :]
    push = velocity[..., 1:, :] / (1 - DRAG) - velocity[..., :-1, :]
    along = np.sum(push * forward, axis=-1)
    np.testing.assert_allclose(push, along[..., None] * forward, rtol=0, atol=1e-13)
    return along


def knot_values(acceleration: np.ndarray, n_knots: int) -> tuple[np.ndarray, float]:
    """Values (..., n_knots) of the not-a-knot spline that runs through all accelerations, and its largest misfit."""
    n_steps = acceleration.shape[-1] + 1
    basis = CubicSpline(np.linspace(0, n_steps - 1, n_knots), np.eye(n_knots), bc_type="not-a-knot")(
        np.arange(1, n_steps)
    )
    values = np.linalg.lstsq(basis, acceleration.reshape(-1, n_steps - 1).T, rcond=None)[0]
    misfit = np.abs(basis @ values - acceleration.reshape(-1, n_steps - 1).T).max()
    return values.T.reshape(*acceleration.shape[:-1], n_knots), float(misfit)


def rotations(heading: np.ndarray) -> np.ndarray:
    steps = np.diff(heading, axis=-1)
    return steps - 2 * np.pi * np.round(steps / (2 * np.pi))


@pytest.fixture(scope="module")
def routes() -> tuple[np.ndarray, np.ndarray]:
    """Headings (400, 1500) and velocities (400, 1500, 2)."""
    made = random_routes(400, N_STEPS, seed=12)
    return made.heading.values, made.velocity.values


@pytest.mark.data
@pytest.mark.parametrize("route", [1, 2])
def test_published_routes_obey_the_recursion(route: int, golden) -> None:
    arrays = golden("central_complex_routes")
    heading, velocity = arrays[f"heading_{route}"], arrays[f"velocity_{route}"]
    acceleration = accelerations(heading, velocity)
    values, misfit = knot_values(acceleration, N_STEPS // 50)
    assert misfit < 1e-13
    assert np.all((values >= 0) & (values <= 0.15))
    turns = rotations(heading)
    for t in range(1, N_STEPS):
        params = MotionParams(drag=DRAG, acceleration=max(acceleration[t - 1], 0))
        theta, v = move(heading[t - 1], velocity[t - 1], turns[t - 1], params)
        assert abs(theta - heading[t]) < 1e-13
        if acceleration[t - 1] >= 0:
            np.testing.assert_allclose(v, velocity[t], rtol=0, atol=1e-13)


def test_route_starts_at_rest_facing_north(routes: tuple) -> None:
    heading, velocity = routes
    assert np.all(heading[:, 0] == 0)
    assert np.all(velocity[:, 0] == 0)
    assert np.all(np.abs(heading) <= np.pi)
    assert np.all(heading[:, 1] != 0)


def test_acceleration_runs_through_uniform_values(routes: tuple) -> None:
    values, misfit = knot_values(accelerations(*routes), N_STEPS // 50)
    assert misfit < 1e-12
    assert values.min() > 0
    assert values.max() < 0.15
    assert stats.kstest(values.ravel() / 0.15, "uniform").pvalue > 1e-4
    between = np.corrcoef(values, rowvar=False) - np.eye(values.shape[1])
    assert np.abs(between).max() < 5 / np.sqrt(len(values))


def test_acceleration_between_the_knots_is_not_clipped(routes: tuple) -> None:
    acceleration = accelerations(*routes)
    assert acceleration.min() < -0.001
    assert acceleration.max() > 0.151


def test_turns_have_the_published_spread(routes: tuple) -> None:
    turns = rotations(routes[0])
    angles = np.linspace(-np.pi, np.pi, 20_001)[:-1]
    density = np.exp(100 * (np.cos(angles) - 1))
    variance = np.sum(density * angles**2) / np.sum(density) / (1 - 0.4**2)
    n_independent = turns.size * (1 - 0.4**2) / (1 + 0.4**2)  # squares of the turns are correlated by 0.4²
    assert turns.var() / variance == pytest.approx(1, abs=5 * np.sqrt(2 / n_independent))
    assert abs(turns.mean()) < 5 * np.sqrt(variance / turns.size) * np.sqrt(1.4 / 0.6)


@pytest.mark.parametrize("persistence", [-0.5, 0.0, 0.4, 0.9])
def test_a_share_of_each_turn_carries_over_to_the_next(persistence: float) -> None:
    made = random_routes(100, 1000, RouteParams(turn_persistence=persistence, turn_concentration=400.0), seed=2)
    turns = rotations(made.heading.values)[:, 100:]
    before, after = turns[:, :-1].ravel(), turns[:, 1:].ravel()
    assert np.corrcoef(before, after)[0, 1] == pytest.approx(persistence, abs=5 / np.sqrt(before.size))
    fresh = turns[:, 1:] - persistence * turns[:, :-1]
    assert abs(np.corrcoef(fresh[:, 1:].ravel(), fresh[:, :-1].ravel())[0, 1]) < 5 / np.sqrt(fresh.size)


def test_first_turn_goes_into_the_filter_only(routes: tuple) -> None:
    heading = random_routes(4000, 2, seed=1).heading.values[:, 1]  # 0.4 ε_0 + ε_1
    assert heading.std() / np.sqrt(1.16 * 0.01) == pytest.approx(1, abs=5 / np.sqrt(2 * 4000) + 0.005)


@pytest.mark.parametrize(
    ("n_steps", "n_knots"), [(5, 4), (60, 4), (199, 4), (200, 4), (201, 4), (249, 4), (250, 5), (500, 10)]
)
def test_number_of_knots_grows_with_the_route(n_steps: int, n_knots: int) -> None:
    made = random_routes(8, n_steps, seed=3)
    acceleration = accelerations(made.heading.values, made.velocity.values)
    values, misfit = knot_values(acceleration, n_knots)
    assert misfit < 1e-12
    assert np.all((values > 0) & (values < 0.15))
    if n_knots > 4:
        assert knot_values(acceleration, n_knots - 1)[1] > 1e-3


def test_parameters_shape_the_route() -> None:
    params = RouteParams(lowest_acceleration=0.2, highest_acceleration=0.3, steps_per_knot=25, drag=0.5)
    made = random_routes(20, 400, params, seed=5)
    heading, velocity = made.heading.values, made.velocity.values
    forward = np.stack([np.sin(heading), np.cos(heading)], axis=-1)[:, 1:]
    acceleration = np.sum((velocity[:, 1:] / 0.5 - velocity[:, :-1]) * forward, axis=-1)
    values, misfit = knot_values(acceleration, 16)
    assert misfit < 1e-12
    assert np.all((values > 0.2) & (values < 0.3))


@pytest.mark.parametrize("n_steps", [1, 2, 3])
def test_shortest_routes(n_steps: int) -> None:
    made = random_routes(3, n_steps, seed=0)
    assert made.heading.shape == (3, n_steps)
    assert np.all(made.heading.values[:, 0] == 0)
    assert np.all(np.isfinite(made.velocity.values))


def test_dataset_names_its_axes_and_says_how_it_was_made() -> None:
    made = random_routes(3, 7, RouteParams(turn_persistence=0.3), seed=9)
    assert made.heading.dims == ("trial", "step")
    assert made.velocity.dims == ("trial", "step", "xy")
    assert made.heading.dtype == made.velocity.dtype == "float64"
    assert made.trial.values.tolist() == [0, 1, 2]
    assert made.step.values.tolist() == list(range(7))
    assert made.xy.values.tolist() == ["x", "y"]
    assert made.heading.attrs["units"] == "rad"
    assert (made.attrs["seed"], made.attrs["route_turn_persistence"]) == (9, 0.3)


@pytest.mark.parametrize("n_more", [17, 40, 400])
def test_route_does_not_depend_on_how_many_there_are(n_more: int) -> None:
    few, many = random_routes(17, 300, seed=7), random_routes(n_more, 300, seed=7)
    np.testing.assert_array_equal(few.heading, many.heading[:17])
    np.testing.assert_array_equal(few.velocity, many.velocity[:17])


def test_seed_decides_the_route() -> None:
    first, again, other = (random_routes(20, 50, seed=seed).heading.values for seed in (1, 1, 2))
    np.testing.assert_array_equal(again, first)
    assert not np.any(other[:, 1:] == first[:, 1:])
    assert len(np.unique(first[:, 1])) == 20


def test_single_precision_is_the_same_route_rounded() -> None:
    double, single = random_routes(20, 300, seed=4), random_routes(20, 300, seed=4, dtype="float32")
    assert single.heading.dtype == single.velocity.dtype == "float32"
    np.testing.assert_array_equal(single.heading, double.heading.astype("float32"))
    np.testing.assert_array_equal(single.velocity, double.velocity.astype("float32"))


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((0, 10), {}, "n_trials is 0, expected a whole number of at least 1"),
        ((10, 0), {}, "n_steps is 0"),
        ((1.5, 10), {}, "n_trials is 1.5"),
        ((2, "many"), {}, "n_steps is 'many'"),
        ((2, 10), {"seed": -1}, "seed is -1"),
        ((2, 10), {"seed": 0.5}, "seed is 0.5"),
        ((2, 10), {"dtype": "float16"}, "dtype 'float16' is unknown"),
        ((2, 10), {"dtype": "flaot32"}, r"dtype 'flaot32' is unknown.*did you mean float32\?"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(arguments: tuple, options: dict, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        random_routes(*arguments, **options)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("turn_concentration", 0.0),
        ("turn_concentration", -1.0),
        ("turn_persistence", 1.0),
        ("turn_persistence", np.nan),
        ("highest_acceleration", np.inf),
        ("lowest_acceleration", np.nan),
        ("steps_per_knot", 0),
        ("steps_per_knot", 2.5),
        ("drag", 1.1),
    ],
)
def test_constant_out_of_its_range_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"^{name} is "):
        RouteParams(**{name: value})


def test_constants_are_the_published_ones_and_frozen() -> None:
    expected = {
        "turn_concentration": 100.0,
        "turn_persistence": 0.4,
        "lowest_acceleration": 0.0,
        "highest_acceleration": 0.15,
        "steps_per_knot": 50,
        "drag": 0.15,
    }
    assert vars(RouteParams()) == expected
    with pytest.raises(FrozenInstanceError):
        RouteParams().drag = 0.2
