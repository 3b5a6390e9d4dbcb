"""The city: its loop, what stands on it, and what moves."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.city import CityParams, city
from insectnav.worlds.moving import CAR_HEIGHT, PERSON_HEIGHT
from insectnav.worlds.shapes import triangle_areas

PARAMS = CityParams(window_range=10.0)
EYE = 2.0  # [m] of Stone et al. 2014
WORLD = city(PARAMS, seed=1)
MOVING = ("cloth", "dark paint", "light paint", "red paint")


def of(mesh, *names: str) -> np.ndarray:
    wanted = [mesh.materials.index(name) for name in names if name in mesh.materials]
    return mesh.vertices[np.isin(mesh.material, wanted)]


@pytest.mark.parametrize("seed", range(3))
def test_loop_is_closed_and_about_two_kilometres(seed: int):
    route = city(PARAMS, seed=seed).route
    np.testing.assert_array_equal(route[0], (0.0, 0.0))
    np.testing.assert_allclose(route[-1], route[0], atol=1e-9)
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    assert steps.sum() == pytest.approx(2000.0, rel=0.05)
    np.testing.assert_allclose(steps, PARAMS.way_step, rtol=0.05)


def test_walk_turns_clockwise_once():
    """The area that a loop encloses is negative, mathematically, for a clockwise turn."""
    x, y = WORLD.route.T
    assert 0.5 * (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() < -100_000.0


@pytest.mark.parametrize("seed", range(3))
def test_nothing_stands_on_the_walk(seed: int):
    """Triangles that reach into 0.1–2.5 m above the road and within 0.2 m of a way point; ground is below that."""
    world = city(PARAMS, seed=seed)
    corners = world.mesh.vertices.astype(float)
    corners = corners[(corners[..., 2].max(axis=1) > 0.1) & (corners[..., 2].min(axis=1) < 2.5)]
    low, high = corners[..., :2].min(axis=1), corners[..., :2].max(axis=1)
    for point in world.route[::5]:
        assert not ((low < point + 0.2) & (high > point - 0.2)).all(axis=1).any()


def test_mesh_is_sound_and_has_all_that_a_city_has():
    mesh = WORLD.mesh
    assert mesh.vertices[..., 2].min() == 0.0
    assert 45.0 < mesh.bounds[1, 2] < 70.0  # the church
    assert triangle_areas(mesh.vertices).min() > 0.0
    assert mesh.notes == ()
    assert {"grass", "leaves", "asphalt", "paving", "window", "timber", *MOVING} <= set(mesh.materials)


def test_whatever_moves_is_below_the_eye():
    assert max(CAR_HEIGHT, PERSON_HEIGHT + 0.12) < EYE
    assert of(WORLD.mesh, *MOVING)[..., 2].max() < EYE


def test_time_moves_cars_and_people_only():
    later = city(replace(PARAMS, time_s=7.0), seed=1)
    for name in set(WORLD.mesh.materials) - {*MOVING, "window", "timber"}:  # cars have windows
        np.testing.assert_array_equal(of(later.mesh, name), of(WORLD.mesh, name), err_msg=name)
    assert not np.array_equal(of(later.mesh, "cloth"), of(WORLD.mesh, "cloth"))
    empty = replace(PARAMS, n_cars=0, n_people=0)
    np.testing.assert_array_equal(
        city(empty, seed=1).mesh.vertices, city(replace(empty, time_s=7.0), seed=1).mesh.vertices
    )


def test_season_changes_leaves_only():
    winter = city(replace(PARAMS, foliage=0.0), seed=1)
    assert "leaves" not in winter.mesh.materials
    for name in set(winter.mesh.materials):
        np.testing.assert_array_equal(of(winter.mesh, name), of(WORLD.mesh, name), err_msg=name)


def test_windows_are_near_the_walk_only():
    n_near = len(of(WORLD.mesh, "window"))
    assert n_near < len(of(city(replace(PARAMS, window_range=45.0), seed=1).mesh, "window"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"loop_length": 2.0}, "in kilometres"),
        ({"street_width": (5.0, 20.0)}, "least street_width"),
        ({"street_width": (20.0, 12.0)}, "greatest street_width"),
        ({"storeys": (3, 2)}, "greatest storeys"),
        ({"park_share": 2.0}, "park_share"),
        ({"foliage": 100.0}, "in percent"),
        ({"n_cars": -1}, "n_cars"),
        ({"time_s": np.inf}, "time_s"),
        ({"way_step": 0.0}, "way_step"),
    ],
)
def test_bad_parameters(change: dict, words: str):
    with pytest.raises(InputError, match=words):
        replace(PARAMS, **change)
