"""Sums of differences between all pairs of frames, compiled."""

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.vector import address, fill, fma, load, maximum, store

Array = NDArray[Any]
TILE = 32  # references that stay in the cache while all queries of a block pass by


@intrinsic
def count_bits(typing_context: Any, word: Any) -> Any:
    """Number of ones in a 64-bit word."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return types.uint64(types.uint64), generate


@intrinsic
def add_byte_difference(typing_context: Any, total: Any, a: Any, b: Any) -> Any:
    """``total + |a − b|`` of bytes in 32 bits; numba would count in 64, half as many at a time."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        whole, *pair = arguments
        wide = [builder.zext(byte, whole.type) for byte in pair]
        apart = builder.sub(*wide)
        negative = builder.icmp_signed("<", apart, whole.type(0))
        return builder.add(whole, builder.select(negative, builder.neg(apart), apart))

    return types.int32(types.int32, types.uint8, types.uint8), generate


@kernel
def sum_byte_differences(queries: Array, references: Array, first: int, last: int, scale: float, out: Array) -> None:
    """Sum of absolute differences over ``scale``, rows ``first`` … ``last`` − 1 of (query, reference); bytes, exact."""
    for start in range(0, len(references), TILE):
        for q in range(first, last):
            for r in range(start, min(start + TILE, len(references))):
                total = np.int32(0)
                for k in range(queries.shape[1]):
                    total = add_byte_difference(total, queries[q, k], references[r, k])
                out[q, r] = total / scale


@lane_function
def add_term(total: Any, apart: Any, is_square: bool) -> Any:
    """The sum with one more feature in it."""
    return fma(apart, apart, total) if is_square else total + maximum(apart, -apart)


@kernel
def sum_differences(
    queries: Array, references: Array, first: int, last: int, is_square: bool, scale: float, out: Array
) -> None:
    """Sum of absolute or squared differences over ``scale``, rows ``first`` … ``last`` − 1 of (query, reference).

    References lie side by side, (block, feature, lane). Each sum runs over the features in order, whatever else is
    compared. Four queries share what is loaded; at the end, some of the four may be the same.
    """
    n, n_references = queries.shape[1], out.shape[1]
    sums_array = np.empty((4, LANES), references.dtype)
    query, reference, sums = address(queries), address(references), address(sums_array)
    for block in range(len(references)):
        n_filled = min(LANES, n_references - block * LANES)
        for q in range(first, last, 4):
            p0, p1, p2, p3 = q * n, min(q + 1, last - 1) * n, min(q + 2, last - 1) * n, min(q + 3, last - 1) * n
            a = fill(0.0, load(reference, 0))
            b, c, d = a, a, a
            for k in range(n):
                row = load(reference, block * n + k)
                a = add_term(a, row - query[p0 + k], is_square)
                b = add_term(b, row - query[p1 + k], is_square)
                c = add_term(c, row - query[p2 + k], is_square)
                d = add_term(d, row - query[p3 + k], is_square)
            store(sums, 0, a / scale)
            store(sums, 1, b / scale)
            store(sums, 2, c / scale)
            store(sums, 3, d / scale)
            for i in range(min(4, last - q)):
                for j in range(n_filled):
                    out[q + i, block * LANES + j] = sums_array[i, j]


@kernel
def count_unequal_bits(queries: Array, references: Array, first: int, last: int, scale: float, out: Array) -> None:
    """Number of bits that differ over ``scale``, of words of 64; rows as above."""
    for start in range(0, len(references), TILE):
        for q in range(first, last):
            for r in range(start, min(start + TILE, len(references))):
                total = np.uint64(0)
                for k in range(queries.shape[1]):
                    total += count_bits(queries[q, k] ^ references[r, k])
                out[q, r] = total / scale
