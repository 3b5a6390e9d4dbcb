"""Trials in batches: an outbound route, then the way home as the circuit steers it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from insectnav.agents.motion import MotionParams
from insectnav.central_complex import POPULATIONS, THESIS, CircuitParams, decode_home_vector
from insectnav.central_complex.layers import N_CELLS, N_ROWS, rows
from insectnav.central_complex.packing import pack_constants, pack_noise, pack_wiring
from insectnav.checks import InputError, check_choice, check_count, check_finite, check_shape
from insectnav.lanes import LANES, empty_rows
from insectnav.rng import trial_streams

if TYPE_CHECKING:
    import xarray

Reals = NDArray[np.floating[Any]]
CELL_DIMENSION = {16: ("cell",), 8: ("direction",), 2: ("side",), 1: ()}
BLOCKS_PER_TASK = 4  # small enough to keep all cores busy until the end


def run_trials(
    routes: xarray.Dataset | tuple[ArrayLike, ArrayLike],
    circuit: CircuitParams = THESIS,
    motion: MotionParams = MotionParams(),  # noqa: B008 (frozen)
    n_inbound: int = 1500,
    noise: float | Mapping[str, float] = 0.1,
    seed: int = 0,
    record: Collection[str] = (),
    dtype: DTypeLike = "float32",
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> xarray.Dataset:
    """Paths, memories and, on request, the activity of every cell over outbound routes and ways home.

    Parameters
    ----------
    routes : Dataset or (heading (trial, step), velocity (trial, step, 2))
        Headings [rad], clockwise from +y, and velocities [steps per time step], as from `random_routes`. The trial
        coordinate of a Dataset says which noise a trial gets, so that any part of it runs as it does in the whole.
    circuit : CircuitParams
    motion : MotionParams
        Of the way home.
    n_inbound : int
        Steps of the way home.
    noise : float, or dict of population name to float
        Standard deviation σ_r of the noise on each firing rate.
    seed : int
    record : collection of population names
        Adds the activity (trial, step, …) of "tl", "cl1", "tb1", "tn1", "tn2", "memory", "cpu4", "pontine", "cpu1"
        or "motor" (the turn [rad]). Memory then grows with trials × steps × cells.
    dtype : {"float32", "float64"}
        float64 follows the published recursion to rounding, float32 is several times faster.
    workers : int, optional
        Threads; all cores of the machine by default. The result does not depend on it.
    progress : callable, optional
        Called with the number of trials just finished, from this thread.

    Returns
    -------
    Dataset
        heading (trial, step) [rad] and position (trial, step, xy) [steps] from the nest at 0, 0: the outbound samples,
        of which the last is the turning point, then each inbound one after its turn and move; coordinate leg (step),
        "out" or "home". memory_at_turn (trial, cell); home_vector_at_turn (trial, xy) [steps], from the agent to the
        nest as the circuit decodes it; closest_distance (trial) [steps] to the nest on the way home, the turning point
        included.

    Raises
    ------
    InputError
        If shapes do not agree, a route is empty or not finite, or an option has an unknown value.

    Notes
    -----
    Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052. On the way home the cells see the present heading and
    velocity, then the agent turns and moves; the first inbound step therefore sees the turning point again.
    """
    check_count("n_inbound", n_inbound, minimum=0)
    check_choice("dtype", np.dtype(dtype).name, ("float32", "float64"))
    for population in record:
        check_choice("population to record", population, POPULATIONS)
    heading, velocity, trials = _route_arrays(routes, dtype)
    recorded = [name for name in POPULATIONS if name in record]
    arrays = _run(
        _Setting(
            heading=heading,
            velocity=velocity,
            streams=trial_streams(seed, trials, "circuit"),
            circuit=circuit,
            motion=motion,
            noise=pack_noise(noise, dtype),
            recorded_rows=np.array([row for name in recorded for row in range(N_ROWS)[rows(name)]], np.int64),
            n_steps=heading.shape[1] + n_inbound,
        ),
        _count_workers(workers),
        progress,
    )
    attributes = {"noise": json.dumps(noise), "seed": seed, "dtype": np.dtype(dtype).name}
    return _dataset(arrays, recorded, trials, heading.shape[1], circuit, motion, attributes)


class _Setting(NamedTuple):
    heading: Reals
    velocity: Reals
    streams: NDArray[np.uint32]
    circuit: CircuitParams
    motion: MotionParams
    noise: Reals
    recorded_rows: NDArray[np.int64]
    n_steps: int


class _Arrays(NamedTuple):
    heading: Reals
    position: Reals
    memory: Reals
    closest: Reals
    record: Reals


def _route_arrays(
    routes: xarray.Dataset | tuple[ArrayLike, ArrayLike], dtype: DTypeLike
) -> tuple[Reals, Reals, NDArray[np.integer]]:
    if isinstance(routes, tuple):
        if len(routes) != 2:
            raise InputError(f"routes has {len(routes)} parts, expected a Dataset or (heading, velocity)")
        heading, velocity = (np.asarray(part) for part in routes)
        trials = np.arange(len(heading)) if heading.ndim else np.arange(1)
    else:
        heading = routes["heading"].transpose("trial", "step").values
        velocity = routes["velocity"].transpose("trial", "step", "xy").values
        trials = np.asarray(routes["trial"].values)
    check_shape("route heading", heading, ("trial", "step"))
    check_shape("route velocity", velocity, (*heading.shape, 2))
    if heading.size == 0:
        raise InputError(f"routes are empty, {heading.shape[0]} trials of {heading.shape[1]} steps: expected some")
    check_finite("route heading", heading)
    check_finite("route velocity", velocity)
    return np.ascontiguousarray(heading, dtype), np.ascontiguousarray(velocity, dtype), trials


def _count_workers(workers: int | None) -> int:
    if workers is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    check_count("workers", workers)
    return workers


def _run(setting: _Setting, workers: int, progress: Callable[[int], None] | None) -> _Arrays:
    """Run all trials, tasks of a few blocks at a time on the given number of threads."""
    from insectnav.agents.trial_kernel import run_trials_kernel

    n_trials, dtype = setting.heading.shape[0], setting.heading.dtype
    n_steps = setting.n_steps
    arrays = _Arrays(
        heading=np.empty((n_trials, n_steps), dtype),
        position=np.empty((n_trials, n_steps, 2), dtype),
        memory=np.empty((n_trials, 16), dtype),
        closest=np.empty(n_trials, dtype),
        record=np.empty((n_trials, n_steps, setting.recorded_rows.size), dtype),
    )
    wiring = tuple(pack_wiring(setting.circuit, dtype))
    constants = pack_constants(setting.circuit, setting.noise)

    def run_task(first: int) -> int:
        last = min(first + BLOCKS_PER_TASK * LANES, n_trials)
        run_trials_kernel(
            first,
            last,
            setting.heading,
            setting.velocity,
            setting.streams,
            setting.circuit.memory_start,
            setting.motion.acceleration,
            setting.motion.drag,
            wiring,
            constants,
            setting.noise,
            setting.recorded_rows,
            empty_rows(N_ROWS + 8 + 3, dtype),
            empty_rows(4, np.uint32),
            *arrays,
        )
        return last - first

    tasks = range(0, n_trials, BLOCKS_PER_TASK * LANES)
    with ThreadPoolExecutor(max(1, min(workers, len(tasks)))) as pool:
        for n_finished in pool.map(run_task, tasks):
            if progress is not None:
                progress(n_finished)
    return arrays


def _dataset(
    arrays: _Arrays,
    recorded: list[str],
    trials: NDArray[np.integer],
    n_outbound: int,
    circuit: CircuitParams,
    motion: MotionParams,
    attributes: dict[str, Any],
) -> xarray.Dataset:
    """Name the arrays and say in attributes how they came about."""
    import xarray

    n_steps = arrays.heading.shape[1]
    variables: dict[str, Any] = {
        "heading": (("trial", "step"), arrays.heading, {"units": "rad", "zero": "+y", "positive": "clockwise"}),
        "position": (("trial", "step", "xy"), arrays.position, {"units": "steps"}),
        "memory_at_turn": (("trial", "cell"), arrays.memory),
        "home_vector_at_turn": (("trial", "xy"), decode_home_vector(arrays.memory, circuit), {"units": "steps"}),
        "closest_distance": (("trial",), arrays.closest, {"units": "steps"}),
    }
    column = 0
    for name in recorded:
        n_cells = N_CELLS[name]
        activity = arrays.record[..., column : column + n_cells]
        variables[name] = (("trial", "step", *CELL_DIMENSION[n_cells]), activity if n_cells > 1 else activity[..., 0])
        column += n_cells
    settings = {f"circuit_{key}": value for key, value in vars(circuit).items() if key != "connectivity"}
    settings |= {f"motion_{key}": value for key, value in asdict(motion).items()}
    return xarray.Dataset(
        variables,
        coords={
            "trial": trials,
            "step": np.arange(n_steps),
            "xy": ["x", "y"],
            "leg": ("step", np.where(np.arange(n_steps) < n_outbound, "out", "home")),
        },
        attrs=settings | attributes,
    )
