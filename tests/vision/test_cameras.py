"""Cameras: pixels of directions and directions of pixels."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from insectnav.checks import InputError
from insectnav.vision.camera_models import PROJECTIONS
from insectnav.vision.cameras import AHEAD, LENSES, MODELS, UPWARDS, Camera, fisheye, panorama, parabolic_mirror
from insectnav.vision.sphere import (
    directions,
    equirectangular,
    fibonacci,
    great_circle_angle,
    rotation_matrix,
    to_world,
)

DEGREE = np.pi / 180
ZENITH, AHEAD_VECTOR, RIGHT_VECTOR = np.array([0.0, 0, 1]), np.array([0.0, 1, 0]), np.array([1.0, 0, 0])
COEFFICIENTS = (0.01, -0.003, 0.0004, 0.00002)
angles = st.floats(-3.0, 3.0)


def camera_of(model: str, mounting: tuple[float, float, float] = (0.7, 0.4, -0.2)) -> Camera:
    """Camera that sees nearly all its model can, with oblong pixels and its axis off the middle."""
    limit = np.pi if model == "equirectangular" else 0.97 * PROJECTIONS[model].max_angle
    return Camera(
        model=model,
        size=(400, 640),
        focal_length=(9.0, 8.0) if model in ("pinhole", "stereographic", "parabolic-mirror") else (70.0, 65.0),
        centre=(310.3, 205.9),
        field=(0.0, limit),
        coefficients=COEFFICIENTS if model == "kannala-brandt" else (),
        mounting=mounting,
    )


@pytest.mark.parametrize("model", MODELS)
@given(angles, st.floats(-1.5, 1.5), angles)
def test_directions_come_back(model: str, heading: float, pitch: float, roll: float):
    camera = camera_of(model, (heading, pitch, roll))
    vectors = fibonacci(500).directions
    pixels, seen = camera.project(vectors)
    assert seen.sum() > 200
    assert np.isnan(pixels[~seen]).all()
    np.testing.assert_array_less(great_circle_angle(camera.look(pixels[seen]), vectors[seen]), 1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_pixels_come_back(model: str):
    camera = camera_of(model)
    pixels = np.random.default_rng(1).uniform(0, 1, (2000, 2)) * [640, 400]
    vectors = camera.look(pixels)
    shown = np.isfinite(vectors).all(axis=-1)
    assert shown.sum() > 10
    np.testing.assert_allclose(np.linalg.norm(vectors[shown], axis=-1), 1.0, rtol=1e-12)
    back, seen = camera.project(vectors[shown])
    assert seen.all()
    np.testing.assert_allclose(back, pixels[shown], atol=1e-9)


# Radius of the picture at θ from its definition, in focal lengths, and the angle at which it is 1.
CLOSED_FORMS = [
    ("equidistant", lambda t: t, 1.0),
    ("equisolid", lambda t: 2 * np.sin(t / 2), np.pi / 3),
    ("stereographic", lambda t: 2 * np.tan(t / 2), 2 * np.arctan(0.5)),
    ("orthographic", np.sin, np.pi / 2),
    ("pinhole", np.tan, np.pi / 4),
    ("parabolic-mirror", lambda t: np.tan(t / 2), np.pi / 2),
]


@pytest.mark.parametrize(("model", "radius", "one"), CLOSED_FORMS)
def test_radius_is_the_formula(model: str, radius, one: float):
    camera = Camera(model=model, size=(200, 200), focal_length=(20.0, 20.0), centre=(100.0, 100.0), field=(0, 1.5))
    theta = np.linspace(0.0, 1.3, 14)
    pixels, seen = camera.project(directions(0.0, theta))  # straight up the picture
    np.testing.assert_allclose(pixels[seen, 0], 100.0, atol=1e-12)
    np.testing.assert_allclose(100.0 - pixels[seen, 1], 20.0 * radius(theta[seen]), atol=1e-12)
    assert seen.sum() >= 13
    if one <= 1.5:
        np.testing.assert_allclose(camera.look([100.0, 80.0]), directions(0.0, one), atol=1e-12)


def test_equisolid_pixels_have_equal_solid_angles():
    camera = fisheye((200, 200), np.pi, model="equisolid", mounting=AHEAD)
    share = camera.pixels_seen().mean() * 200 * 200 / camera.focal_length[0] ** 2
    assert share == pytest.approx(2 * np.pi, rel=0.002)  # the hemisphere, if a pixel is 1/f² sr


@given(st.floats(0.0, 1.7))
def test_kannala_brandt_inverts_as_a_root_finder_does(theta: float):
    camera = camera_of("kannala-brandt", AHEAD)
    k1, k2, k3, k4 = COEFFICIENTS

    def polynomial(t: float) -> float:
        return t + k1 * t**3 + k2 * t**5 + k3 * t**7 + k4 * t**9

    focal, (column, row) = camera.focal_length[1], camera.centre
    pixel = [column, row - focal * polynomial(theta)]
    looked = camera.look(pixel)
    np.testing.assert_allclose(looked, [0.0, np.cos(theta), np.sin(theta)], atol=1e-12)
    root = brentq(lambda t: polynomial(t) - (row - pixel[1]) / focal, 0.0, 3.0, xtol=1e-14)
    assert abs(np.arctan2(looked[2], looked[1]) - root) < 1e-11


def test_kannala_brandt_without_coefficients_is_equidistant():
    plain = replace(camera_of("kannala-brandt"), coefficients=())
    vectors = fibonacci(300).directions
    np.testing.assert_allclose(
        plain.project(vectors)[0], replace(plain, model="equidistant").project(vectors)[0], atol=1e-12
    )


@pytest.mark.parametrize("model", ["equidistant", "equisolid", "stereographic", "orthographic"])
def test_upward_fisheye(model: str):
    camera = fisheye((320, 480), np.pi, model=model)
    pixels, seen = camera.project([ZENITH, AHEAD_VECTOR, RIGHT_VECTOR, -AHEAD_VECTOR, -RIGHT_VECTOR, -ZENITH])
    assert seen.tolist() == [True] * 5 + [False]
    # Ahead is at the top; as in a map of the stars the right is on the left. The horizon is the rim, 160 px away.
    np.testing.assert_allclose(pixels[:5], [[240, 160], [240, 0], [80, 160], [240, 320], [400, 160]], atol=1e-5)


def test_mirror_shows_the_horizon_and_does_not_exchange_the_sides():
    camera = parabolic_mirror((400, 400), 150.0, field=(10 * DEGREE, 100 * DEGREE))
    pixels, seen = camera.project([AHEAD_VECTOR, RIGHT_VECTOR, directions(0.0, 30 * DEGREE), ZENITH])
    assert seen.tolist() == [True, True, True, False]  # its own camera is left out
    # tan(60°/2) = 1/√3 of the radius of the horizon.
    np.testing.assert_allclose(pixels[:3], [[200, 50], [350, 200], [200, 200 - 150 / np.sqrt(3)]], atol=1e-9)


def test_rays_meet_the_paraboloid_where_the_mirror_shows_them():
    camera = parabolic_mirror((400, 400), 150.0, field=(0.2, 1.9))
    vectors = fibonacci(400).directions
    pixels, seen = camera.project(vectors)
    point = np.stack([pixels[seen, 0] - 200, 200 - pixels[seen, 1]], axis=-1)
    height = (150.0**2 - (point**2).sum(axis=-1)) / (2 * 150.0)  # the paraboloid, its focus at the origin
    surface = np.column_stack([point, height])
    np.testing.assert_allclose(surface / np.linalg.norm(surface, axis=-1, keepdims=True), vectors[seen], atol=1e-12)


def test_panorama_pixels_are_those_of_the_grid():
    camera, grid = panorama(3.0, (-15.0, 90.0)), equirectangular(3.0, (-15.0, 90.0))
    assert camera.size == grid.shape
    assert camera.wraps
    np.testing.assert_allclose(camera.pixel_directions().reshape(-1, 3), grid.directions, atol=1e-12)
    assert camera.pixels_seen().all()
    pixels, seen = camera.project([[0.0, -1.0, 0.0], [1e-12, -1.0, 0.0], [-1e-12, -1.0, 0.0], -ZENITH])
    assert seen.tolist() == [True, True, True, False]
    assert ((pixels[:3, 0] % 120 < 1e-6) | (pixels[:3, 0] % 120 > 120 - 1e-6)).all()  # the seam


def test_panorama_may_begin_in_any_direction():
    usual = panorama(3.0, (-90.0, 90.0))
    turned = replace(usual, centre=(0.0, 30.0))  # straight ahead at the left edge
    vectors = fibonacci(300).directions
    pixels, seen = turned.project(vectors)
    assert seen.all()
    offset = np.mod(pixels[:, 0] - usual.project(vectors)[0][:, 0], 120.0)
    np.testing.assert_allclose(offset, 60.0, atol=1e-9)
    np.testing.assert_array_less(great_circle_angle(turned.look(pixels), vectors), 1e-9)
    assert turned.pixels_seen().all()


@given(angles, st.floats(-1.5, 1.5), angles)
def test_turning_the_camera_turns_what_it_sees(heading: float, pitch: float, roll: float):
    rotation = rotation_matrix(heading, pitch, roll)
    level, turned = camera_of("equisolid", AHEAD), camera_of("equisolid", (heading, pitch, roll))
    pixels = np.random.default_rng(2).uniform(0, 1, (50, 2)) * [640, 400]
    np.testing.assert_allclose(turned.look(pixels), to_world(level.look(pixels), rotation), atol=1e-12)


@pytest.mark.parametrize("model", LENSES)
def test_mirrored_directions_are_mirrored_in_the_picture(model: str):
    camera = fisheye((300, 300), 2.0, model=model)
    vectors = fibonacci(200).directions
    pixels, seen = camera.project(vectors)
    assert 30 < seen.sum() < 150
    np.testing.assert_allclose(camera.project(vectors * [-1, 1, 1])[0], [300, 0] + pixels * [-1, 1], atol=1e-9)
    np.testing.assert_allclose(camera.project(vectors * [1, -1, 1])[0], [0, 300] + pixels * [1, -1], atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_batch_is_the_loop(model: str):
    camera = camera_of(model)
    vectors = fibonacci(24).directions.reshape(2, 3, 4, 3)
    pixels, seen = camera.project(vectors)
    assert pixels.shape == (2, 3, 4, 2)
    assert seen.shape == (2, 3, 4)
    looked = camera.look(pixels)
    for index in np.ndindex(2, 3, 4):
        one, is_seen = camera.project(vectors[index])
        np.testing.assert_array_equal(one, pixels[index])
        assert bool(is_seen) == seen[index]
        np.testing.assert_allclose(camera.look(one), looked[index], atol=1e-15)


def test_field_picture_and_sectors_limit_what_is_seen():
    camera = fisheye((100, 100), 120 * DEGREE)
    assert camera.project(directions(1.0, 31 * DEGREE))[1]
    assert not camera.project(directions(1.0, 29 * DEGREE))[1]
    small = replace(camera, size=(50, 100))  # the lower half of the picture is missing: what lies behind
    assert small.project(directions(0.0, 50 * DEGREE))[1]
    assert not small.project(directions(np.pi, 50 * DEGREE))[1]
    assert np.isnan(small.look([50.0, 60.0])).all()
    held = replace(camera, masked_sectors=((80 * DEGREE, 100 * DEGREE), (-10 * DEGREE, 5 * DEGREE)))
    # Clockwise in the picture from its top, which is ahead: 90° is on its right, the animal's left.
    azimuth = -np.array([0.0, 6, 79, 81, 99, 101, -9, -11]) * DEGREE
    assert held.project(directions(azimuth, 1.0))[1].tolist() == [False, True, True, False, False, True, False, True]
    assert np.isfinite(held.look([90.0, 50.0])).all()
    share = held.pixels_seen().sum() / camera.pixels_seen().sum()
    assert share == pytest.approx(1 - 35 / 360, abs=0.005)


def test_pixels_out_of_the_field_look_nowhere():
    camera = fisheye((100, 100), np.pi)
    assert np.isnan(camera.look([[1.0, 1.0], [-1.0, 50.0], [50.0, 101.0]])).all()
    assert camera.pixels_seen().mean() == pytest.approx(np.pi / 4, abs=0.01)


def test_check_sees_names_direction_and_angle():
    camera = fisheye((100, 100), 185 * DEGREE)
    camera.check_sees(fibonacci(50, (0.0, 90.0)).directions)
    with pytest.raises(InputError) as caught:
        camera.check_sees([ZENITH, directions(40 * DEGREE, -30 * DEGREE), -ZENITH], "landmark")
    assert str(caught.value) == (
        "landmark at azimuth 40°, elevation -30° is 120° from the axis of the equidistant camera, expected 0 to 92.5° "
        "and an unmasked pixel: another mounting?"
    )


GOOD = {"model": "equidistant", "size": (10, 10), "focal_length": (4.0, 4.0), "centre": (5.0, 5.0)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"model": "fisheye"}, "model 'fisheye' is unknown"),
        ({"model": "equisolids"}, "did you mean equisolid"),
        ({"size": (10, 0)}, "size is 0"),
        ({"size": (10,)}, r"size has shape \(1,\)"),
        ({"focal_length": (0.0, 4.0)}, "focal_length reaches 0"),
        ({"centre": (np.nan, 4.0)}, "centre is nan"),
        ({"field": (0.0, 92.5)}, "field reaches 92.5.*degrees"),
        ({"field": (1.0, 1.0)}, "field goes from 1 to 1 rad"),
        ({"model": "pinhole", "field": (0.0, np.pi / 2)}, "field reaches 1.5708.*too wide for pinhole"),
        ({"model": "orthographic", "field": (0.0, 1.6)}, "too wide for orthographic"),
        ({"mounting": (0.0, 90.0, 0.0)}, "mounting reaches 90, expected radians"),
        ({"coefficients": (0.1,)}, "coefficients has 1 values, expected at most 0 for equidistant"),
        ({"model": "kannala-brandt", "coefficients": (0.1,) * 5}, "at most 4"),
        ({"model": "kannala-brandt", "coefficients": (-0.3,)}, "fall beyond 60.4° from the axis"),
        ({"masked_sectors": ((0.0, 90.0),)}, "masked_sectors reaches 90"),
        ({"masked_sectors": (0.0, 1.0)}, "masked_sectors has shape"),
    ],
)
def test_impossible_cameras_are_refused_in_one_sentence(change: dict, message: str):
    Camera(**GOOD)
    with pytest.raises(InputError, match=message) as caught:
        Camera(**(GOOD | change))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fisheye((10, 10), 185.0), "field_of_view is 185.*degrees"),
        (lambda: fisheye((10, 10), 3.3, model="orthographic"), "too wide for orthographic"),
        (lambda: fisheye((10, 10), 3.0, model="kannala-brandt"), "model 'kannala-brandt' is unknown"),
        (lambda: panorama(1.1), "resolution_deg is 1.1"),
        (lambda: Camera(**GOOD).project([0.0, 0.0, 2.0]), "directions has a vector of length 2"),
        (lambda: Camera(**GOOD).look([1.0, 2.0, 3.0]), r"pixels has shape \(3,\)"),
    ],
)
def test_bad_calls_are_refused_in_one_sentence(call, message: str):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_camera_that_looks_up_has_its_top_ahead():
    rotation = rotation_matrix(*UPWARDS)
    np.testing.assert_allclose(rotation.T, [-RIGHT_VECTOR, ZENITH, AHEAD_VECTOR], atol=1e-15)
