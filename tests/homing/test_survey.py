"""Surveys against the same views all at once, laws of what is measured, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.homing import (
    catchment_area,
    distance_from,
    feature_distance,
    grid_positions,
    random_headings,
    rms_difference,
    survey,
    visual_compass,
)
from insectnav.records import Mesh
from insectnav.vision.descriptors import DESCRIPTORS, zernike_amplitudes
from insectnav.worlds import flat_world, render_panorama

COARSE = {"resolution_deg": 5.0, "elevation_deg": (-15.0, 90.0), "supersampling": 2}


@pytest.fixture(scope="module")
def world():
    """Triangles round an empty place of 4 × 4 m."""
    rng = np.random.default_rng(4)
    angle, distance = rng.uniform(0, 2 * np.pi, 60), rng.uniform(4.0, 12.0, 60)
    foot = np.stack([distance * np.sin(angle), distance * np.cos(angle), np.zeros(60)], axis=-1)
    corners = foot[:, None] + rng.uniform(-0.7, 0.7, (60, 3, 3))
    corners[..., 2] = rng.uniform(0.0, 3.0, (60, 3))
    return flat_world(Mesh(vertices=corners), extent=[[-3, -3], [3, 3]])


# A grid of places.


def test_grid_counts_x_along_columns_and_y_along_rows():
    grid = grid_positions((0.2, 0.1), 0.1, (5.0, -1.0))
    assert_allclose(grid, [[[5.0, -1.0], [5.1, -1.0], [5.2, -1.0]], [[5.0, -0.9], [5.1, -0.9], [5.2, -0.9]]])


@given(n=st.integers(1, 60), spacing=st.floats(0.01, 5.0))
def test_far_edge_of_the_grid_has_samples(n, spacing):
    grid = grid_positions(n * spacing, spacing)
    assert grid.shape == (n + 1, n + 1, 2)
    assert_allclose(grid[-1, -1], n * spacing)


def test_grid_of_the_thesis():
    assert grid_positions(10.0, 0.02).shape == (501, 501, 2)  # section 4.3: every 2 cm in a box of 10 × 10 m


@pytest.mark.parametrize(
    ("size", "spacing", "words"),
    [(1.0, 0.3, "divides"), (1.0, 2.0, "size"), (1.0, 0.0, "spacing"), ("ten", 1.0, "numbers")],
)
def test_grid_refuses(size, spacing, words):
    with pytest.raises(InputError, match=words):
        grid_positions(size, spacing)


# Streaming.


def test_block_by_block_is_all_at_once(world, monkeypatch):
    grid = grid_positions(2.0, 0.25, (-1.0, -1.0))
    headings = random_headings(grid.shape[:2], 1)
    views = render_panorama(world, grid.reshape(-1, 2), headings.reshape(-1), **COARSE)
    for at_once in (1, 7, 81, 1000):
        monkeypatch.setitem(survey.__globals__, "VIEWS_AT_ONCE", at_once)
        found = survey(world, grid, headings, {"zernike": zernike_amplitudes, "pixels": lambda v: v}, **COARSE)
        assert_array_equal(found["pixels"].reshape(views.shape), views)
        assert_allclose(found["zernike"].reshape(81, -1), zernike_amplitudes(views), rtol=1e-6, atol=1e-7)


def test_threads_change_nothing(world):
    grid = grid_positions(3.0, 0.2, (-1.5, -1.5))  # 256 views: four blocks
    remembered = render_panorama(world, [[0.0, 0.0], [1.0, 0.5]], 0.0, **COARSE)
    measures = {"aligned": distance_from(remembered), "zernike": DESCRIPTORS["zernike"]}
    one, two = (survey(world, grid, 0.0, measures, workers=workers, **COARSE) for workers in (1, 2))
    for name in measures:
        assert_array_equal(one[name], two[name])


def test_progress_tells_of_each_view_once(world):
    told: list[int] = []
    survey(
        world, grid_positions(3.0, 0.2, (-1.5, -1.5)), 0.0, {"z": zernike_amplitudes}, progress=told.append, **COARSE
    )
    assert sum(told) == 256
    assert len(told) > 1


def test_precision_is_what_is_asked_for(world):
    for dtype in ("float32", "float64"):
        assert survey(world, [[0.0, 0.0]], 0.0, {"z": zernike_amplitudes}, dtype=dtype, **COARSE)["z"].dtype == dtype


def test_a_single_place_and_one_number_a_view(world):
    found = survey(world, [0.5, 0.5], 0.0, {"mean": lambda views: views.mean(axis=(1, 2))}, **COARSE)
    assert found["mean"].shape == ()
    assert 0.1 < found["mean"] < 1.0


# Distances.


def test_distances_are_those_of_one_remembered_view_at_a_time(world):
    places = np.random.default_rng(0).uniform(-2, 2, (9, 2))
    views = render_panorama(world, places, 0.0, **COARSE)
    remembered = views[[2, 5]]
    aligned, compass = distance_from(remembered)(views), distance_from(remembered, "compass")(views)
    zernike = distance_from(remembered, zernike_amplitudes)(views)
    for k, view in enumerate(remembered):
        assert_allclose(aligned[:, k], rms_difference(views, view), rtol=1e-9, atol=1e-6)
        assert_allclose(compass[:, k], visual_compass(views, view).difference, rtol=1e-7, atol=1e-6)
        expected = feature_distance(zernike_amplitudes(views), zernike_amplitudes(view))
        assert_allclose(zernike[:, k], expected, rtol=1e-9, atol=1e-12)
    assert_allclose(aligned[[2, 5], [0, 1]], 0.0, atol=1e-6)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000))
def test_best_over_turns_is_no_worse_than_aligned_and_knows_no_turn(seed):
    rng = np.random.default_rng(seed)
    views, remembered = rng.random((3, 6, 36)).astype(np.float32), rng.random((2, 6, 36))
    compass = distance_from(remembered, "compass")
    assert (compass(views) <= distance_from(remembered)(views) + 1e-7).all()
    assert_allclose(compass(np.roll(views, int(rng.integers(36)), axis=-1)), compass(views), atol=1e-7)


def test_bytes_count_as_brightness():
    rng = np.random.default_rng(2)
    remembered = rng.integers(0, 256, (2, 4, 8), np.uint8)
    views = rng.random((5, 4, 8)).astype(np.float32)
    assert_allclose(distance_from(remembered)(views), distance_from(remembered / 255.0)(views), atol=1e-7)


@pytest.mark.parametrize("name", ["zernike", "zernike-orthonormal", "frequency-strip", "spherical-harmonics"])
def test_whole_degrees_leave_amplitudes(world, name):
    """At headings of whole pixels the eye sees the same samples, so that what forgets the heading gives the same."""
    places = np.random.default_rng(1).uniform(-2, 2, (7, 2))
    headings = np.deg2rad(np.random.default_rng(2).integers(-180, 180, 7))
    remembered = render_panorama(world, places[:2], 0.0)
    by = {name: distance_from(remembered, DESCRIPTORS[name]), "pixels": distance_from(remembered)}
    north, turned = survey(world, places, 0.0, by), survey(world, places, headings, by)
    assert_allclose(turned[name], north[name], rtol=1e-5, atol=1e-6)
    assert np.abs(turned["pixels"] - north["pixels"]).max() > 0.01


def test_an_area_is_at_most_the_box(world):
    grid = grid_positions(2.0, 0.2, (-1.0, -1.0))
    remembered = render_panorama(world, [[0.0, 0.0]], 0.0, **COARSE)
    surface = survey(world, grid, 0.0, {"a": distance_from(remembered)}, **COARSE)["a"][..., 0]
    area, is_inside = catchment_area(surface, 0.2, [1.0, 1.0], 0.3)
    assert 0.0 < area <= 4.0
    assert is_inside.shape == (10, 10)


# What is refused.


@pytest.mark.parametrize(
    ("positions", "headings", "measures", "words"),
    [
        ([[0.0, 0.0]], 0.0, {}, "measures is empty"),
        (np.empty((0, 2)), 0.0, {"z": zernike_amplitudes}, "number of positions"),
        ([[0.0, 0.0]], [0.0, 1.0], {"z": zernike_amplitudes}, "headings has shape"),
        ([[0.0, 0.0]], 90.0, {"z": zernike_amplitudes}, "degrees"),
        ([[9.0, 0.0]], 0.0, {"z": zernike_amplitudes}, "outside the world"),
        ([[0.0, 0.0]], 0.0, {"sum": lambda views: views.sum(axis=0)}, "a row for each view"),
        ([[0.0, 0.0]], 0.0, {"words": lambda views: np.array(["a"] * len(views))}, "real numbers"),
    ],
)
def test_survey_refuses(world, positions, headings, measures, words):
    with pytest.raises(InputError, match=words):
        survey(world, positions, headings, measures, **COARSE)


def test_distance_refuses():
    views = np.zeros((2, 4, 8))
    with pytest.raises(InputError, match="aligned"):
        distance_from(views, "turned")
    with pytest.raises(InputError, match="remembered"):
        distance_from(views[0])
    for by in ("aligned", "compass"):
        with pytest.raises(InputError, match="as the remembered ones"):
            distance_from(views, by)(np.zeros((3, 4, 9), np.float32))
