"""Where on a map each query was taken, by comparing with all of its places, a piece of the map at a time."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError
from insectnav.matching.difference import prepare_references
from insectnav.matching.place_arrays import PlaceArrays
from insectnav.matching.place_pieces import Lines, join_pieces, map_pieces, search_piece
from insectnav.matching.seqslam import Matches, SeqSlamParams, matches_from_lines

Reals = NDArray[np.floating[Any]]
QUERIES_PER_BLOCK = 256


def exact_matches(
    places: PlaceArrays, metric: str, queries: NDArray[Any], params: SeqSlamParams, workers: int | None
) -> Matches:
    """Matches of queries with a line in the map, as `insectnav.matching.seqslam` gives them on a single route."""
    references = prepare_references(places.descriptors(), metric)
    pieces = map_pieces(places.routes, params)
    rows = np.ascontiguousarray(references.differences(queries, workers=workers).T)
    is_seen = np.asarray(~np.isnan(rows).all(axis=1))
    lines = join_pieces([search_piece(piece, rows[:, piece.low : piece.high], params) for piece in pieces], params)
    return matches_of_lines(lines, is_seen, params.bound, params)


def matches_of_lines(lines: Lines, is_seen: NDArray[np.bool_], baseline: float, params: SeqSlamParams) -> Matches:
    """Matches of all queries from the lines of their sequences.

    Parameters
    ----------
    lines : Lines
    is_seen : (query,) which have a descriptor
    baseline : contrast at which a score is 0
    params : SeqSlamParams
    """
    n = params.n_steps + 1
    n_seen = np.convolve(is_seen, np.ones(n, np.int64), "valid")
    second = lines.second - n * baseline
    is_match = (2 * n_seen >= n) & (lines.start >= 0) & (second > 0.0) & (second < np.inf)
    score = np.full(len(second), np.nan)
    np.divide(np.maximum(lines.lowest - n * baseline, 0.0), second, out=score, where=is_match)
    found = (np.where(is_match, lines.start, -1), score, np.where(is_match, lines.speed, -1))
    return matches_from_lines(found, params, len(is_seen))


def check_queries(queries: NDArray[Any], params: SeqSlamParams) -> None:
    """Refuse fewer queries than a sequence is long."""
    if len(queries) < params.n_steps + 1:
        raise InputError(
            f"there are {len(queries)} queries, expected at least {params.n_steps + 1} for sequences of "
            f"{params.sequence_length} steps: fewer frames than a sequence?"
        )
