"""Light on surfaces a second time, in plain NumPy: one ray a pixel, no texture's blur, shadows by exact rays if any."""

import numpy as np

from insectnav.worlds import LitWorld
from insectnav.worlds.materials import MATERIALS, mirror_fraction
from insectnav.worlds.skylight import BANDS
from insectnav.worlds.texture import texture

NAMES = tuple(BANDS)


def is_free(triangles: np.ndarray, points: np.ndarray, ray: np.ndarray) -> np.ndarray:
    """Whether nothing stands between points (n, 3) and far away along a ray: Möller & Trumbore, all pairs."""
    start = triangles[:, 0]
    one, other = triangles[:, 1] - start, triangles[:, 2] - start
    normal = np.cross(ray, other)
    scale = (one * normal).sum(axis=-1)
    free = np.ones(len(points), bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for i, point in enumerate(points):
            from_start = point - start
            u = (from_start * normal).sum(axis=-1) / scale
            turned = np.cross(from_start, one)
            v = turned @ ray / scale
            distance = (turned * other).sum(axis=-1) / scale
            free[i] = not ((u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 1e-4)).any()
    return free


def shade(world: LitWorld, rays: np.ndarray, triangle: np.ndarray, nearness: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Radiance (ray, band) of rays (ray, 3) that meet these triangles at these distances."""
    sky, light = world.sky, world.packed.light
    radiance = sky.radiance(rays, NAMES)
    index = np.flatnonzero(triangle != -1)
    rays, triangle, nearness = rays[index], triangle[index], nearness[index]
    corners = world.mesh.vertices.astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    normal = np.where(triangle[:, None] >= 0, normals[triangle], [0.0, 0.0, 1.0])
    normal = np.where((normal * rays).sum(axis=-1, keepdims=True) > 0, -normal, normal)
    distance = np.where(triangle >= 0, 1 / nearness, -eye[2] / np.minimum(rays[:, 2], -1e-9))
    points = eye + distance[:, None] * rays
    names = np.array([*world.mesh.materials, world.ground])
    material = names[np.where(triangle >= 0, np.asarray(world.mesh.material)[triangle], len(names) - 1)]
    diffuse = np.stack([MATERIALS[name].diffuse for name in material])
    through = np.stack([MATERIALS[name].through for name in material])
    mirrors = np.array([mirror_fraction(name, 1.0) > 0 for name in material])
    grain = texture(points, seed=world.grain.seed, coarsest=world.grain.coarsest, n_octaves=world.grain.n_octaves)
    grain = np.where(mirrors, 1.0, np.maximum(1 + world.grain.contrast * grain, 0.0))[:, None]
    grain = np.minimum(grain, 1 / (diffuse + through))
    below = 0.5 * np.pi * (1 - normal[:, 2:])
    sides = [below * light.ground_light, (np.pi - below) * light.ground_light]
    sources = [*zip(light.part, light.part_light, strict=True), (sky.sun, sky.sun_irradiance(NAMES))]
    for towards, amount in sources:
        cosine = normal @ towards
        free = is_free(corners, points, towards) if world.shadows else np.ones(len(points), bool)
        walls = 0.0 * amount if amount is sources[-1][1] else 2 * np.pi / len(light.part) * light.wall_light
        coming = np.where(free[:, None], amount, walls)
        for side in (0, 1):
            sides[side] = sides[side] + np.maximum(cosine if side == 0 else -cosine, 0.0)[:, None] * coming
    found = grain * (diffuse * sides[0] + through * sides[1]) / np.pi
    along = (rays * normal).sum(axis=-1)
    mirrored = rays - 2 * along[:, None] * normal
    mirrored /= np.linalg.norm(mirrored, axis=-1, keepdims=True)
    up = mirrored[:, 2:] >= 0
    shown = np.where(up, sky.radiance(mirrored, NAMES), light.ground_light)
    for name in np.unique(material[mirrors]):
        share = mirror_fraction(name, np.minimum(-along, 1.0))
        found += np.where(material == name, share, 0.0)[:, None] * shown
    radiance[index] = found
    return radiance
