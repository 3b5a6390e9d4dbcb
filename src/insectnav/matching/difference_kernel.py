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


@lane_function
def empty_lanes(like: Array) -> Array:
    """Room for one row of lanes of this precision."""
    return np.empty(LANES, like.dtype)


@lane_function
def add_lanes(lanes: Array) -> float:
    """Sum of the lanes, in double precision."""
    total = 0.0
    for k in range(LANES):
        total += lanes[k]
    return total


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


@kernel
def sum_real_differences(
    queries: Array, references: Array, n_rows: int, first: int, last: int, scale: float, out: Array
) -> None:
    """Sum of absolute differences over ``scale``; vectors lie in ``n_rows`` rows of lanes each; rows as above."""
    sums_array = empty_lanes(queries)
    query_start, reference_start, sums = address(queries), address(references), address(sums_array)
    for start in range(0, out.shape[1], TILE):
        for q in range(first, last):
            for r in range(start, min(start + TILE, out.shape[1])):
                total = fill(0.0, load(query_start, 0))
                for k in range(n_rows):
                    apart = load(query_start, q * n_rows + k) - load(reference_start, r * n_rows + k)
                    total = total + maximum(apart, -apart)
                store(sums, 0, total)
                out[q, r] = add_lanes(sums_array) / scale


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


@kernel
def finish_products(
    queries: Array,
    references: Array,
    n_rows: int,
    power: Array,
    least: float,
    first: int,
    last: int,
    product: Array,
    out: Array,
) -> None:
    """Turn products of vectors into squared differences, rows as above; those of near pairs from the vectors.

    ``power`` holds the squares of the queries and then those of the references; row ``first`` of the queries is row 0
    of the product. Where the square of the difference is less than ``least`` of both squares, subtraction would leave
    mostly rounding.
    """
    sums_array = empty_lanes(queries)
    query_start, reference_start, sums = address(queries), address(references), address(sums_array)
    n_queries = out.shape[0]
    for q in range(first, last):
        for r in range(out.shape[1]):
            both = power[q] + power[n_queries + r]
            square = both - 2.0 * product[q - first, r]
            if square < least * both:
                total = fill(0.0, load(query_start, 0))
                for k in range(n_rows):
                    apart = load(query_start, q * n_rows + k) - load(reference_start, r * n_rows + k)
                    total = fma(apart, apart, total)
                store(sums, 0, total)
                square = add_lanes(sums_array)
            out[q, r] = square
