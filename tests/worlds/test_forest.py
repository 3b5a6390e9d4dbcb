"""The forest trail: free to walk, open to the sky in the gaps."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.forest import TRAIL_ABOVE_GROUND, ForestParams, canopy_gaps, forest_trail
from insectnav.worlds.shapes import triangle_areas
from insectnav.worlds.ways import distance_to_way

PARAMS = ForestParams(length=80.0, n_gaps=2)
PLANTS = ("leaves", "needles", "bark")


def plants(world) -> np.ndarray:
    mesh = world.mesh
    return mesh.vertices[
        np.isin(mesh.material, [mesh.materials.index(name) for name in PLANTS if name in mesh.materials])
    ]


@pytest.mark.parametrize("seed", range(4))
def test_trail_is_free_and_level(seed: int):
    """What reaches below 1.5 m, a twelfth of the least height of a crown's foot and more, keeps off the trail."""
    world = forest_trail(PARAMS, seed=seed)
    body = plants(world).astype(float)
    low = body[body[..., 2].min(axis=1) < 1.5]
    assert distance_to_way(low[..., :2], world.route).min() > PARAMS.trail_half_width - 0.1
    np.testing.assert_array_equal(world.ground_height(world.route), 0.0)


def test_route_runs_north_from_the_origin():
    route = forest_trail(PARAMS, seed=3).route
    np.testing.assert_array_equal(route[0], (0.0, 0.0))
    np.testing.assert_allclose(np.diff(route[:, 1]), PARAMS.way_step)
    assert route[-1, 1] == pytest.approx(80.0)
    assert np.abs(route[:, 0]).max() <= 2 * PARAMS.bend


def test_no_tree_stands_in_a_gap():
    world = forest_trail(PARAMS, seed=1)
    mesh = world.mesh
    bark = mesh.vertices[mesh.material == mesh.materials.index("bark")]
    is_trunk = (bark[..., 2].min(axis=1) < 2.0) & (np.ptp(bark[..., 2], axis=1) > 3.0)  # branches begin higher
    trunks = bark[is_trunk][..., :2].mean(axis=1)
    assert len(trunks) > 100
    for gap in canopy_gaps(world.route, PARAMS):
        assert np.linalg.norm(trunks - gap, axis=1).min() > PARAMS.gap_radius - 0.5


def test_there_is_more_sky_in_gaps_than_between_them():
    """Share of a disc of 4 m over the trail that crowns cover, by their triangles; mean of eight seeds."""
    covered = {"gap": [], "between": []}
    for seed in range(8):
        world = forest_trail(PARAMS, seed=seed)
        body = plants(world)
        body = body[body[..., 2].min(axis=1) > 3.0][..., :2].mean(axis=1)
        for name, share in (("gap", 0.25), ("gap", 0.75), ("between", 0.5)):
            point = world.route[round(share * (len(world.route) - 1))]
            covered[name].append((np.linalg.norm(body - point, axis=1) < 4.0).sum())
    assert np.mean(covered["gap"]) < 0.3 * np.mean(covered["between"])


def test_mesh_is_sound():
    mesh = forest_trail(PARAMS, seed=2).mesh
    assert mesh.vertices[..., 2].min() >= 0.0
    assert mesh.vertices[..., 2].max() <= PARAMS.tree_height[1] + PARAMS.hills
    assert triangle_areas(mesh.vertices).min() > 0.0
    assert mesh.notes == ()
    soil = mesh.vertices[mesh.material == mesh.materials.index("soil")]
    np.testing.assert_allclose(soil[..., 2], TRAIL_ABOVE_GROUND, atol=1e-4)


def test_winter_keeps_needles_and_wood():
    summer, winter = forest_trail(PARAMS, seed=5).mesh, forest_trail(replace(PARAMS, foliage=0.0), seed=5).mesh
    for name in ("needles", "bark", "litter"):
        one, other = (mesh.vertices[mesh.material == mesh.materials.index(name)] for mesh in (summer, winter))
        np.testing.assert_array_equal(one, other)
    area = [
        triangle_areas(mesh.vertices[mesh.material == mesh.materials.index("leaves")]).sum()
        for mesh in (winter, summer)
    ]
    assert area[0] < 0.1 * area[1]  # ferns keep half of their fronds


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"length": 0.0}, "length"),
        ({"tree_density": 4.0}, "hectare"),
        ({"conifer_share": 1.5}, "conifer_share"),
        ({"tree_height": (0.0, 10.0)}, "least tree_height"),
        ({"n_gaps": -1}, "n_gaps"),
        ({"trail_half_width": 100.0}, "trail_half_width"),
        ({"ground": "snow"}, "ground"),
    ],
)
def test_bad_parameters(change: dict, words: str):
    with pytest.raises(InputError, match=words):
        replace(PARAMS, **change)
