"""Where an eye cannot be: inside what is closed, but not under leaves."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.worlds import load_world, render, render_panorama
from insectnav.worlds.builders import build_world
from insectnav.worlds.solids import INSIDE, N_RAYS, check_outside_solids, count_crossings, share_odd, upward_rays
from solid_shapes import box, quad, soup, sphere, turned, world_of

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
seeds = st.integers(0, 2**32 - 1)


def is_inside(world, x, y, z=0.3) -> bool:
    try:
        check_outside_solids(world, np.array([[x, y, z]]), np.array([True]))
    except InputError:
        return True
    return False


@settings(max_examples=25, deadline=None)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-np.pi, np.pi))
def test_a_house_has_an_inside(x, y, angle):
    east, north = turned(np.array([[x, y, 0.0]]), -angle)[0, :2]
    margin = max(abs(east), abs(north)) - 1
    if abs(margin) > 1e-3:
        assert is_inside(world_of(turned(box(0, 0, 2, 2), angle)), x, y) == (margin < 0)


def test_solids_overlap():
    world = world_of(box(0, 0, 2, 2), box(0.5, 0, 2, 3), box(-0.3, 0.2, 2, 1.5))
    assert is_inside(world, 0.1, 0.1)
    assert not is_inside(world, 3, 0)


def test_a_ball_in_the_air_has_an_inside_and_room_below():
    world = world_of(sphere(8, 12, 1.0, (0, 0, 3)))
    assert is_inside(world, 0.1, 0.2, 3.1)
    assert not is_inside(world, 0.1, 0.2, 1.0)
    assert not is_inside(world, 0.1, 0.2, 5.0)


def test_below_a_ground_that_is_part_of_the_mesh():
    ground = quad((-999, -999, 1), (999, -999, 1), (999, 999, 1), (-999, 999, 1))
    world = world_of(ground)
    assert is_inside(world, 0, 0, 0.5)
    assert not is_inside(world, 0, 0, 1.5)


def test_houses_of_the_city_have_an_inside_and_its_streets_have_none():
    """Panes before the walls, chimneys and scaffolding lead some rays astray."""
    city = build_world("city", seed=1)
    world = load_world(city.mesh)
    rng = np.random.default_rng(0)
    above = np.column_stack([rng.uniform(0, 400, (40, 2)), np.full(40, 90.0)])
    below = render(world, above, directions=[[0, 0, -1.0]], layers=("depth", "triangle"))
    material = np.array(city.mesh.materials)[city.mesh.material[below["triangle"][:, 0]]]
    is_wall = np.isin(material, ("brick", "render", "concrete", "limestone"))  # flat roofs are of the walls' material
    houses = above[is_wall & (below["depth"][:, 0] < 85)]
    assert len(houses) > 5
    assert all(is_inside(world, x, y, 1.5) for x, y, _ in houses)
    assert not any(is_inside(world, x, y, 1.5) for x, y in city.route[::100])


def test_leaves_have_no_inside():
    """A closed canopy of leaves two deep, through which no sky is seen."""
    leaf = quad((-99, -99, 2), (99, -99, 2), (99, 99, 2), (-99, 99, 2))
    assert not is_inside(world_of(leaf, 1.1 * leaf), 0, 0)


@pytest.mark.data
def test_chance_makes_no_inside_of_plants():
    """Among plants half of the rays are odd; at this place seven in ten of the first 33 are."""
    path = DATA / "antworld_seville2009.npz"
    if not path.exists():
        pytest.skip(f"{path} is missing")
    world, eye = load_world(path), np.array([8.7, 3.8, 0.01])
    assert share_odd(world, eye, N_RAYS) >= INSIDE
    assert not is_inside(world, *eye)


@settings(max_examples=15, deadline=None)
@given(seeds)
def test_the_renderer_never_refuses_a_place_from_which_sky_is_seen(seed):
    world = world_of(soup(seed, 30))
    for place in np.random.default_rng(seed).uniform(-8, 8, (5, 1, 2)):
        view = None
        try:
            view = render_panorama(world, place, 0.0, resolution_deg=5.0, supersampling=1)
        except InputError:
            assert is_inside(world, *place[0], 0.01)
        assert view is None or view.shape == (1, 21, 72)


def test_rays_are_spread_evenly_over_the_upper_hemisphere():
    rays = upward_rays()
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1)
    np.testing.assert_allclose(rays[:, 2].mean(), 0.5)  # of a hemisphere
    assert rays[:, 2].min() > 0
    assert np.linalg.norm(rays[:, :2].mean(axis=0)) < 0.1


def test_crossings_are_counted():
    world = world_of(box(0, 5, 2, 4), box(0, 9, 2, 4))
    eye = np.array([0.1, 0.2, 1.0])
    assert count_crossings(world, eye, np.array([[0.0, 1.0, 0.0]])) == [4]
    assert count_crossings(world, eye, np.array([[0.0, -1.0, 0.0]])) == [0]
    assert count_crossings(world, eye, np.array([[0.0, 0.0, 1.0]])) == [0]
    assert count_crossings(world, np.array([0.1, 5.2, 1.0]), np.array([[0.0, 0.0, 1.0]])) == [1]


@pytest.mark.parametrize("index", [0, 2])
def test_the_first_such_place_is_named(index):
    places = np.array([[4.0, 0.0], [5.0, 0.0], [6.0, 0.0]])
    places[index] = 0.1
    with pytest.raises(InputError, match=rf"position {index} at \(0.1, 0.1, 0.01\) m is inside a solid"):
        render_panorama(world_of(box(0, 0, 2, 2)), places, 0.0)
