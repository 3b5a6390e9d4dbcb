"""Ground: level where the animal walks, gentle elsewhere, without holes."""

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.ground import LEVEL, Relief, ground_height, ground_patch
from insectnav.worlds.shapes import triangle_areas
from insectnav.worlds.ways import distance_to_way, stepped

HILLS = Relief(height=2.0, wavelength=15.0, level_within=5.0, rise=4.0, seed=3)
PLACES = np.random.default_rng(1).uniform(-60.0, 60.0, (4000, 2))


def test_level_ground_is_at_0():
    np.testing.assert_array_equal(ground_height(PLACES, LEVEL), 0.0)


def test_hills_are_positive_bounded_and_begin_outside_the_level_disc():
    height = ground_height(PLACES, HILLS)
    assert height.min() >= 0.0
    assert height.max() <= HILLS.height
    assert height.std() > 0.1 * HILLS.height
    within = np.hypot(*PLACES.T) <= HILLS.level_within
    assert within.sum() > 10
    np.testing.assert_array_equal(height[within], 0.0)


def test_level_strip_follows_the_way():
    relief = Relief(height=2.0, level_within=3.0, rise=1.0, way=((0.0, 0.0), (0.0, 50.0), (30.0, 50.0)))
    along = np.array([(0.0, 20.0), (2.9, 40.0), (15.0, 52.9), (30.0, 50.0)])
    np.testing.assert_array_equal(ground_height(along, relief), 0.0)
    assert ground_height(PLACES, relief).max() > 0.5


@pytest.mark.parametrize("relief", [LEVEL, HILLS])
def test_patch_covers_its_rectangle_once_and_looks_up(relief: Relief):
    triangles = ground_patch((-10.0, -20.0), (30.0, 25.0), relief)
    flat = triangles.copy()
    flat[..., 2] = 0.0
    assert triangle_areas(flat).sum() == pytest.approx(40.0 * 45.0)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (normals[:, 2] > 0).all()
    np.testing.assert_allclose(triangles[..., 2], ground_height(triangles[..., :2], relief))


def test_distance_to_a_way_by_hand():
    way = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]
    places = [(2.0, 1.0), (-3.0, 4.0), (5.0, 2.0), (7.0, 7.0), (4.0, 0.0)]
    np.testing.assert_allclose(distance_to_way(places, way), [1.0, 5.0, 1.0, 5.0, 0.0])
    np.testing.assert_allclose(distance_to_way(places, [(0.0, 0.0)]), np.hypot(*np.array(places).T))


def test_steps_along_a_way():
    points = stepped(np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 2.0)]), 0.5)
    np.testing.assert_allclose(np.hypot(*np.diff(points, axis=0).T), 0.5)
    np.testing.assert_array_equal(points[[0, 6, -1]], [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0)])


def test_bad_input():
    with pytest.raises(InputError, match="height of the hills"):
        Relief(height=-1.0)
    with pytest.raises(InputError, match="wavelength"):
        Relief(wavelength=0.0)
    with pytest.raises(InputError, match="seed"):
        Relief(seed=-1)
    with pytest.raises(InputError, match="positions has shape"):
        ground_height(np.zeros((3, 3)))
    with pytest.raises(InputError, match="sides of the ground"):
        ground_patch((0.0, 0.0), (0.0, 1.0))
    with pytest.raises(InputError, match="number of tiles"):
        ground_patch((0.0, 0.0), (4000.0, 4000.0), HILLS, tile=1.0)
