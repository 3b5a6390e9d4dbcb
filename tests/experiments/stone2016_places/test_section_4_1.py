"""Figs 4.1 and 4.2: what is drawn, beside closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from insectnav.experiments.recordings import files
from insectnav.experiments.stone2016_places import fig_4_1, fig_4_2
from insectnav.experiments.stone2016_places.one_sky import RENDERED, one_sky, source
from insectnav.vision import rotation_matrix
from insectnav.vision.descriptors import contour_coefficients, harmonic_pairs, sky_contour
from real_skies import DATA


@pytest.fixture(autouse=True)
def no_data(monkeypatch):
    monkeypatch.delenv(files.FOLDER, raising=False)
    files.sky_masks.cache_clear()
    yield
    files.sky_masks.cache_clear()


def square(side):
    mask = np.zeros((320, 320), bool)
    mask[160 - side // 2 : 160 + side // 2, 160 - side // 2 : 160 + side // 2] = True
    return mask


def test_without_photographs_one_sky_is_rendered():
    assert source() == RENDERED
    assert [cell.sky for cell in fig_4_1.grid("full")] == [RENDERED]
    assert 0.2 < one_sky(RENDERED).mean() < 0.7


def test_a_square_comes_back_as_a_disc_from_one_frequency_and_as_itself_from_many():
    """Its first amplitude is 8 sqrt(2) / π² of its half side: ∫ of one side times e^(−iπt/2), four times alike."""
    mask, half = square(200), (200 - 1) / 2.0
    coefficients = contour_coefficients(sky_contour(mask), 100)
    assert fig_4_1._overlap(mask, coefficients) > 0.99
    radius = 8 * np.sqrt(2) / np.pi**2 * half
    assert np.abs(coefficients[1]) * 160 == pytest.approx(radius, rel=1e-6)
    expected = shared_with_disc(half, radius)
    assert fig_4_1._overlap(mask, coefficients[:3]) == pytest.approx(expected, abs=0.02)


def shared_with_disc(half, radius):
    """Intersection over union of a square and a disc about its middle, by counting points."""
    x, y = np.meshgrid(*2 * [np.linspace(-1.3 * half, 1.3 * half, 1500)])
    disc, box = np.hypot(x, y) < radius, np.maximum(np.abs(x), np.abs(y)) < half
    return (disc & box).sum() / (disc | box).sum()


def test_pictures_of_harmonics_are_those_of_the_textbook():
    """Y_1m is sqrt(3 / 4π) times right, up or ahead, for m = −1, 0, 1."""
    pictures, (degree, order) = fig_4_2._pictures(), harmonic_pairs(fig_4_2.N_DRAWN)
    assert pictures.shape == (25, fig_4_2.SIZE, fig_4_2.SIZE)
    axis = (np.arange(fig_4_2.SIZE) + 0.5) / fig_4_2.SIZE * 2.1 - 1.05
    right, up = np.meshgrid(axis, -axis)
    inside = right**2 + up**2 <= 1.0
    assert (np.isfinite(pictures) == inside).all()
    near = -np.sqrt(1.0 - np.minimum(right**2 + up**2, 1.0))
    world = np.einsum("ij,jrc->irc", rotation_matrix(*fig_4_2.LOOK), np.stack([right, near, up]))
    for m, component in ((-1, world[0]), (0, world[2]), (1, world[1])):
        (pair,) = np.flatnonzero((degree == 1) & (order == m))
        assert_allclose(pictures[pair][inside], np.sqrt(3 / (4 * np.pi)) * component[inside], atol=1e-6)


def test_amplitudes_of_the_rendered_sky_stay_and_what_is_left_out_falls():
    arrays = fig_4_2.simulate(fig_4_2.Cell(sky=RENDERED), 0)
    level, turned = arrays["amplitude"][1]
    assert_allclose(turned, level, rtol=1e-9)
    left_out = arrays["left_out"][1]
    assert (np.diff(left_out) <= 1e-12).all()
    assert arrays["off_orthonormal"][1] < 1e-10


@pytest.mark.data
def test_ten_coefficients_of_an_open_sky_tell_its_shape_and_of_a_torn_one_less(monkeypatch):
    if not DATA.is_dir():
        pytest.skip(f"{DATA} is missing")
    monkeypatch.setenv(files.FOLDER, str(DATA))
    files.sky_masks.cache_clear()
    share = {}
    for number in (6, 28):  # a round sky, and one half hidden by a tree
        arrays = fig_4_1.simulate(fig_4_1.Cell(sky="photograph", number=number), 0)
        share[number] = arrays["overlap"][1][fig_4_1.COEFFICIENTS.index(fig_4_1.TEN)]
        assert arrays["change_by_quarter_turn"][1] < 1e-9
    assert share[6] > 0.9 > 0.7 > share[28]
