"""Trees, bushes and grass that hold up in a photograph: many small leaves in lumps, where worlds have a few large ones.

Sizes of leaves are those of clusters of leaves, not of single ones: a pixel of these pictures is 1.7 mrad wide.
"""

import numpy as np

from insectnav.angles import Floats
from insectnav.worlds.plants import tussocks
from insectnav.worlds.shapes import Part, frustum, joined, placed, quads, spikes, unit

LUMPS = 16  # of a crown, assumed
GRASS = 0.5  # length of the longest blade over its distance to the next tussock, assumed


def leafy_trees(
    rng: np.random.Generator, feet: Floats, heights: Floats, *, leaf: float = 0.25, density: float = 3.0
) -> list[Part]:
    """Broad-leaved trees: a trunk, branches to the lumps of the crown, and leaves in these.

    Parameters
    ----------
    feet : (n, 3) array [m]
    heights : (n,) array [m]
    leaf : length of a cluster of leaves [m]
    density : area of leaves over that which the crown covers; 0 is bare
    """
    parts = [_tree(rng, foot, float(height), leaf, density) for foot, height in zip(feet, heights, strict=True)]
    return [("leaves", joined([leaves for leaves, _ in parts])), ("bark", joined([wood for _, wood in parts]))]


def _tree(rng: np.random.Generator, foot: Floats, height: float, leaf: float, density: float) -> tuple[Floats, Floats]:
    middle, half = foot + np.array([0.0, 0.0, 0.62 * height]), height * np.array([0.3, 0.3, 0.36])
    lumps = middle + half * in_ball(rng, LUMPS, 0.3) * 0.72
    radii = (0.3 + 0.14 * rng.random((LUMPS, 1))) * half
    leaves = leaves_in(rng, lumps, radii, leaf, density)
    trunk = placed(frustum(8, 0.02, 0.006, 0.75) * height, foot[None])
    starts = foot + np.array([0.0, 0.0, 1.0]) * height * (0.25 + 0.35 * rng.random((LUMPS, 1)))
    boughs = spikes(starts, lumps, np.full(LUMPS, 0.006 * height))
    twigs_from = np.repeat(0.4 * starts + 0.6 * lumps, 8, axis=0)
    twigs_to = np.repeat(lumps, 8, axis=0) + np.repeat(radii, 8, axis=0) * in_ball(rng, 8 * LUMPS, 0.7)
    return leaves, joined([trunk, boughs, spikes(twigs_from, twigs_to, np.full(8 * LUMPS, 0.002 * height))])


def bushes(
    rng: np.random.Generator,
    feet: Floats,
    heights: Floats,
    *,
    leaf: float = 0.06,
    density: float = 2.5,
    width: float = 0.6,
) -> list[Part]:
    """Bushes, lumps of leaves from the ground up; `width` is the radius over the height."""
    leaves, twigs = [], []
    for foot, height in zip(feet, np.asarray(heights, dtype=np.float64), strict=True):
        half = height * np.array([width, width, 0.5])
        lumps = foot + np.array([0.0, 0.0, 0.5 * height]) + half * in_ball(rng, 9, 0.2) * 0.6
        leaves.append(leaves_in(rng, lumps, (0.35 + 0.15 * rng.random((9, 1))) * half, leaf, density))
        ends = lumps + half * 0.3 * in_ball(rng, 9, 0.5)
        ends[:, 2] = np.maximum(ends[:, 2], foot[2] + 0.05 * height)
        starts = np.broadcast_to(foot + np.array([0.0, 0.0, 0.02 * height]), ends.shape)
        twigs.append(spikes(starts, ends, np.full(9, 0.012 * height)))
    return [("leaves", joined(leaves)), ("bark", joined(twigs))]


def leaves_in(rng: np.random.Generator, lumps: Floats, radii: Floats, leaf: float, density: float) -> Floats:
    """Leaves as diamonds of any orientation in the outer part of ellipsoids (n, 3) with half axes (n, 3).

    Parameters
    ----------
    leaf : length of the largest [m]; no leaf is shorter than half of it
    density : one-sided area of the leaves of a lump over the area of its shadow from above
    """
    area = 0.35 * (0.75 * leaf) ** 2  # of a diamond of mean length
    numbers = np.round(density * np.pi * radii[:, 0] * radii[:, 1] / area).astype(int)
    owner = np.repeat(np.arange(len(lumps)), numbers)
    centres = lumps[owner] + radii[owner] * in_ball(rng, len(owner), 0.6)
    along = unit(rng.standard_normal(centres.shape))
    across = unit(np.cross(along, rng.standard_normal(centres.shape)))
    size = 0.5 * leaf * (0.5 + 0.5 * rng.random((len(owner), 1)))
    ends = along * size, 0.7 * across * size
    kept = quads(np.stack([centres - ends[0], centres + ends[1], centres + ends[0], centres - ends[1]], axis=1))
    return kept[(kept[..., 2] > 0.005).all(axis=1)]


def in_ball(rng: np.random.Generator, n: int, inner: float) -> Floats:
    """Points between `inner` and 1 from the origin, (n, 3)."""
    radius = (inner**3 + (1.0 - inner**3) * rng.random(n)) ** (1.0 / 3.0)
    return unit(rng.standard_normal((n, 3))) * radius[:, None]


def grass(
    rng: np.random.Generator,
    low: tuple[float, float],
    high: tuple[float, float],
    height: float,
    *,
    material: str = "straw",
    n_blades: int = 30,
) -> Part:
    """Tussocks all over a rectangle with the corners `low` and `high` [m], as high as `height` at most."""
    spacing = height / GRASS
    count = np.maximum(np.ceil((np.array(high) - low) / spacing), 1).astype(int)
    x, y = np.meshgrid(*(np.arange(n) + 0.5 for n in count), indexing="ij")
    place = np.stack([x, y], axis=-1).reshape(-1, 2) + 0.8 * (rng.random((x.size, 2)) - 0.5)
    feet = np.concatenate([np.array(low) + place * spacing, np.zeros((x.size, 1))], axis=-1)
    heights = height * (0.4 + 0.6 * rng.random(x.size))
    return material, tussocks(rng, feet, heights, n_blades=n_blades)


def scattered_feet(
    rng: np.random.Generator, n: int, low: tuple[float, float], high: tuple[float, float], clear: float = 0.0
) -> Floats:
    """Places on level ground in a rectangle, (n or fewer, 3); none within `clear` metres of the origin."""
    place = np.array(low) + (np.array(high) - low) * rng.random((n, 2))
    place = place[np.hypot(place[:, 0], place[:, 1]) > clear]
    return np.concatenate([place, np.zeros((len(place), 1))], axis=-1)
