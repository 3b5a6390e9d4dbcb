"""Places with buildings, for a camera that stands at the origin and looks along +y."""

from itertools import pairwise

import numpy as np

from insectnav.angles import Floats
from insectnav.experiments.stone2014_sky_segmentation.scene_plants import bushes, leafy_trees, scattered_feet
from insectnav.records import Mesh
from insectnav.worlds.building_rows import row_of_buildings
from insectnav.worlds.buildings import Building, building, tower
from insectnav.worlds.ground import ground_patch
from insectnav.worlds.moving import cars, people
from insectnav.worlds.shapes import Part, box, frustum, generator, joined, mesh_from, placed, quads, upright_quads

TOWARDS = np.pi  # [rad] heading of a front that looks at the camera


def hidden_building(seed: int) -> Mesh:
    """A house of brick behind trees and bushes."""
    rng = generator(seed, "hidden building")
    house = Building(width=24.0, depth=11.0, height=8.0, walls="brick", roofing="slate", has_chimney=True)
    screen = scattered_feet(rng, 9, (-17.0, 18.0), (17.0, 27.0))
    low = scattered_feet(rng, 12, (-14.0, 14.0), (14.0, 22.0))
    behind = scattered_feet(rng, 18, (-45.0, 48.0), (45.0, 70.0))
    return _scene(
        "hidden building",
        [
            *_standing(building(house), (0.0, 36.0), TOWARDS),
            *leafy_trees(rng, screen, 5.5 + 4.5 * rng.random(len(screen)), leaf=0.35, density=2.4),
            *bushes(rng, low, 0.8 + 1.2 * rng.random(len(low)), leaf=0.22, density=2.2),
            *leafy_trees(rng, behind, 9.0 + 5.0 * rng.random(len(behind)), leaf=0.6),
        ],
        "grass",
    )


def minaret(seed: int, walls: str = "sandstone") -> Mesh:
    """A minaret with a gallery and a pointed roof, beside a prayer hall with a dome; houses and trees below."""
    rng = generator(seed, "minaret")
    shaft = [
        (walls, box(5.0, 5.0, 6.0)),
        (walls, frustum(8, 2.3, 2.0, 18.0, base=6.0)),
        (walls, frustum(8, 2.0, 3.1, 0.9, base=24.0)),  # below the gallery
        (walls, frustum(8, 3.1, 3.1, 1.0, base=24.9)),
        (walls, frustum(8, 1.5, 1.4, 5.0, base=24.9)),
        (walls, frustum(8, 1.4, 1.9, 0.5, base=29.9)),
        ("slate", frustum(8, 1.9, 0.0, 5.5, base=30.4)),
        ("metal", frustum(6, 0.12, 0.03, 1.6, base=35.7)),
    ]
    slits = upright_quads(np.array([(0.0, 2.6, z) for z in (3.0, 4.6)]), 0.7, 1.1)
    shaft.append(("window", slits))
    hall: list[Part] = [(walls, box(22.0, 16.0, 7.5)), (walls, _dome(5.0, 7.5))]
    arches = upright_quads(np.array([(x, 8.03, 3.2) for x in np.linspace(-8.0, 8.0, 6)]), 1.6, 3.6)
    hall.append(("window", arches))
    trees = scattered_feet(rng, 5, (-24.0, 26.0), (20.0, 33.0))
    houses = row_of_buildings(
        rng, np.array([0.0, 85.0]), 120.0, TOWARDS, depth=12.0, storeys=3, is_flat=False, base=0.0,
        route=np.array([[0.0, 0.0], [0.0, 60.0]]), window_range=50.0, scaffold_share=0.0, gap_share=0.1,
    )  # fmt: skip
    return _scene(
        "minaret",
        [
            *_standing(shaft, (5.0, 42.0), TOWARDS),
            *_standing(hall, (-10.0, 50.0), TOWARDS),
            *houses,
            *leafy_trees(rng, trees, 4.0 + 3.0 * rng.random(len(trees)), leaf=0.2),
        ],
        "paving",
    )


