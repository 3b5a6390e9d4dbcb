"""The suburban street: houses on both sides, a free road."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.shapes import triangle_areas
from insectnav.worlds.street import PAVEMENT, ROAD, StreetParams, suburban_street

PARAMS = StreetParams(length=96.0)


@pytest.mark.parametrize("time_s", [0.0, 3.0, 11.0])
@pytest.mark.parametrize("seed", range(3))
def test_middle_of_the_road_is_free(seed: int, time_s: float):
    world = suburban_street(replace(PARAMS, time_s=time_s, n_cars=6), seed=seed)
    corners = world.mesh.vertices
    corners = corners[(corners[..., 2].max(axis=1) > 0.15) & (corners[..., 2].min(axis=1) < 2.5)]
    low, high = corners[..., 0].min(axis=1), corners[..., 0].max(axis=1)
    assert not ((low < 0.2) & (high > -0.2)).any()
    np.testing.assert_array_equal(world.route[:, 0], 0.0)
    assert world.route[-1, 1] == pytest.approx(96.0)


def test_houses_stand_on_both_sides_behind_the_pavements():
    """Six plots of 16 m on each side; the walls and gables of a house have eight or ten triangles."""
    mesh = suburban_street(PARAMS, seed=1).mesh
    walls = mesh.vertices[np.isin(mesh.material, [mesh.materials.index(name) for name in ("brick", "render")])]
    walls = walls[walls[..., 2].max(axis=1) > 2.0].mean(axis=1)
    assert np.abs(walls[:, 0]).min() > ROAD / 2 + PAVEMENT
    for side in (-1, 1):
        along = np.sort(walls[walls[:, 0] * side > 0][:, 1])
        assert [((along > 16.0 * k) & (along < 16.0 * (k + 1))).any() for k in range(6)] == [True] * 6


def test_shares_are_obeyed_at_their_ends():
    bare = replace(PARAMS, hedge_share=0.0, tree_share=0.0, back_trees=0.0)
    mesh = suburban_street(bare, seed=1).mesh
    leaves = mesh.vertices[mesh.material == mesh.materials.index("leaves")]
    assert leaves[..., 2].max() < 2.0  # shrubs by the houses only
    hedged = suburban_street(replace(bare, hedge_share=1.0), seed=1).mesh
    leaves = hedged.vertices[hedged.material == hedged.materials.index("leaves")].mean(axis=1)
    for side in (-1, 1):
        near = leaves[np.abs(leaves[:, 0] - side * (ROAD / 2 + PAVEMENT + 0.6)) < 0.9][:, 1]
        assert [(np.abs(near - (16.0 * k + 8.0)) < 2.0).any() for k in range(6)] == [True] * 6


def test_mesh_is_sound():
    mesh = suburban_street(PARAMS, seed=2).mesh
    assert mesh.vertices[..., 2].min() == 0.0
    assert 5.0 < mesh.bounds[1, 2] < 20.0
    assert triangle_areas(mesh.vertices).min() > 0.0
    assert mesh.notes == ()


def test_season_and_time_move_no_house():
    worlds = [
        suburban_street(replace(PARAMS, **change), seed=3).mesh for change in ({}, {"foliage": 0.2, "time_s": 50.0})
    ]
    for name in ("brick", "render", "tiles", "slate", "needles", "paving"):
        one, other = (mesh.vertices[mesh.material == mesh.materials.index(name)] for mesh in worlds)
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"length": 1e5}, "length"),
        ({"house_width": (10.0, 30.0)}, "greatest house_width"),
        ({"house_height": (1.0, 3.0)}, "least house_height"),
        ({"hedge_share": 60.0}, "hedge_share"),
        ({"n_parked": -2}, "n_parked"),
        ({"foliage": -0.1}, "foliage"),
    ],
)
def test_bad_parameters(change: dict, words: str):
    with pytest.raises(InputError, match=words):
        replace(PARAMS, **change)
