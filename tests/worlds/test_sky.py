"""The whole sky: limits (clear, standard overcast), energy, what clouds do in each band, and its place in time."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.worlds.clouds import CloudField, weather_clouds
from insectnav.worlds.polarisation import e_vector_angle, maximal_degree, rayleigh_degree
from insectnav.worlds.sky import Sky, overcast_pattern, sky_at
from insectnav.worlds.skylight import BANDS, air_mass, atmosphere, clear_irradiance, clear_radiance
from insectnav.worlds.sun import sun_direction, sun_position

CLEAR = Sky(sun_azimuth=2.0, sun_elevation=0.7)
SHEET = CloudField(cover=1.0, optical_depth=40.0, variation=0.0)  # lets a quarter of the light through
ZENITH = np.array([0.0, 0.0, 1.0])
UV, GREEN = list(BANDS).index("uv"), list(BANDS).index("green")


def sky_points(n_rings: int = 60, n_sectors: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints of even cells of elevation and azimuth, and their weights for the irradiance of level ground."""
    elevation = (np.arange(n_rings) + 0.5) * np.pi / 2 / n_rings
    azimuth = (np.arange(n_sectors) + 0.5) * 2 * np.pi / n_sectors
    directions = sun_direction(*np.meshgrid(azimuth, elevation))
    weights = np.sin(elevation) * np.cos(elevation) * np.pi / 2 / n_rings * 2 * np.pi / n_sectors
    return directions.reshape(-1, 3), np.repeat(weights, n_sectors)


# Limits.


def test_cloudless_sky_is_the_clear_sky():
    directions, _ = sky_points(10, 12)
    expected = clear_radiance(directions, CLEAR.sun, 3.0)
    assert CLEAR.radiance(directions, sun_disc=False) == pytest.approx(expected, rel=1e-6)
    for nothing in (CloudField(cover=0.0), CloudField(cover=1.0, optical_depth=0.0)):
        assert replace(CLEAR, clouds=nothing).radiance(directions) == pytest.approx(CLEAR.radiance(directions))


@given(st.floats(0.1, 1.5), st.floats(-3.0, 3.0), st.floats(2.0, 8.0))
@settings(max_examples=20, deadline=None)
def test_overcast_sky_is_the_standard_one(sun_elevation, sun_azimuth, turbidity):
    # Moon and Spencer 1942: (1 + 2 sin θ) / 3 of the zenith, wherever the sun is; its irradiance 7π/9 of the zenith.
    sky = Sky(sun_azimuth=sun_azimuth, sun_elevation=sun_elevation, turbidity=turbidity, clouds=SHEET)
    elevation = np.linspace(0.0, np.pi / 2, 20)
    radiance = sky.radiance(sun_direction(1.0, elevation))
    zenith = sky.radiance(ZENITH)
    expected = (1.0 + 2.0 * np.sin(elevation)[:, None]) / 3.0 * zenith
    assert radiance == pytest.approx(expected, rel=1e-5)
    clear = clear_irradiance(sun_elevation, atmosphere(turbidity)).horizontal
    assert sky.irradiance() == pytest.approx(0.25 * clear, rel=1e-5)
    assert zenith * 7 * np.pi / 9 == pytest.approx(0.25 * clear, rel=1e-5)
    assert sky.sun_irradiance() == pytest.approx(0.0, abs=1e-12)
    assert sky.polarisation(sun_direction(1.0, elevation)).degree == pytest.approx(0.0, abs=1e-6)


def test_overcast_pattern_has_the_mean_one():
    directions, weights = sky_points(400, 4)
    assert weights @ overcast_pattern(directions[:, 2]) == pytest.approx(np.pi, rel=1e-4)
    assert overcast_pattern(1.0) / overcast_pattern(0.0) == pytest.approx(3.0)


def test_clouds_of_the_overcast_weather_stay_near_the_standard():
    # Over many skies the uneven sheet lets through a quarter, and a little more: thin places gain more than thick lose.
    shares = []
    for seed in range(12):
        sky = replace(CLEAR, clouds=weather_clouds("overcast", seed))
        shares.append(sky.irradiance() / CLEAR.irradiance())
    assert np.ptp(shares, axis=1).max() < 0.005  # the same in all bands, but for the air beneath the clouds
    assert 0.24 < np.mean(shares) < 0.28


