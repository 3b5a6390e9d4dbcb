"""Elementary functions of lanes, in single and double precision.

One sequence of correctly rounded operations each, so the bits are the same on every machine. Their errors are measured
in tests/lanes/test_functions.py.
"""

import math
from typing import Any

from numba import types
from numba.extending import overload

from insectnav.lanes.compiled import lane_function
from insectnav.lanes.vector import as_bits, floor, fma, from_bits, horner, maximum, minimum, to_real

TWO_PI = 2.0 * math.pi
INVERSE_TWO_PI = 1.0 / TWO_PI
LN_2 = math.log(2.0)

# Single precision: Chebyshev interpolation over the reduced range; largest error below 1e-7 of the function's scale.
EXP2_SINGLE = (1.0000000754549, 0.6931471880262, 0.2402210748531, 0.0555035711422, 0.0096760319183, 0.0013390863365)
SIN_SINGLE = (0.9999999956988, -0.1666665794785, 0.0083330501707, -0.0001980901742, 2.6051076353e-6)
COS_SINGLE = (0.9999999530275, -0.4999990477779, 0.0416635731602, -0.0013853629536, 2.31524166600e-5)
# Double precision: Taylor series (Abramowitz & Stegun 1964, 4.2.1, 4.3.65, 4.3.66) to below 1e-17.
EXP2_DOUBLE = tuple(LN_2**k / math.factorial(k) for k in range(14))
SIN_DOUBLE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(11))
COS_DOUBLE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(12))
# (ln(1 + m) − m) / m² on √½ − 1 … √2 − 1: Chebyshev interpolation of degree 7, relative error of ln below 6e-8.
LOG_SINGLE = (
    -0.499999971, 0.333336706, -0.250011477, 0.199720497, -0.165884885, 0.148347868, -0.14159647, 0.0878726549,
)  # fmt: skip
ATANH_DOUBLE = tuple(2.0 / (2 * k + 1) for k in range(12))

SQRT_HALF_BITS_SINGLE = 0x3F3504F3
SQRT_HALF_BITS_DOUBLE = 0x3FE6A09E667F3BCD


def _for_precision(single: Any, double: Any) -> Any:
    """A numba function that is ``single`` for single precision lanes and ``double`` for double precision ones."""

    def stub(x):
        raise TypeError("lanes exist in compiled kernels only")

    @overload(stub, jit_options={"error_model": "numpy", "forceinline": True})
    def choose(x):
        return single if x.dtype == types.float32 else double

    return stub


def _exp2_single(x):
    x = minimum(maximum(x, -126.0), 127.0)
    shifted = x + 12582912.0  # 1.5 · 2^23: the lowest bits now hold the nearest integer
    rest = x - (shifted - 12582912.0)
    return from_bits(as_bits(horner(rest, EXP2_SINGLE)) + (as_bits(shifted) << 23))


def _exp2_double(x):
    x = minimum(maximum(x, -1022.0), 1023.0)
    shifted = x + 6755399441055744.0  # 1.5 · 2^52
    rest = x - (shifted - 6755399441055744.0)
    return from_bits(as_bits(horner(rest, EXP2_DOUBLE)) + (as_bits(shifted) << 52))


exp2 = _for_precision(_exp2_single, _exp2_double)


def _log_single(x):
    """Natural logarithm of normal positive numbers."""
    offset = as_bits(x) - SQRT_HALF_BITS_SINGLE
    mantissa = (offset & 0x7FFFFF) + SQRT_HALF_BITS_SINGLE
    m = from_bits(mantissa) - 1.0
    power = to_real(as_bits(x) - mantissa, x) * (1.0 / 0x800000)
    return fma(power, LN_2, fma(m * m, horner(m, LOG_SINGLE), m))


def _log_double(x):
    """Natural logarithm of normal positive numbers."""
    offset = as_bits(x) - SQRT_HALF_BITS_DOUBLE
    mantissa = (offset & 0xFFFFFFFFFFFFF) + SQRT_HALF_BITS_DOUBLE
    m = from_bits(mantissa) - 1.0
    power = to_real(as_bits(x) - mantissa, x) * (1.0 / 0x10000000000000)
    s = m / (m + 2.0)
    return fma(power, LN_2, s * horner(s * s, ATANH_DOUBLE))


log = _for_precision(_log_single, _log_double)


def _sin_cos_single(x):
    half = 0.5 * x
    square = half * half
    sine = half * horner(square, SIN_SINGLE)
    cosine = horner(square, COS_SINGLE)
    return 2.0 * sine * cosine, fma(-2.0 * sine, sine, 1.0)


def _sin_cos_double(x):
    half = 0.5 * x
    square = half * half
    sine = half * horner(square, SIN_DOUBLE)
    cosine = horner(square, COS_DOUBLE)
    return 2.0 * sine * cosine, fma(-2.0 * sine, sine, 1.0)


sin_cos = _for_precision(_sin_cos_single, _sin_cos_double)  # of angles in −π … π, by the half angle


@lane_function
def sigmoid_base_2(x):
    """1 / (1 + 2^(−x)): the logistic function of x ln 2."""
    return 1.0 / (1.0 + exp2(-x))


@lane_function
def clip_to_unit(x):
    """The nearest number in 0 … 1."""
    return minimum(maximum(x, 0.0), 1.0)


@lane_function
def wrap(angle):
    """The same angle in −π … π."""
    return fma(floor(fma(angle, INVERSE_TWO_PI, 0.5)), -TWO_PI, angle)
