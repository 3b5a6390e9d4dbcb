"""The laws of single scattering, and its angle by spherical trigonometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.angles import wrap
from insectnav.worlds.polarisation import e_vector, e_vector_angle, maximal_degree, rayleigh_degree
from insectnav.worlds.sun import sun_direction

azimuths, elevations = st.floats(-np.pi, np.pi), st.floats(0.0, np.pi / 2)


def random_directions(n: int, seed: int) -> np.ndarray:
    vectors = np.random.default_rng(seed).normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def mirrored(directions: np.ndarray, azimuth: float) -> np.ndarray:
    """In the vertical plane of that azimuth."""
    across = np.array([np.cos(azimuth), -np.sin(azimuth), 0.0])
    return directions - 2.0 * (directions @ across)[..., None] * across


def axial_distance(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.abs(wrap(2.0 * (first - second))) / 2.0


@given(azimuths, elevations)
def test_degree_is_greatest_at_a_right_angle_and_zero_at_sun_and_opposite(azimuth, elevation):
    sun = sun_direction(azimuth, elevation)
    directions = random_directions(200, 0)
    degree = rayleigh_degree(directions, sun)
    assert ((degree >= 0.0) & (degree <= 1.0 + 1e-12)).all()
    at_right_angle = np.cross(directions, sun)
    at_right_angle /= np.linalg.norm(at_right_angle, axis=-1, keepdims=True)
    assert rayleigh_degree(at_right_angle, sun) == pytest.approx(1.0, abs=1e-12)
    assert rayleigh_degree([sun, -sun], sun) == pytest.approx(0.0, abs=1e-12)
    nearer = np.argsort(np.abs(directions @ sun))
    assert (np.diff(degree[nearer]) <= 1e-12).all()


@pytest.mark.parametrize(("angle", "degree"), [(0.0, 0.0), (45.0, 1 / 3), (60.0, 0.6), (90.0, 1.0), (120.0, 0.6)])
def test_degree_at_an_angle(angle, degree):
    assert rayleigh_degree(sun_direction(np.deg2rad(angle), 0.0), [0.0, 1.0, 0.0]) == pytest.approx(degree)


@given(azimuths, elevations)
def test_pattern_is_symmetric_about_the_solar_meridian(azimuth, elevation):
    sun, directions = sun_direction(azimuth, elevation), random_directions(50, 1)
    directions = directions[np.linalg.norm(np.cross(directions, sun), axis=-1) > 1e-3]
    other = mirrored(directions, azimuth)
    assert rayleigh_degree(other, sun) == pytest.approx(rayleigh_degree(directions, sun), abs=1e-9)
    assert axial_distance(e_vector_angle(other, sun), -e_vector_angle(directions, sun)).max() < 1e-6


@given(azimuths, elevations)
def test_e_vector_is_across_sight_and_sun(azimuth, elevation):
    sun, directions = sun_direction(azimuth, elevation), random_directions(50, 2)
    vector = e_vector(directions, sun)
    assert np.abs((vector * directions).sum(axis=-1)).max() < 1e-9
    assert np.abs(vector @ sun).max() < 1e-9
    assert np.linalg.norm(vector, axis=-1) == pytest.approx(1.0)


@given(azimuths, st.floats(0.01, 1.5), azimuths, st.floats(0.01, 1.5))
def test_angle_by_spherical_trigonometry(sun_azimuth, sun_elevation, azimuth, elevation):
    # The great circle to the sun leaves the vertical at the bearing of navigation; the e-vector is at 90° to it.
    turn = sun_azimuth - azimuth
    towards = np.arctan2(
        np.sin(turn) * np.cos(sun_elevation),
        np.cos(elevation) * np.sin(sun_elevation) - np.sin(elevation) * np.cos(sun_elevation) * np.cos(turn),
    )
    sun, direction = sun_direction(sun_azimuth, sun_elevation), sun_direction(azimuth, elevation)
    if np.linalg.norm(np.cross(sun, direction)) > 1e-4:
        assert axial_distance(e_vector_angle(direction, sun), towards + np.pi / 2) < 1e-6


@given(azimuths, elevations, azimuths)
def test_turning_sun_and_sight_changes_nothing(azimuth, elevation, turn):
    directions = random_directions(30, 3)
    level = np.hypot(directions[:, 0], directions[:, 1])
    bearing = np.arctan2(directions[:, 0], directions[:, 1])
    turned = np.stack([level * np.sin(bearing + turn), level * np.cos(bearing + turn), directions[:, 2]], axis=-1)
    before, after = sun_direction(azimuth, elevation), sun_direction(azimuth + turn, elevation)
    assert rayleigh_degree(turned, after) == pytest.approx(rayleigh_degree(directions, before), abs=1e-9)
    assert axial_distance(e_vector_angle(turned, after), e_vector_angle(directions, before)).max() < 1e-5


def test_known_angles():
    zenith, north, east = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]
    assert e_vector_angle(zenith, north) == -np.pi / 2  # east to west, across the plane of the sun in the north
    assert e_vector_angle(zenith, east) == pytest.approx(0.0)
    assert e_vector_angle(north, zenith) == -np.pi / 2  # horizontal, all round, under a sun at the zenith
    assert e_vector_angle(north, east) == pytest.approx(0.0)  # vertical at 90° from a sun at the horizon
    assert e_vector_angle(north, sun_direction(np.pi / 2, np.pi / 4)) == pytest.approx(-np.pi / 4)  # down to the right
    assert e_vector_angle(north, north) == 0.0


def test_greatest_degree_falls_with_haze_as_measured():
    # Kreuter, Emde and Blumthaler 2010: 0.7 to 0.4 for optical depths 0.05 to 0.5, which are T = 2 (less) and 5.4.
    assert maximal_degree([2.0, 5.4]) == pytest.approx([0.7, 0.4], abs=0.12)
    assert (np.diff(maximal_degree(np.linspace(2.0, 8.0, 20))) < 0.0).all()
