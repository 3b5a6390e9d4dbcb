"""A forest trail: broad-leaved trees and conifers close on both sides, and gaps in the canopy along the way."""

from dataclasses import dataclass

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import check_choice, check_count, check_range
from insectnav.worlds.ant_world import GROUNDS, MAX_DENSITY
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.ground import Relief, ground_height, ground_patch
from insectnav.worlds.plants import (
    CONIFER,
    SPARSE,
    check_heights,
    conifers,
    on_ground,
    scattered_in_box,
    shrubs,
    trees,
    tussocks,
)
from insectnav.worlds.shapes import Part, generator, mesh_from, quads
from insectnav.worlds.ways import distance_to_way

TRAIL_ABOVE_GROUND = 0.01  # [m]
MAX_TREES = 20_000


@dataclass(frozen=True, kw_only=True)
class ForestParams:
    """What a forest trail is made of.

    Parameters
    ----------
    length : float
        Of the trail, measured along +y [m].
    half_width : float
        Of the forest, to each side of the trail [m].
    bend, bend_length : float
        How far the trail swings to the sides, and the length of a swing [m].
    trail_half_width : float
        Free of plants below the height of the lowest boughs [m].
    tree_density, undergrowth_density : float
        On a square metre.
    conifer_share : float
        Of the trees.
    tree_height, undergrowth_height : pairs of float
        Least and greatest [m].
    n_gaps : int
        Openings of the canopy, evenly along the trail, the first half an interval from its start.
    gap_radius : float
        Within which no tree stands [m].
    foliage : float
        Season of the broad-leaved plants, 0 to 1.
    hills : float
        Height of the ground away from the trail [m].
    ground : str
        "litter", "soil", "grass" or "sand".
    way_step : float
        Between way points along +y [m].

    Raises
    ------
    InputError
        If a number makes no sense.
    """

    length: float = 150.0  # [m]
    half_width: float = 22.0  # [m]
    bend: float = 5.0  # [m]
    bend_length: float = 70.0  # [m]
    trail_half_width: float = 1.5  # [m]
    tree_density: float = 0.035  # [1/m²]
    undergrowth_density: float = 0.03  # [1/m²]
    conifer_share: float = 0.35
    tree_height: tuple[float, float] = (11.0, 21.0)  # [m]
    undergrowth_height: tuple[float, float] = (0.4, 1.6)  # [m]
    n_gaps: int = 4
    gap_radius: float = 8.0  # [m]
    foliage: float = 1.0
    hills: float = 1.5  # [m]
    ground: str = "litter"
    way_step: float = 0.5  # [m]

    def __post_init__(self) -> None:
        check_range("length", self.length, 5.0, 2000.0, "m")
        check_range("half_width", self.half_width, 3.0, 300.0, "m")
        check_range("bend", self.bend, 0.0, 50.0, "m")
        check_range("bend_length", self.bend_length, 5.0, 2000.0, "m")
        check_range("trail_half_width", self.trail_half_width, 0.1, self.half_width, "m")
        check_range("tree_density", self.tree_density, 0.0, MAX_DENSITY, "trees on a square metre")
        check_range("undergrowth_density", self.undergrowth_density, 0.0, MAX_DENSITY, "plants on a square metre")
        n_trees = self.tree_density * 2 * (self.half_width + self.bend) * (self.length + 40.0)
        check_range("mean number of trees", n_trees, 0, MAX_TREES, slip="density for a hectare?")
        check_range("conifer_share", self.conifer_share, 0.0, 1.0)
        check_heights("tree_height", self.tree_height)
        check_heights("undergrowth_height", self.undergrowth_height)
        check_count("n_gaps", self.n_gaps, minimum=0)
        check_range("gap_radius", self.gap_radius, 0.0, 100.0, "m")
        check_range("foliage", self.foliage, 0.0, 1.0, slip="in percent?")
        check_range("hills", self.hills, 0.0, 50.0, "m")
        check_choice("ground", self.ground, GROUNDS)
        check_range("way_step", self.way_step, 0.01, 10.0, "m")


