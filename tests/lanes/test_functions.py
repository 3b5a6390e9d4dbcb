"""Errors of the elementary functions of lanes, against extended precision.

The bounds are what the package promises: a few units in the last place, so that neither precision costs the circuit
more than rounding its rates does.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel
from insectnav.lanes.functions import clip_to_unit, exp2, log, sigmoid_base_2, sin_cos, wrap
from insectnav.lanes.vector import address, load, store

PRECISIONS = ("float32", "float64")
FUNCTIONS = ("exp2", "log", "sine", "cosine", "sigmoid", "clip", "wrapped")
ERROR = {"float32": 3e-7, "float64": 1e-15}  # absolute where the function is of order 1, otherwise relative
COSINE_ERROR = {"float32": 6e-7, "float64": 1.2e-15}  # 1 - 2 sin² of the half angle: the worst of all, close to ±π
N_DENSE = 20_000
TWO_PI = 8 * np.arctan(np.longdouble(1))


@kernel
def evaluate(x, results):
    """Every function of the rows of ``x`` (n, LANES), into ``results`` (7 n, LANES)."""
    n, at, out = x.shape[0], address(x), address(results)
    for row in range(n):
        value = load(at, row)
        sine, cosine = sin_cos(value)
        store(out, row, exp2(value))
        store(out, row + n, log(value))
        store(out, row + 2 * n, sine)
        store(out, row + 3 * n, cosine)
        store(out, row + 4 * n, sigmoid_base_2(value))
        store(out, row + 5 * n, clip_to_unit(value))
        store(out, row + 6 * n, wrap(value))


def values_of(function: str, x: np.ndarray) -> np.ndarray:
    """``function`` of a vector ``x``, in its precision."""
    padded = np.resize(x, (-(-x.size // LANES), LANES))
    results = np.empty((len(FUNCTIONS), *padded.shape), x.dtype)
    evaluate(padded, results.reshape(-1, LANES))
    return results[FUNCTIONS.index(function)].reshape(-1)[: x.size]


def dense(low: float, high: float, precision: str) -> np.ndarray:
    return np.linspace(low, high, N_DENSE).astype(precision)


def vectors(low: float, high: float, precision: str) -> st.SearchStrategy[np.ndarray]:
    width = 32 if precision == "float32" else 64
    low, high = float(np.dtype(precision).type(low)), float(np.dtype(precision).type(high))
    return arrays(precision, LANES, elements=st.floats(low, high, width=width))


def relative_error(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.max(np.abs(found - exact) / np.abs(exact)))


def absolute_error(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.max(np.abs(found - exact)))


def log_error(x: np.ndarray) -> float:
    """Relative error of the logarithm; where that is 0, of the absolute one."""
    exact = np.log(x.astype(np.longdouble))
    return relative_error(values_of("log", x) + (exact == 0), exact + (exact == 0))


def circle_error(found: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Distance along the circle between an angle and what became of it."""
    rest = (found.astype(np.longdouble) - angle) / TWO_PI
    return np.abs(rest - np.round(rest)) * TWO_PI


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(("low", "high"), [(-1, 1), (-30, 30), (-126, 127)])
def test_exp2_is_right_to_a_few_last_places(precision: str, low: float, high: float) -> None:
    x = dense(low, high, precision)
    assert relative_error(values_of("exp2", x), np.exp2(x.astype(np.longdouble))) < ERROR[precision]


def test_exp2_in_double_precision_covers_its_whole_range() -> None:
    x = dense(-1022, 1023, "float64")
    assert relative_error(values_of("exp2", x), np.exp2(x.astype(np.longdouble))) < ERROR["float64"]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_exp2_of_whole_numbers_is_a_power_of_two(precision: str) -> None:
    x = np.arange(-126, 128).astype(precision)
    rounding = {"float32": 2e-7, "float64": 0}[precision]  # the single precision polynomial is not exact at 0
    np.testing.assert_allclose(values_of("exp2", x), np.exp2(x.astype("float64")), rtol=rounding)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(("low", "high"), [(0.5, 2), (1e-3, 1e3)])
def test_log_is_right_to_a_few_last_places(precision: str, low: float, high: float) -> None:
    assert log_error(dense(low, high, precision)) < ERROR[precision]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_log_keeps_its_relative_error_near_one_and_far_away(precision: str) -> None:
    smallest = np.finfo(precision).tiny
    steps = np.arange(-200, 201) * np.finfo(precision).eps
    near_one = (1 + steps).astype(precision)
    far = np.geomspace(smallest, 1 / (4 * smallest), N_DENSE).astype(precision)
    assert log_error(near_one) < ERROR[precision]
    assert log_error(far) < ERROR[precision]
    assert values_of("log", np.ones(LANES, precision)).tolist() == [0] * LANES


