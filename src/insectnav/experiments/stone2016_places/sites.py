"""The three sites of the paper, built: part of a city, a BMX track from a forest to a street, a disposal site.

The sites are stand-ins made from what the text says of the places (section IV-B): "urban streets"; "a BMX track in a
forest, heavy forest canopy", then "a border between a forest (right side) and the gardens of adjoining houses (left
side)", then "a suburban street"; "mainly a road through a forest marked by a single road junction, a disposal site and
a small building". All sizes are assumed but the lengths of the ways. What moves is where it is at `time_s`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.records import Mesh
from insectnav.worlds.buildings import Building, building
from insectnav.worlds.city import CityParams, city
from insectnav.worlds.ground import ground_patch
from insectnav.worlds.moving import cars
from insectnav.worlds.plants import SPARSE, conifers, hedge, on_ground, scattered_in_box, shrubs, trees, tussocks
from insectnav.worlds.shapes import Part, box, frustum, generator, joined, mesh_from, placed
from insectnav.worlds.street import StreetParams, suburban_street
from insectnav.worlds.ways import distance_to_way

Bools = npt.NDArray[np.bool_]
HELMET, RC_CAR = 1.9, 0.3  # [m] above the ground: a camera on a cyclist's helmet, on a remote-controlled car; assumed
CYCLING, RC_DRIVING = 5.0, 3.0  # [m/s] assumed
FOREST_END, GARDENS_END = 260.0, 450.0  # [m] along +y, of the BMX track
JUNCTION, DISPOSAL, HUT = 170.0, (325.0, 385.0), 405.0  # [m] along +y, of the disposal site
TREES_BESIDE = 40.0  # [m] of wood beside a way, so deep that little sky is seen between the trunks


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """A site at one time: its surfaces and the way through it.

    Parameters
    ----------
    mesh : Mesh
    way : (n, 2) array [m]
    ground : material beyond the mesh
    """

    mesh: Mesh
    way: Floats
    ground: str


@dataclass(frozen=True, kw_only=True)
class Site:
    """A site of the paper.

    Parameters
    ----------
    name : of the data set
    build : from a seed and `time_s` [s] to the site at that time
    length : of the way [m], as published
    eye_height : of the camera [m]
    speed : mean [m/s]
    """

    name: str
    build: Callable[[int, float], Ground]
    length: float
    eye_height: float
    speed: float

    @property
    def n_frames(self) -> int:
        """Frames of a passage at five in a second: ten frames are two seconds of travel (caption of Fig. 8)."""
        return round(5.0 * self.length / self.speed)


def city_streets(seed: int, time_s: float) -> Ground:
    """A city in summer; of its closed walk of two kilometres the beginning is cycled."""
    built = city(CityParams(time_s=time_s), seed=seed)
    return Ground(mesh=built.mesh, way=built.route, ground="asphalt")


def bmx_track(seed: int, time_s: float) -> Ground:
    """Forest, its border with gardens on the left, a suburban street."""
    y = np.arange(0.0, 606.0, 0.5)
    inside = np.clip((FOREST_END - y) / 40.0, 0.0, 1.0)
    way = np.stack([4.0 * np.sin(2.0 * np.pi * y / 80.0) * inside, y], axis=-1)
    street = suburban_street(StreetParams(length=180.0, time_s=time_s), seed=seed)
    parts = [*_forest(seed, way, (-TREES_BESIDE, -40.0), (TREES_BESIDE, FOREST_END), density=0.055, conifer_share=0.2)]
    parts += _forest(seed + 1, way, (2.0, FOREST_END), (TREES_BESIDE, GARDENS_END - 25.0), 0.055, conifer_share=0.2)
    parts += _gardens(generator(seed, "bmx gardens"))
    parts += _parts_of(street.mesh, (0.0, GARDENS_END, 0.0))
    parts.append(("litter", ground_patch((-50.0, -45.0), (50.0, FOREST_END))))
    parts.append(("grass", ground_patch((-48.0, FOREST_END), (48.0, GARDENS_END - 25.0))))
    return Ground(mesh=mesh_from(parts, "bmx track"), way=way, ground="grass")


def disposal_site(seed: int, time_s: float) -> Ground:
    """A straight road through a plantation of conifers; what marks it is a junction, the site and a hut."""
    y = np.arange(0.0, 516.0, 0.5)
    way = np.stack([5.0 * np.sin(2.0 * np.pi * y / 260.0), y], axis=-1)
    side_road = np.array([[0.0, JUNCTION], [TREES_BESIDE + 15.0, JUNCTION + 4.0]])

    def is_free(place: Floats) -> Bools:
        x, along = place.T
        yard = (x < -3.0) & (along > DISPOSAL[0]) & (along < DISPOSAL[1])
        hut = (x > 3.0) & (x < 16.0) & (np.abs(along - HUT) < 7.0)
        return ~(yard | hut) & (distance_to_way(place, side_road) > 4.0)

    parts = _forest(seed, way, (-TREES_BESIDE, -40.0), (TREES_BESIDE, 555.0), 0.06, 0.75, (13.0, 17.0), 2.5, is_free)
    parts += _yard(generator(seed, "disposal yard"))
    hut = Building(width=6.0, depth=5.0, height=2.8, roof="flat", walls="concrete", bay=3.0)
    parts += [(name, placed(body, [(9.0, HUT, 0.0)], -np.pi / 2)[0]) for name, body in building(hut)]
    parts += _parked_van(generator(seed, f"disposal van {time_s:g}"))
    parts.append(("litter", ground_patch((-50.0, -45.0), (80.0, 560.0))))
    return Ground(mesh=mesh_from(parts, "disposal site"), way=way, ground="litter")


def _forest(
    seed: int,
    way: Floats,
    low: tuple[float, float],
    high: tuple[float, float],
    density: float,
    conifer_share: float,
    tree_height: tuple[float, float] = (11.0, 20.0),
    half_width: float = 1.5,
    is_free: Callable[[Floats], Bools] | None = None,
) -> list[Part]:
    """Trees and undergrowth in a rectangle; nothing but crowns within `half_width` [m] of the way."""
    rng = generator(seed, "place forest")
    place = scattered_in_box(rng, density, low, high)
    heights = tree_height[0] + (tree_height[1] - tree_height[0]) * rng.random(len(place))
    is_slim = rng.random(len(place)) < conifer_share
    free = distance_to_way(place, way) > half_width + np.where(is_slim, 0.1 * heights, 0.4)
    low_plants = scattered_in_box(rng, 0.05, low, high)
    tall = 0.3 + 0.9 * rng.random(len(low_plants))
    is_fern = rng.random(len(low_plants)) < 0.75
    clear = distance_to_way(low_plants, way) > half_width + tall
    if is_free is not None:
        free, clear = free & is_free(place), clear & is_free(low_plants)
    broad, slim, fern, shrub = free & ~is_slim, free & is_slim, clear & is_fern, clear & ~is_fern
    return [
        *trees(rng, on_ground(place[broad]), heights[broad], SPARSE),
        *conifers(rng, on_ground(place[slim]), heights[slim]),
        ("leaves", tussocks(rng, on_ground(low_plants[fern]), tall[fern], n_blades=9)),
        *shrubs(rng, on_ground(low_plants[shrub]), tall[shrub]),
    ]


def _gardens(rng: np.random.Generator) -> list[Part]:
    """Houses on the left with their backs to the way, hedges along it, garden trees and shrubs."""
    parts: list[Part] = []
    for middle in np.arange(FOREST_END + 9.0, GARDENS_END - 30.0, 17.0):
        chance = rng.random(8)
        plan = Building(
            width=8.0 + 4.0 * chance[0], depth=7.5 + 2.5 * chance[1], height=3.2 + 3.0 * chance[2],
            roof="gable" if chance[3] < 0.65 else "hip", pitch=0.6 + 0.3 * chance[4],
            walls="brick" if chance[5] < 0.5 else "render", bay=2.7, has_back_windows=True, has_chimney=chance[6] < 0.6,
        )  # fmt: skip
        at = (-17.0 - 5.0 * chance[7], middle, 0.0)
        parts += [(name, placed(body, [at], -np.pi / 2)[0]) for name, body in building(plan)]
        edge, reach = -2.6, 7.5
        if rng.random() < 0.7:
            parts += hedge(rng, np.array([edge, middle - reach]), np.array([edge, middle + reach]), 1.1 + rng.random())
        n = rng.poisson(2.0)
        place = np.stack([-5.0 - 7.0 * rng.random(n), middle + 16.0 * (rng.random(n) - 0.5)], axis=-1)
        parts += trees(rng, on_ground(place), 4.0 + 5.0 * rng.random(n), SPARSE)
        place = np.stack([-4.0 - 8.0 * rng.random(3), middle + 16.0 * (rng.random(3) - 0.5)], axis=-1)
        parts += shrubs(rng, on_ground(place), 0.6 + 0.9 * rng.random(3))
    return parts


def _yard(rng: np.random.Generator) -> list[Part]:
    """Containers, heaps and a fence on the left of the road."""
    low, high = DISPOSAL
    places = np.stack([-9.0 - 16.0 * rng.random(7), low + 6.0 + (high - low - 12.0) * rng.random(7)], axis=-1)
    container = box(2.5, 6.0, 2.6)
    heap = frustum(9, 1.0, 0.15, 0.55)
    heaps = np.stack([-10.0 - 15.0 * rng.random(5), low + 8.0 + (high - low - 16.0) * rng.random(5)], axis=-1)
    size = (2.0 + 2.0 * rng.random(5))[:, None, None, None]
    post = box(0.08, 0.08, 2.0)
    posts = np.arange(low, high, 3.0)
    fence = [placed(post, on_ground(np.stack([np.full(len(posts), -4.5), posts], axis=-1)))]
    return [
        ("weathered metal", joined([placed(container, on_ground(places), 2.0 * np.pi * rng.random(7)), *fence])),
        ("soil", joined([placed(heap * size, on_ground(heaps))])),
        ("concrete", ground_patch((-28.0, low), (-3.2, high)) + np.array([0.0, 0.0, 0.02])),
    ]


def _parked_van(rng: np.random.Generator) -> list[Part]:
    """A car in the yard, elsewhere at another time."""
    place = np.array([[-6.5, DISPOSAL[0] + 50.0 * rng.random()]])
    return cars(rng, on_ground(place), np.zeros(1))


def _parts_of(mesh: Mesh, shift: tuple[float, float, float]) -> list[Part]:
    """Parts of a mesh, moved."""
    material = np.asarray(mesh.material)
    moved = np.asarray(mesh.vertices, np.float64) + np.array(shift)
    return [(name, moved[material == k]) for k, name in enumerate(mesh.materials)]


CITY = Site(name="City", build=city_streets, length=520.0, eye_height=HELMET, speed=CYCLING)
BMX = Site(name="BMX Track", build=bmx_track, length=600.0, eye_height=RC_CAR, speed=RC_DRIVING)
YARD = Site(name="Disposal Site", build=disposal_site, length=510.0, eye_height=RC_CAR, speed=RC_DRIVING)
SITES = {site.name: site for site in (CITY, BMX, YARD)}