def forest_trail(params: ForestParams | None = None, *, seed: int = 0) -> BuiltWorld:
    """A forest with a trail from the origin northwards; the route is the middle of the trail.

    Parameters
    ----------
    params : ForestParams
    seed : int
        Not negative. The same seed gives the same forest, bit for bit; season moves no tree.

    Raises
    ------
    InputError
        If the seed is negative.
    """
    params = ForestParams() if params is None else params
    check_count("seed", seed, minimum=0)
    route = _trail(generator(seed, "forest trail"), params)
    way = route[:: max(1, round(2.0 / params.way_step))]
    way = np.concatenate([way, route[-1:]])
    beyond = 20.0
    low = (float(route[:, 0].min()) - params.half_width, -beyond)
    high = (float(route[:, 0].max()) + params.half_width, params.length + beyond)
    relief = Relief(height=params.hills, wavelength=25.0, level_within=params.trail_half_width, rise=8.0,
                    way=tuple((float(x), float(y)) for x, y in way), seed=seed)  # fmt: skip
    parts = _trees(seed, params, relief, route, low, high)
    parts += _undergrowth(seed, params, relief, low, high)
    parts.append((params.ground, ground_patch(low, high, relief, tile=3.0)))
    parts.append(("soil", _ribbon(route, params.trail_half_width)))
    return BuiltWorld(
        mesh=mesh_from(parts, "forest-trail"),
        route=route,
        name="forest-trail",
        parameters=params,
        seed=seed,
        relief=relief,
    )


def canopy_gaps(route: Floats, params: ForestParams) -> Floats:
    """Middles of the openings of the canopy, on the trail, (gap, 2) array [m]."""
    at = (np.arange(params.n_gaps) + 0.5) / max(params.n_gaps, 1) * (len(route) - 1)
    return route[np.round(at).astype(int)]


def _trail(rng: np.random.Generator, params: ForestParams) -> Floats:
    """Way points of a trail that swings to both sides and begins at the origin."""
    n = max(2, round(params.length / params.way_step) + 1)
    y = np.linspace(0.0, params.length, n)
    phase, other = 2 * np.pi * rng.random(2)
    swing = 0.7 * np.sin(2 * np.pi * y / params.bend_length + phase)
    swing += 0.3 * np.sin(2 * np.pi * y / (0.43 * params.bend_length) + other)
    return np.stack([params.bend * (swing - swing[0]), y], axis=-1)


def _trees(
    seed: int, params: ForestParams, relief: Relief, route: Floats, low: tuple[float, float], high: tuple[float, float]
) -> list[Part]:
    rng = generator(seed, "forest trees")
    place = scattered_in_box(rng, params.tree_density, low, high)
    least, greatest = params.tree_height
    heights = least + (greatest - least) * rng.random(len(place))
    is_conifer = rng.random(len(place)) < params.conifer_share
    way = np.array(relief.way)
    reach = np.where(is_conifer, CONIFER.crown_radius, SPARSE.trunk_radius) * heights  # conifers have boughs low down
    free = distance_to_way(place, way) > params.trail_half_width + reach
    for gap in canopy_gaps(route, params):
        free &= ((place - gap) ** 2).sum(axis=-1) > params.gap_radius**2
    feet = on_ground(place, ground_height(place, relief))
    broad, slim = free & ~is_conifer, free & is_conifer
    shapes = generator(seed, "forest shapes of trees")
    needles = generator(seed, "forest shapes of conifers")
    return [
        *trees(shapes, feet[broad], heights[broad], SPARSE, foliage=params.foliage),
        *conifers(needles, feet[slim], heights[slim]),
    ]


def _undergrowth(
    seed: int, params: ForestParams, relief: Relief, low: tuple[float, float], high: tuple[float, float]
) -> list[Part]:
    """Ferns, three in four, and shrubs; none reaches over the trail."""
    rng = generator(seed, "forest undergrowth")
    place = scattered_in_box(rng, params.undergrowth_density, low, high)
    least, greatest = params.undergrowth_height
    heights = least + (greatest - least) * rng.random(len(place))
    is_fern = rng.random(len(place)) < 0.75
    free = distance_to_way(place, relief.way) > params.trail_half_width + heights
    feet = on_ground(place, ground_height(place, relief))
    fern, shrub = free & is_fern, free & ~is_fern
    ferns, others = generator(seed, "forest ferns"), generator(seed, "forest shrubs")
    return [
        ("leaves", tussocks(ferns, feet[fern], heights[fern], n_blades=9, foliage=params.foliage)),
        *shrubs(others, feet[shrub], heights[shrub], n_leaves=24, foliage=params.foliage),
    ]


def _ribbon(route: Floats, half_width: float) -> Floats:
    """Trodden soil along the trail, a finger's breadth above the level ground."""
    along = np.gradient(route, axis=0)
    along /= np.sqrt((along**2).sum(axis=-1, keepdims=True))
    right = np.stack([along[:, 1], -along[:, 0]], axis=-1) * half_width
    edges = np.stack([on_ground(route + side, TRAIL_ABOVE_GROUND) for side in (-right, right)], axis=1)
    edges = np.concatenate([edges[:-1:4], edges[-1:]])
    return quads(np.stack([edges[:-1, 0], edges[:-1, 1], edges[1:, 1], edges[1:, 0]], axis=1))
