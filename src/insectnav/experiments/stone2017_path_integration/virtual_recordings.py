"""The stimuli of Figs 1 to 3 shown to the model, and spike times as a lab would have them from its cells.

The model has rates from 0 to 1 and time steps; a lab has impulses and seconds. Two assumptions join them: the length of
a time step, and the firing rate that 1 stands for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.agents.motion import MotionParams
from insectnav.agents.simulation import TrialParams, simulate_trials
from insectnav.angles import FULL_TURN, unit_vector, wrap
from insectnav.central_complex import N_CELLS, POPULATIONS, CircuitParams

Reals = NDArray[np.floating[Any]]

STILL = 0.5  # [s] Methods: the pattern stands still before it moves
MOVING = 3.0  # [s] Methods
DARK = 3.0  # [s] Methods
_BEFORE = 2.5  # [s] of darkness before the first bout; background is taken from 2 s of it
_SAMPLE_MS = 50.0  # of the recorded angle, which is linear in between
_BATCH = 16  # recordings simulated at once, as many as a compiled block holds


class TurningStimulus(NamedTuple):
    """A stimulus that turns clockwise, then anticlockwise, at one speed."""

    time: Reals  # (sample,) [s] of the recorded angle
    angle: Reals  # (sample,) [rad] wrapped
    angle_in_step: Reals  # (step,) [rad] in the middle of each time step of the model, not wrapped
    way: NDArray[np.int64]  # (step,) 1 clockwise, −1 anticlockwise


class FlowProtocol(NamedTuple):
    """Bouts of optic flow, one after the other, each before darkness."""

    start: Reals  # (bout,) [s] begin of movement
    stop: Reals  # (bout,) [s]
    onset: float  # [s] when the first pattern appears
    heading: Reals  # (step,) [rad]
    velocity: Reals  # (step, 2) [steps per time step]


def turning_stimulus(speed_deg: float, n_turns: int, step_ms: float) -> TurningStimulus:
    """Whole turns of 360°, first clockwise, then anticlockwise.

    Parameters
    ----------
    speed_deg : float [°/s]
    n_turns : int
        Each way.
    step_ms : float [ms]
        Of the model; a turn must take a whole number of them.
    """
    n_steps = round(360.0 / speed_deg * 1000.0 / step_ms) * n_turns
    sample = np.arange(0, 2 * n_steps + 1, max(1, round(_SAMPLE_MS / step_ms)))
    step = np.arange(2 * n_steps)

    def angle_at(place: NDArray[Any]) -> Reals:
        return (n_steps - np.abs(n_steps - place)) * (FULL_TURN * n_turns / n_steps)

    way = np.where(step < n_steps, 1, -1)
    return TurningStimulus(sample * step_ms / 1000.0, wrap(angle_at(sample)), angle_at(step + 0.5), way)


def sensed_heading(stimulus: TurningStimulus, anticipation: float, is_polariser: bool) -> Reals:
    """Heading that the compass is told in each time step, (step,) [rad].

    Parameters
    ----------
    stimulus : TurningStimulus
    anticipation : float [rad]
        Compass shift of Ext. Data Fig. 9a: how far the angle of the stimulus is sensed ahead of its turn.
    is_polariser : bool
        Whether half a turn of the stimulus is a whole one to the compass: the model has no cells for polarised light,
        and is given twice the angle.
    """
    ahead = stimulus.angle_in_step + anticipation * stimulus.way
    return wrap((2.0 if is_polariser else 1.0) * ahead)


def flow_protocol(velocity: Reals, turning: Reals, step_ms: float) -> FlowProtocol:
    """Bouts of 0.5 s of a still pattern, 3 s of movement and 3 s of darkness, after 2.5 s of darkness.

    Parameters
    ----------
    velocity : (bout, 2) array [steps per time step]
        Simulated movement of the body, to its right and forwards.
    turning : (bout,) array [rad/s]
        Simulated turning.
    step_ms : float [ms]
        Of the model; the three intervals must be whole numbers of them.
    """
    seconds = step_ms / 1000.0
    n_before, n_still, n_moving, n_dark = (round(interval / seconds) for interval in (_BEFORE, STILL, MOVING, DARK))
    is_moving = np.concatenate([np.zeros(n_still), np.ones(n_moving), np.zeros(n_dark)])
    bouts = (is_moving[None, :, None] * np.column_stack([velocity, turning])[:, None, :]).reshape(-1, 3)
    steps = np.concatenate([np.zeros((n_before, 3)), bouts])
    heading = np.cumsum(steps[:, 2]) * seconds
    right, forward = steps[:, 0, None], steps[:, 1, None]
    over_ground = right * unit_vector(heading + np.pi / 2.0) + forward * unit_vector(heading)
    start = (n_before + n_still + np.arange(len(velocity)) * is_moving.size) * seconds
    return FlowProtocol(start, start + n_moving * seconds, n_before * seconds, wrap(heading), over_ground)


def recorded_rates(
    heading: Reals,
    velocity: Reals,
    circuit: CircuitParams,
    *,
    noise: float,
    seed: int,
    first_trial: int,
    n_animals: int,
) -> Iterator[tuple[int, dict[str, Reals]]]:
    """Number of each animal, and the rates (step, cell) of its compass and flow cells under one and the same stimulus.

    Parameters
    ----------
    heading : (step,) array [rad]
    velocity : (step, 2) array [steps per time step]
    circuit : CircuitParams
    noise : float
        σ_r of all cells.
    seed, first_trial : int
        Animal k has the noise of trial ``first_trial + k``.
    n_animals : int
    """
    record = ("tl", "cl1", "tb1", "tn1", "tn2")
    params = TrialParams(circuit=circuit, motion=MotionParams(), n_inbound=0, noise=noise, seed=seed, record=record)
    order = [name for name in POPULATIONS if name in record]
    ends = np.cumsum([N_CELLS[name] for name in order])[:-1]
    for first in range(0, n_animals, _BATCH):
        animals = np.arange(first, min(first + _BATCH, n_animals))
        headings = np.tile(heading.astype(np.float32), (len(animals), 1))
        velocities = np.tile(velocity.astype(np.float32), (len(animals), 1, 1))
        activity = simulate_trials(headings, velocities, first_trial + animals, params).activity
        for animal, rates in zip(animals, activity, strict=True):
            yield int(animal), dict(zip(order, np.split(rates, ends, axis=-1), strict=True))


def poisson_spikes(rate: Reals, step_ms: float, peak_rate: float, generator: np.random.Generator) -> Reals:
    """Spike times [s], in order, of an inhomogeneous Poisson process whose rate is constant within each time step.

    Parameters
    ----------
    rate : (step,) array
        From 0 to 1.
    step_ms : float [ms]
    peak_rate : float [1/s]
        What a rate of 1 stands for.
    generator : numpy Generator
    """
    seconds = step_ms / 1000.0
    step = np.repeat(np.arange(rate.size), generator.poisson(rate * (peak_rate * seconds)))
    return np.sort((step + generator.uniform(size=step.size)) * seconds)


def spike_generator(seed: int, purpose: Sequence[int]) -> np.random.Generator:
    """Random numbers for the spikes of one recording: other numbers give independent ones."""
    return np.random.default_rng(np.random.SeedSequence([seed, *purpose]))
