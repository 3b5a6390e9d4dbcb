"""Which way a path leaves a circle, on paths whose answer is known by hand or by walking them in tiny steps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from insectnav.checks import InputError
from insectnav.metrics.path_integration import departure_error

seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-3.0, 3.0)


def along(heading: float) -> np.ndarray:
    """Unit vector along a heading, clockwise from +y."""
    return np.array([math.sin(heading), math.cos(heading)])


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return vectors @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


def wandering(seed: int, n_trials: int = 4) -> np.ndarray:
    """Paths (trial, 80, 2) that start some way from the nest and drift away from there."""
    rng = np.random.default_rng(seed)
    start = (30.0 + 20.0 * rng.random((n_trials, 1, 1))) * np.stack([along(a) for a in rng.uniform(-3, 3, n_trials)])[
        :, None
    ]
    moves = rng.normal(size=(n_trials, 79, 2)) + 0.7 * rng.normal(size=(n_trials, 1, 2))
    return np.concatenate([start, start + np.cumsum(moves, axis=1)], axis=1)


@given(angles, angles, st.floats(0.1, 19.0))
def test_straight_course_is_its_own_error(bearing_of_home: float, error: float, radius: float):
    start = -25.0 * along(bearing_of_home)
    path = start + np.linspace(0.0, 20.0, 38)[:, None] * along(bearing_of_home + error)
    assert departure_error(path[None], radius)[0] == pytest.approx(error, abs=1e-9)


@pytest.mark.parametrize(
    ("corners", "crossing"),
    [
        ([(3, 0), (3, 8)], (3, 4)),
        ([(-3, 0), (-3, 8)], (-3, 4)),
        ([(0, 5)], (0, 5)),  # on the circle is out of it
        ([(0, 3), (0, 4.9), (4, 4.9), (4, -20)], (math.sqrt(25 - 4.9**2), 4.9)),
        ([(3, 0), (3, 8), (0, 0), (-30, 0)], (3, 4)),  # the first time counts
        ([(0, 0), (0, 0), (0, -1), (0, -1), (0, -9)], (0, -5)),
        ([(40, 0)], (5, 0)),  # in one step
        ([(1, 2), (math.nan, math.nan), (4, 3)], None),
    ],
)
def test_crossing_by_hand(corners: list, crossing: tuple | None):
    """The nest lies ahead, 10 along +y, and the circle has a radius of 5."""
    path = np.array([(0, 0), *corners], float) - np.array([0, 10])
    if crossing is None:
        assert np.isnan(departure_error(path[None], 5.0)[0])
        return
    error = departure_error(path[None], 5.0)[0]
    expected = math.atan2(*crossing)
    assert math.cos(error - expected) == pytest.approx(1.0, abs=1e-12)
    assert -math.pi <= error < math.pi


def test_crossing_is_that_of_tiny_steps():
    """Each step divided in 2000, about 0.001 in length: the direction is right to 0.001 in 6."""
    path, radius, n_crossings = wandering(1, n_trials=60), 6.0, 0
    share = np.arange(2000) / 2000
    for trial, error in zip(path, departure_error(path, radius), strict=True):
        tiny = (trial[:-1, None] + share[:, None] * np.diff(trial, axis=0)[:, None]).reshape(-1, 2)
        away = tiny - trial[0]
        outside = away[np.linalg.norm(away, axis=1) >= radius]
        assert np.isnan(error) == (len(outside) == 0)
        if len(outside):
            expected = math.atan2(*outside[0]) - math.atan2(*-trial[0])
            assert math.cos(error - expected) > math.cos(2e-3)
            n_crossings += 1
    assert n_crossings > 50


@given(seeds, angles)
def test_turning_the_world_changes_nothing(seed: int, by: float):
    path = wandering(seed)
    difference = departure_error(turned(path, by), 6.0) - departure_error(path, 6.0)
    assert_allclose(np.cos(difference[np.isfinite(difference)]), 1.0, atol=1e-12)
    assert np.array_equal(np.isnan(departure_error(turned(path, by), 6.0)), np.isnan(departure_error(path, 6.0)))


@given(seeds)
def test_mirror_turns_the_sign(seed: int):
    path = wandering(seed)
    assert_allclose(departure_error(path * (-1, 1), 6.0), -departure_error(path, 6.0), atol=1e-9)


@given(seeds, st.floats(0.01, 100.0))
def test_unit_does_not_matter(seed: int, factor: float):
    path = wandering(seed)
    assert_allclose(departure_error(factor * path, factor * 6.0), departure_error(path, 6.0), atol=1e-7)


def test_trials_are_taken_one_by_one():
    path = wandering(3, n_trials=50)
    assert_allclose(departure_error(path, 6.0), [departure_error(trial[None], 6.0)[0] for trial in path])


def test_path_that_stays_inside_or_starts_at_the_nest_has_none():
    still = np.full((1, 9, 2), 3.0)
    assert np.isnan(departure_error(still, 1.0)).all()
    from_the_nest = np.arange(9.0)[None, :, None] * (1.0, 0.0)
    assert np.isnan(departure_error(from_the_nest, 3.0)).all()
    assert departure_error(np.empty((0, 5, 2)), 3.0).shape == (0,)


@pytest.mark.parametrize("shape", [(5, 2), (3, 5, 3), (5,)])
def test_other_shape_is_refused(shape: tuple):
    with pytest.raises(InputError, match=r"^path has shape"):
        departure_error(np.zeros(shape), 3.0)


def test_path_of_one_sample_leaves_no_circle():
    assert np.isnan(departure_error(np.ones((3, 1, 2)), 20.0)).all()
