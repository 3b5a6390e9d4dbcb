"""The exact skyline against closed forms, finer and finer pictures, and symmetries."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.worlds import render_layers, skyline
from solid_shapes import box, quad, soup, turned, wall, world_of

seeds = st.integers(0, 2**32 - 1)


def columns(n: int) -> np.ndarray:
    return -np.pi + (np.arange(n) + 0.5) * 2 * np.pi / n


def crossings(triangles: np.ndarray, eye: np.ndarray, azimuth: float) -> float:
    """Highest elevation where an edge crosses the vertical half-plane along an azimuth, edge by edge in 3D."""
    corners = np.float32(triangles).astype(float) - eye
    ahead = corners[..., :2] @ [np.sin(azimuth), np.cos(azimuth)]
    aside = corners[..., :2] @ [np.cos(azimuth), -np.sin(azimuth)]
    highest = 0.0
    for i, j in ((0, 1), (1, 2), (2, 0)):
        crosses = (aside[:, i] < 0) != (aside[:, j] < 0)
        part = aside[crosses, i] / (aside[crosses, i] - aside[crosses, j])
        s = ahead[crosses, i] + part * (ahead[crosses, j] - ahead[crosses, i])
        z = corners[crosses, i, 2] + part * (corners[crosses, j, 2] - corners[crosses, i, 2])
        highest = max([highest, *np.arctan2(z, s)[s > 0]])
    return highest


def test_top_of_a_long_wall():
    azimuths = np.linspace(-1.2, 1.2, 77)
    got = skyline(world_of(wall(-40, 2, 40, 2, 3)), [[0, 0, 1.0]], azimuths)
    assert_allclose(got[0], np.arctan(2 / (2 / np.cos(azimuths))), atol=1e-6)
    assert_array_equal(skyline(world_of(wall(-40, 2, 40, 2, 3)), [[0, 0, 1.0]], [np.pi, -2.0, 3.0]), [[0, 0, 0]])


def test_a_roof_overhead_reaches_the_zenith_everywhere():
    roof = quad((-1, -1, 2), (1, -1, 2), (1, 1, 2), (-1, 1, 2))
    assert_allclose(skyline(world_of(roof), [[0.2, -0.3, 1.0]], 90), np.pi / 2)


@settings(max_examples=25, deadline=None)
@given(seeds, st.floats(-np.pi, np.pi))
def test_it_is_the_highest_crossing_of_an_edge(seed, azimuth):
    rng = np.random.default_rng(seed)
    triangles = soup(seed, 40)
    triangles = triangles[np.hypot(*triangles.mean(axis=1).T[:2]) > 4.5]  # none overhead, where a crossing is no top
    eye = np.array([*rng.uniform(-0.1, 0.1, 2), 0.2])
    assert_allclose(
        skyline(world_of(triangles), eye[None], [azimuth])[0, 0], crossings(triangles, eye, azimuth), atol=1e-5
    )


def test_finer_and_finer_pictures_approach_it():
    """Trees without holes or floating parts: it lies within half a pixel of the border of the sky."""
    rng = np.random.default_rng(2)
    trees = [box(*rng.uniform(3, 8, 2), 0.8, rng.uniform(1, 4)) for _ in range(9)]
    world, eye = world_of(*trees), [[0.0, 0.0, 0.01]]
    for resolution_deg in (0.5, 0.25, 0.125):
        options = {"resolution_deg": resolution_deg, "elevation_deg": (0.0, 60.0)}
        alpha = render_layers(world, eye, 0.0, ("alpha",), **options)["alpha"][0]
        found = np.deg2rad(resolution_deg) * alpha.sum(axis=0)
        assert np.abs(found - skyline(world, eye, found.size)[0]).max() <= np.deg2rad(resolution_deg) / 2 + 1e-6


def test_even_azimuths_are_the_columns_of_a_panorama():
    world = world_of(soup(3))
    assert_allclose(skyline(world, [[0, 0]], 48), skyline(world, [[0, 0]], columns(48)), rtol=1e-12)


def test_order_number_and_repetition_of_azimuths_are_free():
    world, azimuths = world_of(soup(4)), np.array([3.0, -3.0, 0.5, 0.5, 6.0, -6.0])
    got = skyline(world, [[0, 0]], azimuths)[0]
    assert_array_equal(got[2], got[3])
    for i, azimuth in enumerate(azimuths):
        assert got[i] == skyline(world, [[0, 0]], [azimuth])[0, 0]
    assert skyline(world, [[0, 0]], []).shape == (1, 0)
    assert_allclose(got[4], skyline(world, [[0, 0]], [6.0 - 2 * np.pi])[0, 0])


@settings(max_examples=15, deadline=None)
@given(seeds, st.floats(-3, 3))
def test_turning_the_world_turns_the_skyline(seed, angle):
    triangles = soup(seed, 30)
    here = skyline(world_of(triangles), [[0, 0]], columns(90) % 3)
    there = skyline(world_of(turned(triangles, angle)), [[0, 0]], columns(90) % 3 + angle)
    assert np.mean(np.abs(here - there) > 1e-4) < 0.05  # but beside vertical edges, where rounding decides


def test_batch_equals_loop_with_any_number_of_threads():
    world, positions = world_of(soup(5)), np.random.default_rng(0).uniform(-8, 8, (70, 2))
    expected = skyline(world, positions, 60, workers=1)
    assert_array_equal(skyline(world, positions, 60, workers=3), expected)
    assert_array_equal(np.concatenate([skyline(world, [place], 60) for place in positions]), expected)


@pytest.mark.parametrize(
    ("azimuths", "words"),
    [
        (0, "azimuths is 0, expected a whole number of at least 1"),
        ([180.0], "azimuths reaches 180, expected radians within ±2π: degrees?"),
        ([np.nan], "azimuths is nan at index 0"),
        ([[0.0]], "azimuths has shape (1, 1), expected (azimuth,)"),
    ],
)
def test_bad_azimuths_are_refused(azimuths, words):
    with pytest.raises(InputError) as caught:
        skyline(world_of(soup(1, 9)), [[0, 0]], azimuths)
    assert words in str(caught.value)
