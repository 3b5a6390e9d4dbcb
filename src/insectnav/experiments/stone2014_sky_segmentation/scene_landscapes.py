"""Places without buildings, for a camera that stands at the origin and looks along +y: scrub, forest, ponds, hills."""

import numpy as np

from insectnav.angles import Floats
from insectnav.experiments.stone2014_sky_segmentation.scene_plants import bushes, grass, leafy_trees, scattered_feet
from insectnav.records import Mesh
from insectnav.worlds.ground import Relief, ground_height, ground_patch
from insectnav.worlds.plants import TreeForm, conifers, tussocks
from insectnav.worlds.shapes import Part, generator, mesh_from

SPRUCE = TreeForm(crown_radius=0.17, n_leaves=420)
FIELD, FIRST_FIELD = np.array([125.0, 87.5]), np.array([37.5, 0.0])  # [m] sides and a corner of a field


def desert_scrub(seed: int, n_trees: int = 5) -> Mesh:
    """Dry tussocks and low bushes on sand, some trees behind, as at an ant's site near Seville."""
    rng = generator(seed, "scrub")
    feet = scattered_feet(rng, 22, (-6.0, 1.2), (6.0, 14.0), clear=1.5)
    shrubs = bushes(rng, feet, 0.3 + 0.7 * rng.random(len(feet)), leaf=0.07, density=1.6)
    far = scattered_feet(rng, 70, (-30.0, 14.0), (30.0, 60.0))
    behind = bushes(rng, far, 0.7 + 1.3 * rng.random(len(far)), leaf=0.3, density=2.0)
    stand = scattered_feet(rng, n_trees, (-20.0, 26.0), (20.0, 50.0))
    trees = leafy_trees(rng, stand, 4.0 + 3.0 * rng.random(n_trees), leaf=0.25, density=2.2)
    near = grass(rng, (-2.5, 0.7), (2.5, 6.0), 0.3, n_blades=40)
    further = grass(rng, (-10.0, 6.0), (10.0, 20.0), 0.4, n_blades=24)
    ground: Part = ("sand", ground_patch((-40.0, -20.0), (40.0, 70.0)))
    return mesh_from([near, further, *shrubs, *behind, *trees, ground], "desert scrub")


def forest_floor(seed: int, gap: float = 3.0, reach: float = 40.0) -> Mesh:
    """Broad-leaved trees and spruces, ferns between them; no trunk within `gap` metres."""
    rng = generator(seed, "forest floor")
    box = (-0.6 * reach, -8.0), (0.6 * reach, reach)
    broad = scattered_feet(rng, 24, *box, clear=gap)
    slim = scattered_feet(rng, 10, (box[0][0], 7.0), box[1])
    fern = scattered_feet(rng, 120, (-8.0, 1.2), (8.0, 18.0), clear=1.5)
    wall = scattered_feet(rng, 30, (-40.0, reach), (40.0, reach + 20.0))
    return mesh_from(
        [
            *leafy_trees(rng, broad, 12.0 + 8.0 * rng.random(len(broad)), leaf=0.55, density=1.8),
            *conifers(rng, slim, 12.0 + 8.0 * rng.random(len(slim)), SPRUCE),
            ("leaves", tussocks(rng, fern, 0.3 + 0.5 * rng.random(len(fern)), n_blades=40)),
            *leafy_trees(rng, wall, 11.0 + 8.0 * rng.random(len(wall)), leaf=1.3, density=2.0),
            ("litter", ground_patch((-45.0, -15.0), (45.0, 65.0))),
        ],
        "forest floor",
    )


def pond(seed: int, reach: float = 30.0, tree_height: float = 11.0) -> Mesh:
    """A pond in a meadow, reeds and trees on the far bank."""
    rng = generator(seed, "pond")
    middle, half = np.array([0.0, 0.5 * reach + 2.5]), np.array([0.75 * reach, 0.5 * reach])
    angle = 2.0 * np.pi * np.arange(65) / 64
    rim = middle + half * (1.0 + 0.06 * np.sin(3.0 * angle + 1.0))[:, None] * np.stack(
        [np.cos(angle), np.sin(angle)], axis=-1
    )
    bank = rng.integers(2, 31, 260)  # of the rim's points, those on the far side
    reed = middle + (rim[bank] - middle) * (1.0 + 0.05 * rng.random((260, 1)))
    feet = np.concatenate([reed, np.zeros((260, 1))], axis=-1)
    trees = scattered_feet(rng, 22, (-1.1 * reach, reach + 8.0), (1.1 * reach, reach + 30.0))
    bush = scattered_feet(rng, 14, (-1.2 * reach, reach + 4.0), (1.2 * reach, reach + 12.0))
    return mesh_from(
        [
            ("water", _disc(rim, 0.03)),
            ("leaves", tussocks(rng, feet, 0.7 + 0.8 * rng.random(260), n_blades=24)),
            *leafy_trees(rng, trees, tree_height * (0.6 + 0.5 * rng.random(len(trees))), leaf=0.45, density=2.4),
            *bushes(rng, bush, 1.0 + 1.5 * rng.random(len(bush)), leaf=0.3),
            grass(rng, (-6.0, 1.0), (6.0, 2.2), 0.15, material="leaves"),
            ("grass", ground_patch((-60.0, -20.0), (60.0, 75.0))),
        ],
        "pond",
    )


