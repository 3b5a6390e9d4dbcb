import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.descriptors import binary_sky, panorama_binary_sky
from insectnav.vision.descriptors.sky_region import middle_region
from real_routes import DATA, load_images


def sky(size=180, seed=3):
    """A smooth blob about the middle."""
    rng = np.random.default_rng(seed)
    place = np.arange(size) + 0.5 - size / 2
    x, y = np.meshgrid(place, -place)
    azimuth, edge = np.arctan2(x, y), 0.0
    for k in range(1, 6):
        edge = edge + rng.normal() / k * np.cos(k * azimuth + rng.uniform(0, 6))
    return np.hypot(x, y) < size * (0.25 + 0.04 * edge)


def test_area_and_place_are_kept():
    bits = binary_sky(sky()).reshape(90, 90)
    assert abs(bits.sum() * 4 - sky().sum()) < 0.02 * sky().sum()
    rows, columns = np.nonzero(bits)
    assert abs(rows.mean() - 44.5) < 0.5
    assert abs(columns.mean() - 44.5) < 0.5


@settings(deadline=None, max_examples=30)
@given(st.integers(-30, 30), st.integers(-30, 30))
def test_a_shifted_sky_is_the_same(down, right):
    assert_array_equal(binary_sky(np.roll(sky(), (down, right), (0, 1))), binary_sky(sky()))


@pytest.mark.parametrize("quarter", [1, 2, 3])
def test_a_turned_sky_is_turned(quarter):
    turned = binary_sky(np.rot90(sky(), quarter), isolate=False, centre=False).reshape(90, 90)
    assert_array_equal(turned, np.rot90(binary_sky(sky(), isolate=False, centre=False).reshape(90, 90), quarter))


def test_only_the_region_nearest_to_the_middle_counts():
    mask = np.zeros((90, 90), bool)
    mask[40:50, 50:60] = mask[10:20, 10:20] = True
    assert binary_sky(mask).sum() == 100
    assert binary_sky(mask, isolate=False).sum() == 200
    region = middle_region(mask)
    assert region[45, 55]
    assert not region[15, 15]


def test_of_regions_equally_near_the_largest_counts():
    mask = np.zeros((11, 11), bool)
    mask[5, 1:4] = True  # two steps from the middle
    mask[5, 7] = True
    assert_array_equal(np.nonzero(middle_region(mask))[1], [1, 2, 3])


@pytest.mark.parametrize("value", [False, True])
def test_no_sky_and_nothing_but_sky(value):
    assert_array_equal(binary_sky(np.full((50, 60), value)), value)


def test_batches_and_types():
    masks = np.stack([sky(seed=1), sky(seed=2)])
    bits = binary_sky(masks[None])
    assert bits.shape == (1, 2, 8100)
    assert bits.dtype == bool
    for other in (masks.astype(np.uint8) * 255, masks.astype(float), masks * 0.6):
        assert_array_equal(binary_sky(other), bits[0])
    assert_array_equal(binary_sky(masks[1]), bits[0, 1])


def test_a_panorama_is_wrapped_first():
    views = np.zeros((105, 360))
    views[:60] = 1.0  # the zenith and 60° around it
    bits = panorama_binary_sky(views).reshape(90, 90)
    radius = np.hypot(*np.meshgrid(np.arange(90) - 44.5, np.arange(90) - 44.5))
    assert bits[radius < 45 * 59 / 105].all()
    assert not bits[radius > 45 * 61 / 105].any()


@pytest.mark.data
def test_a_real_sky_agrees_with_a_plain_way():
    masks = load_images(sorted((DATA / "fisheye_sky").glob("*_mask.png"))[:4]) > 127
    found = binary_sky(masks).reshape(-1, 90, 90)
    for mask, bits in zip(masks, found, strict=True):
        labels = cv2.connectedComponents(mask.astype(np.uint8))[1]
        region = labels == labels[160, 160] if mask[160, 160] else mask
        rows, columns = np.nonzero(region)
        shift = [round(159.5 - axis.mean()) for axis in (rows, columns)]
        moved = cv2.warpAffine(region.astype(np.float32), np.float32([[1, 0, shift[1]], [0, 1, shift[0]]]), (320, 320))
        expected = cv2.resize(moved, (90, 90), interpolation=cv2.INTER_AREA) > 0.5
        assert np.mean(bits != expected) < 0.01


def test_bad_masks_are_refused():
    with pytest.raises(InputError, match="views hold int64"):
        binary_sky(np.ones((4, 4), int))
    with pytest.raises(InputError, match="size is 0"):
        binary_sky(np.ones((4, 4)), 0)


def test_a_pixel_half_of_which_is_sky_is_none():
    mask = np.zeros((8, 8), bool)
    mask[:, ::2] = True  # one of two columns
    assert not binary_sky(mask, 4, isolate=False, centre=False).any()
    mask[0, 1] = True  # three of four pixels in one corner
    assert np.flatnonzero(binary_sky(mask, 4, isolate=False, centre=False)).tolist() == [0]


def test_pixels_that_touch_by_a_corner_are_one_region():
    mask = np.zeros((9, 9), bool)
    mask[4, 4] = mask[3, 3] = mask[2, 2] = mask[0, 8] = True
    expected = mask.copy()
    expected[0, 8] = False
    assert_array_equal(middle_region(mask), expected)
