"""The route pairs of the paper, SeqSLAM on each of them, and precision and recall of all together."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.stone2014_places.walks import Walk
from insectnav.matching import OPENSEQSLAM_V1, Matches, SeqSlamParams, difference_matrix, seqslam
from insectnav.metrics.retrieval import (
    PrecisionRecall,
    position_error,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
)

SAMPLING = 10  # [s] from frame to frame of a set, section II-F
# To a right match; the paper tells none. Two frames of a set: OpenSeqSLAM v1 places a match up to one frame from where
# its line runs, and the nearest frame of the other set may be half a frame away.
TOLERANCE = 30.0  # [m]
TOLERANCES = (10.0, 20.0, TOLERANCE, 70.0)  # [m] also told; the last is five frames, as Stone et al., ICRA 2016, count
STRETCH = 100.0  # [m] of way that are drawn together for standard errors
N_DRAWS = 400  # of stretches of way
Features = Callable[[Walk], NDArray[Any]]  # (frame, feature)


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A reference set and a test set: their days, and the second at which each begins."""

    reference_day: str
    reference_start: int
    query_day: str
    query_start: int


def route_pairs(days: Sequence[str] = ("january", "april"), every: int = 1) -> list[Pair]:
    """All runs: both directions of each route pair, 38 of 19 pairs if there is a frame every second.

    Notes
    -----
    A set from the first frame of either day against ten sets of the other are twenty pairs of sets, of which one occurs
    twice, that of both first frames. The other reading, the twenty runs whose reference is the set from the first
    frame, is that of `begins_at_first`.
    """
    first, second = days
    starts = range(0, SAMPLING, every)
    of_sets = {(0, start) for start in starts} | {(start, 0) for start in starts}
    pairs = []
    for one, other in sorted(of_sets):
        pairs.append(Pair(reference_day=first, reference_start=one, query_day=second, query_start=other))
        pairs.append(Pair(reference_day=second, reference_start=other, query_day=first, query_start=one))
    return pairs


def begins_at_first(pair: Pair) -> bool:
    """Whether the reference set begins with the first frame of its day."""
    return pair.reference_start == 0


