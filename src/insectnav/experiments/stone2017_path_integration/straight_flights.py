"""Trials along given routes; flights in one direction at constant speed, and what was done to the circuit in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from insectnav.agents.motion import MotionParams
from insectnav.agents.simulation import TrialArrays, TrialParams, simulate_trials
from insectnav.angles import unit_vector
from insectnav.central_complex import CircuitParams

Route = tuple[NDArray[np.floating[Any]], NDArray[np.floating[Any]]]


def straight_flight(heading: ArrayLike, n_steps: int, speed: float) -> Route:
    """Heading (trial, step) [rad] and velocity (trial, step, 2) of flights straight ahead.

    Parameters
    ----------
    heading : (trial,) array [rad]
    n_steps : int
    speed : float
        [steps per time step]
    """
    headings = np.repeat(np.atleast_1d(np.asarray(heading, float))[:, None], n_steps, axis=1)
    return headings, speed * unit_vector(headings)


def fly(
    route: tuple[ArrayLike, ArrayLike],
    circuit: CircuitParams,
    *,
    n_inbound: int = 0,
    noise: float | Mapping[str, float] = 0.0,
    seed: int = 0,
    first_trial: int = 0,
    perturbations: Sequence[Any] = (),
    record: Sequence[str] = (),
    dtype: DTypeLike = "float32",
) -> TrialArrays:
    """Trials along given routes; trial k has the same noise whatever is done to it.

    Parameters
    ----------
    route : heading (trial, step) [rad] and velocity (trial, step, 2)
    circuit : CircuitParams
    n_inbound : int
    noise : float, or dict of population name to float
        σ_r of all cells, or of some.
    seed, first_trial : int
        Trial k of the batch has the noise of trial first_trial + k.
    perturbations : sequence of perturbations
    record : names of populations
    dtype : {"float32", "float64"}
    """
    params = TrialParams(
        circuit=circuit,
        motion=MotionParams(),
        n_inbound=n_inbound,
        noise=noise,
        seed=seed,
        record=record,
        dtype=dtype,
        perturbations=perturbations,
    )
    return simulate_trials(*route, first_trial + np.arange(len(np.asarray(route[0]))), params)
