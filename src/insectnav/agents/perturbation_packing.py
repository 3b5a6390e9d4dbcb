"""Perturbations in the form that the trial kernel reads: the same few scalars and arrays, whatever there is of them.

The kernel is therefore compiled once. What is absent is an array without rows, or a scalar that changes nothing.
"""

import hashlib
import numbers
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from insectnav.agents.obstacles import Circle, Wall
from insectnav.agents.perturbations import (
    ClampCells,
    CompassShift,
    Displace,
    FilterSpeed,
    FreezeMemory,
    Perturbation,
    ScaleSpeed,
    SetMemory,
    TurnBody,
    WeightNoise,
)
from insectnav.central_complex.layers import N_CELLS, ROW
from insectnav.central_complex.packing import FIRST_TARGET, N_TARGETS, PackedCircuit
from insectnav.checks import InputError
from insectnav.lanes import LANES, empty_rows
from insectnav.rng import trial_streams

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
Kind = TypeVar("Kind")

SINGLE = (WeightNoise, CompassShift, FilterSpeed, TurnBody)  # at most one of each: two have no plain meaning
SKIN = 0.01  # [steps] left to the surface of obstacles; more than single precision loses up to 60 000 steps from home
NEVER = np.iinfo(np.int64).max


class Intervals(NamedTuple):
    """Steps from ``first_step`` up to but not including ``end_step``."""

    first_step: Integers
    end_step: Integers


class Clamps(NamedTuple):
    """Clamps of single cells; of two on one cell, the later counts."""

    first_step: Integers
    end_step: Integers
    row: Integers
    rate: Reals


class Displacements(NamedTuple):
    """At a step, position ← keep · position + change."""

    step: Integers
    keep: Reals
    change: Reals  # (n, 2) [steps]


class MemoryChanges(NamedTuple):
    """At a step, memory ← clip(keep · memory + change[first_row + row_of_trial · trial], 0, 1)."""

    step: Integers
    keep: Reals
    first_row: Integers
    row_of_trial: Integers  # 1 for a row for each trial, 0 for one for all
    change: Reals  # (row, 16)


class WeightChanges(NamedTuple):
    """Weights of each trial: mean · (1 + sd · normal number)."""

    is_noisy: bool
    lowest_factor: float
    mean: Reals  # (synapse,)
    sd: Reals  # (synapse,)
    streams: NDArray[np.uint32]  # (trial, 4)


class Turning(NamedTuple):
    """An angle added to the heading from ``first_step`` up to but not including ``end_step``."""

    is_on: bool
    angle: float  # [rad]
    redraw_every: int  # [steps] 0: it stays
    first_step: int
    end_step: int
    streams: NDArray[np.uint32]  # (trial, 4)


class Disturbances(NamedTuple):
    """All perturbations of a batch of trials but those that stand in the packed circuit."""

    clamps: Clamps
    displacements: Displacements
    memories: MemoryChanges
    freezes: Intervals
    weights: WeightChanges
    body: Turning
    compass: Turning
    obstacles: Reals  # (n, 5) rows as in `insectnav.agents.obstacle_kernel`
    speed_factor: float


class Notebook(NamedTuple):
    """What disturbances carry from step to step in 16 trials; no two threads may share one."""

    turning: Reals  # (3, LANES) body offset, last turn, last heading of the route [rad]
    words: NDArray[np.uint32]  # (4, LANES) random number generators
    place: Reals  # (5, LANES) rows as in `insectnav.agents.obstacle_kernel`
    sides: Integers  # (n obstacles, LANES)


