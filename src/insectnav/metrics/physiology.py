"""Firing rates and tuning curves of recorded cells, from spike times in seconds.

What Stone et al. 2017 (doi 10.1016/j.cub.2017.08.052, Methods, Data analysis) did with responses to optic flow. Moving
bars are in `receptive_fields`, polarised light is in `polarisation_tuning`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import bearing, unit_vector
from insectnav.checks import InputError, as_numbers, check_finite, check_radians, check_range, check_shape

Reals = NDArray[np.floating[Any]]
Counts = NDArray[np.integer[Any]]

MIN_ANGLES = 3  # two angles have no spread to speak of


class BinnedRate(NamedTuple):
    """Firing rate in consecutive bins of a stimulus interval."""

    time: Reals  # (bin,) [s] centres of the bins, from the start of the interval
    rate: Reals  # (..., bin) [1/s]


class TuningCurve(NamedTuple):
    """Response of one cell to each stimulus condition; normalised values are NaN for a silent cell."""

    condition: Reals  # (condition,) ascending
    rate: Reals  # (condition,) [1/s] mean over the repeats
    normalised: Reals  # (condition,) rate over its maximum
    n_bouts: Counts  # (condition,) repeats
    background: float  # [1/s]
    normalised_background: float


class PopulationTuning(NamedTuple):
    """Mean and standard deviation (n − 1) of normalised tuning curves across cells; no SD of a single cell."""

    condition: Reals  # (condition,) ascending
    mean: Reals  # (condition,)
    sd: Reals  # (condition,)
    n_cells: Counts  # (condition,) cells tested with it
    background_mean: float
    background_sd: float


class PreferredDirection(NamedTuple):
    """Circular mean of directions weighted by rate."""

    azimuth: Reals  # (...) [rad] in [−π, π); NaN where the vectors cancel
    vector_length: Reals  # (...) 0 for equal rates all round, 1 for a response to one direction only


def sorted_spikes(spike_times: ArrayLike) -> Reals:
    """Spike times in order, (n,) [s]; refuses other shapes, NaN and infinity."""
    spikes = as_numbers("spike_times", spike_times).astype(float)
    check_shape("spike_times", spikes, ("n",))
    check_finite("spike_times", spikes)
    return np.sort(spikes)


def mean_rate(spike_times: ArrayLike, start: ArrayLike, stop: ArrayLike) -> Reals:
    """Spikes per second in each interval, (...) [1/s]; a spike at its start counts, one at its stop does not.

    Parameters
    ----------
    spike_times : (n,) array [s], in any order
    start, stop : (...) arrays [s]
        Each start before its stop.

    Raises
    ------
    InputError
        If times are not finite, or an interval is empty.
    """
    spikes = sorted_spikes(spike_times)
    begin, end = _intervals(start, stop)
    count = np.searchsorted(spikes, end) - np.searchsorted(spikes, begin)
    return (count / (end - begin))[()]


def binned_rate(spike_times: ArrayLike, start: ArrayLike, stop: ArrayLike, bin_width: float = 0.25) -> BinnedRate:
    """Firing rate in consecutive bins of one stimulus interval, or of several.

    Parameters
    ----------
    spike_times : (n,) array [s], in any order
    start, stop : (...) arrays [s]
        Each start before its stop.
    bin_width : float [s]

    Returns
    -------
    BinnedRate
        time (bin,) and rate (..., bin), with as many whole bins as the shortest interval holds; the rest is left out.

    Raises
    ------
    InputError
        If times are not finite, an interval is empty, or the shortest holds no whole bin.

    Notes
    -----
    Stone et al. 2017, Methods: bins of 0.25 s, each stimulus bout by itself. A bin includes its start, not its end.
    """
    check_range("bin_width", bin_width, np.finfo(float).tiny, np.inf, "s", "milliseconds?")
    spikes = sorted_spikes(spike_times)
    begin, end = _intervals(start, stop)
    duration = float(np.min(end - begin))
    n_bins = int(duration / bin_width * (1 + 1e-9))  # 0.3 s is to hold three bins of 0.1 s
    if n_bins < 1:
        raise InputError(f"bin_width is {bin_width:g} s, expected at most the {duration:g} s of the shortest interval")
    edges = begin[..., None] + bin_width * np.arange(n_bins + 1)
    rate = np.diff(np.searchsorted(spikes, edges), axis=-1) / bin_width
    return BinnedRate(time=bin_width * (np.arange(n_bins) + 0.5), rate=rate)


def background_rate(
    spike_times: ArrayLike, first_onset: float, duration: float = 2.0, *, recording_start: float = 0.0
) -> float:
    """Spikes per second before the first stimulus [1/s].

    Parameters
    ----------
    spike_times : (n,) array [s]
    first_onset : float [s]
        When the first stimulus came on; that of its stationary pattern, if it stood before it moved.
    duration : float [s]
    recording_start : float [s]
        When the recording began.

    Raises
    ------
    InputError
        If times are not finite, or the recording began less than the duration before the first stimulus.

    Notes
    -----
    Stone et al. 2017, Methods: 2 s before onset of the first stimulus.
    """
    check_finite("first_onset", first_onset)
    check_range("duration", duration, np.finfo(float).tiny, np.inf, "s")
    if first_onset - duration < recording_start:
        raise InputError(
            f"first_onset is {first_onset:g} s, expected at least {duration:g} s of recording before it, "
            f"which starts at {recording_start:g} s"
        )
    return float(mean_rate(spike_times, first_onset - duration, first_onset))


def tuning_curve(
    spike_times: ArrayLike,
    start: ArrayLike,
    stop: ArrayLike,
    condition: ArrayLike,
    *,
    background: float = np.nan,
    window: float = 2.0,
) -> TuningCurve:
    """Mean firing rate over the end of each stimulus bout, one value for each stimulus condition.

    Parameters
    ----------
    spike_times : (n,) array [s]
    start, stop : (bout,) arrays [s]
        When the stimulus began to move and stopped.
    condition : (bout,) array
        What was shown, as a number: velocity, spatial frequency, azimuth, ... Bouts with equal numbers are repeats.
    background : float [1/s]
        From `background_rate`, to be normalised as the curve is.
    window : float [s]
        How much of the end of each bout counts.

    Raises
    ------
    InputError
        If shapes do not agree, values are not finite, there is no bout, or one is shorter than the window.

    Notes
    -----
    Stone et al. 2017, Methods: the last 2 s of each stimulus interval, normalised to the maximal value of the curve.
    """
    begin, end = _intervals(start, stop)
    check_shape("start", begin, ("bout",))
    conditions = as_numbers("condition", condition).astype(float)
    check_shape("condition", conditions, begin.shape)
    check_finite("condition", conditions)
    check_range("window", window, np.finfo(float).tiny, np.inf, "s")
    shortest = float(np.min(end - begin))
    if shortest < window * (1 - 1e-9):
        raise InputError(f"a bout lasts {shortest:g} s, expected at least the window of {window:g} s")
    rates = mean_rate(spike_times, end - window, end)
    values, which, n_bouts = np.unique(conditions, return_inverse=True, return_counts=True)
    rate = np.bincount(which, weights=rates) / n_bouts
    scale = rate.max() or np.nan
    return TuningCurve(values, rate, rate / scale, n_bouts, float(background), float(background / scale))


def population_tuning(curves: Sequence[TuningCurve]) -> PopulationTuning:
    """Mean and standard deviation of normalised tuning curves, and of normalised background rates, across cells.

    Parameters
    ----------
    curves : sequence of TuningCurve
        One for each cell; a cell need not have been tested with every condition.

    Raises
    ------
    InputError
        If there is no curve, or a cell was silent.

    Notes
    -----
    Stone et al. 2017, Methods and Fig. 2c, f. Cells without a background rate are left out of its mean.
    """
    if not curves:
        raise InputError("curves is empty, expected a tuning curve for each cell")
    for cell, curve in enumerate(curves):
        check_finite(f"normalised rate of cell {cell}", curve.normalised)
    conditions, which = np.unique(np.concatenate([curve.condition for curve in curves]), return_inverse=True)
    normalised = np.concatenate([curve.normalised for curve in curves])
    columns = [_mean_and_sd(normalised[which == index]) for index in range(len(conditions))]
    mean, sd = np.array(columns).T
    backgrounds = np.array([curve.normalised_background for curve in curves])
    background_mean, background_sd = _mean_and_sd(backgrounds[np.isfinite(backgrounds)])
    return PopulationTuning(conditions, mean, sd, np.bincount(which), background_mean, background_sd)


def preferred_expansion_point(azimuth: ArrayLike, rate: ArrayLike) -> PreferredDirection:
    """Circular mean of the azimuths of expansion, each weighted by the firing rate that it evoked.

    Parameters
    ----------
    azimuth : (n,) array [rad] clockwise from straight ahead, n ≥ 3
    rate : (..., n) array [1/s]

    Raises
    ------
    InputError
        If shapes do not agree, there are fewer than three azimuths, or a rate is negative or not finite.

    Notes
    -----
    Stone et al. 2017, Methods: spike frequencies as a distribution of azimuths, mean of Berens 2009, doi
    10.18637/jss.v031.i10. The azimuths should be evenly spaced all round: elsewhere the mean leans to where they crowd.
    """
    angles, rates = as_numbers("azimuth", azimuth).astype(float), as_numbers("rate", rate).astype(float)
    check_shape("azimuth", angles, ("n",))
    check_finite("azimuth", angles)
    check_radians("azimuth", angles)
    if len(angles) < MIN_ANGLES:
        raise InputError(f"azimuth holds {len(angles)} angles, expected at least {MIN_ANGLES}")
    check_shape("rate", rates, (..., len(angles)))
    check_finite("rate", rates)
    check_range("rate", rates, 0.0, np.inf, "spikes per second")
    total = rates.sum(axis=-1)
    mean = rates @ unit_vector(angles) / np.where(total > 0.0, total, np.nan)[..., None]
    length = np.linalg.norm(mean, axis=-1)
    # Below rounding the direction of the sum is that of the errors.
    preferred = np.where(length > 1e-12, bearing(mean), np.nan)[()]
    return PreferredDirection(azimuth=preferred, vector_length=length)


def _intervals(start: ArrayLike, stop: ArrayLike) -> tuple[Reals, Reals]:
    """Starts and stops of one shape, checked."""
    begin, end = as_numbers("start", start).astype(float), as_numbers("stop", stop).astype(float)
    check_shape("stop", end, begin.shape)
    check_finite("start", begin)
    check_finite("stop", end)
    if not begin.size:
        raise InputError("start is empty, expected at least one interval")
    is_empty = end <= begin
    if is_empty.any():
        first = np.argmax(is_empty.ravel())
        raise InputError(
            f"stop is {end.ravel()[first]:g} where start is {begin.ravel()[first]:g}, expected a later time: "
            "a duration, or swapped?"
        )
    return begin, end


def _mean_and_sd(values: Reals) -> tuple[float, float]:
    """Mean and standard deviation (n − 1); NaN where there is none."""
    mean = float(np.mean(values)) if len(values) else np.nan
    return mean, float(np.std(values, ddof=1)) if len(values) > 1 else np.nan
