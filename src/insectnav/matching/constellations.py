"""Lookup by constellations: peaks of a sequence of spectra as keys, which stay when the speed changes."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, check_range
from insectnav.matching.difference import checked_vectors
from insectnav.matching.seqslam import Matches, no_matches

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
SPEED_STEP = 1.1  # from one speed that is tried to the next


@dataclass(frozen=True, kw_only=True)
class ConstellationParams:
    """How keys are made and looked up; no published system has these numbers, all are assumed."""

    peak_frames: int = 2  # [frame] to either side, within which a peak is the highest
    peak_features: int = 2  # [feature] the same
    longest: int = 30  # [frame] from the first to the last peak of a constellation
    n_neighbours: int = 8  # peaks after the first that it is combined with, two at a time
    ratio_bins: int = 16  # in which the place of the second peak between first and third is told apart
    slowest: float = 0.5  # [reference frame per query frame]
    fastest: float = 2.0  # [reference frame per query frame]
    sequence_length: int = 40  # [frame] of the query that vote for the place of the middle one
    place_frames: int = 2  # [frame] of the reference within which votes are for one place
    unique_window: int = 10  # [frame] of the reference beyond which a place is another

    def __post_init__(self) -> None:
        for name in ("peak_frames", "peak_features", "longest", "n_neighbours", "ratio_bins", "sequence_length"):
            check_count(name, getattr(self, name))
        check_count("place_frames", self.place_frames, minimum=0)
        check_count("unique_window", self.unique_window, minimum=0)
        check_range("slowest", self.slowest, 0.01, 100.0)
        check_range("fastest", self.fastest, self.slowest, 100.0, slip="slowest and fastest interchanged?")


class Constellations(NamedTuple):
    """Triples of peaks, (triple,) arrays."""

    key: Integers  # of the three features and the ratio of the two times between them
    frame: Integers  # of the first peak
    span: Integers  # [frame] from the first peak to the third


@dataclass(frozen=True, kw_only=True, eq=False)
class ConstellationIndex:
    """Constellations of a route, sorted by key; made by `constellation_index`.

    Parameters
    ----------
    constellations : sorted by key
    mean, deviation : (feature,) of the references, by which queries are scaled too
    n_references : frames of the route
    params : ConstellationParams
    """

    constellations: Constellations
    mean: Reals
    deviation: Reals
    n_references: int
    params: ConstellationParams


class Hits(NamedTuple):
    """Pairs of a constellation of the query and one of the reference, (pair,) arrays."""

    frame: Integers  # of the query, first peak
    reference: Integers  # frame of the reference, first peak
    slowest: Reals  # [reference frame per query frame] the speeds that are possible
    fastest: Reals  # [reference frame per query frame]


def constellation_index(references: ArrayLike, params: ConstellationParams | None = None) -> ConstellationIndex:
    """Constellations of a route, to be looked up by `locate_by_constellations`.

    Parameters
    ----------
    references : (reference, feature) array
        Spectra along a route, as of `harmonic_amplitudes`, neighbouring features side by side; NaN for missing frames.
    params : ConstellationParams

    Raises
    ------
    InputError
        If these are no finite spectra.

    Notes
    -----
    Stone 2017, thesis, section 4.4.4, proposes to take the amplitudes of a sequence of skies as a spectrogram and to
    look up constellations of its peaks as music is recognised (Wang 2003, An industrial-strength audio search
    algorithm, ISMIR). There a key is two frequencies and the time between them; a change of speed changes the time.
    Here a key is three features and the ratio of two times, which stays. Each feature is scaled to mean 0 and standard
    deviation 1 along the route, so that all of them have peaks.
    """
    params = params or ConstellationParams()
    vectors, is_missing = checked_vectors("references", references)
    values = vectors.astype(np.float64)
    known = values[~is_missing]
    if not len(known):
        raise InputError("all references are missing, expected some with a descriptor")
    mean, deviation = known.mean(axis=0), known.std(axis=0)
    deviation = np.where(deviation > 1e-9 * np.abs(mean), deviation, np.inf)
    found = _constellations(_scaled(values, is_missing, mean, deviation), params)
    order = np.argsort(found.key, kind="stable")
    return ConstellationIndex(
        constellations=Constellations(*(array[order] for array in found)),
        mean=mean,
        deviation=deviation,
        n_references=len(values),
        params=params,
    )


def locate_by_constellations(index: ConstellationIndex, queries: ArrayLike) -> Matches:
    """The place on the route for which most constellations about each query vote.

    Parameters
    ----------
    index : ConstellationIndex
    queries : (query, feature) array
        Spectra in the order in which they were taken; NaN for missing frames.

    Returns
    -------
    Matches
        The score is the number of votes of the next best place over that of the best, 0 unique … 1 as good as another;
        −1 and NaN where no constellation is known. The speed is that at which most agree, of a series in steps of 1.1.

    Raises
    ------
    InputError
        If the queries are not of the references' kind.

    Notes
    -----
    Two constellations of one key vote for ``r + v (q − f)`` as the place of query q, with r and f the frames of their
    first peaks, at each speed v that the frames they span allow. The place is the median of the votes of the densest
    spot. Time does not grow with the route, but with the constellations that share a key.
    """
    params = index.params
    vectors, is_missing = checked_vectors("queries", queries)
    if vectors.shape[1] != len(index.mean):
        raise InputError(
            f"queries have {vectors.shape[1]} features, expected {len(index.mean)} as the references: "
            "the same descriptor?"
        )
    values = _scaled(vectors.astype(np.float64), is_missing, index.mean, index.deviation)
    hits = _hits(index, _constellations(values, params))
    n_queries, half = len(values), params.sequence_length // 2
    matches = no_matches(n_queries)
    starts = np.searchsorted(hits.frame, np.arange(n_queries) - half)
    ends = np.searchsorted(hits.frame, np.arange(n_queries) + half, side="right")
    for query in range(n_queries):
        about = slice(starts[query], ends[query])
        near = Hits(hits.frame[about], hits.reference[about], hits.slowest[about], hits.fastest[about])
        found = _best_place(near, query, index.n_references, params)
        if found is not None:
            matches.reference[query], matches.score[query], matches.speed[query] = found
    return matches


def _scaled(values: Reals, is_missing: NDArray[np.bool_], mean: Reals, deviation: Reals) -> Reals:
    """Deviations from the mean of each feature; missing frames have no peak."""
    return np.where(is_missing[:, None], -np.inf, (values - mean) / deviation)


def _peaks(values: Reals, params: ConstellationParams) -> tuple[Integers, Integers]:
    """Frame and feature of what is higher than all about it, and than the mean, by frame and then by feature."""
    from scipy.ndimage import maximum_filter

    size = (2 * params.peak_frames + 1, 2 * params.peak_features + 1)
    highest = maximum_filter(values, size=size, mode="constant", cval=-np.inf)
    frame, feature = np.nonzero((values == highest) & (values > 0.0))
    return frame.astype(np.int64), feature.astype(np.int64)


def _constellations(values: Reals, params: ConstellationParams) -> Constellations:
    """Each peak with pairs of those that follow it, in three different frames."""
    frame, feature = _peaks(values, params)
    pieces = []
    after = np.searchsorted(frame, frame, side="right")  # the first peak of a later frame
    for i in range(params.n_neighbours):
        for j in range(i + 1, params.n_neighbours):
            first = np.flatnonzero(after + j < len(frame))
            second, third = after[first] + i, after[first] + j
            keep = (frame[third] > frame[second]) & (frame[third] - frame[first] <= params.longest)
            pieces.append(np.stack([first[keep], second[keep], third[keep]]))
    first, second, third = np.concatenate(pieces, axis=1) if pieces else np.empty((3, 0), np.int64)
    span = frame[third] - frame[first]
    ratio = (frame[second] - frame[first]) / np.maximum(span, 1)
    n, n_bins = values.shape[1], params.ratio_bins
    ratio_bin = np.minimum((ratio * n_bins).astype(np.int64), n_bins - 1)
    key = ((feature[first] * n + feature[second]) * n + feature[third]) * n_bins + ratio_bin
    return Constellations(key, frame[first], span)


def _hits(index: ConstellationIndex, found: Constellations) -> Hits:
    """Pairs of constellations with one key, by frame of the query."""
    known, params = index.constellations, index.params
    order = np.argsort(found.frame, kind="stable")
    found = Constellations(*(array[order] for array in found))
    low, high = (np.searchsorted(known.key, found.key, side=side) for side in ("left", "right"))
    count = high - low
    query = np.repeat(np.arange(len(found.key)), count)
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    reference = low[query] + within
    # A peak lies at a whole frame, so that a span may be off by one in either.
    slowest = (known.span[reference] - 1.0) / (found.span[query] + 1.0)
    fastest = (known.span[reference] + 1.0) / (found.span[query] - 1.0)
    keep = (fastest >= params.slowest) & (slowest <= params.fastest)
    return Hits(found.frame[query[keep]], known.frame[reference[keep]], slowest[keep], fastest[keep])


def _best_place(
    hits: Hits, query: int, n_references: int, params: ConstellationParams
) -> tuple[int, float, float] | None:
    """Place with most votes at any speed, next best place's share of them, and the speed; None without votes."""
    n_speeds = 1 + 2 * round(np.log(params.fastest / params.slowest) / np.log(SPEED_STEP) / 2.0)  # 0.5 … 1 … 2
    n_best, best, speed, rivals = 0, 0, np.nan, []
    for v in np.geomspace(params.slowest, params.fastest, n_speeds):
        is_voter = (hits.slowest <= v) & (hits.fastest >= v)
        place = np.sort(hits.reference[is_voter] + v * (query - hits.frame[is_voter]))
        place = place[(place > -0.5) & (place < n_references - 0.5)]
        if not place.size:
            continue
        low = np.searchsorted(place, place - params.place_frames)
        high = np.searchsorted(place, place + params.place_frames, side="right")
        votes = high - low
        top = int(np.argmax(votes))
        rivals.append((place, votes))
        if votes[top] > n_best:
            n_best, best, speed = int(votes[top]), round(float(np.median(place[low[top] : high[top]]))), float(v)
    if not n_best:
        return None
    far = (votes[np.abs(place - best) > params.unique_window].max(initial=0) for place, votes in rivals)
    return best, max(far) / n_best, speed
