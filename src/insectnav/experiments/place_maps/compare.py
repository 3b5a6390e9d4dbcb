"""Matches of queries with the places of a map: by the map's own search, after all turns, or after all rotations."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import wrap
from insectnav.checks import InputError
from insectnav.experiments.place_maps.describe import COMPARED, ROTATED, DescribeParams
from insectnav.experiments.place_maps.view_cameras import grid, grid_resampler
from insectnav.matching.compass import TurnMatrix, turn_matrix, turns_of_matches
from insectnav.matching.difference import prepare_references
from insectnav.matching.place_exact_search import matches_of_differences
from insectnav.matching.places import MapAbout, PlaceMap
from insectnav.matching.rotation import build_rotation_index
from insectnav.matching.rotation_matches import RotationMatches
from insectnav.matching.seqslam import Matches, SeqSlamParams, no_matches

Reals = NDArray[np.floating[Any]]
Features = NDArray[np.float32]


DIFFERENCES_AT_ONCE = 10_000_000


class Compared(NamedTuple):
    """Matches, and how each query was turned against its match.

    Parameters
    ----------
    matches : Matches
    angles_deg : (query, 3) heading, pitch and roll of the query in the frame of its match [°], NaN where not known;
        None where the descriptor says nothing of it
    difference : (place, query) after the best turn or rotation, NaN for missing frames; None where it is not kept
    """

    matches: Matches
    angles_deg: Reals | None = None
    difference: Reals | None = None


def compare(
    place_map: PlaceMap,
    features: Features,
    describe: DescribeParams,
    params: SeqSlamParams,
    search: str,
    workers: int | None,
) -> Compared:
    """The place that each query matches best.

    Parameters
    ----------
    place_map : PlaceMap
    features : (query, feature) array, a row of NaN for a missing frame
    describe : how they were described
    params : how sequences are searched
    search : "auto", "exact" or "index", as of `PlaceMap.locate`
    workers : threads

    Raises
    ------
    InputError
        If they were described otherwise than the map, or are fewer than a sequence.
    """
    about = place_map.about
    own = MapAbout(
        descriptor=describe.descriptor,
        metric=describe.used_metric,
        n_features=features.shape[1],
        camera="" if describe.is_vectors else describe.camera.text,
        settings=about.settings if describe.is_vectors else describe.settings(),
    )
    if describe.is_vectors or describe.descriptor not in COMPARED:
        if params.n_steps == 0 and search != "index":
            about.check_same(own, "the queries")
            return Compared(_most_alike(place_map, features, params, workers))
        return Compared(place_map.locate(features, params, about=own, search=search, workers=workers))
    about.check_same(own, "the queries")
    if search == "index":
        raise InputError(
            f"--search index is given with {describe.descriptor}, expected exact or auto: all are compared"
        )
    params.check_length(len(features), "query", "queries")
    if describe.descriptor == ROTATED:
        return _rotated(place_map, features, describe, params, workers)
    return _turned(place_map, features, describe, params, workers)


def _turn_matrix(known: Features, seen: Features, describe: DescribeParams, workers: int | None) -> TurnMatrix:
    size = describe.view_size or (1, known.shape[1])
    views = (vectors.reshape(-1, *size) for vectors in (known, seen))
    return turn_matrix(*views, normalise=not describe.is_of_sky, workers=workers)


def _turned(
    place_map: PlaceMap, features: Features, describe: DescribeParams, params: SeqSlamParams, workers: int | None
) -> Compared:
    """Matches of views after the best of all turns: of sequences, or the most alike of single views."""
    known, routes = np.asarray(place_map.descriptors), np.asarray(place_map.routes)
    difference = _turn_matrix(known, features, describe, workers).difference
    if params.n_steps == 0:
        matches = _nearest(difference, routes, params.unique_window // 2)
    else:
        matches = matches_of_differences(difference, routes, params, workers)
    size = describe.view_size or (1, known.shape[1])
    compass = turns_of_matches(
        known.reshape(-1, *size), features.reshape(-1, *size), matches.reference, normalise=not describe.is_of_sky
    )
    angles = np.full((len(features), 3), np.nan)
    angles[:, 0] = np.rad2deg(wrap(-compass.turn))  # the heading is that of the match less the turn
    return Compared(matches, angles, difference)


def _most_alike(place_map: PlaceMap, features: Features, params: SeqSlamParams, workers: int | None) -> Matches:
    """The most alike place of each single frame, a few queries at a time."""
    references = prepare_references(np.asarray(place_map.descriptors), place_map.about.metric)
    routes, half = np.asarray(place_map.routes), params.unique_window // 2
    size = max(1, DIFFERENCES_AT_ONCE // len(routes))
    parts = [
        _nearest(references.differences(features[first : first + size], workers=workers), routes, half)
        for first in range(0, len(features), size)
    ]
    return Matches(*(np.concatenate([part[k] for part in parts]) for k in range(3)))


def _nearest(difference: Reals, routes: NDArray[np.int64], half_window: int) -> Matches:
    """The most alike place of each single view; its score is its difference over the least of other places."""
    n_queries = difference.shape[1]
    matches = no_matches(n_queries)
    for query in range(n_queries):
        column = np.where(np.isnan(difference[:, query]), np.inf, difference[:, query])
        best, finite = int(column.argmin()), column[np.isfinite(column)]
        if not finite.size or (finite.size > 1 and finite.max() == column[best]):  # nothing tells places apart
            continue
        matches.reference[query], matches.score[query] = best, _score(column, best, routes, half_window)
    return matches


def _least_elsewhere(column: Reals, best: int, routes: NDArray[np.int64], half_window: int) -> float:
    """The least of a column (place,) outside the window about its best place; inf if there is none."""
    is_other = (np.abs(np.arange(len(column)) - best) > half_window) | (routes != routes[best])
    return float(column[is_other].min(initial=np.inf))


def _score(column: Reals, best: int, routes: NDArray[np.int64], half_window: int) -> float:
    """Difference of a query from its match over the least from places outside the window, at most 1; inf: missing."""
    second = _least_elsewhere(column, best, routes, half_window)
    return min(float(column[best]) / second, 1.0) if 0.0 < second < np.inf else 1.0


def _rotated(
    place_map: PlaceMap, features: Features, describe: DescribeParams, params: SeqSlamParams, workers: int | None
) -> Compared:
    """Matches of skies after the best of all rotations, over what both saw: of sequences, or of single skies."""
    known, routes = np.asarray(place_map.descriptors), np.asarray(place_map.routes)
    seen = grid_resampler(describe.camera, describe.view_size or (0, 0)).seen
    usable = np.flatnonzero(_has_sky_and_ground(known, seen))
    if not usable.size:
        raise InputError("no place of the map has sky and ground, expected some: missing frames, or a covered lens?")
    index = build_rotation_index(np.clip(known[usable], 0.0, 1.0), seen, grid())
    queries = np.flatnonzero(_has_sky_and_ground(features, seen))
    skies, n_queries = np.clip(features[queries], 0.0, 1.0), len(features)
    difference, angles = np.full((len(known), n_queries), np.nan, np.float32), np.full((n_queries, 3), np.nan)
    if not queries.size:
        return Compared(no_matches(n_queries), angles, difference)
    if params.n_steps == 0:
        single, compared = index.match_and_compare(skies, seen)
        difference[np.ix_(usable, queries)] = compared.T
        matches, half = no_matches(n_queries), params.unique_window // 2
        matches.reference[queries] = usable[single.reference]
        columns = np.where(np.isnan(difference), np.inf, difference).T
        for query in queries.tolist():
            matches.score[query] = _score(columns[query], int(matches.reference[query]), routes, half)
        angles[queries] = _angles_deg(single)
        return Compared(matches, angles, difference)
    difference[np.ix_(usable, queries)] = index.compare(skies, seen).T
    matches = matches_of_differences(difference, routes, params, workers)
    number = np.full(len(known), -1)
    number[usable] = np.arange(len(usable))
    for sky, query in zip(skies, queries.tolist(), strict=True):
        place = matches.reference[query]
        if place >= 0 and number[place] >= 0:
            angles[query] = _angles_deg(index.part([number[place]]).match(sky, seen))
    return Compared(matches, angles, difference)


def _angles_deg(found: RotationMatches) -> Reals:
    """Heading, pitch and roll of each query in the frame of its match, (..., 3) [°]."""
    return np.rad2deg(np.stack([found.heading, found.pitch, found.roll], axis=-1))


def _has_sky_and_ground(views: Features, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which views (view, direction) are there and have more than one value where they were seen."""
    values = views[:, seen]
    return np.asarray(np.isfinite(values).all(axis=1) & (np.ptp(values, axis=1) > 1e-3))
