import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import sph_harm_y

from insectnav.checks import InputError
from insectnav.vision.descriptors import amplitude_spectrum, harmonic_pairs, real_harmonics
from insectnav.vision.descriptors.harmonic_basis import fejer_weights
from insectnav.vision.sphere import directions, fibonacci, gauss_legendre


def scipy_harmonic(degree, order, azimuth, elevation):
    """Y_lm of Eq. 1 of the paper, by SciPy's complex ones, which bear the sign (−1)^m."""
    value = sph_harm_y(degree, abs(order), np.pi / 2 - elevation, azimuth) * (-1.0) ** order
    return value.real if order == 0 else np.sqrt(2) * (value.real if order > 0 else value.imag)


@pytest.mark.parametrize(
    ("degree", "order"), [(0, 0), (1, -1), (1, 0), (1, 1), (7, -4), (59, 3), (119, 0), (119, 119), (119, -60), (255, 9)]
)
def test_values_are_those_of_scipy(degree, order):
    rng = np.random.default_rng(0)
    azimuth, elevation = rng.uniform(-np.pi, np.pi, 200), np.arcsin(rng.uniform(-1, 1, 200))
    elevation[:3] = np.pi / 2, -np.pi / 2, 0.0
    found = real_harmonics(degree + 1, directions(azimuth, elevation))
    assert_allclose(found[:, degree**2 + degree + order], scipy_harmonic(degree, order, azimuth, elevation), atol=2e-12)


def test_first_ones_in_words():
    x, y, z = np.eye(3)
    found = real_harmonics(2, [x, y, z])  # right, ahead, up
    slope = np.sqrt(3 / (4 * np.pi))
    expected = np.column_stack([np.full(3, np.sqrt(1 / (4 * np.pi))), slope * np.array([x, z, y]).T])
    assert_allclose(found, expected, atol=1e-16)


def test_they_are_orthonormal():
    grid = gauss_legendre(24)
    values = real_harmonics(24, grid.directions)
    assert_allclose(values.T @ (values * grid.weights[:, None]), np.eye(576), atol=2e-13)


@settings(max_examples=20, deadline=None)
@given(azimuth=st.floats(-3.1, 3.1), elevation=st.floats(-1.57, 1.57))
def test_sum_of_squares_of_a_degree_is_the_same_everywhere(azimuth, elevation):
    # Unsöld's theorem
    amplitudes = amplitude_spectrum(real_harmonics(150, directions(azimuth, elevation)))
    assert_allclose(amplitudes**2, (2 * np.arange(150) + 1) / (4 * np.pi), rtol=1e-11)


def test_order_of_the_pairs():
    degree, order = harmonic_pairs(3)
    assert_array_equal(degree, [0, 1, 1, 1, 2, 2, 2, 2, 2])
    assert_array_equal(order, [0, -1, 0, 1, -2, -1, 0, 1, 2])


def test_amplitude_spectrum_of_batches():
    coefficients = np.arange(18).reshape(2, 9)
    expected = [[0, np.sqrt(1 + 4 + 9), np.sqrt(16 + 25 + 36 + 49 + 64)]]
    assert_allclose(amplitude_spectrum(coefficients)[:1], expected, rtol=1e-15)
    assert amplitude_spectrum(np.zeros((4, 0, 9))).shape == (4, 0, 3)


@pytest.mark.parametrize("n", [1, 2, 7, 60, 61])
def test_fejer_weights_integrate_polynomials(n):
    height = np.cos((np.arange(n) + 0.5) * np.pi / n)
    for power in range(n):
        expected = 2 / (power + 1) if power % 2 == 0 else 0.0
        assert_allclose(fejer_weights(n) @ height**power, expected, atol=1e-14)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: harmonic_pairs(0), "n_degrees is 0, expected a whole number of at least 1"),
        (lambda: harmonic_pairs(257), "n_degrees is 257, expected at most 256"),
        (lambda: real_harmonics(4, np.ones((2, 3))), "directions has a vector of length 1.732"),
        (lambda: amplitude_spectrum(np.zeros((3, 8))), r"coefficients have shape \(3, 8\), expected L² of them"),
        (lambda: amplitude_spectrum(1.0), r"coefficients have shape \(\), expected L²"),
        (lambda: amplitude_spectrum([np.nan]), "coefficients is nan at index 0"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()


def test_points_anywhere_may_be_asked_for():
    assert real_harmonics(5, fibonacci(60).directions.reshape(3, 20, 3)).shape == (3, 20, 25)
