"""Plants: where they stand, and tussocks, shrubs, hedges, broad-leaved trees and conifers as triangles.

Foliage is the season: each leaf has a number between 0 and 1 and is there while that is below the foliage, so that a
world in winter has a part of the leaves that it has in summer, at the same places. Needles stay.
"""

from dataclasses import dataclass

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import InputError, check_count, check_range
from insectnav.worlds.shapes import Part, ball, frustum, joined, placed, quads, spikes, unit

LASTING_BLADES = 0.5  # share of the blades of a tussock that stand through the winter
_LOWEST_BRANCH = 0.45  # share of the height of the crown's middle at which the lowest branch leaves the trunk
_LEAFY = 0.3  # foliage below which the inside of a hedge is twigs


@dataclass(frozen=True, kw_only=True)
class TreeForm:
    """Proportions of a tree, as shares of its height."""

    crown_radius: float = 0.30
    crown_middle: float = 0.62  # height of the middle of the crown
    crown_half_height: float = 0.36
    trunk_radius: float = 0.018
    leaf: float = 0.09  # length of a cluster of leaves
    n_leaves: int = 60  # clusters of leaves on a tree
    n_clumps: int = 6  # dense parts of the crown
    n_branches: int = 9

    @property
    def reach(self) -> float:
        """How far leaves reach from the foot, as a share of the height."""
        return self.crown_radius


BROADLEAF = TreeForm()
SPARSE = TreeForm(n_leaves=32, leaf=0.12, n_clumps=4, n_branches=4)  # for worlds of many trees
TOWN = TreeForm(crown_radius=0.27, n_leaves=30, leaf=0.13, n_clumps=4, n_branches=4)
CONIFER = TreeForm(crown_radius=0.16, n_leaves=48, n_clumps=0, n_branches=0)


def check_heights(name: str, heights: tuple[float, float]) -> None:
    """Refuse what is no pair of a least and a greatest height in metres."""
    if not isinstance(heights, tuple) or len(heights) != 2:
        raise InputError(f"{name} is {heights!r}, expected the least and the greatest as in (0.4, 1.3)")
    check_range(f"least {name}", heights[0], 0.01, 100.0, "m")
    check_range(f"greatest {name}", heights[1], heights[0], 100.0, "m")


def scattered(rng: np.random.Generator, density: float, inner: float, outer: float) -> Floats:
    """Positions in a ring about the origin, at random and independent, (n, 2) array [m].

    Parameters
    ----------
    density : float
        Mean number on a square metre; n is Poisson distributed about density × area.
    inner, outer : float
        Radii of the ring [m].

    Raises
    ------
    InputError
        If the density is negative or the ring is empty.
    """
    check_range("density", density, 0.0, 1e3, "plants on a square metre")
    check_range("inner radius", inner, 0.0, outer, "m")
    n = rng.poisson(density * np.pi * (outer**2 - inner**2))
    radius = np.sqrt(inner**2 + (outer**2 - inner**2) * rng.random(n))
    angle = 2 * np.pi * rng.random(n)
    return np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=-1)


def scattered_in_box(
    rng: np.random.Generator, density: float, low: tuple[float, float], high: tuple[float, float]
) -> Floats:
    """Positions in a rectangle with the corners `low` and `high`, at random and independent, (n, 2) array [m]."""
    check_range("density", density, 0.0, 1e3, "plants on a square metre")
    sides = np.array(high) - np.array(low)
    check_range("sides of the rectangle", sides, 0.0, 1e4, "m")
    return np.array(low) + sides * rng.random((rng.poisson(density * float(sides[0] * sides[1])), 2))


def on_ground(positions: Floats, height: Floats | float = 0.0) -> Floats:
    """Positions (n, 2) with the height of the ground below them as z, (n, 3)."""
    return np.concatenate([positions, np.broadcast_to(height, len(positions))[:, None]], axis=1)


