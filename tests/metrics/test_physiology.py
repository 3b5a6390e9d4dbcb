"""Rates and tuning curves of spike trains that were made with known ones."""

import math
from itertools import pairwise

import numpy as np
import pytest
from astropy.stats import circmean
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import circmean as scipy_circmean

from insectnav.checks import InputError
from insectnav.metrics.physiology import (
    background_rate,
    binned_rate,
    mean_rate,
    population_tuning,
    preferred_expansion_point,
    tuning_curve,
)
from spike_trains import poisson, regular

seeds = st.integers(0, 2**32 - 1)
VELOCITIES_DEG = (-90.0, -30.0, 30.0, 90.0)  # [°/s]
RATES = (8.0, 24.0, 96.0, 160.0)  # [1/s] evoked by them
ALL_ROUND = np.deg2rad([-180.0, -135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0])


def bouts(velocities: tuple, first: float = 4.0) -> tuple[np.ndarray, np.ndarray]:
    """Start and stop of bouts of 3 s with pauses of 3.5 s."""
    start = first + 6.5 * np.arange(len(velocities))
    return start, start + 3.0


def optic_flow_spikes(start: np.ndarray, rates: tuple) -> np.ndarray:
    """5 spikes/s before the first bout; 200 in the first second of each, then its rate, then nothing."""
    trains = [regular(5.0, 0.0, start[0])]
    for begin, rate in zip(start, rates, strict=True):
        trains += [regular(200.0, begin, begin + 1.0), regular(rate, begin + 1.0, begin + 3.0)]
    return np.concatenate(trains)


# Rates.


@pytest.mark.parametrize("rate", [4.0, 40.0, 200.0])
def test_regular_train_has_its_rate_in_every_bin(rate: float):
    time, binned = binned_rate(regular(rate, 0.0, 10.0), 2.0, 5.0)
    np.testing.assert_allclose(time, 0.125 + 0.25 * np.arange(12), rtol=1e-12)
    np.testing.assert_allclose(binned, rate, rtol=1e-12)


def test_bin_includes_its_start_and_not_its_end():
    assert binned_rate([1.0, 1.25, 1.5], 1.0, 1.5).rate.tolist() == [4.0, 4.0]
    assert mean_rate([1.0, 1.25, 1.5], 1.0, 1.5) == 4.0


@pytest.mark.parametrize(
    ("duration", "width", "n_bins"), [(3.0, 0.25, 12), (0.3, 0.1, 3), (1.0, 0.3, 3), (0.7, 0.7, 1)]
)
def test_only_whole_bins_count(duration: float, width: float, n_bins: int):
    for start in (0.0, 1.1, 700.3):
        assert binned_rate([], start, start + duration, width).rate.tolist() == [0.0] * n_bins


def test_bouts_in_batches_are_as_one_by_one():
    spikes = poisson(lambda t: 60.0 + 0 * t, 60.0, 30.0, seed=1)
    start = np.array([[1.0, 5.5, 8.25], [12.0, 16.1, 21.7]])
    batch = binned_rate(spikes, start, start + 3.0)
    assert batch.rate.shape == (2, 3, 12)
    for index in np.ndindex(2, 3):
        one = binned_rate(spikes, start[index], start[index] + 3.0).rate
        np.testing.assert_array_equal(batch.rate[index], one)
        assert mean_rate(spikes, start, start + 3.0)[index] == pytest.approx(one.mean())


@given(st.lists(st.floats(0.0, 20.0), max_size=60), st.floats(0.0, 10.0), st.floats(0.5, 8.0))
def test_rates_agree_with_counting(spikes: list[float], start: float, duration: float):
    stop = start + duration
    assert mean_rate(spikes, start, stop) == pytest.approx(sum(start <= t < stop for t in spikes) / (stop - start))
    time, rate = binned_rate(spikes, start, stop, 0.5)
    edges = [start + 0.5 * k for k in range(len(time) + 1)]
    assert (rate * 0.5).tolist() == [sum(a <= t < b for t in spikes) for a, b in pairwise(edges)]


def test_rate_of_a_poisson_train_is_recovered():
    spikes = poisson(lambda t: 50.0 + 40.0 * np.cos(2.0 * np.pi * t / 5.0), 90.0, 400.0, seed=3)
    # Over a fifth of a period about the peak the mean of cos is sin(π/5) / (π/5); 79 peaks.
    expected = 50.0 + 40.0 * math.sin(math.pi / 5) / (math.pi / 5)
    peaks = 5.0 * np.arange(1, 80)
    got = mean_rate(spikes, peaks - 0.5, peaks + 0.5).mean()
    assert abs(got - expected) < 5.0 * math.sqrt(expected / len(peaks))