def _disc(rim: Floats, height: float) -> Floats:
    """A level polygon (n, 2), its first and last corner the same, seen from above."""
    corners = np.concatenate([rim, np.full((len(rim), 1), height)], axis=-1)
    middle = np.broadcast_to(corners.mean(axis=0), corners[1:].shape)
    return np.stack([middle, corners[:-1], corners[1:]], axis=1)


def open_country(seed: int) -> Mesh:
    """Fields of grass, ripe corn and soil on gentle hills up to a kilometre away, hedgerows and trees between them."""
    rng = generator(seed, "open country")
    relief = Relief(height=75.0, wavelength=420.0, level_within=60.0, rise=350.0, seed=seed)
    ground = ground_patch((-1000.0, -200.0), (1000.0, 1700.0), relief, tile=12.5)
    number = np.floor((ground.mean(axis=1)[:, :2] - FIRST_FIELD) / FIELD).astype(int)
    kind = rng.integers(0, 8, (64, 64))[number[:, 0] % 64, number[:, 1] % 64]
    fields: list[Part] = [
        ("grass", ground[kind < 5]),
        ("straw", ground[(kind >= 5) & (kind < 7)]),
        ("soil", ground[kind == 7]),
    ]
    place = rng.uniform((-450.0, 40.0), (450.0, 800.0), (420, 2))
    row, axis = np.arange(60, 420), rng.integers(0, 2, 360)  # most stand along the fields
    number = np.round((place[row, axis] - FIRST_FIELD[axis]) / FIELD[axis])
    place[row, axis] = FIRST_FIELD[axis] + number * FIELD[axis] + rng.normal(0.0, 0.8, 360)
    place = place[place[:, 1] > 45.0]
    feet = np.concatenate([place, ground_height(place, relief)[:, None]], axis=-1)
    tall = 2.5 + 7.0 * rng.random(len(feet)) ** 2
    near = scattered_feet(rng, 4, (-24.0, 32.0), (24.0, 50.0))
    return mesh_from(
        [
            *fields,
            *leafy_trees(rng, feet, tall, leaf=1.0, density=2.0),
            *leafy_trees(rng, near, 5.0 + 3.0 * rng.random(len(near)), leaf=0.35, density=2.2),
            grass(rng, (-8.0, 2.0), (8.0, 16.0), 0.4, material="straw", n_blades=20),
        ],
        "open country",
    )


def forest_edge(seed: int) -> Mesh:
    """A meadow before the edge of a wood."""
    rng = generator(seed, "forest edge")
    broad = scattered_feet(rng, 20, (-22.0, 17.0), (22.0, 32.0))
    slim = scattered_feet(rng, 6, (-22.0, 20.0), (22.0, 34.0))
    bush = scattered_feet(rng, 16, (-22.0, 12.0), (22.0, 18.0))
    behind = scattered_feet(rng, 36, (-40.0, 34.0), (40.0, 55.0))
    return mesh_from(
        [
            *leafy_trees(rng, broad, 7.0 + 7.0 * rng.random(len(broad)), leaf=0.45, density=2.2),
            *conifers(rng, slim, 9.0 + 7.0 * rng.random(len(slim)), SPRUCE),
            *bushes(rng, bush, 0.8 + 1.2 * rng.random(len(bush)), leaf=0.2, density=2.0),
            *leafy_trees(rng, behind, 8.0 + 5.0 * rng.random(len(behind)), leaf=1.0, density=2.4),
            grass(rng, (-10.0, 1.5), (10.0, 14.0), 0.3, material="leaves"),
            ("grass", ground_patch((-45.0, -15.0), (45.0, 62.0))),
        ],
        "forest edge",
    )
