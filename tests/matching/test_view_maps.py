"""Maps on a cube: what is smooth stays, what was not seen is NaN, and nothing leaks."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from bumpy_skies import bumpy_sky, cap
from insectnav.checks import InputError
from insectnav.matching.view_maps import blur_to_cube, cube_nodes, look_up
from insectnav.vision.sphere import directions, equirectangular, fibonacci, gauss_legendre

GRID = equirectangular(3.0)
BLUR = blur_to_cube(GRID, np.deg2rad(3.0), "fine_blur")
LOOK = fibonacci(3000).directions
ALL = np.ones((1, GRID.n_directions), bool)


def test_nodes_are_unit_vectors_that_surround_each_face():
    nodes = cube_nodes(4)
    assert nodes.shape == (6 * 36, 3)
    assert_allclose(np.linalg.norm(nodes, axis=-1), 1.0)
    on_face = nodes[:36] / nodes[:36, :1]  # +x
    assert_allclose(on_face[:, 1].reshape(6, 6)[:, 0], [-1.25, -0.75, -0.25, 0.25, 0.75, 1.25])


def test_looking_up_a_plane_is_exact_on_every_face():
    # z/x is linear in the two places on the face +x, and so on: only gnomonic maps give such functions back exactly.
    nodes = cube_nodes(5)
    for axis in range(3):
        for sign in (1.0, -1.0):
            is_near = sign * LOOK[:, axis] > np.abs(np.delete(LOOK, axis, axis=1)).max(axis=1) + 1e-3
            with np.errstate(divide="ignore", invalid="ignore"):
                ratios = nodes[:, (axis + 1) % 3] / nodes[:, axis] + 2.0 * nodes[:, (axis + 2) % 3] / nodes[:, axis]
            near = LOOK[is_near]
            expected = near[:, (axis + 1) % 3] / near[:, axis] + 2.0 * near[:, (axis + 2) % 3] / near[:, axis]
            assert is_near.sum() > 400
            assert_allclose(look_up(ratios[None].astype(np.float32), 5, near)[0], expected, atol=1e-5)


def test_a_linear_function_of_direction_is_only_scaled():
    # The mean of n·d over a von Mises-Fisher density is (coth κ − 1/κ) n·d, κ = 1/σ²; here less, as the tail is cut.
    values = GRID.directions @ np.array([0.3, -0.5, 0.8])
    got = look_up(BLUR(values[None].astype(np.float32), ALL), BLUR.n_cells, LOOK)[0]
    kappa = np.deg2rad(3.0) ** -2
    assert_allclose(got, (1.0 - 1.0 / kappa) * (LOOK @ np.array([0.3, -0.5, 0.8])), atol=4e-3)


@pytest.mark.parametrize("grid", [GRID, gauss_legendre(60), fibonacci(5000)], ids=lambda grid: grid.name)
def test_a_constant_stays_and_the_whole_sphere_is_seen(grid):
    blur = blur_to_cube(grid, np.deg2rad(3.0), "fine_blur")
    maps = blur(np.full((1, grid.n_directions), 0.7, np.float32), np.ones((1, grid.n_directions), bool))
    assert_allclose(maps, 0.7, rtol=1e-6)
    coverage = np.add.reduceat(blur.weights.astype(float), blur.starts[:-1])
    assert_allclose(coverage, 1.0, atol=0.1)
    assert_allclose(coverage.mean(), 1.0, atol=0.01)


def test_the_edge_of_the_mask_is_where_half_was_seen():
    seen = cap(GRID.directions, 60.0)[None]
    maps = BLUR(np.ones((1, GRID.n_directions), np.float32), seen)
    away = np.rad2deg(np.arccos(cube_nodes(BLUR.n_cells)[:, 2]))
    assert np.isnan(maps[0, away > 61.5]).all()
    assert_array_equal(maps[0, away < 58.5], 1.0)
    fine = equirectangular(1.0)  # on which a tenth of the blur's width is told
    blur = blur_to_cube(fine, np.deg2rad(3.0), "fine_blur")
    maps = blur(np.ones((1, fine.n_directions), np.float32), cap(fine.directions, 60.0)[None])
    assert np.isnan(maps[0, away > 60.4]).all()
    assert_array_equal(maps[0, away < 59.6], 1.0)


def test_what_was_not_seen_changes_no_bit():
    sky, seen = bumpy_sky(0)(GRID.directions).astype(np.float32)[None], cap(GRID.directions, 70.0)[None]
    rubbish = np.where(seen, sky, np.float32(np.nan))
    assert_array_equal(BLUR(sky, seen), BLUR(rubbish, seen))


def test_neighbouring_faces_agree_at_their_edge():
    values = bumpy_sky(1)(GRID.directions).astype(np.float32)[None]
    maps = BLUR(values, ALL)
    along = np.linspace(-0.99, 0.99, 50)
    edge = np.stack([np.ones_like(along), np.ones_like(along), along], axis=-1)
    sides = [edge + np.array([1e-6, -1e-6, 0.0]), edge + np.array([-1e-6, 1e-6, 0.0])]
    one, other = (look_up(maps, BLUR.n_cells, side / np.linalg.norm(side, axis=-1, keepdims=True)) for side in sides)
    assert_allclose(one, other, atol=5e-3)
    assert np.ptp(one) > 0.1


def test_the_axes_and_the_corners_are_looked_up():
    maps = BLUR(np.ones((1, GRID.n_directions), np.float32), ALL)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / np.sqrt(3.0)
    for look in (np.eye(3), -np.eye(3), corners, directions(0.0, np.pi / 2)):
        assert_array_equal(look_up(maps, BLUR.n_cells, look), 1.0)


def test_a_grid_that_is_too_coarse_is_refused():
    with pytest.raises(InputError, match=r"3° apart, expected at most 1.6 times fine_blur, which is 1°: a larger"):
        blur_to_cube(GRID, np.deg2rad(1.0), "fine_blur")
