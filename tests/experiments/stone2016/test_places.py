"""The box, its references and grids: what the experiments of section 4.3 share."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.datasets.known_worlds import DATA_VARIABLE
from insectnav.experiments.stone2016_homing import clutter, coding, fig_4_3, fig_4_4, fig_4_5, fig_4_6, sampling
from insectnav.experiments.stone2016_homing.places import (
    CORNERS,
    SIZE,
    STAND_IN,
    areas,
    open_world,
    reference_places,
    stage,
    stands_in,
    surfaces,
)
from insectnav.homing import feature_distance, grid_positions, rms_difference
from insectnav.vision.descriptors import zernike_amplitudes
from insectnav.worlds import render_panorama

EXPERIMENTS = (fig_4_3, fig_4_4, fig_4_5, fig_4_6, sampling, coding, clutter)
SPACING, CORNER = 1.0, -5.0


@pytest.fixture(scope="module")
def world():
    return open_world(STAND_IN, 0, tree_density=0.002, tussock_density=0.02)


def test_twenty_references_in_the_box():
    places = reference_places(0.0)
    assert places.shape == (20, 2)
    assert ((places > 0.0) & (places < SIZE)).all()
    assert_allclose(places.mean(axis=0), SIZE / 2.0)  # as far from one edge as from the other
    assert_allclose(reference_places(-5.0), places - 5.0)


@pytest.mark.parametrize("spacing", [0.02, 0.05, 0.1, 0.2])
def test_references_are_samples_of_all_grids(spacing):
    steps = reference_places(0.0) / spacing
    assert_allclose(steps, np.rint(steps), atol=1e-9)


@pytest.mark.parametrize("experiment", EXPERIMENTS)
@pytest.mark.parametrize("scale", ["quick", "full"])
def test_without_the_data_built_worlds_stand_in(experiment, scale, monkeypatch):
    monkeypatch.delenv(DATA_VARIABLE, raising=False)
    cells = experiment.grid(scale)
    assert all(stands_in(cell.world) for cell in cells)
    assert all(cell.corner == CORNERS[STAND_IN] for cell in cells)


def test_a_missing_world_is_told_of_where_a_cell_names_it(monkeypatch):
    monkeypatch.delenv(DATA_VARIABLE, raising=False)
    open_world.cache_clear()
    assert stage("clearing") == STAND_IN
    with pytest.raises(InputError, match="the world clearing is missing"):
        open_world("clearing")


def test_surfaces_are_those_of_all_views_at_once(world):
    grid = grid_positions(SIZE, SPACING, (CORNER, CORNER))
    views = render_panorama(world, grid.reshape(-1, 2), 0.0, supersampling=1)
    remembered = render_panorama(world, reference_places(CORNER), 0.0, supersampling=1)
    by = {"pixels": "aligned", "zernike": zernike_amplitudes}
    found = surfaces(world, CORNER, SPACING, "aligned", by, seed=0, supersampling=1)
    for k in (0, 7, 19):
        expected = rms_difference(views, remembered[k]).reshape(11, 11)
        assert_allclose(found["pixels"][k], expected, rtol=1e-5, atol=1e-6)
        expected = feature_distance(zernike_amplitudes(views), zernike_amplitudes(remembered[k])).reshape(11, 11)
        assert_allclose(found["zernike"][k], expected, rtol=1e-5, atol=1e-6)


def test_random_headings_come_from_the_seed(world):
    first, again, other = (
        surfaces(world, CORNER, 2.0, "random", {"a": "aligned"}, seed=seed, supersampling=1)["a"] for seed in (1, 1, 2)
    )
    assert_array_equal(first, again)
    assert (first != other).any()


def test_area_of_a_cone_is_the_box_and_of_a_plain_the_radius():
    """From anywhere on a cone the slope leads to its tip; where there is no slope only starts at home are home."""
    grid = grid_positions(SIZE, 0.2)
    cones = np.stack([np.linalg.norm(grid - place, axis=-1) for place in reference_places(0.0)])
    assert_allclose(areas(cones, 0.2, 0.3), SIZE**2)
    flat = areas(np.zeros_like(cones), 0.2, 0.3)
    assert_allclose(flat, 4 * 0.04 + 8 * 0.0, atol=0.5)
    assert (flat < 1.0).all()


def test_every_second_sample_is_a_grid_of_its_own():
    """A ridge that a coarse grid does not sample is not in its way."""
    grid = grid_positions(SIZE, 0.2)
    cones = np.stack([np.linalg.norm(grid - place, axis=-1) for place in reference_places(0.0)])
    ridged = np.full((20, 101, 101), 20.0)
    ridged[:, ::2, ::2] = cones
    assert_allclose(areas(ridged, 0.1, 0.3, every=2), SIZE**2)
    assert (areas(ridged[:, :, :], 0.1, 0.15) < 1.0).all()
