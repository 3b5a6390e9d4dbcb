"""From an animal's recorded track to the steps that the circuit is flown along."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import bearing, wrap
from insectnav.checks import InputError, check_range
from insectnav.records import Track

Reals = NDArray[np.floating[Any]]

HIGH_SPEED = 0.85  # [TN range] what the 95th percentile of speed becomes; ours, the top speed of random routes
FARTHEST = 300.0  # [steps] ours: flown straight at that speed, memory saturates from 350 to 400 steps on
LONGEST = 5000  # [time steps] thesis, Ext. Data Fig. 9b: memory saturates on longer random routes
MAX_STEPS = 1_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedRoute:
    """A track in the steps of the model.

    Parameters
    ----------
    heading : (step,) array [rad]
        Clockwise from +y.
    velocity : (step, 2) array [steps per time step]
        Null at the first step, the nest.
    nest : (2,) array [length unit of the track]
        Where the track starts.
    steps_per_unit : float
        Steps of the model in a length unit of the track.
    time_per_step : float [time unit of the track]
    heading_source : str
        "recorded" or "direction of motion".
    notes : tuple of str
        What the user must be told.
    """

    heading: Reals
    velocity: Reals
    nest: Reals
    steps_per_unit: float
    time_per_step: float
    heading_source: str
    notes: tuple[str, ...]

    @property
    def n_steps(self) -> int:
        """Number of steps, the nest included."""
        return len(self.heading)


def route_from_track(
    track: Track, *, steps_per_unit: float | None = None, heading_smoothing: float = 2.0
) -> RecordedRoute:
    """The track at even time steps, scaled so that the speed cells can follow it and the memory can hold it.

    A time step is the median interval of the samples; where the farthest point of the track would then be more than
    300 steps from its start, or the track longer than 5000 time steps, it is as much longer as that takes. The length
    of a step is such that the 95th percentile of speed is 0.85 of what the TN cells can signal. If ``steps_per_unit``
    gives the length of a step instead, the time step is chosen to the same end, and the memory may saturate.

    Parameters
    ----------
    track : Track
        From the nest outwards.
    steps_per_unit : float, optional
        Steps of the model in a length unit of the track.
    heading_smoothing : float [time steps]
        SD of the Gaussian with which velocities are averaged where the heading is the direction of motion. While the
        animal stands, it keeps its heading.

    Raises
    ------
    InputError
        If the animal stands still in more than 95 % of the samples, or the steps would be too many or too few.
    """
    if track.n_samples < 2:
        raise InputError(f"track {track.name!r} has a single sample, expected at least 2")
    interval = float(np.median(np.diff(track.time)))
    slips = "is one position far off?", "is one time far off?"
    top_speed = _top_speed(track, _even_times(track, interval, *slips)) / interval
    notes = []
    if steps_per_unit is None:
        times = _even_times(track, _fitting_time_step(track, interval, top_speed), *slips)
        steps_per_unit = HIGH_SPEED / _top_speed(track, times)
        if (stretch := float(times[1] - times[0]) / interval) > 1.1:
            notes.append(f"a time step is {stretch:.3g} samples long, so that the memory can hold the track")
    else:
        check_range("steps per unit", steps_per_unit, 1e-12, 1e12, f"steps per {track.length_unit}")
        slips = "raise --steps-per-unit", "lower --steps-per-unit"
        times = _even_times(track, HIGH_SPEED / steps_per_unit / top_speed, *slips)
    position = _position_at(track, times)
    velocity = np.diff(position, axis=0, prepend=position[:1]) * steps_per_unit
    if track.heading is not None:
        heading, source = wrap(np.interp(times, track.time, np.unwrap(track.heading))), "recorded"
    else:
        heading, source = _direction_of_motion(velocity, heading_smoothing), "direction of motion"
        notes.append(
            f"no heading column: the heading is the direction of motion, smoothed over {heading_smoothing:g} steps (SD)"
        )
    if (too_fast := float(np.mean(np.linalg.norm(velocity, axis=-1) > 1.0))) > 0.05:
        notes.append(f"{100.0 * too_fast:.0f} % of the steps are faster than the speed cells can signal")
    return RecordedRoute(
        heading=heading,
        velocity=velocity,
        nest=position[0],
        steps_per_unit=float(steps_per_unit),
        time_per_step=float(times[1] - times[0]),
        heading_source=source,
        notes=tuple(notes),
    )


def _fitting_time_step(track: Track, interval: float, top_speed: float) -> float:
    """Time step for which neither the farthest point nor the whole track is too much for the memory."""
    farthest = float(np.linalg.norm(track.position - track.position[0], axis=-1).max())
    return max(interval, farthest / FARTHEST * HIGH_SPEED / top_speed, track.duration / LONGEST)


def _even_times(track: Track, interval: float, too_few: str, too_many: str) -> Reals:
    """Times about ``interval`` apart from the first sample to the last, both included."""
    n_intervals = round(min(track.duration / interval, 10.0 * MAX_STEPS))
    if n_intervals < 1:
        raise InputError(f"track {track.name!r} would become a single step, expected more: {too_few}")
    if n_intervals > MAX_STEPS:
        raise InputError(f"track {track.name!r} would become more than {MAX_STEPS} steps, expected fewer: {too_many}")
    return np.linspace(track.time[0], track.time[-1], n_intervals + 1)


def _position_at(track: Track, times: Reals) -> Reals:
    return np.stack([np.interp(times, track.time, coordinate) for coordinate in track.position.T], axis=-1)


def _top_speed(track: Track, times: Reals) -> float:
    """95th percentile of the distance between successive times [length unit]."""
    speed = float(np.percentile(np.linalg.norm(np.diff(_position_at(track, times), axis=0), axis=-1), 95.0))
    if speed > 0.0:
        return speed
    raise InputError(
        f"track {track.name!r} stands still in more than 95 % of its samples, expected movement: cut the pauses out"
    )


def _direction_of_motion(velocity: Reals, smoothing: float) -> Reals:
    """Heading along velocities averaged with a Gaussian; where they cancel or rest, the heading before."""
    check_range("heading_smoothing", smoothing, 0.0, 1e4, "time steps")
    reach = min(int(np.ceil(4.0 * smoothing)), len(velocity))
    offsets = np.arange(-reach, reach + 1)
    weights = np.exp(-0.5 * (offsets / max(smoothing, 1e-9)) ** 2)
    mean = np.stack([np.convolve(v, weights / weights.sum())[reach : reach + len(velocity)] for v in velocity.T], -1)
    speed = np.linalg.norm(mean, axis=-1)
    is_moving = speed > 1e-3 * np.percentile(np.linalg.norm(velocity, axis=-1), 95.0)
    last_moving = np.maximum.accumulate(np.where(is_moving, np.arange(len(velocity)), -1))
    last_moving[last_moving < 0] = np.argmax(is_moving)
    return bearing(mean)[last_moving]
