"""The vector type of compiled kernels: what each operation gives, and that it stays in its precision."""

from fractions import Fraction

import numpy as np
import pytest
from numba.core.errors import TypingError

from insectnav.lanes import LANES, empty_rows
from insectnav.lanes.compiled import kernel
from insectnav.lanes.vector import (
    address,
    as_bits,
    fill,
    floor,
    fma,
    from_bits,
    horner,
    load,
    maximum,
    minimum,
    square_root,
    store,
    to_real,
)

REALS = ("float32", "float64")
COEFFICIENTS = (0.1, -0.7, 0.3, 1.1)


@kernel
def copy_rows(source, target):
    at, out = address(source), address(target)
    for row in range(source.shape[0]):
        store(out, row, load(at, row))


@kernel
def mix_with_scalars(source, target):
    at, out = address(source), address(target)
    x = load(at, 0)
    store(out, 0, 0.1 * x)
    store(out, 1, x * 0.1 * 0.3)
    store(out, 2, x + 1)
    store(out, 3, 0.7 - x)
    store(out, 4, x / 3)
    store(out, 5, 1.0 / x)
    store(out, 6, -x)
    store(out, 7, 0.1 * x - 0.3 * (x + 0.7))
    store(out, 8, minimum(x, 0.1))
    store(out, 9, maximum(0.1, x))


@kernel
def fuse(source, target):
    at, out = address(source), address(target)
    x, y = load(at, 0), load(at, 1)
    store(out, 0, fma(x, y, 0.1))
    store(out, 1, fma(-x, 0.3, y))
    store(out, 2, horner(x, COEFFICIENTS))


@kernel
def apply_functions(source, target):
    at, out = address(source), address(target)
    x, y = load(at, 0), load(at, 1)
    store(out, 0, square_root(maximum(x, 0.0)))
    store(out, 1, floor(x))
    store(out, 2, minimum(x, y))
    store(out, 3, maximum(x, y))
    store(out, 4, from_bits(as_bits(x)))
    store(out, 5, fill(0.1, x))
    store(out, 6, 0.1)
    store(out, 7, 3)


@kernel
def combine_words(source, target):
    at, out = address(source), address(target)
    a, b = load(at, 0), load(at, 1)
    store(out, 0, a + b)
    store(out, 1, a - b)
    store(out, 2, a * b)
    store(out, 3, a ^ b)
    store(out, 4, a & b)
    store(out, 5, a | b)
    store(out, 6, a << 7)
    store(out, 7, a >> 25)
    store(out, 8, a >> 1)


@kernel
def words_to_real(source, like, target):
    store(address(target), 0, to_real(load(address(source), 0), load(address(like), 0)))


@kernel
def add_two_kinds(source, other, target):
    store(address(target), 0, load(address(source), 0) + load(address(other), 0))


def sample(dtype: str, n_rows: int = 1, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 3, (n_rows, LANES)).astype(dtype)


def words(dtype: str = "uint32", seed: int = 0) -> np.ndarray:
    bits = np.random.default_rng(seed).integers(0, 2**32, (2, LANES), np.uint32)
    bits[0, :4] = 0, 2**31, 2**32 - 1, 2**31 - 1
    return bits.view(dtype)


@pytest.mark.parametrize("dtype", [*REALS, "int32", "int64", "uint32", "uint64"])
def test_rows_come_back_from_lanes_bit_for_bit(dtype: str) -> None:
    size = 7 * LANES * np.dtype(dtype).itemsize
    source = np.frombuffer(np.random.default_rng(1).bytes(size), dtype).reshape(7, LANES)
    target = np.zeros_like(source)
    copy_rows(source, target)
    assert target.tobytes() == source.tobytes()


@pytest.mark.parametrize("dtype", REALS)
def test_scalars_take_the_precision_of_the_lanes(dtype: str) -> None:
    x = sample(dtype)
    found = np.empty((10, LANES), dtype)
    mix_with_scalars(x, found)
    real, x = np.dtype(dtype).type, x[0]
    expected = [
        real(0.1) * x,
        x * real(0.1) * real(0.3),
        x + real(1),
        real(0.7) - x,
        x / real(3),
        real(1) / x,
        -x,
        real(0.1) * x - real(0.3) * (x + real(0.7)),
        np.minimum(x, real(0.1)),
        np.maximum(x, real(0.1)),
    ]
    np.testing.assert_array_equal(found, np.array(expected, dtype))


def test_single_precision_is_not_double_precision_rounded_at_the_end() -> None:
    x = sample("float32")
    found = np.empty((10, LANES), "float32")
    mix_with_scalars(x, found)
    in_double = (0.1 * x[0].astype("float64") - 0.3 * (x[0].astype("float64") + 0.7)).astype("float32")
    assert np.any(found[7] != in_double)


