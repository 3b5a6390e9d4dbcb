"""Trials in batches: an outbound route, then the way home as the circuit steers it."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from insectnav.agents.motion import MotionParams
from insectnav.agents.perturbation_packing import describe_perturbation
from insectnav.agents.perturbations import Perturbation
from insectnav.agents.simulation import TrialArrays, TrialParams, simulate_trials
from insectnav.central_complex import THESIS, CircuitParams, decode_home_vector
from insectnav.central_complex.layers import N_CELLS
from insectnav.checks import InputError

if TYPE_CHECKING:
    import xarray

CELL_DIMENSION = {16: ("cell",), 8: ("direction",), 2: ("side",), 1: ()}


def run_trials(
    routes: xarray.Dataset | tuple[ArrayLike, ArrayLike],
    circuit: CircuitParams = THESIS,
    motion: MotionParams = MotionParams(),  # noqa: B008 (frozen)
    n_inbound: int = 1500,
    noise: float | Mapping[str, float] = 0.1,
    seed: int = 0,
    record: Collection[str] = (),
    dtype: DTypeLike = "float32",
    perturbations: Sequence[Perturbation] = (),
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> xarray.Dataset:
    """Paths, memories and, on request, the activity of every cell over outbound routes and ways home.

    Parameters
    ----------
    routes : Dataset as from `random_routes`, or (heading (trial, step) [rad], velocity (trial, step, 2))
        Its trial coordinate says which noise a trial gets: any part of it runs as it does in the whole.
    circuit, motion : CircuitParams, MotionParams
    n_inbound : int
        Steps of the way home.
    noise : float, or dict of population name to float
        Standard deviation σ_r of the noise on each firing rate.
    seed : int
    record : collection of population names
        Adds their activity (trial, step, …); "motor" is the turn [rad]. Takes memory for every step and cell.
    dtype : {"float32", "float64"}
        float64 follows the published recursion to rounding, float32 is several times faster.
    perturbations : sequence of perturbations, any of `insectnav.agents.perturbations` and `insectnav.agents.obstacles`
    workers : int, optional
        Threads, by default one for each core. The result does not depend on it.
    progress : callable, optional
        Called with the number of trials just finished.

    Returns
    -------
    Dataset
        heading (trial, step) [rad] and position (trial, step, xy) [steps] from the nest at 0, 0: the outbound samples,
        the last of which is the turning point, then each inbound one after its turn and move; leg (step), "out" or
        "home". memory_at_turn (trial, cell); home_vector_at_turn (trial, xy) [steps], agent to nest as decoded;
        closest_distance (trial) [steps] to the nest on the way home, the turning point included.

    Raises
    ------
    InputError
        If shapes do not agree, a route is empty or not finite, or an option has an unknown value.

    Notes
    -----
    Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052. The first inbound step sees the turning point again.
    """
    heading, velocity, trials = _route_arrays(routes)
    params = TrialParams(
        circuit=circuit, motion=motion, n_inbound=n_inbound, noise=noise, seed=seed,
        record=record, dtype=dtype, perturbations=perturbations,
    )  # fmt: skip
    arrays = simulate_trials(heading, velocity, trials, params, workers=workers, progress=progress)
    return _dataset(arrays, params, np.asarray(trials))


def _route_arrays(routes: xarray.Dataset | tuple[ArrayLike, ArrayLike]) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
    if isinstance(routes, tuple | list):
        if len(routes) != 2:
            raise InputError(f"routes have {len(routes)} parts, expected a Dataset or (heading, velocity)")
        return *routes, np.arange(np.shape(routes[0])[0] if np.ndim(routes[0]) else 1)
    missing = [name for name in ("heading", "velocity", "trial") if name not in routes]
    if missing:
        raise InputError(f"routes have no {' and no '.join(missing)}, expected a Dataset as from random_routes")
    heading = routes["heading"].transpose("trial", "step").values
    return heading, routes["velocity"].transpose("trial", "step", "xy").values, routes["trial"].values


def _dataset(arrays: TrialArrays, params: TrialParams, trials: np.ndarray) -> xarray.Dataset:
    """Name the arrays and say in attributes how they came about."""
    import xarray

    n_steps = arrays.heading.shape[1]
    home_vector = decode_home_vector(arrays.memory_at_turn, params.circuit)
    variables: dict[str, Any] = {
        "heading": (("trial", "step"), arrays.heading, {"units": "rad", "zero": "+y", "positive": "clockwise"}),
        "position": (("trial", "step", "xy"), arrays.position, {"units": "steps"}),
        "memory_at_turn": (("trial", "cell"), arrays.memory_at_turn),
        "home_vector_at_turn": (("trial", "xy"), home_vector, {"units": "steps"}),
        "closest_distance": (("trial",), arrays.closest_distance, {"units": "steps"}),
    }
    for name, activity in split_recorded(arrays.activity, params.recorded).items():
        variables[name] = (("trial", "step", *CELL_DIMENSION[N_CELLS[name]]), activity)
    return xarray.Dataset(
        variables,
        coords={
            "trial": trials,
            "step": np.arange(n_steps),
            "xy": ["x", "y"],
            "leg": ("step", np.where(np.arange(n_steps) < n_steps - params.n_inbound, "out", "home")),
        },
        attrs=describe(params),
    )


def split_recorded(activity: np.ndarray, recorded: Sequence[str]) -> dict[str, np.ndarray]:
    """Recorded activity (trial, step, row) by population: (trial, step, cell), and (trial, step) for the turn."""
    parts, first = {}, 0
    for name in recorded:
        parts[name] = activity[..., first : first + N_CELLS[name]]
        first += N_CELLS[name]
    if "motor" in parts:
        parts["motor"] = parts["motor"][..., 0]
    return parts


def describe(params: TrialParams) -> dict[str, Any]:
    """Flat, JSON-ready description of what trials were run with."""
    description = {f"circuit_{name}": value for name, value in vars(params.circuit).items() if name != "connectivity"}
    description |= {f"motion_{name}": value for name, value in vars(params.motion).items()}
    if isinstance(params.noise, Mapping):
        noise: float | str = json.dumps({name: float(sigma) for name, sigma in params.noise.items()})
    else:
        noise = float(params.noise)
    description |= {"noise": noise, "seed": int(params.seed), "n_inbound": int(params.n_inbound)}
    return description | {
        "dtype": np.dtype(params.dtype).name,
        "perturbations": [describe_perturbation(perturbation) for perturbation in params.perturbations],
    }
