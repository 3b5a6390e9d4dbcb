from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.descriptors import (
    radial_polynomials,
    zernike_amplitudes,
    zernike_coefficients,
    zernike_pairs,
    zernike_weights,
)
from zernike_oracle import radial_integral

RNG = np.random.default_rng(0)
NOISE = RNG.random((2, 3, 21, 72))


# Outside numbers.


def unquantised(views):
    """The rendered brightness behind golden bytes: ground is 0.1, which the bytes give as 26/255."""
    is_ground = (views == 26) & (np.arange(105)[:, None] >= 90)
    return np.where(is_ground, 0.1, views / 255.0)


@pytest.mark.data
@pytest.mark.parametrize(("sampling", "tolerance"), [("AA1", 1e-6), ("AA4", 1e-4)])
def test_published_amplitudes_of_the_clearing(golden, sampling, tolerance):
    # One ray a pixel gives three brightnesses, known exactly; supersampled pixels are known to half a grey level.
    arrays = golden("ant_world_views")
    expected = arrays[f"clearing_{sampling}_zernike"].astype(float)
    found = zernike_amplitudes(unquantised(arrays[f"clearing_{sampling}_views"]), weights="raw")
    apart = np.linalg.norm(found - expected, axis=-1) / np.linalg.norm(expected, axis=-1)
    assert apart.max() < tolerance
    if sampling == "AA1":
        assert_allclose(found, expected, rtol=1e-3)


@pytest.mark.data
@pytest.mark.parametrize("world", ["clearing_AA1", "clearing_AA4", "seville_AA1", "seville_AA4"])
def test_published_amplitudes_from_bytes(golden, world):
    # Half a grey level everywhere changes a coefficient by no more than half a level times the integral of |R_nm|.
    arrays = golden("ant_world_views")
    expected = arrays[f"{world}_zernike"].astype(float)
    found = zernike_amplitudes(arrays[f"{world}_views"], weights="raw")
    radius = (np.arange(105) + 0.5) / 105
    bound = 0.5 / 255 * 2 * np.pi * (np.abs(radial_polynomials(16, radius)) * radius[:, None] / 105).sum(axis=0)
    assert np.all(np.abs(found - expected) <= bound + 1e-5)


# Closed forms.


@pytest.mark.parametrize("order", [16, 50])
@pytest.mark.parametrize(("rows", "columns"), [((0, 21), (0, 120)), ((0, 9), (30, 31)), ((20, 21), (5, 90))])
def test_a_sector_is_integrated_exactly(order, rows, columns):
    view = np.zeros((21, 120))
    view[slice(*rows), slice(*columns)] = 1.0
    edges = np.array(columns) * 2 * np.pi / 120 - np.pi
    n, m = zernike_pairs(order)
    angular = np.array([edges[1] - edges[0] if k == 0 else np.diff(np.exp(-1j * k * edges))[0] / (-1j * k) for k in m])
    inner_and_outer = (Fraction(rows[0], 21), Fraction(rows[1], 21))
    radial = np.array([float(radial_integral(int(a), int(b), *inner_and_outer)) for a, b in zip(n, m, strict=True)])
    found = zernike_coefficients(view, order, quadrature="cells")
    assert_allclose(found, radial * angular, rtol=0, atol=1e-13)


def test_a_constant_view_has_one_coefficient():
    found = zernike_coefficients(np.full((105, 360), 0.7), 50, quadrature="cells")
    assert_allclose(found[0], 0.7 * np.pi, rtol=1e-14)
    assert_allclose(found[1:], 0.0, rtol=0, atol=1e-13)


def test_a_zernike_function_has_its_own_coefficient():
    rows, columns, order = 600, 64, 12
    radius = (np.arange(rows) + 0.5) / rows
    azimuth = (np.arange(columns) + 0.5) * 2 * np.pi / columns - np.pi
    n, m = zernike_pairs(order)
    for pair in (0, 5, 17, 31, 48):
        view = radial_polynomials(order, radius)[:, pair, None] * np.cos(m[pair] * (azimuth - 0.4))
        expected = np.zeros(len(n), complex)
        # ∫ R² r dr = 1 / (2 (n + 1)); ∫ cos(m (θ − 0.4)) e^(−imθ) dθ = π e^(−0.4im), 2π for m = 0
        expected[pair] = np.pi * np.exp(-0.4j * m[pair]) / (2 * (n[pair] + 1)) * (2 if m[pair] == 0 else 1)
        # the midpoint rule errs by h²/24 times the rise of the slope of the integrand, at most 2 n² at the rim
        bound = 2 * np.pi * (1 / rows) ** 2 / 24 * 2 * order**2
        assert_allclose(zernike_coefficients(view, order), expected, rtol=0, atol=bound)