def is_nearest(found: np.floating, exact: Fraction) -> bool:
    """Whether no number of the same precision lies closer to the exact one."""
    error = abs(Fraction(float(found)) - exact)
    infinity = type(found)(np.inf)
    neighbours = np.nextafter(found, infinity), np.nextafter(found, -infinity)
    return all(error <= abs(Fraction(float(neighbour)) - exact) for neighbour in neighbours)


@pytest.mark.parametrize("dtype", REALS)
def test_fused_multiply_add_is_rounded_once(dtype: str) -> None:
    source = sample(dtype, 2)
    found = np.empty((3, LANES), dtype)
    fuse(source, found)
    tenth, three_tenths = (Fraction(float(np.dtype(dtype).type(number))) for number in (0.1, 0.3))
    for lane in range(LANES):
        x, y = (Fraction(float(row[lane])) for row in source)
        assert is_nearest(found[0, lane], x * y + tenth)
        assert is_nearest(found[1, lane], y - x * three_tenths)
    twice_rounded = source[0] * source[1] + np.dtype(dtype).type(0.1)
    assert np.any(found[0] != twice_rounded)


@pytest.mark.parametrize("dtype", REALS)
def test_horner_sums_the_polynomial(dtype: str) -> None:
    source = sample(dtype, 2)
    found = np.empty((3, LANES), dtype)
    fuse(source, found)
    x = source[0].astype(np.longdouble)
    terms = [c * x**power for power, c in enumerate(np.array(COEFFICIENTS, dtype).astype(np.longdouble))]
    rounding = 4 * np.finfo(dtype).eps * np.sum(np.abs(terms), axis=0)
    assert np.all(np.abs(found[2] - np.sum(terms, axis=0)) < rounding)


@pytest.mark.parametrize("dtype", REALS)
def test_functions_of_lanes_are_those_of_numbers(dtype: str) -> None:
    source = sample(dtype, 2)
    source[0, :4] = 0, 2, -2, -0.5
    found = np.empty((8, LANES), dtype)
    apply_functions(source, found)
    x, y = source
    tenth = np.full(LANES, 0.1, dtype)
    expected = [
        np.sqrt(np.maximum(x, 0)),
        np.floor(x),
        np.minimum(x, y),
        np.maximum(x, y),
        x,
        tenth,
        tenth,
        np.full(LANES, 3.0, dtype),
    ]
    np.testing.assert_array_equal(found, np.array(expected, dtype))


@pytest.mark.parametrize("dtype", ["uint32", "int32"])
def test_words_are_combined_modulo_two_to_the_32(dtype: str) -> None:
    source = words(dtype)
    found = np.empty((9, LANES), dtype)
    combine_words(source, found)
    for lane in range(LANES):
        a, b = (int(word) for word in source.view("uint32")[:, lane])
        expected = [a + b, a - b, a * b, a ^ b, a & b, a | b, a << 7, a >> 25, a >> 1]
        assert found.view("uint32")[:, lane].tolist() == [word % 2**32 for word in expected]


def test_right_shift_of_negative_numbers_fills_with_zeros() -> None:
    found = np.empty((9, LANES), "int32")
    combine_words(np.full((2, LANES), -1, "int32"), found)
    assert found[8].tolist() == [2**31 - 1] * LANES


@pytest.mark.parametrize("dtype", REALS)
def test_words_become_signed_numbers(dtype: str) -> None:
    source = words()
    found = np.empty((1, LANES), dtype)
    words_to_real(source, np.zeros((1, LANES), dtype), found)
    np.testing.assert_array_equal(found[0], source[0].view("int32").astype(dtype))
    assert found[0, 1] == -(2.0**31)


def test_lanes_of_two_precisions_do_not_mix() -> None:
    with pytest.raises(TypingError):
        add_two_kinds(sample("float32"), sample("float64"), np.empty((1, LANES)))


@pytest.mark.parametrize("dtype", [*REALS, "uint32"])
@pytest.mark.parametrize("n_rows", [1, 2, 3, 105])
def test_empty_rows_start_on_cache_lines(dtype: str, n_rows: int) -> None:
    kept = [empty_rows(n_rows, dtype) for _ in range(8)]  # at once, so that they lie at different places
    for rows in kept:
        assert rows.shape == (n_rows, LANES)
        assert rows.dtype == dtype
        assert rows.flags.c_contiguous
        assert rows.flags.writeable
        assert rows.ctypes.data % 64 == 0
        assert rows.strides[0] % 64 == 0


def test_empty_rows_do_not_overlap() -> None:
    kept = [empty_rows(5, "float32") for _ in range(20)]
    for number, rows in enumerate(kept):
        rows[:] = number
    assert [set(rows.ravel()) for rows in kept] == [{number} for number in range(20)]
