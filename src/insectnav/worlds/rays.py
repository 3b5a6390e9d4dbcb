"""Rays along any directions: what they meet, by Embree."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import InputError
from insectnav.worlds.world import World

SKY, GROUND = -1, -2  # in place of the index of a triangle
_scenes: WeakKeyDictionary[World, Any] = WeakKeyDictionary()


def cast_rays(world: World, position: Floats, rays: Floats) -> tuple[npt.NDArray[np.int32], Floats]:
    """Triangle and distance (view, ray) [m] of what each ray meets first.

    Parameters
    ----------
    world : World
    position : (view, 3) array [m] above the ground
    rays : (view, ray, 3) array of unit vectors in the world

    Returns
    -------
    triangle : (view, ray) array of int32, -1 for the sky and -2 for the level ground
    distance : (view, ray) array [m], infinite for the sky

    Raises
    ------
    InputError
        If embreex is not installed.

    Notes
    -----
    Embree (Wald et al. 2014, doi 10.1145/2601097.2601199), in single precision.
    """
    scene = _scene(world)
    starts = np.ascontiguousarray(np.broadcast_to(position[:, None], rays.shape).reshape(-1, 3), np.float32)
    triangle = np.full(rays.shape[:-1], SKY, np.int32)
    distance = np.full(rays.shape[:-1], np.inf)
    if starts.size:
        hit = scene.run(starts, np.ascontiguousarray(rays.reshape(-1, 3), np.float32), output=True)
        triangle = hit["primID"].reshape(rays.shape[:-1]).astype(np.int32)
        distance = np.where(triangle >= 0, hit["tfar"].reshape(triangle.shape), np.inf).astype(np.float64)
    below = (triangle < 0) & (rays[..., 2] < 0)
    triangle[triangle < 0] = SKY
    triangle[below] = GROUND
    distance[below] = (-position[:, None, 2] / np.where(below, rays[..., 2], -1.0))[below]
    return triangle, distance


def _scene(world: World) -> Any:
    """Embree's scene of a world, built once."""
    if world not in _scenes:
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError:
            raise InputError(
                "rays need the package embreex, which is not installed: pip install 'insectnav[rays]'"
            ) from None
        scene = EmbreeScene()
        TriangleMesh(scene, np.array(world.mesh.vertices))
        _scenes[world] = scene
    return _scenes[world]
