import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import ducc0
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import erf, sph_harm_y

from insectnav.checks import InputError
from insectnav.vision import fisheye
from insectnav.vision.descriptors import (
    DESCRIPTORS,
    amplitude_spectrum,
    harmonic_amplitudes,
    harmonic_coefficients,
    real_harmonics,
    sphere_amplitudes,
    sphere_coefficients,
)
from insectnav.vision.sphere import (
    azimuth_elevation,
    equirectangular,
    fibonacci,
    gauss_legendre,
    great_circle_angle,
    rotation_matrix,
    thesis,
    to_world,
)

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[4] / "shared" / "data")
RNG = np.random.default_rng(0)
RING = gauss_legendre(20)
NOISE = RNG.random((2, 3, 20, 40))
VIEWS = RNG.random((2, 3, 35, 120))
TILTS = [(0.7, 0.0, 0.0), (0.0, 0.2, 0.0), (2.0, -0.5, 0.3), (-1.0, 1.2, -2.0)]  # heading, pitch, roll [rad]


def relative_error(found, expected):
    return np.linalg.norm(found - expected, axis=-1) / np.linalg.norm(expected, axis=-1)


def harmonic(degree, order, grid):
    """Y_lm of Eq. 1 of the paper on a grid, by SciPy's complex ones, which bear the sign (−1)^m."""
    azimuth, elevation = azimuth_elevation(grid.directions)
    value = sph_harm_y(degree, abs(order), np.pi / 2 - elevation, azimuth) * (-1.0) ** order
    return value.real if order == 0 else np.sqrt(2) * (value.real if order > 0 else value.imag)


# Outside numbers.


def test_coefficients_are_those_of_ducc():
    grid = gauss_legendre(120)
    values = RNG.random((120, 240))
    theirs = ducc0.sht.analysis_2d(
        map=values[None], spin=0, lmax=119, geometry="GL", phi0=np.pi / 240 - np.pi, nthreads=1
    )[0]
    order = np.repeat(np.arange(120), 120 - np.arange(120))
    degree = np.concatenate([np.arange(m, 120) for m in range(120)])
    found, middle = sphere_coefficients(values, grid), degree * (degree + 1)
    scale = np.where(order > 0, np.sqrt(2), 1.0) * (-1.0) ** order  # complex ones, with the sign (−1)^m
    assert_allclose(found[middle + order], scale * theirs.real, atol=1e-14)
    assert_allclose(found[middle - order], scale * np.where(order > 0, -theirs.imag, theirs.real), atol=1e-14)


@pytest.mark.parametrize(("degree", "order"), [(0, 0), (1, 1), (5, -3), (40, 0), (60, 59), (89, -89)])
def test_a_single_harmonic_has_one_coefficient(degree, order):
    expected = np.zeros(90**2)
    expected[degree**2 + degree + order] = 1.0
    rings = gauss_legendre(90)
    assert_allclose(sphere_coefficients(harmonic(degree, order, rings), rings, 90), expected, atol=1e-12)
    panorama = harmonic(degree, order, equirectangular(1.0)).reshape(180, 360)
    assert_allclose(harmonic_coefficients(panorama, 90, elevation_deg=(-90, 90)), expected, atol=1e-12)
    assert_allclose(harmonic_amplitudes(panorama, 90, elevation_deg=(-90, 90)), np.eye(90)[degree], atol=1e-12)


def cap_amplitudes(radius, n_degrees):
    """Those of a cap of brightness 1: ∫ P_l over its heights is (P_(l−1) − P_(l+1)) / (2l + 1) at its edge."""
    p = np.polynomial.legendre.legvander(np.cos([radius]), n_degrees)[0]
    degree = np.arange(1, n_degrees)
    integral = np.concatenate([[1 - p[1]], (p[degree - 1] - p[degree + 1]) / (2 * degree + 1)])
    return np.abs(integral) * np.sqrt(np.pi * (2 * np.arange(n_degrees) + 1))


@pytest.mark.parametrize("top", [90, 60])
def test_cells_integrate_caps_exactly(top):
    expected = cap_amplitudes(np.deg2rad(70), 80)
    if top == 60:
        expected = np.abs(
            harmonic_coefficients(np.ones((160, 360)), 80, elevation_deg=(20, 90), quadrature="cells")
            - harmonic_coefficients(np.ones((40, 360)), 80, elevation_deg=(60, 90), quadrature="cells")
        )[np.arange(80) * (np.arange(80) + 1)]
    view = np.ones((top - 20, 360))
    found = harmonic_amplitudes(view, 80, elevation_deg=(20, top), quadrature="cells")
    assert_allclose(found, expected, atol=1e-13)


