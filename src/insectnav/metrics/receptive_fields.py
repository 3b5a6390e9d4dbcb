"""Receptive fields of recorded cells: responses to a narrow bar that goes round the animal."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import FULL_TURN, wrap
from insectnav.checks import InputError, as_numbers, check_choice, check_finite, check_radians, check_shape
from insectnav.metrics.physiology import MIN_ANGLES, sorted_spikes

Reals = NDArray[np.floating[Any]]

NEIGHBOURS = ("running", "blocks")
_N_FRAMES = 3  # averaged first
_N_BINS = 3  # width of the low-pass filter


class ReceptiveField(NamedTuple):
    """Response to the bar at each azimuth; rates are NaN where no pass went that way, normalised ones if none fired."""

    azimuth: Reals  # (bin,) [rad] clockwise from straight ahead, ascending in [−π, π)
    rate: Reals  # (bin,) [1/s] mean over the passes, smoothed
    normalised: Reals  # (bin,) rate over its peak
    n_passes: int


class ReceptiveFields(NamedTuple):
    """Receptive field for each direction in which the bar moved."""

    clockwise: ReceptiveField
    anticlockwise: ReceptiveField


def receptive_fields(
    spike_times: ArrayLike, frame_edges: ArrayLike, azimuth: ArrayLike, *, neighbours: str = "running"
) -> ReceptiveFields:
    """Normalised firing rate against the azimuth of a bar, clockwise and anticlockwise passes apart.

    Parameters
    ----------
    spike_times : (n,) array [s]
    frame_edges : (pass, position + 1) array [s]
        When each frame of a rotation of the bar came on, in order of display, and when the last went off.
    azimuth : (pass, position) array [rad] clockwise from straight ahead
        Where the bar was in each frame: evenly spaced, once round, in one direction. Wherever a pass begins, all must
        visit the same positions.
    neighbours : {"running", "blocks"}
        Average over three neighbouring frames: as a running mean, which keeps every position, or in blocks, which
        leaves a third of them.

    Raises
    ------
    InputError
        If shapes do not agree, times do not ascend, a pass is not one even turn, passes visit different positions, or
        blocks of three do not divide them.

    Notes
    -----
    Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052: 192 frames in 6 s; rate of each frame, mean over three
    neighbouring frames, mean over passes of one direction, low-pass filter of three bins, peak to 1. The paper calls
    the result of the first mean bins of about 0.1 s, which may mean either kind of neighbours; Fig. 3 has 192 columns.
    Both means close the circle: the first and the last frame of a pass are neighbours in azimuth, though they are a
    rotation apart in time.
    """
    check_choice("neighbours", neighbours, NEIGHBOURS)
    spikes = sorted_spikes(spike_times)
    edges, angles = _checked_passes(frame_edges, azimuth)
    is_clockwise = _directions(angles)
    positions, index = _common_positions(angles)
    count = np.diff(np.searchsorted(spikes, edges), axis=-1)
    rate: Reals = np.empty(angles.shape)
    np.put_along_axis(rate, index, count / np.diff(edges, axis=-1), axis=-1)
    if neighbours == "running":
        rate = _running_mean(rate, _N_FRAMES)
    else:
        rate = _block_mean(rate, _N_FRAMES)
        positions = positions[_N_FRAMES // 2 :: _N_FRAMES]
    return ReceptiveFields(
        clockwise=_field(positions, rate[is_clockwise]), anticlockwise=_field(positions, rate[~is_clockwise])
    )


def _checked_passes(frame_edges: ArrayLike, azimuth: ArrayLike) -> tuple[Reals, Reals]:
    """Edges (pass, position + 1) and azimuths (pass, position) that belong together."""
    edges, angles = as_numbers("frame_edges", frame_edges).astype(float), as_numbers("azimuth", azimuth).astype(float)
    check_shape("azimuth", angles, ("pass", "position"))
    n_passes, n_positions = angles.shape
    if n_passes < 1 or n_positions < MIN_ANGLES:
        raise InputError(f"azimuth has shape {angles.shape}, expected at least one pass and {MIN_ANGLES} positions")
    check_finite("azimuth", angles)
    check_radians("azimuth", angles)
    check_shape("frame_edges", edges, (n_passes, n_positions + 1))
    check_finite("frame_edges", edges)
    if (np.diff(edges, axis=-1) <= 0.0).any():
        raise InputError("frame_edges does not ascend along every pass, expected times in order of display")
    return edges, angles


def _directions(angles: Reals) -> NDArray[np.bool_]:
    """Whether each pass goes clockwise; refuses passes that are not one even turn."""
    step = FULL_TURN / angles.shape[1]
    moves = wrap(np.diff(angles, axis=-1)) / step
    is_clockwise = moves[:, 0] > 0.0
    is_even = np.abs(moves - np.where(is_clockwise, 1.0, -1.0)[:, None]) < 0.1
    if not is_even.all():
        first = int(np.argmin(is_even.all(axis=-1)))
        raise InputError(
            f"azimuth of pass {first} does not go round once in {angles.shape[1]} even steps one way, expected steps "
            f"of {np.rad2deg(step):.4g}°: half a turn, or two directions in one pass?"
        )
    return is_clockwise


def _common_positions(angles: Reals) -> tuple[Reals, NDArray[np.intp]]:
    """Ascending azimuths (position,) that all passes visit, and which of them each frame shows, (pass, position)."""
    n_positions = angles.shape[1]
    step = FULL_TURN / n_positions
    offset = float(np.mod(angles[0, 0] + np.pi, step))
    offset = 0.0 if step - offset < 1e-6 * step else offset  # a rounding error below −π
    place = (angles + np.pi - offset) / step
    nearest = np.rint(place)
    if (np.abs(place - nearest) > 0.1).any():
        raise InputError("azimuth differs between passes by a part of a step, expected the same positions in all")
    return offset - np.pi + step * np.arange(n_positions), nearest.astype(np.intp) % n_positions


def _running_mean(rate: Reals, width: int) -> Reals:
    """Mean of each value and its neighbours (..., n), the ends joined; the width is odd."""
    shifts = range(-(width // 2), width // 2 + 1)
    return sum((np.roll(rate, shift, axis=-1) for shift in shifts), np.zeros_like(rate)) / width


def _block_mean(rate: Reals, width: int) -> Reals:
    """Mean of each run of neighbours, (..., n / width)."""
    n_positions = rate.shape[-1]
    if n_positions % width:
        raise InputError(f"azimuth has {n_positions} positions, expected a multiple of {width} for blocks")
    return rate.reshape(*rate.shape[:-1], n_positions // width, width).mean(axis=-1)


def _field(azimuth: Reals, rate: Reals) -> ReceptiveField:
    """Mean over passes (pass, bin), smoothed and normalised."""
    n_passes = len(rate)
    if n_passes == 0:
        nothing = np.full(azimuth.shape, np.nan)
        return ReceptiveField(azimuth, nothing, nothing, 0)
    smooth = _running_mean(rate.mean(axis=0), _N_BINS)
    peak = smooth.max()
    return ReceptiveField(azimuth, smooth, smooth / (peak if peak > 0.0 else np.nan), n_passes)
