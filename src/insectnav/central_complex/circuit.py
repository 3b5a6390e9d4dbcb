"""The path integrator as a pure function of its state and senses, one time step at a time."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from insectnav.central_complex.layers import N_ROWS, POPULATIONS, rows
from insectnav.central_complex.packing import new_workspace, pack_circuit
from insectnav.central_complex.parameters import CircuitParams
from insectnav.checks import InputError, as_numbers, check_finite, check_precision, check_radians, check_shape
from insectnav.rng import trial_streams

Reals = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True, eq=False)
class CircuitState:
    """What the circuit carries from step to step. Batch axes lead.

    Parameters
    ----------
    tb1 : (..., 8) array
        Rates of the compass ring.
    memory : (..., 16) array
        Charge of the CPU4 cells, 0 to 1.
    stream : (..., 4) array of uint32, or None
        Random numbers still to come; None where there is no noise.
    """

    tb1: Reals
    memory: Reals
    stream: NDArray[np.uint32] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Senses:
    """What the circuit is told in a time step. Batch axes lead.

    Parameters
    ----------
    heading : (...) array [rad]
        Clockwise from +y.
    velocity : (..., 2) array [steps per time step]
        Over ground; the noduli cells measure its components relative to the heading.
    """

    heading: ArrayLike
    velocity: ArrayLike


@dataclass(frozen=True, kw_only=True, eq=False)
class Rates:
    """Activity of every cell after a step, in the order of the circuit. All lie in 0…1 but the turn.

    Parameters
    ----------
    tl, cl1, memory, cpu4, pontine, cpu1 : (..., 16) arrays
    tb1 : (..., 8) array
    tn1, tn2 : (..., 2) arrays
        Right, left.
    motor : (...) array [rad]
        Turn, positive to the right.
    """

    tl: Reals
    cl1: Reals
    tb1: Reals
    tn1: Reals
    tn2: Reals
    memory: Reals
    cpu4: Reals
    pontine: Reals
    cpu1: Reals
    motor: Reals


def initial_state(
    params: CircuitParams,
    shape: tuple[int, ...] = (),
    *,
    seed: int | None = None,
    dtype: DTypeLike = "float64",
) -> CircuitState:
    """State of circuits that have just left the nest: an even memory and a silent compass ring.

    Parameters
    ----------
    params : CircuitParams
    shape : tuple of int
        Batch axes; () for one circuit.
    seed : int, optional
        Of the noise; needed by `step` only when noise is asked for. Circuit k of the batch draws the same numbers as
        trial k of `insectnav.agents.run_trials` with this seed.
    dtype : {"float32", "float64"}

    Raises
    ------
    InputError
        If the seed is negative or the dtype is another.
    """
    dtype = check_precision("dtype", dtype)
    stream = None
    if seed is not None:
        stream = trial_streams(seed, np.arange(int(np.prod(shape))), "circuit").reshape(*shape, 4)
    return CircuitState(
        tb1=np.zeros((*shape, 8), dtype), memory=np.full((*shape, 16), params.memory_start, dtype), stream=stream
    )


def step(
    state: CircuitState,
    senses: Senses,
    params: CircuitParams,
    *,
    noise: float | Mapping[str, float] = 0.0,
) -> tuple[CircuitState, Rates]:
    """State and rates after one time step; the turn to make is ``rates.motor``.

    Parameters
    ----------
    state : CircuitState
        From `initial_state` or from the step before; its precision is the one computed in.
    senses : Senses
        With the same batch axes.
    params : CircuitParams
    noise : float, or dict of population name to float
        Standard deviation σ_r of the noise on each firing rate; populations not named have none.

    Raises
    ------
    InputError
        If shapes do not agree, a value is not finite or not in radians, or noise is asked of a state without a seed.

    Notes
    -----
    The equations of Stone et al. 2017, Methods; they stand, once, in `circuit_kernel.advance_circuit`.
    """
    from insectnav.central_complex.step_kernel import step_circuits

    dtype = np.asarray(state.memory).dtype
    check_precision("dtype of the state", dtype)
    batch = np.shape(senses.heading)
    _check_batch(state, senses, batch)
    circuit = pack_circuit(params, noise, dtype)
    if circuit.constants.is_noisy and state.stream is None:
        raise InputError("noise needs random numbers, but the state has none: give initial_state a seed")
    n_circuits = math.prod(batch)
    streams = np.zeros((n_circuits, 4), np.uint32) if state.stream is None else np.array(state.stream).reshape(-1, 4)
    activity = np.empty((n_circuits, N_ROWS), dtype)
    step_circuits(
        np.array(senses.heading, dtype).reshape(-1),
        np.array(senses.velocity, dtype).reshape(-1, 2),
        np.array(state.tb1, dtype).reshape(-1, 8),
        np.array(state.memory).reshape(-1, 16),
        streams,
        activity,
        circuit,
        new_workspace(dtype),
    )
    rates = split_activity(activity.reshape(*batch, N_ROWS))
    stream_after = None if state.stream is None else streams.reshape(*batch, 4)
    return CircuitState(tb1=rates.tb1, memory=rates.memory, stream=stream_after), rates


def split_activity(activity: Reals) -> Rates:
    """Rates by population, from an array (..., N_ROWS) of all activities."""
    parts = {name: activity[..., rows(name)] for name in POPULATIONS}
    parts["motor"] = parts["motor"][..., 0]
    return Rates(**parts)


def _check_batch(state: CircuitState, senses: Senses, batch: tuple[int, ...]) -> None:
    check_shape("state tb1", np.asarray(state.tb1), (*batch, 8))
    check_shape("state memory", np.asarray(state.memory), (*batch, 16))
    check_shape("velocity", as_numbers("velocity", senses.velocity), (*batch, 2))
    if state.stream is not None:
        check_shape("state stream", state.stream, (*batch, 4))
    check_finite("heading", senses.heading)
    check_radians("heading", senses.heading)
    check_finite("velocity", senses.velocity)
