from fractions import Fraction

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import zernike_oracle
from insectnav.checks import InputError
from insectnav.vision.descriptors import radial_polynomials, zernike_pairs, zernike_weights


def test_pairs_of_the_first_orders():
    n, m = zernike_pairs(4)
    assert_array_equal(n, [0, 1, 2, 2, 3, 3, 4, 4, 4])
    assert_array_equal(m, [0, 1, 0, 2, 1, 3, 0, 2, 4])


@pytest.mark.data
def test_pairs_are_those_of_published_code(golden):
    arrays = golden("ant_world_views")
    n, m = zernike_pairs(16)
    assert_array_equal(n, arrays["n"])
    assert_array_equal(m, arrays["m"])


@pytest.mark.parametrize(
    ("n", "m", "polynomial"),
    [
        (0, 0, [1]),
        (1, 1, [0, 1]),
        (2, 0, [-1, 0, 2]),
        (2, 2, [0, 0, 1]),
        (3, 1, [0, -2, 0, 3]),
        (4, 0, [1, 0, -6, 0, 6]),
        (4, 2, [0, 0, -3, 0, 4]),
        (5, 1, [0, 3, 0, -12, 0, 10]),
        (6, 0, [-1, 0, 12, 0, -30, 0, 20]),
        (6, 2, [0, 0, 6, 0, -20, 0, 15]),
        (7, 3, [0, 0, 0, 10, 0, -30, 0, 21]),
        (8, 0, [1, 0, -20, 0, 90, 0, -140, 0, 70]),
    ],
)
def test_low_orders_are_as_in_the_tables(n, m, polynomial):
    radius = np.linspace(0, 1, 21)
    column = list(zip(*zernike_pairs(8), strict=True)).index((n, m))
    assert_allclose(
        radial_polynomials(8, radius)[:, column],
        np.polynomial.polynomial.polyval(radius, polynomial),
        rtol=0,
        atol=1e-14,
    )


@pytest.mark.parametrize("order", [20, 35, 50])
def test_high_orders_are_exact(order):
    n, m = zernike_pairs(50)
    numerators = np.arange(0, 211, 15)
    values = radial_polynomials(50, numerators / 210)
    for pair in np.flatnonzero(n == order):
        exact = [float(zernike_oracle.radial_value(order, int(m[pair]), Fraction(int(k), 210))) for k in numerators]
        assert_allclose(values[:, pair], exact, rtol=0, atol=1e-13)


def test_they_are_jacobi_polynomials():
    from scipy.special import eval_jacobi

    radius, (n, m) = np.linspace(0, 1, 33)[:, None], zernike_pairs(50)
    k = (n - m) // 2
    expected = (-1.0) ** k * radius**m * eval_jacobi(k, m, 0, 1 - 2 * radius**2)
    assert_allclose(radial_polynomials(50, radius[:, 0]), expected, rtol=0, atol=1e-12)


def test_they_are_orthogonal():
    nodes, weights = np.polynomial.legendre.leggauss(60)  # exact to degree 119
    radius = (nodes + 1) / 2
    values, (n, m) = radial_polynomials(50, radius), zernike_pairs(50)
    gram = values.T @ (values * (radius * weights / 2)[:, None])
    same_wave = m[:, None] == m
    expected = np.diag(1 / (2 * (n + 1.0)))
    assert_allclose(gram[same_wave], expected[same_wave], rtol=0, atol=1e-14)


def test_rim_centre_and_any_shape():
    n, m = zernike_pairs(50)
    assert_allclose(radial_polynomials(50, 1.0), 1.0, rtol=0, atol=1e-12)
    assert_array_equal(radial_polynomials(50, 0.0), np.where(m == 0, (-1.0) ** (n // 2), 0.0))
    radius = np.linspace(0, 1, 6)
    assert_array_equal(
        radial_polynomials(9, radius.reshape(2, 3)),
        radial_polynomials(9, radius).reshape(2, 3, len(zernike_pairs(9)[0])),
    )


def test_weights():
    n, m = zernike_pairs(16)
    assert_array_equal(zernike_weights(16, "raw"), np.ones(81))
    stone = zernike_weights(16, "stone")
    assert_array_equal(stone[m > 0], (n + 1)[m > 0])
    assert_array_equal(2 * stone[m == 0], (n + 1)[m == 0])
    assert_allclose(zernike_weights(16, "orthonormal") ** 2, n + 1, rtol=1e-15)


@pytest.mark.parametrize("order", [-1, 51, 2.5, True, "many"])
def test_bad_orders_are_refused(order):
    with pytest.raises(InputError, match="Zernike order is"):
        zernike_pairs(order)


def test_other_bad_input_is_refused():
    with pytest.raises(InputError, match=r"radius reaches 1\.2, expected 0 to 1"):
        radial_polynomials(4, [0.5, 1.2])
    with pytest.raises(InputError, match=r"Zernike weights 'stones' is unknown.*did you mean stone"):
        zernike_weights(4, "stones")
