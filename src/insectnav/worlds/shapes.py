"""Triangles of simple bodies, and how they are put into a world.

A body is an array (triangle, 3, 3) of corners x, y, z [m]. Closed bodies face outwards: seen from outside, the corners
of a triangle go round anticlockwise. In its own frame a body stands on z = 0 over the origin and looks along +y.
"""

import hashlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.records import Mesh

Part = tuple[str, Floats]  # material, triangles
GRID = 2.0**-14  # [m]; vertices lie on it, so that the last digits in which processors differ fall away
_LEAST_AREA = 1e-8  # [m²]; below, rounding to the grid may have left a line


def generator(seed: int, purpose: str) -> np.random.Generator:
    """Random numbers for one purpose of one world: PCG64, keyed by the seed and the purpose."""
    key = int.from_bytes(hashlib.sha256(purpose.encode()).digest()[:8], "little")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([int(seed), key])))


def joined(parts: Sequence[Floats]) -> Floats:
    """All triangles in one array; none at all is an empty array (0, 3, 3)."""
    return np.concatenate([np.zeros((0, 3, 3)), *(np.reshape(part, (-1, 3, 3)) for part in parts)])


def mesh_from(parts: Sequence[Part], name: str) -> Mesh:
    """Mesh of parts, each of one material; vertices rounded to the grid, and what that flattens left out."""
    materials = tuple(dict.fromkeys(material for material, triangles in parts if triangles.size))
    vertices = np.round(joined([triangles for _, triangles in parts]) / GRID) * GRID
    index = np.concatenate(
        [np.full(triangles.size // 9, materials.index(material)) for material, triangles in parts if triangles.size]
    )
    keep = triangle_areas(vertices) > _LEAST_AREA
    return Mesh(
        vertices=vertices[keep].astype(np.float32),
        material=index[keep].astype(np.int32),
        materials=materials,
        name=name,
    )


def triangle_areas(triangles: npt.ArrayLike) -> Floats:
    """Area of each triangle, (triangle,) array [m²]."""
    corners = np.asarray(triangles, dtype=np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.sqrt((normals**2).sum(axis=-1))


def placed(triangles: Floats, positions: npt.ArrayLike, headings: npt.ArrayLike = 0.0) -> Floats:
    """Copies of a body, each turned clockwise by its heading and moved to its position, (copy, triangle, 3, 3).

    Parameters
    ----------
    triangles : (triangle, 3, 3) or (copy, triangle, 3, 3) array [m]
    positions : (copy, 3) array [m]
    headings : number or (copy,) array [rad] clockwise from +y
    """
    positions = np.atleast_2d(np.asarray(positions, dtype=np.float64))
    headings = np.broadcast_to(np.asarray(headings, dtype=np.float64), positions.shape[:1])[:, None, None]
    x, y, z = np.moveaxis(np.broadcast_to(triangles, (len(positions), *triangles.shape[-3:])), -1, 0)
    sine, cosine = np.sin(headings), np.cos(headings)
    turned = np.stack([x * cosine + y * sine, y * cosine - x * sine, z], axis=-1)
    return turned + positions[:, None, None, :]


def quads(corners: npt.ArrayLike) -> Floats:
    """Two triangles for each four corners (..., 4, 3) that go round it, (triangle, 3, 3)."""
    corners = np.reshape(np.asarray(corners, dtype=np.float64), (-1, 4, 3))
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


def box(width: float, depth: float, height: float, base: float = 0.0) -> Floats:
    """Ten triangles: the sides and the top of a block, `width` along x and `depth` along y, from `base` upwards [m]."""
    x, y, low, high = width / 2, depth / 2, base, base + height
    ring = [(-x, -y), (x, -y), (x, y), (-x, y)]
    sides = [
        [(*ring[i], low), (*ring[(i + 1) % 4], low), (*ring[(i + 1) % 4], high), (*ring[i], high)] for i in range(4)
    ]
    return quads([*sides, [(*corner, high) for corner in ring]])


def upright_quads(centres: npt.ArrayLike, width: float, height: float) -> Floats:
    """Upright rectangles that look along +y, one for each centre (n, 3), (2 n, 3, 3)."""
    offsets = np.array([(1, 0, -1), (-1, 0, -1), (-1, 0, 1), (1, 0, 1)]) * np.array([width, 0.0, height]) / 2
    return quads(np.asarray(centres, dtype=np.float64)[:, None, :] + offsets)


def frustum(n_sides: int, bottom: float, top: float, height: float, base: float = 0.0) -> Floats:
    """Sides of an upright cone, cut off unless the top radius is 0, (n_sides or 2 n_sides, 3, 3).

    Parameters
    ----------
    bottom, top : radii [m]
    height, base : of the body, and of where it begins [m]
    """
    angle = 2 * np.pi * np.arange(n_sides + 1) / n_sides
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    low, high = circle * bottom + [0, 0, base], circle * top + [0, 0, base + height]
    if top == 0:
        return np.stack([low[:-1], low[1:], high[:-1]], axis=1)
    return quads(np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1))


def spikes(starts: npt.ArrayLike, ends: npt.ArrayLike, radii: npt.ArrayLike) -> Floats:
    """Three-sided thin cones from the starts to a point at the ends, (3 n, 3, 3): twigs and branches.

    Parameters
    ----------
    starts, ends : (n, 3) arrays [m]
    radii : (n,) array, at the start [m]
    """
    starts, ends = np.asarray(starts, dtype=np.float64), np.asarray(ends, dtype=np.float64)
    along = unit(ends - starts)
    across = unit(np.cross(along, np.where(np.abs(along[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])))
    other = np.cross(along, across)
    angle = 2 * np.pi * np.arange(3) / 3
    ring = across[:, None] * np.cos(angle)[:, None] + other[:, None] * np.sin(angle)[:, None]
    foot = starts[:, None] + ring * np.asarray(radii, dtype=np.float64)[:, None, None]
    tip = np.broadcast_to(ends[:, None], foot.shape)
    return np.stack([foot, np.roll(foot, -1, axis=1), tip], axis=2).reshape(-1, 3, 3)


def ball() -> Floats:
    """Twenty triangles of an icosahedron of radius 1 about the origin, (20, 3, 3)."""
    golden = (1 + np.sqrt(5)) / 2
    corners = np.array([(0.0, a, b * golden) for a in (-1, 1) for b in (-1, 1)])
    corners = unit(np.concatenate([np.roll(corners, turn, axis=1) for turn in range(3)]))
    near = np.linalg.norm(corners[:, None] - corners, axis=-1) < 1.1  # an edge is 1.05 long
    faces = [
        (i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]
    ]
    triangles = corners[np.array(faces)]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    outwards = (normals * triangles[:, 0]).sum(axis=-1)
    return np.where(outwards[:, None, None] > 0, triangles, triangles[:, ::-1])


def unit(vectors: Floats) -> Floats:
    """Vectors of the same direction and length 1."""
    return vectors / np.sqrt((vectors**2).sum(axis=-1, keepdims=True))