def tussocks(
    rng: np.random.Generator, feet: Floats, heights: Floats, *, n_blades: int = 12, foliage: float = 1.0
) -> Floats:
    """Fans of narrow blades that bend outwards, three triangles a blade.

    Parameters
    ----------
    feet : (n, 3) array [m]
    heights : (n,) array, length of the longest blade of each [m]; no blade reaches higher or farther from its foot
    n_blades : int
        Of each tussock in summer.
    foliage : float
        0 for winter, when half of the blades stand, to 1 for summer.
    """
    check_count("n_blades", n_blades)
    check_range("foliage", foliage, 0.0, 1.0)
    shape = (len(feet), n_blades)
    heading = 2 * np.pi * rng.random(shape)
    outwards = np.stack([np.sin(heading), np.cos(heading), np.zeros(shape)], axis=-1)
    sideways = np.stack([np.cos(heading), -np.sin(heading), np.zeros(shape)], axis=-1)
    length = 0.95 * np.asarray(heights)[:, None] * (0.55 + 0.45 * rng.random(shape))
    lean = 0.05 + 0.65 * rng.random(shape)  # [rad] from the vertical, at the foot
    bend = 0.15 + 0.55 * rng.random(shape)  # [rad] more, at the tip
    width = 0.03 * length * (0.6 + 0.8 * rng.random(shape))
    there = rng.random(shape) < LASTING_BLADES + (1 - LASTING_BLADES) * foliage
    foot = feet[:, None] + outwards * (0.05 * length)[..., None]
    middle = foot + _leaning(outwards, lean) * (0.55 * length)[..., None]
    tip = middle + _leaning(outwards, lean + bend) * (0.45 * length)[..., None]
    half = sideways * (0.5 * width)[..., None]
    lower = quads(np.stack([foot - half, foot + half, middle + 0.8 * half, middle - 0.8 * half], axis=2))
    upper = np.stack([middle - 0.8 * half, middle + 0.8 * half, tip], axis=2)
    blades = np.concatenate([lower.reshape(*shape, 2, 3, 3), upper[:, :, None]], axis=2)
    return blades[there].reshape(-1, 3, 3)


def shrubs(
    rng: np.random.Generator, feet: Floats, heights: Floats, *, n_leaves: int = 24, foliage: float = 1.0
) -> list[Part]:
    """Shrubs as broad as high: twigs from the foot, and clusters of leaves in a flattened ball.

    Parameters
    ----------
    feet : (n, 3) array [m]
    heights : (n,) array [m]; no leaf reaches higher, nor farther from the foot than 0.6 heights
    n_leaves : int
        Clusters of leaves on each in summer.
    foliage : float
        0 to 1.
    """
    check_range("foliage", foliage, 0.0, 1.0)
    heights = np.asarray(heights, dtype=np.float64)
    middle = feet + np.stack([np.zeros_like(heights), np.zeros_like(heights), 0.5 * heights], axis=-1)
    half = np.stack([0.5 * heights, 0.5 * heights, 0.4 * heights], axis=-1)
    leaves = joined([
        _leaves(rng, middle, half, 0.2 * heights, n_leaves, foliage), _clumps(rng, middle, 0.9 * half, 2, foliage)
    ])  # fmt: skip
    ends = middle[:, None] + _in_ball(rng, (len(feet), 7), 0.7) * half[:, None]
    up = np.stack([np.zeros_like(heights), np.zeros_like(heights), 0.012 * heights], axis=-1)  # stay above the ground
    starts = np.broadcast_to((feet + up)[:, None], ends.shape)
    radii = np.repeat(0.012 * heights, 7)
    return [("leaves", leaves), ("bark", spikes(starts.reshape(-1, 3), ends.reshape(-1, 3), radii))]