@pytest.mark.parametrize("quadrature", ["fejer", "cells"])
def test_a_constant_sphere_has_one_coefficient(quadrature):
    expected = np.zeros(120)
    expected[0] = 0.7 * np.sqrt(4 * np.pi)
    sphere = np.full((180, 360), 0.7)
    assert_allclose(harmonic_amplitudes(sphere, elevation_deg=(-90, 90), quadrature=quadrature), expected, atol=1e-13)
    # and so has a part of it, if the rest is as bright
    assert_allclose(harmonic_amplitudes(sphere[:105], unseen=0.7, quadrature=quadrature), expected, atol=1e-13)
    hemisphere = np.full(equirectangular(2.0, (0, 90)).n_directions, 0.7)
    found = sphere_amplitudes(hemisphere, equirectangular(2.0, (0, 90)), 60, unseen=0.7)
    assert_allclose(found, expected[:60], atol=1e-13)


# Agreement with a plain sum.


@pytest.mark.parametrize(
    "grid",
    [RING, equirectangular(6.0), equirectangular(6.0, (-12, 90)), fibonacci(500), thesis()],
    ids=lambda g: g.name,
)
def test_agrees_with_a_plain_sum(grid):
    n_degrees = 15
    values = RNG.random((3, grid.n_directions))
    expected = (values * grid.weights) @ real_harmonics(n_degrees, grid.directions)
    assert_allclose(sphere_coefficients(values, grid, n_degrees), expected, atol=1e-12)
    assert_allclose(sphere_amplitudes(values, grid, n_degrees), amplitude_spectrum(expected), atol=1e-12)


def test_panoramas_agree_with_a_plain_sum_over_fine_cells():
    # Each pixel as 20 × 20 points of its brightness: the midpoint rule errs by (1 / 20)² times what a cell varies.
    view = RNG.random((17, 60))
    fine = equirectangular(0.3, (-12, 90))
    expected = sphere_coefficients(np.kron(view, np.ones((20, 20))), fine, 20)
    found = harmonic_coefficients(view, 20, elevation_deg=(-12, 90), quadrature="cells")
    assert_allclose(found, expected, atol=2e-4)
    rough = sphere_coefficients(view, equirectangular(6.0, (-12, 90)), 20)
    assert np.abs(rough - found).max() > 1e-3


# Laws.


def test_parseval_on_rings():
    coefficients = RNG.standard_normal(RING.shape[0] ** 2)
    values = real_harmonics(20, RING.directions) @ coefficients
    found = sphere_coefficients(values, RING, 20)
    assert_allclose(found, coefficients, atol=1e-12)
    assert_allclose(np.sum(sphere_amplitudes(values, RING, 20) ** 2), RING.integral(values**2), rtol=1e-13)


@pytest.mark.parametrize("tilt", TILTS)
def test_amplitudes_of_a_band_limited_field_are_the_same_after_any_rotation(tilt):
    coefficients = RNG.standard_normal(400)
    seen = real_harmonics(20, to_world(RING.directions, rotation_matrix(*tilt))) @ coefficients
    assert_allclose(sphere_amplitudes(seen, RING, 20), amplitude_spectrum(coefficients), rtol=1e-12)
    pixels = equirectangular(3.0)
    seen = real_harmonics(20, to_world(pixels.directions, rotation_matrix(*tilt))) @ coefficients
    found = harmonic_amplitudes(seen.reshape(60, 120), 20, elevation_deg=(-90, 90))
    assert_allclose(found, amplitude_spectrum(coefficients), rtol=1e-12)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("quadrature", ["fejer", "cells"])
def test_amplitudes_of_a_smooth_cap_are_the_same_after_any_rotation(tilt, quadrature):
    # A sky of 60° about a place 20° from the zenith, its edge blurred by 3°, against the same about the zenith.
    def sky(grid, centre):
        return (1 - erf((great_circle_angle(grid.directions, centre) - np.pi / 3) / np.deg2rad(3.0))) / 2

    rings, pixels = gauss_legendre(120), equirectangular(1.0)
    centre = np.array([0.0, np.sin(0.35), np.cos(0.35)]) @ rotation_matrix(*tilt)
    expected = sphere_amplitudes(sky(rings, np.array([0.0, 0.0, 1.0])), rings)
    assert relative_error(sphere_amplitudes(sky(rings, centre), rings), expected) < 1e-5
    view = sky(pixels, centre).reshape(180, 360)
    found = harmonic_amplitudes(view, elevation_deg=(-90, 90), quadrature=quadrature)
    assert relative_error(found, expected) < {"fejer": 1e-5, "cells": 2e-3}[quadrature]