class Run(NamedTuple):
    """What SeqSLAM makes of a pair; (query,) arrays but for the pair and the references."""

    pair: Pair
    references: NDArray[np.int64]  # (reference,) frames of the reference walk
    queries: NDArray[np.int64]  # frames of the query walk
    matches: Matches
    error: NDArray[np.float64]  # [m] from the query to its match, NaN where there is none
    distance: NDArray[np.float64]  # [m] of the query along the way

    @property
    def is_matched(self) -> NDArray[np.bool_]:
        """Which queries have a match."""
        return self.matches.reference >= 0

    def is_right(self, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
        """Which queries have a match within the tolerance [m]."""
        return self.is_matched & (np.nan_to_num(self.error, nan=np.inf) <= tolerance)

    @property
    def curve(self) -> PrecisionRecall:
        """Precision and recall of this run alone."""
        return precision_recall(self.is_right(), self.matches.score)


def run_pair(
    walks: Mapping[str, Walk],
    features: Mapping[str, NDArray[Any]],
    metric: str,
    pair: Pair,
    params: SeqSlamParams = OPENSEQSLAM_V1,
    query_features: Mapping[str, NDArray[Any]] | None = None,
) -> Run:
    """SeqSLAM on one pair; features (frame, feature) of each day, of the queries others if given."""
    reference, query = walks[pair.reference_day], walks[pair.query_day]
    references = reference.sampled(pair.reference_start, SAMPLING)
    queries = query.sampled(pair.query_start, SAMPLING)
    of_queries = (features if query_features is None else query_features)[pair.query_day]
    difference = difference_matrix(features[pair.reference_day][references], of_queries[queries], metric, workers=1)
    matches = seqslam(difference, params, workers=1)
    error = position_error(reference["position"][references], query["position"][queries], matches.reference)
    return Run(pair, references, queries, matches, np.asarray(error), query["distance"][queries])


class Score(NamedTuple):
    """Shares of all runs together, with standard errors."""

    recall: float  # at full precision
    recall_error: float
    precision: float  # of all matches
    precision_error: float
    curve: PrecisionRecall


def pooled(runs: Sequence[Run], tolerance: float = TOLERANCE) -> Score:
    """Precision and recall of all matches of all runs under one threshold.

    Standard errors are those of drawing stretches of 100 m of the way, which are what a walk has many of; runs share
    their frames and are no trials of their own.
    """
    right = np.concatenate([run.is_right(tolerance) for run in runs])
    score = np.concatenate([run.matches.score for run in runs])
    stretch = np.floor(np.concatenate([run.distance for run in runs]) / STRETCH).astype(int)
    is_matched = np.isfinite(score)
    right, score, stretch = right[is_matched], score[is_matched], stretch[is_matched]
    curve = precision_recall(right, score)
    drawn = []
    for counts in draws_of(stretch):
        of_draw = precision_recall(np.repeat(right, counts), np.repeat(score, counts))
        drawn.append((recall_at_full_precision(of_draw), precision_at_full_recall(of_draw)))
    recall_error, precision_error = np.std(drawn, axis=0, ddof=1)
    return Score(
        recall_at_full_precision(curve), float(recall_error), precision_at_full_recall(curve), float(precision_error),
        curve,
    )  # fmt: skip


def draws_of(stretch: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """How often each trial is drawn if its stretch of way is drawn as a whole, with replacement, N_DRAWS times."""
    rng = np.random.Generator(np.random.PCG64(0))
    _, number = np.unique(stretch, return_inverse=True)
    n = int(number.max()) + 1
    counts = [np.bincount(rng.integers(0, n, n), minlength=n)[number] for _ in range(N_DRAWS)]
    return [count for count in counts if count.any()]


def share_of(is_right: NDArray[np.bool_], distance: NDArray[np.float64]) -> tuple[float, float]:
    """Share of right trials and its standard error, by stretches of the way as in `pooled`."""
    stretch = np.floor(distance / STRETCH).astype(int)
    drawn = [float(np.repeat(is_right, counts).mean()) for counts in draws_of(stretch)]
    return float(is_right.mean()), float(np.std(drawn, ddof=1))


class Answers(Protocol):
    """Matches of queries along a way, as `Run` has them; (query,) arrays."""

    @property
    def distance(self) -> NDArray[np.float64]:
        """Along the way [m]."""
        ...

    @property
    def is_matched(self) -> NDArray[np.bool_]:
        """Which queries have a match."""
        ...

    def is_right(self) -> NDArray[np.bool_]:
        """Which queries have a right match."""
        ...


SomeAnswers = TypeVar("SomeAnswers", bound=Answers)


def less_of(
    runs: Sequence[SomeAnswers],
    others: Sequence[SomeAnswers],
    chosen: NDArray[np.bool_] | None = None,
    is_so: Callable[[SomeAnswers], NDArray[np.bool_]] | None = None,
) -> tuple[float, float]:
    """Share of all matches for which something is so less that in other runs of the same queries, and standard error.

    It is precision unless `is_so` is given, (query,) of a run. The same stretches are drawn for both: one where both
    fail says nothing of their difference. Of the chosen queries if some are given, (query,) of all runs; NaN where
    either has no match among them.
    """
    distance = np.concatenate([run.distance for run in runs])
    if len(distance) != sum(len(run.distance) for run in others):
        raise ValueError("runs are compared with runs of other queries")
    so, other_so = (
        np.concatenate([run.is_right() if is_so is None else is_so(run) for run in each]).astype(float)
        for each in (runs, others)
    )
    kept, other_kept = (np.concatenate([run.is_matched for run in each]) for each in (runs, others))
    if chosen is not None:
        kept, other_kept = kept & chosen, other_kept & chosen
    if not (kept.any() and other_kept.any()):
        return float("nan"), float("nan")
    some = kept | other_kept
    drawn = []
    for counts in draws_of(np.floor(distance[some] / STRETCH).astype(int)):
        weights = [counts * kept[some], counts * other_kept[some]]
        if all(weight.any() for weight in weights):
            one, other = (
                np.average(values[some], weights=weight) for values, weight in zip((so, other_so), weights, strict=True)
            )
            drawn.append(one - other)
    return float(so[kept].mean() - other_so[other_kept].mean()), float(np.std(drawn, ddof=1))


def contrast_of(values: NDArray[Any], chosen: NDArray[np.bool_], distance: NDArray[np.float64]) -> tuple[float, float]:
    """Mean of the chosen values less that of the others, and its standard error, by stretches as in `pooled`.

    NaN where all or none are chosen.
    """
    if chosen.all() or not chosen.any():
        return float("nan"), float("nan")
    drawn = []
    for counts in draws_of(np.floor(distance / STRETCH).astype(int)):
        weights = [counts * chosen, counts * ~chosen]
        if all(weight.any() for weight in weights):
            drawn.append(np.average(values, weights=weights[0]) - np.average(values, weights=weights[1]))
    return float(values[chosen].mean() - values[~chosen].mean()), float(np.std(drawn, ddof=1))