def pack_disturbances(
    perturbations: Sequence[Perturbation],
    circuit: PackedCircuit,
    *,
    memory_start: float,
    n_outbound: int,
    trials: ArrayLike,
    seed: int,
) -> tuple[PackedCircuit, Disturbances]:
    """The circuit with its filter, and everything else that is done to it, to the animal and in the world.

    Parameters
    ----------
    perturbations : sequence of perturbations
    circuit : PackedCircuit
    memory_start : float
        Even memory that stored memories are compared with.
    n_outbound : int
        Steps of the way out.
    trials : (trial,) array of int
        Numbers that say which random numbers each trial gets.
    seed : int

    Raises
    ------
    InputError
        If one is no perturbation, or they do not go together or not with the number of trials.
    """
    _check_list(perturbations)
    dtype, n_trials = circuit.noise.dtype, len(np.asarray(trials))
    for speed_filter in _of_kind(perturbations, FilterSpeed):
        share, is_noisy = 1.0 / speed_filter.n_steps, speed_filter.form == "code-2017"
        circuit = circuit._replace(constants=circuit.constants._replace(flow_share=share, is_filter_noisy=is_noisy))
    body = next(_of_kind(perturbations, TurnBody), TurnBody(offset=0.0))
    shift = next(_of_kind(perturbations, CompassShift), CompassShift(shift=0.0))
    freezes = list(_of_kind(perturbations, FreezeMemory))
    disturbances = Disturbances(
        clamps=_pack_clamps(list(_of_kind(perturbations, ClampCells)), dtype),
        displacements=_pack_displacements(list(_of_kind(perturbations, Displace)), dtype),
        memories=_pack_memories(list(_of_kind(perturbations, SetMemory)), memory_start, n_trials, dtype),
        freezes=Intervals(_integers(f.first_step for f in freezes), _integers(_end_step(f) for f in freezes)),
        weights=_pack_weights(next(_of_kind(perturbations, WeightNoise), None), circuit, trials, seed),
        body=_pack_turning(body.leg, body.offset, body.redraw_every, n_outbound, trials, seed),
        compass=_pack_turning(shift.leg, shift.shift, None, n_outbound, trials, seed),
        obstacles=_pack_obstacles(perturbations),
        speed_factor=float(np.prod([scale.factor for scale in _of_kind(perturbations, ScaleSpeed)])),
    )
    return circuit, disturbances


def own_weights(circuit: PackedCircuit, disturbances: Disturbances) -> PackedCircuit:
    """The circuit with room for weights of its own, where they differ between trials; else as it is."""
    if not disturbances.weights.is_noisy:
        return circuit
    room = empty_rows(len(circuit.wiring.weight), circuit.wiring.weight.dtype)
    return circuit._replace(wiring=circuit.wiring._replace(weight=room))


def new_notebook(disturbances: Disturbances, dtype: DTypeLike) -> Notebook:
    """Room for what disturbances carry from step to step."""
    return Notebook(
        turning=empty_rows(3, dtype),
        words=empty_rows(4, np.uint32),
        place=empty_rows(5, dtype),
        sides=np.zeros((len(disturbances.obstacles), LANES), np.int64),
    )


def describe_perturbation(perturbation: Perturbation) -> str:
    """The call that makes a perturbation, with arrays as their shape and the start of their SHA-256."""
    values = (f"{field.name}={_shown(getattr(perturbation, field.name))}" for field in fields(perturbation))
    return f"{type(perturbation).__name__}({', '.join(values)})"


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray):
        digest = hashlib.sha256(np.ascontiguousarray(value, "<f8").tobytes()).hexdigest()
        return f"<array {value.shape} sha256 {digest[:12]}>"
    if isinstance(value, tuple):
        return f"({', '.join(_shown(part) for part in value)}{',' if len(value) == 1 else ''})"
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        return repr(int(value))
    return repr(float(value)) if isinstance(value, numbers.Real) and not isinstance(value, bool) else repr(value)


def _check_list(perturbations: Sequence[Perturbation]) -> None:
    if not isinstance(perturbations, Sequence):
        raise InputError(f"perturbations are a {type(perturbations).__name__}, expected a list of perturbations")
    for perturbation in perturbations:
        if not isinstance(perturbation, get_args(Perturbation)):
            names = ", ".join(kind.__name__ for kind in get_args(Perturbation))
            raise InputError(f"perturbations hold a {type(perturbation).__name__}, expected some of {names}")
    for kind in SINGLE:
        if (n_given := len(list(_of_kind(perturbations, kind)))) > 1:
            raise InputError(f"perturbations hold {n_given} of {kind.__name__}, expected one at most")


def _of_kind(perturbations: Sequence[Perturbation], kind: type[Kind]) -> Iterator[Kind]:
    return (perturbation for perturbation in perturbations if isinstance(perturbation, kind))