@pytest.mark.parametrize("columns", [1, 17, 60, -5])
def test_a_turn_by_columns_rotates_pairs_of_coefficients(columns):
    still, turned = (harmonic_coefficients(v, 20) for v in (VIEWS, np.roll(VIEWS, -columns, axis=-1)))  # to the right
    angle, degree, order = columns * 2 * np.pi / 120, *np.indices((20, 20))
    degree, order = degree[order <= degree], order[order <= degree]
    middle = degree * (degree + 1)
    waves = [c[..., middle + order] + 1j * np.where(order > 0, c[..., middle - order], 0) for c in (still, turned)]
    assert_allclose(waves[1], waves[0] * np.exp(-1j * order * angle), atol=1e-13)
    assert_allclose(amplitude_spectrum(turned), amplitude_spectrum(still), rtol=1e-12)


def test_a_mirrored_view_has_the_same_amplitudes():
    assert_allclose(harmonic_amplitudes(VIEWS[..., ::-1], 60), harmonic_amplitudes(VIEWS, 60), rtol=1e-12)


def test_amplitudes_are_those_of_the_coefficients():
    expected = amplitude_spectrum(harmonic_coefficients(VIEWS, 60, unseen=0.3))
    assert_allclose(harmonic_amplitudes(VIEWS, 60, unseen=0.3), expected, rtol=1e-15)
    assert_array_equal(DESCRIPTORS["spherical-harmonics"](VIEWS), harmonic_amplitudes(VIEWS, 60))


def test_fewer_degrees_are_the_beginning_of_more():
    assert_allclose(harmonic_coefficients(VIEWS, 9), harmonic_coefficients(VIEWS, 50)[..., :81], atol=1e-14)


def test_what_is_not_seen_counts_as_stated():
    whole = np.concatenate([VIEWS, np.full((2, 3, 25, 120), 0.3)], axis=-2)
    for quadrature in ("fejer", "cells"):
        expected = harmonic_coefficients(whole, 40, elevation_deg=(-90, 90), quadrature=quadrature)
        found = harmonic_coefficients(VIEWS, 40, unseen=0.3, quadrature=quadrature)
        assert_allclose(found, expected, atol=1e-13)


def test_batch_is_loop_to_the_bit():
    many = RNG.random((130, 105, 360))  # more than are worked on at once
    together = harmonic_amplitudes(many)
    assert together.shape == (130, 120)
    assert_array_equal(together[[0, 65, 66, 129]], [harmonic_amplitudes(view) for view in many[[0, 65, 66, 129]]])
    assert harmonic_amplitudes(many[:0]).shape == (0, 120)
    assert_array_equal(sphere_amplitudes(NOISE, RING, 20)[1, 2], sphere_amplitudes(NOISE[1, 2], RING, 20))
    assert_array_equal(sphere_amplitudes(NOISE.reshape(2, 3, 800), RING, 20), sphere_amplitudes(NOISE, RING, 20))
    points = RNG.random((2, 3, 500))
    found = sphere_amplitudes(points, fibonacci(500), 9)
    assert_allclose(found[1, 2], sphere_amplitudes(points[1, 2], fibonacci(500), 9), rtol=1e-13)


def test_threads_change_nothing():
    many = RNG.random((40, 35, 120))
    with ThreadPoolExecutor(4) as threads:
        apart = np.concatenate(list(threads.map(lambda part: harmonic_coefficients(part, 60), np.split(many, 20))))
    assert_array_equal(apart, harmonic_coefficients(many, 60))


def test_bytes_count_as_zero_to_one_and_input_is_left_alone():
    grey = RNG.integers(0, 256, (2, 35, 120), np.uint8)
    before = grey.copy()
    assert_allclose(harmonic_amplitudes(grey, 60), harmonic_amplitudes(grey / 255, 60), atol=1e-13)
    floats = grey / 255
    harmonic_amplitudes(floats, 60, unseen=0.5)
    assert_array_equal(grey, before)
    assert_array_equal(floats, before / 255)


# Skies.


def test_thesis_points_alias_as_much_as_their_number_says():
    # Plain sums over n points of weight w: Σ c² is w² Σ f² L²/(4π), by Unsöld's theorem, where products of different
    # points cancel. Of a harmonic on the sphere that is L²/n times its true 1: most of the power is false.
    n_degrees, degree = 120, 100
    for points, share in ((thesis("sphere"), 1.0), (thesis("hemisphere"), 0.25)):
        values = harmonic(degree, 30, points)
        power = sphere_amplitudes(values, points, n_degrees) ** 2
        assert power.sum() == pytest.approx(share * n_degrees**2 / 2000, rel=0.05)
        assert power[degree] < 0.25 * power.sum()
    rings = gauss_legendre(120)
    values = harmonic(degree, 30, rings)
    assert_allclose(sphere_amplitudes(values, rings), np.eye(120)[degree], atol=1e-12)


