import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

from insectnav.angles import bearing, circular_mean, circular_std, from_math, to_math, unit_vector, wrap

PI = np.pi
COMPASS = [  # heading, x, y: north, north-east, east, south-east, south, west
    (0.0, 0.0, 1.0),
    (PI / 4, np.sqrt(0.5), np.sqrt(0.5)),
    (PI / 2, 1.0, 0.0),
    (3 * PI / 4, np.sqrt(0.5), -np.sqrt(0.5)),
    (-PI, 0.0, -1.0),
    (-PI / 2, -1.0, 0.0),
]
angle = st.floats(-1e6, 1e6)


def turn_between(a, b):
    """Size of the turn from a to b, from the chord between the two unit vectors."""
    return 2 * np.arcsin(np.minimum(np.hypot(np.sin(a) - np.sin(b), np.cos(a) - np.cos(b)) / 2, 1))


@pytest.mark.parametrize(
    ("given_angle", "expected"),
    [
        (0.0, 0.0),
        (PI, -PI),
        (-PI, -PI),
        (np.nextafter(PI, 4), -PI),
        (np.nextafter(-PI, -4), np.nextafter(PI, 0)),
        (3 * PI / 2, -PI / 2),
        (-3 * PI / 2, PI / 2),
        (2 * PI, 0.0),
        (1e-20, 1e-20),
        (3, 3.0),
    ],
)
def test_wrap_at_single_angles(given_angle, expected):
    assert_allclose(wrap(given_angle), expected, rtol=0, atol=1e-15)


def test_wrap_keeps_what_is_in_the_interval_to_the_last_bit():
    angles = np.array([-PI, -3.0, -1e-300, 0.0, 1e-20, 0.1, np.nextafter(PI, 0)])
    assert_array_equal(wrap(angles), angles)


@given(angle)
def test_wrap_keeps_the_direction_and_stays_in_the_interval(value):
    wrapped = wrap(value)
    assert -PI <= wrapped < PI
    assert turn_between(wrapped, value) < 1e-9


@given(st.floats(-100, 100, width=32))
def test_wrap_stays_in_the_interval_of_float32(value):
    wrapped = wrap(np.float32(value))
    assert wrapped.dtype == np.float32
    assert np.float32(-PI) <= wrapped < np.float32(PI)


def test_wrap_passes_missing_values_on():
    assert np.isnan(wrap([np.nan, 1.0])).tolist() == [True, False]


@pytest.mark.parametrize(("heading", "x", "y"), COMPASS)
def test_unit_vector_and_bearing_on_the_compass(heading, x, y):
    assert_allclose(unit_vector(heading), [x, y], atol=1e-15)
    assert_allclose(bearing([5 * x, 5 * y]), heading, atol=1e-15)


@given(angle)
def test_bearing_inverts_unit_vector(value):
    assert turn_between(bearing(unit_vector(value)), value) < 1e-9


def test_a_positive_turn_is_to_the_right():
    ahead, turned = unit_vector(0.3), unit_vector(0.3 + 0.1)
    right_of_ahead = np.array([ahead[1], -ahead[0]])
    assert turned @ right_of_ahead == pytest.approx(np.sin(0.1))


@pytest.mark.parametrize("null", [[0.0, 0.0], [-0.0, -0.0], [0.0, -0.0]])
def test_bearing_of_the_null_vector_is_0(null):
    assert bearing(null) == 0


def test_bearing_straight_back_is_minus_pi():
    assert_array_equal(bearing([[0.0, -1.0], [-0.0, -1.0]]), [-PI, -PI])


@pytest.mark.parametrize(
    ("angles", "expected"),
    [
        ([0.1, -0.1], 0.0),
        ([PI - 0.1, -PI + 0.3], -PI + 0.1),  # across the seam
        ([0.0, PI / 2], PI / 4),
        ([2.0], 2.0),
    ],
)
def test_circular_mean_by_hand(angles, expected):
    assert turn_between(circular_mean(angles), expected) < 1e-12


@pytest.mark.parametrize(
    ("angles", "length"),
    [([0.0, PI / 2], np.sqrt(0.5)), ([0.0, 0.0, PI], 1 / 3), ([1.0 - PI / 3, 1.0 + PI / 3], 0.5)],
)
def test_circular_std_by_hand(angles, length):
    assert_allclose(circular_std(angles), np.sqrt(-2 * np.log(length)), rtol=1e-12)


def test_circular_std_of_equal_angles_is_0_and_of_opposite_ones_is_large():
    assert circular_std(np.full(50, 0.3)) < 1e-7
    assert circular_std([0.0, PI]) > 8


def test_circular_statistics_agree_with_scipy_along_each_axis():
    angles = np.random.default_rng(0).vonmises(2.9, 1.5, size=(4, 60))
    for axis, values in ((-1, angles), (0, angles.T)):
        assert_allclose(circular_std(values, axis=axis), stats.circstd(angles, axis=-1), rtol=1e-12)
        assert turn_between(circular_mean(values, axis=axis), stats.circmean(angles, axis=-1)).max() < 1e-12


@given(st.lists(st.floats(-PI, PI), min_size=1, max_size=20), angle)
def test_turning_all_angles_leaves_their_spread(angles, turn):
    r = abs(np.mean(np.exp(1j * np.array(angles))))
    if r > 1e-3:
        turned = circular_std(np.array(angles) + turn)
        assert turned == pytest.approx(circular_std(angles), abs=1e-4)


@pytest.mark.parametrize(
    ("mathematical", "heading"),
    [(0.0, PI / 2), (PI / 2, 0.0), (PI, -PI / 2), (-PI / 2, -PI), (PI / 4, PI / 4), (3 * PI / 4, -PI / 4)],
)
def test_conversion_from_and_to_mathematical_angles(mathematical, heading):
    assert_allclose(from_math(mathematical), heading, atol=1e-15)
    assert turn_between(to_math(heading), mathematical) < 1e-15


@given(angle)
def test_a_mathematical_angle_points_the_same_way(value):
    assert_allclose(unit_vector(from_math(value)), [np.cos(value), np.sin(value)], atol=1e-9)
    assert turn_between(to_math(from_math(value)), value) < 1e-9


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_dtype_and_leading_axes_are_kept(dtype):
    angles = np.linspace(-9, 9, 24, dtype=dtype).reshape(2, 3, 4)
    vectors = unit_vector(angles)
    for result, shape in (
        (wrap(angles), (2, 3, 4)),
        (vectors, (2, 3, 4, 2)),
        (bearing(vectors), (2, 3, 4)),
        (circular_mean(angles), (2, 3)),
        (circular_std(angles), (2, 3)),
        (from_math(angles), (2, 3, 4)),
        (to_math(angles), (2, 3, 4)),
    ):
        assert result.dtype == dtype
        assert result.shape == shape
