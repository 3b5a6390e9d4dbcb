"""Clouds against a plain second implementation, published hash values, geometry, and what chance allows."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.worlds.clouds import (
    GAIN,
    OCTAVES,
    RANKED,
    WEATHERS,
    CloudField,
    depth_of_transmittance,
    fractal_noise,
    gradient_noise,
    layer_places,
    mix_bits,
    opacity,
    transmittance,
    weather_clouds,
)
from insectnav.worlds.sun import sun_direction

RADIUS = 6.371e6
WORD = 0xFFFFFFFF


def far_places(n: int, seed: int = 0) -> np.ndarray:
    """So far apart that their clouds are independent."""
    return np.random.default_rng(seed).uniform(-1e8, 1e8, (n, 2))


# A plain second implementation, in Python's own numbers.


def plain_mix(word: int) -> int:
    word = ((word ^ word >> 16) * 0x85EBCA6B) & WORD
    word = ((word ^ word >> 13) * 0xC2B2AE35) & WORD
    return word ^ word >> 16


def plain_noise(x: float, y: float, seed: int) -> float:
    half = math.sqrt(0.5)
    gradients = [(1, 0), (0, 1), (-1, 0), (0, -1), (half, half), (half, -half), (-half, half), (-half, -half)]
    column, row = math.floor(x), math.floor(y)
    fade_x, fade_y = (t * t * t * (t * (t * 6.0 - 15.0) + 10.0) for t in (x - column, y - row))
    pulls = {}
    for dx in (0, 1):
        for dy in (0, 1):
            word = plain_mix((row + dy) % 2**32 ^ plain_mix(seed >> 32))
            word = plain_mix(((column + dx) + word + plain_mix(seed & WORD)) % 2**32)
            east, north = gradients[word % 8]
            pulls[dx, dy] = east * (x - column - dx) + north * (y - row - dy)
    low, high = (pulls[0, dy] + fade_x * (pulls[1, dy] - pulls[0, dy]) for dy in (0, 1))
    return low + fade_y * (high - low)


def plain_fractal(x: float, y: float, seed: int) -> float:
    total, amplitude = 0.0, 1.0
    for octave in range(7):
        total += amplitude * plain_noise(x, y, 7 * seed + octave)
        x, y, amplitude = 2.0 * (0.6 * x - 0.8 * y), 2.0 * (0.8 * x + 0.6 * y), amplitude * 0.637
    return total


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.integers(0, 2**60))
def test_noise_is_that_of_the_plain_implementation_to_the_last_bit(x, y, seed):
    assert fractal_noise([x, y], seed) == plain_fractal(x, y, seed)


def test_published_hash_values():
    # MurmurHash3_x86_32 of nothing is its final mix of the seed: the verification values of its reference code.
    words = mix_bits(np.array([0, 1, 0xFFFFFFFF], np.uint32))
    assert words.tolist() == [0, 0x514E28B7, 0x81F16F39]


# Noise.


def test_noise_is_zero_at_lattice_points_and_smooth():
    whole = np.arange(-50.0, 50.0)
    assert (gradient_noise(whole, whole[::-1], 3) == 0.0).all()
    x = np.linspace(-3.0, 3.0, 60_001)  # in steps of 1e-4, across lattice lines; a slope is at most about 3
    assert np.abs(np.diff(gradient_noise(x, 0.3 + 0.5 * x, 3))).max() < 4e-4


def test_noise_has_mean_zero_and_the_same_spread_for_all_seeds():
    n = 4000
    places = far_places(n) / 2000.0
    spread = []
    for seed in (0, 1, 2**40):
        noise = fractal_noise(places, seed)
        assert abs(noise.mean()) < 5.0 * noise.std() / math.sqrt(n)
        spread.append(noise.std())
    # The relative error of a standard deviation is 1 / sqrt(2 n) for normal numbers; noise has shorter tails.
    assert spread == pytest.approx(np.full(3, np.mean(spread)), rel=5.0 / math.sqrt(2 * n))


def test_outline_has_the_dimension_of_clouds():
    # Lovejoy 1982: D = 1.35 = 2 − H, where squared differences grow as the distance to the power 2 H.
    assert abs(GAIN - 2.0 ** -(2.0 - 1.35)) < 1e-3
    places, distances = far_places(20_000) / 2000.0, np.array([1 / 32, 1 / 16, 1 / 8, 1 / 4])
    squares = [
        np.mean((fractal_noise(places + np.array([r, 0.0]), 1) - fractal_noise(places, 1)) ** 2) for r in distances
    ]
    slope = np.polyfit(np.log(distances), np.log(squares), 1)[0]
    assert 2.0 - slope / 2.0 == pytest.approx(1.35, abs=0.1)
    assert OCTAVES == 7


# Cover and thickness.


@pytest.mark.parametrize("cover", [0.0, 0.1, 3.5 / 8, 0.75, 1.0])
@pytest.mark.parametrize("seed", [0, 7])
def test_cover_and_mean_depth_are_as_asked(cover, seed):
    n = 20_000
    depth = CloudField(seed=seed, cover=cover, optical_depth=10.0).optical_depth_over(far_places(n, seed))
    chance = 5.0 * math.sqrt(cover * (1.0 - cover) * (1.0 / n + 1.0 / RANKED))  # of the places and of the ranking
    assert np.mean(depth > 0.0) == pytest.approx(cover, abs=chance + 2.0 / RANKED)
    if cover:
        cloud = depth[depth > 0.0]  # even from 0 to 20: SD 20 / sqrt(12)
        assert cloud.max() <= 20.0
        assert cloud.mean() == pytest.approx(10.0, abs=5.0 * 20.0 / math.sqrt(12) * math.sqrt(2.0 / len(cloud)))


@pytest.mark.parametrize("elevation", [0.05, 0.6, 1.5])
def test_every_direction_meets_cloud_as_often_as_cover_says(elevation):
    n, cover = 400, 0.4
    direction = sun_direction(1.0, elevation)
    hits = [CloudField(seed=seed, cover=cover).look(direction).optical_depth > 0.0 for seed in range(n)]
    assert np.mean(hits) == pytest.approx(cover, abs=5.0 * math.sqrt(cover * (1.0 - cover) / n))


def test_sheet_has_one_depth():
    sheet = CloudField(cover=1.0, optical_depth=12.0, variation=0.0)
    assert (sheet.optical_depth_over(far_places(100)) == 12.0).all()


# Geometry and drift.


@given(st.floats(-np.pi, np.pi), st.floats(0.0, np.pi / 2), st.floats(50.0, 2e4))
def test_line_of_sight_meets_the_layer(azimuth, elevation, height):
    direction = sun_direction(azimuth, elevation)
    place, slant = layer_places(direction, height)
    level = float(np.hypot(*place))
    cosine = math.cos(elevation)
    if level > 1.0:
        assert place / level == pytest.approx(direction[:2] / cosine, abs=1e-6)
        point = np.array([0.0, 0.0, RADIUS]) + level / cosine * direction
        assert np.linalg.norm(point) == pytest.approx(RADIUS + height, abs=1e-3 + 1e-8 * level / max(cosine, 1e-6))
        up = point / np.linalg.norm(point)
        assert slant == pytest.approx(1.0 / (up @ direction), rel=1e-6)


def test_zenith_and_horizon():
    place, slant = layer_places(np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.8, -0.6]]), 1500.0)
    edge = math.sqrt(2 * RADIUS * 1500.0 + 1500.0**2)
    assert place[0].tolist() == [0.0, 0.0]
    assert place[1:] == pytest.approx(np.array([[0.0, edge], [0.0, edge]]))
    assert slant == pytest.approx([1.0, (RADIUS + 1500.0) / edge, (RADIUS + 1500.0) / edge])


def test_clouds_shrink_towards_the_horizon():
    elevation = np.deg2rad([2.0, 3.0, 30.0, 31.0, 88.0, 89.0])
    distance = np.hypot(*layer_places(sun_direction(0.0, elevation), 1500.0)[0].T)
    along = np.abs(np.diff(distance))[::2] / np.deg2rad(1.0)
    # On a flat layer a radian of elevation spans height / sin² of it.
    assert along[1:] == pytest.approx(1500.0 / np.sin(np.deg2rad([30.5, 88.5])) ** 2, rel=0.01)
    assert along[0] > 100.0 * along[1]


@given(st.integers(-10_000, 10_000), st.integers(0, 100))
def test_clouds_drift_with_the_wind(time, seed):
    field = CloudField(seed=seed, wind=(8.0, -3.0))
    places = np.random.default_rng(seed).integers(-10_000, 10_000, (40, 2)).astype(float)
    later = field.optical_depth_over(places + np.array([8.0, -3.0]) * time, time)
    assert (later == field.optical_depth_over(places, 0.0)).all()


def test_batch_is_loop_and_seeds_differ():
    places = far_places(12).reshape(3, 4, 2)
    field = CloudField(seed=5, cover=0.8)
    depth = field.optical_depth_over(places)
    assert depth.shape == (3, 4)
    assert all(field.optical_depth_over(places[i, j]) == depth[i, j] for i, j in np.ndindex(3, 4))
    assert (CloudField(seed=6, cover=0.8).optical_depth_over(places) != depth).any()


# Light through clouds, and weather.


def test_transmittance():
    assert transmittance([0.0, 40.0]) == pytest.approx([1.0, 0.25])
    assert transmittance(1e6) * 1e6 == pytest.approx(2.0 / 0.15, rel=1e-4)
    assert transmittance(depth_of_transmittance(0.4)) == pytest.approx(0.4)


def test_opacity_is_that_of_the_slanted_way():
    path = CloudField(cover=1.0, optical_depth=0.5, variation=0.0).look(sun_direction(0.0, np.deg2rad(30.0)))
    assert opacity(path) == pytest.approx(1.0 - math.exp(-1.0), abs=2e-3)  # twice as long, nearly, on a round Earth


def test_weathers():
    fields = [weather_clouds(weather, seed=3, wind=(1.0, 2.0)) for weather in WEATHERS]
    assert fields[0] is None
    assert [field.cover for field in fields[1:]] == [0.4375, 0.75, 1.0]  # 3.5, 6 and 8 oktas
    assert {(field.seed, field.wind) for field in fields[1:]} == {(3, (1.0, 2.0))}
    assert transmittance(fields[3].optical_depth) == pytest.approx(0.25)  # Kasten and Czeplak 1980


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("cover", 75, "not a percentage"),
        ("seed", -1, "whole number"),
        ("optical_depth", -2.0, "optical_depth"),
        ("base_height", 1.5, "kilometres"),
        ("size", 2, "kilometres"),
        ("wind", (1.0, 2.0, 3.0), "wind has shape"),
        ("wind", (np.nan, 0.0), "wind is nan"),
        ("variation", 2.0, "variation"),
    ],
)
def test_bad_field(field, value, words):
    with pytest.raises(InputError, match=words):
        CloudField(**{field: value})


def test_bad_weather_and_time():
    with pytest.raises(InputError, match="did you mean overcast"):
        weather_clouds("overcst")
    with pytest.raises(InputError, match="time"):
        CloudField().optical_depth_over([0.0, 0.0], time=np.inf)
