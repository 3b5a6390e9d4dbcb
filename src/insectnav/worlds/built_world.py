"""What every builder returns: the surfaces, a way through them, and what they were made from."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.records import Mesh
from insectnav.worlds.ground import LEVEL, Relief, ground_height


@dataclass(frozen=True, kw_only=True, eq=False)
class BuiltWorld:
    """A world that was built from a seed and a few parameters.

    Parameters
    ----------
    mesh : Mesh
        Surfaces in metres, a material for each triangle.
    route : (n, 2) array of x, y [m]
        Way points of a walk on free ground; a loop ends where it begins.
    name : str
        Of the builder.
    parameters : frozen dataclass
        What it was built with.
    seed : int
        Of its random numbers.
    relief : Relief
        Shape of the ground; level by default.
    """

    mesh: Mesh
    route: Floats
    name: str
    parameters: Any
    seed: int
    relief: Relief = LEVEL

    def __post_init__(self) -> None:
        route = np.array(self.route, dtype=np.float64)
        route.setflags(write=False)
        object.__setattr__(self, "route", route)

    def ground_height(self, positions: npt.ArrayLike) -> Floats:
        """Height of the ground at positions (..., 2) of x, y [m], (...) array [m]."""
        return ground_height(positions, self.relief)
