"""Trees over stretches of the walk: the paper's fails under trees, and those of the built city stand aside of it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.records import Mesh
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.plants import on_ground, trees
from insectnav.worlds.shapes import generator, mesh_from
from insectnav.worlds.traverse import along, way_length


@dataclass(frozen=True, kw_only=True)
class Planting:
    """Trees along stretches of the way; all numbers are assumed.

    Parameters
    ----------
    stretches : first and last share of the way
    spacing : from tree to tree [m]
    asides : of the rows, to the right of the way [m]
    heights : least and greatest [m]
    """

    stretches: tuple[tuple[float, float], ...]
    spacing: float
    asides: tuple[float, ...]
    heights: tuple[float, float]

    def covers(self, share: ArrayLike) -> NDArray[np.bool_]:
        """Which places are on one of the stretches, by the share of the way that is behind them."""
        share = np.asarray(share)
        return np.any([(first <= share) & (share <= last) for first, last in self.stretches], axis=0)


# About 300 m in all; crowns of 3 m then reach to the walk.
ROW = Planting(stretches=((0.12, 0.17), (0.45, 0.50), (0.78, 0.83)), spacing=8.0, asides=(2.0,), heights=(9.0, 13.0))
# About 580 m in all, each stretch longer than a sequence of ten frames; crowns of 3 to 4.2 m meet over the walk.
CROWNS = Planting(
    stretches=((0.10, 0.20), (0.42, 0.52), (0.74, 0.84)), spacing=5.0, asides=(2.5, -2.5), heights=(10.0, 14.0)
)
PLANTINGS = {"none": None, "row": ROW, "crowns": CROWNS}


def with_street_trees(city: BuiltWorld, foliage: float, planting: Planting) -> BuiltWorld:
    """The same city with rows of trees along stretches of the way."""
    length = way_length(city.route)
    places = np.concatenate(
        [np.arange(first * length, last * length, planting.spacing) for first, last in planting.stretches]
    )
    position, course = along(city.route, places)
    right = np.stack([np.cos(course), -np.sin(course)], axis=-1)
    feet = np.concatenate([position + aside * right for aside in planting.asides])
    rng = generator(city.seed, "trees over the walk")
    low, high = planting.heights
    heights = low + (high - low) * rng.random(len(feet))
    return replace(city, mesh=_joined(city.mesh, mesh_from(trees(rng, on_ground(feet), heights, foliage=foliage), "")))


def _joined(first: Mesh, second: Mesh) -> Mesh:
    """Both meshes as one, with the name of the first."""
    materials = tuple(dict.fromkeys((*first.materials, *second.materials)))
    number = [np.array([materials.index(name) for name in mesh.materials]) for mesh in (first, second)]
    index = [of[np.asarray(mesh.material)] for of, mesh in zip(number, (first, second), strict=True)]
    return replace(
        first,
        vertices=np.concatenate([first.vertices, second.vertices]),
        material=np.concatenate(index).astype(np.int32),
        materials=materials,
    )
