"""One step of the circuit: against the published code, the plain oracle, and the laws it must keep."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import oracle
from insectnav.central_complex import (
    N_CELLS,
    POPULATIONS,
    THESIS,
    VARIANTS,
    CircuitParams,
    CircuitState,
    Connectivity,
    Rates,
    Senses,
    circuit_params,
    initial_state,
    step,
)
from insectnav.checks import InputError

NOISY = tuple(name for name in POPULATIONS if name not in ("memory", "motor"))
WITHOUT_PONTINE = ("no-pontine", "idealised")
GOLDEN_LAYERS = {name: name for name in POPULATIONS if name not in ("tl", "pontine")} | {"tl": "tl2"}
N_BATCH = 37  # two full registers of lanes and a part


def walk(
    params: CircuitParams, heading: np.ndarray, velocity: np.ndarray, noise: float = 0.0, **options
) -> tuple[CircuitState, dict[str, np.ndarray]]:
    """Last state, and rates (time, ..., cell) along headings (time, ...) and velocities (time, ..., 2)."""
    state = initial_state(params, heading.shape[1:], **options)
    history = []
    for theta, v in zip(heading, velocity, strict=True):
        state, rates = step(state, Senses(heading=theta, velocity=v), params, noise=noise)
        history.append(rates)
    return state, {name: np.stack([getattr(rates, name) for rates in history]) for name in POPULATIONS}


def uneven_state(params: CircuitParams, shape: tuple[int, ...], seed: int = 0, dtype: str = "float64") -> CircuitState:
    rng = np.random.default_rng(seed)
    state = initial_state(params, shape, seed=seed, dtype=dtype)
    memory, tb1 = rng.uniform(0, 1, state.memory.shape), rng.uniform(0, 1, state.tb1.shape)
    return replace(state, memory=memory.astype(dtype), tb1=tb1.astype(dtype))


def senses_of(shape: tuple[int, ...], seed: int = 1, speed: float = 0.6) -> Senses:
    rng = np.random.default_rng(seed)
    return Senses(heading=rng.uniform(-np.pi, np.pi, shape), velocity=rng.normal(0, speed, (*shape, 2)))


def assert_same_bits(found: Rates | CircuitState, expected: Rates | CircuitState, index: object = ...) -> None:
    for field in fields(found):
        np.testing.assert_array_equal(
            getattr(found, field.name), getattr(expected, field.name)[index], err_msg=field.name
        )


def responses(before: CircuitState, senses: Senses, rates: Rates, p: CircuitParams) -> dict[str, np.ndarray]:
    """What each population answers, without noise, to the recorded rates of those that feed it."""

    def rate(population: str, drive: np.ndarray) -> np.ndarray:
        slope, bias = getattr(p, f"{population}_slope"), getattr(p, f"{population}_bias")
        return 1 / (1 + np.exp(bias - slope * drive)) if p.is_sigmoid else np.clip(drive, 0, 1)

    def arriving(projection: str, population: np.ndarray) -> np.ndarray:
        return population @ getattr(p.connectivity, projection).T

    compass = np.cos(np.asarray(senses.heading)[..., None] - np.arange(16) % 8 * np.pi / 4)
    flow_axes = np.asarray(senses.heading)[..., None] + p.tn_preference * np.array([1, -1])
    x, y = np.moveaxis(np.asarray(senses.velocity), -1, 0)
    flow = x[..., None] * np.sin(flow_axes) + y[..., None] * np.cos(flow_axes)
    if p.is_flow_averaged:
        flow = np.repeat(flow.mean(axis=-1, keepdims=True), 2, axis=-1)
    tb1_drive = p.cl1_to_tb1_strength * arriving("cl1_to_tb1", rates.cl1)
    tb1_drive = tb1_drive - p.tb1_to_tb1_strength * arriving("tb1_to_tb1", before.tb1)
    tn1, tn2 = arriving("tn_to_cpu4", rates.tn1), arriving("tn_to_cpu4", rates.tn2)
    direction = arriving("tb1_to_cpu4", rates.tb1)
    charge = {
        "inhibited-flow": np.clip(tn2 - direction, 0, 1) - p.memory_loss,
        "flow-times-heading": (0.5 - tn1) * (0.5 - direction),
        "backward-flow": np.clip(0.5 - tn1, 0, 1) * (1 - direction) - tn2 / 4,
    }[p.memory_rule]
    steering = p.cpu4_to_cpu1_strength * arriving("cpu4_to_cpu1", rates.cpu4)
    steering = steering - p.pontine_to_cpu1_strength * arriving("pontine_to_cpu1", rates.pontine)
    has_pontine = p.pontine_to_cpu1_strength != 0
    inhibition = p.tb1_to_cpu1_strength * arriving("tb1_to_cpu1", rates.tb1)
    sides = arriving("cpu1_to_motor", rates.cpu1)
    return {
        "tl": rate("tl", compass if p.is_sigmoid else (1 + compass) / 2),
        "cl1": rate("cl1", (0 if p.is_sigmoid else 1) - arriving("tl_to_cl1", rates.tl)),
        "tb1": rate("tb1", tb1_drive),
        "tn1": np.clip((1 - flow) / 2, 0, 1),
        "tn2": np.clip(flow, 0, 1),
        "memory": np.clip(before.memory + p.memory_gain * charge, 0, 1),
        "cpu4": rate("cpu4", rates.memory),
        "pontine": rate("pontine", arriving("cpu4_to_pontine", rates.cpu4)) if has_pontine else np.zeros((len(x), 16)),
        "cpu1": rate("cpu1", steering * (1 - inhibition) if p.steering_rule == "gate" else steering - inhibition),
        "motor": p.motor_gain * (sides[..., 0] - sides[..., 1]),
    }


@pytest.mark.data
@pytest.mark.parametrize("variant", ["partially-holonomic", "fully-holonomic"])
def test_every_layer_is_the_published_one(variant: str, golden) -> None:
    routes, published = golden("central_complex_routes"), golden(f"central_complex_{variant.replace('-', '_')}")
    heading = np.stack([routes["heading_1"], routes["heading_2"]], axis=1)
    velocity = np.stack([routes["velocity_1"], routes["velocity_2"]], axis=1)
    state, history = walk(circuit_params(variant, "code-2017"), heading, velocity)
    for index, route in enumerate(["r1", "r2"]):
        for name, theirs in GOLDEN_LAYERS.items():
            ours = history[name][:, index]
            np.testing.assert_allclose(ours[:20], published[f"{route}_first20_{theirs}"], rtol=0, atol=1e-12)
            np.testing.assert_allclose(ours[::50], published[f"{route}_out50_{theirs}"], rtol=0, atol=1e-12)
        np.testing.assert_allclose(state.memory[index], published[f"{route}_final_memory"], rtol=0, atol=1e-12)
        np.testing.assert_allclose(state.tb1[index], published[f"{route}_final_tb1"], rtol=0, atol=1e-12)


@pytest.mark.parametrize("preset", ["thesis", "code-2017"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_plain_oracle_agrees(variant: str, preset: str) -> None:
    heading, velocity = oracle.random_route(300, np.random.default_rng(5))
    velocity = 1.7 * velocity + np.random.default_rng(6).normal(0, 0.2, velocity.shape)  # also sideways, and too fast
    _, ours = walk(circuit_params(variant, preset), heading, velocity)
    base = oracle.CODE_2017 if preset == "code-2017" else oracle.THESIS
    params = oracle.variant_params(variant, base)
    tb1, memory = oracle.initial_state()
    for t in range(len(heading)):
        tb1, memory, theirs = oracle.step(tb1, memory, heading[t], velocity[t], params)
        for name in POPULATIONS:
            np.testing.assert_allclose(ours[name][t], theirs[name], rtol=0, atol=1e-12, err_msg=f"{name}, step {t}")


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_batch_is_a_loop_over_single_circuits(variant: str, dtype: str) -> None:
    params = circuit_params(variant)
    state, senses = uneven_state(params, (N_BATCH,), dtype=dtype), senses_of((N_BATCH,))
    together, rates = step(state, senses, params, noise=0.1)
    for index in range(N_BATCH):
        one = CircuitState(tb1=state.tb1[index], memory=state.memory[index], stream=state.stream[index])
        sense = Senses(heading=senses.heading[index], velocity=senses.velocity[index])
        alone, rates_alone = step(one, sense, params, noise=0.1)
        assert_same_bits(alone, together, index)
        assert_same_bits(rates_alone, rates, index)


def test_batch_may_have_several_axes() -> None:
    state, senses = uneven_state(THESIS, (24,)), senses_of((24,))
    after, rates = step(state, senses, THESIS, noise=0.1)
    folded = CircuitState(**{f.name: getattr(state, f.name).reshape(2, 3, 4, -1) for f in fields(state)})
    folded_senses = Senses(heading=senses.heading.reshape(2, 3, 4), velocity=senses.velocity.reshape(2, 3, 4, 2))
    folded_after, folded_rates = step(folded, folded_senses, THESIS, noise=0.1)
    assert folded_rates.motor.shape == (2, 3, 4)
    for name in POPULATIONS:
        np.testing.assert_array_equal(getattr(folded_rates, name).ravel(), getattr(rates, name).ravel())
    np.testing.assert_array_equal(folded_after.stream.reshape(-1, 4), after.stream)


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3), (0,)])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_results_have_the_shape_and_precision_of_the_state(shape: tuple, dtype: str) -> None:
    state, rates = step(initial_state(THESIS, shape, seed=1, dtype=dtype), senses_of(shape), THESIS, noise=0.1)
    for name in POPULATIONS:
        expected = shape if name == "motor" else (*shape, N_CELLS[name])
        assert getattr(rates, name).shape == expected, name
        assert getattr(rates, name).dtype == dtype, name
    assert state.tb1.dtype == state.memory.dtype == dtype
    assert state.stream.shape == (*shape, 4)
    assert_same_bits(CircuitState(tb1=rates.tb1, memory=rates.memory, stream=state.stream), state)


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("variant", VARIANTS)
def test_single_precision_stays_close_to_double(variant: str, noise: float) -> None:
    heading, velocity = oracle.random_route(300, np.random.default_rng(7))
    params = circuit_params(variant)
    _, double = walk(params, heading, velocity, noise, seed=3)
    _, single = walk(params, heading, velocity, noise, seed=3, dtype="float32")
    for name in POPULATIONS:
        # Charge of 300 steps, each rounded to 6e-8; a slope of 7.5 and a turn over 16 cells on top of it.
        np.testing.assert_allclose(single[name], double[name], rtol=0, atol=1e-4, err_msg=name)


@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-12), ("float32", 2e-5)])
def test_full_turn_of_the_heading_does_not_matter(dtype: str, tolerance: float) -> None:
    state, senses = uneven_state(THESIS, (N_BATCH,), dtype=dtype), senses_of((N_BATCH,))
    rates = step(state, senses, THESIS)[1]
    heading = np.asarray(senses.heading)
    turned = Senses(heading=heading - np.copysign(2 * np.pi, heading), velocity=senses.velocity)
    for name, found in vars(step(state, turned, THESIS)[1]).items():
        np.testing.assert_allclose(found, getattr(rates, name), rtol=0, atol=tolerance, err_msg=name)


@settings(max_examples=80, deadline=None)
@given(
    variant=st.sampled_from(VARIANTS),
    dtype=st.sampled_from(["float32", "float64"]),
    heading=st.lists(st.floats(-np.pi, np.pi), min_size=5, max_size=5),
    speed=st.floats(0, 100),
    noise=st.floats(0, 3),
    seed=st.integers(0, 2**32),
)
def test_memory_and_rates_stay_between_zero_and_one(
    variant: str, dtype: str, heading: list, speed: float, noise: float, seed: int
) -> None:
    params = replace(circuit_params(variant), memory_gain=0.3)
    state = initial_state(params, (5,), seed=seed, dtype=dtype)
    velocity = speed * np.column_stack([np.sin(np.arange(5)), np.cos(np.arange(5))])
    for _ in range(4):
        state, rates = step(state, Senses(heading=heading, velocity=velocity), params, noise=noise)
        for name in POPULATIONS[:-1]:
            assert np.all((getattr(rates, name) >= 0) & (getattr(rates, name) <= 1)), name
        assert np.all(np.abs(rates.motor) <= 8 * params.motor_gain * (1 + 1e-6))


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("population", NOISY)
def test_noise_of_one_population_disturbs_its_own_rates_alone(population: str, variant: str) -> None:
    params = circuit_params(variant)
    if population == "pontine" and variant in WITHOUT_PONTINE:
        pytest.skip("this circuit has none")
    state, senses = uneven_state(params, (N_BATCH,)), senses_of((N_BATCH,), speed=0.3)
    rates = step(state, senses, params, noise={population: 0.2})[1]
    for name, expected in responses(state, senses, rates, params).items():
        difference = np.abs(getattr(rates, name) - expected)
        if name == population:
            assert np.mean(difference > 0.01) > 0.5
        else:
            assert difference.max() < 1e-12, name


@pytest.mark.parametrize("variant", VARIANTS)
def test_any_wiring_gives_each_cell_what_arrives_there(variant: str) -> None:
    rng = np.random.default_rng(11)
    shapes = {field.name: getattr(Connectivity(), field.name).shape for field in fields(Connectivity)}
    dense = Connectivity(**{name: rng.normal(0, 0.5, shape) for name, shape in shapes.items()})
    params = replace(circuit_params(variant), connectivity=dense, pontine_to_cpu1_strength=0.7, memory_gain=0.2)
    state, senses = uneven_state(params, (N_BATCH,)), senses_of((N_BATCH,))
    rates = step(state, senses, params)[1]
    for name, expected in responses(state, senses, rates, params).items():
        np.testing.assert_allclose(getattr(rates, name), expected, rtol=0, atol=1e-12, err_msg=name)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("population", NOISY)
def test_noise_has_the_asked_for_mean_and_spread(population: str, dtype: str) -> None:
    n, sigma = 4000, 0.05
    params = replace(THESIS, tb1_to_cpu1_strength=0.1)  # so that some cells of each population are half active
    senses = Senses(heading=np.full(n, 0.4), velocity=np.full((n, 2), 0.3))
    state = initial_state(params, (n,), seed=2, dtype=dtype)
    quiet = getattr(step(state, senses, params)[1], population)
    added = getattr(step(state, senses, params, noise={population: sigma})[1], population) - quiet
    unclipped = np.abs(quiet[0] - 0.5) < 0.5 - 5 * sigma
    assert unclipped.any()
    added = added[:, unclipped].astype("float64")
    assert np.abs(added.mean(axis=0)).max() < 5 * sigma / np.sqrt(n)
    assert np.abs(added.std(axis=0) / sigma - 1).max() < 5 / np.sqrt(2 * n)
    between = np.corrcoef(added, rowvar=False) - np.eye(added.shape[1])
    assert np.abs(between).max() < 5 / np.sqrt(n)


def test_clipped_cells_pile_up_at_the_limit() -> None:
    n, sigma = 4000, 0.2
    at_rest = Senses(heading=np.zeros(n), velocity=np.zeros((n, 2)))
    rates = step(initial_state(THESIS, (n,), seed=4), at_rest, THESIS, noise={"tn2": sigma})[1].tn2
    for side in rates.T:
        assert abs(np.mean(side == 0) - 0.5) < 5 * np.sqrt(0.25 / n)
        assert side[side > 0].mean() == pytest.approx(sigma * np.sqrt(2 / np.pi), abs=5 * sigma / np.sqrt(n / 2))


def test_noise_is_fresh_in_every_step_and_circuit() -> None:
    n = 500
    senses = Senses(heading=np.zeros(n), velocity=np.zeros((n, 2)))
    state = initial_state(THESIS, (n,), seed=5)
    tn1 = []
    for _ in range(4):
        state, rates = step(state, senses, THESIS, noise={"tn1": 0.05})
        tn1.append(rates.tn1)
    assert len(np.unique(tn1)) == 4 * n * 2
    between = np.corrcoef(np.concatenate(tn1, axis=1), rowvar=False) - np.eye(8)
    assert np.abs(between).max() < 5 / np.sqrt(n)


def test_same_seed_same_noise_and_another_seed_other_noise() -> None:
    senses = senses_of((6,))
    first, again, other = (
        step(initial_state(THESIS, (6,), seed=seed), senses, THESIS, noise=0.1)[1] for seed in (8, 8, 9)
    )
    assert_same_bits(again, first)
    for name in NOISY:
        assert np.mean(getattr(other, name) == getattr(first, name)) < 0.5, name  # clipped cells may agree
    one_number, by_name = (
        step(uneven_state(THESIS, (9,)), senses_of((9,)), THESIS, noise=noise)[1]
        for noise in (0.1, dict.fromkeys(NOISY, 0.1))
    )
    assert_same_bits(by_name, one_number)


def test_circuit_keeps_its_noise_when_more_run_beside_it() -> None:
    few, many = (
        step(
            initial_state(THESIS, (n,), seed=8),
            Senses(heading=np.zeros(n), velocity=np.zeros((n, 2))),
            THESIS,
            noise=0.1,
        )
        for n in (3, 40)
    )
    assert_same_bits(few[1], many[1], slice(3))
    assert_same_bits(few[0], many[0], slice(3))


def test_step_leaves_its_arguments_as_they_are() -> None:
    state, senses = uneven_state(THESIS, (N_BATCH,)), senses_of((N_BATCH,))
    noise = {"tl": 0.1, "cpu1": 0.2}
    before = [array.copy() for array in (*vars(state).values(), *vars(senses).values())]
    first = step(state, senses, THESIS, noise=noise)
    for array, copy in zip((*vars(state).values(), *vars(senses).values()), before, strict=True):
        np.testing.assert_array_equal(array, copy)
    assert noise == {"tl": 0.1, "cpu1": 0.2}
    assert_same_bits(step(state, senses, THESIS, noise=noise)[1], first[1])
    first[1].memory[:] = -1  # results do not share memory with what was given
    np.testing.assert_array_equal(state.memory, before[1])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"noise": 0.1, "stream": None},
            "noise needs random numbers, but the state has none: give initial_state a seed",
        ),
        ({"noise": -0.1}, r"noise is -0\.1, expected 0 to 10"),
        ({"noise": np.nan}, "noise is nan"),
        ({"noise": {"tb1": -1.0}}, "noise of tb1 is -1"),
        ({"noise": {"cpu-4": 0.1}}, r"population with noise 'cpu-4' is unknown.*did you mean cpu4\?"),
        ({"noise": {"memory": 0.1}}, "population with noise 'memory' is unknown"),
        ({"heading": [0.1, np.nan]}, "heading is nan at index 1"),
        ({"velocity": [[0, 0], [0, np.inf]]}, "velocity is inf at index 1, 1"),
        ({"velocity": [0, 0]}, r"velocity has shape \(2,\), expected \(2, 2\)"),
        (
            {"heading": [0.1, 0.2, 0.3], "velocity": np.zeros((3, 2))},
            r"state tb1 has shape \(2, 8\), expected \(3, 8\)",
        ),
        ({"memory": np.zeros((2, 8))}, r"state memory has shape \(2, 8\), expected \(2, 16\)"),
        ({"stream": np.zeros(4, np.uint32)}, r"state stream has shape \(4,\), expected \(2, 4\)"),
        ({"memory": np.zeros((2, 16), "float16")}, "dtype of the state 'float16' is unknown"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(change: dict, message: str) -> None:
    state = initial_state(THESIS, (2,), seed=1)
    given_state = replace(state, **{key: value for key, value in change.items() if hasattr(state, key)})
    senses = Senses(heading=change.get("heading", [0.1, 0.2]), velocity=change.get("velocity", np.zeros((2, 2))))
    with pytest.raises(InputError, match=f"^{message}"):
        step(given_state, senses, THESIS, noise=change.get("noise", 0.0))


@pytest.mark.parametrize("options", [{"seed": -1}, {"seed": 0.5}, {"dtype": "float16"}, {"dtype": "int64"}])
def test_bad_start_is_refused(options: dict) -> None:
    with pytest.raises(InputError, match=r"^(seed|dtype) "):
        initial_state(THESIS, **options)


def test_circuit_starts_with_an_even_memory_and_a_silent_compass() -> None:
    state = initial_state(replace(THESIS, memory_start=0.3), (2, 5), dtype="float32")
    assert state.stream is None
    np.testing.assert_array_equal(state.memory, np.full((2, 5, 16), np.float32(0.3)))
    np.testing.assert_array_equal(state.tb1, np.zeros((2, 5, 8)))
