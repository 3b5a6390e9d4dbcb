"""A map searched on the move: one frame in, the best match so far out."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError
from insectnav.matching.difference import References
from insectnav.matching.place_exact_search import Landscape, checked_queries, known_frames, matches_of_lines
from insectnav.matching.place_index import PlaceIndex
from insectnav.matching.place_index_search import best_line, check_baseline
from insectnav.matching.place_pieces import (
    STARTS_PER_PIECE,
    Lines,
    Piece,
    join_pieces,
    map_pieces,
    piece_contrast,
    search_piece,
)
from insectnav.matching.seqslam import Matches, SeqSlamParams
from insectnav.matching.stream import StreamMatch, later, match_so_far

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class MapStream:
    """What a robot keeps between frames; made by `PlaceMap.stream`, carried on by `locate_next`.

    Parameters
    ----------
    landscape : of the map
    params : SeqSlamParams
    index : that proposes lines; None to compare with all places
    pieces : of the map, each ready to be compared; none with an index
    contrast : (frame, place) array for each piece, of the newest frames
    frames : (frame, feature) descriptors of the newest frames, with NaN or 0 for those that are missing
    candidates : their places and distances, (frame, candidate) each
    is_seen : (frame,) which of them were not missing
    times : (frame,) array [s] of these, NaN if they come without
    n_frames : that have come so far
    """

    landscape: Landscape
    params: SeqSlamParams
    index: PlaceIndex | None
    pieces: tuple[tuple[Piece, References], ...]
    contrast: tuple[Reals, ...]
    frames: NDArray[Any]
    candidates: tuple[Integers, Reals]
    is_seen: NDArray[np.bool_]
    times: Reals
    n_frames: int = 0

    def locate_next(self, descriptor: ArrayLike | None, time: float | None = None) -> tuple["MapStream", StreamMatch]:
        """The stream after one more frame, and what is known by then.

        Parameters
        ----------
        descriptor : (feature,) array
            Of the frame; None if it is missing, as a corrupt image is.
        time : float [s]
            When it was taken; later than the frame before, whether or not that is missing.

        Returns
        -------
        MapStream, StreamMatch
            The stream itself stays as it is. The match is that of `PlaceMap.locate` on all frames together, to the bit.

        Raises
        ------
        InputError
            If the descriptor is not of the places' kind, or the frame is not later than the one before.
        """
        after = _with_frame(self, descriptor, later(self.n_frames, float(self.times[-1]), time))

        def newest() -> tuple[int, int, Matches]:
            lines = _lines(after)
            return int(lines.start[0]), int(lines.speed[0]), matches_of_lines(lines, after.is_seen, self.params)

        return after, match_so_far(after.n_frames, after.times, self.params, newest)


def begin_map_stream(landscape: Landscape, params: SeqSlamParams, index: PlaceIndex | None) -> MapStream:
    """A stream before its first frame.

    Raises
    ------
    InputError
        If the baseline of the contrast is not known beforehand.
    """
    check_baseline(params)
    n, places = params.n_steps + 1, landscape.places
    pieces = [] if index else map_pieces(places.routes, params, STARTS_PER_PIECE)
    n_candidates = index.sizes.n_candidates if index else 0
    return MapStream(
        landscape=landscape,
        params=params,
        index=index,
        pieces=tuple((piece, landscape.references(slice(piece.low, piece.high))) for piece in pieces),
        contrast=tuple(np.zeros((n, piece.end - piece.first)) for piece in pieces),
        frames=np.zeros((n, places.n_features), bool if places.is_bits else places.stored.dtype),
        candidates=(np.full((n, n_candidates), -1, np.int64), np.full((n, n_candidates), np.inf, np.float32)),
        is_seen=np.zeros(n, bool),
        times=np.full(n, np.nan),
    )


def _with_frame(stream: MapStream, descriptor: ArrayLike | None, time: float) -> MapStream:
    """The stream with one more frame in the place of the oldest, compared with the map as far as that is needed."""
    frame = _checked_frame(stream, descriptor)
    is_seen = descriptor is not None and bool(known_frames(stream.landscape, frame)[0])
    seen = frame if is_seen else None
    return replace(
        stream,
        contrast=tuple(
            np.concatenate([rows[1:], _contrast(*piece, seen, stream.params)])
            for piece, rows in zip(stream.pieces, stream.contrast, strict=True)
        ),
        frames=np.concatenate([stream.frames[1:], frame]),
        candidates=_candidates(stream, seen),
        is_seen=np.append(stream.is_seen[1:], is_seen),
        times=np.append(stream.times[1:], time),
        n_frames=stream.n_frames + 1,
    )


def _candidates(stream: MapStream, frame: NDArray[Any] | None) -> tuple[Integers, Reals]:
    """Candidates of the newest frames, with those of one more; a missing frame has none."""
    places, distances = stream.candidates
    new_places, new_distances = np.full_like(places[:1], -1), np.full_like(distances[:1], np.inf)
    if stream.index is not None and frame is not None:
        new_places, new_distances = stream.index.candidates(frame, workers=1)
    return np.concatenate([places[1:], new_places]), np.concatenate([distances[1:], new_distances])


def _checked_frame(stream: MapStream, descriptor: ArrayLike | None) -> NDArray[Any]:
    """One frame as an array (1, feature); NaN where it is missing, 0 where the map holds no such number."""
    kept, n = stream.frames.dtype, stream.landscape.places.n_features
    if descriptor is None:
        return np.full((1, n), np.nan if kept.kind == "f" else 0, kept)
    vector = np.asarray(descriptor)
    if vector.shape != (n,):
        raise InputError(f"descriptor has shape {vector.shape}, expected ({n},) as the places: one frame at a time")
    return checked_queries(stream.landscape, vector[None])


def _contrast(piece: Piece, references: References, frame: NDArray[Any] | None, params: SeqSlamParams) -> Reals:
    """Contrasts of one frame, (1, place); none if it is missing."""
    if frame is None:
        return np.zeros((1, piece.end - piece.first))
    return piece_contrast(piece, np.ascontiguousarray(references.differences(frame, workers=1).T), params)


def _lines(stream: MapStream) -> Lines:
    """The best line of the newest sequence."""
    if stream.index is None:
        found = zip(stream.pieces, stream.contrast, strict=True)
        return join_pieces([search_piece(piece, rows, stream.params) for (piece, _), rows in found], stream.params)
    found_line = best_line(stream.landscape, stream.frames, stream.is_seen, *stream.candidates, stream.params)
    start, speed, lowest, second = (np.array([value]) for value in found_line)
    return Lines(start, speed, lowest, second, np.inf)
