"""The full-spectrum camera of Stone et al. 2014: optics, exposure, noise, white balance."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from insectnav.experiments.stone2014_sky_segmentation.photographs import (
    DAYLIGHT,
    FullSpectrum,
    photograph,
    seen_share_of_sun,
    shown,
    view,
)
from insectnav.vision.lens_flare import NO_FLARE
from insectnav.worlds import light_world
from insectnav.worlds.shapes import box, mesh_from
from insectnav.worlds.sky import Sky

HOW = FullSpectrum(reduction=8, supersampling=2, flare=NO_FLARE)
SKY = Sky(sun_azimuth=np.pi, sun_elevation=0.8)
PARTS = [("brick", box(6.0, 2.0, 5.0) + np.array([0.0, 15.0, 0.0]))]


def sheets(left: float, right: float) -> dict[str, np.ndarray]:
    """Layers of a sheet that is half as bright as a white one times left, the other times right."""
    rows, columns = HOW.camera.size
    half = np.where(np.arange(columns) < columns // 2, left, right) * np.ones((rows, 1))
    white = dict(zip(("uv", "red", "green", "blue"), DAYLIGHT.irradiance(("uv", "red", "green", "blue")), strict=True))
    layers = {band: half * light / np.pi for band, light in white.items()}
    return layers | {"sky": half > 0.5}


def test_the_field_is_that_of_a_35_mm_lens():
    camera = FullSpectrum().camera
    assert camera.size == (403, 604)
    ends = camera.look(np.array([[0.0, 201.5], [604.0, 201.5]]))
    assert np.rad2deg(np.arccos(ends[0] @ ends[1])) == pytest.approx(
        2 * np.rad2deg(np.arctan(35.9 / 2 / 35.0)), abs=0.01
    )


def test_each_picture_is_metered_to_18_percent():
    picture = photograph(sheets(0.4, 0.6), DAYLIGHT, 0.0, 1.0, HOW, seed=0)
    for numbers in (picture.visible, picture.uv, picture.green):
        assert numbers.mean() / 65535 == pytest.approx(0.18, rel=0.01)
        columns = numbers.reshape(*numbers.shape[:2], -1).mean(axis=(0, 2))
        assert columns[-1] / columns[0] == pytest.approx(1.5, rel=0.02)
    assert picture.sky[:, -1].all()
    assert not picture.sky[:, 0].any()
    assert_allclose(picture.uv_green[..., 1], picture.green)


def test_a_white_sheet_by_daylight_is_white_and_by_other_light_is_not():
    by_daylight = photograph(sheets(0.5, 0.5), DAYLIGHT, 0.0, 1.0, replace(HOW, n_raw=0), seed=0).visible
    assert int(np.ptp(by_daylight.astype(int))) <= 1
    low = Sky(sun_azimuth=0.0, sun_elevation=0.1)
    layers = sheets(0.5, 0.5)
    ratio = low.irradiance(("blue",))[0] / DAYLIGHT.irradiance(("blue",))[0]
    layers["blue"] = layers["blue"] * ratio
    fixed = photograph(layers, low, 0.0, 0.0, HOW, seed=0).visible.mean(axis=(0, 1))
    assert fixed[2] < 0.9 * fixed[0]


def test_noise_falls_with_the_root_of_the_raw_pixels():
    spread = []
    for n_raw in (1, 25):
        uv = photograph(sheets(0.5, 0.5), DAYLIGHT, 0.0, 1.0, replace(HOW, n_raw=n_raw), seed=0).uv
        spread.append(uv.astype(float).std())
    assert spread[0] / spread[1] == pytest.approx(5.0, rel=0.06)  # three standard errors of 3750 pixels each: 5 %
    silent = photograph(sheets(0.5, 0.5), DAYLIGHT, 0.0, 1.0, replace(HOW, n_raw=0), seed=0).uv
    assert np.ptp(silent) == 0


def test_the_same_seed_has_the_same_noise_and_another_has_not():
    one, again, other = (photograph(sheets(0.5, 0.4), DAYLIGHT, 0.0, 1.0, HOW, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(one.visible, again.visible)
    assert not np.array_equal(one.uv, other.uv)


def test_three_stops_less_are_an_eighth():
    dark = photograph(sheets(0.5, 0.5), DAYLIGHT, 0.0, 1.0, replace(HOW, exposure=0.125, n_raw=0), seed=0).uv
    assert dark.mean() / 65535 == pytest.approx(0.18 / 8.0, rel=1e-3)


def test_a_view_has_the_radiance_of_the_sky_where_nothing_stands():
    lit = light_world(mesh_from(PARTS, "block"), SKY, ground="grass", extent=[[-50.0, -50.0], [50.0, 50.0]])
    layers = view(lit, 1.6, 0.1, HOW)
    looks = HOW.camera.pixel_directions()[0, 0]
    sine, cosine = np.sin(0.1), np.cos(0.1)
    up = np.array([looks[0], looks[1] * cosine - looks[2] * sine, looks[2] * cosine + looks[1] * sine])
    assert layers["sky"][0, 0] == 1.0
    assert layers["uv"][0, 0] == pytest.approx(SKY.radiance(up, ("uv",))[0], rel=1e-5)
    assert layers["sky"][-1].max() == 0.0


def test_the_sun_shines_on_the_lens_unless_something_stands_before_it():
    mesh, extent = mesh_from(PARTS, "block"), [[-50.0, -50.0], [50.0, 50.0]]
    behind = light_world(mesh, Sky(sun_azimuth=0.0, sun_elevation=0.1), extent=extent)
    assert seen_share_of_sun(behind, 1.6) == 0.0
    assert seen_share_of_sun(light_world(mesh, SKY, extent=extent), 1.6) == 1.0


def test_what_is_shown_is_the_mean_of_blocks_encoded():
    picture = np.full((9, 12), 65535, np.uint16)
    picture[:, 6:] = 0
    assert shown(picture, 4).tolist() == [[255, 255, 0, 0]] * 3
