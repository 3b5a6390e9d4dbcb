"""What most experiments of the paper have in common: random trips out and the way home, and how they are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.agents.simulation import TrialArrays
from insectnav.central_complex import CircuitParams
from insectnav.experiments.figures import COLOURS
from insectnav.experiments.stone2017_path_integration.straight_flights import fly

if TYPE_CHECKING:
    from matplotlib.axes import Axes

N_STEPS = 1500  # Methods: length of a trip out, and of the way home
HOME_RANGE = 20.0  # [steps] Ext. Data Fig. 8: the range round the nest that counts as found
NOISE_LEVELS = (0.0, 0.1, 0.2, 0.3, 0.4)  # σ_r, Methods
NOISE_COLOURS = dict(zip(NOISE_LEVELS, ("black", "blue", "green", "orange", "red"), strict=True))
PRESET_NAMES = {"thesis": "thesis constants", "code-2017": "2017 code's constants"}
PRESET_LINES = {"thesis": "-", "code-2017": "--"}


def random_trips(
    n_trials: int,
    circuit: CircuitParams,
    *,
    noise: float,
    seed: int,
    n_outbound: int = N_STEPS,
    n_inbound: int | None = None,
    route: RouteParams = RouteParams(),  # noqa: B008 (frozen)
    perturbations: Sequence[Any] = (),
    record: Sequence[str] = (),
) -> TrialArrays:
    """Trips along random routes and the ways home, as long as out unless told otherwise.

    Parameters
    ----------
    n_trials : int
    circuit : CircuitParams
    noise : float
        σ_r of all cells.
    seed : int
        Trial k has the same route and the same noise in all cells of a grid: what differs is the condition's doing.
    n_outbound, n_inbound : int
    route : RouteParams
    perturbations : sequence of perturbations
    record : names of populations
    """
    return fly(
        route_arrays(n_trials, n_outbound, route, seed, "float32"),
        circuit,
        n_inbound=n_outbound if n_inbound is None else n_inbound,
        noise=noise,
        seed=seed,
        record=record,
        perturbations=perturbations,
    )


def example_trip(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Heading (1, step) [rad] and velocity (1, step, 2) of the trip of Fig. 5a and b: trial 0 of `random_trips`."""
    return route_arrays(1, N_STEPS, RouteParams(), seed, "float32")


def ways_home(arrays: TrialArrays, n_inbound: int) -> np.ndarray:
    """Paths (trial, step, 2) from the turning point on."""
    return arrays.position[:, arrays.position.shape[1] - n_inbound - 1 :]


def draw_home_range(axes: Axes, radius: float = HOME_RANGE) -> None:
    """The nest and the dashed circle round it."""
    from matplotlib.patches import Circle

    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, linestyle="--", linewidth=0.7, edgecolor=COLOURS["grey"]))
    axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", markersize=3.5, linestyle="none", zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (steps)")
    axes.set_ylabel("y (steps)")
