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
PIECE = 512  # features that are summed in the precision of the vectors
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


@lane_function
def add_piece(
    reference: Any, row: int, query: Any, at: Any, first: int, last: int, is_square: bool, sums: Array, out: Any
) -> None:
    """Add to ``sums`` (query, lane) what features ``first`` … ``last`` − 1 of four queries give, by way of ``out``."""
    p0, p1, p2, p3 = at
    a = fill(0.0, load(reference, 0))
    b, c, d = a, a, a
    for k in range(first, last):
        there = load(reference, row + k)
        a = add_term(a, there - query[p0 + k], is_square)
        b = add_term(b, there - query[p1 + k], is_square)
        c = add_term(c, there - query[p2 + k], is_square)
        d = add_term(d, there - query[p3 + k], is_square)
    store(address(out), 0, a)
    store(address(out), 1, b)
    store(address(out), 2, c)
    store(address(out), 3, d)
    for i in range(4):
        for j in range(LANES):
            sums[i, j] += out[i, j]


@kernel
def sum_differences(
    queries: Array,
    references: Array,
    first: int,
    last: int,
    is_square: bool,
    is_root: bool,
    scale: float,
    out: Array,
) -> None:
    """Sum of absolute or squared differences over ``scale``, or the root of it, rows ``first`` … ``last`` − 1 of out.

    References lie side by side, (block, feature, lane). Each sum runs over the features in order, whatever else is
    compared; pieces of it are added up in double precision, or long sums would lose digits. Four queries share what is
    loaded; at the end, some of the four may be the same.
    """  # fmt: skip
    n, n_references = queries.shape[1], out.shape[1]
    piece, sums = np.empty((4, LANES), references.dtype), np.empty((4, LANES))
    query, reference = address(queries), address(references)
    for block in range(len(references)):
        n_filled = min(LANES, n_references - block * LANES)
        for q in range(first, last, 4):
            at = q * n, min(q + 1, last - 1) * n, min(q + 2, last - 1) * n, min(q + 3, last - 1) * n
            sums[:] = 0.0
            for start in range(0, n, PIECE):
                add_piece(reference, block * n, query, at, start, min(start + PIECE, n), is_square, sums, piece)
            for i in range(min(4, last - q)):
                for j in range(n_filled):
                    total = sums[i, j] / scale
                    out[q + i, block * LANES + j] = np.sqrt(total) if is_root else total


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
