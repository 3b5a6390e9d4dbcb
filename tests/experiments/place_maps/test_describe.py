"""Features of frames: those of the descriptors on what a camera saw, by any way of taking it."""

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.experiments.place_maps.describe import DescribeParams, describe, looks_like_mask
from insectnav.experiments.place_maps.thumbnails import thumbnail
from insectnav.experiments.place_maps.view_cameras import AHEAD, grid, view_camera
from insectnav.vision.descriptors import DESCRIPTORS
from insectnav.vision.descriptors.lanczos import resize
from insectnav.vision.sphere import azimuth_elevation
from place_scenes import panoramas, sky_disk, skylines

FISHEYE = view_camera("fisheye:180")


def settled(picture: np.ndarray, **given: object) -> DescribeParams:
    return DescribeParams(**given).settled(picture)


def test_grey_of_pictures_is_the_descriptor_of_the_reduced_picture():
    picture = np.random.default_rng(0).integers(0, 256, (90, 160, 3), dtype=np.uint8)
    params = settled(picture)
    assert params.settings() == {"sky": "none", "size": "32x64"}
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    assert_array_equal(describe(picture, params), DESCRIPTORS["patch-normalised"](resize(grey, (32, 64))))


def test_round_pictures_are_cut_to_their_middle_square():
    picture = np.random.default_rng(1).integers(0, 256, (120, 160), dtype=np.uint8)
    params = settled(picture, camera=FISHEYE, descriptor="retinotopic")
    assert_array_equal(describe(picture, params), describe(picture[:, 20:140], params))


@pytest.mark.parametrize("descriptor", ["spherical-harmonics", "zernike", "sky-contour"])
def test_skies_of_an_upward_fisheye_are_those_of_the_panorama(descriptor: str):
    skyline = skylines(1)[0]
    params = settled(np.zeros((320, 320), np.uint8), descriptor=descriptor, camera=FISHEYE, sky="mask")
    azimuth, elevation = (np.rad2deg(angle) for angle in azimuth_elevation(grid().directions))
    index = np.floor(np.mod(azimuth, 360.0) * 2).astype(int) % 720
    panorama = (elevation > skyline[index]).reshape(grid().shape)
    expected = DESCRIPTORS[descriptor](panorama)
    found = describe(sky_disk(skyline, 320), params)
    assert np.linalg.norm(found - expected) < 0.03 * np.linalg.norm(expected)


@pytest.mark.parametrize("descriptor", ["spherical-harmonics", "zernike"])
def test_a_turned_camera_has_the_same_features(descriptor: str):
    sky = sky_disk(skylines(1)[0], 200)
    params = settled(sky, descriptor=descriptor, camera=FISHEYE, sky="mask")
    first, turned = describe(sky, params), describe(np.rot90(sky).copy(), params)
    assert_allclose(turned, first, atol=1e-3 * np.abs(first).max())
    other = describe(sky_disk(skylines(8)[7], 200), params)
    assert np.linalg.norm(other - first) > 20 * np.linalg.norm(turned - first)


def test_what_the_camera_does_not_see_is_ground():
    everything = np.full((120, 480), 255, np.uint8)  # from −30° to 60°, all of it sky
    params = settled(everything, descriptor="zernike", camera=view_camera("panorama:-30,60"), sky="mask")
    rows = np.rad2deg(azimuth_elevation(grid().directions)[1]).reshape(grid().shape)
    inner = np.abs(rows - 60.0) > 2.0  # at the very edge of the picture a share is seen
    expected = DESCRIPTORS["zernike"](rows < 60.0)
    assert inner.any()
    assert np.linalg.norm(describe(everything, params) - expected) < 0.02 * np.linalg.norm(expected)


def test_methods_of_the_sky_follow_from_the_picture():
    colour, grey = np.zeros((60, 60, 3), np.uint8), np.zeros((60, 60), np.uint8)
    params = DescribeParams(descriptor="zernike", camera=FISHEYE)
    assert params.settled(colour).sky == "skylight"
    assert params.settled(grey).sky == "watershed"
    assert DescribeParams(descriptor="zernike", camera=FISHEYE, sky="none").settled(colour).sky == "none"
    assert DescribeParams(sky="otsu:blue").settled(colour).settings()["sky"] == "otsu:blue"


