"""The visual compass of the paper on a walk: every tenth second of one day against all frames of the other."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import wrap
from insectnav.experiments.stone2014_places.route_pairs import SAMPLING, TOLERANCE, Run
from insectnav.experiments.stone2014_places.walk_frames import grey_of
from insectnav.experiments.stone2014_places.walks import Walk
from insectnav.matching import TurnMatrix, disk_turn_matrix, nearest_view, prepare_references, turn_matrix
from insectnav.matching.compass import N_TURNS
from insectnav.metrics.retrieval import position_error

REFERENCES_AT_ONCE = 500  # skies in memory: 250 MB


class CompassRun(NamedTuple):
    """What the compass makes of the queries of one day; (query,) arrays but for the days."""

    reference_day: str
    query_day: str
    queries: NDArray[np.int64]  # frames of the query walk
    reference: NDArray[np.int64]  # frames of the reference walk; -1 where there is none
    advised: NDArray[np.float64]  # [rad] direction that the compass says to walk in
    course: NDArray[np.float64]  # [rad] direction of the way
    error: NDArray[np.float64]  # [m] from the query to its match
    distance: NDArray[np.float64]  # [m] of the query along the way

    def is_right(self, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
        """Which queries have a match within the tolerance [m]."""
        return np.asarray(np.nan_to_num(self.error, nan=np.inf) <= tolerance)

    @property
    def is_matched(self) -> NDArray[np.bool_]:
        """Which queries have a match."""
        return self.reference >= 0

    @property
    def astray(self) -> NDArray[np.float64]:
        """Advised direction less the course, without sign [rad]."""
        return np.abs(wrap(self.advised - self.course))


def absolute_turns(references: ArrayLike, queries: ArrayLike, n_turns: int = N_TURNS) -> TurnMatrix:
    """Least mean absolute difference of each pair of panoramas of bytes over so many turns, and that turn.

    ``D[r, q] = min_k mean |reference[r] - query[q] turned right by k columns|``: for greys what the sum of an exclusive
    or is for bits.

    Parameters
    ----------
    references, queries : (view, rows, columns, ...) arrays of uint8
        Columns are a whole multiple of the turns.
    """
    reference, query = np.asarray(references), np.asarray(queries)
    known = prepare_references(reference.reshape(len(reference), -1), "absolute")
    shape = (len(reference), len(query))
    difference, turn = np.full(shape, np.inf), np.zeros(shape)
    step = query.shape[2] // n_turns
    for k in range(n_turns):
        turned = np.roll(query, -k * step, axis=2)
        one = known.differences(np.ascontiguousarray(turned.reshape(len(query), -1)), workers=1)
        is_better = one < difference
        difference[is_better], turn[is_better] = one[is_better], 2.0 * np.pi * k / n_turns
    return TurnMatrix(difference, wrap(turn))


def sky_turns(reference: Walk, query: Walk, queries: Any, *, centred: bool, reduction: int) -> TurnMatrix:
    """Turns of the skies of bits in the mirror, all frames of the reference walk at a time as memory allows."""
    seen = query.mirror_skies(queries, centred=centred, reduction=reduction)
    parts = []
    for first in range(0, len(reference), REFERENCES_AT_ONCE):
        frames = np.arange(first, min(first + REFERENCES_AT_ONCE, len(reference)))
        known = reference.mirror_skies(frames, centred=centred, reduction=reduction)
        parts.append(disk_turn_matrix(known, seen, workers=1))
    return TurnMatrix(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def grey_turns(reference: Walk, query: Walk, queries: Any) -> TurnMatrix:
    """Turns of unwrapped grey pictures of 180 × 28 pixels."""
    return absolute_turns(grey_of(reference["colours"]), grey_of(query["colours"][queries]))


def normal_turns(reference: Walk, query: Walk, queries: Any) -> TurnMatrix:
    """The same without brightness and contrast, by the root mean square."""

    def in_turns(colours: Any) -> Any:
        grey = grey_of(colours)  # two columns are a turn of 4°: one of them goes below the other
        return np.concatenate([grey[..., 0::2], grey[..., 1::2]], axis=1)

    return turn_matrix(in_turns(reference["colours"]), in_turns(query["colours"][queries]), workers=1)


def colour_turns(reference: Walk, query: Walk, queries: Any) -> TurnMatrix:
    """Turns of unwrapped colours of 90 × 14 pixels."""

    def small(colours: Any) -> Any:
        rows, columns = colours.shape[1] // 2, colours.shape[2] // 2
        blocks = colours.reshape(len(colours), rows, 2, columns, 2, 3).mean(axis=(2, 4))
        return np.rint(blocks).astype(np.uint8)

    return absolute_turns(small(reference["colours"]), small(query["colours"][queries]))


def queries_of(walk: Walk) -> NDArray[np.int64]:
    """One frame every ten seconds from the first on."""
    return walk.sampled(0, SAMPLING)


def found(reference: Walk, query: Walk, queries: NDArray[np.int64], turns: TurnMatrix) -> CompassRun:
    """The nearest of all frames after any turn: no memory of the sequence."""
    nearest = nearest_view(turns)
    return _compass_run(reference, query, queries, nearest.reference, nearest.turn)


def found_after(reference: Walk, query: Walk, run: Run, queries: NDArray[np.int64], turns: TurnMatrix) -> CompassRun:
    """SeqSLAM first, then the turn that fits its match."""
    if not np.array_equal(queries, run.queries):
        raise ValueError("the compass and SeqSLAM have other queries")
    match = np.where(run.is_matched, run.references[run.matches.reference], -1)
    turn = np.where(run.is_matched, turns.turn[match, np.arange(len(queries))], np.nan)
    return _compass_run(reference, query, queries, match, turn)


def _compass_run(reference: Walk, query: Walk, queries: Any, match: Any, turn: Any) -> CompassRun:
    return CompassRun(
        reference.day,
        query.day,
        queries,
        match,
        np.asarray(wrap(query["heading"][queries] + turn)),
        query["course"][queries],
        np.asarray(position_error(reference["position"], query["position"][queries], match)),
        query["distance"][queries],
    )


def both_directions(walks: Mapping[str, Walk]) -> list[tuple[Walk, Walk]]:
    """Reference and query walk, each day once as either."""
    first, second = walks.values()
    return [(first, second), (second, first)]
