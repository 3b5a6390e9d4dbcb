"""A map in pieces: lines are searched for in each, and the answers joined are those of the whole, bit for bit."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.matching.seqslam import SeqSlamParams

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
STARTS_PER_PIECE = 2**13


class Piece(NamedTuple):
    """Neighbouring starts of lines on one route, and the places that their lines and windows of contrast need."""

    route: int
    first: int  # start, by number of the place
    last: int  # the first start of the next piece
    low: int  # the first place that is needed
    high: int  # the first that is not
    end: int  # the first place that no line may run to: of the next route, or beyond the longest line


class PieceLines(NamedTuple):
    """What a piece knows of each sequence of queries, (sequence, …) arrays."""

    piece: Piece
    start: Integers  # of the best line, by number of the place
    speed: Integers  # number of its speed
    sums: Reals  # (sequence, 4), as of `place_pieces_kernel.search_piece`
    left: Reals  # (sequence, window) sums of the first starts
    right: Reals  # (sequence, window) sums of the last starts
    least: float  # contrast of its places, if the baseline is that observed


class Lines(NamedTuple):
    """The best line of the whole map for each sequence, (sequence,) arrays."""

    start: Integers  # −1 where all are equal
    speed: Integers
    lowest: Reals  # sum of contrasts along it
    second: Reals  # least sum outside its window
    least: float  # contrast of all places, if the baseline is that observed


def map_pieces(routes: Integers, params: SeqSlamParams, size: int = STARTS_PER_PIECE) -> list[Piece]:
    """Pieces of at most ``size`` starts that cover all places; no line runs from one route into the next.

    Parameters
    ----------
    routes : (place,) number of the traverse
    params : SeqSlamParams
    size : starts in a piece
    """
    borders = [0, *(np.flatnonzero(np.diff(routes)) + 1).tolist(), len(routes)]
    contrast, longest = params.contrast_window // 2, int(params.offsets[:, -1].max())
    return [
        Piece(
            route=int(routes[begin]),
            first=first,
            last=min(first + size, end),
            low=max(first - contrast, begin),
            high=min(min(first + size, end) + longest + contrast, end),
            end=min(min(first + size, end) + longest, end),
        )
        for begin, end in pairwise(borders)
        for first in range(begin, end, size)
    ]


def piece_contrast(piece: Piece, difference: Reals, params: SeqSlamParams) -> Reals:
    """Contrasts (query, place) of a piece from its first start to its end, of the differences of all it needs."""
    from insectnav.matching.place_pieces_kernel import enhance_piece

    out = np.empty((len(difference), piece.end - piece.first))
    enhance_piece(difference, params.contrast_window // 2, params.flat, piece.first - piece.low, out)
    return out


def search_piece(piece: Piece, contrast: Reals, params: SeqSlamParams) -> PieceLines:
    """The best lines within a piece, and what others must know of it.

    Parameters
    ----------
    piece : Piece
    contrast : (query, place) array of `piece_contrast`
    params : SeqSlamParams
    """
    from insectnav.matching import place_pieces_kernel

    n_sequences, half, n_starts = len(contrast) - params.n_steps, params.unique_window // 2, piece.last - piece.first
    start, speed = np.empty(n_sequences, np.int64), np.empty(n_sequences, np.int64)
    sums, left, right = np.empty((n_sequences, 4)), np.empty((n_sequences, half)), np.empty((n_sequences, half))
    place_pieces_kernel.search_piece(contrast, params.offsets, n_starts, half, start, speed, sums, left, right)
    least = float(contrast[:, :n_starts].min()) if params.baseline == "observed" else np.inf
    return PieceLines(piece, start + piece.first, speed, sums, left, right, least)


def join_pieces(found: Sequence[PieceLines], params: SeqSlamParams) -> Lines:
    """The best line of all pieces and its rival, as if they had been searched as one."""
    half = params.unique_window // 2
    lowest = np.stack([lines.sums[:, 0] for lines in found])
    winner, each = lowest.argmin(axis=0), np.arange(lowest.shape[1])
    start = np.stack([lines.start for lines in found])[winner, each]
    route = np.array([lines.piece.route for lines in found])[winner]
    second = np.full(lowest.shape[1], np.inf)
    for k, lines in enumerate(found):
        rival = np.minimum(lines.sums[:, 2], _outside(lines, start, route, half))
        second = np.minimum(second, np.where(winner == k, lines.sums[:, 1], rival))
    greatest = np.max([lines.sums[:, 3] for lines in found], axis=0)
    is_line = greatest > lowest[winner, each]
    speed = np.stack([lines.speed for lines in found])[winner, each]
    least = min(lines.least for lines in found)
    return Lines(np.where(is_line, start, -1), speed, lowest[winner, each], second, least)


def joined_blocks(blocks: Sequence[Lines]) -> Lines:
    """Lines of all sequences from those of one block of them after the other."""
    start, speed, lowest, second, least = zip(*blocks, strict=True)
    return Lines(
        np.concatenate(start), np.concatenate(speed), np.concatenate(lowest), np.concatenate(second), min(least)
    )


def _outside(lines: PieceLines, start: Integers, route: Integers, half: int) -> Reals:
    """Least sum at the ends of a piece, outside the window about a start in another."""
    least = np.full(len(start), np.inf)
    piece = lines.piece
    for first, sums in ((piece.first, lines.left), (piece.last - half, lines.right)):
        distance = np.abs(first + np.arange(half) - start[:, None])
        is_outside = (distance > half) | (route != piece.route)[:, None]
        least = np.minimum(least, np.where(is_outside, sums, np.inf).min(axis=1, initial=np.inf))
    return least
