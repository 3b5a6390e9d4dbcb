"""The Rayleigh test against outside implementations and its exact distribution; widths and shifts in closed form."""

import math

import numpy as np
import pytest
from astropy.stats import circmean as astropy_circmean
from astropy.stats import rayleightest as astropy_rayleightest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, special
from scipy.stats import binom, circmean, ncx2

from insectnav.angles import wrap
from insectnav.checks import InputError
from insectnav.metrics.polarisation_tuning import (
    aligned_tuning,
    polarisation_tuning,
    preference_shift,
    rayleigh_test,
    tuning_width,
)
from spike_trains import poisson, regular

OMEGA = math.radians(60.0)  # [rad/s]
TIME = np.linspace(0.0, 120.0, 12_001)  # ten turns clockwise, then ten back
ANGLE = wrap(OMEGA * np.where(TIME < 60.0, TIME, 120.0 - TIME))
seeds = st.integers(0, 2**32 - 1)


def far(first: np.ndarray, second: np.ndarray, period: float = np.pi) -> float:
    """Largest distance between angles on a circle of that period."""
    turn = 2 * np.pi / period
    return float(np.abs(wrap(turn * np.subtract(first, second)) / turn).max())


def exact_p(n: int, resultant: float) -> float:
    """P(R > r) of n uniform angles, 1 − r ∫ J1(rt) J0(t)ⁿ dt: Kluyver 1905; Mardia and Jupp 2000, Eq. 4.4.2."""
    integral, _ = integrate.quad(lambda t: special.j1(resultant * t) * special.j0(t) ** n, 0.0, 300.0, limit=3000)
    return 1.0 - resultant * integral


def angles_with_resultant(n: int, resultant: float) -> np.ndarray:
    """Pairs on either side of 0, n even, whose vectors add up to that length."""
    half = math.acos(resultant / n)
    return np.tile([half, -half], n // 2)


def raised_cosine(angle: np.ndarray, preferred: float = 0.0) -> np.ndarray:
    return 10.0 + 30.0 * (1.0 + np.cos(2 * (angle - preferred)))


# Rayleigh test.


def test_published_example():
    # The example of circ_rayleigh in the manual of Pingouin (Vallat 2018, doi 10.21105/joss.01026).
    test = rayleigh_test([0.785, 1.570, 3.141, 0.839, 5.934], axial=False)
    assert test.statistic == pytest.approx(1.236, abs=5e-4)
    assert test.p_value == pytest.approx(0.304844, abs=5e-7)


@pytest.mark.parametrize(("n", "tolerance"), [(6, 0.005), (10, 0.0005), (20, 0.00025), (50, 0.00005)])
@pytest.mark.parametrize("statistic", [0.3, 1.0, 2.0, 3.0, 4.5])
def test_p_is_exact_to_two_decimals_from_5_and_to_three_from_10(n: int, tolerance: float, statistic: float):
    # The accuracy is Zar's claim (Biostatistical Analysis, Eq. 27.4), the exact value Kluyver's.
    resultant = math.sqrt(statistic * n)
    test = rayleigh_test(angles_with_resultant(n, resultant), axial=False)
    assert test.statistic == pytest.approx(statistic)
    assert test.p_value == pytest.approx(exact_p(n, resultant), abs=tolerance)


@given(seeds, st.integers(10, 300), st.floats(0.0, 0.5))
def test_rayleigh_test_agrees_with_astropy(seed: int, n: int, clustering: float):
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-np.pi, np.pi, n) * (1.0 - clustering)
    test = rayleigh_test(angles, axial=False)
    # Astropy sums a series; from 50 angles on it drops the term of e^−z (2z − z²) / 4n, at most 0.12 / n.
    assert test.p_value == pytest.approx(astropy_rayleightest(angles), abs=1e-3 if n < 50 else 0.15 / n)
    assert far(test.mean_angle, astropy_circmean(angles), 2 * np.pi) * test.vector_length < 1e-9
    assert far(test.mean_angle, circmean(angles), 2 * np.pi) * test.vector_length < 1e-9
    assert test.is_significant == (test.p_value < 0.05)


@given(seeds, st.integers(3, 100))
def test_axial_test_is_that_of_doubled_angles(seed: int, n: int):
    angles = np.random.default_rng(seed).uniform(-np.pi, np.pi, n)
    axial, doubled = rayleigh_test(angles), rayleigh_test(wrap(2 * angles), axial=False)
    assert axial.p_value == pytest.approx(doubled.p_value)
    assert far(axial.mean_angle, doubled.mean_angle / 2) * axial.vector_length < 1e-9
    assert far(axial.mean_angle, circmean(angles, high=np.pi)) * axial.vector_length < 1e-9
    assert -np.pi / 2 <= axial.mean_angle < np.pi / 2


