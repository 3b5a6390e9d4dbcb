"""Trials in batches, from arrays to arrays, on all cores."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from insectnav.agents.motion import MotionParams
from insectnav.agents.perturbation_packing import new_notebook, own_weights, pack_disturbances
from insectnav.agents.perturbations import Perturbation
from insectnav.central_complex import POPULATIONS, CircuitParams
from insectnav.central_complex.layers import N_ROWS, rows
from insectnav.central_complex.packing import new_workspace, pack_circuit
from insectnav.checks import (
    InputError,
    as_numbers,
    check_choice,
    check_count,
    check_finite,
    check_precision,
    check_radians,
    check_shape,
)
from insectnav.lanes import LANES
from insectnav.rng import trial_streams
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
BLOCKS_PER_TASK = 4  # small enough to keep all cores busy until the end


@dataclass(frozen=True, kw_only=True)
class TrialParams:
    """All that a batch of trials is run with, but for the routes; see `insectnav.agents.run_trials`.

    Raises
    ------
    InputError
        If an option has an unknown value.
    """

    circuit: CircuitParams
    motion: MotionParams
    n_inbound: int
    noise: float | Mapping[str, float]
    seed: int
    record: Collection[str] = ()
    dtype: DTypeLike = "float32"
    perturbations: Sequence[Perturbation] = ()
    keep_paths: bool = True  # without them, headings and positions have no steps: for very long trials

    def __post_init__(self) -> None:
        check_count("n_inbound", self.n_inbound, minimum=0)
        check_precision("dtype", self.dtype)
        for population in self.record:
            check_choice("population to record", population, POPULATIONS)

    @property
    def recorded(self) -> tuple[str, ...]:
        """Populations to record, in the order of the circuit."""
        return tuple(name for name in POPULATIONS if name in self.record)


class TrialArrays(NamedTuple):
    """Results of a batch of trials; the names are those of the Dataset of `insectnav.agents.run_trials`."""

    heading: Reals  # (trial, step) [rad]
    position: Reals  # (trial, step, 2) [steps]
    memory_at_turn: Reals  # (trial, 16)
    closest_distance: Reals  # (trial,) [steps]
    activity: Reals  # (trial, step, column): cells of the recorded populations, one after the other
    recorded_rows: NDArray[np.int64]  # (column,) which cells they are, rows as in `insectnav.central_complex.layers`


class Motion(NamedTuple):
    """How an agent starts and moves, in the form that the kernel reads."""

    memory_start: float
    acceleration: float
    drag: float
    n_inbound: int


def simulate_trials(
    heading: ArrayLike,
    velocity: ArrayLike,
    trials: ArrayLike,
    params: TrialParams,
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> TrialArrays:
    """Results of one trial per route, as arrays; `insectnav.agents.run_trials` is this with names.

    Parameters
    ----------
    heading : (trial, step) array [rad]
    velocity : (trial, step, 2) array [steps per time step]
    trials : (trial,) array of int
        Numbers that say which noise each trial gets.
    params : TrialParams
    workers, progress
        As of `insectnav.agents.run_trials`.

    Raises
    ------
    InputError
        If shapes do not agree, or a route is empty, not finite or not in radians.
    """
    from insectnav.agents.trial_kernel import run_trials_kernel

    heading, velocity = _check_routes(
        as_numbers("route heading", heading), as_numbers("route velocity", velocity), params.dtype
    )
    (n_trials, n_outbound), dtype = heading.shape, heading.dtype
    results = _empty_results(n_trials, n_outbound + params.n_inbound, params, dtype)
    streams = trial_streams(params.seed, trials, "circuit")
    memory_start = float(params.circuit.memory_start)
    motion = Motion(memory_start, float(params.motion.acceleration), float(params.motion.drag), int(params.n_inbound))
    circuit, disturbances = pack_disturbances(
        params.perturbations,
        pack_circuit(params.circuit, params.noise, dtype),
        memory_start=memory_start,
        n_outbound=n_outbound,
        trials=trials,
        seed=params.seed,
    )

    def run_task(first: int, last: int) -> None:
        work = new_workspace(dtype)
        own_circuit, notebook = own_weights(circuit, disturbances), new_notebook(disturbances, dtype)
        run_trials_kernel(
            first, last, heading, velocity, streams, own_circuit, motion, disturbances, work, notebook, results
        )

    run_blocks(run_task, n_trials, BLOCKS_PER_TASK * LANES, workers, progress)
    return results


def _empty_results(n_trials: int, n_steps: int, params: TrialParams, dtype: DTypeLike) -> TrialArrays:
    recorded_rows = np.array([row for name in params.recorded for row in range(N_ROWS)[rows(name)]], np.int64)
    n_kept = n_steps if params.keep_paths else 0
    return TrialArrays(
        heading=np.empty((n_trials, n_kept), dtype),
        position=np.empty((n_trials, n_kept, 2), dtype),
        memory_at_turn=np.empty((n_trials, 16), dtype),
        closest_distance=np.empty(n_trials, dtype),
        activity=np.empty((n_trials, n_steps, recorded_rows.size), dtype),
        recorded_rows=recorded_rows,
    )


def _check_routes(heading: Reals, velocity: Reals, dtype: DTypeLike) -> tuple[Reals, Reals]:
    check_shape("route heading", heading, ("trial", "step"))
    check_shape("route velocity", velocity, (*heading.shape, 2))
    if heading.size == 0:
        raise InputError(f"routes are empty ({heading.shape[0]} trials of {heading.shape[1]} steps), expected some")
    check_finite("route heading", heading)
    check_radians("route heading", heading)
    check_finite("route velocity", velocity)
    return np.require(heading, dtype, ["C", "W"]), np.require(velocity, dtype, ["C", "W"])
