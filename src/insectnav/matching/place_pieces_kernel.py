"""The best lines within a piece of a map, and what is needed to join pieces, compiled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.lanes.compiled import kernel
from insectnav.matching.sequence_kernel import TILE, best_speed, enhance_row, score_starts

Array = NDArray[Any]


@kernel
def enhance_piece(difference: Array, half: int, least_contrast: float, low: int, out: Array) -> None:
    """Fill contrasts of the places from column ``low`` on, (query, place); the others are there for their windows."""
    n_places = difference.shape[1]
    row, mean, squares = np.empty(n_places), np.empty(n_places), np.empty(n_places)
    for q in range(len(difference)):
        enhance_row(difference[q], half, least_contrast, mean, squares, row)
        out[q, :] = row[low : low + out.shape[1]]


@kernel
def search_piece(
    contrast: Array,
    offsets: Array,
    n_starts: int,
    half: int,
    start: Array,
    speed: Array,
    sums: Array,
    left: Array,
    right: Array,
) -> None:
    """Fill the best start and speed of each sequence of rows, sums of lines, and sums at both ends of the piece.

    ``sums`` holds, for each sequence, the least of all starts, the least of those farther than ``half`` from the best,
    the least of those farther than ``half`` from both ends, and the greatest that is not infinite. ``left`` and
    ``right`` hold the sums of the first and last ``half`` starts, infinite where there are fewer.
    """
    score, total = np.empty(contrast.shape[1]), np.empty(TILE)
    for i in range(len(start)):
        score_starts(contrast, i, offsets, score, total)
        best, greatest = 0, -np.inf
        for s in range(n_starts):
            if score[s] < score[best]:
                best = s
            if score[s] < np.inf:
                greatest = max(greatest, score[s])
        second, inner = np.inf, np.inf
        for s in range(n_starts):
            if s < best - half or s > best + half:
                second = min(second, score[s])
            if half <= s < n_starts - half:
                inner = min(inner, score[s])
        start[i], speed[i] = best, best_speed(contrast, i, offsets, best)
        sums[i, 0], sums[i, 1], sums[i, 2], sums[i, 3] = score[best], second, inner, greatest
        left[i, :], right[i, :] = np.inf, np.inf
        for s in range(min(half, n_starts)):
            left[i, s] = score[s]
        for s in range(max(n_starts - half, half), n_starts):
            right[i, s - (n_starts - half)] = score[s]
