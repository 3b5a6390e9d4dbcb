"""Tuning of recorded cells to the angle of polarised light: Rayleigh test, width, shift between turns either way.

Angles of a polariser come back after half a turn (axial data); with ``axial=False`` the functions serve any stimulus
whose angle comes back after a whole one.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import wrap
from insectnav.checks import InputError, as_numbers, check_finite, check_radians, check_range, check_shape
from insectnav.metrics.physiology import MIN_ANGLES
from insectnav.metrics.stimulus_angles import MIN_SPEED, AngleHistogram, angle_histogram, period_of, spike_angles

Reals = NDArray[np.floating[Any]]


class RayleighTest(NamedTuple):
    """Rayleigh test of uniformity; all arrays (...)."""

    n: int  # angles
    vector_length: Reals  # mean resultant length, 0 to 1
    statistic: Reals  # z = n · vector_length²
    mean_angle: Reals  # [rad] in [−π/2, π/2) for axial data, else in [−π, π); meaningless for a vector_length near 0
    p_value: Reals  # of a statistic as large for uniform angles
    is_significant: NDArray[np.bool_]  # p_value below alpha


class AlignedTuning(NamedTuple):
    """Tuning curve with its minimum at 0, its peak at 1 and at angle 0."""

    angle: Reals  # (bin,) [rad]
    response: Reals  # (..., bin); NaN for a flat curve


class TurnTuning(NamedTuple):
    """Response of a cell while the stimulus turned one way."""

    spike_angle: Reals  # (n,) [rad] of the stimulus at each spike
    test: RayleighTest
    histogram: AngleHistogram
    width: float  # [rad] at half maximum of the histogram's rates; NaN for a flat one


class PolarisationTuning(NamedTuple):
    """Response of a cell to a polariser turned both ways."""

    clockwise: TurnTuning
    anticlockwise: TurnTuning
    shift: float  # [rad] between the two mean angles, positive where the cell anticipates the turn


def rayleigh_test(angles: ArrayLike, *, axial: bool = True, alpha: float = 0.05) -> RayleighTest:
    """Whether angles cluster about one axis (or, not axial, one direction), and about which.

    Parameters
    ----------
    angles : (..., n) array [rad], n ≥ 3
    axial : bool
        Whether angles half a turn apart are the same; they are doubled for the test.
    alpha : float
        Level of significance.

    Raises
    ------
    InputError
        If there are fewer than three angles, or they are not finite or not in radians, or alpha is no probability.

    Notes
    -----
    p = exp(√(1 + 4n + 4(n² − R²)) − (1 + 2n)), R = n · vector_length: Wilkie 1983, Applied Statistics 32:311; Zar,
    Biostatistical Analysis, 5th ed. 2010, Eq. 27.4, after Greenwood and Durand 1955, Annals of Mathematical Statistics
    26:233; as in the toolbox that Stone et al. 2017 used (Berens 2009, doi 10.18637/jss.v031.i10). The test takes
    spikes as independent, and the stimulus as spending equal time at all angles.
    """
    values = as_numbers("angles", angles).astype(float)
    check_shape("angles", values, (..., "n"))
    n = values.shape[-1]
    if n < MIN_ANGLES:
        raise InputError(f"angles holds {n} angles, expected at least {MIN_ANGLES}")
    check_finite("angles", values)
    check_radians("angles", values)
    check_range("alpha", alpha, 0.0, 1.0)
    fold = 2 if axial else 1
    cosine, sine = np.cos(fold * values).mean(axis=-1), np.sin(fold * values).mean(axis=-1)
    length = np.minimum(np.hypot(sine, cosine), 1.0)
    # The exponent √(a² − b²) − a with a = 1 + 2n, b = 2R, written without its cancellation.
    a, squared = 1.0 + 2.0 * n, (2.0 * n * length) ** 2
    p_value = np.exp(-squared / (np.sqrt(a**2 - squared) + a))
    mean_angle = wrap(np.arctan2(sine, cosine)) / fold
    return RayleighTest(n, length, n * length**2, mean_angle, p_value, p_value < alpha)


def aligned_tuning(rate: ArrayLike, *, axial: bool = True) -> AlignedTuning:
    """Tuning curve normalised to its peak, its minimum set to zero, shifted so that the peak is at 0.

    Parameters
    ----------
    rate : (..., bin) array
        Rates in even bins that cover one period: half a turn if axial, else a whole one.
    axial : bool

    Raises
    ------
    InputError
        If there are fewer than three bins, or a rate is not finite.

    Notes
    -----
    Stone et al. 2017, Methods and Fig. 1f. Of equal peaks the first is taken.
    """
    values = as_numbers("rate", rate).astype(float)
    check_shape("rate", values, (..., "bin"))
    n_bins = values.shape[-1]
    if n_bins < MIN_ANGLES:
        raise InputError(f"rate holds {n_bins} bins, expected at least {MIN_ANGLES}")
    check_finite("rate", values)
    low, high = values.min(axis=-1, keepdims=True), values.max(axis=-1, keepdims=True)
    centre = n_bins // 2
    source = (values.argmax(axis=-1)[..., None] + np.arange(n_bins) - centre) % n_bins
    shifted = np.take_along_axis(values, source, axis=-1)
    response = (shifted - low) / np.where(high > low, high - low, np.nan)
    return AlignedTuning(angle=(np.arange(n_bins) - centre) * period_of(axial) / n_bins, response=response)


def tuning_width(rate: ArrayLike, *, axial: bool = True) -> Reals:
    """Width of a tuning curve halfway between its minimum and its peak, (...) [rad]; NaN for a flat curve.

    Parameters
    ----------
    rate : (..., bin) array
        Rates in even bins that cover one period: half a turn if axial, else a whole one.
    axial : bool

    Raises
    ------
    InputError
        If there are fewer than three bins, or a rate is not finite.

    Notes
    -----
    Stone et al. 2017, Methods and Fig. 1f. Linear between bins, from the peak to the first crossing on either side:
    noise on the flanks makes a curve narrower.
    """
    response = aligned_tuning(rate, axial=axial).response
    n_bins = response.shape[-1]
    onwards = np.roll(response, -(n_bins // 2), axis=-1)
    onwards = np.concatenate([onwards, onwards[..., :1]], axis=-1)  # once round, from peak to peak
    return (_half_crossing(onwards) + _half_crossing(onwards[..., ::-1])) * (period_of(axial) / n_bins)


def preference_shift(clockwise: ArrayLike, anticlockwise: ArrayLike, *, axial: bool = True) -> Reals:
    """Preferred angle in anticlockwise minus that in clockwise turns, (...) [rad], positive where the cell anticipates.

    Parameters
    ----------
    clockwise, anticlockwise : (...) arrays [rad]
        Preferred angles while the stimulus turned that way.
    axial : bool
        Whether to wrap the difference to [−π/2, π/2) rather than to [−π, π).

    Raises
    ------
    InputError
        If angles are not finite or not in radians.

    Notes
    -----
    Stone et al. 2017, Fig. 1h. A cell that fires before the stimulus comes to its true preference fires at a smaller
    angle while angles grow, at a larger one while they shrink. A response that lags by τ at the speed ω gives −2ωτ.
    """
    for name, angles in (("clockwise", clockwise), ("anticlockwise", anticlockwise)):
        check_finite(name, angles)
        check_radians(name, angles)
    fold = 2 if axial else 1
    return wrap(fold * np.subtract(anticlockwise, clockwise, dtype=float)) / fold


def polarisation_tuning(
    spike_times: ArrayLike,
    time: ArrayLike,
    angle: ArrayLike,
    *,
    axial: bool = True,
    alpha: float = 0.05,
    bin_width_deg: float = 10.0,
    min_speed: float = MIN_SPEED,
    max_bias: float = 0.25,
) -> PolarisationTuning:
    """Spike angles, Rayleigh test, histogram and tuning width for turns either way, and the shift between them.

    Parameters
    ----------
    spike_times, time, angle, axial, bin_width_deg, min_speed
        As of `angle_histogram`.
    alpha : float
        Level of significance.
    max_bias : float
        How much uneven turns may add to the Rayleigh statistic of an untuned cell, which is 1 on average: number of
        spikes times squared length of the mean vector of the time spent at each angle, 0 after whole turns at constant
        speed. A bias of 0.25 finds tuning in 9 of 100 untuned cells rather than in 5, one of 3 in 58.

    Raises
    ------
    InputError
        As `angle_histogram` and `rayleigh_test`, and if turns one way leave out angles or are uneven.

    Notes
    -----
    Stone et al. 2017, Methods and Fig. 1e–h: turns either way apart, Rayleigh test for axial data.
    """
    found = spike_angles(spike_times, time, angle, axial=axial, min_speed=min_speed)
    histograms = angle_histogram(
        spike_times, time, angle, axial=axial, bin_width_deg=bin_width_deg, min_speed=min_speed
    )
    turns = {}
    for name, angles, histogram in zip(found._fields, found, histograms, strict=True):
        if len(angles) < MIN_ANGLES:
            raise InputError(
                f"{len(angles)} spikes fell in {name} turns, expected at least {MIN_ANGLES}: milliseconds?"
            )
        _check_even(histogram, name, axial, max_bias)
        test = rayleigh_test(angles, axial=axial, alpha=alpha)
        turns[name] = TurnTuning(angles, test, histogram, float(tuning_width(histogram.rate, axial=axial)))
    shift = preference_shift(*(turn.test.mean_angle for turn in turns.values()), axial=axial)
    return PolarisationTuning(**turns, shift=float(shift))


def _half_crossing(onwards: Reals) -> Reals:
    """Bins from a peak at the start of the last axis to where the response first falls to one half; NaN if never."""
    step = np.argmax(onwards <= 0.5, axis=-1)[..., None]
    after = np.take_along_axis(onwards, step, axis=-1)
    before = np.take_along_axis(onwards, np.maximum(step - 1, 0), axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return (step - (0.5 - after) / (before - after))[..., 0]


def _check_even(histogram: AngleHistogram, name: str, axial: bool, max_bias: float) -> None:
    """Refuse turns that spent so uneven a time at the angles that the Rayleigh test mistakes it for tuning."""
    time = histogram.time_spent
    if not time.all():
        missing = np.rad2deg(histogram.angle[np.argmin(time)])
        raise InputError(f"{name} turns leave out angles about {missing:.4g}°, expected at least one whole turn")
    unevenness = abs(np.exp((2j if axial else 1j) * histogram.angle) @ time) / time.sum()
    bias = histogram.n_spikes.sum() * unevenness**2
    if bias > max_bias:
        raise InputError(
            f"{name} turns spend uneven time at the angles, which adds {bias:.2g} to the Rayleigh statistic, expected "
            f"at most {max_bias:g}: turns cut short, or not at constant speed?"
        )
