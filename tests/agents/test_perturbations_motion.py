"""Speed, compass, body and place of a disturbed animal; the symmetries of a trial, and the same bits in any batch."""

import numpy as np
import pytest
import xarray
from scipy import stats

from insectnav.agents import (
    Circle,
    ClampCells,
    CompassShift,
    Displace,
    FilterSpeed,
    FreezeMemory,
    ScaleSpeed,
    SetMemory,
    TurnBody,
    Wall,
    WeightNoise,
    random_routes,
    run_trials,
)
from insectnav.central_complex import POPULATIONS, VARIANTS, circuit_params

N_OUT, N_HOME, N_TRIALS = 80, 70, 37
DTYPES = ("float32", "float64")
MEMORIES = np.random.default_rng(5).uniform(0.3, 0.7, (N_TRIALS, 16))


@pytest.fixture(scope="module")
def routes() -> xarray.Dataset:
    return random_routes(N_TRIALS, N_OUT, seed=9)


def fly(routes: object, *perturbations, **options) -> xarray.Dataset:
    options = {"n_inbound": N_HOME, "noise": 0.1, "seed": 2, "record": POPULATIONS} | options
    return run_trials(routes, perturbations=perturbations, **options)


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return np.asarray(vectors) @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle from one heading to another."""
    return np.angle(np.exp(1j * (np.asarray(b) - np.asarray(a))))


# One at a time.


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    "nothing",
    [
        [ScaleSpeed(factor=1.0)],
        [ScaleSpeed(factor=4.0), ScaleSpeed(factor=0.25)],
        [CompassShift(shift=0.0, leg="both")],
        [TurnBody(offset=0.0, leg="both")],
        [Displace(step=50, by=(0.0, 0.0)), Displace(step=N_OUT + N_HOME, to=(1.0, 1.0))],
        [FreezeMemory(first_step=30, end_step=30), FreezeMemory(first_step=10**30)],
        [SetMemory(memory=np.zeros(16), step=N_OUT + N_HOME)],
        [Circle(centre=(1e5, 1e5), radius=10), Wall(start=(-1e4, 2e3), end=(1e4, 2e3))],
    ],
    ids=lambda nothing: type(nothing[0]).__name__,
)
def test_no_perturbation_at_all_changes_not_a_bit(nothing: list, dtype: str, routes: xarray.Dataset) -> None:
    xarray.testing.assert_equal(fly(routes, *nothing, dtype=dtype), fly(routes, dtype=dtype))


@pytest.mark.parametrize("dtype", DTYPES)
def test_faster_flight_is_a_longer_route(dtype: str, routes: xarray.Dataset) -> None:
    faster = fly(routes, ScaleSpeed(factor=2.0), dtype=dtype)  # doubling is exact
    xarray.testing.assert_equal(faster, fly((routes.heading.values, 2.0 * routes.velocity.values), dtype=dtype))
    plain = fly(routes, dtype=dtype)
    np.testing.assert_array_equal(faster.position[:, :N_OUT], 2.0 * plain.position[:, :N_OUT])


def test_compass_is_not_shifted_before_the_first_turn(routes: xarray.Dataset) -> None:
    plain = fly(routes, dtype="float64", noise=0.0)
    for leg, is_same in (("home", [True, True, True, False]), ("out", [True, False, False, False])):
        shifted = fly(routes, CompassShift(shift=0.5, leg=leg), dtype="float64", noise=0.0)
        for step, same in zip((0, 5, N_OUT - 1, N_OUT + 1), is_same, strict=True):
            assert np.array_equal(shifted.tl[:, step], plain.tl[:, step]) == same, (leg, step)
    both = fly(routes, CompassShift(shift=0.5, leg="both"), dtype="float64", noise=0.0)
    np.testing.assert_array_equal(both.tl[:, N_OUT], plain.tl[:, N_OUT])


def test_shifted_compass_runs_ahead_of_the_turn(routes: xarray.Dataset) -> None:
    out = fly(routes, CompassShift(shift=0.3), noise=0.0, dtype="float64")
    heading = out.heading.values[:, N_OUT : N_OUT + 30]  # after the turn: what the next step is given, unshifted
    tl = out.tl.values[:, N_OUT + 1 : N_OUT + 31, :8]
    turns = out.motor.values[:, N_OUT : N_OUT + 30]
    preferred = np.arange(8) * np.pi / 4
    expected = 1.0 / (1.0 + np.exp(3.0 - 6.8 * np.cos((heading + 0.3 * np.sign(turns))[..., None] - preferred)))
    np.testing.assert_allclose(tl, expected, rtol=0, atol=1e-9)


def test_turned_body_is_a_route_with_other_headings(routes: xarray.Dataset) -> None:
    body = fly(routes, TurnBody(offset=1.1), dtype="float64")
    heading = np.angle(np.exp(1j * (routes.heading.values + 1.1)))
    other = fly((heading, routes.velocity.values), dtype="float64")
    assert np.abs(between(body.heading, other.heading)).max() < 1e-7
    np.testing.assert_allclose(body.position, other.position, rtol=0, atol=1e-7)
    np.testing.assert_allclose(body.memory, other.memory, rtol=0, atol=1e-9)


def test_random_body_is_redrawn_as_often_as_asked() -> None:
    routes = random_routes(400, 100, seed=2)
    out = run_trials(routes, n_inbound=30, seed=3, dtype="float64", perturbations=[TurnBody(redraw_every=25)])
    offsets = between(routes.heading, out.heading[:, :100]).reshape(400, 4, 25)
    np.testing.assert_allclose(offsets, np.broadcast_to(offsets[..., :1], offsets.shape), rtol=0, atol=1e-9)
    drawn = offsets[..., 0].ravel()
    n = drawn.size
    assert np.unique(drawn).size == n
    allowed = np.sqrt(np.log(2e6) / (2.0 * n))  # Dvoretzky, Kiefer & Wolfowitz; Massart: once in a million
    assert stats.kstest(drawn, stats.uniform(-np.pi, 2.0 * np.pi).cdf).statistic < allowed
    assert abs(np.exp(1j * np.diff(offsets[..., 0], axis=1)).mean()) < 5.0 / np.sqrt(300 * 4)
    first_turn = between(out.heading[:, 99], out.heading[:, 100])
    assert np.abs(first_turn).max() < np.pi * 0.9  # it comes home from where it looked, not from the route's heading


def test_random_body_on_the_way_home_keeps_its_course() -> None:
    routes = random_routes(40, 60, seed=2)
    out = run_trials(
        routes, n_inbound=60, seed=3, perturbations=[TurnBody(redraw_every=20, leg="home")], dtype="float64"
    )
    np.testing.assert_allclose(between(routes.heading, out.heading[:, :60]), 0.0, atol=1e-12)
    # v' = 0.85 (v + 0.1 u): what velocity gains is thrust along the course, from which the body stands off.
    velocity = np.diff(out.position.values, axis=1)[:, 58:]
    thrust = velocity[:, 1:] / 0.85 - velocity[:, :-1]
    course = np.arctan2(thrust[..., 0], thrust[..., 1])
    offsets = between(course, out.heading[:, 60:]).reshape(40, 3, 20)
    np.testing.assert_allclose(offsets, np.broadcast_to(offsets[..., :1], offsets.shape), rtol=0, atol=1e-6)
    assert np.unique(offsets[..., 0].round(6)).size == 120


@pytest.mark.parametrize("step", [0, 40, N_OUT, 120])
def test_carried_animal_goes_on_as_before_from_elsewhere(step: int, routes: xarray.Dataset) -> None:
    plain = fly(routes, dtype="float64")
    by, to = np.array([12.0, -7.0]), np.array([3.0, 4.0])
    moved = fly(routes, Displace(step=step, by=by), dtype="float64")
    put = fly(routes, Displace(step=step, to=to), dtype="float64")
    for name in ("heading", "memory", "memory_at_turn", "motor"):
        np.testing.assert_array_equal(moved[name], plain[name], err_msg=name)
        np.testing.assert_array_equal(put[name], plain[name], err_msg=name)
    is_after = np.arange(N_OUT + N_HOME)[:, None] >= step
    np.testing.assert_allclose(moved.position, plain.position + by * is_after, rtol=0, atol=1e-12)
    before = plain.position.values[:, step - 1 : step] if step else np.zeros((N_TRIALS, 1, 2))
    np.testing.assert_allclose(put.position, plain.position + (to - before) * is_after, rtol=0, atol=1e-12)
    closest = np.linalg.norm(moved.position[:, N_OUT - 1 :], axis=-1).min(axis=1)
    np.testing.assert_allclose(moved.closest_distance, closest, rtol=1e-14)


def test_displacements_at_one_step_follow_each_other(routes: xarray.Dataset) -> None:
    in_turn = Displace(step=90, by=(1.0, 1.0)), Displace(step=90, to=(5.0, 6.0)), Displace(step=90, by=(2.0, 3.0))
    xarray.testing.assert_equal(fly(routes, *in_turn), fly(routes, Displace(step=90, to=(7.0, 9.0))))


# All at once.


def everything(memory: np.ndarray, by: float = 0.0, mirror: int = 1) -> list:
    """One of each, in a world turned by an angle and mirrored at the y axis."""
    place = lambda *point: turned(point, by) * [mirror, 1]  # noqa: E731
    return [
        TurnBody(offset=0.3 * mirror, leg="both"),
        CompassShift(shift=0.2, leg="both"),
        FilterSpeed(n_steps=3),
        ScaleSpeed(factor=1.4),
        Displace(step=N_OUT + 5, by=place(2.0, 3.0)),
        Displace(step=30, to=place(-3.0, 1.0)),
        SetMemory(memory=memory, step=N_OUT, mode="add"),
        FreezeMemory(first_step=40, end_step=45),
        Wall(start=place(-30.0, 4.0), end=place(21.0, 9.0)),
        Circle(centre=place(4.0, -5.0), radius=4.0),
    ]


RANDOM = [WeightNoise(sd=0.1), ClampCells(population="tb1", cells=[3], rate=0.4, first_step=20, end_step=25)]


@pytest.mark.parametrize("variant", VARIANTS)
def test_turned_world_turns_the_disturbed_trial(variant: str, routes: xarray.Dataset) -> None:
    few = routes.isel(trial=slice(0, 16))
    options = {"noise": 0.0, "dtype": "float64", "circuit": circuit_params(variant)}
    memory = MEMORIES[:16].reshape(16, 2, 8)
    plain = fly(few, *everything(memory.reshape(16, 16)), **options)
    for n_columns in (1, 3, -2):
        by = n_columns * np.pi / 4
        rolled = np.roll(memory, n_columns, axis=-1).reshape(16, 16)
        pair = few.heading.values + by, turned(few.velocity.values, by)
        other = fly(pair, *everything(rolled, by), **options)
        np.testing.assert_allclose(between(plain.heading + by, other.heading), 0.0, atol=1e-7)
        np.testing.assert_allclose(other.position, turned(plain.position.values, by), rtol=0, atol=1e-7)


@pytest.mark.parametrize("variant", VARIANTS)
def test_mirrored_world_mirrors_the_disturbed_trial(variant: str, routes: xarray.Dataset) -> None:
    few = routes.isel(trial=slice(0, 16))
    options = {"noise": 0.0, "dtype": "float64", "circuit": circuit_params(variant)}
    memory = MEMORIES[:16].reshape(16, 2, 8)
    sides = memory[:, ::-1, -np.arange(8) % 8].reshape(16, 16)
    plain = fly(few, *everything(memory.reshape(16, 16)), **options)
    pair = -few.heading.values, few.velocity.values * [-1, 1]
    mirrored = fly(pair, *everything(sides, mirror=-1), **options)
    np.testing.assert_allclose(between(-plain.heading, mirrored.heading), 0.0, atol=1e-7)
    np.testing.assert_allclose(mirrored.position, plain.position * [-1, 1], rtol=0, atol=1e-7)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("body", [None, TurnBody(redraw_every=7, leg="both")])
def test_all_at_once_is_the_same_in_any_batch(dtype: str, body: TurnBody | None) -> None:
    routes = random_routes(150, N_OUT, seed=9)
    memory = np.random.default_rng(6).uniform(0.3, 0.7, (150, 16))

    def run(trials: slice, **options) -> xarray.Dataset:
        perturbations = [*everything(memory[trials]), *RANDOM]
        if body is not None:
            perturbations = [body, *perturbations[1:]]
        return fly(routes.isel(trial=trials), *perturbations, dtype=dtype, **options)

    whole = run(slice(None), workers=1)
    for name, values in whole.data_vars.items():
        assert np.isfinite(values).all(), name
    xarray.testing.assert_equal(run(slice(None), workers=3), whole)
    for trials in (slice(0, 1), slice(5, 80, 3), slice(140, None)):
        xarray.testing.assert_equal(run(trials), whole.isel(trial=trials))
    later = run(slice(0, 20), seed=3)
    assert not np.array_equal(later.position, whole.position[:20])
    assert not whole.equals(fly(routes, dtype=dtype))


def test_kernel_is_compiled_once_whatever_is_done(routes: xarray.Dataset) -> None:
    from insectnav.agents.trial_kernel import run_trials_kernel

    few = routes.isel(trial=[0])
    for perturbations in ((), everything(MEMORIES[0]), RANDOM, [TurnBody(redraw_every=np.int32(5))]):
        fly(few, *perturbations, record=())
    before = len(run_trials_kernel.signatures)
    fly(few, WeightNoise(sd=1, keep_signs=False), ScaleSpeed(factor=2), FilterSpeed(n_steps=2, form="code-2017"))
    assert len(run_trials_kernel.signatures) == before <= 2  # one for each precision
