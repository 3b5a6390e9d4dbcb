"""How an agent moves: closed forms of drag and thrust, the sign of a turn, and the plain oracle."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import oracle
from insectnav.agents import MotionParams, move
from insectnav.checks import InputError

HOMING = MotionParams()
angles = st.floats(-10, 10)
speeds = st.floats(-3, 3)


def fly(heading: float, velocity: list, n_steps: int, params: MotionParams, turn: float = 0.0) -> np.ndarray:
    """Velocities of a flight with equal turns, (n_steps, 2)."""
    velocities = []
    for _ in range(n_steps):
        heading, velocity = move(heading, velocity, turn, params)
        velocities.append(velocity)
    return np.array(velocities)


def test_constants_are_the_published_ones() -> None:
    assert (HOMING.drag, HOMING.acceleration) == (0.15, 0.1)


@pytest.mark.parametrize(("acceleration", "terminal_speed"), [(0.1, 0.567), (0.15, 0.85)])
def test_straight_flight_reaches_the_terminal_speed(acceleration: float, terminal_speed: float) -> None:
    velocity = fly(0.7, [0, 0], 200, replace(HOMING, acceleration=acceleration))[-1]
    np.testing.assert_allclose(velocity, terminal_speed * np.array([np.sin(0.7), np.cos(0.7)]), rtol=0, atol=5e-4)


def test_speed_from_rest_is_a_geometric_sum() -> None:
    kept = 1 - 0.15
    expected = [0.1 * sum(kept**power for power in range(1, n + 1)) for n in range(1, 31)]
    velocity = fly(0, [0, 0], 30, HOMING)
    np.testing.assert_allclose(velocity, np.column_stack([np.zeros(30), expected]), rtol=0, atol=1e-14)


def test_without_thrust_speed_decays() -> None:
    velocity = fly(0.3, [0.4, -0.2], 10, MotionParams(acceleration=0.0), turn=0.5)
    expected = 0.85 ** np.arange(1, 11)[:, None] * [0.4, -0.2]
    np.testing.assert_allclose(velocity, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("turn", "direction"), [(0.0, [0, 1]), (np.pi / 2, [1, 0]), (-np.pi / 2, [-1, 0]), (np.pi, [0, -1])]
)
def test_positive_turn_is_to_the_right_and_comes_before_the_thrust(turn: float, direction: list) -> None:
    heading, velocity = move(0.0, [0.0, 0.0], turn, MotionParams(drag=0.0, acceleration=2.0))
    np.testing.assert_allclose(velocity, 2.0 * np.array(direction), rtol=0, atol=1e-15)
    np.testing.assert_allclose([np.sin(heading), np.cos(heading)], direction, rtol=0, atol=1e-15)


@given(heading=angles, turn=angles, x=speeds, y=speeds)
def test_plain_oracle_moves_alike(heading: float, turn: float, x: float, y: float) -> None:
    ours = move(heading, [x, y], turn, HOMING)
    theirs = oracle.move(heading, np.array([x, y]), turn, HOMING.acceleration, HOMING.drag)
    assert abs(np.angle(np.exp(1j * (ours[0] - theirs[0])))) < 1e-14
    assert -np.pi <= ours[0] < np.pi
    np.testing.assert_allclose(ours[1], theirs[1], rtol=0, atol=1e-14)


@given(heading=angles, turn=angles, x=speeds, y=speeds, by=angles)
def test_turned_world_turns_the_motion(heading: float, turn: float, x: float, y: float, by: float) -> None:
    rotation = np.array([[np.cos(by), np.sin(by)], [-np.sin(by), np.cos(by)]])  # clockwise
    plain = move(heading, [x, y], turn, HOMING)[1]
    turned = move(heading + by, rotation @ [x, y], turn, HOMING)[1]
    np.testing.assert_allclose(turned, rotation @ plain, rtol=0, atol=1e-14)


@given(heading=angles, turn=angles, x=speeds, y=speeds)
def test_mirrored_world_mirrors_the_motion(heading: float, turn: float, x: float, y: float) -> None:
    plain, mirrored = move(heading, [x, y], turn, HOMING)[1], move(-heading, [-x, y], -turn, HOMING)[1]
    np.testing.assert_allclose(mirrored, plain * [-1, 1], rtol=0, atol=1e-15)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_batch_is_a_loop(dtype: str) -> None:
    rng = np.random.default_rng(0)
    heading, turn = rng.uniform(-4, 4, (2, 5, 3)).astype(dtype)
    velocity = rng.normal(0, 1, (5, 3, 2)).astype(dtype)
    given_arrays = [array.copy() for array in (heading, velocity, turn)]
    headings, velocities = move(heading, velocity, turn, HOMING)
    assert headings.dtype == velocities.dtype == dtype
    for index in np.ndindex(5, 3):
        one_heading, one_velocity = move(heading[index], velocity[index], turn[index], HOMING)
        assert headings[index] == one_heading
        np.testing.assert_array_equal(velocities[index], one_velocity)
    for array, before in zip((heading, velocity, turn), given_arrays, strict=True):
        np.testing.assert_array_equal(array, before)


@pytest.mark.parametrize(
    ("name", "value"),
    [("drag", -0.1), ("drag", 1.5), ("drag", np.nan), ("acceleration", -0.1), ("acceleration", np.inf)],
)
def test_constant_out_of_its_range_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"^{name} is "):
        MotionParams(**{name: value})


def test_constants_are_frozen_and_named() -> None:
    with pytest.raises(FrozenInstanceError):
        HOMING.drag = 0.2
    with pytest.raises(TypeError):
        MotionParams(0.15, 0.1)
    assert hash(MotionParams()) == hash(HOMING)