def _integers(values: Iterator[int]) -> Integers:
    return np.array([min(int(value), NEVER) for value in values], np.int64)


def _end_step(interval: ClampCells | FreezeMemory) -> int:
    return NEVER if interval.end_step is None else interval.end_step


def _pack_clamps(clamps: list[ClampCells], dtype: DTypeLike) -> Clamps:
    """One entry for each clamped cell."""
    held = [
        (clamp, ROW[clamp.population] + cell)
        for clamp in clamps
        for cell in (range(N_CELLS[clamp.population]) if clamp.cells is None else clamp.cells)
    ]
    return Clamps(
        first_step=_integers(clamp.first_step for clamp, _ in held),
        end_step=_integers(_end_step(clamp) for clamp, _ in held),
        row=_integers(row for _, row in held),
        rate=np.array([clamp.rate for clamp, _ in held], dtype),
    )


def _pack_displacements(displacements: list[Displace], dtype: DTypeLike) -> Displacements:
    return Displacements(
        step=_integers(displacement.step for displacement in displacements),
        keep=np.array([0.0 if displacement.by is None else 1.0 for displacement in displacements], dtype),
        change=np.array([d.to if d.by is None else d.by for d in displacements], dtype).reshape(-1, 2),
    )


def _pack_memories(changes: list[SetMemory], memory_start: float, n_trials: int, dtype: DTypeLike) -> MemoryChanges:
    first_row, tables = 0, [np.empty((0, 16), dtype)]
    keep, first_rows, row_of_trial = [], [], []
    for setting in changes:
        table = np.atleast_2d(np.asarray(setting.memory))
        if len(table) not in (1, n_trials):
            raise InputError(
                f"memory to {setting.mode} has {len(table)} rows, expected 1 or one for each of {n_trials}"
            )
        if setting.mode != "replace":
            table = (table - memory_start) * (1.0 if setting.mode == "add" else -1.0)
        tables.append(table.astype(dtype))
        keep.append(0.0 if setting.mode == "replace" else 1.0)
        first_rows.append(first_row)
        row_of_trial.append(int(len(table) > 1))
        first_row += len(table)
    return MemoryChanges(
        step=_integers(setting.step for setting in changes),
        keep=np.array(keep, dtype),
        first_row=np.array(first_rows, np.int64),
        row_of_trial=np.array(row_of_trial, np.int64),
        change=np.concatenate(tables),
    )


def _pack_weights(noise: WeightNoise | None, circuit: PackedCircuit, trials: ArrayLike, seed: int) -> WeightChanges:
    mean = np.ascontiguousarray(circuit.wiring.weight[:, 0])
    sd = np.zeros_like(mean)
    if noise is None:
        return WeightChanges(False, 0.0, mean, sd, np.empty((0, 4), np.uint32))
    for projection in noise.projections or ():
        target = FIRST_TARGET[projection]
        first, end = circuit.wiring.first[[target, target + N_TARGETS[projection]]]
        sd[first:end] = noise.sd
    lowest_factor = 0.0 if noise.keep_signs else -np.inf
    return WeightChanges(True, lowest_factor, mean, sd, trial_streams(seed, trials, "weights"))


def _pack_turning(
    leg: str, angle: float | None, redraw_every: int | None, n_outbound: int, trials: ArrayLike, seed: int
) -> Turning:
    return Turning(
        is_on=bool(redraw_every or angle),
        angle=float(angle or 0.0),
        redraw_every=min(int(redraw_every or 0), NEVER),
        first_step=n_outbound if leg == "home" else 0,
        end_step=n_outbound if leg == "out" else NEVER,
        streams=trial_streams(seed, trials if redraw_every else [], "body"),
    )


def _pack_obstacles(perturbations: Sequence[Perturbation]) -> Reals:
    walls = [(*wall.start, *wall.end, SKIN) for wall in _of_kind(perturbations, Wall)]
    circles = [(*circle.centre, *circle.centre, circle.radius + SKIN) for circle in _of_kind(perturbations, Circle)]
    return np.array([*walls, *circles], float).reshape(-1, 5)
