"""The home vector in the memory: closed forms, the published code's reading, and exactness of the linear circuit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import oracle
from insectnav.angles import unit_vector, wrap
from insectnav.central_complex import (
    CODE_2017,
    THESIS,
    VARIANTS,
    CircuitParams,
    Senses,
    circuit_params,
    decode_home_vector,
    decode_waggle_dance,
    initial_state,
    step,
)
from insectnav.checks import InputError

IDEALISED = circuit_params("idealised")
PREFERRED = np.arange(8) * np.pi / 4
bearings = st.floats(-np.pi, np.pi)


def linear_memory(course: float, distance: float, heading: float, params: CircuitParams = IDEALISED) -> np.ndarray:
    """Charge of the linear circuit after a straight walk along ``course``, with the body along ``heading``.

    A side that looks at θ ± 45° sees the flow v cos(course − θ ∓ 45°) and charges column d in every step by
    h · flow/2 · cos(θ − d)/2, since ½ − TN1 = flow/2 and ½ − TB1 = cos(θ − d)/2.
    """
    tuning = np.cos(heading - PREFERRED)
    sides = [distance * np.cos(course - heading - side * np.pi / 4) for side in (1, -1)]
    return 0.5 + params.memory_gain / 4 * np.concatenate([sides[0] * tuning, sides[1] * tuning])


def memory_after(params: CircuitParams, heading: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    state = initial_state(params, heading.shape[1:])
    for theta, v in zip(heading, velocity, strict=True):
        state = step(state, Senses(heading=theta, velocity=v), params)[0]
    return state.memory


def turn_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.abs(wrap(np.asarray(a) - np.asarray(b)))


@pytest.fixture(scope="module")
def routes() -> tuple[np.ndarray, np.ndarray]:
    """Headings (time, trial) and velocities (time, trial, 2) of 60 random routes of 400 steps."""
    rng = np.random.default_rng(21)
    made = [oracle.random_route(400, rng) for _ in range(60)]
    return np.stack([heading for heading, _ in made], axis=1), np.stack([velocity for _, velocity in made], axis=1)


@given(course=bearings, heading=bearings, distance=st.floats(0, 500))
def test_linear_memory_of_a_straight_walk_is_read_exactly(course: float, heading: float, distance: float) -> None:
    memory = linear_memory(course, distance, heading)
    expected = -distance * np.array([np.sin(course), np.cos(course)])
    np.testing.assert_allclose(decode_home_vector(memory, IDEALISED), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("course", [0.0, 0.5, -2.0, 3.1])
@pytest.mark.parametrize("sideways", [0.0, 0.4, np.pi / 2, np.pi])
def test_idealised_circuit_charges_as_the_closed_form_says(course: float, sideways: float) -> None:
    n_steps, speed = 90, 0.6
    heading = np.full(n_steps, course - sideways)
    velocity = np.tile(speed * unit_vector(course), (n_steps, 1))
    memory = memory_after(IDEALISED, heading, velocity)
    np.testing.assert_allclose(memory, linear_memory(course, n_steps * speed, course - sideways), rtol=0, atol=1e-13)


def test_idealised_circuit_holds_the_exact_vector(routes: tuple) -> None:
    heading, velocity = routes
    decoded = decode_home_vector(memory_after(IDEALISED, heading, velocity), IDEALISED)
    np.testing.assert_allclose(decoded, -velocity.sum(axis=0), rtol=0, atol=0.01)
    assert np.linalg.norm(decoded, axis=1).max() > 50


def test_idealised_circuit_holds_it_whichever_way_the_body_points(routes: tuple) -> None:
    velocity = 0.8 * routes[1]  # slower than 1, where TN saturates
    heading = np.random.default_rng(3).uniform(-np.pi, np.pi, velocity.shape[:2])
    decoded = decode_home_vector(memory_after(IDEALISED, heading, velocity), IDEALISED)
    np.testing.assert_allclose(decoded, -velocity.sum(axis=0), rtol=0, atol=0.01)


@pytest.mark.data
@pytest.mark.parametrize("variant", ["partially-holonomic", "fully-holonomic"])
@pytest.mark.parametrize("route", [1, 2])
def test_published_memory_gives_the_published_vector_unmirrored(variant: str, route: int, golden) -> None:
    published = golden(f"central_complex_{variant.replace('-', '_')}")
    mirrored_angle, distance = published[f"r{route}_decoded"]
    dance = decode_waggle_dance(published[f"r{route}_final_memory"], circuit_params(variant, "code-2017"))
    assert turn_between(dance.bearing, -mirrored_angle) < 1e-12
    assert dance.distance == pytest.approx(distance, rel=1e-12)
    travelled = golden("central_complex_routes")[f"velocity_{route}"].sum(axis=0)
    assert turn_between(dance.bearing, np.arctan2(*travelled)) < np.radians(10)


@pytest.mark.parametrize(
    ("variant", "typical", "bounds"),
    [
        ("partially-holonomic", (1.08, 1.16), (1.0, 1.25)),
        ("fully-holonomic", (1.05, 1.11), (1.0, 1.2)),
        ("no-pontine", (1.05, 1.11), (1.0, 1.25)),
        ("non-holonomic", (0.95, 1.16), (0.8, 1.3)),
    ],
)
def test_rate_models_are_right_but_somewhat_too_long(
    variant: str, typical: tuple, bounds: tuple, routes: tuple
) -> None:
    heading, velocity = routes
    params = circuit_params(variant, "code-2017")
    travelled = velocity.sum(axis=0)
    far = np.linalg.norm(travelled, axis=1) > 25
    assert np.count_nonzero(far) > 30
    dance = decode_waggle_dance(memory_after(params, heading, velocity)[far], params)
    ratio = dance.distance / np.linalg.norm(travelled[far], axis=1)
    assert typical[0] < np.median(ratio) < typical[1]
    assert bounds[0] < np.percentile(ratio, 5) < np.percentile(ratio, 95) < bounds[1]
    errors = np.degrees(turn_between(dance.bearing, np.arctan2(*travelled[far].T)))
    assert np.median(errors) < 3
    assert np.percentile(errors, 90) < 10


@pytest.mark.parametrize("variant", VARIANTS)
def test_dance_is_the_home_vector_from_the_other_end(variant: str) -> None:
    params = circuit_params(variant)
    memory = np.random.default_rng(0).uniform(0, 1, (5, 3, 16))
    dance = decode_waggle_dance(memory, params)
    home = decode_home_vector(memory, params)
    assert dance.bearing.shape == dance.distance.shape == (5, 3)
    np.testing.assert_allclose(home, -dance.distance[..., None] * unit_vector(dance.bearing), rtol=0, atol=1e-12)
    assert np.all((dance.bearing >= -np.pi) & (dance.bearing < np.pi))
    assert np.all(dance.distance >= 0)


@pytest.mark.parametrize("variant", [name for name in VARIANTS if name != "no-pontine"])
def test_plain_oracle_reads_the_same(variant: str) -> None:
    memory = np.random.default_rng(1).uniform(0, 1, (20, 16))
    dance = decode_waggle_dance(memory, circuit_params(variant))
    for index in range(len(memory)):
        bearing, distance = oracle.decode(memory[index], oracle.variant_params(variant))
        assert turn_between(dance.bearing[index], bearing) < 1e-12
        assert dance.distance[index] == pytest.approx(distance, rel=1e-12)


@given(bearing=bearings, distance=st.floats(1, 500), n_columns=st.integers(-9, 9))
def test_memory_rolled_by_a_column_is_turned_by_45_degrees(bearing: float, distance: float, n_columns: int) -> None:
    for params in (THESIS, IDEALISED):
        memory = linear_memory(bearing, distance, bearing, params)
        rolled = np.roll(memory.reshape(2, 8), n_columns, axis=1).ravel()
        before, after = decode_waggle_dance(memory, params), decode_waggle_dance(rolled, params)
        assert turn_between(after.bearing - before.bearing, n_columns * np.pi / 4) < 1e-9
        assert after.distance == pytest.approx(before.distance, rel=1e-9)


@given(bearing=bearings, distance=st.floats(1, 500))
def test_mirrored_memory_is_a_mirrored_vector(bearing: float, distance: float) -> None:
    right, left = linear_memory(bearing, distance, 0.3).reshape(2, 8)
    reflected = np.concatenate([left[-np.arange(8)], right[-np.arange(8)]])
    dance = decode_waggle_dance(reflected, IDEALISED)
    assert turn_between(dance.bearing, -bearing) < 1e-9
    assert dance.distance == pytest.approx(distance, rel=1e-9)


@pytest.mark.parametrize("level", [0.0, 0.5, 1.0])
def test_even_memory_says_at_home(level: float) -> None:
    np.testing.assert_allclose(decode_home_vector(np.full(16, level), THESIS), [0, 0], rtol=0, atol=1e-12)


def test_distance_counts_in_units_of_the_memory_gain() -> None:
    memory = np.random.default_rng(2).uniform(0, 1, 16)
    slower = replace(THESIS, memory_gain=THESIS.memory_gain / 4)
    expected = 4 * decode_waggle_dance(memory, THESIS).distance
    assert decode_waggle_dance(memory, slower).distance == pytest.approx(expected, rel=1e-14)
    np.testing.assert_array_equal(decode_home_vector(memory, CODE_2017), decode_home_vector(memory, THESIS))


def test_single_precision_memory_is_read_in_its_precision() -> None:
    memory = linear_memory(1.0, 200.0, 1.0)
    double, single = decode_home_vector(memory, IDEALISED), decode_home_vector(memory.astype("float32"), IDEALISED)
    assert single.dtype == "float32"
    np.testing.assert_allclose(single, double, rtol=0, atol=200 * 16 * 2.0**-24 / 0.35)


@pytest.mark.parametrize("shape", [(8,), (16, 2), (3, 17), ()])
def test_memory_of_another_shape_is_refused(shape: tuple) -> None:
    for decode in (decode_home_vector, decode_waggle_dance):
        with pytest.raises(InputError, match=r"^memory has shape .*expected \(\.\.\., 16\)"):
            decode(np.zeros(shape), THESIS)
