"""Angle of a turning stimulus at each spike of a recorded cell, and firing rate against that angle.

Angles are in radians; clockwise is where the recorded angle grows. Those of a polariser come back after half a turn
(axial data), those of other stimuli after a whole one.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import FULL_TURN, wrap
from insectnav.checks import InputError, as_numbers, check_finite, check_radians, check_range, check_shape
from insectnav.metrics.physiology import Counts, sorted_spikes

Reals = NDArray[np.floating[Any]]

MIN_SPEED = float(np.deg2rad(10.0))  # [rad/s] a third of the slower speed of Stone et al. 2017

_MAX_STEP = np.pi / 4  # [rad] between samples: a jump of over 90° would be taken for one the other way
_SPEED_WINDOW = 0.1  # [s] longer than the jitter of a recorded angle, shorter than a turn


class SpikeAngles(NamedTuple):
    """Angle of the stimulus at each spike, (n,) [rad], in order of time."""

    clockwise: Reals
    anticlockwise: Reals


class AngleHistogram(NamedTuple):
    """Firing rate against the angle of the stimulus."""

    angle: Reals  # (bin,) [rad] centres, ascending through one period about 0
    n_spikes: Counts  # (bin,)
    time_spent: Reals  # (bin,) [s] that the stimulus was in the bin
    rate: Reals  # (bin,) [1/s]; NaN where no time was spent


class AngleHistograms(NamedTuple):
    """Histogram for each way in which the stimulus turned."""

    clockwise: AngleHistogram
    anticlockwise: AngleHistogram


class _Path(NamedTuple):
    """Recorded angle of the stimulus, without jumps."""

    time: Reals  # (sample,) [s]
    angle: Reals  # (sample,) [rad]
    direction: NDArray[np.floating[Any]]  # (sample − 1,) 1 clockwise, −1 anticlockwise, 0 at rest


def spike_angles(
    spike_times: ArrayLike, time: ArrayLike, angle: ArrayLike, *, axial: bool = True, min_speed: float = MIN_SPEED
) -> SpikeAngles:
    """Angle of the stimulus at each spike, clockwise and anticlockwise turns apart.

    Parameters
    ----------
    spike_times : (n,) array [s]
        Spikes outside the recorded time, and those while the stimulus was at rest, are left out.
    time : (sample,) array [s], ascending
    angle : (sample,) array [rad], wrapped
        Recorded stimulus, sampled at least every 45°; linear in between.
    axial : bool
        Whether to give angles in [−π/2, π/2) rather than in [−π, π).
    min_speed : float [rad/s]
        Slower than this, as a mean over 0.1 s, the stimulus counts as at rest.

    Raises
    ------
    InputError
        If shapes do not agree, values are not finite, times do not ascend, or the angle jumps by more than 45°.

    Notes
    -----
    Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052; there the polariser turned at 30 or 60°/s.
    """
    path = _path(time, angle, min_speed)
    spikes = sorted_spikes(spike_times)
    return SpikeAngles(_angles_at(spikes, path, 1, axial), _angles_at(spikes, path, -1, axial))


def angle_histogram(
    spike_times: ArrayLike,
    time: ArrayLike,
    angle: ArrayLike,
    *,
    axial: bool = True,
    bin_width_deg: float = 10.0,
    min_speed: float = MIN_SPEED,
) -> AngleHistograms:
    """Firing rate against the angle of the stimulus, clockwise and anticlockwise turns apart.

    Parameters
    ----------
    spike_times, time, angle, min_speed
        As of `spike_angles`.
    axial : bool
        Whether to fold the angles into half a turn, [−π/2, π/2), rather than a whole one.
    bin_width_deg : float [°]
        A whole part of the period.

    Raises
    ------
    InputError
        As `spike_angles`, and if bins of this width do not divide the period.

    Notes
    -----
    Stone et al. 2017, Methods: bins of 10°, spike counts divided by the time spent in the bin.
    """
    path = _path(time, angle, min_speed)
    spikes = sorted_spikes(spike_times)
    n_bins = _n_bins(bin_width_deg, axial)
    ways = (_histogram(_angles_at(spikes, path, way, axial), path, way, axial, n_bins) for way in (1, -1))
    return AngleHistograms(*ways)


def period_of(axial: bool) -> float:
    """Turn after which a stimulus is the same again [rad]: half of one for axial data."""
    return FULL_TURN / 2 if axial else FULL_TURN


def _path(time: ArrayLike, angle: ArrayLike, min_speed: float) -> _Path:
    """Recorded stimulus, checked, its jumps from end to end of the circle taken out."""
    times, angles = as_numbers("time", time).astype(float), as_numbers("angle", angle).astype(float)
    check_shape("time", times, ("sample",))
    check_shape("angle", angles, times.shape)
    if len(times) < 2:
        raise InputError(f"time holds {len(times)} samples, expected at least 2")
    check_finite("time", times)
    check_finite("angle", angles)
    check_radians("angle", angles)
    check_range("min_speed", min_speed, 0.0, np.inf, "rad/s")
    if (np.diff(times) <= 0.0).any():
        raise InputError("time does not ascend, expected samples in order of time")
    running = np.unwrap(angles, period=FULL_TURN / 2)  # serves angles wrapped after half a turn and after a whole one
    jump = float(np.abs(np.diff(running)).max())
    if jump > _MAX_STEP:
        raise InputError(
            f"angle jumps by {np.rad2deg(jump):.3g}° between two samples, expected at most "
            f"{np.rad2deg(_MAX_STEP):.3g}°: sampled too seldom, or a glitch where it is wrapped?"
        )
    return _Path(times, running, _direction(times, running, min_speed))


def _direction(time: Reals, angle: Reals, min_speed: float) -> Reals:
    """Which way the stimulus turns between neighbouring samples, from its mean speed over a short window."""
    middle = (time[:-1] + time[1:]) / 2
    half = np.maximum(_SPEED_WINDOW, np.diff(time)) / 2
    before, after = np.maximum(middle - half, time[0]), np.minimum(middle + half, time[-1])
    speed = (np.interp(after, time, angle) - np.interp(before, time, angle)) / (after - before)
    return np.where(np.abs(speed) > min_speed, np.sign(speed), 0.0)


def _angles_at(spikes: Reals, path: _Path, way: int, axial: bool) -> Reals:
    """Angle at each of the spikes that fell while the stimulus turned that way."""
    inside = spikes[(spikes >= path.time[0]) & (spikes < path.time[-1])]
    segment = np.searchsorted(path.time, inside, side="right") - 1
    running = np.interp(inside[path.direction[segment] == way], path.time, path.angle)
    fold = 2 if axial else 1
    return wrap(fold * running) / fold


def _n_bins(bin_width_deg: float, axial: bool) -> int:
    """Bins in one period; refuses a width that does not divide it."""
    period_deg = np.rad2deg(period_of(axial))
    check_range("bin_width_deg", bin_width_deg, 1e-3, period_deg / 3, "degrees", "radians?")
    n_bins = round(period_deg / bin_width_deg)
    if abs(n_bins * bin_width_deg - period_deg) > 1e-6 * period_deg:
        raise InputError(f"bin_width_deg is {bin_width_deg:g}, expected a whole part of {period_deg:g}")
    return n_bins


def _histogram(angles: Reals, path: _Path, way: int, axial: bool, n_bins: int) -> AngleHistogram:
    """Spikes and time spent in each bin during turns that way."""
    period = period_of(axial)
    width = period / n_bins
    bins = np.floor((angles + period / 2) / width).astype(np.intp) % n_bins
    n_spikes = np.bincount(bins, minlength=n_bins)
    time_spent = _time_spent(path, way, period, n_bins)
    rate = np.divide(n_spikes, time_spent, out=np.full(n_bins, np.nan), where=time_spent > 0.0)
    return AngleHistogram(width * (np.arange(n_bins) + 0.5) - period / 2, n_spikes, time_spent, rate)


def _time_spent(path: _Path, way: int, period: float, n_bins: int) -> Reals:
    """Time in each bin during turns that way, exact for an angle that is linear between samples."""
    turning = path.direction == way
    duration = np.diff(path.time)[turning]
    begin, end = path.angle[:-1][turning] + period / 2, path.angle[1:][turning] + period / 2
    low, span = np.minimum(begin, end), np.abs(end - begin)
    still = span < 1e-9  # samples at rest within a turn, as of a coarsely digitised angle
    width = period / n_bins
    in_bin = np.floor(low[still] / width).astype(np.intp) % n_bins
    time_spent: Reals = np.bincount(in_bin, weights=duration[still], minlength=n_bins).astype(float)
    low, span, duration = low[~still], span[~still], duration[~still]
    for index in range(n_bins):
        passed = _way_within(low + span, index * width, width, period) - _way_within(low, index * width, width, period)
        time_spent[index] += np.sum(duration * passed / span)
    return time_spent


def _way_within(angle: Reals, start: float, width: float, period: float) -> Reals:
    """How much of the way from 0 to an angle lies in the bin, counted once each period."""
    periods, rest = np.divmod(angle, period)
    return periods * width + np.clip(rest - start, 0.0, width)