def test_background_is_the_last_two_seconds_before_the_first_stimulus():
    spikes = np.concatenate([regular(70.0, 0.0, 3.0), regular(6.0, 3.0, 5.0), regular(200.0, 5.0, 8.0)])
    assert background_rate(spikes, 5.0) == pytest.approx(6.0)
    assert background_rate(spikes, 5.0, duration=4.0) == pytest.approx((2 * 70.0 + 2 * 6.0) / 4)
    assert background_rate(spikes - 5.0, 0.0, recording_start=-5.0) == pytest.approx(6.0)


# Tuning curves.


def test_tuning_curve_is_the_rate_over_the_last_two_seconds():
    order = (2, 0, 3, 1)
    start, stop = bouts(order)
    spikes = optic_flow_spikes(start, tuple(RATES[i] for i in order))
    curve = tuning_curve(spikes, start, stop, [VELOCITIES_DEG[i] for i in order], background=background_rate(spikes, 4))
    np.testing.assert_array_equal(curve.condition, VELOCITIES_DEG)
    np.testing.assert_allclose(curve.rate, RATES)
    np.testing.assert_allclose(curve.normalised, np.array(RATES) / 160.0)
    assert curve.n_bouts.tolist() == [1, 1, 1, 1]
    assert curve.background == pytest.approx(5.0)
    assert curve.normalised_background == pytest.approx(5.0 / 160.0)


def test_repeats_of_a_condition_are_averaged():
    velocities = (30.0, 60.0, 30.0, 30.0)
    start, stop = bouts(velocities)
    curve = tuning_curve(optic_flow_spikes(start, (10.0, 80.0, 30.0, 20.0)), start, stop, velocities)
    np.testing.assert_allclose(curve.rate, [20.0, 80.0])
    np.testing.assert_allclose(curve.normalised, [0.25, 1.0])
    assert curve.n_bouts.tolist() == [3, 1]
    assert math.isnan(curve.normalised_background)


@given(seeds, st.floats(-50.0, 50.0))
def test_a_later_clock_or_another_order_changes_no_tuning(seed: int, delay: float):
    rng = np.random.default_rng(seed)
    start, stop = bouts(VELOCITIES_DEG * 2)
    condition = np.array(VELOCITIES_DEG * 2)
    spikes = rng.uniform(0.0, 60.0, 300)
    first = tuning_curve(spikes, start, stop, condition)
    order = rng.permutation(len(start))
    other = tuning_curve(
        rng.permutation(spikes) + delay, (start + delay)[order], (stop + delay)[order], condition[order]
    )
    np.testing.assert_allclose(other.rate, first.rate, rtol=1e-12)
    assert first.normalised.max() == 1.0


def test_silent_cell_has_rates_but_no_normalised_ones():
    start, stop = bouts(VELOCITIES_DEG)
    curve = tuning_curve([], start, stop, VELOCITIES_DEG, background=2.0)
    assert curve.rate.tolist() == [0.0] * 4
    assert np.isnan([*curve.normalised, curve.normalised_background]).all()
    with pytest.raises(InputError, match="normalised rate of cell 0"):
        population_tuning([curve])


def test_population_by_hand():
    start, stop = bouts((1.0, 2.0))
    rates = ((20.0, 100.0), (30.0, 100.0), (40.0, 100.0))
    curves = [
        tuning_curve(optic_flow_spikes(start, rate), start, stop, (1.0, 2.0), background=background)
        for rate, background in zip(rates, (10.0, 30.0, math.nan), strict=True)
    ]
    curves.append(tuning_curve(regular(50.0, 0, 9), [4.0], [7.0], [3.0]))
    population = population_tuning(curves)
    assert population.condition.tolist() == [1.0, 2.0, 3.0]
    assert population.n_cells.tolist() == [3, 3, 1]
    np.testing.assert_allclose(population.mean, [0.3, 1.0, 1.0])
    np.testing.assert_allclose(population.sd, [0.1, 0.0, math.nan], atol=1e-12)
    assert population.background_mean == pytest.approx(0.2)
    assert population.background_sd == pytest.approx(math.sqrt(0.02))


# Preferred expansion point.


@given(seeds, st.integers(3, 12))
def test_expansion_point_agrees_with_astropy(seed: int, n: int):
    rng = np.random.default_rng(seed)
    azimuth, rate = rng.uniform(-np.pi, np.pi, n), rng.uniform(0.0, 200.0, n)
    got = preferred_expansion_point(azimuth, rate)
    assert abs(np.exp(1j * got.azimuth) - np.exp(1j * circmean(azimuth, weights=rate))) < 1e-9 / got.vector_length
    assert got.vector_length == pytest.approx(abs(np.exp(1j * azimuth) @ rate) / rate.sum())


def test_rate_is_the_number_of_times_that_an_azimuth_stands_in_the_sample():
    count = np.array([0, 1, 2, 5, 9, 12, 6, 3])
    sample = np.repeat(ALL_ROUND, count)
    assert preferred_expansion_point(ALL_ROUND, count).azimuth == pytest.approx(
        scipy_circmean(sample, high=np.pi, low=-np.pi)
    )