def white_building(seed: int) -> Mesh:
    """A white flat-roofed block of three storeys on a lawn, with two trees."""
    rng = generator(seed, "white building")
    block = Building(width=26.0, depth=14.0, height=10.5, roof="flat", walls="white paint", bay=3.2)
    wing = Building(width=12.0, depth=10.0, height=6.8, roof="flat", walls="white paint", bay=3.2)
    feet = np.array([(-13.0, 24.0, 0.0), (16.0, 30.0, 0.0)])
    hedge = np.stack([np.linspace(-12.0, 4.0, 12), np.full(12, 26.5), np.zeros(12)], axis=-1)
    behind = scattered_feet(rng, 12, (-50.0, 60.0), (50.0, 75.0))
    return _scene(
        "white building",
        [
            *_standing(building(block), (-2.0, 36.0), TOWARDS),
            *_standing(building(wing), (17.5, 39.0), TOWARDS),
            *leafy_trees(rng, feet, np.array([7.5, 9.0]), leaf=0.3),
            *bushes(rng, hedge, np.full(12, 1.1), leaf=0.18, density=2.0),
            *leafy_trees(rng, behind, 8.0 + 5.0 * rng.random(len(behind)), leaf=0.6),
        ],
        "grass",
    )


def metallic_roof(seed: int) -> Mesh:
    """A hall of brick under a roof of aluminium and zinc sheet with standing seams, its slope towards the camera."""
    rng = generator(seed, "metallic roof")
    hall = Building(width=30.0, depth=16.0, height=5.0, walls="brick", roofing="metal", pitch=0.42, bay=4.0)
    slope = np.tan(hall.pitch)
    seams = []
    for x in np.arange(-14.5, 15.0, 1.0):
        foot, ridge = np.array([x, 8.3, hall.height - 0.3 * slope]), np.array([x, 0.0, hall.top])
        seams.append(_beam(foot, ridge, 0.06, 0.08))
    trees = scattered_feet(rng, 7, (-38.0, 38.0), (38.0, 50.0))
    shed = Building(width=7.0, depth=5.0, height=2.8, walls="timber", roofing="weathered metal", pitch=0.3, bay=0.0)
    parked = cars(generator(seed, "paints"), np.array([(-7.0, 15.5, 0.0), (-3.5, 15.8, 0.0)]), np.array([0.1, 0.0]))
    return _scene(
        "metallic roof",
        [
            *_standing([*building(hall), ("metal", joined(seams))], (0.0, 28.0), TOWARDS),
            *_standing(building(shed), (13.5, 16.0), TOWARDS + 0.2),
            *leafy_trees(rng, trees, 7.0 + 5.0 * rng.random(len(trees)), leaf=0.35),
            *parked,
        ],
        "asphalt",
    )


def metal_wall(seed: int) -> Mesh:
    """A hall clad in ribbed aluminium and zinc sheet, with a gate and a lower part of brick."""
    rng = generator(seed, "metal wall")
    ribs = [box(0.12, 0.12, 10.0) + np.array([x, 9.05, 0.0]) for x in np.arange(-14.5, 15.0, 0.6)]
    hall: list[Part] = [("metal", joined([box(30.0, 18.0, 10.0), *ribs]))]
    hall.append(("dark paint", upright_quads(np.array([(-6.0, 9.2, 2.5)]), 5.0, 5.0)))
    hall.append(("weathered metal", box(30.6, 18.6, 0.5, base=10.0)))
    low = Building(width=10.0, depth=9.0, height=4.0, roof="flat", walls="brick", bay=2.5)
    trees = scattered_feet(rng, 6, (-45.0, 45.0), (45.0, 60.0))
    parked = cars(generator(seed, "paints"), np.array([(4.0, 14.0, 0.0), (7.0, 14.2, 0.0)]), np.array([0.0, 3.1]))
    return _scene(
        "metal wall",
        [
            *_standing(hall, (-3.0, 42.0), TOWARDS + 0.25),
            *_standing(building(low), (20.5, 34.0), TOWARDS),
            *leafy_trees(rng, trees, 8.0 + 5.0 * rng.random(len(trees)), leaf=0.4),
            *parked,
        ],
        "asphalt",
    )