def trees(
    rng: np.random.Generator, feet: Floats, heights: Floats, form: TreeForm = BROADLEAF, *, foliage: float = 1.0
) -> list[Part]:
    """Broad-leaved trees: trunk, branches, dense clumps within the crown, and clusters of leaves about them.

    Parameters
    ----------
    feet : (n, 3) array [m]
    heights : (n,) array [m]
    form : TreeForm
    foliage : float
        0 for bare branches to 1 for summer.
    """
    check_range("foliage", foliage, 0.0, 1.0)
    heights = np.asarray(heights, dtype=np.float64)
    up = np.zeros((len(heights), 3))
    up[:, 2] = 1.0
    middle = feet + up * (form.crown_middle * heights)[:, None]
    half = heights[:, None] * np.array([form.crown_radius, form.crown_radius, form.crown_half_height])
    half = half - 0.5 * form.leaf * heights[:, None]
    leaves = _leaves(rng, middle, half, form.leaf * heights, form.n_leaves, foliage)
    clumps = _clumps(rng, middle, half, form.n_clumps, foliage)
    turn = 2 * np.pi * rng.random(len(heights))
    trunk = frustum(6, form.trunk_radius, 0.3 * form.trunk_radius, form.crown_middle) * heights[:, None, None, None]
    shape = (len(heights), form.n_branches)
    where = _LOWEST_BRANCH * form.crown_middle + 0.5 * form.crown_middle * rng.random(shape)
    starts = feet[:, None] + up[:, None] * (where * heights[:, None])[..., None]
    ends = middle[:, None] + _in_ball(rng, shape, 0.6) * half[:, None]
    radii = np.broadcast_to((0.35 * form.trunk_radius * heights)[:, None], shape).ravel()
    branches = spikes(starts.reshape(-1, 3), ends.reshape(-1, 3), radii) if radii.size else np.zeros((0, 3, 3))
    return [("leaves", joined([leaves, clumps])), ("bark", joined([placed(trunk, feet, turn), branches]))]


def conifers(rng: np.random.Generator, feet: Floats, heights: Floats, form: TreeForm = CONIFER) -> list[Part]:
    """Conifers: a trunk, a slim cone, and drooping boughs round it that are wider below; the same in all seasons."""
    heights = np.asarray(heights, dtype=np.float64)
    scale = heights[:, None, None, None]
    turn = 2 * np.pi * rng.random(len(heights))
    cone = frustum(7, 0.6 * form.crown_radius, 0.0, 0.8, base=0.2) * scale
    trunk = frustum(6, form.trunk_radius, 0.4 * form.trunk_radius, 0.3) * scale
    shape = (len(heights), form.n_leaves)
    level = 0.16 + 0.8 * rng.random(shape)
    heading = 2 * np.pi * rng.random(shape)
    outwards = np.stack([np.sin(heading), np.cos(heading), np.zeros(shape)], axis=-1)
    sideways = np.stack([np.cos(heading), -np.sin(heading), np.zeros(shape)], axis=-1)
    reach = form.crown_radius * (1.05 - level) * (0.75 + 0.25 * rng.random(shape)) / 0.9
    height = heights[:, None, None]
    up = np.zeros((*shape, 3))
    up[..., 2] = level
    tip = (outwards * reach[..., None] + up - np.array([0.0, 0.0, 0.04])) * height
    half = sideways * (0.45 * reach)[..., None] * height
    boughs = np.stack([up * height, 0.6 * tip + 0.4 * up * height + half, tip], axis=2)
    other = np.stack([up * height, tip, 0.6 * tip + 0.4 * up * height - half], axis=2)
    needles = joined([boughs + feet[:, None, None], other + feet[:, None, None], placed(cone, feet, turn)])
    return [("needles", needles), ("bark", joined([placed(trunk, feet, turn)]))]


