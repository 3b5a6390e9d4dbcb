"""A city: streets, squares and parks on an uneven grid, and a closed walk of about two kilometres through them."""

from dataclasses import dataclass

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import check_count, check_range
from insectnav.worlds.building_rows import row_of_buildings
from insectnav.worlds.buildings import Building, building, tower
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.ground import ground_patch
from insectnav.worlds.moving import cars, people, traffic, walkers
from insectnav.worlds.plants import TOWN, on_ground, trees
from insectnav.worlds.shapes import Part, box, frustum, generator, joined, mesh_from, placed
from insectnav.worlds.ways import distance_to_way, stepped

N_STREETS = 7  # in each direction
# Crossings of the walk, as numbers of streets from the west and from the south; 20 blocks long, clockwise.
LOOP = ((1, 1), (1, 3), (2, 3), (2, 4), (1, 4), (1, 5), (3, 5), (3, 4), (4, 4), (4, 5), (5, 5), (5, 1))
LOOP_BLOCKS = 20
KERB, LAWN = 0.12, 0.15  # [m] above the road
_FROM_KERB = 0.3  # [m] on the road, where the walk goes


@dataclass(frozen=True, kw_only=True)
class CityParams:
    """What a city is made of.

    Parameters
    ----------
    loop_length : float
        Of the closed walk, about [m]; the city is 0.3 of it across.
    street_width : pair of float
        Least and greatest, from wall to wall [m].
    storeys : pair of int
        Least and greatest of a block; a building may differ from its block by one.
    park_share, square_share : float
        Of the blocks along the walk; at least one of each, and the first square has a church.
    scaffold_share : float
        Of the buildings near the walk.
    gap_share : float
        Of the plots that stand empty.
    foliage : float
        Season of the trees, 0 to 1.
    n_cars, n_people : int
        That move in the whole city.
    time_s : float
        At which they are shown [s]; nothing else changes with it.
    window_range : float
        Distance from the walk up to which buildings have windows [m].
    way_step : float
        Between way points, about [m].

    Raises
    ------
    InputError
        If a number makes no sense.
    """

    loop_length: float = 2000.0  # [m]: Stone et al. 2014, Robotics: Science and Systems X
    street_width: tuple[float, float] = (11.0, 22.0)  # [m]
    storeys: tuple[int, int] = (2, 6)
    park_share: float = 0.12
    square_share: float = 0.10
    scaffold_share: float = 0.06
    gap_share: float = 0.08
    foliage: float = 1.0
    n_cars: int = 60
    n_people: int = 120
    time_s: float = 0.0  # [s]
    window_range: float = 45.0  # [m]
    way_step: float = 1.0  # [m]

    def __post_init__(self) -> None:
        check_range("loop_length", self.loop_length, 1000.0, 5000.0, "m", slip="in kilometres?")
        check_range("least street_width", self.street_width[0], 10.0, 40.0, "m")
        check_range("greatest street_width", self.street_width[1], self.street_width[0], 40.0, "m")
        check_count("least storeys", self.storeys[0])
        check_count("greatest storeys", self.storeys[1], minimum=self.storeys[0])
        check_range("greatest storeys", self.storeys[1], 1, 50)
        for share in ("park_share", "square_share", "scaffold_share", "gap_share"):
            check_range(share, getattr(self, share), 0.0, 0.5)
        check_range("foliage", self.foliage, 0.0, 1.0, slip="in percent?")
        check_count("n_cars", self.n_cars, minimum=0)
        check_count("n_people", self.n_people, minimum=0)
        check_range("time_s", self.time_s, -1e9, 1e9, "s")
        check_range("window_range", self.window_range, 0.0, 5000.0, "m")
        check_range("way_step", self.way_step, 0.05, 20.0, "m")


@dataclass(frozen=True, kw_only=True, eq=False)
class _Streets:
    """Where the streets run: `middle[axis][k]` [m], and how wide they are; axis 0 are those that run north."""

    middle: Floats  # (2, street)
    width: Floats  # (2, street)

    @property
    def road(self) -> Floats:
        """Width between the kerbs, (2, street) [m]."""
        return 0.6 * self.width