def glass_fronts(seed: int) -> Mesh:
    """Three office blocks whose fronts are nearly all panes, turned to different sides."""
    rng = generator(seed, "glass fronts")
    trees = np.array([(-14.0, 22.0, 0.0), (2.5, 25.0, 0.0), (10.0, 20.0, 0.0)])
    walkers = people(generator(seed, "walkers"), np.array([(-4.0, 13.0, 0.0), (3.0, 17.0, 0.0)]), np.array([1.0, 4.0]))
    return _scene(
        "reflective windows",
        [
            *_standing(_office(20.0, 16.0, 7), (-17.0, 66.0), TOWARDS + 0.35),
            *_standing(_office(16.0, 14.0, 11), (11.0, 84.0), TOWARDS - 0.15),
            *_standing(_office(18.0, 16.0, 5), (30.0, 56.0), TOWARDS - 0.7),
            *leafy_trees(rng, trees, np.array([6.0, 5.0, 6.5]), leaf=0.2),
            *walkers,
        ],
        "paving",
    )


def city_street(
    seed: int, width: float = 14.0, storeys: int = 4, has_church: bool = False, *, leaves: float = 3.0
) -> Mesh:
    """A street along +y between rows of houses, cars at the kerbs, a few trees; a church at the end if wanted.

    Parameters
    ----------
    width : from wall to wall [m]
    storeys : of most houses
    leaves : density of the leaves of the trees, 0 in winter
    """
    rng = generator(seed, "city street")
    way = np.array([[0.0, 0.0], [0.0, 60.0], [0.0, 120.0]])
    parts: list[Part] = []
    for side in (-1.0, 1.0):
        parts += row_of_buildings(
            rng, np.array([side * (width / 2 + 6.0), 62.0]), 130.0, -side * np.pi / 2, depth=12.0, storeys=storeys,
            is_flat=False, base=0.12, route=np.repeat(way, 5, axis=0), window_range=60.0, scaffold_share=0.08,
            gap_share=0.06,
        )  # fmt: skip
        parts.append(("paving", box(2.5, 150.0, 0.12) + np.array([side * (width / 2 - 1.25), 62.0, 0.0])))
    if has_church:
        nave = Building(width=13.0, depth=24.0, height=11.0, walls="limestone", roofing="slate", pitch=0.9, bay=4.0)
        parts += _standing(tower(6.5, 42.0, "limestone", "slate"), (0.0, 138.0), TOWARDS)
        parts += _standing(building(nave), (0.0, 155.0), TOWARDS)
    else:
        parts += row_of_buildings(
            rng, np.array([0.0, 150.0]), 60.0, TOWARDS, depth=12.0, storeys=storeys, is_flat=False, base=0.12,
            route=np.repeat(way, 5, axis=0), window_range=60.0, scaffold_share=0.0, gap_share=0.0,
        )  # fmt: skip
    kerb = width / 2 - 3.6
    spots = np.array([(s * kerb, y, 0.0) for s in (-1.0, 1.0) for y in (11.0, 17.5, 24.0, 37.0, 44.0, 58.0, 71.0)])
    parked = spots[rng.permutation(len(spots))[:10]]
    parts += cars(generator(seed, "paints"), parked, np.where(parked[:, 0] > 0, 0.0, np.pi))
    feet = np.array([(-width / 2 + 1.6, 30.0, 0.12), (width / 2 - 1.6, 48.0, 0.12), (-width / 2 + 1.6, 78.0, 0.12)])
    parts += leafy_trees(rng, feet, np.array([6.5, 7.0, 7.0]), leaf=0.22, density=leaves)
    walkers = np.array([(-width / 2 + 1.0, 14.0, 0.12), (width / 2 - 0.9, 21.0, 0.12)])
    parts += people(generator(seed, "walkers"), walkers, np.array([0.0, np.pi]))
    posts = np.array([(s * (width / 2 - 2.3), y, 0.12) for s in (-1.0, 1.0) for y in (20.0, 45.0, 70.0, 95.0)])
    parts.append(("weathered metal", joined([placed(frustum(6, 0.08, 0.05, 7.0), posts)])))
    return _scene("city street", parts, "asphalt")


