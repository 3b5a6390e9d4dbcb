"""Meshes whose pictures are known: walls, boxes, spheres round the eye, triangles at random."""

import numpy as np

from insectnav.records import Mesh
from insectnav.worlds import World, flat_world

EVERYWHERE = ((-50.0, -50.0), (50.0, 50.0))


def world_of(*triangles: np.ndarray, plants=None) -> World:
    """Flat grey world, open all round."""
    return flat_world(Mesh(vertices=np.concatenate(triangles)), plants=plants, extent=EVERYWHERE)


def quad(a, b, c, d) -> np.ndarray:
    """Two triangles (2, 3, 3) of four corners in order."""
    return np.array([[a, b, c], [a, c, d]], float)


def wall(x0: float, y0: float, x1: float, y1: float, height: float) -> np.ndarray:
    """Vertical wall on the ground."""
    return quad((x0, y0, 0), (x1, y1, 0), (x1, y1, height), (x0, y0, height))


def box(x: float, y: float, size: float, height: float) -> np.ndarray:
    """House without a floor; x, y is its middle."""
    low_x, high_x, low_y, high_y = x - size / 2, x + size / 2, y - size / 2, y + size / 2
    roof = [(low_x, low_y, height), (high_x, low_y, height), (high_x, high_y, height), (low_x, high_y, height)]
    return np.concatenate([
        wall(low_x, low_y, high_x, low_y, height),
        wall(high_x, low_y, high_x, high_y, height),
        wall(high_x, high_y, low_x, high_y, height),
        wall(low_x, high_y, low_x, low_y, height),
        quad(*roof),
    ])  # fmt: skip


def sphere(n_rings: int, n_sectors: int, radius: float, centre=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Closed sphere of meridians and parallels, with corners exactly at the poles."""
    polar = np.linspace(0, np.pi, n_rings + 1)[:, None]
    azimuth = np.linspace(0, 2 * np.pi, n_sectors + 1)[None]
    azimuth = np.where(azimuth == 2 * np.pi, 0.0, azimuth)
    along = np.sin(polar) * (polar > 0) * (polar < np.pi)
    points = np.stack([along * np.sin(azimuth), along * np.cos(azimuth), np.cos(polar) + 0 * azimuth], axis=-1)
    points = (radius * points + np.array(centre)).astype(np.float32)  # rounded before corners are shared
    found = []
    for i in range(n_rings):
        for j in range(n_sectors):
            a, b, c, d = points[i, j], points[i + 1, j], points[i + 1, j + 1], points[i, j + 1]
            found += [[a, b, c]] if i < n_rings - 1 else []  # b and c are the nadir
            found += [[a, c, d]] if i > 0 else []  # a and d are the zenith
    return np.array(found, float)


def turned(triangles: np.ndarray, heading: float, pitch: float = 0.0) -> np.ndarray:
    """Triangles turned clockwise seen from above, after a turn about the x axis."""
    sp, cp, sh, ch = np.sin(pitch), np.cos(pitch), np.sin(heading), np.cos(heading)
    tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    return triangles @ tilt.T @ np.array([[ch, sh, 0], [-sh, ch, 0], [0, 0, 1]]).T


def soup(seed: int, n: int = 300, spread: float = 8.0) -> np.ndarray:
    """Triangles of all sizes at random places above the ground."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-spread, spread, (n, 1, 3)) * [1, 1, 0.5]
    triangles = middle + rng.normal(size=(n, 3, 3)) * rng.uniform(0.05, 1.5, (n, 1, 1))
    triangles[..., 2] = np.abs(triangles[..., 2])
    return triangles