def sky_masks():
    """The 65 hand-made masks of skies, as a function of directions."""
    from matplotlib.image import imread

    paths = sorted((DATA / "fisheye_sky").glob("*_mask.png"))
    if not paths:
        pytest.skip(f"{DATA / 'fisheye_sky'} is missing")
    camera = fisheye((320, 320), np.pi)
    masks = [imread(path) for path in paths]
    masks = np.array([mask if mask.ndim == 2 else mask[..., 0] for mask in masks]) > 0.5

    def look(directions):
        """(mask, direction): the pixel that a direction falls in; ground below the camera's horizon."""
        place, seen = camera.project(directions)
        column, row = (np.where(seen, np.clip(axis, 0, 319), 0).astype(int) for axis in place.T)
        return masks[:, row, column] & seen

    return look


@pytest.mark.slow
@pytest.mark.data
def test_amplitudes_of_real_skies_stay_under_tilt():
    look = sky_masks()
    errors, retrieved = {}, {}
    tilts = np.deg2rad([(20, 10, 0), (100, 30, 10), (-70, 60, -20)])
    for grid in (gauss_legendre(120), gauss_legendre(241), thesis("sphere")):
        still = sphere_amplitudes(look(grid.directions), grid)
        tilted = [sphere_amplitudes(look(to_world(grid.directions, rotation_matrix(*tilt))), grid) for tilt in tilts]
        errors[grid.name] = np.median(relative_error(np.array(tilted), still), axis=-1)
        apart = np.linalg.norm(np.array(tilted)[:, :, None] - still, axis=-1)
        retrieved[grid.name] = np.mean(apart.argmin(axis=-1) == np.arange(len(still)), axis=-1)
    assert np.all(errors["gauss-legendre 120"] < 0.03)
    assert np.all(errors["gauss-legendre 241"] < 0.012)
    assert np.all(errors["thesis sphere"] > 0.04)
    assert np.all(retrieved["gauss-legendre 120"] == 1.0)
    assert np.all(retrieved["gauss-legendre 241"] == 1.0)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"n_degrees": 61}, "n_degrees is 61, expected at most 60 for 120 columns and rows 3° apart"),
        ({"n_degrees": 257}, "n_degrees is 257, expected at most 256"),
        ({"n_degrees": 2.5}, "n_degrees is 2.5, expected a whole number of at least 1"),
        ({"quadrature": "fejér"}, r"quadrature 'fejér' is unknown: .*did you mean fejer\?"),
        ({"elevation_deg": (90, -15)}, "elevation_deg goes from 90 to -15, expected the lower limit first"),
        ({"elevation_deg": (-1.6, 1.6)}, "35 rows from -1.6° to 1.6° are not rows of a sphere from pole to pole"),
        ({"elevation_deg": (-14.0, 91.0)}, "elevation_deg reaches 91, expected -90 to 90 degrees"),
        ({"unseen": np.nan}, "unseen is nan, expected finite numbers"),
        ({"views": np.zeros(5)}, r"views has shape \(5,\), expected \(\.\.\., rows, columns\)"),
        ({"views": np.full((35, 120), np.nan)}, r"views is nan at index 0, 0 \(4200 of 4200 values\)"),
        ({"views": np.zeros((35, 120), complex)}, "views hold complex128 values"),
    ],
)
def test_bad_panoramas_are_refused_in_a_sentence(change, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        harmonic_amplitudes(**({"views": VIEWS, "n_degrees": 60} | change))


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: sphere_amplitudes(NOISE, RING, 21),
            "n_degrees is 21, expected at most 20 for 40 columns and rows 8.7",
        ),
        (
            lambda: sphere_amplitudes(NOISE[..., :39], RING, 5),
            r"values have shape \(2, 3, 20, 39\), expected \(..., 800\) or \(..., 20, 40\), as the grid gauss-legend",
        ),
        (
            lambda: sphere_amplitudes(np.zeros(1999), thesis(), 5),
            r"values have shape \(1999,\), expected \(..., 2000\), as the grid thesis hemisphere",
        ),
        (lambda: sphere_amplitudes(np.full(800, np.nan), RING, 5), "views is nan at index 0, 0"),
        (
            lambda: sphere_amplitudes(np.zeros(800), replace(fibonacci(800), shape=(20, 40)), 5),
            "the grid fibonacci 800 has a shape, expected rows of equal elevation",
        ),
    ],
)
def test_values_that_do_not_fit_a_grid_are_refused(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
