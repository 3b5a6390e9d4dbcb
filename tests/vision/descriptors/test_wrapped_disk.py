import os
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.descriptors import (
    radial_polynomials,
    wrap_to_disk,
    zernike_amplitudes,
    zernike_disk_amplitudes,
    zernike_disk_coefficients,
    zernike_pairs,
    zernike_weights,
)

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[4] / "shared" / "data")
RNG = np.random.default_rng(0)


def plain_coefficients(disk, order):
    """The sum over all pixels as it is written, without symmetries."""
    size = disk.shape[-1]
    place = (2 * np.arange(size) + 1 - size) / size
    right, up = np.meshgrid(place, -place)
    radius = np.hypot(right, up)
    inside = radius <= 1
    waves = np.exp(-1j * np.arctan2(right, up)[..., None] * zernike_pairs(order)[1])
    functions = radial_polynomials(order, np.minimum(radius, 1)) * waves * inside[..., None]
    return (disk[..., None] * functions).sum(axis=(-3, -2)) * (2 / size) ** 2


@pytest.mark.data
def test_amplitudes_that_were_published_with_their_disk_images():
    # Sun et al. 2020: sky is what is quite white; (n + 1), over the number of pixels of the disk and one.
    path = DATA / "sun2020_home_memory.npz"
    if not path.exists():
        pytest.skip(f"{path} is missing")
    with np.load(path) as arrays:
        sky, expected = arrays["images"] == 255, arrays["zm_amplitude"]
    size = sky.shape[-1]
    offset = 2 * np.arange(size) - size + 1
    n_pixels = np.count_nonzero(np.hypot(*np.meshgrid(offset, offset)) <= size)
    n, _ = zernike_pairs(16)
    found = np.abs(zernike_disk_coefficients(sky)) * (n + 1) * (size / 2) ** 2 / (n_pixels + 1)
    assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.data
def test_the_published_view_by_way_of_a_disk(golden):
    # The published amplitudes are of the polar view; a disk samples it anew, and the bytes alone are 0.9e-3 off.
    arrays = golden("ant_world_views")
    expected = arrays["clearing_AA4_zernike"].astype(float)
    for interpolation in ("nearest", "bilinear"):
        found = zernike_disk_amplitudes(arrays["clearing_AA4_views"], weights="raw", interpolation=interpolation)
        apart = np.linalg.norm(found - expected, axis=-1) / np.linalg.norm(expected, axis=-1)
        assert apart.max() < 2e-3


@pytest.mark.parametrize("size", [2, 9, 16, 31])
@pytest.mark.parametrize("order", [0, 1, 7])
def test_folding_changes_nothing(size, order):
    disks = RNG.normal(size=(3, size, size))
    assert_allclose(zernike_disk_coefficients(disks, order), plain_coefficients(disks, order), rtol=0, atol=1e-13)


def test_folding_changes_nothing_at_order_50():
    disk = RNG.random((40, 40))
    assert_allclose(zernike_disk_coefficients(disk, 50), plain_coefficients(disk, 50), rtol=0, atol=1e-12)


@pytest.mark.parametrize("interpolation", ["nearest", "bilinear"])
def test_zenith_in_the_middle_ahead_at_the_top_right_on_the_right(interpolation):
    view = np.zeros((30, 120))
    view[:3] = 0.5  # the zenith
    view[:, 75:105] = 1.0  # 45° to 135° to the right
    disk = wrap_to_disk(view, 60, interpolation=interpolation)
    assert disk[30, 59] == 1.0
    assert_array_equal(disk[[0, 59, 30], [30, 30, 0]], 0.0)
    assert disk[29, 29] == 0.5
    assert_array_equal(disk[[0, 0, 59, 59], [0, 59, 0, 59]], 0.0)