@pytest.mark.parametrize("precision", PRECISIONS)
def test_sine_and_cosine_are_right_over_the_circle(precision: str) -> None:
    x = dense(-np.pi, np.pi, precision)
    exact = x.astype(np.longdouble)
    assert absolute_error(values_of("sine", x), np.sin(exact)) < ERROR[precision]
    assert absolute_error(values_of("cosine", x), np.cos(exact)) < COSINE_ERROR[precision]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_sine_is_odd_and_cosine_even_to_the_last_bit(precision: str) -> None:
    x = dense(-np.pi, np.pi, precision)
    np.testing.assert_array_equal(values_of("sine", -x), -values_of("sine", x))
    np.testing.assert_array_equal(values_of("cosine", -x), values_of("cosine", x))
    assert values_of("sine", np.zeros(LANES, precision)).tolist() == [0] * LANES


@pytest.mark.parametrize("precision", PRECISIONS)
def test_sigmoid_is_right_to_a_few_last_places(precision: str) -> None:
    x = dense(-100, 100, precision)
    exact = 1 / (1 + np.exp2(-x.astype(np.longdouble)))
    assert relative_error(values_of("sigmoid", x), exact) < ERROR[precision]
    assert absolute_error(values_of("sigmoid", x), exact) < ERROR[precision]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_sigmoid_is_half_at_zero_and_its_mirror_images_add_up_to_one(precision: str) -> None:
    x = dense(0, 40, precision)
    assert absolute_error(values_of("sigmoid", x) + values_of("sigmoid", -x), np.ones(x.size)) < ERROR[precision]
    assert absolute_error(values_of("sigmoid", np.zeros(LANES, precision)), np.full(LANES, 0.5)) < ERROR[precision]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_wrapped_angle_is_the_same_angle_in_the_first_turn(precision: str) -> None:
    x = dense(-30, 30, precision)
    wrapped = values_of("wrapped", x)
    n_turns = np.abs(np.round(x / (2 * np.pi)))  # 2π is off by half a last place each
    assert np.all(circle_error(wrapped, x) < ERROR[precision] * (1 + n_turns))
    assert np.all(np.abs(wrapped.astype(np.longdouble)) <= np.pi * (1 + 4 * np.finfo(precision).eps))


@pytest.mark.parametrize("precision", PRECISIONS)
def test_angle_within_the_first_turn_comes_back_unchanged(precision: str) -> None:
    x = dense(-3.14159, 3.14159, precision)
    np.testing.assert_array_equal(values_of("wrapped", x), x)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("extreme", [126.5, 1e3, 2000.0, 1e6, 1e30, np.inf])
def test_extremes_saturate(precision: str, extreme: float) -> None:
    x = np.array([extreme, -extreme], precision)
    large, small = values_of("exp2", x)
    assert np.isfinite(large)
    assert large >= 2.0**126
    assert 0 <= small <= 2.0**-125
    one, nothing = values_of("sigmoid", x)
    assert one == 1
    assert 0 <= nothing <= 2.0**-125


@pytest.mark.parametrize("precision", PRECISIONS)
def test_clip_gives_the_nearest_number_of_the_unit_interval(precision: str) -> None:
    x = np.array([-np.inf, -1e30, -1e-30, 0, 1e-30, 0.3, 1, 1 + 1e-6, 1e30, np.inf], precision)
    np.testing.assert_array_equal(values_of("clip", x), np.clip(x, 0, 1))


@pytest.mark.parametrize("precision", PRECISIONS)
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_no_drawn_number_is_worse_than_the_dense_ones(precision: str, data: st.DataObject) -> None:
    bound = ERROR[precision]
    x = data.draw(vectors(-126, 127, precision))
    exact = x.astype(np.longdouble)
    assert relative_error(values_of("exp2", x), np.exp2(exact)) < bound
    assert absolute_error(values_of("sigmoid", x), 1 / (1 + np.exp2(-exact))) < bound
    assert log_error(data.draw(vectors(np.finfo(precision).tiny, np.finfo(precision).max, precision))) < bound
    angle = data.draw(vectors(-3.1415925, 3.1415925, precision))
    assert absolute_error(values_of("sine", angle), np.sin(angle.astype(np.longdouble))) < bound
    assert absolute_error(values_of("cosine", angle), np.cos(angle.astype(np.longdouble))) < COSINE_ERROR[precision]
    far = data.draw(vectors(-100, 100, precision))
    assert np.all(circle_error(values_of("wrapped", far), far) < bound * (1 + np.abs(far) / 6))


def test_precision_of_the_result_is_that_of_the_argument() -> None:
    x = np.linspace(0.1, 0.9, LANES)
    for function in ("exp2", "log", "sine", "cosine", "sigmoid"):
        single, double = values_of(function, x.astype("float32")), values_of(function, x)
        assert np.any(single.astype("float64") != double), function
        np.testing.assert_allclose(single, double, rtol=5e-7, atol=0, err_msg=function)
