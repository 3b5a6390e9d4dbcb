"""The ground: a square patch, level or with a gentle relief that is level where the animal walks."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import as_numbers, check_count, check_range, check_shape
from insectnav.worlds.shapes import quads
from insectnav.worlds.texture import texture
from insectnav.worlds.ways import distance_to_way

ROUGHEST = 3.0  # standard deviations of the noise that make up the height


@dataclass(frozen=True, kw_only=True)
class Relief:
    """Gentle hills, and the level disc or strip within them.

    Parameters
    ----------
    height : float
        Of the highest hill above the level part [m]; 0 is level ground.
    wavelength : float
        Size of the hills [m].
    level_within : float
        Half-width of what is level [m], about the origin or about a way.
    rise : float
        Distance over which the hills begin [m].
    way : tuple of x, y pairs [m]
        Way points; the level part is a strip along them. None is a disc about the origin.
    seed : int
        Of the noise.
    """

    height: float = 0.0  # [m]
    wavelength: float = 30.0  # [m]
    level_within: float = 0.0  # [m]
    rise: float = 10.0  # [m]
    way: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    seed: int = 0

    def __post_init__(self) -> None:
        check_range("height of the hills", self.height, 0.0, 100.0, "m")
        check_range("wavelength of the hills", self.wavelength, 0.1, 1000.0, "m")
        check_range("level_within", self.level_within, 0.0, 1000.0, "m")
        check_range("rise", self.rise, 0.01, 1000.0, "m")
        check_count("seed of the hills", self.seed, minimum=0)


LEVEL = Relief()


def ground_height(positions: npt.ArrayLike, relief: Relief = LEVEL) -> Floats:
    """Height of the ground, not negative, (...) array [m].

    Parameters
    ----------
    positions : (..., 2) array of x, y [m]

    Raises
    ------
    InputError
        If the positions are not pairs.
    """
    positions = np.asarray(as_numbers("positions", positions), dtype=np.float64)
    check_shape("positions", positions, (..., 2))
    if relief.height == 0.0:
        return np.zeros(positions.shape[:-1])
    points = np.concatenate([positions, np.zeros((*positions.shape[:-1], 1))], axis=-1)
    noise = texture(points, seed=relief.seed, coarsest=relief.wavelength, n_octaves=2)
    hills = np.clip(0.5 + 0.5 * noise / ROUGHEST, 0.0, 1.0)
    away = np.clip((distance_to_way(positions, relief.way) - relief.level_within) / relief.rise, 0.0, 1.0)
    return relief.height * hills * away * away * (3.0 - 2.0 * away)


def ground_patch(
    low: tuple[float, float], high: tuple[float, float], relief: Relief = LEVEL, *, tile: float = 2.0
) -> Floats:
    """Ground between two corners, seen from above as a grid of tiles, (triangle, 3, 3) [m].

    Parameters
    ----------
    low, high : x, y of the least and the greatest corner [m]
    tile : float
        Size of a tile [m] where the ground has a relief; level ground has 8 by 8 tiles.

    Raises
    ------
    InputError
        If the patch is empty or the tiles are too many.
    """
    sides = np.array(high, dtype=np.float64) - np.array(low, dtype=np.float64)
    check_range("sides of the ground", sides, 1e-3, 8000.0, "m")
    n = np.full(2, 8) if relief.height == 0.0 else np.ceil(sides / tile).astype(int)
    check_range("number of tiles along a side", n, 1, 1000)
    x, y = (low[axis] + sides[axis] * np.arange(n[axis] + 1) / n[axis] for axis in (0, 1))
    plane = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    corners = np.concatenate([plane, ground_height(plane, relief)[..., None]], axis=-1)
    return quads(np.stack([corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=2))
