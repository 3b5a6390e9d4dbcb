import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

from insectnav.checks import InputError
from insectnav.vision.descriptors.lanczos import resize

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("size", [(32, 64), (7, 13), (105, 50), (120, 401)])
def test_agrees_with_pillow(size):
    image = RNG.random((105, 360)).astype(np.float32)
    expected = Image.fromarray(image).resize(size[::-1], Image.Resampling.LANCZOS)
    assert_allclose(resize(image, size), np.asarray(expected), rtol=0, atol=2e-6)


def test_a_constant_stays_and_integers_are_rounded():
    assert_allclose(resize(np.full((50, 70), 0.3), (9, 8)), 0.3, rtol=1e-14)
    image = RNG.integers(0, 256, (2, 50, 70), np.uint8)
    small = resize(image, (9, 8))
    assert small.dtype == np.uint8
    assert_array_equal(small, np.clip(np.floor(resize(image.astype(float), (9, 8)) + 0.5), 0, 255))


def test_bits_become_bytes_and_the_right_size_is_left_alone():
    mask = RNG.random((6, 8)) > 0.5
    assert_array_equal(resize(mask, (6, 8)), 255 * mask)
    image = RNG.random((6, 8))
    assert resize(image, (6, 8)) is image


@pytest.mark.parametrize(
    ("size", "sentence"),
    [((3,), "size is '.3,.', expected a pair of rows and columns"), ((0, 5), "size is 0, expected a whole number")],
)
def test_a_bad_size_is_refused(size, sentence):
    with pytest.raises(InputError, match=sentence):
        resize(np.zeros((5, 5)), size)
