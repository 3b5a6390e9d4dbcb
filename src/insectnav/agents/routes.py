"""Random foraging trips: smooth turns and speeds, as filtered noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike, NDArray

from insectnav.agents.turns import von_mises_series
from insectnav.checks import check_count, check_precision, check_range
from insectnav.lanes import empty_rows
from insectnav.rng import trial_streams

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, kw_only=True)
class RouteParams:
    """Constants of random outbound routes.

    Raises
    ------
    InputError
        If a number is out of its range.

    Notes
    -----
    Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052.
    """

    turn_concentration: float = 100.0  # κ of the von Mises distribution of turns
    turn_persistence: float = 0.4  # λ, share of a turn that carries over to the next
    lowest_acceleration: float = 0.0  # [steps per time step²]
    highest_acceleration: float = 0.15  # [steps per time step²]
    steps_per_knot: int = 50  # a new random acceleration every so many steps, and 4 in routes of 200 steps or fewer
    drag: float = 0.15  # F_D

    def __post_init__(self) -> None:
        check_range("turn_concentration", self.turn_concentration, 1e-3, 1e8)
        check_range("turn_persistence", self.turn_persistence, -0.999, 0.999)
        check_range("lowest_acceleration", self.lowest_acceleration, -100.0, 100.0, "steps per time step squared")
        check_range("highest_acceleration", self.highest_acceleration, -100.0, 100.0, "steps per time step squared")
        check_count("steps_per_knot", self.steps_per_knot)
        check_range("drag", self.drag, 0.0, 1.0)


def random_routes(
    n_trials: int,
    n_steps: int,
    params: RouteParams = RouteParams(),
    seed: int = 0,
    dtype: DTypeLike = "float64",
) -> xarray.Dataset:
    """Outbound routes from the nest: heading (trial, step) [rad], velocity (trial, step, xy) [steps per time step].

    Parameters
    ----------
    n_trials, n_steps : int
        At least one of each. The first step is the nest itself: at rest, heading 0.
    params : RouteParams
    seed : int
        Route k depends on the seed and k alone, not on how many routes there are.
    dtype : {"float64", "float32"}
        Of the result; computed in double precision.

    Raises
    ------
    InputError
        If a count or the seed is not a whole number, or too small.

    Notes
    -----
    r_t = λ r_(t−1) + ε_t with ε_t ~ von Mises(0, κ), θ_t = θ_(t−1) + r_t, and v_t = (1 − F_D) (v_(t−1) + a_t (sin θ_t,
    cos θ_t)). The acceleration a_t runs through uniform random values evenly spaced in time, by not-a-knot cubic
    splines, and is not clipped between them. Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052.
    """
    import xarray

    heading, velocity = route_arrays(n_trials, n_steps, params, seed, dtype)
    return xarray.Dataset(
        {
            "heading": (("trial", "step"), heading, {"units": "rad", "zero": "+y", "positive": "clockwise"}),
            "velocity": (("trial", "step", "xy"), velocity, {"units": "steps per time step"}),
        },
        coords={"trial": np.arange(n_trials), "step": np.arange(n_steps), "xy": ["x", "y"]},
        attrs={"seed": seed, **{f"route_{name}": value for name, value in vars(params).items()}},
    )


def route_arrays(
    n_trials: int,
    n_steps: int,
    params: RouteParams,
    seed: int,
    dtype: DTypeLike = "float64",
    *,
    first_trial: int = 0,
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Headings (trial, step) and velocities (trial, step, 2): `random_routes` without the names.

    From trial ``first_trial`` on: any part of the routes is as it is in the whole.
    """
    from insectnav.agents.route_kernel import make_routes

    check_count("n_trials", n_trials)
    check_count("n_steps", n_steps)
    check_count("first_trial", first_trial, minimum=0)
    dtype = check_precision("dtype", dtype)
    n_knots = max(4, n_steps // params.steps_per_knot if n_steps > 200 else 4)  # fewer do not make a cubic
    heading = np.empty((n_trials, n_steps), dtype)
    velocity = np.empty((n_trials, n_steps, 2), dtype)
    make_routes(
        0,
        n_trials,
        trial_streams(seed, first_trial + np.arange(n_trials), "routes"),
        von_mises_series(params.turn_concentration),
        n_knots,
        params.lowest_acceleration,
        params.highest_acceleration,
        params.turn_persistence,
        params.drag,
        empty_rows(3 * n_knots + 3, "float64"),
        empty_rows(4, np.uint32),
        heading,
        velocity,
    )
    return heading, velocity
