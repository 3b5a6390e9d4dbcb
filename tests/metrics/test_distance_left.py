"""The share of the way left and tortuosity, on paths whose answer is known by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.metrics.straightness import distance_left, tortuosity

seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-10.0, 10.0)


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return vectors @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


def through(*corners: tuple[float, float]) -> np.ndarray:
    """A path (1, step, 2) of these positions."""
    return np.array([corners], float)


def straight(start: float, end: float, n_steps: int) -> np.ndarray:
    """A path (1, step, 2) along y."""
    y = np.linspace(start, end, n_steps + 1)
    return np.stack([np.zeros_like(y), y], axis=-1)[None]


def wandering(seed: int, n_trials: int = 3, n_steps: int = 60) -> np.ndarray:
    """Paths that start about 20 from the nest and stagger towards it; no two distances are equal."""
    rng = np.random.default_rng(seed)
    start = rng.normal(0.0, 10.0, (n_trials, 1, 2)) + np.sign(rng.normal(size=(n_trials, 1, 2))) * 5.0
    home = -start / np.linalg.norm(start, axis=-1, keepdims=True)
    return np.concatenate([start, start + np.cumsum(home + rng.normal(size=(n_trials, n_steps, 2)), axis=1)], axis=1)


def semicircle(n_steps: int = 20_000, diameter: float = 10.0) -> np.ndarray:
    """From (0, diameter) to the nest along half a circle."""
    angle = np.linspace(0.0, np.pi, n_steps + 1)
    return diameter / 2 * np.stack([np.sin(angle), 1.0 + np.cos(angle)], axis=-1)[None]


@pytest.mark.parametrize(
    ("path", "left"),
    [
        (straight(10.0, 0.0, 10), 0.0),
        (straight(10.0, -5.0, 15), 0.0),  # on beyond the nest
        (straight(10.0, 30.0, 20), 1.0),  # away from it
        (through((0, 10), (5, 10), (10, 10)), 1.0),  # across, no nearer than at the start
        (through((3, 4), (3, 2), (3, 0), (2, 0), (1, 0), (0, 0)), 0.4),  # 5 walked at (2, 0), of 5
        (through((0, 10), (0, 6), (0, 2), (0, -2), (0, -6)), 0.2),  # 12 walked; nearest were (0, 2) and (0, -2)
        (through((0, 10), (0, 1), (0, 2), (0, 9)), 0.1),  # was at 1 before it was at 2
        (through((0, 8), (0, 8), (0, 4), (0, 4), (0, 0)), 0.0),  # rests count for nothing
        (through((4, 0), (0, 4), (0, 0)), 1.0),  # what comes after path length L does not count
    ],
)
def test_distance_left_by_hand(path: np.ndarray, left: float):
    np.testing.assert_allclose(distance_left(path), [left], rtol=0, atol=1e-12)


def test_distance_left_on_half_a_circle_is_a_chord():
    # After path length L on a circle of radius L / 2, π − 2 rad are left: their chord is L sin(π / 2 − 1) = L cos 1.
    assert distance_left(semicircle())[0] == pytest.approx(math.cos(1.0), abs=1e-3)
    assert tortuosity(distance_left(semicircle())) == pytest.approx(1.0 / (1.0 - math.cos(1.0)), abs=5e-3)


@pytest.mark.parametrize(
    "path",
    [
        straight(10.0, 0.5, 19),  # 9.5 walked, of 10
        straight(10.0, 10.0, 5),  # stands still
        straight(0.0, 10.0, 10),  # starts at the nest
        through((0, 0), (0, 0)),
        through((0, 3)),  # not a single step
    ],
)
def test_path_too_short_or_without_a_way_has_no_straightness(path: np.ndarray):
    np.testing.assert_array_equal(distance_left(path), [np.nan])
    assert math.isnan(tortuosity(distance_left(path)))


def test_tortuosity_takes_the_mean_over_trials_first():
    paths = np.concatenate([straight(10.0, 0.0, 10), straight(10.0, 30.0, 10), straight(10.0, 9.0, 10)])
    np.testing.assert_array_equal(distance_left(paths), [0.0, 1.0, np.nan])
    assert tortuosity(distance_left(paths)) == 1.0 / (1.0 - 0.5)
    assert tortuosity(distance_left(paths[:1])) == 1.0


def test_tortuosity_of_agents_that_come_no_nearer_is_infinite():
    assert tortuosity(distance_left(straight(10.0, 30.0, 20))) == math.inf


def test_no_trials_have_no_tortuosity():
    assert distance_left(np.zeros((0, 5, 2))).shape == (0,)
    assert math.isnan(tortuosity(distance_left(np.zeros((0, 5, 2)))))


@pytest.mark.parametrize("shape", [(5, 2), (3, 5, 3), (2, 2, 5, 2), (2,)])
def test_path_of_another_shape_is_refused(shape: tuple):
    with pytest.raises(InputError, match=r"^path has shape .*expected \(trial, step, 2\)"):
        distance_left(np.zeros(shape))


@given(seeds, angles, st.integers(-20, 20))
def test_turning_or_stretching_the_world_changes_no_straightness(seed: int, by: float, power: int):
    paths = wandering(seed)
    left = distance_left(paths)
    np.testing.assert_array_equal(distance_left(paths * 2.0**power), left)
    np.testing.assert_allclose(distance_left(turned(paths, by)), left, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(distance_left(paths * [-1.0, 1.0]), left)


@given(seeds)
def test_paths_in_batches_are_as_one_by_one(seed: int):
    paths = wandering(seed, n_trials=5)
    np.testing.assert_array_equal(distance_left(paths), np.concatenate([distance_left(path[None]) for path in paths]))


@given(seeds)
def test_distance_left_is_a_share(seed: int):
    left = distance_left(wandering(seed, n_steps=400))
    assert np.isfinite(left).all()
    assert (left >= 0.0).all()
    assert (left <= 1.0).all()


def test_arguments_are_left_as_they_are():
    paths = wandering(1)
    before = paths.copy()
    distance_left(paths)
    tortuosity(distance_left(paths))
    np.testing.assert_array_equal(paths, before)
