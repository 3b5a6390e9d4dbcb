"""Whole trials: the published way home, the circuit's own steps, the laws, and the same bits however they are run."""

import json
import numbers
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
import xarray

import oracle
from insectnav.agents import MotionParams, RouteParams, move, random_routes, run_trials
from insectnav.agents.routes import route_arrays
from insectnav.agents.simulation import TrialParams, simulate_trials
from insectnav.central_complex import (
    N_CELLS,
    POPULATIONS,
    VARIANTS,
    Senses,
    circuit_params,
    decode_home_vector,
    initial_state,
    step,
)
from insectnav.checks import InputError

GOLDEN_VARIANTS = ("partially-holonomic", "fully-holonomic")
GOLDEN_LAYERS = {name: name for name in POPULATIONS if name not in ("tl", "pontine")} | {"tl": "tl2"}
N_OUT, N_HOME = 120, 100
DTYPES = ("float32", "float64")


def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Size of the angle from one heading to another."""
    return np.abs(np.angle(np.exp(1j * (np.asarray(a) - np.asarray(b)))))


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return vectors @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


@pytest.fixture(scope="module")
def routes() -> xarray.Dataset:
    """200 outbound routes: four tasks of 64 trials and a part, twelve registers of lanes and a half."""
    return random_routes(200, N_OUT, seed=3)


@pytest.fixture(scope="module", params=DTYPES)
def whole(request: pytest.FixtureRequest, routes: xarray.Dataset) -> tuple[xarray.Dataset, Callable]:
    """All of them at once on one thread, and how to run others in the same way."""

    def run(some: object, **options) -> xarray.Dataset:
        options = {"n_inbound": N_HOME, "noise": 0.1, "seed": 5, "dtype": request.param, "record": ["tb1"]} | options
        return run_trials(some, **options)

    return run(routes, workers=1), run


@pytest.mark.data
@pytest.mark.parametrize("variant", GOLDEN_VARIANTS)
def test_way_home_is_the_published_one(variant: str, golden) -> None:
    arrays, published = golden("central_complex_routes"), golden(f"central_complex_{variant.replace('-', '_')}")
    pair = tuple(np.stack([arrays[f"{name}_{route}"] for route in (1, 2)]) for name in ("heading", "velocity"))
    params = circuit_params(variant, "code-2017")
    ours = run_trials(pair, params, noise=0.0, n_inbound=1500, dtype="float64", record=POPULATIONS)
    velocity = np.diff(ours.position.values, axis=1)[:, 1498:]
    for index, route in enumerate(["r1", "r2"]):
        assert between(ours.heading[index, 1499:], published[f"{route}_home_heading"]).max() < 1e-8
        np.testing.assert_allclose(velocity[index], published[f"{route}_home_velocity"], rtol=0, atol=1e-8)
        memory = ours.memory_at_turn[index].values
        np.testing.assert_allclose(memory, published[f"{route}_final_memory"], rtol=0, atol=1e-12)
        mirrored_angle, distance = published[f"{route}_decoded"]
        home = -distance * np.array([np.sin(-mirrored_angle), np.cos(-mirrored_angle)])
        np.testing.assert_allclose(ours.home_vector_at_turn[index], home, rtol=0, atol=1e-8)
        for name, theirs in GOLDEN_LAYERS.items():
            rates = ours[name][index].values
            np.testing.assert_allclose(rates[:20], published[f"{route}_first20_{theirs}"], rtol=0, atol=1e-12)
            np.testing.assert_allclose(rates[:1500:50], published[f"{route}_out50_{theirs}"], rtol=0, atol=1e-12)
            np.testing.assert_allclose(rates[1549::50], published[f"{route}_home50_{theirs}"], rtol=0, atol=1e-8)


@pytest.mark.parametrize("variant", VARIANTS)
def test_plain_oracle_comes_home_alike(variant: str, routes: xarray.Dataset) -> None:
    few = routes.isel(trial=[0, 1])
    motion = MotionParams(drag=0.2, acceleration=0.12)
    ours = run_trials(few, circuit_params(variant), motion, n_inbound=N_HOME, noise=0.0, dtype="float64")
    params = oracle.replace(oracle.variant_params(variant), drag=0.2, acceleration=0.12)
    for index in range(2):
        theirs = oracle.run_trial(few.heading.values[index], few.velocity.values[index], N_HOME, params)
        assert between(ours.heading[index], theirs["heading"]).max() < 1e-8
        np.testing.assert_allclose(ours.position[index], theirs["position"], rtol=0, atol=1e-8)
        np.testing.assert_allclose(ours.memory_at_turn[index], theirs["memory_at_turn"], rtol=0, atol=1e-12)
        closest = np.linalg.norm(theirs["position"][N_OUT - 1 :], axis=1).min()
        assert float(ours.closest_distance[index]) == pytest.approx(closest, abs=1e-8)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("variant", VARIANTS)
def test_trial_is_a_loop_of_steps_and_moves(variant: str, dtype: str, routes: xarray.Dataset) -> None:
    few, params, motion = routes.isel(trial=slice(0, 37)), circuit_params(variant), MotionParams()
    compiled = run_trials(few, params, motion, n_inbound=60, noise=0.1, seed=8, dtype=dtype, record=POPULATIONS)
    recorded = {name: compiled[name].values for name in (*POPULATIONS, "heading", "position")}
    tolerance = {"float64": 1e-9, "float32": 2e-3}[dtype]
    heading, velocity = few.heading.values.astype(dtype), few.velocity.values.astype(dtype)
    state = initial_state(params, (37,), seed=8, dtype=dtype)
    theta, v, position = heading[:, 0], velocity[:, 0], np.zeros((37, 2), dtype)
    for t in range(N_OUT + 60):
        if t < N_OUT:
            theta, v = heading[:, t], velocity[:, t]
        state, rates = step(state, Senses(heading=theta, velocity=v), params, noise=0.1)
        if t < N_OUT:  # not a bit differs while the steering is not connected
            for name in POPULATIONS:
                np.testing.assert_array_equal(recorded[name][:, t], getattr(rates, name), err_msg=name)
        else:  # NumPy has sines of its own
            theta, v = move(theta, v, rates.motor, motion)
            np.testing.assert_allclose(rates.motor, recorded["motor"][:, t], rtol=0, atol=tolerance)
        position += v
        assert between(theta, recorded["heading"][:, t]).max() < tolerance
        np.testing.assert_allclose(position, recorded["position"][:, t], rtol=0, atol=tolerance)


@pytest.mark.parametrize("n_workers", [2, 5])
def test_number_of_threads_does_not_change_a_bit(n_workers: int, whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    xarray.testing.assert_identical(run(routes, workers=n_workers), expected)


@pytest.mark.parametrize("trials", [[0], [7, 3, 11], list(range(60, 140)), list(range(0, 200, 9)), [199]])
def test_part_of_the_trials_runs_as_in_the_whole(trials: list, whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    xarray.testing.assert_identical(run(routes.isel(trial=trials)), expected.isel(trial=trials))


def test_routes_from_any_trial_on_are_those_of_the_whole() -> None:
    for dtype in DTYPES:
        whole = route_arrays(50, 130, RouteParams(), 7, dtype)
        for first, n_trials in ((0, 50), (1, 16), (33, 17)):
            part = route_arrays(n_trials, 130, RouteParams(), 7, dtype, first_trial=first)
            for some, everything in zip(part, whole, strict=True):
                np.testing.assert_array_equal(some, everything[first : first + n_trials])
    with pytest.raises(InputError, match=r"^first_trial is -1, expected a whole number of at least 0"):
        route_arrays(2, 10, RouteParams(), 7, first_trial=-1)


def test_paths_that_are_not_kept_take_no_room_and_change_nothing_else(routes: xarray.Dataset) -> None:
    options = {"circuit": circuit_params(), "motion": MotionParams(), "n_inbound": N_HOME, "noise": 0.1, "seed": 5}
    heading, velocity = routes.heading.values, routes.velocity.values
    kept, dropped = (
        simulate_trials(heading, velocity, routes.trial.values, TrialParams(**options, record=["tb1"], keep_paths=keep))
        for keep in (True, False)
    )
    assert (dropped.heading.shape, dropped.position.shape) == ((200, 0), (200, 0, 2))
    for name in ("memory_at_turn", "closest_distance", "activity", "recorded_rows"):
        np.testing.assert_array_equal(getattr(dropped, name), getattr(kept, name), err_msg=name)
    closest = np.linalg.norm(kept.position[:, N_OUT - 1 :].astype(float), axis=-1).min(axis=1)
    np.testing.assert_allclose(dropped.closest_distance, closest, rtol=1e-6)


def test_more_trials_and_more_steps_change_none_of_the_first(whole: tuple) -> None:
    expected, run = whole
    more = run(random_routes(230, N_OUT, seed=3), n_inbound=N_HOME + 20)
    first = more.isel(trial=slice(0, 200), step=slice(0, N_OUT + N_HOME))
    for name in ("heading", "position", "memory_at_turn", "tb1"):
        np.testing.assert_array_equal(first[name], expected[name], err_msg=name)


def test_seed_and_noise_decide_the_noise(whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    few = routes.isel(trial=slice(0, 20))
    xarray.testing.assert_identical(run(few), expected.isel(trial=slice(0, 20)))
    assert np.mean(run(few, seed=6).tb1.values == expected.tb1.values[:20]) < 0.5
    assert np.mean(run(few, noise=0.05).tb1.values == expected.tb1.values[:20]) < 0.5
    by_name = dict.fromkeys(set(POPULATIONS) - {"memory", "motor"}, 0.1)
    np.testing.assert_array_equal(run(few, noise=by_name).position, expected.position[:20])
    quiet_cells = run(few, noise={"cpu1": 0.1}).tb1.values[:, :N_OUT]
    np.testing.assert_array_equal(quiet_cells, run(few, noise=0).tb1.values[:, :N_OUT])


def test_pair_of_arrays_is_as_good_as_a_dataset(whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    pair = run((routes.heading.values, routes.velocity.values))
    xarray.testing.assert_identical(pair, expected)
    xarray.testing.assert_identical(run(routes.transpose("xy", "step", "trial")), expected)
    as_lists = run((routes.heading.values[:3].tolist(), routes.velocity.values[:3].tolist()))
    xarray.testing.assert_identical(as_lists, expected.isel(trial=slice(0, 3)))


@pytest.mark.parametrize("variant", VARIANTS)
def test_turned_world_turns_the_trial(variant: str, routes: xarray.Dataset) -> None:
    few = routes.isel(trial=slice(0, 16))
    options = {"n_inbound": N_HOME, "noise": 0.0, "dtype": "float64", "record": ["tb1"]}
    plain = run_trials(few, circuit_params(variant), **options)
    for n_columns in (1, 3, -2):
        by = n_columns * np.pi / 4
        pair = few.heading.values + by, turned(few.velocity.values, by)
        other = run_trials(pair, circuit_params(variant), **options)
        assert between(other.heading, plain.heading + by).max() < 1e-7
        np.testing.assert_allclose(other.position, turned(plain.position.values, by), rtol=0, atol=1e-7)
        home_vector = turned(plain.home_vector_at_turn.values, by)
        np.testing.assert_allclose(other.home_vector_at_turn, home_vector, rtol=0, atol=1e-7)
        np.testing.assert_allclose(other.closest_distance, plain.closest_distance, rtol=0, atol=1e-7)
        rolled = np.roll(plain.memory_at_turn.values.reshape(-1, 2, 8), n_columns, axis=-1).reshape(-1, 16)
        np.testing.assert_allclose(other.memory_at_turn, rolled, rtol=0, atol=1e-12)
        np.testing.assert_allclose(other.tb1, np.roll(plain.tb1.values, n_columns, axis=-1), rtol=0, atol=1e-7)


@pytest.mark.parametrize("variant", VARIANTS)
def test_mirrored_world_mirrors_the_trial(variant: str, routes: xarray.Dataset) -> None:
    few = routes.isel(trial=slice(0, 16))
    options = {"n_inbound": N_HOME, "noise": 0.0, "dtype": "float64", "record": ["tb1", "motor"]}
    plain = run_trials(few, circuit_params(variant), **options)
    mirrored = run_trials((-few.heading.values, few.velocity.values * [-1, 1]), circuit_params(variant), **options)
    reflect = -np.arange(8) % 8
    assert between(mirrored.heading, -plain.heading).max() < 1e-7
    np.testing.assert_allclose(mirrored.position, plain.position * [-1, 1], rtol=0, atol=1e-7)
    np.testing.assert_allclose(mirrored.motor, -plain.motor, rtol=0, atol=1e-7)
    np.testing.assert_allclose(mirrored.tb1, plain.tb1.values[..., reflect], rtol=0, atol=1e-7)
    sides = plain.memory_at_turn.values.reshape(-1, 2, 8)[:, ::-1, reflect].reshape(-1, 16)
    np.testing.assert_allclose(mirrored.memory_at_turn, sides, rtol=0, atol=1e-12)


def test_dataset_keeps_its_promises(whole: tuple, routes: xarray.Dataset) -> None:
    out, _ = whole
    dtype = out.attrs["dtype"]
    assert out.heading.dims == ("trial", "step")
    assert out.position.dims == ("trial", "step", "xy")
    assert out.memory_at_turn.dims == ("trial", "cell")
    assert out.home_vector_at_turn.dims == ("trial", "xy")
    assert out.closest_distance.dims == ("trial",)
    assert dict(out.sizes) == {"trial": 200, "step": N_OUT + N_HOME, "xy": 2, "cell": 16, "direction": 8}
    assert {array.dtype.name for array in out.data_vars.values()} == {dtype}
    assert out.leg.dims == ("step",)
    assert out.leg.values.tolist() == ["out"] * N_OUT + ["home"] * N_HOME
    assert out.xy.values.tolist() == ["x", "y"]
    np.testing.assert_array_equal(out.heading[:, :N_OUT], routes.heading.astype(dtype))
    assert (out.attrs["seed"], out.attrs["circuit_preset"], out.attrs["motion_drag"]) == (5, "thesis", 0.15)


def test_position_sums_the_velocities_and_the_turning_point_stands_once(whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    out = run(routes, record=["motor"])
    tolerance = 1e-12 if out.attrs["dtype"] == "float64" else 1e-4
    np.testing.assert_array_equal(out.position, expected.position)
    velocity = routes.velocity.values
    np.testing.assert_allclose(out.position[:, :N_OUT], np.cumsum(velocity, axis=1), rtol=0, atol=tolerance)
    heading = out.heading.values[:, N_OUT - 1] + out.motor.values[:, N_OUT]
    assert between(out.heading[:, N_OUT], heading).max() < tolerance
    first_move = 0.85 * (velocity[:, -1] + 0.1 * np.stack([np.sin(heading), np.cos(heading)], axis=-1))
    np.testing.assert_allclose(out.position[:, N_OUT] - out.position[:, N_OUT - 1], first_move, rtol=0, atol=tolerance)
    assert between(np.diff(out.heading, axis=1)[:, N_OUT - 1 :], out.motor[:, N_OUT:]).max() < tolerance


def test_results_at_the_turn_and_closest_distance_fit_the_path(whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    out = run(routes, record=["memory"])
    np.testing.assert_array_equal(out.memory_at_turn, out.memory[:, N_OUT - 1])
    np.testing.assert_array_equal(
        out.home_vector_at_turn, decode_home_vector(out.memory_at_turn.values, circuit_params())
    )
    closest = np.linalg.norm(out.position.values[:, N_OUT - 1 :].astype("float64"), axis=-1).min(axis=1)
    np.testing.assert_allclose(out.closest_distance, closest, rtol=4 * np.finfo(out.attrs["dtype"]).eps)
    np.testing.assert_array_equal(out.closest_distance, expected.closest_distance)


def test_trial_may_end_at_the_turning_point(whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    out = run(routes, n_inbound=0, record=())
    assert out.sizes["step"] == N_OUT
    np.testing.assert_array_equal(out.position, expected.position[:, :N_OUT])
    np.testing.assert_array_equal(out.memory_at_turn, expected.memory_at_turn)
    distance = np.linalg.norm(out.position.values[:, -1], axis=-1)
    np.testing.assert_allclose(out.closest_distance, distance, rtol=4 * np.finfo(out.attrs["dtype"]).eps)


@pytest.mark.parametrize("record", [["motor"], ["cpu1", "tl"], ("tn1", "memory", "tn2"), POPULATIONS])
def test_recording_adds_the_asked_for_populations_alone(record: tuple, whole: tuple, routes: xarray.Dataset) -> None:
    expected, run = whole
    few = routes.isel(trial=slice(0, 20))
    out, everything = run(few, record=record), run(few, record=POPULATIONS)
    assert set(out.data_vars) - set(record) == set(expected.data_vars) - {"tb1"}
    for name in record:
        n_cells = () if name == "motor" else (N_CELLS[name],)
        assert out[name].shape == (20, N_OUT + N_HOME, *n_cells)
        np.testing.assert_array_equal(out[name], everything[name])
    np.testing.assert_array_equal(everything.tb1, expected.tb1[:20])
    np.testing.assert_array_equal(out.position, expected.position[:20])


def test_arguments_are_left_as_they_are(whole: tuple, routes: xarray.Dataset) -> None:
    before = routes.copy(deep=True)
    whole[1](routes.isel(trial=slice(0, 20)), dtype="float64")
    xarray.testing.assert_identical(routes, before)


def test_progress_counts_every_trial(whole: tuple, routes: xarray.Dataset) -> None:
    finished: list[int] = []
    whole[1](routes, progress=finished.append, workers=2)
    assert sum(finished) == 200
    assert len(finished) > 1


@pytest.mark.parametrize("n_inbound", [500, 1500])
def test_memory_is_what_is_returned_and_little_more(n_inbound: int) -> None:
    made = random_routes(400, 500, seed=1, dtype="float32")
    pair = made.heading.values, made.velocity.values
    run_trials(pair, n_inbound=0, workers=1)  # loads what is loaded once
    tracemalloc.start()
    try:
        out = run_trials(pair, n_inbound=n_inbound, workers=1)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    returned = sum(array.nbytes for array in out.data_vars.values())
    assert returned > 400 * (500 + n_inbound) * 3 * 4
    assert peak < returned + 500_000


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n_inbound": -1}, "n_inbound is -1"),
        ({"n_inbound": 1.5}, "n_inbound is 1.5"),
        ({"dtype": "float16"}, "dtype 'float16' is unknown"),
        ({"dtype": "flaot32"}, r"dtype 'flaot32' is unknown.*did you mean float32\?"),
        ({"record": ["cpu2"]}, r"population to record 'cpu2' is unknown.*did you mean cpu[14]\?"),
        ({"seed": -1}, "seed is -1"),
        ({"workers": 0}, "workers is 0"),
        ({"noise": -0.1}, r"noise is -0\.1"),
        ({"noise": np.nan}, "noise is nan"),
        ({"noise": {"cpu": 0.1}}, "population with noise 'cpu' is unknown"),
        ({"routes": (np.zeros((3, 10)), np.zeros((3, 9, 2)))}, r"route velocity has shape \(3, 9, 2\)"),
        ({"routes": (np.zeros((3, 10)), np.zeros((10, 3, 2)))}, "route velocity has shape"),
        ({"routes": (np.zeros(10), np.zeros((10, 2)))}, r"route heading has shape \(10,\)"),
        ({"routes": (np.zeros((0, 10)), np.zeros((0, 10, 2)))}, r"routes are empty"),
        ({"routes": (np.zeros((3, 0)), np.zeros((3, 0, 2)))}, r"routes are empty"),
        ({"routes": (np.full((3, 10), np.nan), np.zeros((3, 10, 2)))}, "route heading is nan at index 0, 0"),
        ({"routes": (np.zeros((3, 10)), np.full((3, 10, 2), np.inf))}, "route velocity is inf at index 0, 0, 0"),
        ({"routes": (np.zeros((3, 10)),)}, r"routes have 1 parts, expected a Dataset or \(heading, velocity\)"),
        ({"routes": xarray.Dataset({"heading": (("trial", "step"), np.zeros((3, 10)))})}, "routes .*velocity"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(change: dict, message: str, routes: xarray.Dataset) -> None:
    options = {"routes": routes.isel(trial=[0]), "n_inbound": 1, "noise": 0.1} | change
    with pytest.raises(InputError, match=f"^{message}"):
        run_trials(**options)


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int64, int])
def test_settings_of_any_kind_of_number_can_be_written_down(kind: type, routes: xarray.Dataset) -> None:
    settings = [{"noise": kind(1)}, {"noise": {"tb1": kind(1)}}]
    settings += [{"seed": kind(1)}] if issubclass(kind, numbers.Integral) else []
    for setting in settings:
        out = run_trials(routes.isel(trial=[0]), n_inbound=1, **setting)
        written = json.loads(json.dumps(out.attrs))
        assert "1" in str(written[next(iter(setting))])
