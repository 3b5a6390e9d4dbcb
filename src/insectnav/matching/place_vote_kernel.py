"""Candidates of the frames of a sequence vote for lines, and lines near the best of them are scored; compiled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.lanes.compiled import kernel, lane_function
from insectnav.matching.sequence_kernel import TILE, best_speed, enhance_row, score_starts

Array = NDArray[Any]


@lane_function
def votes_of_speed(starts: Array, frame: Array, weight: Array, best: Array, vote: Array) -> None:
    """Votes for the line from each start, given in order, or from the two places after it; a frame has one vote."""
    n = len(starts)
    for i in range(n):
        best[:] = 0.0
        j = i
        while j < n and starts[j] <= starts[i] + 2:
            best[frame[j]] = max(best[frame[j]], weight[j])
            j += 1
        total = 0.0
        for k in range(len(best)):
            total += best[k]
        vote[i] = total


@lane_function
def most_voted(starts: Array, votes: Array, routes: Array, apart: int, proposed: Array) -> int:
    """Fill the middles of the starts with most votes, ``apart`` from each other; how many. Uses the votes up."""
    n = 0
    while n < len(proposed):
        top = np.argmax(votes) if len(votes) else 0
        if not len(votes) or votes[top] <= 0.0:
            break
        middle = starts[top] + 1
        if middle >= len(routes) or routes[middle] != routes[starts[top]]:
            middle = starts[top]
        proposed[n] = middle
        chosen = starts[top]
        for i in range(len(starts)):
            if abs(starts[i] - chosen) < apart and routes[starts[i]] == routes[chosen]:
                votes[i] = 0.0
        n += 1
    return n


@kernel
def propose_starts(places: Array, weights: Array, routes: Array, offsets: Array, apart: int, proposed: Array) -> int:
    """Fill the starts of the lines that most candidates vote for, at least ``apart`` from each other; how many.

    ``places`` and ``weights`` are (frame, candidate), −1 for none; ``offsets`` are (speed, frame).
    """
    n_frames, n_candidates = places.shape
    room = n_frames * n_candidates
    starts, votes = np.empty(len(offsets) * room, np.int64), np.empty(len(offsets) * room)
    start, frame, weight = np.empty(room, np.int64), np.empty(room, np.int64), np.empty(room)
    best = np.empty(n_frames)
    n = 0
    for v in range(len(offsets)):
        m = 0
        for k in range(n_frames):
            for c in range(n_candidates):
                place = places[k, c]
                first = place - offsets[v, k]
                if place >= 0 and first >= 0 and routes[first] == routes[place]:
                    start[m], frame[m], weight[m] = first, k, weights[k, c]
                    m += 1
        order = np.argsort(start[:m])
        starts[n : n + m] = start[:m][order]
        votes_of_speed(starts[n : n + m], frame[:m][order], weight[:m][order], best, votes[n : n + m])
        n += m
    return most_voted(starts[:n], votes[:n], routes, apart, proposed)


@kernel
def score_neighbourhoods(
    difference: Array, pieces: Array, half_contrast: int, least_contrast: float, offsets: Array, half: int
) -> tuple[int, int, float, float]:
    """Best of all starts, number of its speed, its sum, and the least sum outside its window; −1 if all are equal.

    ``difference`` is (frame, place), neighbourhoods side by side; ``pieces`` holds for each of them route, first start,
    last start, first place, last place and the place that no line may run to, as `place_pieces.Piece`.
    """
    n_frames, n_pieces = len(difference), len(pieces)
    n_starts = 0
    for p in range(n_pieces):
        n_starts += pieces[p, 2] - pieces[p, 1]
    sums, starts, route = np.empty(n_starts), np.empty(n_starts, np.int64), np.empty(n_starts, np.int64)
    widest = 0
    for p in range(n_pieces):
        widest = max(widest, pieces[p, 4] - pieces[p, 3])
    row, mean, squares, total = np.empty(widest), np.empty(widest), np.empty(widest), np.empty(TILE)
    score = np.empty(widest)
    n, column = 0, 0
    lowest, best, best_start, speed = np.inf, -1, -1, -1
    for p in range(n_pieces):
        first, last, low, high, end = pieces[p, 1], pieces[p, 2], pieces[p, 3], pieces[p, 4], pieces[p, 5]
        contrast = np.empty((n_frames, end - first))
        for k in range(n_frames):
            enhance_row(difference[k, column : column + high - low], half_contrast, least_contrast, mean, squares, row)
            contrast[k, :] = row[first - low : end - low]
        score_starts(contrast, 0, offsets, score[: end - first], total)
        for s in range(last - first):
            sums[n], starts[n], route[n] = score[s], first + s, pieces[p, 0]
            if score[s] < lowest:  # neighbourhoods are in order, so that the first of equal starts stays
                lowest, best, best_start = score[s], n, first + s
                speed = best_speed(contrast, 0, offsets, s)
            n += 1
        column += high - low
    second, greatest = np.inf, -np.inf
    for i in range(n):
        if sums[i] < np.inf:
            greatest = max(greatest, sums[i])
        if best >= 0 and (route[i] != route[best] or abs(starts[i] - best_start) > half):
            second = min(second, sums[i])
    return (best_start if greatest > lowest else -1), speed, lowest, second
