"""Where on a map each query was taken, by comparing with all of its places, a piece of the map at a time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError
from insectnav.matching.difference import (
    FEW_FEATURES,
    Common,
    References,
    checked_vectors,
    common_of,
    prepare_references,
)
from insectnav.matching.place_arrays import PlaceArrays
from insectnav.matching.place_pieces import (
    STARTS_PER_PIECE,
    Lines,
    Piece,
    PieceLines,
    join_pieces,
    joined_blocks,
    map_pieces,
    piece_contrast,
    search_piece,
)
from insectnav.matching.seqslam import Matches, SeqSlamParams, matches_from_lines
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
SEQUENCES_PER_BLOCK = 256
TASKS_AT_ONCE = 64  # blocks of queries × pieces of the map whose lines are kept until they are joined


@dataclass(frozen=True, kw_only=True, eq=False)
class Landscape:
    """Places and what all of them together decide: what a comparison with some of them needs.

    Parameters
    ----------
    places : PlaceArrays
    metric : one of `insectnav.matching.METRICS`
    common : Common
    is_any_known : whether any place has a descriptor
    """

    places: PlaceArrays
    metric: str
    common: Common
    is_any_known: bool

    def references(self, places: slice | NDArray[np.int64]) -> References:
        """Some of the places, ready to be compared."""
        return prepare_references(self.places.descriptors(places), self.metric, common=self.common)


def landscape_of(places: PlaceArrays, metric: str) -> Landscape:
    """Places with what all of them together decide."""
    vectors = places.stored
    is_missing, is_any_known = np.zeros(len(vectors), bool), True
    if vectors.dtype.kind == "f":
        if metric == "euclidean" and places.n_features > FEW_FEATURES:  # else nobody asks, and it takes a while
            is_missing = np.isnan(vectors[:, 0])
        pieces = range(0, len(vectors), STARTS_PER_PIECE)
        is_any_known = any(not np.isnan(vectors[k : k + STARTS_PER_PIECE, 0]).all() for k in pieces)
    # Compiled code is compiled for arrays that may be written to and for others: let there be one kind.
    routes = places.routes.view(np.ndarray)
    routes.flags.writeable = False
    return Landscape(
        places=replace(places, routes=routes),
        metric=metric,
        common=common_of(vectors, is_missing, metric),
        is_any_known=is_any_known,
    )


def exact_matches(landscape: Landscape, queries: NDArray[Any], params: SeqSlamParams, workers: int | None) -> Matches:
    """Matches of queries with a line in the map, as `insectnav.matching.seqslam` gives them on a single route.

    Notes
    -----
    Memory does not grow with map and queries but for what is returned.
    """
    pieces = map_pieces(landscape.places.routes, params)
    n_sequences = len(queries) - params.n_steps
    at_once = SEQUENCES_PER_BLOCK * max(1, TASKS_AT_ONCE // len(pieces))
    blocks = []
    for first in range(0, n_sequences, at_once):
        part = queries[first : min(first + at_once, n_sequences) + params.n_steps]
        blocks.append(join_pieces(lines_of_pieces(landscape, pieces, part, params, workers), params))
    return matches_of_lines(joined_blocks(blocks), known_frames(landscape, queries), params)


def matches_of_differences(
    difference: Reals, routes: NDArray[np.int64], params: SeqSlamParams, workers: int | None = None
) -> Matches:
    """Matches of queries whose differences from all places are known, as `PlaceMap.locate` finds them on its routes.

    Parameters
    ----------
    difference : (place, query) array
        However it was made; NaN for missing frames.
    routes : (place,) number of the traverse of each place
    params : SeqSlamParams
    workers : threads; they change nothing in the results

    Raises
    ------
    InputError
        If there are fewer queries than a sequence, or places on every route.
    """
    params.check_length(difference.shape[1], "query", "queries")
    check_routes(routes, params)
    rows, pieces = np.ascontiguousarray(difference.T), map_pieces(routes, params)
    found: list[PieceLines] = [None] * len(pieces)  # type: ignore[list-item]

    def run(task: int, _: int) -> None:
        piece = pieces[task]
        contrast = piece_contrast(piece, np.ascontiguousarray(rows[:, piece.low : piece.high]), params)
        found[task] = search_piece(piece, contrast, params)

    run_blocks(run, len(pieces), 1, workers)
    is_seen = np.asarray(~np.isnan(rows).all(axis=1))
    return matches_of_lines(join_pieces(found, params), is_seen, params)


def lines_of_pieces(
    landscape: Landscape, pieces: Sequence[Piece], queries: NDArray[Any], params: SeqSlamParams, workers: int | None
) -> list[PieceLines]:
    """What each of the pieces knows of the sequences of queries."""
    n_sequences = len(queries) - params.n_steps
    starts = range(0, n_sequences, SEQUENCES_PER_BLOCK)
    found: list[PieceLines] = [None] * (len(pieces) * len(starts))  # type: ignore[list-item]

    def run(task: int, _: int) -> None:
        piece, first = pieces[task // len(starts)], starts[task % len(starts)]
        part = queries[first : min(first + SEQUENCES_PER_BLOCK, n_sequences) + params.n_steps]
        references = landscape.references(slice(piece.low, piece.high))
        rows = np.ascontiguousarray(references.differences(part, workers=1).T)
        found[task] = search_piece(piece, piece_contrast(piece, rows, params), params)

    run_blocks(run, len(found), 1, workers)
    return [_one_after_the_other(found[k : k + len(starts)]) for k in range(0, len(found), len(starts))]


def _one_after_the_other(blocks: Sequence[PieceLines]) -> PieceLines:
    """What one piece knows of all sequences, from blocks of them."""
    piece, least = blocks[0].piece, min(lines.least for lines in blocks)
    start, speed, sums, left, right = (np.concatenate(parts) for parts in zip(*(b[1:-1] for b in blocks), strict=True))
    return PieceLines(piece, start, speed, sums, left, right, least)


def matches_of_lines(lines: Lines, is_seen: NDArray[np.bool_], params: SeqSlamParams) -> Matches:
    """Matches of all queries from the lines of their sequences.

    Parameters
    ----------
    lines : Lines
    is_seen : (query,) which could be compared
    params : SeqSlamParams
    """
    n = params.n_steps + 1
    baseline = lines.least if params.baseline == "observed" else params.bound
    n_seen = np.convolve(is_seen, np.ones(n, np.int64), "valid")
    second = lines.second - n * baseline
    is_match = (2 * n_seen >= n) & (lines.start >= 0) & (second > 0.0) & (second < np.inf)
    score = np.full(len(second), np.nan)
    np.divide(np.maximum(lines.lowest - n * baseline, 0.0), second, out=score, where=is_match)
    found = (np.where(is_match, lines.start, -1), score, np.where(is_match, lines.speed, -1))
    return matches_from_lines(found, params, len(is_seen))


def known_frames(landscape: Landscape, queries: NDArray[Any]) -> NDArray[np.bool_]:
    """Which queries could be compared with any place."""
    return ~checked_vectors("queries", queries)[1] & landscape.is_any_known


def checked_queries(landscape: Landscape, descriptors: ArrayLike) -> NDArray[Any]:
    """Queries as an array (query, feature).

    Raises
    ------
    InputError
        If they are not of the kind of the places.
    """
    queries, places = np.asarray(descriptors), landscape.places
    checked_vectors("queries", queries)
    if queries.shape[1] != places.n_features:
        raise InputError(
            f"queries have {queries.shape[1]} features, expected {places.n_features} as the places: "
            "the same descriptor?"
        )
    landscape.references(slice(0, 1)).differences(queries[:1])  # which refuses numbers of another type
    return queries


def check_routes(routes: NDArray[np.int64], params: SeqSlamParams) -> None:
    """Refuse places (place,) of which no route holds even the shortest line."""
    longest, shortest = int(np.bincount(routes).max()), int(params.offsets[:, -1].min()) + 1
    if longest < shortest:
        raise InputError(
            f"the longest route of the map has {longest} places, expected at least {shortest} for sequences of "
            f"{params.sequence_length} steps: shorter sequences, or places closer to each other?"
        )
