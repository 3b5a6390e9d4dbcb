"""The bootstrap against what it tends to: closed forms of the error of a mean and of a median."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.special import i0, i1

from insectnav.angles import circular_mean, circular_std
from insectnav.metrics.statistics import N_RESAMPLES, bootstrap_error

RISK_SD = 4.5  # standard errors; 1 in 150 000 by chance
samples = st.lists(st.integers(-1000, 1000), min_size=2, max_size=30)


def relative_error_of_an_sd(kurtosis: float) -> float:
    """Of the SD of N_RESAMPLES numbers with that kurtosis, 3 for the normal distribution."""
    return math.sqrt((kurtosis - 1.0) / N_RESAMPLES) / 2.0


@pytest.mark.parametrize("n", [2, 10, 1000])
def test_error_of_a_mean(n: int):
    """A resample of n is n independent draws from the sample: the SD of their mean is σ / √n, σ with divisor n."""
    values = np.random.default_rng(n).exponential(size=n)
    kurtosis = 3.0 + (np.mean((values - values.mean()) ** 4) / values.var() ** 2 - 3.0) / n
    bound = RISK_SD * relative_error_of_an_sd(kurtosis)
    assert bootstrap_error(values, np.mean) == pytest.approx(values.std() / math.sqrt(n), rel=bound)


@pytest.mark.parametrize("n", [5, 21, 301])
def test_error_of_a_median(n: int):
    """Efron 1979, sec. 3: the median of a resample of odd size is at most x(k) if at least half of the draws are."""
    values = np.sort(np.random.default_rng(n).lognormal(size=n))
    up_to = stats.binom.sf(n // 2, n, np.arange(1, n + 1) / n)
    chance = np.diff(up_to, prepend=0.0)
    mean = np.sum(chance * values)
    variance = np.sum(chance * (values - mean) ** 2)
    kurtosis = np.sum(chance * (values - mean) ** 4) / variance**2
    bound = RISK_SD * relative_error_of_an_sd(kurtosis)
    assert bound < 0.5
    assert bootstrap_error(values, np.median) == pytest.approx(math.sqrt(variance), rel=bound)


def test_error_covers_the_truth_as_often_as_it_should():
    """Of a circular SD, whose error has no simple form: 300 samples of known SD, within two errors in about 95 %."""
    n_samples, concentration = 300, 4.0
    truth = math.sqrt(-2.0 * math.log(i1(concentration) / i0(concentration)))  # of a von Mises distribution
    rng, within = np.random.default_rng(8), 0
    for _ in range(n_samples):
        angles = rng.vonmises(0.0, concentration, 200)
        within += abs(circular_std(angles) - truth) < 2.0 * bootstrap_error(angles, circular_std)
    assert within >= stats.binom.ppf(1e-4, n_samples, 0.93)  # a sample of 200 is a little biased
    assert within < n_samples


def test_error_of_a_circular_mean_of_small_angles_is_that_of_their_mean():
    angles = 1e-3 * np.random.default_rng(0).normal(size=50)
    circular, linear = bootstrap_error(angles, circular_mean), bootstrap_error(angles, np.mean)
    assert circular == pytest.approx(linear, rel=1e-4)


@given(samples)
def test_same_data_have_the_same_error(values: list[int]):
    assert bootstrap_error(values, np.mean) == bootstrap_error(values, np.mean)


@given(samples, st.integers(-1000, 1000))
def test_error_grows_with_the_scale_and_not_with_the_place(values: list[int], shift: int):
    error = bootstrap_error(values, np.median)
    assert bootstrap_error(np.array(values) + shift, np.median) == pytest.approx(error, abs=1e-9)
    assert bootstrap_error(-4.0 * np.array(values), np.median) == pytest.approx(4.0 * error, abs=1e-9)


@pytest.mark.parametrize("hole", [math.nan, math.inf, -math.inf])
def test_holes_are_left_out(hole: float):
    assert bootstrap_error([hole, 1.0, 2.0, hole, 4.0], np.mean) == bootstrap_error([1.0, 2.0, 4.0], np.mean)


@pytest.mark.parametrize("values", [[], [1.0], [math.nan, 3.0], [math.inf, math.nan]])
def test_fewer_than_two_have_no_error(values: list[float]):
    assert math.isnan(bootstrap_error(values, np.mean))


def test_equal_values_are_certain():
    assert bootstrap_error([2.5, 2.5, 2.5], np.median) == 0.0
