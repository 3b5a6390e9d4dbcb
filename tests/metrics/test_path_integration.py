"""Distances, decoded vectors and straightness on paths whose answer is known by hand."""

import math
import statistics

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.metrics.path_integration import bearing_error, distance_left, length_ratio, summary, tortuosity

finite = st.floats(-1e6, 1e6)
seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-10.0, 10.0)


def along(heading: float, length: float = 1.0) -> np.ndarray:
    """Vector of that length along a heading, clockwise from +y."""
    return length * np.array([math.sin(heading), math.cos(heading)])


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


# Summary.


def test_summary_by_hand():
    mean, median, sd, p90, n = summary([10.0, 1.0, 4.0, 2.0, 3.0])
    assert (mean, median, n) == (4.0, 3.0, 5)
    assert sd == pytest.approx(math.sqrt((9 + 4 + 1 + 0 + 36) / 4))
    assert p90 == pytest.approx(4.0 + 0.6 * 6.0)  # six tenths of the way from the fourth to the fifth


@pytest.mark.parametrize("hole", [np.nan, np.inf, -np.inf])
def test_summary_leaves_out_what_is_not_finite(hole: float):
    assert summary([1.0, hole, 4.0, hole]) == summary([1.0, 4.0])
    assert summary([1.0, hole, 4.0]).n == 2


@pytest.mark.parametrize("nothing", [[], [np.nan], [[np.nan, np.inf]]])
def test_summary_of_nothing(nothing: list):
    got = summary(nothing)
    assert np.isnan(got[:4]).all()
    assert got.n == 0


def test_single_value_has_no_spread():
    got = summary(7.0)
    assert (got.mean, got.median, got.p90, got.n) == (7.0, 7.0, 7.0, 1)
    assert math.isnan(got.sd)


def test_summary_of_a_share_and_of_many_axes():
    assert summary(np.array([[True, False], [True, True]])).mean == 0.75
    assert summary(np.arange(24).reshape(2, 3, 4)).n == 24


@given(st.lists(finite, min_size=2, max_size=40))
def test_summary_agrees_with_the_standard_library(values: list[float]):
    got = summary(values)
    close = {"rel": 1e-9, "abs": 1e-6}
    assert got.mean == pytest.approx(statistics.fmean(values), **close)
    assert got.median == pytest.approx(statistics.median(values), **close)
    assert got.sd == pytest.approx(statistics.stdev(values), **close)
    assert got.p90 == pytest.approx(statistics.quantiles(values, n=10, method="inclusive")[8], **close)


# Decoded vectors.


@pytest.mark.parametrize(
    ("decoded", "true", "error_deg"),
    [
        ((1, 0), (0, 1), 90),
        ((-1, 0), (0, 1), -90),
        ((0, 3), (0, 1), 0),
        ((0, -1), (0, 1), -180),
        (along(math.radians(-170)), along(math.radians(170)), 20),
        (along(math.radians(170)), along(math.radians(-170)), -20),
    ],
)
def test_bearing_error_is_positive_clockwise(decoded: tuple, true: tuple, error_deg: float):
    assert math.degrees(bearing_error(decoded, true)) == pytest.approx(error_deg, abs=1e-9)


@pytest.mark.parametrize(("decoded", "true"), [((0, 0), (1, 0)), ((1, 0), (0, 0)), ((0, 0), (0, 0))])
def test_null_vector_has_no_bearing(decoded: tuple, true: tuple):
    assert np.isnan(bearing_error(decoded, true))


def test_length_ratio_by_hand():
    ratio = length_ratio([[3, 4], [0, 0], [0, 10]], [[0, 10], [1, 0], [6, 8]])
    np.testing.assert_allclose(ratio, [0.5, 0.0, 1.0], rtol=1e-12)


def test_length_ratio_to_a_null_vector_does_not_exist():
    assert np.isnan(length_ratio([[3.0, 4.0]], [[0.0, 0.0]])).all()


@given(angles, angles, st.floats(0.01, 100.0), st.floats(0.01, 100.0))
def test_vectors_of_known_bearing_and_length(true: float, error: float, length: float, ratio: float):
    decoded, real = along(true + error, length * ratio), along(true, length)
    got = bearing_error(decoded, real)
    assert -np.pi <= got < np.pi
    assert abs(np.exp(1j * got) - np.exp(1j * error)) < 1e-9
    assert length_ratio(decoded, real) == pytest.approx(ratio)


@given(seeds, angles, st.floats(0.001, 1000.0))
def test_turning_or_stretching_the_world_changes_no_error(seed: int, by: float, scale: float):
    decoded, true = np.random.default_rng(seed).normal(size=(2, 5, 2))
    error = bearing_error(turned(decoded, by) * scale, turned(true, by) * scale)
    assert np.abs(np.exp(1j * error) - np.exp(1j * bearing_error(decoded, true))).max() < 1e-9
    ratio = length_ratio(turned(decoded, by) * scale, turned(true, by) * scale)
    np.testing.assert_allclose(ratio, length_ratio(decoded, true), rtol=1e-9)


def test_vectors_in_batches_are_as_one_by_one():
    decoded, true = np.random.default_rng(4).normal(size=(2, 3, 4, 2))
    for measure in (bearing_error, length_ratio):
        batch = measure(decoded, true)
        assert batch.shape == (3, 4)
        for index in np.ndindex(3, 4):
            assert batch[index] == measure(decoded[index], true[index])


# Straightness.


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
