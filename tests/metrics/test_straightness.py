"""The curve of the distance left, on paths whose answer is known by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.metrics.straightness import distance_left, distance_left_along

SHARES = np.linspace(0.0, 1.5, 16)


def wandering(seed: int, n_trials: int = 4, n_steps: int = 90) -> np.ndarray:
    rng = np.random.default_rng(seed)
    start = rng.normal(0.0, 10.0, (n_trials, 1, 2)) + 5.0
    home = -start / np.linalg.norm(start, axis=-1, keepdims=True)
    return np.concatenate([start, start + np.cumsum(home + rng.normal(size=(n_trials, n_steps, 2)), axis=1)], axis=1)


def test_straight_line_loses_what_it_walks():
    y = np.linspace(10.0, -6.0, 16_001)
    left = distance_left_along(np.stack([0.0 * y, y], axis=-1)[None], SHARES)
    np.testing.assert_allclose(left[0], np.maximum(1.0 - SHARES, 0.0), atol=2e-4)
    there = distance_left_along(np.stack([0.0 * y, y], axis=-1)[None], SHARES, nearest_so_far=False)
    np.testing.assert_allclose(there[0], np.abs(1.0 - SHARES), atol=2e-4)


def test_half_a_circle_leaves_a_chord():
    # On a circle whose diameter is the way, a path s leaves an arc of π − 2 s / L and its chord, L cos(s / L).
    angle = np.linspace(0.0, np.pi, 50_001)
    path = 4.0 * np.stack([np.sin(angle), 1.0 + np.cos(angle)], axis=-1)[None]
    np.testing.assert_allclose(distance_left_along(path, SHARES)[0], np.cos(SHARES), atol=2e-4)


def test_steps_by_hand():
    path = np.array([[(0, 10), (0, 6), (0, 9), (0, 2), (4, 2)]], float)  # walked 0, 4, 7, 14, 18
    shares = [0.0, 0.4, 0.5, 0.7, 0.8, 1.4, 1.8, 1.9]
    np.testing.assert_allclose(distance_left_along(path, shares)[0], [1, 0.6, 0.6, 0.6, 0.2, 0.2, 0.2, np.nan])
    there = distance_left_along(path, shares, nearest_so_far=False)[0]
    np.testing.assert_allclose(there, [1, 0.6, 0.9, 0.9, 0.2, 0.2, np.sqrt(20.0) / 10.0, np.nan])


def test_path_at_the_nest_or_of_one_sample_has_no_curve():
    assert np.isnan(distance_left_along(np.zeros((2, 5, 2)), [0.0, 1.0])).all()
    np.testing.assert_array_equal(distance_left_along(np.full((1, 1, 2), 3.0), [0.0, 0.1]), [[1.0, np.nan]])
    assert distance_left_along(np.zeros((0, 5, 2)), SHARES).shape == (0, 16)


@given(st.integers(0, 2**32 - 1))
def test_curve_falls_and_passes_through_distance_left(seed: int):
    path = wandering(seed)
    left = distance_left_along(path, SHARES)
    np.testing.assert_array_equal(left[:, 10], distance_left(path))
    assert (np.diff(left, axis=1)[np.isfinite(np.diff(left, axis=1))] <= 0.0).all()
    there = distance_left_along(path, SHARES, nearest_so_far=False)
    np.testing.assert_array_equal(np.isnan(there), np.isnan(left))
    assert (there[np.isfinite(there)] >= left[np.isfinite(left)]).all()


@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0))
def test_turning_and_stretching_the_world_changes_nothing(seed: int, by: float):
    path = wandering(seed)
    turned = 8.0 * path @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])
    # Between samples, where rounding cannot move the step at which a share is reached.
    shares = SHARES[1:] + 1e-4
    np.testing.assert_allclose(
        distance_left_along(turned, shares), distance_left_along(path, shares), rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize(
    ("path", "shares", "message"),
    [
        (np.zeros((5, 2)), [1.0], "path has shape"),
        (np.zeros((1, 5, 2)), 1.0, "shares has shape"),
        (np.zeros((1, 5, 2)), [np.nan], "shares"),
    ],
)
def test_other_shapes_and_holes_are_refused(path: np.ndarray, shares: object, message: str):
    with pytest.raises(InputError, match=message):
        distance_left_along(path, shares)
