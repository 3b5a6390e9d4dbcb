"""Trees over stretches of the walk: the paper's fails under trees, and those of the built city stand aside of it."""

from dataclasses import replace

import numpy as np

from insectnav.records import Mesh
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.plants import on_ground, trees
from insectnav.worlds.shapes import generator, mesh_from
from insectnav.worlds.traverse import along, way_length

STRETCHES = ((0.12, 0.17), (0.45, 0.50), (0.78, 0.83))  # [share of the way] with trees: about 300 m, assumed
SPACING, ASIDE = 8.0, 2.0  # [m] from tree to tree, and to the right of the way; assumed
HEIGHTS = (9.0, 13.0)  # [m] assumed; crowns of 3 m then reach over the walk


def with_street_trees(city: BuiltWorld, foliage: float) -> BuiltWorld:
    """The same city with a row of trees at the right of the way, on three stretches of it."""
    length = way_length(city.route)
    places = np.concatenate([np.arange(first * length, last * length, SPACING) for first, last in STRETCHES])
    position, course = along(city.route, places)
    feet = position + ASIDE * np.stack([np.cos(course), -np.sin(course)], axis=-1)
    rng = generator(city.seed, "trees over the walk")
    heights = HEIGHTS[0] + (HEIGHTS[1] - HEIGHTS[0]) * rng.random(len(feet))
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
