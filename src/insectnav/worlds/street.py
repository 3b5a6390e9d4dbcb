"""A suburban street: houses with pitched roofs behind hedges, garden and street trees, and cars."""

from dataclasses import dataclass

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import check_count, check_range
from insectnav.worlds.buildings import Building, building
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.city import KERB
from insectnav.worlds.ground import ground_patch
from insectnav.worlds.moving import CAR_LENGTH, CAR_WIDTH, cars, clear_of, people, traffic, walkers
from insectnav.worlds.plants import SPARSE, TOWN, conifers, hedge, on_ground, shrubs, trees
from insectnav.worlds.shapes import Part, box, frustum, generator, joined, mesh_from, placed
from insectnav.worlds.ways import stepped

ROAD, PAVEMENT, GARDEN = 6.5, 2.0, 6.0  # [m] wide; garden is what lies before a house
BEHIND = 25.0  # [m] of garden behind the houses
END = 25.0  # [m] of street beyond the plots
_PARKED_FROM_KERB = 1.1  # [m]


@dataclass(frozen=True, kw_only=True)
class StreetParams:
    """What a suburban street is made of.

    Parameters
    ----------
    length : float
        Of the street, along +y [m].
    plot_width : float
        Of a house with its garden, about [m].
    house_width, house_height : pairs of float
        Least and greatest; the height is that of the walls [m].
    hedge_share, tree_share : float
        Of the plots that have a hedge before them, and a tree in the front garden.
    back_trees : float
        Trees on a plot behind the house, on average.
    hedge_height : pair of float
        Least and greatest [m].
    n_parked, n_cars, n_people : int
        Parked cars, and what moves.
    foliage : float
        Season, 0 to 1.
    time_s : float
        At which what moves is shown [s].
    way_step : float
        Between way points [m].

    Raises
    ------
    InputError
        If a number makes no sense.
    """

    length: float = 200.0  # [m]
    plot_width: float = 16.0  # [m]
    house_width: tuple[float, float] = (8.0, 11.5)  # [m]
    house_height: tuple[float, float] = (3.2, 6.2)  # [m]
    hedge_share: float = 0.6
    tree_share: float = 0.7
    back_trees: float = 2.0
    hedge_height: tuple[float, float] = (0.9, 1.9)  # [m]
    n_parked: int = 8
    n_cars: int = 2
    n_people: int = 4
    foliage: float = 1.0
    time_s: float = 0.0  # [s]
    way_step: float = 0.5  # [m]

    def __post_init__(self) -> None:
        check_range("length", self.length, 20.0, 1500.0, "m")
        check_range("plot_width", self.plot_width, 8.0, 60.0, "m")
        check_range("least house_width", self.house_width[0], 4.0, self.plot_width, "m")
        check_range("greatest house_width", self.house_width[1], self.house_width[0], self.plot_width, "m")
        check_range("least house_height", self.house_height[0], 2.2, 30.0, "m")
        check_range("greatest house_height", self.house_height[1], self.house_height[0], 30.0, "m")
        check_range("hedge_share", self.hedge_share, 0.0, 1.0)
        check_range("tree_share", self.tree_share, 0.0, 1.0)
        check_range("back_trees", self.back_trees, 0.0, 20.0)
        check_range("least hedge_height", self.hedge_height[0], 0.3, 5.0, "m")
        check_range("greatest hedge_height", self.hedge_height[1], self.hedge_height[0], 5.0, "m")
        for number in ("n_parked", "n_cars", "n_people"):
            check_count(number, getattr(self, number), minimum=0)
        check_range("foliage", self.foliage, 0.0, 1.0, slip="in percent?")
        check_range("time_s", self.time_s, -1e9, 1e9, "s")
        check_range("way_step", self.way_step, 0.01, 10.0, "m")


def suburban_street(params: StreetParams | None = None, *, seed: int = 0) -> BuiltWorld:
    """A street from the origin northwards; the route runs along the middle of the road.

    Parameters
    ----------
    params : StreetParams
    seed : int
        Not negative. The same seed gives the same street, bit for bit; season and time move no house.

    Raises
    ------
    InputError
        If the seed is negative.
    """
    params = StreetParams() if params is None else params
    check_count("seed", seed, minimum=0)
    route = stepped(np.array([(0.0, 0.0), (0.0, params.length)]), params.way_step)
    parts: list[Part] = []
    for side in (-1, 1):
        n_plots = max(1, round(params.length / params.plot_width))
        for plot in range(n_plots):
            middle = (plot + 0.5) * params.length / n_plots
            parts += _plot(generator(seed, f"street plot {side} {plot}"), side, middle, params.length / n_plots, params)
    parts += _pavements(params)
    parts += _on_the_street(seed, route, params)
    half = ROAD / 2 + PAVEMENT + GARDEN + 12.0 + BEHIND
    parts.append(("asphalt", ground_patch((-half, -END), (half, params.length + END))))
    return BuiltWorld(mesh=mesh_from(parts, "suburban-street"), route=route, name="suburban-street",
                      parameters=params, seed=seed)  # fmt: skip


