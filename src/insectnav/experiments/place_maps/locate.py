"""Frames located in a map: described as its places were, matched in sequences, judged where the truth is known."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_range, counted, quoted
from insectnav.datasets.key_frames import read_key_frames
from insectnav.experiments.place_maps.compare import Compared, compare
from insectnav.experiments.place_maps.describe import OF_PICTURES, DescribeParams
from insectnav.experiments.place_maps.describing import Described, Remarks, described, settled, stacked
from insectnav.experiments.place_maps.located import MAX_PLACES, Located
from insectnav.experiments.place_maps.opening import FrameParams, opened
from insectnav.experiments.place_maps.truth import (
    Truth,
    between_key_frames,
    by_position,
    from_pairs,
    read_pairs,
    same_index,
)
from insectnav.matching.difference import difference_matrix
from insectnav.matching.places import MapAbout, PlaceMap
from insectnav.matching.seqslam import SeqSlamParams

Reals = NDArray[np.floating[Any]]
MOST_BYTES_OF_PICTURES = 200_000_000  # kept while queries are located
TOLERANCE_FRAMES = 2.0  # [frame] as docs/place-recognition.md has it for Nordland


@dataclass(frozen=True, kw_only=True)
class TruthParams:
    """What is known of where the queries were taken; at most one of these.

    Parameters
    ----------
    pairs : table of queries and their places
    key_frames : table of some queries and their places, between which lines are straight
    same_index : whether query k was taken at place k
    tolerance_frames : up to which a match is right
    tolerance_m : with positions of the queries, up to which a match is right

    Raises
    ------
    InputError
        If they do not go together.
    """

    pairs: str | None = None
    key_frames: str | None = None
    same_index: bool = False
    tolerance_frames: float | None = None
    tolerance_m: float | None = None

    def __post_init__(self) -> None:
        given = [
            name
            for name, is_given in (
                ("--truth", self.pairs is not None),
                ("--key-frames", self.key_frames is not None),
                ("--same-index", self.same_index),
                ("--tolerance-m", self.tolerance_m is not None),
            )
            if is_given
        ]
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} are given, expected one kind of truth")
        if self.tolerance_frames is not None and not self.is_in_frames:
            raise InputError(
                "--tolerance-frames is given without a truth in frames, expected --same-index, --truth or --key-frames"
            )

    @property
    def is_in_frames(self) -> bool:
        """Whether the truth is told by numbers of frames."""
        return self.same_index or self.pairs is not None or self.key_frames is not None

    @property
    def tolerance(self) -> float:
        """In frames."""
        return TOLERANCE_FRAMES if self.tolerance_frames is None else self.tolerance_frames


@dataclass(frozen=True, kw_only=True)
class LocateParams:
    """How queries are located, matched and judged.

    Parameters
    ----------
    frames : which frames are taken
    seqslam : how sequences are searched
    search : "auto", "exact" or "index", as of `PlaceMap.locate`
    threshold : matches of this score or less are kept; None keeps all
    truth : TruthParams

    Raises
    ------
    InputError
        If the threshold is no score.
    """

    frames: FrameParams = field(default_factory=FrameParams)
    seqslam: SeqSlamParams = field(default_factory=SeqSlamParams)
    search: str = "auto"
    threshold: float | None = None
    truth: TruthParams = TruthParams()

    def __post_init__(self) -> None:
        if self.threshold is not None:
            check_range("threshold", self.threshold, 0.0, sys.float_info.max)


@dataclass(frozen=True, kw_only=True, eq=False)
class Search:
    """What came of it, with what a page needs.

    Parameters
    ----------
    found : matches, names, positions and truth
    features : (query, feature) of the queries
    difference : (place, query) after the best turn or rotation; None for other descriptors
    pictures : small ones of the queries, by number
    describe : how frames were described
    notes : what a person must know
    seqslam : how sequences were searched
    seconds : that describing and matching took
    """

    found: Located
    features: NDArray[np.float32]
    difference: NDArray[np.floating[Any]] | None
    pictures: Mapping[int, bytes]
    describe: DescribeParams
    notes: Sequence[str]
    seqslam: SeqSlamParams
    seconds: Mapping[str, float]

    def differences(
        self, place_map: PlaceMap, places: NDArray[np.int64], queries: NDArray[np.int64]
    ) -> NDArray[np.floating[Any]]:
        """Difference of some places and some queries, (place, query), as they were compared."""
        if self.difference is not None:
            return self.difference[np.ix_(places, queries)]
        known = np.asarray(place_map.descriptors[places])
        return difference_matrix(known, self.features[queries], place_map.about.metric)


def locate(
    place_map: PlaceMap, places: Sequence[str], params: LocateParams, progress: Callable[[int], Any] | None = None
) -> Search:
    """Locate frames in a map.

    Parameters
    ----------
    place_map : PlaceMap
    places : folders, patterns, films, an array, a recording
    params : LocateParams
    progress : called with the number of frames just described

    Raises
    ------
    InputError
        If no frame can be used, they are fewer than a sequence, or were described otherwise than the map.
    """
    started = time.perf_counter()
    about = place_map.about
    if not place_map.n_places:
        raise InputError(f"the map {quoted(place_map.path, 200)} is empty, expected places in it")
    given = opened(places, params.frames, about)
    describe, frames, notes = settled(given.frames, given.describe)
    remarks = Remarks()
    ready = described(frames, describe, params.frames.pictures, params.frames.workers)
    queries, pictures = _collected(ready, remarks, progress)
    features = stacked([one.features for one in queries], _n_features(queries), "")
    middle = time.perf_counter()
    compared = compare(place_map, features, describe, params.seqslam, params.search, params.frames.workers)
    found = _matched(compared, place_map, queries, params)
    found = replace(found, truth=_truth(found, place_map, params))
    said = _warnings(found, describe.is_vectors, about, params.truth.same_index)
    finished = time.perf_counter()
    return Search(
        found=found,
        features=features,
        difference=compared.difference,
        pictures=pictures,
        describe=describe,
        notes=[*given.notes, *notes, *remarks.sentences(""), *said],
        seqslam=params.seqslam,
        seconds={"describing": middle - started, "matching": finished - middle},
    )


def _collected(
    frames: Iterator[Described], remarks: Remarks, progress: Callable[[int], Any] | None
) -> tuple[list[Described], dict[int, bytes]]:
    """All queries, and small pictures of them by number, as many as there is memory for."""
    queries: list[Described] = []
    pictures: dict[int, bytes] = {}
    n_bytes = 0
    for one in frames:
        remarks.add(one)
        if one.picture and n_bytes < MOST_BYTES_OF_PICTURES:
            pictures[len(queries)] = one.picture
            n_bytes += len(one.picture)
        queries.append(replace(one, picture=b""))
        if progress is not None:
            progress(1)
    remarks.check_any()
    return queries, pictures


def _matched(compared: Compared, place_map: PlaceMap, queries: Sequence[Described], params: LocateParams) -> Located:
    """Matches with names and positions."""
    matches = compared.matches
    positions = np.stack([one.frame.position for one in queries])
    return Located(
        names=[one.frame.name for one in queries],
        frames=np.array([one.frame.number for one in queries]),
        times=np.array([one.frame.time for one in queries]),
        reference=np.asarray(matches.reference, np.int64),
        score=np.asarray(matches.score, np.float64),
        speed=np.asarray(matches.speed, np.float64),
        place_names=place_map.names,
        place_positions=np.asarray(place_map.positions),
        place_routes=np.asarray(place_map.routes),
        half_sequence=params.seqslam.n_steps // 2,
        threshold=params.threshold,
        angles_deg=compared.angles_deg,
        query_positions=positions if np.isfinite(positions[:, :2]).all(axis=1).any() else None,
    )


def _truth(found: Located, place_map: PlaceMap, params: LocateParams) -> Truth | None:
    """The truth that the user knows of."""
    known, where = params.truth, params.frames.where
    if known.tolerance_m is None:
        return truth_in_frames(found, known, True)
    if where.positions is None:
        raise InputError("--tolerance-m is given without --positions, expected a file of where the queries were")
    query = np.full((len(found.names), 3), np.nan) if found.query_positions is None else found.query_positions
    source = f"positions of {os.path.basename(where.positions)} (--positions), over the ground"
    return by_position(found.reference, query, found.place_positions, known.tolerance_m, source)


def truth_in_frames(found: Located, known: TruthParams, is_whole_map: bool) -> Truth | None:
    """The truth by numbers of frames; None if none is given.

    Parameters
    ----------
    found : Located
    known : TruthParams
    is_whole_map : whether its places are all of the map; if not, those that were matched, and all lie on one route

    Raises
    ------
    InputError
        If a table cannot be read, or names what is not there.
    """

    def routes_up_to(place: float) -> NDArray[np.int64]:
        if is_whole_map:
            return found.place_routes
        if place > MAX_PLACES:
            raise InputError(f"the truth names a place beyond {MAX_PLACES}, expected numbers of places of a map")
        return np.zeros(max(len(found.place_routes), 1 + int(place)), np.int64)

    if known.same_index:
        return same_index(found.reference, found.place_routes, known.tolerance, is_whole_map=is_whole_map)
    if known.pairs is not None:
        pairs = read_pairs(known.pairs, found.names, found.place_names, found.place_routes)
        routes = routes_up_to(max(chain.from_iterable(pairs.values()), default=-1))
        source = f"pairs of {os.path.basename(known.pairs)} (--truth)"
        return from_pairs(found.reference, pairs, known.tolerance, source, routes)
    if known.key_frames is not None:
        keys = read_key_frames(known.key_frames)
        source = f"straight lines between the key frames of {os.path.basename(known.key_frames)} (--key-frames)"
        routes = routes_up_to(float(np.max(keys[:, 1], where=np.isfinite(keys[:, 1]), initial=-1)))
        return between_key_frames(found.reference, keys, known.tolerance, source, routes)
    return None


def _warnings(found: Located, is_vectors: bool, about: MapAbout, is_same_index: bool) -> list[str]:
    """What a user may not have meant."""
    said = []
    if about.camera.startswith("panorama") and about.descriptor in OF_PICTURES and not is_vectors:
        said.append(
            f"{about.descriptor} takes for granted that the camera faces as it did in the map: a map with --descriptor "
            "turned-views, or of the sky, does not"
        )
    if is_vectors and about.settings.get("sky") is not None:
        said.append(f"the features are taken to be described as the map's, by {about.descriptor}: nothing tells")
    if is_same_index and (slip := _other_index(found)):
        said.append(slip)
    said.extend(on_other_routes(found))
    half = found.half_sequence
    if half:
        ends = "the first and the last query have" if half == 1 else f"the first and last {half} queries have"
        said.append(f"{ends} no match, since a sequence does not reach beyond them")
    inner = found.has_sequence & ~found.is_matched
    if inner.any():
        more = counted(int(inner.sum()), "more query has", "more queries have")
        said.append(f"{more} no match: too many frames missing, or nothing tells places apart")
    return said


def on_other_routes(found: Located) -> list[str]:
    """A note on matches that are wrong by a route, not by frames, if there are any."""
    truth = found.truth
    if truth is None or truth.unit != "frames":
        return []
    n_off = int((truth.is_known & truth.is_in_map & found.is_matched & np.isnan(truth.error)).sum())
    if not n_off:
        return []
    some = counted(n_off, "match lies", "matches lie")
    return [f"{some} on another route than the true place, and so wrong without an error in frames"]


def _other_index(found: Located) -> str:
    """That names of queries and places say something else than their numbers, if they do."""
    places = {name: k for k, name in enumerate(found.place_names) if name}
    pairs = [(k, places[name]) for k, name in enumerate(found.names) if name in places]
    off = [(k, place) for k, place in pairs if k != place]
    if not pairs or len(off) <= len(pairs) / 2 or found.place_routes.any():
        return ""
    query, place = off[0]
    return (
        f"query {query} and place {place} are both called {quoted(found.names[query])}, but --same-index takes query "
        f"{query} for place {query}: thinned otherwise than the map?"
    )


def _n_features(queries: Sequence[Described]) -> int:
    return next(len(one.features) for one in queries if one.features is not None)
