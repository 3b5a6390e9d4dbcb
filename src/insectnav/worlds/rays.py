"""Views along any directions, by casting rays: for eyes whose directions are no panorama."""

from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import InputError, as_numbers, check_choice, check_finite, check_shape
from insectnav.vision.sphere import check_directions, rotation_matrix, to_world
from insectnav.worlds.renderer import Layers, check_size
from insectnav.worlds.solids import check_outside_solids
from insectnav.worlds.world import World, check_positions

LAYERS = ("sky", "alpha", "nearness", "depth", "triangle")
RAYS_AT_ONCE = 1 << 18
SKY, GROUND = -1, -2  # in place of the index of a triangle
_scenes: WeakKeyDictionary[World, Any] = WeakKeyDictionary()


def render(
    world: World,
    positions: npt.ArrayLike,
    headings: npt.ArrayLike,
    pitch: npt.ArrayLike = 0.0,
    roll: npt.ArrayLike = 0.0,
    *,
    directions: npt.ArrayLike,
    band: str = "grey",
) -> npt.NDArray[np.float32]:
    """Brightness (n, ...) in 0…1 along each direction of a turned and tilted eye, one ray a direction.

    Parameters
    ----------
    world : World
    positions : (n, 2 or 3) array of x, y and perhaps z [m]; an eye without z is 0.01 m above the ground
    headings, pitch, roll : (n,) arrays, or one for all [rad], as of `insectnav.vision.sphere.rotation_matrix`
    directions : (..., 3) array of unit vectors in the frame of the eye: x right, y ahead, z up
    band : one of `world.bands`

    Raises
    ------
    InputError
        If a position is outside the world or inside a solid, or embreex is not installed.

    Notes
    -----
    Rays by Embree (Wald et al. 2014, ACM Transactions on Graphics 33: 143), in single precision. For panoramas of level
    eyes `insectnav.worlds.render_panorama` gives the same and is several times as fast.
    """
    check_choice("band", band, world.bands)
    return render_rays(world, positions, headings, pitch, roll, directions=directions, layers=(band,))[band]


def render_rays(
    world: World,
    positions: npt.ArrayLike,
    headings: npt.ArrayLike,
    pitch: npt.ArrayLike = 0.0,
    roll: npt.ArrayLike = 0.0,
    *,
    directions: npt.ArrayLike,
    layers: Sequence[str],
) -> Layers:
    """Several values of the same rays, by name: bands of the world, and what else is known of each ray.

    Parameters
    ----------
    layers : bands, and any of "sky", "alpha", "nearness", "depth" and "triangle", as of
        `insectnav.worlds.render_layers`
    world, positions, headings, pitch, roll, directions
        As of `render`.

    Returns
    -------
    name → (n, ...) array of float32, int32 for "triangle"

    Raises
    ------
    InputError
        If a layer is unknown, or as `render`.
    """
    for layer in layers:
        check_choice("layer", layer, (*world.bands, *LAYERS))
    position, rotation, look = _check_eyes(world, positions, (headings, pitch, roll), directions)
    n_views, n_rays = len(position), len(look)
    check_size((n_views, n_rays), len(layers))
    found: Layers = {
        layer: np.empty((n_views, n_rays), np.int32 if layer == "triangle" else np.float32) for layer in layers
    }
    at_once = max(1, RAYS_AT_ONCE // max(n_rays, 1))
    sees_sky = np.zeros(n_views, np.bool_)
    for first in range(0, n_views, at_once):
        chosen = slice(first, first + at_once)
        rays = to_world(look, rotation[chosen, None])
        triangle, distance = _cast(world, position[chosen], rays)
        sees_sky[chosen] = ((triangle == SKY) | (rays[..., 2] < 0).all(axis=-1, keepdims=True)).any(axis=-1)
        below = triangle == GROUND
        with np.errstate(divide="ignore"):
            distance[below] = (-position[chosen, None, 2] / rays[..., 2])[below]
        for layer in layers:
            found[layer][chosen] = _layer(world, layer, triangle, distance)
    check_outside_solids(world, position, ~sees_sky)
    shape = np.shape(directions)[:-1]
    return {layer: values.reshape(n_views, *shape) for layer, values in found.items()}


def _check_eyes(
    world: World, positions: npt.ArrayLike, angles: tuple[npt.ArrayLike, ...], directions: npt.ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Positions (n, 3), rotations (n, 3, 3) and directions (ray, 3)."""
    position = check_positions(world, positions)
    given = []
    for name, angle in zip(("headings", "pitch", "roll"), angles, strict=True):
        array = as_numbers(name, angle).astype(np.float64)
        if array.ndim:
            check_shape(name, array, (len(position),))
        check_finite(name, array)
        given.append(np.broadcast_to(array, len(position)))
    look = np.asarray(check_directions("directions", directions), dtype=np.float64).reshape(-1, 3)
    return position, np.asarray(rotation_matrix(*given), dtype=np.float64), look


def _layer(world: World, layer: str, triangle: npt.NDArray[Any], distance: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values of one layer, of the triangle and the distance along each ray."""
    if layer == "triangle":
        return triangle
    if layer == "depth":
        return distance
    if layer == "nearness":
        return 1 / distance
    if layer == "alpha":
        return triangle >= 0
    if layer == "sky":
        return triangle == SKY
    values = np.append(world.brightness[layer], np.array([world.ground[layer], world.sky[layer]], np.float32))
    return values[triangle]  # the last two for the indices -2 and -1


def _cast(world: World, position: Floats, rays: Floats) -> tuple[npt.NDArray[np.int32], Floats]:
    """Triangle and distance (view, ray) of the first hit; infinite where there is none."""
    scene = _scene(world)
    starts = np.ascontiguousarray(np.broadcast_to(position[:, None], rays.shape).reshape(-1, 3), np.float32)
    hit = scene.run(starts, np.ascontiguousarray(rays.reshape(-1, 3), np.float32), output=True)
    triangle = hit["primID"].reshape(rays.shape[:-1]).astype(np.int32)
    distance = np.where(triangle >= 0, hit["tfar"].reshape(triangle.shape), np.inf).astype(np.float64)
    triangle[triangle < 0] = np.where(rays[..., 2] >= 0, SKY, GROUND)[triangle < 0]
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