@given(seeds, st.floats(-3.0, 3.0))
def test_mean_axis_turns_and_mirrors_with_the_angles(seed: int, by: float):
    rng = np.random.default_rng(seed)
    angles = rng.vonmises(0.0, 1.0, 40) / 2
    test = rayleigh_test(angles)
    half_turns = np.pi * rng.integers(-1, 2, 40)
    turned, mirrored = rayleigh_test(wrap(angles + by + half_turns)), rayleigh_test(-angles)
    assert far(turned.mean_angle, test.mean_angle + by) * test.vector_length < 1e-9
    assert far(mirrored.mean_angle, -test.mean_angle) * test.vector_length < 1e-9
    assert turned.p_value == pytest.approx(test.p_value)


@pytest.mark.parametrize("n", [5, 12, 60, 300])
@pytest.mark.parametrize("axial", [True, False])
def test_uniform_angles_are_called_tuned_as_often_as_alpha_says(n: int, axial: bool):
    n_samples = 4000
    angles = np.random.default_rng(11 + n).uniform(-np.pi, np.pi, (n_samples, n))
    n_tuned = int(rayleigh_test(angles, axial=axial).is_significant.sum())
    low, high = binom.interval(1 - 1e-6, n_samples, 0.05)
    assert low <= n_tuned <= high


@pytest.mark.parametrize(("bias", "share"), [(0.25, 0.09), (3.0, 0.58)])
def test_uneven_turns_find_tuning_as_often_as_the_docstring_says(bias: float, share: float):
    n, n_samples = 1000, 4000
    length = math.sqrt(bias / n)  # of the density 1 + 2 length · cos 2θ, about: angles of a slightly uneven turn
    even = np.random.default_rng(13).uniform(-np.pi / 2, np.pi / 2, (n_samples, n))
    n_tuned = int(rayleigh_test(even - length * np.sin(2 * even)).is_significant.sum())
    expected = ncx2.sf(-2 * math.log(0.05), 2, 2 * bias)  # twice the statistic is chi-squared
    assert expected == pytest.approx(share, abs=0.005)
    low, high = binom.interval(1 - 1e-6, n_samples, expected)
    assert low <= n_tuned <= high


def test_tests_in_batches_are_as_one_by_one():
    angles = np.random.default_rng(6).vonmises(1.0, 0.5, (2, 3, 30))
    batch = rayleigh_test(angles)
    for index in np.ndindex(2, 3):
        one = rayleigh_test(angles[index])
        assert one.n == batch.n == 30
        for name in ("vector_length", "statistic", "mean_angle", "p_value", "is_significant"):
            assert getattr(batch, name)[index] == pytest.approx(getattr(one, name), rel=1e-12)


def test_certain_tuning_of_very_many_spikes():
    test = rayleigh_test(np.zeros(1_000_000))
    assert (test.vector_length, test.statistic, test.mean_angle, test.p_value) == (1.0, 1e6, 0.0, 0.0)


# Width.


@pytest.mark.parametrize("axial", [True, False])
@pytest.mark.parametrize("n_bins", [12, 36, 360])
def test_raised_cosine_is_half_its_period_wide(n_bins: int, axial: bool):
    rate = 7.0 + 20.0 * np.cos(2 * np.pi * np.arange(n_bins) / n_bins + 2 * np.pi / 3)
    assert tuning_width(rate, axial=axial) == pytest.approx(np.pi / 2 if axial else np.pi, rel=1e-9)


@pytest.mark.parametrize("kappa", [0.5, 1.0, 3.0, 8.0])
def test_width_of_a_von_mises_curve(kappa: float):
    angle = 2 * np.pi * np.arange(3600) / 3600
    # Halfway from e^−κ to e^κ is cosh κ, which e^(κ cos φ) reaches where cos φ = ln(cosh κ) / κ.
    expected = 2 * math.acos(math.log(math.cosh(kappa)) / kappa)
    assert tuning_width(np.exp(kappa * np.cos(angle - 1.0)), axial=False) == pytest.approx(expected, abs=1e-4)
    assert tuning_width(np.exp(kappa * np.cos(angle - 1.0))) == pytest.approx(expected / 2, abs=1e-4)