def hedge(
    rng: np.random.Generator, start: Floats, end: Floats, height: float, *, foliage: float = 1.0, leaf: float = 0.18
) -> list[Part]:
    """A clipped hedge along a line: a dark block, smaller in winter, under a skin of leaves.

    Parameters
    ----------
    start, end : (2,) arrays [m]
    height : float
        [m]; it is 0.35 heights to each side wide.
    foliage : float
        0 to 1.
    leaf : float
        Size of a cluster of leaves [m].
    """
    check_range("foliage", foliage, 0.0, 1.0)
    along = np.asarray(end, dtype=np.float64) - np.asarray(start, dtype=np.float64)
    length = float(np.sqrt(along[0] ** 2 + along[1] ** 2))
    n = max(1, int(12 * length))
    place = rng.random((n, 3))
    side = rng.integers(0, 3, n)  # left, right, top
    x = np.where(side == 2, 2 * place[:, 0] - 1, np.where(side == 0, -1.0, 1.0)) * 0.35 * height
    z = np.where(side == 2, 0.95, 0.05 + 0.9 * place[:, 2]) * height
    centres = np.stack([x, (place[:, 1] - 0.5) * length, np.maximum(z - 0.5 * leaf, 0.5 * leaf)], axis=-1)
    skin = _cards(rng, centres, np.full(n, leaf))[rng.random(n) < foliage]
    thin = 0.35 + 0.65 * foliage
    block = frustum(4, np.sqrt(0.5), np.sqrt(0.5), 1.0)
    turned = placed(block, [(0.0, 0.0, 0.0)], np.pi / 4)[0]
    body = turned * np.array([0.6 * height * thin, length, 0.88 * height])
    middle = on_ground((np.asarray(start, dtype=np.float64) + 0.5 * along)[None])
    heading = np.arctan2(along[0], along[1])
    outer, inner = placed(skin.reshape(-1, 3, 3), middle, heading), placed(body, middle, heading)
    if foliage < _LEAFY:
        return [("leaves", joined([outer])), ("bark", joined([inner]))]
    return [("leaves", joined([outer, inner]))]


def _leaning(outwards: Floats, angle: Floats) -> Floats:
    """Unit vectors at an angle from the vertical."""
    direction = outwards * np.sin(angle)[..., None]
    direction[..., 2] = np.cos(angle)
    return direction


def _in_ball(rng: np.random.Generator, shape: tuple[int, ...], inner: float) -> Floats:
    """Points between `inner` and 1 from the origin, in all directions alike, (..., 3)."""
    radius = (inner**3 + (1 - inner**3) * rng.random(shape)) ** (1 / 3)
    return unit(rng.standard_normal((*shape, 3))) * radius[..., None]


def _leaves(
    rng: np.random.Generator, middle: Floats, half: Floats, size: Floats, n_leaves: int, foliage: float
) -> Floats:
    """Clusters of leaves in the outer part of ellipsoids, two triangles a cluster."""
    shape = (len(middle), n_leaves)
    centres = middle[:, None] + _in_ball(rng, shape, 0.6) * half[:, None]
    sizes = np.asarray(size)[:, None] * (0.6 + 0.4 * rng.random(shape))
    cards = _cards(rng, centres, sizes)
    return cards[rng.random(shape) < foliage].reshape(-1, 3, 3)


def _clumps(rng: np.random.Generator, middle: Floats, half: Floats, n_clumps: int, foliage: float) -> Floats:
    """Dense clumps within ellipsoids, twenty triangles each; they shrink with the foliage and are gone without it."""
    shape = (len(middle), n_clumps)
    centres = middle[:, None] + 0.45 * _in_ball(rng, shape, 0.7) * half[:, None]
    radii = (0.38 + 0.17 * rng.random(shape))[..., None] * half[:, None] * foliage
    turn = 2 * np.pi * rng.random(shape)
    if radii.size == 0 or foliage == 0.0:
        return np.zeros((0, 3, 3))
    return placed(ball() * radii.reshape(-1, 1, 1, 3), centres.reshape(-1, 3), turn.ravel()).reshape(-1, 3, 3)


def _cards(rng: np.random.Generator, centres: Floats, sizes: Floats) -> Floats:
    """Diamonds of any orientation about centres (..., 3), as long as the sizes (...), (..., 2, 3, 3)."""
    along = unit(rng.standard_normal(centres.shape))
    across = unit(np.cross(along, rng.standard_normal(centres.shape)))
    length, width = 0.5 * sizes[..., None] * along, 0.35 * sizes[..., None] * across
    corners = np.stack([centres - length, centres + width, centres + length, centres - width], axis=-2)
    return quads(corners).reshape(*centres.shape[:-1], 2, 3, 3)