def test_midpoints_converge_to_cells_in_the_second_order():
    def error(rows):
        view = np.cos(3 * (np.arange(rows) + 0.5) / rows)[:, None] * np.ones(40)
        midpoint, cells = (zernike_coefficients(view, 8, quadrature=kind) for kind in ("midpoint", "cells"))
        return np.abs(midpoint - cells)[zernike_pairs(8)[1] == 0].max()

    assert error(80) / error(160) == pytest.approx(4, rel=0.02)


# Laws.


@pytest.mark.parametrize("quadrature", ["midpoint", "cells"])
@pytest.mark.parametrize("columns", [1, 17, 36, -5])
def test_a_turn_by_columns_changes_phases_only(columns, quadrature):
    still = zernike_coefficients(NOISE, 20, quadrature=quadrature)
    turned = zernike_coefficients(np.roll(NOISE, -columns, axis=-1), 20, quadrature=quadrature)  # to the right
    angle = columns * 2 * np.pi / 72
    assert_allclose(turned, still * np.exp(1j * zernike_pairs(20)[1] * angle), rtol=0, atol=1e-14)


@settings(max_examples=25, deadline=None)
@given(angle=st.floats(-7, 7))
def test_a_turn_by_any_angle_leaves_amplitudes_of_what_the_columns_resolve(angle):
    azimuth = (np.arange(72) + 0.5) * 2 * np.pi / 72 - np.pi
    rows = np.linspace(0, 1, 21)[:, None]

    def view(heading):  # harmonics of exp(2 cos θ) fall below 1e-16 long before 72 − 12
        return rows * np.exp(2 * np.cos(azimuth + heading - 0.3)) + rows**3 * np.cos(5 * (azimuth + heading))

    still, turned = (zernike_amplitudes(view(heading), 12) for heading in (0.0, angle))
    assert_allclose(turned, still, rtol=0, atol=1e-12 * still.max())


def test_a_mirrored_view_has_the_conjugates():
    mirrored = zernike_coefficients(NOISE[..., ::-1], 20)
    assert_allclose(mirrored, np.conj(zernike_coefficients(NOISE, 20)), rtol=0, atol=1e-14)


def test_coefficients_are_linear():
    a, b = NOISE[0], NOISE[1]
    expected = 0.3 * zernike_coefficients(a) - 2.0 * zernike_coefficients(b)
    assert_allclose(zernike_coefficients(0.3 * a - 2.0 * b), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("weights", ["raw", "stone", "orthonormal"])
def test_amplitudes_are_weighted_moduli(weights):
    expected = np.abs(zernike_coefficients(NOISE)) * zernike_weights(16, weights)
    assert_array_equal(zernike_amplitudes(NOISE, weights=weights), expected)


def test_a_lower_order_is_the_beginning_of_a_higher_one():
    assert_allclose(zernike_amplitudes(NOISE, 7), zernike_amplitudes(NOISE, 31)[..., :20], rtol=0, atol=1e-13)


def test_batch_is_loop():
    many = RNG.random((130, 105, 360))  # more than are worked on at once
    together = zernike_amplitudes(many)
    assert together.shape == (130, 81)
    alone = np.stack([zernike_amplitudes(view) for view in many[[0, 65, 66, 129]]])
    assert_allclose(together[[0, 65, 66, 129]], alone, rtol=0, atol=1e-12)
    assert zernike_amplitudes(many[:0]).shape == (0, 81)
    assert zernike_amplitudes(NOISE).shape == (2, 3, 81)


def test_bytes_count_as_zero_to_one():
    grey = RNG.integers(0, 256, (2, 12, 40), np.uint8)
    assert_allclose(zernike_amplitudes(grey), zernike_amplitudes(grey / 255), rtol=0, atol=1e-13)


def test_input_is_left_alone():
    view = NOISE[0, 0].copy()
    zernike_amplitudes(view)
    assert_array_equal(view, NOISE[0, 0])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"order": 37}, r"Zernike order is 37, expected at most half of the 72 columns of the views"),
        ({"order": 51}, r"Zernike order is 51, expected at most 50"),
        ({"quadrature": "exact"}, r"quadrature 'exact' is unknown: expected one of midpoint, cells"),
        ({"weights": "none"}, r"Zernike weights 'none' is unknown"),
        ({"views": np.zeros(5)}, r"views has shape \(5,\), expected \(\.\.\., rows, columns\)"),
        ({"views": np.zeros((3, 0))}, r"views have shape \(3, 0\), expected at least one pixel"),
        ({"views": np.full((8, 40), np.nan)}, r"views is nan at index 0, 0 \(320 of 320 values\)"),
        ({"views": np.zeros((8, 40), complex)}, r"views hold complex128 values, expected floats, or integers of 8 or"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(change, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        zernike_amplitudes(**({"views": NOISE} | change))
