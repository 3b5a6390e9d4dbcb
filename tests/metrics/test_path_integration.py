"""Summaries and decoded vectors whose answer is known by hand."""

import math
import statistics

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.metrics.path_integration import bearing_error, length_ratio, summary

finite = st.floats(-1e6, 1e6)
seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-10.0, 10.0)


def along(heading: float, length: float = 1.0) -> np.ndarray:
    """Vector of that length along a heading, clockwise from +y."""
    return length * np.array([math.sin(heading), math.cos(heading)])


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return vectors @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


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
