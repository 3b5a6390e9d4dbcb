"""Local contrast of differences, and the search for sequences in them, compiled.

A row is a query here, so that its references lie side by side in memory and as SIMD lanes in registers.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.lanes.compiled import kernel, lane_function

Array = NDArray[Any]
TILE = 512  # starts that are scored together, so that their sums stay in the cache


@lane_function
def contrast_at(row: Array, r: int, half: int, least_contrast: float) -> float:
    """Difference less the mean of its neighbours, over their standard deviation; those that are missing left out."""
    low, high = max(0, r - half), min(len(row), r + half + 1)
    n, mean, squares = 0, 0.0, 0.0
    for j in range(low, high):
        if not np.isnan(row[j]):
            n += 1
            mean += row[j]
    if n < 2 or np.isnan(row[r]):
        return 0.0
    mean /= n
    for j in range(low, high):
        if not np.isnan(row[j]):
            squares += (row[j] - mean) * (row[j] - mean)
    deviation = np.sqrt(squares / (n - 1))
    return (row[r] - mean) / deviation if deviation > least_contrast * abs(mean) else 0.0


@lane_function
def whole_windows(row: Array, n_whole: int, width: int, mean: Array, squares: Array) -> None:
    """Mean and sum of squared deviations of all whole windows, side by side."""
    mean[:n_whole] = 0.0
    squares[:n_whole] = 0.0
    for j in range(width):
        shifted = row[j : j + n_whole]
        for r in range(n_whole):
            mean[r] += shifted[r]
    for r in range(n_whole):
        mean[r] /= width
    for j in range(width):
        shifted = row[j : j + n_whole]
        for r in range(n_whole):
            squares[r] += (shifted[r] - mean[r]) * (shifted[r] - mean[r])


@lane_function
def enhance_row(row: Array, half: int, least_contrast: float, mean: Array, squares: Array, out: Array) -> None:
    """Contrast of each reference of a query; windows at the ends or with gaps are taken singly."""
    width, n_whole = 2 * half + 1, max(len(row) - 2 * half, 0)
    whole_windows(row, n_whole, width, mean, squares)
    middle, inner = row[half : half + n_whole], out[half : half + n_whole]
    for r in range(n_whole):
        deviation = np.sqrt(squares[r] / (width - 1))
        apart = middle[r] - mean[r]
        inner[r] = apart / deviation if deviation > least_contrast * abs(mean[r]) else 0.0
    for r in range(len(row)):
        is_whole = half <= r < half + n_whole and not np.isnan(mean[r - half])
        if not is_whole:
            out[r] = contrast_at(row, r, half, least_contrast)


@kernel
def enhance_rows(difference: Array, half: int, least_contrast: float, out: Array, is_seen: Array) -> float:
    """Fill contrasts (query, reference) and which queries have any difference at all; returns the least contrast."""
    mean, squares = np.empty(difference.shape[1]), np.empty(difference.shape[1])
    least = np.inf
    for q in range(len(difference)):
        enhance_row(difference[q], half, least_contrast, mean, squares, out[q])
        is_seen[q] = False
        for r in range(difference.shape[1]):
            is_seen[q] = is_seen[q] or not np.isnan(difference[q, r])
            least = min(least, out[q, r])
    return least


@lane_function
def add_lines(contrast: Array, first: int, offset: Array, low: int, total: Array) -> None:
    """Sums along the lines of one speed from neighbouring starts, side by side; four steps at a time.

    Pieces of rows are cut out first: an index that might count from the end of a row would keep sums out of SIMD.
    """
    n_steps, n, k = len(offset), len(total), 0
    total[:] = 0.0
    while k + 4 <= n_steps:
        p, q, r, s = low + offset[k], low + offset[k + 1], low + offset[k + 2], low + offset[k + 3]
        a, b = contrast[first + k, p : p + n], contrast[first + k + 1, q : q + n]
        c, d = contrast[first + k + 2, r : r + n], contrast[first + k + 3, s : s + n]
        for i in range(n):
            total[i] += (a[i] + b[i]) + (c[i] + d[i])
        k += 4
    while k < n_steps:
        p = low + offset[k]
        a = contrast[first + k, p : p + n]
        for i in range(n):
            total[i] += a[i]
        k += 1


@lane_function
def score_starts(contrast: Array, first: int, offsets: Array, score: Array, total: Array) -> None:
    """Least sum over all speeds for each start of a sequence, infinite where no speed stays within the references."""
    n_references, n_steps = contrast.shape[1], offsets.shape[1]
    for low in range(0, n_references, TILE):
        high = min(low + TILE, n_references)
        score[low:high] = np.inf
        for v in range(len(offsets)):
            end = min(high, n_references - offsets[v, n_steps - 1])
            n = end - low
            if n <= 0:
                continue
            add_lines(contrast, first, offsets[v], low, total[:n])
            least = score[low:end]
            for s in range(n):
                least[s] = min(least[s], total[s])


@lane_function
def is_any_greater(score: Array) -> bool:
    """Whether any score that is not infinite is greater than the first."""
    greatest = score[0]
    for s in range(1, len(score)):
        if score[s] < np.inf:
            greatest = max(greatest, score[s])
    return greatest > score[0]


@lane_function
def best_and_next(score: Array, half: int) -> tuple[int, float, float]:
    """First of the best starts, its score, and the best of those farther from it than ``half``; −1 if all are equal."""
    best = 0
    for s in range(len(score)):
        if score[s] < score[best]:
            best = s
    if best == 0 and not is_any_greater(score):
        return -1, np.inf, np.inf
    second = np.inf
    for s in range(len(score)):
        if s < best - half or s > best + half:
            second = min(second, score[s])
    return best, score[best], second


@lane_function
def best_speed(contrast: Array, first: int, offsets: Array, start: int) -> int:
    """The first of the speeds with the least sum from a start."""
    n_steps, best, least = offsets.shape[1], 0, np.inf
    for v in range(len(offsets)):
        total = np.inf
        if start + offsets[v, n_steps - 1] < contrast.shape[1]:
            total = 0.0
            for k in range(n_steps):
                total += contrast[first + k, start + offsets[v, k]]
        if total < least:
            best, least = v, total
    return best


@kernel
def search_sequences(
    contrast: Array,
    is_seen: Array,
    offsets: Array,
    half: int,
    baseline: float,
    start: Array,
    score: Array,
    speed: Array,
) -> None:
    """Best start, score and speed of each sequence of rows; −1 and NaN where there is none.

    The score is the best sum over the next best outside the window, with each contrast measured from ``baseline``.
    A sequence of which more than half of the queries are missing has no match.
    """  # fmt: skip
    n_steps = offsets.shape[1]
    sums, total = np.empty(contrast.shape[1]), np.empty(TILE)
    for i in range(len(start)):
        n_seen = 0
        for k in range(n_steps):
            n_seen += is_seen[i + k]
        start[i], score[i], speed[i] = -1, np.nan, -1
        if 2 * n_seen < n_steps:
            continue
        score_starts(contrast, i, offsets, sums, total)
        best, lowest, second = best_and_next(sums, half)
        second -= n_steps * baseline
        if best >= 0 and second > 0.0 and second < np.inf:
            start[i], score[i] = best, max(lowest - n_steps * baseline, 0.0) / second
            speed[i] = best_speed(contrast, i, offsets, best)
