"""Channels against OpenCV, and pictures that are none."""

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.sky_channels import channel_name, checked_picture, features, lab, one_channel, uv_green

RNG = np.random.default_rng(0)
COLOUR = RNG.integers(0, 256, (12, 17, 3)).astype(np.uint8)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_mean_and_bands_keep_the_unit(dtype):
    picture = checked_picture((COLOUR * 200.0 if dtype == np.uint16 else COLOUR).astype(dtype))
    assert_allclose(one_channel(picture, "mean"), picture.mean(axis=2), rtol=1e-6)
    for k, name in enumerate(("red", "green", "blue")):
        assert_array_equal(one_channel(picture, name), picture[..., k])


def test_grey_is_that_of_opencv():
    assert_allclose(one_channel(COLOUR, "grey"), cv2.cvtColor(COLOUR, cv2.COLOR_RGB2GRAY), atol=0.51)


def test_lab_is_that_of_opencv():
    scaled = (COLOUR / 255).astype(np.float32)
    assert_allclose(lab(scaled), cv2.cvtColor(scaled, cv2.COLOR_RGB2LAB), atol=0.3)  # theirs by splines
    assert_allclose(lab(np.ones((1, 3))), [[100, 0, 0]], atol=1e-4)


def test_uv_is_red_and_green_is_grey_with_white_as_one():
    deep = COLOUR.astype(np.uint16) * 257
    both = uv_green(COLOUR, deep)
    assert both.shape == (12, 17, 2)
    assert_allclose(both[..., 0], COLOUR[..., 0] / 255, atol=1e-6)
    assert_allclose(both[..., 1], COLOUR @ np.array([0.299, 0.587, 0.114]) / 255, atol=1e-5)
    with pytest.raises(InputError, match="not aligned"):
        uv_green(COLOUR, COLOUR[:-1])


def test_features_have_white_at_one():
    assert features(COLOUR, "rgb").max() <= 1.0
    assert features(COLOUR.astype(np.uint16) * 257, "mean") == pytest.approx(features(COLOUR, "mean"), abs=1e-6)


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (np.zeros(5), "1 axes"),
        (np.zeros((5, 5, 4)), "alpha"),
        (np.zeros((3, 5, 5)), "bands first"),
        (np.zeros((2, 2)), "2 × 2 pixels"),
        (np.full((5, 5), np.nan), "nan"),
        (np.full((5, 5), -1.0), "difference of pictures"),
        (np.zeros((5, 5), bool), "bool"),
        ([["a"]], "expected real numbers"),
    ],
)
def test_what_is_no_picture_is_refused(bad, words):
    with pytest.raises(InputError, match=words):
        checked_picture(bad)


def test_channels_that_a_picture_lacks_are_refused():
    with pytest.raises(InputError, match="need an image of 3 bands, but it has 1"):
        channel_name(COLOUR[..., 0], "blue", one=True)
    with pytest.raises(InputError, match="need an image of 2 bands"):
        channel_name(COLOUR, "uv-green", one=False)
    with pytest.raises(InputError, match="more than one"):
        channel_name(COLOUR, "rgb", one=True)
    with pytest.raises(InputError, match="did you mean blue"):
        channel_name(COLOUR, "blau", one=True)
    assert channel_name(COLOUR[..., :2], None, one=False) == "uv-green"
    assert channel_name(COLOUR[..., 0], "grey", one=True) == "mean"
