"""Obstacles on the way home, as data.

Where an agent's next move would enter a circle or cross a wall, it is deflected along the surface: it moves at right
angles to the line from the nearest point of the obstacle, with the speed it had, on the side nearer to its motion, and
its heading becomes that direction. It keeps that side for as long as it is within a step of the obstacle (within one
move where that is farther), as an animal does that follows an edge; otherwise it would go to and fro for ever at the
foot of a wall. Where two obstacles leave no way on that side, it turns round; where they leave none at all, it stands
still. No move passes through at any speed, and a hundredth of a step is always left to the surface. An agent that finds
itself inside, as after being carried there, is put on the surface first.

The circuit goes on integrating what the animal really does: Stone et al. 2017, Fig. 5a (inset), doi
10.1016/j.cub.2017.08.052. The rule is ours; the source does not give its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from insectnav.checks import InputError, as_numbers, check_finite, check_range, check_shape


@dataclass(frozen=True, kw_only=True)
class Circle:
    """A round obstacle on the way home; `insectnav.agents.obstacles` says what an agent does there.

    Parameters
    ----------
    centre : (2,) sequence [steps]
    radius : float [steps]

    Raises
    ------
    InputError
        If the centre is no finite point or the radius is not positive.
    """

    centre: Sequence[float]
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", point("centre of the circle", self.centre))
        check_shape("radius of the circle", np.asarray(self.radius), ())
        check_range("radius of the circle", self.radius, 1e-6, 1e9, "steps")


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A straight obstacle on the way home; `insectnav.agents.obstacles` says what an agent does there.

    Parameters
    ----------
    start, end : (2,) sequences [steps]

    Raises
    ------
    InputError
        If an end is no finite point, or both are the same.
    """

    start: Sequence[float]
    end: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", point("start of the wall", self.start))
        object.__setattr__(self, "end", point("end of the wall", self.end))
        if self.start == self.end:
            raise InputError(f"wall starts and ends at {self.start[0]:g}, {self.start[1]:g}, expected two points")


def point(name: str, coordinates: Sequence[float]) -> tuple[float, ...]:
    """Coordinates (2,) [steps] as two finite numbers.

    Raises
    ------
    InputError
        If they are anything else.
    """
    array = as_numbers(name, coordinates)
    check_shape(name, array, (2,))
    check_finite(name, array)
    return tuple(array.astype(float).tolist())