@pytest.mark.parametrize("preferred_deg", [-135.0, -45.0, 0.0, 45.0, 170.0])
def test_expansion_point_of_a_cosine_is_its_peak(preferred_deg: float):
    preferred = math.radians(preferred_deg)
    azimuth, length = preferred_expansion_point(ALL_ROUND, 60.0 + 30.0 * np.cos(ALL_ROUND - preferred))
    assert math.degrees(azimuth) == pytest.approx(preferred_deg)
    assert length == pytest.approx(0.5 * 30.0 / 60.0)


@given(seeds, st.integers(0, 7))
def test_expansion_point_turns_and_mirrors_with_the_stimulus(seed: int, by: int):
    rate = np.random.default_rng(seed).uniform(0.0, 100.0, 8)
    azimuth = preferred_expansion_point(ALL_ROUND, rate).azimuth
    turned = preferred_expansion_point(ALL_ROUND, np.roll(rate, by)).azimuth
    mirrored = preferred_expansion_point(-ALL_ROUND, rate).azimuth
    assert abs(np.exp(1j * turned) - np.exp(1j * (azimuth + by * np.pi / 4))) < 1e-9
    assert abs(np.exp(1j * mirrored) - np.exp(-1j * azimuth)) < 1e-9


def test_expansion_points_in_batches_are_as_one_by_one():
    rates = np.random.default_rng(5).uniform(0.0, 100.0, (2, 3, 8))
    batch = preferred_expansion_point(ALL_ROUND, rates)
    for index in np.ndindex(2, 3):
        one = preferred_expansion_point(ALL_ROUND, rates[index])
        assert (batch.azimuth[index], batch.vector_length[index]) == pytest.approx(one, rel=1e-12)


@pytest.mark.parametrize("rate", [np.zeros(8), np.ones(8), np.array([1.0, 0, 0, 0, 1.0, 0, 0, 0])])
def test_rates_that_cancel_have_no_expansion_point(rate: np.ndarray):
    assert math.isnan(preferred_expansion_point(ALL_ROUND, rate).azimuth)


# Bad input.


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mean_rate([1.0, np.nan], 0.0, 1.0), "spike_times is nan at index 1"),
        (lambda: mean_rate([[1.0]], 0.0, 1.0), "spike_times has shape"),
        (lambda: mean_rate(["a"], 0.0, 1.0), "spike_times holds"),
        (lambda: mean_rate([1.0], 4.0, 3.0), "stop is 3 where start is 4, expected a later time"),
        (lambda: mean_rate([1.0], [0.0, 1.0], [2.0]), "stop has shape"),
        (lambda: mean_rate([1.0], 0.0, np.inf), "stop is inf"),
        (lambda: mean_rate([1.0], [], []), "start is empty"),
        (lambda: binned_rate([1.0], 0.0, 1.0, 0.0), "bin_width is 0"),
        (lambda: binned_rate([1.0], 0.0, 0.1), "bin_width is 0.25 s, expected at most the 0.1 s"),
        (lambda: background_rate([1.0], 1.5), "first_onset is 1.5 s, expected at least 2 s of recording before it"),
        (lambda: background_rate([1.0], np.nan), "first_onset is nan"),
        (lambda: tuning_curve([1.0], [0.0], [1.0], [3.0]), "a bout lasts 1 s, expected at least the window of 2 s"),
        (lambda: tuning_curve([1.0], [0.0], [3.0], [3.0, 4.0]), "condition has shape"),
        (lambda: tuning_curve([1.0], [0.0], [3.0], [np.nan]), "condition is nan"),
        (lambda: tuning_curve([1.0], 0.0, 3.0, 1.0), "start has shape"),
        (lambda: tuning_curve([1.0], [0.0], [3.0], [1.0], window=0.0), "window is 0"),
        (lambda: population_tuning([]), "curves is empty"),
        (lambda: preferred_expansion_point([0.0, 1.0], [1.0, 1.0]), "azimuth holds 2 angles, expected at least 3"),
        (lambda: preferred_expansion_point([0.0, 90.0, 180.0], [1.0] * 3), "azimuth reaches 180.* degrees"),
        (lambda: preferred_expansion_point([0.0, 1.0, 2.0], [1.0, -1.0, 1.0]), "rate reaches -1"),
        (lambda: preferred_expansion_point([0.0, 1.0, 2.0], [1.0, 1.0]), "rate has shape"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message: str):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_arguments_are_left_as_they_are():
    spikes, start = np.array([3.0, 1.0, 2.0]), np.array([0.0])
    tuning_curve(spikes, start, start + 3.0, [1.0])
    binned_rate(spikes, start, start + 3.0)
    assert spikes.tolist() == [3.0, 1.0, 2.0]
    assert start.tolist() == [0.0]