@given(st.integers(2, 8), st.integers(2, 8), st.integers(0, 17), st.floats(0.1, 100.0), st.floats(0.0, 100.0))
def test_width_of_a_triangle_is_exact(rise: int, fall: int, peak: int, scale: float, offset: float):
    place = np.arange(18)
    triangle = np.maximum(np.where(place < 9, 1 - place / fall, 1 - (18 - place) / rise), 0.0)
    rate = offset + scale * np.roll(triangle, peak)
    assert math.degrees(tuning_width(rate)) == pytest.approx(10.0 * (rise + fall) / 2, rel=1e-6)


def test_second_hump_does_not_count():
    rate = np.zeros(18)
    rate[[3, 4, 5, 11, 12]] = 4.0, 8.0, 4.0, 7.0, 7.0
    assert math.degrees(tuning_width(rate)) == pytest.approx(20.0)


def test_widths_in_batches_are_as_one_by_one():
    rates = np.random.default_rng(7).uniform(0.0, 50.0, (2, 3, 18))
    for index in np.ndindex(2, 3):
        assert tuning_width(rates)[index] == tuning_width(rates[index])


@given(seeds, st.integers(3, 40))
def test_aligned_curve_has_its_peak_at_0(seed: int, n_bins: int):
    rate = np.random.default_rng(seed).uniform(0.0, 50.0, n_bins)
    angle, response = aligned_tuning(rate)
    assert angle[np.argmax(response)] == 0.0
    assert (response.min(), response.max()) == (0.0, 1.0)
    np.testing.assert_allclose(np.diff(angle), np.pi / n_bins)
    np.testing.assert_allclose(np.sort(response), np.sort((rate - rate.min()) / np.ptp(rate)), atol=1e-12)
    after = (rate[(np.argmax(rate) + 1) % n_bins] - rate.min()) / np.ptp(rate)
    assert response[(np.argmax(response) + 1) % n_bins] == pytest.approx(after)


def test_flat_curve_has_no_width():
    assert math.isnan(tuning_width(np.full(18, 4.0)))
    widths = tuning_width([[1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 0.0, 0.0]])
    np.testing.assert_allclose(widths, [math.nan, np.pi / 4])


# Shift.


@pytest.mark.parametrize(
    ("clockwise_deg", "anticlockwise_deg", "shift_deg", "axial"),
    [(10, 63, 53, True), (63, 10, -53, True), (80, -80, 20, True), (-170, 170, -20, False), (0, 120, 120, False)],
)
def test_shift_by_hand(clockwise_deg: float, anticlockwise_deg: float, shift_deg: float, axial: bool):
    shift = preference_shift(math.radians(clockwise_deg), math.radians(anticlockwise_deg), axial=axial)
    assert math.degrees(shift) == pytest.approx(shift_deg)


@pytest.mark.parametrize("latency", [-0.2, 0.0, 0.1, 0.35])
def test_latency_shifts_the_preferred_axes_apart(latency: float):
    # Spikes when the polariser was at 30°, 40° and 50° so many seconds before, each half turn but the first and last.
    at = np.deg2rad([30.0, 40.0, 50.0])
    passes = (at + np.pi * np.arange(1, 19)[:, None]).ravel() / OMEGA
    spikes = np.concatenate([passes, 120.0 - passes]) + latency
    tuning = polarisation_tuning(spikes, TIME, ANGLE)
    assert tuning.shift == pytest.approx(-2 * OMEGA * latency, abs=1e-9)
    assert far(tuning.clockwise.test.mean_angle, math.radians(40.0) + OMEGA * latency) < 1e-9
    assert far(tuning.anticlockwise.test.mean_angle, math.radians(40.0) - OMEGA * latency) < 1e-9


# All together.


def tuned_spikes(preferred: tuple[float, float], seed: int) -> np.ndarray:
    """Poisson spikes with a raised cosine about one axis in clockwise, another in anticlockwise turns."""

    def rate(time: np.ndarray) -> np.ndarray:
        angle = OMEGA * np.where(time < 60.0, time, 120.0 - time)
        return raised_cosine(angle, np.where(time < 60.0, *preferred))

    return poisson(rate, 70.0, 120.0, seed)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("preferred_deg", [(20.0, 73.0), (-85.0, -32.0), (70.0, -57.0)])
