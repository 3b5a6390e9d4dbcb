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
PRODUCTS = 128  # the same of products, which grow while differences of like vectors stay small
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
def sum_byte_differences(queries: Array, references: Array, scale: float, out: Array) -> None:
    """Fill ``out`` (query, reference) with sums of absolute differences over ``scale``; bytes, exact."""
    for start in range(0, len(references), TILE):
        for q in range(len(queries)):
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


@lane_function
def sum_tile(reference: Any, row: int, query: Any, at: Any, n: int, is_square: bool, sums: Array, piece: Array) -> None:
    """Fill ``sums`` (query, lane) of four queries and the references of a block.

    Pieces are added up in double precision, or long sums would lose digits.
    """
    sums[:] = 0.0
    for start in range(0, n, PIECE):
        add_piece(reference, row, query, at, start, min(start + PIECE, n), is_square, sums, piece)


@kernel
def sum_differences(
    queries: Array, references: Array, is_square: bool, is_root: bool, scale: float, out: Array
) -> None:
    """Fill ``out`` (query, reference) with sums of absolute or squared differences over ``scale``, or the root of it.

    References lie side by side, (block, feature, lane). Each sum runs over the features in order, whatever else is
    compared. Four queries share what is loaded; at the end, some of the four may be the same.
    """
    n, end, n_references = queries.shape[1], len(queries) - 1, out.shape[1]
    piece, sums = np.empty((4, LANES), references.dtype), np.empty((4, LANES))
    query, reference = address(queries), address(references)
    for block in range(len(references)):
        n_filled = min(LANES, n_references - block * LANES)
        for q in range(0, len(queries), 4):
            at = q * n, min(q + 1, end) * n, min(q + 2, end) * n, min(q + 3, end) * n
            sum_tile(reference, block * n, query, at, n, is_square, sums, piece)
            for i in range(min(4, len(queries) - q)):
                for j in range(n_filled):
                    total = sums[i, j] / scale
                    out[q + i, block * LANES + j] = np.sqrt(total) if is_root else total


@lane_function
def add_products(reference: Any, rows: Any, query: Any, at: Any, first: int, last: int, sums: Array, out: Any) -> None:
    """Add to ``sums`` (block, query, lane) the products of four queries and two blocks; features as above."""
    (left, right), (p0, p1, p2, p3) = rows, at
    a = fill(0.0, load(reference, 0))
    b, c, d, e, f, g, h = a, a, a, a, a, a, a
    for k in range(first, last):
        x, y = load(reference, left + k), load(reference, right + k)
        a, e = fma(x, query[p0 + k], a), fma(y, query[p0 + k], e)
        b, f = fma(x, query[p1 + k], b), fma(y, query[p1 + k], f)
        c, g = fma(x, query[p2 + k], c), fma(y, query[p2 + k], g)
        d, h = fma(x, query[p3 + k], d), fma(y, query[p3 + k], h)
    store(address(out), 0, a)
    store(address(out), 1, b)
    store(address(out), 2, c)
    store(address(out), 3, d)
    store(address(out), 4, e)
    store(address(out), 5, f)
    store(address(out), 6, g)
    store(address(out), 7, h)
    for half in range(2):
        for i in range(4):
            for j in range(LANES):
                sums[half, i, j] += out[4 * half + i, j]


@lane_function
def subtract(products: Array, near: float, out: Array) -> bool:
    """Fill ``out`` (query, lane) with one less the products; whether any comes out below ``near``."""
    n_near = 0
    for i in range(len(out)):
        row, product = out[i], products[i]
        for j in range(len(row)):
            row[j] = 1.0 - product[j]
            n_near += 1.0 - product[j] < near
    return n_near > 0


@kernel
def subtract_cosines(queries: Array, references: Array, near: float, out: Array) -> None:
    """Fill ``out`` (query, reference) with one less the product of unit vectors, laid out as for `sum_differences`.

    Where that is below ``near``, subtraction has cost digits, and half the squared distance is the same but keeps them.
    """
    n, end = queries.shape[1], len(queries) - 1
    piece, sums = np.empty((8, LANES), references.dtype), np.empty((2, 4, LANES))
    squares = np.empty((4, LANES))
    query, reference = address(queries), address(references)
    for block in range(0, len(references), 2):
        rows = block * n, min(block + 1, len(references) - 1) * n
        for q in range(0, len(queries), 4):
            at = q * n, min(q + 1, end) * n, min(q + 2, end) * n, min(q + 3, end) * n
            sums[:] = 0.0
            for start in range(0, n, PRODUCTS):
                add_products(reference, rows, query, at, start, min(start + PRODUCTS, n), sums, piece)
            for half in range(min(2, len(references) - block)):
                tile = out[q : q + 4, (block + half) * LANES : (block + half + 1) * LANES]
                if not subtract(sums[half], near, tile):
                    continue
                sum_tile(reference, rows[half], query, at, n, True, squares, piece)
                for i in range(tile.shape[0]):
                    for j in range(tile.shape[1]):
                        if 1.0 - sums[half, i, j] < near:
                            tile[i, j] = squares[i, j] / 2.0


@kernel
def count_unequal_bits(queries: Array, references: Array, scale: float, out: Array) -> None:
    """Fill ``out`` (query, reference) with numbers of bits that differ over ``scale``, of words of 64."""
    for start in range(0, len(references), TILE):
        for q in range(len(queries)):
            for r in range(start, min(start + TILE, len(references))):
                total = np.uint64(0)
                for k in range(queries.shape[1]):
                    total += count_bits(queries[q, k] ^ references[r, k])
                out[q, r] = total / scale