def test_a_photograph_is_no_mask():
    params = settled(np.zeros((60, 60), np.uint8), descriptor="zernike", camera=FISHEYE, sky="mask")
    with pytest.raises(InputError, match="expected 0 and one for sky"):
        describe(np.arange(3600, dtype=np.uint16).reshape(60, 60).astype(np.uint8), params)
    with pytest.raises(InputError, match="in colour"):
        describe(np.random.default_rng(0).integers(0, 256, (60, 60, 3), dtype=np.uint8), params)
    sky = sky_disk(skylines(1)[0], 60)
    unknown = np.where(sky == 0, 0, sky)
    unknown[:3] = 128
    assert_array_equal(describe(np.where(unknown == 128, 128, unknown), params),
                       describe(np.where(unknown == 128, 0, unknown), params))  # fmt: skip
    assert looks_like_mask(unknown)
    assert not looks_like_mask(panoramas(1)[0])


def test_views_for_turning_have_three_degrees_to_a_column():
    picture = panoramas(1)[0]
    params = settled(picture, descriptor="turned-views", camera=view_camera("panorama"))
    assert params.settings() == {"sky": "none", "view_size": "30x120"}
    assert_allclose(describe(picture, params).reshape(30, 120), picture / 255.0, atol=1e-6)


@pytest.mark.parametrize("descriptor", ["turned-views", "frequency-strip", "retinotopic"])
@pytest.mark.parametrize("camera", ["panorama", "fisheye:180"])
def test_grey_in_floating_point_is_described_as_in_bits(descriptor: str, camera: str):
    shares = cv2.GaussianBlur(np.random.default_rng(0).random((105, 360), np.float32), (0, 0), 3)
    deep = np.rint(shares * 65535).astype(np.uint16)
    params = settled(deep, descriptor=descriptor, camera=view_camera(camera))
    expected = describe(deep, params)
    assert_allclose(describe(shares, params), expected, atol=1e-3 * np.ptp(expected))
    shares[52, 180] = np.nan
    with pytest.raises(InputError, match="expected finite numbers"):
        describe(shares, params)
    assert thumbnail(shares)  # whose warnings, if any, are errors here


def test_vectors_pass_unchanged_and_are_checked():
    params = DescribeParams(is_vectors=True, descriptor="netvlad")
    assert_array_equal(describe(np.arange(5.0), params), np.arange(5, dtype=np.float32))
    assert params.used_metric == "cosine"
    with pytest.raises(InputError, match="NaN, infinite"):
        describe(np.array([1.0, np.nan]), params)
    with pytest.raises(InputError, match=r"expected \(feature,\)"):
        describe(np.zeros((2, 2)), params)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("fisheye:x", "expected numbers after the colon"),
        ("fisheye:400", "field of view of the camera is 400"),
        ("panorama:60,-15", "the lower elevation first"),
        ("panorama:60", "as in panorama:-15,90"),
        ("ahead:3", "expected ahead"),
        ("mirror", "with its radius"),
        ("eye", "camera 'eye' is unknown"),
    ],
)
def test_cameras_that_make_no_sense(text: str, words: str):
    with pytest.raises(InputError, match=words):
        view_camera(text)


def test_elevations_of_panoramas_follow_from_their_height_where_they_can():
    camera = view_camera("panorama")
    rendered = camera.of_size((105, 360))
    assert_allclose([rendered.centre[1], *rendered.focal_length], [90.0, 180 / np.pi, 180 / np.pi])
    assert camera.of_size((180, 360)).centre[1] == 90.0
    with pytest.raises(InputError, match=r"shows 75° of elevation, expected --camera panorama:LOW,HIGH"):
        camera.of_size((25, 120))
    with pytest.raises(InputError, match="looks ahead"):
        AHEAD.of_size((25, 120))
    assert view_camera("fisheye").text == "fisheye:180"
    assert view_camera("mirror:150").of_size((400, 400)).focal_length == (150.0, 150.0)