def test_preferred_axes_and_shift_of_poisson_spikes_are_recovered(seed: int, preferred_deg: tuple[float, float]):
    tuning = polarisation_tuning(tuned_spikes(tuple(np.deg2rad(preferred_deg)), seed), TIME, ANGLE)
    errors = []
    for turn, expected in zip(tuning[:2], preferred_deg, strict=True):
        n = turn.test.n
        # 40 + 30 cos: mean vector 30/80. The mean of n doubled angles errs by 1 / √(2n) across it, halved for the axis.
        errors.append(0.5 / math.sqrt(2 * n) / (30.0 / 80.0))
        assert turn.test.is_significant
        assert far(turn.test.mean_angle, math.radians(expected)) < 4.5 * errors[-1]
        assert abs(turn.test.vector_length - 30.0 / 80.0) < 4.5 / math.sqrt(2 * n)
        assert abs(n - 60.0 * 40.0) < 4.5 * math.sqrt(60.0 * 40.0)
        assert turn.histogram.n_spikes.sum() == n == len(turn.spike_angle)
        assert turn.width == tuning_width(turn.histogram.rate)
    assert far(tuning.shift, math.radians(53.0)) < 4.5 * math.hypot(*errors)


def test_stimulus_in_the_mirror_changes_the_ways_and_keeps_the_shift():
    spikes = tuned_spikes((0.4, 1.3), seed=5)
    tuning, mirrored = polarisation_tuning(spikes, TIME, ANGLE), polarisation_tuning(spikes, TIME, wrap(-ANGLE))
    assert mirrored.shift == pytest.approx(tuning.shift)
    assert far(mirrored.clockwise.test.mean_angle, -tuning.anticlockwise.test.mean_angle) < 1e-9


def test_cell_that_fires_evenly_is_not_tuned():
    tuning = polarisation_tuning(regular(37.3, 0.0, 120.0), TIME, ANGLE)
    for turn in tuning[:2]:
        assert not turn.test.is_significant
        np.testing.assert_allclose(turn.histogram.rate, 37.3, rtol=0.1)


def test_stimulus_of_a_whole_turn():
    shift = math.radians(120.0)
    passes = (np.array([0.9, 1.0, 1.1]) + 2 * np.pi * np.arange(1, 9)[:, None]).ravel() / OMEGA
    tuning = polarisation_tuning(np.concatenate([passes, 120.0 - passes - shift / OMEGA]), TIME, ANGLE, axial=False)
    assert tuning.shift == pytest.approx(shift)
    assert tuning.clockwise.histogram.angle.size == 36


# Bad input.

QUARTER = TIME[:150]  # 90° clockwise


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: rayleigh_test([0.0, 1.0]), "angles holds 2 angles, expected at least 3"),
        (lambda: rayleigh_test([0.0, 1.0, np.nan]), "angles is nan"),
        (lambda: rayleigh_test([0.0, 90.0, 180.0]), "angles reaches 180.*degrees"),
        (lambda: rayleigh_test(1.0), "angles has shape"),
        (lambda: rayleigh_test([0.0, 1.0, 2.0], alpha=5.0), "alpha is 5"),
        (lambda: tuning_width([1.0, 2.0]), "rate holds 2 bins, expected at least 3"),
        (lambda: tuning_width([1.0, np.nan, 2.0]), "rate is nan"),
        (lambda: preference_shift(53.0, 0.0), "clockwise is 53.*degrees"),
        (lambda: preference_shift(0.0, np.nan), "anticlockwise is nan"),
        (lambda: polarisation_tuning([1.0, 2.0], TIME, ANGLE), "2 spikes fell in clockwise turns, expected at least 3"),
        (lambda: polarisation_tuning(1e3 * regular(9.0, 1.0, 99.0), TIME, ANGLE), "0 spikes fell .*milliseconds"),
        (lambda: polarisation_tuning(regular(9.0, 0.0, 60.0), TIME, ANGLE), "0 spikes fell in anticlockwise turns"),
        (
            lambda: polarisation_tuning(regular(9.0, 0.0, 1.5), QUARTER, ANGLE[:150]),
            "clockwise turns leave out angles about -?[0-9.]+°, expected at least one whole turn",
        ),
        (  # half a turn and 83.4°: the doubled vectors of the rest add up to sin 83.4° in 4.6 rad; 40 spikes
            lambda: polarisation_tuning(regular(9.0, 0.0, 8.0), TIME[:440], ANGLE[:440], max_bias=1.8),
            "clockwise turns spend uneven time at the angles, which adds 1.9 to the Rayleigh statistic, .* most 1.8",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_refused_in_one_sentence(call, message: str):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
