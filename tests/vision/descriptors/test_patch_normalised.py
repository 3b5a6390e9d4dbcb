import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import seqslam_oracle
from insectnav.checks import InputError
from insectnav.vision.descriptors import DESCRIPTORS, patch_normalised
from real_routes import nordland

RNG = np.random.default_rng(0)
IMAGES = RNG.integers(0, 256, (3, 32, 64), np.uint8)


@pytest.mark.parametrize("flat_patch", [0, 127])
def test_bytes_are_those_of_the_plain_way(flat_patch):
    images = IMAGES.copy()
    images[0, :8, 8:24] = 77  # two patches without contrast
    images[1] //= 64  # few values, many equal ones
    expected = [seqslam_oracle.patch_normalise(image, flat_patch=flat_patch).ravel() for image in images]
    assert_array_equal(patch_normalised(images, rounded=True, flat_patch=flat_patch), expected)


@pytest.mark.data
def test_bytes_are_those_of_openseqslam(golden):
    stored = golden("openseqslam_v1_nordland_100_399")
    images = nordland("summer", stored["frame"][:20])
    found = patch_normalised(images, rounded=True, flat_patch=0)
    assert_array_equal(found, stored["patches_ref"])
    assert_array_equal(DESCRIPTORS["patch-normalised-v1"](images), stored["patches_ref"])


def test_each_patch_has_mean_0_and_deviation_1():
    patches = patch_normalised(IMAGES).reshape(3, 4, 8, 8, 8).swapaxes(2, 3)
    assert_allclose(patches.mean(axis=(-2, -1)), 0, atol=1e-7)
    assert_allclose(patches.std(axis=(-2, -1), ddof=1), 1, rtol=1e-6)


@settings(deadline=None)
@given(st.floats(0.1, 50), st.floats(-100, 100))
def test_light_on_a_patch_changes_nothing(gain, offset):
    image = IMAGES[0].astype(float)
    lit = image.copy()
    lit[8:16, 16:24] = gain * lit[8:16, 16:24] + offset
    assert_allclose(patch_normalised(lit), patch_normalised(image), rtol=0, atol=1e-5)


@pytest.mark.parametrize("value", [0, 1, 255])
def test_a_constant_image_is_neutral(value):
    image = np.full((32, 64), value, np.uint8)
    assert_array_equal(patch_normalised(image), 0)
    assert_array_equal(patch_normalised(image / 255), 0)
    assert_array_equal(patch_normalised(image, rounded=True), 127)
    assert_array_equal(patch_normalised(image, rounded=True, flat_patch=0), 0)


def test_constant_light_with_rounding_errors_is_flat_too():
    image = np.full((105, 360), 0.1) * 3.3  # resized, its pixels differ in the last digits
    assert_array_equal(patch_normalised(image), 0)


def test_batch_is_loop_and_types_agree():
    batch = patch_normalised(IMAGES.reshape(3, 1, 32, 64))
    assert batch.shape == (3, 1, 2048)
    assert batch.dtype == np.float32
    assert_array_equal(batch[1, 0], patch_normalised(IMAGES[1]))
    assert_allclose(patch_normalised(IMAGES.astype(np.uint16)), batch[:, 0], rtol=1e-5)
    assert_allclose(patch_normalised(IMAGES / 255.0), batch[:, 0], rtol=0, atol=1e-5)
    assert patch_normalised(IMAGES, rounded=True).dtype == np.uint8


def test_views_keep_their_size_if_asked():
    views = RNG.random((2, 105, 360))
    assert patch_normalised(views, size=None, patch_px=15).shape == (2, 105 * 360)
    assert patch_normalised(views).shape == (2, 2048)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"size": None}, "views of 33 × 64 pixels cannot be filled with patches of 8 × 8"),
        ({"patch_px": 1}, "patch_px is 1, expected a whole number of at least 2"),
        ({"flat_patch": 300}, "flat_patch is 300, expected 0 to 255"),
    ],
)
def test_bad_options_are_refused(options, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        patch_normalised(np.zeros((33, 64)), **options)
