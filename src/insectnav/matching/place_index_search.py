"""Where on a large map each query was taken: an index proposes lines, and those are scored as by comparing with all."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError
from insectnav.matching.place_exact_search import Landscape, known_frames, matches_of_lines
from insectnav.matching.place_index import PlaceIndex
from insectnav.matching.place_pieces import Lines
from insectnav.matching.seqslam import Matches, SeqSlamParams
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
LINES = 64  # that are scored for each sequence: on Nordland 16 lose a tenth of the matches that are right, 64 half a %
LEAST_WEIGHT = 1e-3  # of a candidate; it decides where there is nothing else
SPARE = 2  # [place] beyond twice the window, to either side of a proposed start, that lines are scored from
SEQUENCES_PER_BLOCK = 16


def indexed_matches(
    landscape: Landscape, index: PlaceIndex, queries: NDArray[Any], params: SeqSlamParams, workers: int | None
) -> Matches:
    """Matches of queries with lines that the index proposes, scored as `exact_matches` does.

    Notes
    -----
    The candidates of all frames of a sequence vote for starts of lines, the nearest of a frame with 1, the farthest
    with 1/1000; lines about the 64 starts with most votes are scored. What has fewer votes is not compared with, so
    that a rival may be missed: the score is then less than that of exact search, and never more where the match is the
    same.
    """
    check_baseline(params)
    places, distances = index.candidates(queries, workers)
    is_seen = known_frames(landscape, queries)
    n_sequences = len(queries) - params.n_steps
    lines = Lines(
        start=np.empty(n_sequences, np.int64),
        speed=np.empty(n_sequences, np.int64),
        lowest=np.empty(n_sequences),
        second=np.empty(n_sequences),
        least=np.inf,
    )

    def run(first: int, last: int) -> None:
        for i in range(first, last):
            of = slice(i, i + params.n_steps + 1)
            found = best_line(landscape, queries[of], is_seen[of], places[of], distances[of], params)
            lines.start[i], lines.speed[i], lines.lowest[i], lines.second[i] = found

    run_blocks(run, n_sequences, SEQUENCES_PER_BLOCK, workers)
    return matches_of_lines(lines, is_seen, params)


def check_baseline(params: SeqSlamParams) -> None:
    """Refuse a baseline that only a comparison with all places could find."""
    if params.baseline != "bound":
        raise InputError(
            f"baseline is {params.baseline!r}, expected 'bound': the least contrast of all places is known only to "
            "a search that is 'exact'"
        )


def best_line(
    landscape: Landscape,
    frames: NDArray[Any],
    is_seen: NDArray[np.bool_],
    places: Integers,
    distances: Reals,
    params: SeqSlamParams,
) -> tuple[int, int, float, float]:
    """Start, number of the speed, sum and rival's sum of the best line of one sequence; −1 where there is none.

    Parameters
    ----------
    landscape : Landscape
    frames : (frame, feature) descriptors of the sequence
    is_seen : (frame,) which of them are not missing
    places, distances : (frame, candidate) of `PlaceIndex.candidates`
    params : SeqSlamParams
    """
    from insectnav.matching.place_vote_kernel import propose_starts, score_neighbourhoods

    routes, half = landscape.places.routes, params.unique_window // 2
    proposed = np.empty(LINES, np.int64)
    weights = _weights(distances)
    n = propose_starts(places, weights, routes, coarse_speeds(params.offsets), half + 1, proposed)
    if not n:
        return -1, -1, np.inf, np.inf
    pieces = _neighbourhoods(np.sort(proposed[:n]), landscape, params)
    of = np.concatenate([np.arange(piece[3], piece[4]) for piece in pieces])
    rows = np.ascontiguousarray(landscape.references(of).differences(frames, workers=1).T)
    rows[~is_seen] = np.nan
    return score_neighbourhoods(rows, pieces, params.contrast_window // 2, params.flat, params.offsets, half)


def _weights(distances: Reals) -> Reals:
    """How much a candidate counts: 1 for the nearest of a frame down to next to nothing for the farthest."""
    with np.errstate(invalid="ignore"):
        farthest = np.where(np.isfinite(distances), distances, -np.inf).max(axis=1, keepdims=True)
        span = farthest - distances[:, :1]
        share = np.divide(distances - distances[:, :1], span, out=np.zeros_like(distances), where=span > 0.0)
    return np.asarray(1.0 + LEAST_WEIGHT - share, np.float64)


def coarse_speeds(offsets: Integers) -> Integers:
    """Enough of the speeds that each line ends within a place of one of them."""
    last = offsets[:, -1]
    chosen, ahead = [], -np.inf
    for k in range(len(offsets)):
        if last[k] > ahead:
            following = np.flatnonzero(last <= last[k] + 1)[-1]
            chosen.append(following)
            ahead = last[following] + 1
    return offsets[chosen]


def _neighbourhoods(proposed: Integers, landscape: Landscape, params: SeqSlamParams) -> Integers:
    """Route, starts, places needed and end of what is about each proposed start, (neighbourhood, 6)."""
    routes = landscape.places.routes
    route = routes[proposed]
    begin, end = np.searchsorted(routes, route, "left"), np.searchsorted(routes, route, "right")
    reach = 2 * (params.unique_window // 2) + SPARE
    contrast, longest = params.contrast_window // 2, int(params.offsets[:, -1].max())
    first, last = np.maximum(proposed - reach, begin), np.minimum(proposed + reach + 1, end)
    is_new = np.ones(len(first), bool)  # neighbourhoods that overlap become one
    is_new[1:] = (first[1:] > last[:-1]) | (route[1:] != route[:-1])
    first, route, begin, end = first[is_new], route[is_new], begin[is_new], end[is_new]
    last = np.maximum.reduceat(last, np.flatnonzero(is_new))
    low, beyond = np.maximum(first - contrast, begin), np.minimum(last + longest, end)
    return np.stack([route, first, last, low, np.minimum(beyond + contrast, end), beyond], axis=1)