def city(params: CityParams | None = None, *, seed: int = 0) -> BuiltWorld:
    """A city; the route is a loop that begins and ends at the origin, on the road by the right-hand kerb.

    Parameters
    ----------
    params : CityParams
    seed : int
        Not negative. The same seed gives the same city, bit for bit; season and time move no building.

    Raises
    ------
    InputError
        If the seed is negative.

    Notes
    -----
    Made for the kind of walk of Stone et al. 2014 (2 km through narrow streets, city parks and squares, with moving
    traffic and pedestrians, seen from 2 m): nothing that moves is as high as such an eye, so none of it is above the
    horizon. Nothing that moves stands on the route.
    """
    params = CityParams() if params is None else params
    check_count("seed", seed, minimum=0)
    rng = generator(seed, "city streets")
    streets, route = _streets_and_route(rng, params)
    parts: list[Part] = []
    kinds = _kinds_of_blocks(rng, streets, route, params)
    for (i, j), kind in kinds.items():
        low = streets.middle[:, [i, j]].diagonal() + streets.width[:, [i, j]].diagonal() / 2
        high = streets.middle[:, [i + 1, j + 1]].diagonal() - streets.width[:, [i + 1, j + 1]].diagonal() / 2
        kerb_low = streets.middle[:, [i, j]].diagonal() + streets.road[:, [i, j]].diagonal() / 2
        kerb_high = streets.middle[:, [i + 1, j + 1]].diagonal() - streets.road[:, [i + 1, j + 1]].diagonal() / 2
        parts.append(("paving", _slab(kerb_low, kerb_high, KERB)))
        own = generator(seed, f"city block {i} {j}")
        parts += (
            _block(own, low, high, route, params) if kind == "houses" else _open_block(own, low, high, kind, params)
        )
    parts += _street_furniture(generator(seed, "city furniture"), streets, route, params)
    parts += _moving(seed, streets, route, params)
    margin = 30.0
    low, high = streets.middle.min(axis=1) - margin, streets.middle.max(axis=1) + margin
    parts.append(("asphalt", ground_patch((low[0], low[1]), (high[0], high[1]))))
    return BuiltWorld(mesh=mesh_from(parts, "city"), route=route, name="city", parameters=params, seed=seed)


def _streets_and_route(rng: np.random.Generator, params: CityParams) -> tuple[_Streets, Floats]:
    """Streets about a pitch apart, and the walk along some of them; the walk begins at the origin."""
    pitch = params.loop_length / LOOP_BLOCKS
    gaps = 0.85 + 0.3 * rng.random((2, N_STREETS - 1))
    gaps *= pitch / gaps[:, 1:5].mean(axis=1, keepdims=True)
    middle = np.concatenate([np.zeros((2, 1)), np.cumsum(gaps, axis=1)], axis=1)
    least, greatest = params.street_width
    width = least + (greatest - least) * rng.random((2, N_STREETS))
    streets = _Streets(middle=middle, width=width)
    aside = streets.road / 2 - _FROM_KERB
    corners = []
    for before, here, after in zip((LOOP[-1], *LOOP[:-1]), LOOP, (*LOOP[1:], LOOP[0]), strict=True):
        upright, level = ((before, here), (here, after)) if before[0] == here[0] else ((here, after), (before, here))
        east = np.sign(upright[1][1] - upright[0][1])  # to the right of north is east
        north = -np.sign(level[1][0] - level[0][0])
        x = middle[0, here[0]] + east * aside[0, here[0]]
        corners.append((x, middle[1, here[1]] + north * aside[1, here[1]]))
    start = np.array(corners[0])
    shifted = _Streets(middle=middle - start[:, None], width=width)
    return shifted, stepped(np.array([*corners, corners[0]]) - start, params.way_step)


def _kinds_of_blocks(
    rng: np.random.Generator, streets: _Streets, route: Floats, params: CityParams
) -> dict[tuple[int, int], str]:
    """What each block holds: "houses", "park", "church" or "square"."""
    numbers = [(i, j) for i in range(N_STREETS - 1) for j in range(N_STREETS - 1)]
    centres = np.array([[streets.middle[axis, [n[axis], n[axis] + 1]].mean() for axis in (0, 1)] for n in numbers])
    by_walk = np.flatnonzero(distance_to_way(centres, route) < 0.75 * params.loop_length / LOOP_BLOCKS)
    by_walk = rng.permutation(by_walk)
    n_parks, n_squares = (max(1, round(share * len(by_walk))) for share in (params.park_share, params.square_share))
    kinds = dict.fromkeys(numbers, "houses")
    kinds |= {numbers[k]: "park" for k in by_walk[:n_parks]}
    kinds |= {numbers[k]: "square" for k in by_walk[n_parks : n_parks + n_squares]}
    kinds[numbers[by_walk[n_parks]]] = "church"
    return kinds


def _slab(low: Floats, high: Floats, height: float) -> Floats:
    middle, sides = (low + high) / 2, high - low
    return box(sides[0], sides[1], height) + np.array([middle[0], middle[1], 0.0])


def _block(rng: np.random.Generator, low: Floats, high: Floats, route: Floats, params: CityParams) -> list[Part]:
    """Houses round a yard: whole rows along the west and east sides, and between them along the others."""
    depth = 10.0 + 3.0 * rng.random()
    storeys = int(rng.integers(params.storeys[0], params.storeys[1] + 1))
    is_flat = rng.random() < 0.3
    parts: list[Part] = []
    sides = [
        (np.array([low[0] + depth / 2, (low[1] + high[1]) / 2]), high[1] - low[1], -np.pi / 2),
        (np.array([high[0] - depth / 2, (low[1] + high[1]) / 2]), high[1] - low[1], np.pi / 2),
        (np.array([(low[0] + high[0]) / 2, low[1] + depth / 2]), high[0] - low[0] - 2 * depth, np.pi),
        (np.array([(low[0] + high[0]) / 2, high[1] - depth / 2]), high[0] - low[0] - 2 * depth, 0.0),
    ]
    for middle, length, heading in sides:
        parts += row_of_buildings(
            rng, middle, length, heading, depth=depth, storeys=storeys, is_flat=is_flat, base=KERB, route=route,
            window_range=params.window_range, scaffold_share=params.scaffold_share, gap_share=params.gap_share,
        )  # fmt: skip
    return parts


