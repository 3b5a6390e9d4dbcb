"""Trips that end due south of the nest, and what is put in the way home: shared by Fig. 5a and the detours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.perturbations import Circle, Wall
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.agents.simulation import TrialArrays
from insectnav.angles import bearing, wrap
from insectnav.central_complex import CircuitParams
from insectnav.experiments.figures import COLOURS
from insectnav.experiments.stone2017_path_integration.straight_flights import fly
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, N_STEPS
from insectnav.metrics.path_integration import summary
from insectnav.metrics.search import NEVER
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OBSTACLES: dict[str, tuple[Any, ...]] = {  # between the nest at 0, 0 and turning points farther south
    "none": (),
    "circle": (Circle(centre=(4.0, -60.0), radius=25.0),),
    "wall": (Wall(start=(-60.0, -60.0), end=(90.0, -60.0)),),
    "both": (Circle(centre=(6.0, -50.0), radius=18.0), Wall(start=(-70.0, -95.0), end=(45.0, -95.0))),
    "ring": tuple(
        Circle(centre=(70.0 * float(np.sin(angle)), 70.0 * float(np.cos(angle))), radius=20.0)
        for angle in np.arange(8) * (np.pi / 4.0)
    ),
}
FARTHEST_SOUTH = 95.0  # [steps] of any obstacle
MARGIN = 25.0  # [steps] a turning point lies at least so much farther south


def turned(vectors: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Vectors (trial, ..., 2) turned clockwise, each trial by its own angle (trial,) [rad]."""
    by = by.reshape(-1, *[1] * (vectors.ndim - 2))
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([x * np.cos(by) + y * np.sin(by), y * np.cos(by) - x * np.sin(by)], axis=-1)


def trips_from_south(
    n_trials: int,
    circuit: CircuitParams,
    *,
    noise: float,
    seed: int,
    n_inbound: int = N_STEPS,
    perturbations: Sequence[Any] = (),
) -> tuple[TrialArrays, np.ndarray]:
    """Random trips, each turned about the nest so that home is due north at the turning point; the angles [rad].

    Parameters
    ----------
    n_trials : int
    circuit : CircuitParams
    noise : float
        σ_r of all cells.
    seed : int
        Routes are those of `random_trips`, but for the turn.
    n_inbound : int
    perturbations : sequence of perturbations
    """
    heading, velocity = route_arrays(n_trials, N_STEPS, RouteParams(), seed, "float64")
    by = wrap(np.pi - bearing(velocity.sum(axis=1)))
    # The compass is even all round to within its eight columns, so that turning a route changes little else.
    route = wrap(heading + by[:, None]).astype("float32"), turned(velocity, by).astype("float32")
    return fly(route, circuit, n_inbound=n_inbound, noise=noise, seed=seed, perturbations=perturbations), by


def way_walked(path: np.ndarray, last_step: np.ndarray) -> np.ndarray:
    """Length of each path (trial, step, 2) up to its last step, (trial,); NaN where that is -1."""
    steps = np.linalg.norm(np.diff(path.astype(float), axis=1), axis=-1)
    walked = np.concatenate([np.zeros((len(path), 1)), np.cumsum(steps, axis=1)], axis=1)
    return np.where(last_step == NEVER, np.nan, walked[np.arange(len(path)), last_step])


def home_arrays(arrays: TrialArrays, home: np.ndarray, arrival: np.ndarray) -> dict[str, tuple[Any, ...]]:
    """Where each way home (trial, step, 2) began, how near it came to the nest, and its length, as cells keep them.

    Parameters
    ----------
    arrays : TrialArrays
    home : of the same trials
    arrival : (trial,) step at which each is in the home range, as of `first_arrival`
    """
    start = np.linalg.norm(home[:, 0], axis=-1)
    where = {"long_name": "the obstacles lie between the turning point and the nest"}
    return {
        "is_beyond": (("trial",), start > FARTHEST_SOUTH + MARGIN, where),
        "start_distance": (("trial",), start, {"units": "steps"}),
        "closest_distance": (("trial",), arrays.closest_distance, {"units": "steps"}),
        "walked": (("trial",), way_walked(home, arrival), {"units": "steps"}),
    }


def detour(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Way walked over straight way, both to the home range, of the trials that began beyond the obstacles."""
    beyond = arrays["is_beyond"]
    return arrays["walked"][beyond] / (arrays["start_distance"][beyond] - HOME_RANGE)


def home_findings(arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Number of trials that began beyond the obstacles, how near they came and how directly."""
    closest = arrays["closest_distance"][arrays["is_beyond"]]
    return {
        "n": closest.size,
        "mean_closest_distance": summary(closest).mean,
        "median_closest_distance": summary(closest).median,
        "closest_distance_standard_error": bootstrap_error(closest, np.median),
        "within_home_range": float(np.mean(closest <= HOME_RANGE)),
        "median_way_over_straight": summary(detour(arrays)).median,
    }


def draw_shares(axes: Axes, values: np.ndarray, **look: Any) -> None:
    """Share of all trials up to each value [%]; a trial without a value never comes."""
    ordered = np.sort(values[np.isfinite(values)])
    axes.plot(ordered, 100.0 * np.arange(1, ordered.size + 1) / values.size, **look)


def draw_obstacles(axes: Axes, obstacles: Sequence[Any]) -> None:
    """Circles as discs and walls as lines."""
    from matplotlib import patches

    for obstacle in obstacles:
        if isinstance(obstacle, Circle):
            x, y = obstacle.centre
            look: dict[str, Any] = {"facecolor": "0.8", "edgecolor": COLOURS["grey"], "linewidth": 0.5}
            axes.add_patch(patches.Circle((x, y), obstacle.radius, **look))
        else:
            (x0, y0), (x1, y1) = obstacle.start, obstacle.end
            axes.plot([x0, x1], [y0, y1], color=COLOURS["grey"], linewidth=2.5, solid_capstyle="butt")
