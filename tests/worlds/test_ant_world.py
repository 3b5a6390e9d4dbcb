"""The ant world: an empty clearing, plants by their density, seasons."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import poisson

from insectnav.checks import InputError
from insectnav.worlds.ant_world import SHRUBLAND, AntWorldParams, ant_world
from insectnav.worlds.shapes import triangle_areas

DEFAULT = AntWorldParams()
ONLY_TUSSOCKS = replace(DEFAULT, shrub_density=0.0, tree_density=0.0)


def plants(world) -> np.ndarray:
    """Triangles of all that is not ground."""
    mesh = world.mesh
    return mesh.vertices[mesh.material != mesh.materials.index(world.parameters.ground)].astype(float)


def nearest(triangles: np.ndarray) -> float:
    """Least distance from the axis of the world to a side of a triangle, seen from above."""
    start = triangles[..., :2]
    leg = np.roll(start, -1, axis=1) - start
    share = -(start * leg).sum(-1) / np.maximum((leg**2).sum(-1), 1e-12)
    return float(np.linalg.norm(start + np.clip(share, 0.0, 1.0)[..., None] * leg, axis=-1).min())


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("params", [DEFAULT, SHRUBLAND, replace(DEFAULT, hills=3.0, clearing=5.0)])
def test_clearing_is_empty(params: AntWorldParams, seed: int):
    world = ant_world(params, seed=seed)
    assert nearest(plants(world)) >= params.clearing - 1e-3
    ground = world.mesh.vertices[world.mesh.material == world.mesh.materials.index(params.ground)]
    within = np.linalg.norm(ground[..., :2], axis=-1) < params.clearing
    assert (ground[within][:, 2] == 0.0).all()


@pytest.mark.parametrize("seed", range(3))
def test_mesh_is_sound(seed: int):
    mesh = ant_world(seed=seed).mesh
    assert 3000 <= mesh.n_triangles <= 30_000
    assert np.isfinite(mesh.vertices).all()
    assert mesh.vertices[..., 2].min() >= 0.0
    assert mesh.vertices[..., 2].max() <= DEFAULT.tree_height[1]
    assert triangle_areas(mesh.vertices).min() > 0.0
    assert mesh.notes == ()


def test_tussocks_follow_their_density():
    """Twenty-seven triangles each; the sum over forty worlds lies in the two-sided 1e-6 interval of Poisson."""
    counts = [len(plants(ant_world(ONLY_TUSSOCKS, seed=seed))) / (3 * DEFAULT.n_blades) for seed in range(40)]
    assert all(count == int(count) for count in counts)
    inner = DEFAULT.clearing + DEFAULT.tussock_height[1]
    mean = DEFAULT.tussock_density * np.pi * (DEFAULT.radius**2 - inner**2)
    low, high = poisson.interval(1 - 1e-6, 40 * mean)
    assert low <= sum(counts) <= high


def test_seasons_add_leaves_and_move_nothing():
    worlds = [ant_world(replace(DEFAULT, foliage=share), seed=2).mesh for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
    areas = [triangle_areas(mesh.vertices).sum() for mesh in worlds]
    assert (np.diff(areas) > 0.0).all()
    assert "leaves" not in worlds[0].materials
    wood = [mesh.vertices[mesh.material == mesh.materials.index("bark")] for mesh in worlds]
    for bark in wood[1:]:
        np.testing.assert_array_equal(bark, wood[0])


def test_kinds_of_plants_do_not_depend_on_each_other():
    alone, among = ant_world(ONLY_TUSSOCKS, seed=4), ant_world(DEFAULT, seed=4)
    straw = among.mesh.vertices[among.mesh.material == among.mesh.materials.index("straw")]
    np.testing.assert_array_equal(plants(alone), straw)


def test_route_ends_at_the_nest_and_stays_in_the_clearing():
    route = ant_world(seed=0).route
    np.testing.assert_array_equal(route[-1], (0.0, 0.0))
    assert np.linalg.norm(route, axis=1).max() < DEFAULT.clearing
    np.testing.assert_allclose(np.linalg.norm(np.diff(route, axis=0), axis=1), 0.1, rtol=0.01)


def test_hills_carry_the_plants():
    world = ant_world(replace(DEFAULT, hills=5.0), seed=1)
    lowest = plants(world)[..., 2].min(axis=1)
    place = plants(world)[..., :2].mean(axis=1)
    assert (lowest > world.ground_height(place) - 1.0).all()  # on slopes, low boughs may touch the ground
    assert world.ground_height(place).max() > 1.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"radius": 1e5}, "radius of the world"),
        ({"clearing": 50.0}, "clearing"),
        ({"tussock_density": -0.1}, "tussock_density"),
        ({"tree_density": 1e3}, "tree_density"),
        ({"shrub_height": (2.0, 1.0)}, "greatest shrub_height"),
        ({"tree_height": 5.0}, "expected the least and the greatest"),
        ({"n_blades": 0}, "n_blades"),
        ({"foliage": 80.0}, "in percent"),
        ({"hills": -1.0}, "hills"),
        ({"ground": "lava"}, "ground"),
    ],
)
def test_bad_parameters(change: dict, words: str):
    with pytest.raises(InputError, match=words):
        replace(DEFAULT, **change)


def test_bad_seed():
    with pytest.raises(InputError, match="seed is -1"):
        ant_world(seed=-1)
