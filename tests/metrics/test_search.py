"""Arrivals, loops, centres and turns of paths whose answer is known by hand or by symmetry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.metrics.search import (
    NEVER,
    first_arrival,
    homeward_turn,
    search_centre,
    search_loops,
    searching,
)

seeds = st.integers(0, 2**32 - 1)


def along_y(*distances: float) -> np.ndarray:
    """A path (1, step, 2) on the +y axis."""
    return np.array([[(0.0, d) for d in distances]])


def wandering(seed: int, n_trials: int = 3, n_steps: int = 200) -> np.ndarray:
    """Random walks that are drawn to the nest."""
    rng = np.random.default_rng(seed)
    path = np.empty((n_trials, n_steps, 2))
    path[:, 0] = rng.normal(0.0, 20.0, (n_trials, 2))
    for step in range(1, n_steps):
        path[:, step] = 0.97 * path[:, step - 1] + rng.normal(0.0, 2.0, (n_trials, 2))
    return path


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return vectors @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


def circle(radius: float, centre: tuple[float, float], n_steps: int = 360) -> np.ndarray:
    """One clockwise turn on a circle, (1, step, 2)."""
    angle = np.arange(n_steps) * (2.0 * np.pi / n_steps)
    return (np.array(centre) + radius * np.stack([np.sin(angle), np.cos(angle)], axis=-1))[None]


# Arrival.


def test_arrival_by_hand():
    path = np.concatenate([along_y(50, 21, 20, 3), along_y(50, 40, 30, 20.5), along_y(1, 50, 50, 50)])
    assert first_arrival(path, 20.0).tolist() == [2, NEVER, 0]


def test_search_is_on_from_arrival_to_the_end():
    assert searching(4, [2, NEVER, 0]).tolist() == [[False, False, True, True], [False] * 4, [True] * 4]


# Loops.


def test_loops_by_hand():
    path = along_y(90, 10, 25, 45, 60, 45, 19, 30, 5, 20, 21, 41, 20, 99)
    loops = search_loops(path, 20.0, 40.0)
    # In from outside, round 60, a short one round 30 that does not count, round 41, and one that is not closed.
    assert loops.start.tolist() == [1, 9]
    assert loops.apex.tolist() == [4, 11]
    assert loops.end.tolist() == [6, 12]
    assert loops.reach.tolist() == [60.0, 41.0]
    assert loops.trial.tolist() == [0, 0]
    np.testing.assert_allclose(loops.direction, 0.0)


def test_path_that_hovers_on_the_inner_edge_makes_no_loop():
    assert search_loops(along_y(*([19.9, 20.1] * 30)), 20.0, 40.0).trial.size == 0


@given(seeds)
def test_loops_are_those_of_a_plain_walk_through_the_path(seed: int):
    inner, outer = 8.0, 14.0
    path = wandering(seed)
    expected = []
    for trial, one in enumerate(path):
        start = farthest = None
        for step, distance in enumerate(math.hypot(*place) for place in one):
            if distance <= inner:
                if farthest is not None and farthest[0] >= outer:
                    expected.append((trial, start, farthest[1], step))
                start, farthest = step, None
            elif start is not None and (farthest is None or distance > farthest[0]):
                farthest = (distance, step)
    loops = search_loops(path, inner, outer)
    assert list(zip(loops.trial, loops.start, loops.apex, loops.end, strict=True)) == expected


@given(seeds, st.floats(-3.0, 3.0))
def test_turning_the_world_turns_loops_and_nothing_else(seed: int, angle: float):
    path = wandering(seed)
    plain, rotated = search_loops(path, 8.0, 14.0), search_loops(turned(path, angle), 8.0, 14.0)
    np.testing.assert_array_equal(plain.apex, rotated.apex)
    np.testing.assert_allclose(rotated.reach, plain.reach)
    np.testing.assert_allclose(np.exp(1j * rotated.direction), np.exp(1j * (plain.direction + angle)), atol=1e-9)


def test_many_trials_are_each_alone():
    path = wandering(4, n_trials=5, n_steps=400)
    together = search_loops(path, 8.0, 14.0)
    apart = [search_loops(one[None], 8.0, 14.0).apex for one in path]
    np.testing.assert_array_equal(together.apex, np.concatenate(apart))
    np.testing.assert_array_equal(together.trial, np.repeat(np.arange(5), [len(a) for a in apart]))


# Centre.


def test_centre_of_a_circle_and_of_nothing():
    path = np.concatenate([circle(7.0, (3.0, -2.0)), circle(7.0, (3.0, -2.0))])
    centre = search_centre(path, [0, NEVER])
    np.testing.assert_allclose(centre[0], [3.0, -2.0], atol=1e-12)
    assert np.isnan(centre[1]).all()


def test_centre_counts_from_the_first_step_on():
    np.testing.assert_allclose(search_centre(along_y(100, 1, 2, 3), [1]), [[0.0, 2.0]])


# Turns towards home.


@pytest.mark.parametrize("way", [1, -1])
def test_circling_the_nest_turns_towards_it_either_way(way: int):
    """On a circle of 360 steps round the nest each turn is 1° to the side of the nest."""
    turn = homeward_turn(circle(50.0, (0.0, 0.0))[:, ::way], [0.0, 49.0, 51.0])
    assert np.isnan(turn[0])
    assert turn[1] == pytest.approx(np.radians(1.0))


def test_circle_beside_the_nest_turns_away_where_it_is_near():
    """Seen from outside the circle, the near side of it bends away and the far side towards the nest."""
    near = homeward_turn(circle(10.0, (0.0, 40.0)), [29.9, 30.5])[0]
    far = homeward_turn(circle(10.0, (0.0, 40.0)), [49.5, 50.1])[0]
    assert near == pytest.approx(-np.radians(1.0))
    assert far == pytest.approx(np.radians(1.0))


def test_straight_path_does_not_turn():
    beside_the_nest = along_y(*range(-30, 30)) + np.array([5.0, 0.0])
    np.testing.assert_allclose(homeward_turn(beside_the_nest, [0.0, 100.0]), 0.0, atol=1e-12)


@given(seeds)
def test_mirror_image_turns_as_much_towards_home(seed: int):
    path = wandering(seed)
    edges = [0.0, 10.0, 20.0, 100.0]
    np.testing.assert_allclose(homeward_turn(path * [-1.0, 1.0], edges), homeward_turn(path, edges), atol=1e-9)


def test_only_the_wanted_steps_count():
    path = np.concatenate([circle(50.0, (0.0, 0.0)), circle(10.0, (0.0, 300.0))])
    wanted = searching(360, [0, NEVER])
    assert homeward_turn(path, [0.0, 1000.0], wanted)[0] == pytest.approx(np.radians(1.0))


def test_a_loop_reaches_the_outer_circle_when_it_touches_it():
    assert len(search_loops(along_y(0.0, 3.0, 0.0), 1.0, 3.0).apex) == 1
    assert len(search_loops(along_y(0.0, 3.0, 0.0), 1.0, 3.1).apex) == 0


def test_home_is_on_the_side_on_which_it_lay_before_the_turn():
    """South of home, the course is 10° to the right of north and turns 30° to the left: across home, and towards it."""
    headings = np.radians([10.0, -20.0])
    steps = np.stack([np.sin(headings), np.cos(headings)], axis=-1)
    path = np.array([[-steps[0], np.zeros(2), steps[1]]]) + np.array([0.0, -10.0])
    assert homeward_turn(path, [0.0, 20.0])[0] == pytest.approx(np.radians(30.0))


# Bad input.


def test_outer_circle_is_the_larger_one():
    with pytest.raises(InputError, match="outer circle has a radius of 10, expected more than the inner one's 20"):
        search_loops(along_y(1.0, 2.0), 20.0, 10.0)


@pytest.mark.parametrize("function", [lambda p: first_arrival(p, 1.0), lambda p: search_loops(p, 1.0, 2.0)])
def test_path_of_another_shape_is_refused(function):
    with pytest.raises(InputError, match="path"):
        function(np.zeros((5, 2)))


def test_a_path_in_unsigned_numbers_is_the_same_path():
    path = np.array([[(9, 9), (7, 8), (4, 8), (3, 5), (1, 2)]])
    edges = [0.0, 100.0]
    assert homeward_turn(path.astype(np.uint8), edges) == pytest.approx(homeward_turn(path.astype(float), edges))