def _plot(rng: np.random.Generator, side: int, middle: float, width: float, params: StreetParams) -> list[Part]:
    """A house, its hedge, trees and shrubs; `side` is −1 in the west and 1 in the east of the street."""
    chance = rng.random(12)
    heading = -side * np.pi / 2  # the front looks at the street
    storeys = params.house_height[0] + (params.house_height[1] - params.house_height[0]) * chance[0]
    plan = Building(
        width=params.house_width[0] + (params.house_width[1] - params.house_width[0]) * chance[1],
        depth=7.5 + 2.5 * chance[2], height=storeys, roof="gable" if chance[3] < 0.65 else "hip",
        pitch=0.6 + 0.3 * chance[4], walls="brick" if chance[5] < 0.5 else "render",
        roofing="tiles" if chance[6] < 0.7 else "slate", bay=2.7, has_back_windows=True, has_chimney=chance[7] < 0.6,
    )  # fmt: skip
    line = ROAD / 2 + PAVEMENT
    front = line + GARDEN + 2.0 * chance[8]
    spare = 0.5 * (width - plan.width)
    at = (side * (front + plan.depth / 2), middle + spare * (chance[9] - 0.5), KERB)
    parts = [(name, placed(body, [at], heading)[0]) for name, body in building(plan)]
    if chance[10] < params.hedge_share:
        height = params.hedge_height[0] + (params.hedge_height[1] - params.hedge_height[0]) * rng.random()
        x, reach = side * (line + 0.36 * height + 0.1), 0.5 * width - 1.6  # a gate's width between two hedges
        ends = np.array([(x, middle - reach), (x, middle + reach)])
        parts += [
            (name, body + np.array([0.0, 0.0, KERB]))
            for name, body in hedge(rng, ends[0], ends[1], height, foliage=params.foliage)
        ]
    if chance[11] < params.tree_share:
        foot = np.array([[side * (line + 0.6 * GARDEN), middle + 0.3 * width * (2 * rng.random() - 1), KERB]])
        parts += trees(rng, foot, np.array([3.5 + 4.0 * rng.random()]), TOWN, foliage=params.foliage)
    n = rng.poisson(params.back_trees)
    x = side * (front + plan.depth + 4.0 + (BEHIND - 8.0) * rng.random(n))
    feet = np.stack([x, middle + width * (rng.random(n) - 0.5), np.full(n, KERB)], axis=-1)
    heights, is_conifer = 6.0 + 9.0 * rng.random(n), rng.random(n) < 0.3
    parts += trees(rng, feet[~is_conifer], heights[~is_conifer], SPARSE, foliage=params.foliage)
    parts += conifers(rng, feet[is_conifer], heights[is_conifer])
    low = np.array([[side * (front - 0.9), middle + 0.35 * width * (2 * rng.random() - 1), KERB]])
    return [*parts, *shrubs(rng, low, np.array([0.7 + 0.6 * rng.random()]), n_leaves=30, foliage=params.foliage)]


def _pavements(params: StreetParams) -> list[Part]:
    """Pavements and lawns on both sides, a step above the road; lamps along one side."""
    length = params.length + 2 * END
    breadth = GARDEN + 12.0 + BEHIND
    parts: list[Part] = []
    for side in (-1, 1):
        for name, x, width in (
            ("paving", ROAD / 2 + PAVEMENT / 2, PAVEMENT),
            ("grass", ROAD / 2 + PAVEMENT + breadth / 2, breadth),
        ):
            parts.append((name, box(width, length, KERB) + np.array([side * x, params.length / 2, 0.0])))
    along = np.arange(10.0, params.length, 30.0)
    posts = np.stack([np.full(len(along), ROAD / 2 + 0.4), along, np.full(len(along), KERB)], axis=-1)
    return [*parts, ("weathered metal", joined([placed(frustum(4, 0.07, 0.05, 6.0), posts)]))]


def _on_the_street(seed: int, route: Floats, params: StreetParams) -> list[Part]:
    """Parked cars at both kerbs, cars that drive, people on the pavements."""
    rng = generator(seed, "street parked cars")
    slots = np.arange(4.0, params.length - 3.0, 6.0)
    slots = np.array([(side * (ROAD / 2 - _PARKED_FROM_KERB), y) for side in (-1, 1) for y in slots])
    parked = slots[rng.permutation(len(slots))[: params.n_parked]]
    facing = np.where(parked[:, 0] > 0, 0.0, np.pi)
    start, end = -END, params.length + END
    pavement = ROAD / 2 + PAVEMENT / 2
    lanes = np.array([[(x, low), (x, high)] for x, low, high in ((1.6, start, end), (-1.6, end, start))])
    walks = np.array([[(x, low), (x, high)] for x in (-pavement, pavement) for low, high in lanes[:, :, 1]])
    driving, courses = traffic(generator(seed, "street cars"), lanes, params.n_cars, params.time_s, route)
    free = clear_of(parked, driving, courses, 2 * CAR_LENGTH, 2 * CAR_WIDTH)
    place = np.concatenate([parked, driving[free]])
    walking, ways = walkers(generator(seed, "street people"), walks, params.n_people, params.time_s, route)
    return [
        *cars(generator(seed, "street paints"), on_ground(place), np.concatenate([facing, courses[free]])),
        *people(generator(seed, "street walkers"), on_ground(walking, KERB), ways),
    ]
