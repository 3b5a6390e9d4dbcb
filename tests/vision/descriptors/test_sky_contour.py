import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.descriptors import (
    contour_amplitudes,
    contour_coefficients,
    panorama_contour_amplitudes,
    redraw_contour,
    sky_contour,
)


def polygon(seed=0, n=40):
    """A simple polygon about 0, anticlockwise."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, n))
    return rng.uniform(0.3, 1.0, n) * np.exp(1j * angle)


def blob(size=200, turn=0.0, shift=(0, 0)):
    place = np.arange(size) + 0.5 - size / 2
    x, y = np.meshgrid(place - shift[1], -(place - shift[0]))
    azimuth = np.arctan2(y, x) - turn
    return np.hypot(x, y) < size * (0.3 + 0.06 * np.cos(2 * azimuth) + 0.04 * np.sin(3 * azimuth + 1))


def test_coefficients_are_the_limit_of_a_fourier_transform():
    corners, n = polygon(), 2**16
    side = np.roll(corners, -1) - corners
    reached = np.concatenate([[0], np.cumsum(np.abs(side))])
    along = (np.arange(n) + 0.5) * reached[-1] / n
    closed = np.append(corners, corners[0])
    points = np.interp(along, reached, closed.real) + 1j * np.interp(along, reached, closed.imag)
    waves = np.fft.fft(points) / n * np.exp(-1j * np.pi * np.fft.fftfreq(n) * n / n)  # points lie half a step on
    found = contour_coefficients(corners, 12)
    assert_allclose(found[0], waves[0], atol=1e-8)
    assert_allclose(found[1::2], waves[1:13], atol=1e-8)
    assert_allclose(found[2::2], waves[-1:-13:-1], atol=1e-8)


def test_a_regular_polygon_has_the_known_coefficients():
    n = 6  # z turns by 1/n of a circle each n-th of its length: only k = 1 + n j are not 0
    found = np.abs(contour_coefficients(np.exp(2j * np.pi * np.arange(n) / n), 13))
    k = np.arange(1, 28) // 2 * np.where(np.arange(27) % 2, 1, -1)
    is_there = (k - 1) % n == 0
    assert_allclose(found[~is_there], 0, atol=1e-15)
    factor = (n / np.pi * np.sin(np.pi / n)) ** 2  # of the k-th: that of a sawtooth of corners, over k²
    assert_allclose(found[is_there], factor / k[is_there] ** 2.0, rtol=1e-12)


@settings(deadline=None, max_examples=40)
@given(st.floats(-3.1, 3.1), st.floats(-5, 5), st.floats(0.1, 9), st.integers(0, 39))
def test_amplitudes_stay_under_turn_shift_and_another_start_and_scale_with_size(turn, shift, size, start):
    corners = polygon()
    moved = np.roll(size * corners * np.exp(1j * turn) + shift * (1 + 2j), start)
    still = np.abs(contour_coefficients(corners))[1:]
    assert_allclose(np.abs(contour_coefficients(moved))[1:], size * still, rtol=0, atol=1e-12 * size)


def test_redrawn_from_many_coefficients_it_is_the_contour():
    corners = polygon(n=12)
    drawn = redraw_contour(contour_coefficients(corners, 4000), 500)
    side = np.roll(corners, -1) - corners
    reached = np.concatenate([[0], np.cumsum(np.abs(side))])
    along, closed = np.arange(500) * reached[-1] / 500, np.append(corners, corners[0])
    points = np.interp(along, reached, closed.real) + 1j * np.interp(along, reached, closed.imag)
    assert_allclose(drawn, points, atol=1e-3)


def test_a_disk_is_one_wave_of_its_radius():
    place = np.arange(400) + 0.5 - 200
    disk = np.hypot(*np.meshgrid(place, place)) < 100
    found = contour_amplitudes(disk)
    assert_allclose(found[0], 0.5, atol=0.015)  # half of the half image; the outline runs through centres of pixels
    assert found[1:].max() < 0.02


def test_contour_runs_anticlockwise_about_what_is_sky():
    mask = np.zeros((20, 40), bool)
    mask[5:10, 12:30] = True
    contour = sky_contour(mask)
    area = np.sum(contour.real * np.roll(contour.imag, -1) - contour.imag * np.roll(contour.real, -1)) / 2
    assert_allclose(area, 4 * 17 / 20**2)
    assert_allclose([contour.real.min(), contour.real.max()], [(12 - 19.5) / 20, (29 - 19.5) / 20])
    assert_allclose([contour.imag.min(), contour.imag.max()], [(9.5 - 9) / 20, (9.5 - 5) / 20])


def test_a_turned_or_shifted_mask_has_nearly_the_same_amplitudes():
    still = contour_amplitudes(blob())
    for mask in (blob(turn=0.7), blob(turn=2.1), blob(shift=(9, -13))):
        assert np.linalg.norm(contour_amplitudes(mask) - still) < 0.03 * np.linalg.norm(still)
    assert_allclose(contour_amplitudes(np.rot90(blob())), still, atol=1e-13)
    other = np.linalg.norm(contour_amplitudes(blob().T[:, ::-1] & blob()) - still)
    assert other > 0.05 * np.linalg.norm(still)


def test_panoramas_turned_by_quarters_have_the_same_amplitudes():
    rng = np.random.default_rng(1)
    edge = 40 + 20 * np.cos(np.arange(360) / 57.3 * 3 + 1) + rng.uniform(0, 6, 360)
    view = np.arange(105)[:, None] < edge
    still = panorama_contour_amplitudes(view)
    for columns in (90, 180, 270):
        assert_allclose(panorama_contour_amplitudes(np.roll(view, columns, axis=1)), still, atol=1e-12)
    turned = panorama_contour_amplitudes(np.roll(view, 37, axis=1))
    assert 0 < np.linalg.norm(turned - still) < 0.1 * np.linalg.norm(still)


def test_no_sky_and_a_single_pixel_of_it_are_zeros():
    mask = np.zeros((3, 9, 9), bool)
    mask[1, 4, 4] = True
    mask[2, 2:7, 2:7] = True
    found = contour_amplitudes(mask, 5)
    assert found.shape == (3, 10)
    assert_array_equal(found[:2], 0)
    assert_array_equal(found[2], contour_amplitudes(mask[2], 5))
    assert sky_contour(mask[0]).size == 0


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: sky_contour(np.zeros((2, 3, 3))), "mask has shape .2, 3, 3., expected one of .rows, columns."),
        (lambda: contour_coefficients(polygon(), 0), "n_frequencies is 0"),
        (lambda: contour_coefficients(np.ones((2, 2))), "contour has shape .2, 2., expected .corner,."),
        (lambda: contour_coefficients([0, 1j, np.nan]), "contour is nan at index 2"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