def suburban_houses(seed: int) -> Mesh:
    """A road along +y between houses with pitched roofs, gardens, hedges and trees."""
    rng = generator(seed, "suburban houses")
    parts: list[Part] = []
    for side in (-1.0, 1.0):
        for k, y in enumerate(np.arange(18.0, 110.0, 17.0)):
            walls, roofing = ("brick", "tiles") if rng.random() < 0.6 else ("render", "slate")
            plan = Building(
                width=9.0 + 2.0 * rng.random(), depth=8.5, height=5.2 + rng.random(), walls=walls, roofing=roofing,
                roof="gable" if rng.random() < 0.6 else "hip", pitch=0.7, has_chimney=True, has_back_windows=True,
            )  # fmt: skip
            parts += _standing(building(plan), (side * 16.5, float(y)), -side * np.pi / 2)
            line = np.stack([np.full(9, side * 7.0), y + np.linspace(-6.0, 3.5, 9), np.zeros(9)], axis=-1)
            parts += bushes(rng, line, 1.0 + 0.3 * rng.random(9), leaf=0.22, density=2.0) if k % 2 else []
            foot = np.array([[side * 9.5, y + 6.0, 0.0]])
            parts += leafy_trees(rng, foot, np.array([4.0 + 4.0 * rng.random()]), leaf=0.36, density=2.2)
        parts.append(("grass", box(30.0, 160.0, 0.1) + np.array([side * 20.5, 60.0, 0.0])))
        parts.append(("paving", box(1.9, 160.0, 0.11) + np.array([side * 4.5, 60.0, 0.0])))
    trees = scattered_feet(rng, 26, (-50.0, 30.0), (50.0, 150.0))
    trees = trees[np.abs(trees[:, 0]) > 24.0]
    parts += leafy_trees(rng, trees, 8.0 + 5.0 * rng.random(len(trees)), leaf=0.6)
    spots = np.array([(2.4, 14.0, 0.0), (-2.4, 27.0, 0.0), (2.4, 41.0, 0.0), (-2.4, 55.0, 0.0)])
    parts += cars(generator(seed, "paints"), spots, np.array([0.0, np.pi, 0.0, np.pi]))
    return _scene("suburban houses", parts, "asphalt")


def _office(width: float, depth: float, n_storeys: int) -> list[Part]:
    """A block whose front and right side are bands of panes between floors of concrete."""
    height, storey = 3.4 * n_storeys, 3.4
    panes: list[Floats] = []
    for side, span in ((0, width), (1, depth)):
        n = int(span / 1.6)
        across = (np.arange(n) - (n - 1) / 2) * 1.6
        up = (np.arange(n_storeys) + 0.55) * storey
        front = 0.5 * (depth if side == 0 else width) + 0.03
        grid = np.stack(np.meshgrid(across, [front], up, indexing="ij"), axis=-1).reshape(-1, 3)
        panes.append(placed(upright_quads(grid, 1.5, 2.7), [(0.0, 0.0, 0.0)], side * np.pi / 2)[0])
    return [("concrete", box(width, depth, height + 0.8)), ("window", joined(panes))]


def _dome(radius: float, base: float) -> Floats:
    """Half a ball on a low drum."""
    angle = np.linspace(0.0, np.pi / 2, 8)
    rings = [
        frustum(
            24,
            radius * np.cos(a),
            radius * np.cos(b) if b < np.pi / 2 else 0.0,
            radius * (np.sin(b) - np.sin(a)),
            base=base + 1.2 + radius * np.sin(a),
        )
        for a, b in pairwise(angle)
    ]
    return joined([frustum(24, radius, radius, 1.2, base=base), *rings])


def _beam(start: Floats, end: Floats, width: float, height: float) -> Floats:
    """The top and both sides of a bar from start to end (3,), upright."""
    along = (end - start) / np.linalg.norm(end - start)
    side = np.cross(along, [0.0, 0.0, 1.0])
    side *= 0.5 * width / np.linalg.norm(side)
    up = np.array([0.0, 0.0, height])
    left, right = (start - side, end - side), (start + side, end + side)
    return quads(
        [
            [right[0] + up, right[1] + up, left[1] + up, left[0] + up],
            [right[0], right[1], right[1] + up, right[0] + up],
            [left[1], left[0], left[0] + up, left[1] + up],
        ]
    )


def _standing(parts: list[Part], at: tuple[float, float], heading: float) -> list[Part]:
    return [(material, placed(body, [(*at, 0.0)], heading)[0]) for material, body in parts]


def _scene(name: str, parts: list[Part], ground: str) -> Mesh:
    """Mesh with ground below it; what lies beyond is level and of one material."""
    places = np.concatenate([body.reshape(-1, 3)[:, :2] for _, body in parts if body.size])
    reach = (
        tuple(np.append(places, [[-5.0, -5.0]], axis=0).min(axis=0) - 5.0),
        tuple(np.append(places, [[5.0, 5.0]], axis=0).max(axis=0) + 5.0),
    )
    return mesh_from([*parts, (ground, ground_patch(*reach))], name)