def test_nearest_takes_the_pixel_that_holds_the_centre():
    rows, columns, size = 15, 48, 33
    row, column = np.divmod(wrap_to_disk(np.arange(1.0, rows * columns + 1).reshape(rows, columns), size) - 1, columns)
    place = (2 * np.arange(size) + 1) / size - 1
    right, up = np.meshgrid(place, -place)
    radius = np.hypot(right, up)
    inside = radius < 1 - 1e-9
    assert np.abs(radius * rows - row - 0.5)[inside].max() <= 0.5 + 1e-9
    angle = (column + 0.5) * 2 * np.pi / columns - np.pi
    apart = np.angle(np.exp(1j * (np.arctan2(right, up) - angle)))
    assert np.abs(apart)[inside].max() <= np.pi / columns + 1e-9
    assert np.all(row[radius > 1 + 1e-9] == -1)  # the 0 outside


def test_bilinear_is_exact_for_a_linear_ramp_of_elevation():
    rows, size = 20, 60
    view = np.repeat((np.arange(rows) + 0.5)[:, None] / rows, 36, axis=1)
    disk = wrap_to_disk(view, size, interpolation="bilinear")
    place = (2 * np.arange(size) + 1) / size - 1
    radius = np.hypot(*np.meshgrid(place, place))
    expected = np.where(radius <= 1, np.clip(radius, 0.5 / rows, 1 - 0.5 / rows), 0)
    assert_allclose(disk, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_of_the_eye_turns_the_disk_exactly(quarters):
    view = RNG.random((35, 120))
    turned = np.roll(view, -30 * quarters, axis=-1)  # to the right: what was on the right comes to the top
    assert_array_equal(wrap_to_disk(turned, 70), np.rot90(wrap_to_disk(view, 70), quarters))
    still, after = (zernike_disk_amplitudes(v, size=70) for v in (view, turned))
    assert_allclose(after, still, rtol=0, atol=1e-13)


def test_large_disks_come_to_the_polar_amplitudes():
    azimuth = (np.arange(360) + 0.5) * np.pi / 180 - np.pi
    radius = (np.arange(180)[:, None] + 0.5) / 180
    view = np.clip(1 - radius, 0, 1) ** 2 * (1 + np.cos(azimuth - 1) + np.cos(3 * azimuth))  # nothing at the rim
    polar = zernike_amplitudes(view, 8, quadrature="cells", weights="raw")
    for size, tolerance in ((60, 3e-3), (360, 2e-4)):
        apart = zernike_disk_amplitudes(view, 8, size=size, interpolation="bilinear", weights="raw") - polar
        assert np.linalg.norm(apart) / np.linalg.norm(polar) < tolerance


@pytest.mark.parametrize("interpolation", ["nearest", "bilinear"])
def test_amplitudes_are_those_of_the_disk_image_and_batch_is_loop(interpolation):
    views = RNG.integers(0, 256, (2, 3, 20, 72), np.uint8)
    disks = wrap_to_disk(views, 41, interpolation=interpolation)
    assert disks.shape == (2, 3, 41, 41)
    assert disks.dtype == np.float32
    expected = np.abs(zernike_disk_coefficients(disks, 9)) * zernike_weights(9, "stone")
    found = zernike_disk_amplitudes(views, 9, size=41, interpolation=interpolation)
    assert_allclose(found, expected, rtol=0, atol=1e-6)  # the image is in single precision
    alone = zernike_disk_amplitudes(views[1, 2], 9, size=41, interpolation=interpolation)
    assert_allclose(found[1, 2], alone, rtol=0, atol=1e-13)


def test_a_view_of_one_row_is_a_pinwheel():
    for interpolation in ("nearest", "bilinear"):
        disk = wrap_to_disk(np.full((1, 8), 0.25), 10, interpolation=interpolation)
        assert_array_equal(np.unique(disk), [0.0, 0.25])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: zernike_disk_coefficients(np.zeros((4, 5))), r"disk images have shape \(4, 5\), expected square ones"),
        (lambda: wrap_to_disk(np.zeros((4, 8)), 1), "size is 1, expected a whole number of at least 2"),
        (lambda: wrap_to_disk(np.zeros((4, 8)), interpolation="cubic"), "interpolation 'cubic' is unknown"),
        (lambda: zernike_disk_amplitudes(np.zeros((4, 8)), 60), "Zernike order is 60, expected at most 50"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
