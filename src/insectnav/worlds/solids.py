"""Whether an eye is inside a solid, where there is nothing to see."""

from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import InputError
from insectnav.worlds.world import World

N_RAYS, N_RAYS_OF_PROOF = 33, 330  # to suspect and to be sure: of 33, seven in ten are odd by chance at 1 % of leaves
INSIDE = 0.7  # share of rays that cross an odd number of triangles; measured: houses 0.73 to 1, under trees below 0.5
RAYS_AT_ONCE = 8
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def check_outside_solids(world: World, position: Floats, is_suspect: npt.NDArray[np.bool_]) -> None:
    """Refuse an eye inside a solid or below the surface of a ground that is part of the mesh.

    Parameters
    ----------
    world : World
    position : (n, 3) array [m]
    is_suspect : (n,) array of bool, places from which no sky is seen; no others need be looked at

    Raises
    ------
    InputError
        If seven in ten of 33 upward rays meet an odd number of triangles, and of 330, too.

    Notes
    -----
    A ray that starts within a closed surface crosses it an odd number of times. Rays go upwards only, so that houses
    and trees without a floor count as closed. Some rays go astray where a pane lies before a wall, and under leaves and
    fences, which have no inside, half of them do at most.
    """
    seen: dict[tuple[float, ...], bool] = {}
    for index in np.flatnonzero(is_suspect):
        eye = position[index]
        key = tuple(eye.tolist())
        if key not in seen:
            seen[key] = all(share_odd(world, eye, n) >= INSIDE for n in (N_RAYS, N_RAYS_OF_PROOF))
        if seen[key]:
            x, y, z = key
            raise InputError(
                f"position {index} at ({x:g}, {y:g}, {z:g}) m is inside a solid or below the ground, expected outside"
            )


def share_odd(world: World, eye: Floats, n_rays: int) -> float:
    """Share of upward rays from an eye (3,) [m] that meet an odd number of triangles.

    Parameters
    ----------
    world : World
    eye : (3,) array [m]
    n_rays : int
    """
    return float(np.mean(count_crossings(world, eye, upward_rays(n_rays)) % 2))


def upward_rays(n: int = N_RAYS) -> Floats:
    """Unit vectors (ray, 3), evenly spread over the upper hemisphere.

    Parameters
    ----------
    n : how many
    """
    height = (np.arange(n) + 0.5) / n
    azimuth = 0.5 + GOLDEN_ANGLE * np.arange(n)  # none along the edges of what is built square
    across = np.sqrt(1 - height**2)
    return np.stack([across * np.sin(azimuth), across * np.cos(azimuth), height], axis=-1)


def count_crossings(world: World, eye: Floats, rays: Floats) -> npt.NDArray[np.int64]:
    """Number of triangles that each ray meets, (ray,).

    Parameters
    ----------
    world : World
    eye : (3,) array [m], where the rays start
    rays : (ray, 3) unit vectors

    Notes
    -----
    Möller & Trumbore (1997), Journal of Graphics Tools 2: 21-28. Its triple products are put in the order in which all
    but one factor is the same for all rays.
    """
    corners: Any = world.mesh.vertices
    start = corners[:, 0].astype(np.float64)
    one, other = corners[:, 1] - start, corners[:, 2] - start
    from_start = eye - start
    turned = np.cross(from_start, one)
    normal, across = np.cross(other, one), np.cross(other, from_start)
    distance = (turned * other).sum(axis=-1)
    found = [
        _count_met(normal @ block.T, across @ block.T, turned @ block.T, distance[:, None])
        for block in np.split(rays, range(RAYS_AT_ONCE, len(rays), RAYS_AT_ONCE))
    ]
    return np.concatenate(found)


def _count_met(scale: Floats, u: Floats, v: Floats, distance: Floats) -> npt.NDArray[np.int64]:
    """Triangles met by each ray, from coordinates within the triangle and distance, all times a scale of any sign."""
    side = np.sign(scale)
    u, v = side * u, side * v
    is_met = (u >= 0) & (v >= 0) & (u + v <= side * scale) & (side * distance > 0)
    return np.asarray(is_met.sum(axis=0), np.int64)