@pytest.mark.parametrize(("weather", "oktas", "tolerance"), [("scattered", 3.5, 0.15), ("broken", 6.0, 0.08)])
def test_clouds_dim_daylight_as_measured(weather, oktas, tolerance):
    # Kasten and Czeplak 1980, ten years in Hamburg: 1 − 0.75 (N / 8)^3.4 of the cloudless irradiance on average.
    measured = 1.0 - 0.75 * (oktas / 8.0) ** 3.4
    n = 150
    shares = [replace(CLEAR, clouds=weather_clouds(weather, seed)).irradiance() for seed in range(n)]
    shares = np.array(shares)[:, GREEN] / CLEAR.irradiance()[GREEN]
    assert shares.mean() == pytest.approx(measured, abs=tolerance + 3.0 * shares.std() / np.sqrt(n))


# Bands.


def test_clouds_are_white_and_stand_out_in_green_but_hardly_in_ultraviolet():
    directions, _ = sky_points(20, 36)
    high = directions[directions[:, 2] > 0.5]
    ratios = []
    for seed in range(10):
        sky = replace(CLEAR, clouds=weather_clouds("broken", seed))
        depth = sky.clouds.look(high).optical_depth
        thick, gap = (depth > 2.0), (depth == 0.0)
        light = sky.radiance(high, sun_disc=False)
        assert thick.any()
        cloud = light[thick] / CLEAR.irradiance()
        assert np.median(cloud.max(axis=-1) / cloud.min(axis=-1)) < 1.2  # white
        if gap.any():
            ratios.append(np.median(light[thick], axis=0) / np.median(light[gap], axis=0))
    ratio = np.median(ratios, axis=0)
    assert (np.diff(ratio) > 0.0).all()  # from ultraviolet to red
    assert ratio[GREEN] > 1.8 * ratio[UV]
    assert 0.7 < ratio[UV] < 2.0


def test_far_clouds_fade_sooner_in_ultraviolet():
    directions = sun_direction(np.linspace(0.0, 0.5, 400), np.deg2rad(6.0))
    contrast = []
    for seed in range(20):
        light = replace(CLEAR, sun_azimuth=-2.0, clouds=weather_clouds("broken", seed)).radiance(directions)
        contrast.append(light.std(axis=0) / light.mean(axis=0))
    contrast = np.median(contrast, axis=0)
    assert contrast[UV] < 0.5 * contrast[GREEN]


@pytest.mark.parametrize("turbidity", [2.0, 6.0])
def test_far_clouds_lose_what_the_air_beneath_them_takes(turbidity):
    # Opaque clouds at one elevation differ by their transmittance. Of that is seen exp(−m τ), with the share
    # 1 − exp(−h/H) of the air (1 / H = 0.1136 per km) and of the haze (0.8333 per km) below h = 2 km.
    field = CloudField(cover=1.0, optical_depth=400.0, base_height=2000.0)
    sky = Sky(sun_azimuth=1.0, sun_elevation=0.7, turbidity=turbidity, clouds=field)
    directions = sun_direction(np.linspace(0.0, 1.0, 400), 0.15)
    depth = field.look(directions).optical_depth
    thin, thick = np.argmin(np.where(depth > 50.0, depth, np.inf)), np.argmax(depth)
    light = sky.radiance(directions[[thin, thick]], sun_disc=False)
    air, bands = atmosphere(turbidity), BANDS.values()
    vertical = [
        air.rayleigh_depth(band) * (1 - np.exp(-2.0 * 0.1136)) + air.haze_depth(band) * (1 - np.exp(-2.0 * 0.8333))
        for band in bands
    ]
    difference = np.subtract(*(2.0 / (2.0 + 0.15 * depth[[thin, thick]])))
    white = clear_irradiance(0.7, air).horizontal / np.pi * 3.0 / 7.0 * (1.0 + 2.0 * np.sin(0.15))
    expected = white * difference * np.exp(-air_mass(0.15) * np.array(vertical))
    assert light[0] - light[1] == pytest.approx(expected, rel=2e-3)