def _open_block(rng: np.random.Generator, low: Floats, high: Floats, kind: str, params: CityParams) -> list[Part]:
    """A park with trees, or a paved square with trees at its sides and a church tower or a column in the middle."""
    sides, middle = high - low, (low + high) / 2
    if kind == "park":
        n = int(rng.poisson(0.004 * sides[0] * sides[1]))
        feet = on_ground(low + sides * (0.06 + 0.88 * rng.random((n, 2))), LAWN)
        heights = 7.0 + 11.0 * rng.random(n)
        return [("grass", _slab(low, high, LAWN)), *trees(rng, feet, heights, TOWN, foliage=params.foliage)]
    along = np.arange(0.1, 0.95, 0.2)
    ring = np.array([(share, edge) for edge in (0.06, 0.94) for share in along])
    feet = on_ground(low + sides * ring, KERB)
    parts = trees(rng, feet, 5.0 + 3.0 * rng.random(len(feet)), TOWN, foliage=params.foliage)
    at = np.array([middle[0], middle[1], KERB])
    if kind == "church":
        nave = Building(
            width=30.0,
            depth=14.0,
            height=11.0,
            pitch=0.9,
            walls="sandstone",
            roofing="slate",
            bay=5.0,
            has_back_windows=True,
        )
        parts += [(name, placed(body, [at - [0.0, 19.0, 0.0]], np.pi / 2)[0]) for name, body in building(nave)]
        shaft = tower(8.0, 45.0 + 20.0 * rng.random(), "sandstone", "slate")
        return [*parts, *((name, body + at) for name, body in shaft)]
    column = joined([box(3.0, 3.0, 1.5), frustum(8, 0.6, 0.5, 9.0, base=1.5)])
    return [*parts, ("limestone", column + at)]


def _street_furniture(rng: np.random.Generator, streets: _Streets, route: Floats, params: CityParams) -> list[Part]:
    """Lamps by the kerb of all streets, and trees along the wide ones."""
    lamps: list[Floats] = []
    feet: list[Floats] = []
    ends = streets.middle[:, [0, -1]]
    for axis in (0, 1):
        for middle, road, width in zip(streets.middle[axis], streets.road[axis], streets.width[axis], strict=True):
            for side in (-1, 1):
                along = np.arange(ends[1 - axis, 0] + 20.0 * rng.random(), ends[1 - axis, 1], 30.0)
                aside = np.full(len(along), middle + side * (road / 2 + 1.2))
                here = _off_the_roads(np.stack([aside, along] if axis == 0 else [along, aside], axis=-1), streets)
                (feet if width > 18.0 else lamps).append(here)
    near = np.concatenate([np.zeros((0, 2)), *feet])
    places = on_ground(near[distance_to_way(near, route[::5]) < params.window_range], KERB)
    posts = on_ground(np.concatenate([np.zeros((0, 2)), *lamps]), KERB)
    heights = 7.5 + 4.0 * rng.random(len(places))
    return [
        ("weathered metal", joined([placed(frustum(4, 0.08, 0.05, 6.5), posts)])),
        *trees(rng, places, heights, TOWN, foliage=params.foliage),
    ]


def _off_the_roads(positions: Floats, streets: _Streets) -> Floats:
    """Those of the positions that are a metre or more from the roads, though they be on a pavement."""
    off = np.abs(positions[:, :, None] - streets.middle[None])
    return positions[(off > streets.road / 2 + 0.5).all(axis=(1, 2))]


def _moving(seed: int, streets: _Streets, route: Floats, params: CityParams) -> list[Part]:
    """Cars on both lanes of the streets, people on the pavements of the blocks."""
    ends = streets.middle[:, [0, -1]]
    lanes, walks = [], []
    for axis in (0, 1):
        for k in range(N_STREETS):
            for way in (1, -1):
                lane = streets.middle[axis, k] + (way if axis == 0 else -way) * streets.road[axis, k] / 4
                line = [[lane, end] if axis == 0 else [end, lane] for end in ends[1 - axis][::way]]
                lanes.append(line)
                pavement = streets.middle[axis, k] + way * 0.4 * streets.width[axis, k]
                for low, high in zip(streets.middle[1 - axis], streets.middle[1 - axis][1:], strict=False):
                    clear = np.array([low + 15.0, high - 15.0])[:: 1 if (k + way) % 4 else -1]
                    walks.append([[pavement, end] if axis == 0 else [end, pavement] for end in clear])
    time_s = params.time_s
    driving, courses = traffic(generator(seed, "city cars"), np.array(lanes), params.n_cars, time_s, route)
    walking, ways = walkers(generator(seed, "city people"), np.array(walks), params.n_people, time_s, route)
    return [
        *cars(generator(seed, "city shapes of cars"), on_ground(driving), courses),
        *people(generator(seed, "city shapes of people"), on_ground(walking, KERB), ways),
    ]
