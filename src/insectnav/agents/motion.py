"""How an agent moves: drag, thrust along the heading, and a turn before each step."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import unit_vector, wrap
from insectnav.checks import check_range, check_shape

Reals = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class MotionParams:
    """Constants of the agent's motion on the way home.

    Raises
    ------
    InputError
        If a number is out of its range.

    Notes
    -----
    Stone et al. 2017, Methods, doi 10.1016/j.cub.2017.08.052. The terminal speed is a (1 − F_D) / F_D = 0.567.
    """

    drag: float = 0.15  # F_D
    acceleration: float = 0.1  # [steps per time step²] a

    def __post_init__(self) -> None:
        check_range("drag", self.drag, 0.0, 1.0)
        check_range("acceleration", self.acceleration, 0.0, 100.0, "steps per time step squared")


def move(heading: ArrayLike, velocity: ArrayLike, turn: ArrayLike, params: MotionParams) -> tuple[Reals, Reals]:
    """Heading and velocity after one step; the new position is the old one plus the new velocity.

    Parameters
    ----------
    heading : (...) array [rad]
        Clockwise from +y.
    velocity : (..., 2) array [steps per time step]
    turn : (...) array [rad]
        Positive to the right.
    params : MotionParams

    Raises
    ------
    InputError
        If shapes do not agree.

    Notes
    -----
    θ' = θ + turn; v' = (1 − F_D) · (v + a · (sin θ', cos θ')). Stone et al. 2017, Methods.
    """
    heading = wrap(np.asarray(heading) + np.asarray(turn))
    velocity = np.asarray(velocity)
    check_shape("velocity", velocity, (*np.shape(heading), 2))
    return heading, (1.0 - params.drag) * (velocity + params.acceleration * unit_vector(heading))