# Sun and energy.


@pytest.mark.parametrize("diameter_deg", [0.53, 2.0, 10.0])
@pytest.mark.parametrize("clouds", [None, CloudField(cover=1.0, optical_depth=1.0, variation=0.0)])
def test_disc_holds_the_light_of_the_sun(diameter_deg, clouds):
    radius = np.deg2rad(diameter_deg) / 2
    sky = replace(CLEAR, clouds=clouds, sun_diameter=2 * radius)
    aside = np.cross(sky.sun, ZENITH) / np.linalg.norm(np.cross(sky.sun, ZENITH))
    angles = np.array([0.0, 0.98, 1.02]) * radius
    directions = np.cos(angles)[:, None] * sky.sun + np.sin(angles)[:, None] * aside
    disc = sky.radiance(directions) - sky.radiance(directions, sun_disc=False)
    assert (disc[2] == 0.0).all()
    solid_angle = np.pi * (2 * np.sin(radius / 2)) ** 2
    assert disc[0] * solid_angle == pytest.approx(sky.sun_irradiance(), rel=1e-4)
    assert disc[1] * solid_angle == pytest.approx(sky.sun_irradiance(), rel=0.01 if clouds is None else 0.2)


def test_sun_through_a_thin_sheet():
    sheet = CloudField(cover=1.0, optical_depth=1.0, variation=0.0)
    share = replace(CLEAR, clouds=sheet).sun_irradiance() / CLEAR.sun_irradiance()
    assert share == pytest.approx(np.exp(-1.0 / np.sin(0.7)), rel=1e-3)  # the Earth is nearly flat at 40°


@pytest.mark.parametrize("weather", ["clear", "scattered", "broken", "overcast"])
def test_irradiance_is_that_of_the_radiance(weather):
    sky = replace(CLEAR, clouds=weather_clouds(weather, 2))
    directions, weights = sky_points()
    expected = weights @ sky.radiance(directions, sun_disc=False) + sky.sun_irradiance() * np.sin(0.7)
    assert sky.irradiance() == pytest.approx(expected, rel=0.05)


def test_nothing_below_the_horizon():
    below = sun_direction(np.linspace(0.0, 6.0, 20), -1e-3)
    sky = replace(CLEAR, clouds=weather_clouds("broken"))
    assert (sky.radiance(below) == 0.0).all()
    assert (sky.polarisation(below).degree == 0.0).all()
    assert (sky.radiance([1.0, 0.0, -1e-16]) > 0.0).all()  # level, but for rounding


# Polarisation.


def test_polarisation_of_the_clear_sky_is_that_of_single_scattering():
    directions, _ = sky_points(10, 12)
    found = CLEAR.polarisation(directions)
    assert found.degree == pytest.approx(maximal_degree(3.0) * rayleigh_degree(directions, CLEAR.sun), abs=1e-6)
    assert found.angle == pytest.approx(e_vector_angle(directions, CLEAR.sun), abs=1e-6)


def test_clouds_depolarise_and_turn_nothing():
    directions, _ = sky_points(30, 60)
    clear = CLEAR.polarisation(directions)
    sky = replace(CLEAR, clouds=weather_clouds("scattered", 1))
    cloudy, depth = sky.polarisation(directions), sky.clouds.look(directions).optical_depth
    assert (cloudy.angle == clear.angle).all()
    assert (cloudy.degree <= clear.degree * (1 + 1e-6)).all()
    high = (directions[:, 2] > 0.7) & (clear.degree > 0.05)
    assert np.median(cloudy.degree[high & (depth > 6.0)] / clear.degree[high & (depth > 6.0)]) < 0.2
    assert np.median(cloudy.degree[high & (depth == 0.0)] / clear.degree[high & (depth == 0.0)]) > 0.7


# Form.


