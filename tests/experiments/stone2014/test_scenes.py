"""Scenes of Stone et al. 2014: masks, seeds, names, and the plants in them."""

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from insectnav.experiments.stone2014_sky_segmentation import scenes
from insectnav.experiments.stone2014_sky_segmentation.photographs import FullSpectrum
from insectnav.experiments.stone2014_sky_segmentation.scene_plants import bushes, grass, in_ball, leafy_trees, leaves_in
from insectnav.experiments.stone2014_sky_segmentation.scenes import SCENES
from insectnav.experiments.stone2014_sky_segmentation.time_lapse import LOWEST_SUN_DEG, WEATHERS, lapse_sky, moments
from insectnav.worlds import render
from insectnav.worlds.materials import MATERIALS
from insectnav.worlds.shapes import triangle_areas
from insectnav.worlds.world import flat_world

PUBLISHED = Path(scenes.__file__).parent / "published.csv"


def test_there_are_eighteen_scenes_of_which_twelve_are_named_in_the_table():
    with PUBLISHED.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["experiment"] == "stone2014-table-1"]
    names = {row["quantity"].partition(": ")[0] for row in rows if row["quantity"].endswith(": GMM, UV")} - {"mean"}
    assert {scene.name for scene in SCENES if scene.is_named} == names - {"standard deviation"}
    assert len({scene.name for scene in SCENES}) == len(SCENES) == 18
    assert len(names - {"standard deviation"}) == 12


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_a_scene_is_the_same_each_time_and_has_sky_and_ground(scene: scenes.Scene):
    mesh = scene.build()
    assert np.array_equal(scene.build().vertices, mesh.vertices)
    assert set(mesh.materials) <= set(MATERIALS)
    assert scene.sky.sun_elevation > np.deg2rad(2.0)
    eye, pitch = [[0.0, 0.0, scene.eye_height]], np.deg2rad(scene.pitch_deg)
    camera = FullSpectrum(reduction=8).camera
    sky = render(flat_world(mesh), eye, 0.0, pitch, camera=camera, layers=("sky",), supersampling=2)["sky"][0]
    share = (sky >= 0.5).mean()
    assert 0.15 < share < 0.8  # of a picture that shows sky and ground
    assert sky[: len(sky) // 2].mean() > sky[len(sky) // 2 :].mean()  # sky is up


def test_the_sky_of_a_scene_turns_with_the_camera():
    ahead, right = (scenes.scene_sky(scenes.SEVILLE, "2013-07-15T10:00", facing, "dark", 1) for facing in (0.0, 90.0))
    assert_allclose(ahead.sun_azimuth - right.sun_azimuth, np.pi / 2, atol=1e-9)
    assert ahead.sun_elevation == right.sun_elevation
    assert ahead.clouds is not None
    assert ahead.clouds.seed == 1


def test_leaves_cover_as_much_as_they_are_said_to():
    lumps, radii = np.array([[0.0, 0.0, 10.0], [30.0, 0.0, 10.0]]), np.array([[3.0, 3.0, 3.0], [2.0, 4.0, 1.0]])
    leaves = leaves_in(np.random.default_rng(0), lumps, radii, 0.2, 2.5)
    # The length is even between half and all of 0.2 m: its mean square is 7/12, that of the mean length 9/16.
    expected = 2.5 * np.pi * (9.0 + 8.0) * (7.0 / 12.0) / (9.0 / 16.0)
    assert triangle_areas(leaves).sum() == pytest.approx(expected, rel=0.03)


def test_points_in_a_ball_are_as_many_in_equal_volumes():
    radius = np.linalg.norm(in_ball(np.random.default_rng(1), 40_000, 0.6), axis=-1)
    assert radius.min() >= 0.6
    half = (0.5 * (0.6**3 + 1.0)) ** (1.0 / 3.0)
    assert (radius < half).mean() == pytest.approx(0.5, abs=0.015)  # three standard errors are 0.0075


def test_plants_stand_on_the_ground_within_their_height():
    rng = np.random.default_rng(2)
    feet = np.array([[0.0, 0.0, 0.0], [10.0, 5.0, 2.0]])
    for parts in (leafy_trees(rng, feet, np.array([8.0, 8.0])), bushes(rng, feet, np.array([2.0, 2.0]))):
        for _, triangles in parts:
            assert triangles[..., 2].min() >= 0.0
            assert triangles[..., 2].max() < 2.0 + 1.1 * 8.0
    material, blades = grass(rng, (0.0, 0.0), (3.0, 3.0), 0.4)
    assert material == "straw"
    assert blades[..., 2].max() < 0.4


def test_bare_trees_have_wood_alone():
    leaves, wood = leafy_trees(np.random.default_rng(0), np.zeros((1, 3)), np.array([6.0]), density=0.0)
    assert leaves[1].size == 0
    assert wood[1].size > 0


def test_moments_of_a_day_are_ten_minutes_apart_and_have_the_sun_up():
    every = moments()
    assert set(np.diff(every)) == {10}
    elevations = [lapse_sky("clear", minute).sun_elevation for minute in every]
    assert min(elevations) >= np.deg2rad(LOWEST_SUN_DEG)
    # Noon at Edinburgh on 15 January: 90° less the latitude, 55.94°, and a declination of −21.2°.
    assert np.rad2deg(max(elevations)) == pytest.approx(90.0 - 55.94 - 21.2, abs=0.3)


@pytest.mark.parametrize("weather", WEATHERS)
def test_clouds_drift_from_one_moment_to_the_next(weather: str):
    first, second = lapse_sky(weather, 700), lapse_sky(weather, 710)
    assert second.time - first.time == 600.0
    assert first.clouds == second.clouds
