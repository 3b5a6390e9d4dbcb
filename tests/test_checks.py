import numpy as np
import pytest

from insectnav.checks import (
    InputError,
    as_numbers,
    check_choice,
    check_count,
    check_finite,
    check_radians,
    check_range,
    check_shape,
    counted,
    quoted,
)

PRESETS = ("thesis", "code-2017")


def sentence(check, *arguments, **options) -> str:
    with pytest.raises(InputError) as caught:
        check(*arguments, **options)
    return str(caught.value)


def test_an_input_error_is_a_value_error():
    assert issubclass(InputError, ValueError)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plain", "'plain'"),
        ("two\nlines", r"'two\nlines'"),
        ("\u2028\x1b[31m", r"'\u2028\x1b[31m'"),
        ("\udcff", r"'\udcff'"),
        ("it's", '"it\'s"'),
        ("a" * 40, "'" + "a" * 40 + "'"),
        ("a" * 41, "'" + "a" * 39 + "…'"),
        (3, "'3'"),
    ],
)
def test_quoted_text_is_short_and_on_one_line(text, expected):
    assert quoted(text) == expected


def test_a_valid_choice_passes():
    assert check_choice("preset", "thesis", PRESETS) is None


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("thesiss", "preset 'thesiss' is unknown: expected one of thesis, code-2017 (did you mean thesis?)"),
        ("Code-2017", "preset 'Code-2017' is unknown: expected one of thesis, code-2017 (did you mean code-2017?)"),
        ("xyz", "preset 'xyz' is unknown: expected one of thesis, code-2017"),
        (7, "preset '7' is unknown: expected one of thesis, code-2017"),
        (None, "preset 'None' is unknown: expected one of thesis, code-2017"),
    ],
)
def test_an_unknown_choice_lists_the_known(value, expected):
    assert sentence(check_choice, "preset", value, PRESETS) == expected


@pytest.mark.parametrize("value", [1, 10**30, np.int32(3)])
def test_a_count_passes(value):
    assert check_count("trials", value) is None


@pytest.mark.parametrize("value", [0, -1, 1.0, 1.5, True, "3", None, np.nan])
def test_what_is_no_count_is_refused(value):
    assert sentence(check_count, "trials", value) == (
        f"trials is {quoted(value) if value in ('3', None) else value}, expected a whole number of at least 1"
    )


def test_a_count_of_zero_may_be_allowed():
    assert check_count("filled", 0, minimum=0) is None


def test_finite_numbers_pass():
    assert check_finite("x", [[1.0, -2.0], [0.0, 1e300]]) is None
    assert check_finite("x", []) is None


def test_the_first_number_that_is_not_finite_is_named():
    values = [[0.0, 1.0], [np.nan, np.inf]]
    assert sentence(check_finite, "x", values) == "x is nan at index 1, 0 (2 of 4 values), expected finite numbers"
    assert sentence(check_finite, "x", -np.inf) == "x is -inf, expected finite numbers"


@pytest.mark.parametrize("values", [["a", "b"], [True], [1 + 2j], [None]])
def test_what_is_no_number_is_refused(values):
    assert "x holds" in sentence(as_numbers, "x", values)
    assert "expected real numbers" in sentence(check_finite, "x", values)


def test_ragged_rows_are_refused():
    assert sentence(as_numbers, "x", [[1.0], [1.0, 2.0]]) == "x is ragged, expected rows of equal length"


@pytest.mark.parametrize("values", [0, 1, 0.5, [0.0, 1.0], [], np.float32(0.25)])
def test_values_in_range_pass(values):
    assert check_range("noise", values, 0, 1) is None


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (1.5, "noise is 1.5, expected 0 to 1"),
        ([0.5, 1.25, -3.0, 2.0], "noise reaches -3, expected 0 to 1"),
        (np.nan, "noise is nan, expected 0 to 1"),
        ([0.5, np.nan], "noise reaches nan, expected 0 to 1"),
        (np.array([2, 3], dtype=np.uint8), "noise reaches 3, expected 0 to 1"),
    ],
)
def test_the_worst_value_out_of_range_is_named(values, expected):
    assert sentence(check_range, "noise", values, 0, 1) == expected


def test_a_range_may_have_a_unit_a_slip_and_no_upper_end():
    message = sentence(check_range, "gap", -1, 0, np.inf, "s", "a sign too many?")
    assert message == "gap is -1, expected at least 0 s: a sign too many?"
    assert check_range("gap", np.inf, 0, np.inf) is None


@pytest.mark.parametrize("values", [0.0, [-2 * np.pi, 2 * np.pi], [np.nan, 1.0], [], np.float32(2 * np.pi)])
def test_radians_within_a_turn_pass(values):
    assert check_radians("heading", values) is None


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([0.0, 357.0, 20.0], "heading reaches 357, expected radians within ±2π: degrees?"),
        ([[0.0, np.nan], [-180.0, 20.0]], "heading reaches -180, expected radians within ±2π: degrees?"),
        (90, "heading is 90, expected radians within ±2π: degrees?"),
    ],
)
def test_radians_beyond_a_turn_are_taken_for_degrees(values, expected):
    assert sentence(check_radians, "heading", values) == expected


@pytest.mark.parametrize(
    ("shape", "pattern"),
    [
        ((5, 2), ("n", 2)),
        ((0, 2), ("n", 2)),
        ((), ()),
        ((4,), ("n",)),
        ((2,), (..., 2)),
        ((7, 6, 2), (..., 2)),
        ((7, 6), (..., "a", "b")),
    ],
)
def test_a_shape_that_fits_passes(shape, pattern):
    assert check_shape("position", np.zeros(shape), pattern) is None


@pytest.mark.parametrize(
    ("shape", "pattern", "expected"),
    [
        ((5, 3), ("n", 2), "position has shape (5, 3), expected (n, 2)"),
        ((2, 5), ("n", 2), "position has shape (2, 5), expected (n, 2): transposed?"),
        ((5,), ("n", 2), "position has shape (5,), expected (n, 2)"),
        ((5, 2), ("n",), "position has shape (5, 2), expected (n,)"),
        ((5, 3), (..., 2), "position has shape (5, 3), expected (..., 2)"),
        ((), (..., 2), "position has shape (), expected (..., 2)"),
        ((4,), (5,), "position has shape (4,), expected (5,)"),
    ],
)
def test_another_shape_is_named(shape, pattern, expected):
    assert sentence(check_shape, "position", np.zeros(shape), pattern) == expected


def test_what_is_counted_is_one_or_several():
    assert [counted(n, "frame") for n in (0, 1, 2)] == ["0 frames", "1 frame", "2 frames"]
    assert [counted(n, "query has", "queries have") for n in (1, 2)] == ["1 query has", "2 queries have"]