@pytest.mark.parametrize("weather", ["clear", "broken"])
def test_batch_is_loop(weather):
    sky = replace(CLEAR, clouds=weather_clouds(weather, 4), time=123.0)
    directions = sky_points(3, 4)[0].reshape(3, 4, 3)
    batch, polarised = sky.radiance(directions, ["green", "uv"]), sky.polarisation(directions)
    assert batch.shape == (3, 4, 2)
    assert polarised.degree.shape == polarised.angle.shape == (3, 4)
    assert {array.dtype for array in (batch, *polarised, sky.irradiance())} == {np.dtype("float32")}
    for i, j in np.ndindex(3, 4):
        assert sky.radiance(directions[i, j], ["green", "uv"]) == pytest.approx(batch[i, j], rel=1e-6)
        assert sky.polarisation(directions[i, j]).degree == pytest.approx(polarised.degree[i, j], rel=1e-6)
    every = sky.radiance(directions)
    assert batch == pytest.approx(every[..., [GREEN, UV]], rel=1e-6)
    assert (sky.radiance(directions) == every).all()


def test_clouds_drift_over_the_sky():
    # 100 s of wind at 10 m/s from the west move the clouds overhead to the place 1 km to the east.
    field = replace(weather_clouds("scattered", 9), wind=(10.0, 0.0))
    now, later = (replace(CLEAR, clouds=field, time=time) for time in (0.0, 100.0))
    steps = np.linspace(-300.0, 300.0, 50)
    height = field.base_height
    overhead = np.stack([steps, 0 * steps, np.full(50, height)], axis=-1)
    east = overhead + np.array([1000.0, 0.0, 0.0])
    overhead, east = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (overhead, east))
    before, after = now.clouds.look(overhead, now.time), later.clouds.look(east, later.time)
    assert np.ptp(before.optical_depth) > 1.0
    assert np.corrcoef(before.optical_depth, after.optical_depth)[0, 1] > 0.99  # the Earth is round
    assert (later.radiance(overhead) != now.radiance(overhead)).any()


# Place and time.


def test_sky_at_has_the_sun_of_its_place_and_time():
    time = datetime(2014, 4, 11, 10, 30, tzinfo=UTC)
    sky = sky_at(time, 37.4, -5.98, "broken", turbidity=4.0, seed=8)
    azimuth, elevation = sun_position(time, 37.4, -5.98)
    assert (sky.sun_azimuth, sky.sun_elevation) == (azimuth, elevation)
    assert (sky.turbidity, sky.clouds.seed, sky.clouds.cover) == (4.0, 8, 0.75)
    assert sky == sky_at(np.datetime64("2014-04-11T10:30"), 37.4, -5.98, "broken", turbidity=4.0, seed=8)
    later = sky_at(np.datetime64("2014-04-11T10:31"), 37.4, -5.98, "broken", seed=8)
    assert later.time - sky.time == 60.0


def test_night_is_refused_in_a_sentence():
    with pytest.raises(InputError, match=r"the sun stands at -\d+\.\d° on 2014-04-11T22:30:00 UTC .* local time"):
        sky_at(datetime(2014, 4, 11, 22, 30, tzinfo=UTC), 37.4, -5.98)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("sun_elevation", 0.01, "twilight"),
        ("sun_elevation", 45.0, "degrees"),
        ("sun_azimuth", 190.0, "degrees"),
        ("sun_azimuth", np.nan, "finite"),
        ("sun_azimuth", "south", "real numbers"),
        ("sun_elevation", [0.5, 0.6], "has shape"),
        ("turbidity", 20.0, "2 is very clear"),
        ("clouds", "broken", "weather_clouds"),
        ("time", np.inf, "time is inf"),
        ("sun_diameter", 0.0, "sun_diameter"),
    ],
)
def test_bad_sky(field, value, words):
    with pytest.raises(InputError, match=words):
        replace(CLEAR, **{field: value})


@pytest.mark.parametrize(
    ("directions", "words"),
    [([0.0, 0.0, 2.0], "unit vectors"), ([[0.0, 1.0]], "has shape"), ([np.nan, 0.0, 1.0], "unit vectors")],
)
def test_bad_directions(directions, words):
    for method in (CLEAR.radiance, CLEAR.polarisation):
        with pytest.raises(InputError, match=words):
            method(directions)


def test_bad_band():
    with pytest.raises(InputError, match=r"band 'grene' is unknown.*green"):
        CLEAR.radiance(ZENITH, ["grene"])
    with pytest.raises(InputError, match="infrared"):
        CLEAR.polarisation(ZENITH, "infrared")
