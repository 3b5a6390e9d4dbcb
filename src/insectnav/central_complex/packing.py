"""Circuit constants and wiring in the form that compiled kernels read."""

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from insectnav.central_complex.connectivity import DIRECTIONS, PROJECTIONS
from insectnav.central_complex.layers import N_CELLS, N_NOISY, N_ROWS, POPULATIONS_WITH_RATE, ROW, rows
from insectnav.central_complex.parameters import MEMORY_RULES, STEERING_RULES, CircuitParams
from insectnav.checks import check_choice, check_range, check_shape
from insectnav.lanes import empty_rows


class Constants(NamedTuple):
    """Scalars of `CircuitParams`; rules as indices into their tables, slopes and biases in units of ln 2."""

    is_sigmoid: bool
    is_flow_averaged: bool
    is_noisy: bool
    has_pontine: bool
    memory_rule: int
    steering_rule: int
    tl_slope: float
    tl_bias: float
    cl1_slope: float
    cl1_bias: float
    tb1_slope: float
    tb1_bias: float
    cpu4_slope: float
    cpu4_bias: float
    pontine_slope: float
    pontine_bias: float
    cpu1_slope: float
    cpu1_bias: float
    tn_cosine: float
    tn_sine: float
    memory_gain: float
    memory_loss: float
    flow_share: float  # of the present flow in what TN cells are given; 1 without a filter
    is_filter_noisy: bool


class Wiring(NamedTuple):
    """Synapses sorted by projection and receiving cell.

    Receiving cell c of projection p is target ``FIRST_TARGET[p] + c``; its synapses are ``first[target]`` up to
    ``first[target + 1]``. ``row`` is the row of the sending cell in the array of activities.
    """

    first: NDArray[np.int64]  # (target + 1,)
    row: NDArray[np.int64]  # (synapse,)
    weight: NDArray[np.floating]  # (synapse, LANES)
    preferred_cosine: NDArray[np.floating]  # (8,) of the TL cells
    preferred_sine: NDArray[np.floating]  # (8,)


_STRENGTHS = {"tl_to_cl1": -1.0, "cpu4_to_pontine": 1.0, "tn_to_cpu4": 1.0, "tb1_to_cpu4": 1.0}
N_TARGETS = {name: 2 if target == "motor" else N_CELLS[target] for name, (target, _) in PROJECTIONS.items()}
FIRST_TARGET = dict(zip(N_TARGETS, np.cumsum([0, *N_TARGETS.values()])[:-1].tolist(), strict=True))


def _strength(params: CircuitParams, projection: str) -> float:
    if projection == "cpu1_to_motor":
        return params.motor_gain
    if projection in _STRENGTHS:
        return _STRENGTHS[projection]
    return getattr(params, f"{projection}_strength")


def pack_wiring(params: CircuitParams, dtype: DTypeLike) -> Wiring:
    """Synapses with a weight other than zero, each weight repeated for every lane."""
    first: list[int] = [0]
    row: list[int] = []
    weight: list[float] = []
    for projection, (_, source) in PROJECTIONS.items():
        matrix = _strength(params, projection) * getattr(params.connectivity, projection)
        for synapses in matrix:
            senders = np.flatnonzero(synapses)
            if senders.size == 0:
                senders = np.zeros(1, int)  # the kernel wants at least one: a silent one
            row.extend(ROW[source] + senders)
            weight.extend(synapses[senders])
            first.append(len(row))
    lanes = empty_rows(len(weight), dtype)
    lanes[:] = np.array(weight)[:, None]
    cosine, sine = np.cos(DIRECTIONS).astype(dtype), np.sin(DIRECTIONS).astype(dtype)
    return Wiring(np.array(first), np.array(row, np.int64), lanes, cosine, sine)


def pack_constants(params: CircuitParams, noise: NDArray[np.floating]) -> Constants:
    """Scalars for the kernel; without noise it draws no random numbers."""
    same_name = {name: getattr(params, name) for name in Constants._fields if hasattr(params, name)}
    same_name |= {name: value / np.log(2.0) for name, value in same_name.items() if name.endswith(("_slope", "_bias"))}
    computed = {
        "is_noisy": bool(np.any(noise != 0.0)),
        "has_pontine": params.pontine_to_cpu1_strength != 0.0,
        "memory_rule": MEMORY_RULES.index(params.memory_rule),
        "steering_rule": STEERING_RULES.index(params.steering_rule),
        "tn_cosine": float(np.cos(params.tn_preference)),
        "tn_sine": float(np.sin(params.tn_preference)),
        "flow_share": 1.0,
        "is_filter_noisy": False,
    }
    return Constants(**(same_name | computed))


def pack_noise(noise: float | Mapping[str, float], dtype: DTypeLike) -> NDArray[np.floating]:
    """Standard deviation of the noise of each cell, (N_NOISY,), from one number or one for each named population."""
    levels = noise if isinstance(noise, Mapping) else dict.fromkeys(POPULATIONS_WITH_RATE, noise)
    packed = np.zeros(N_NOISY, dtype)
    for population, sigma in levels.items():
        check_choice("population with noise", population, POPULATIONS_WITH_RATE)
        check_range(f"noise of {population}" if isinstance(noise, Mapping) else "noise", sigma, 0.0, 10.0)
        packed[rows(population)] = sigma
    return packed


class PackedCircuit(NamedTuple):
    """All that a kernel needs to know of a circuit."""

    wiring: Wiring
    constants: Constants
    noise: NDArray[np.floating]  # (N_NOISY,) standard deviations


def pack_circuit(params: CircuitParams, noise: float | Mapping[str, float], dtype: DTypeLike) -> PackedCircuit:
    """Circuit with the given noise, packed once and remembered.

    Raises
    ------
    InputError
        If a noise is negative, or given for a population that does not exist.
    """
    if isinstance(noise, Mapping):
        return _packed(params, tuple(sorted(noise.items())), np.dtype(dtype).name)
    check_shape("noise", np.asarray(noise), ())
    return _packed(params, noise, np.dtype(dtype).name)


@lru_cache(maxsize=64)
def _packed(params: CircuitParams, noise: float | tuple, dtype: str) -> PackedCircuit:
    levels = pack_noise(dict(noise) if isinstance(noise, tuple) else noise, dtype)
    return PackedCircuit(pack_wiring(params, dtype), pack_constants(params, levels), levels)


class Workspace(NamedTuple):
    """Arrays in which a kernel works on 16 circuits; no two threads may share one."""

    rows: NDArray[np.floating]  # (N_ROWS, LANES) activities, rows as in `layers.ROW`
    lateral: NDArray[np.floating]  # (8, LANES)
    sample: NDArray[np.floating]  # (3, LANES)
    stream: NDArray[np.uint32]  # (4, LANES) random number generators
    held: NDArray[np.floating]  # (N_NOISY,) rates that cells are held at; negative for free cells
    flow: NDArray[np.floating]  # (2, LANES) filtered flow, right and left


def new_workspace(dtype: DTypeLike) -> Workspace:
    """Work space with all cells free."""
    return Workspace(
        rows=empty_rows(N_ROWS, dtype),
        lateral=empty_rows(8, dtype),
        sample=empty_rows(3, dtype),
        stream=empty_rows(4, np.uint32),
        held=np.full(N_NOISY, -1.0, dtype),
        flow=empty_rows(2, dtype),
    )
