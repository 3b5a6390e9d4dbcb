"""Which matches are right: by the number of the frame, by a table of pairs, or by where the frames were taken."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_range, quoted
from insectnav.datasets.frame_times import frame_name
from insectnav.datasets.text_tables import open_table, read_columns
from insectnav.metrics.place_truth import true_matches_by_frames, true_matches_by_position, within
from insectnav.metrics.retrieval import position_error

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]
NOWHERE = -1  # in place of the number of a route
QUERY_COLUMNS, REFERENCE_COLUMNS = ("query", "query_name"), ("reference", "reference_name")


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What is known of the true places of the queries.

    Parameters
    ----------
    reference : (query,) number of the true place in the map, the nearest one where there are several; NaN where it is
        not known, or not in the map
    error : (query,) how far each match is from the truth, in `unit`; NaN where there is no match or no truth
    is_known : (query,) whether the match can be judged
    is_in_map : (query,) whether a right match exists
    tolerance : error up to which a match is right
    unit : "m" or "frames"
    source : where the truth is from, in words
    """

    reference: Reals
    error: Reals
    is_known: Bools
    is_in_map: Bools
    tolerance: float
    unit: str
    source: str

    @property
    def is_right(self) -> Bools:
        """Whether each match is within the tolerance."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.is_known & (self.error <= self.tolerance))


def quantity(value: float, unit: str) -> str:
    """A number with its unit, as a person writes it: 0.25 m, 1 frame, 2 frames."""
    return f"{value:.3g} {'frame' if unit == 'frames' and value == 1.0 else unit}"


def same_index(matched: Integers, routes: Integers, tolerance: float, *, is_whole_map: bool = True) -> Truth:
    """Truth of two recordings frame by frame in step: query k was taken at place k of each route.

    Parameters
    ----------
    matched : (query,) number of the place of each, −1 where there is none
    routes : (place,) number of the route of each place
    tolerance : [frame]
    is_whole_map : whether these are all places; if not, every query is taken to have one
    """
    check_range("tolerance-frames", tolerance, 0.0, np.inf)
    _, firsts, route, lengths = np.unique(routes, return_index=True, return_inverse=True, return_counts=True)
    query, own = np.arange(len(matched)), route[np.maximum(matched, 0)]
    reference = np.full(len(matched), np.nan) if is_whole_map else query.astype(float)
    for first, length in zip(firsts[::-1], lengths[::-1], strict=True):  # ends with the first that goes so far
        reference[:length] = first + query[:length]
    is_in_own = (matched >= 0) & (query < lengths[own])
    reference = np.where(is_in_own, firsts[own] + query, reference)
    is_in_map = np.isfinite(reference)
    within = matched - firsts[own]
    error = np.where((matched >= 0) & is_in_map, np.abs(within - query), np.nan)
    return Truth(
        reference=reference,
        error=error,
        is_known=np.ones(len(matched), bool),
        is_in_map=is_in_map,
        tolerance=float(tolerance),
        unit="frames",
        source="query k was taken at place k of each route (--same-index)",
    )


def from_pairs(
    matched: Integers, pairs: Mapping[int, Sequence[int]], tolerance: float, source: str, routes: Integers
) -> Truth:
    """Truth of a table: the places of each query, one on each route that came by; other queries are not judged.

    A match on a route for which the table has no place of its query is wrong, and off by no number of frames.

    Parameters
    ----------
    matched : (query,) number of the place of each, −1 where there is none
    pairs : numbers of the places by the number of the query; none of one that is not in the map
    tolerance : [frame]
    source : in words
    routes : (place,) number of the route of each place
    """
    check_range("tolerance-frames", tolerance, 0.0, np.inf)
    reference, is_known = np.full(len(matched), np.nan), np.zeros(len(matched), bool)
    for query, places in pairs.items():
        for place in places or (-1,):
            if not 0 <= query < len(matched) or not -1 <= place < len(routes):
                raise InputError(
                    f"the truth pairs query {query} with place {place}, expected queries 0 to {len(matched) - 1} and "
                    f"places 0 to {len(routes) - 1}, or −1 for none: of another map, or thinned otherwise?"
                )
        is_known[query] = True
        own = [place for place in places if matched[query] >= 0 and routes[place] == routes[matched[query]]]
        reference[query] = next(iter([*own, *places]), np.nan)
    return Truth(
        reference=reference,
        error=_frames_off(matched, reference, routes),
        is_known=is_known,
        is_in_map=np.isfinite(reference),
        tolerance=float(tolerance),
        unit="frames",
        source=source,
    )


def between_key_frames(matched: Integers, key_frames: Reals, tolerance: float, source: str, routes: Integers) -> Truth:
    """Truth between frames that a person has matched; queries before the first and after the last are not judged.

    Nor are those between key frames of two routes, which no line leads from one to the other.

    Parameters
    ----------
    matched : (query,) number of the place of each, −1 where there is none
    key_frames : (key frame, 2) numbers of queries and places, as of `metrics.place_truth.true_matches_by_frames`
    tolerance : [frame]
    source : in words
    routes : (place,) number of the route of each place
    """
    check_range("tolerance-frames", tolerance, 0.0, np.inf)
    slip = "of another recording, or thinned otherwise?"
    check_range("key frames of the queries", key_frames[:, 0], 0, len(matched) - 1, slip=slip)
    places = key_frames[np.isfinite(key_frames[:, 1]), 1]
    check_range("key frames of the map", places, 0, len(routes) - 1, slip=slip)
    queries = np.arange(len(matched))
    true = true_matches_by_frames(key_frames, queries)
    is_between = _is_between_routes(key_frames, routes, queries)
    reference = np.where(is_between, np.nan, true.reference)
    return Truth(
        reference=reference,
        error=_frames_off(matched, reference, routes),
        is_known=np.asarray(true.is_known & ~is_between),
        is_in_map=np.isfinite(reference),
        tolerance=float(tolerance),
        unit="frames",
        source=source,
    )


def _frames_off(matched: Integers, reference: Reals, routes: Integers) -> Reals:
    """Frames from the true place to the match on the same route; NaN where one is missing, or they are on two."""
    is_both = (matched >= 0) & np.isfinite(reference)
    true = np.where(is_both, reference, 0).astype(np.int64)
    is_one_route = routes[np.maximum(matched, 0)] == routes[true]
    return np.where(is_both & is_one_route, np.abs(matched - reference), np.nan)


def _is_between_routes(key_frames: Reals, routes: Integers, queries: Integers) -> Bools:
    """Which queries lie between two key frames of different routes."""
    is_place = np.isfinite(key_frames[:, 1])
    route = np.where(is_place, routes[np.where(is_place, key_frames[:, 1], 0).astype(np.int64)], -1)
    after = np.clip(np.searchsorted(key_frames[:, 0], queries), 1, len(key_frames) - 1)
    is_seam = (route[after] != route[after - 1]) & is_place[after] & is_place[after - 1]
    return np.asarray(is_seam & (queries > key_frames[after - 1, 0]) & (queries < key_frames[after, 0]))


def by_position(
    matched: Integers, query_positions: Reals, reference_positions: Reals, tolerance: float, source: str
) -> Truth:
    """Truth by distance over the ground between where a query and its match were taken.

    Parameters
    ----------
    matched : (query,) number of the place of each, −1 where there is none
    query_positions : (query, 2 or 3) array [m]; NaN where it is not known: such queries are not judged
    reference_positions : (place, 2 or 3) array [m]; a match with a place of unknown position is not judged
    tolerance : [m]
    source : in words
    """
    check_range("tolerance-m", tolerance, 0.0, np.inf)
    query, places = query_positions[:, :2], reference_positions[:, :2]
    has_position, has_place = (np.asarray(np.isfinite(one).all(axis=1)) for one in (query, places))
    if not has_position.any() or not has_place.any():
        what = "query" if not has_position.any() else "place of the map"
        raise InputError(f"no {what} has a position, expected some for a truth by --positions: other names or times?")
    nearest = true_matches_by_position(places, query, np.inf).reference
    distance = position_error(places, query, np.where(has_position, nearest, -1.0))
    error = position_error(places, query, matched)
    error = np.where(within(error, tolerance, query, places), np.minimum(error, tolerance), error)
    return Truth(
        reference=nearest,
        error=error,
        is_known=has_position & ((matched < 0) | has_place[np.maximum(matched, 0)]),
        is_in_map=has_position & within(distance, tolerance, query, places),
        tolerance=float(tolerance),
        unit="m",
        source=source,
    )


def read_pairs(
    path: str | os.PathLike[str], query_names: Sequence[str], reference_names: Sequence[str], routes: Integers
) -> dict[int, tuple[int, ...]]:
    """Pairs of a table with the columns query and reference, which hold numbers from 0 or names of frames.

    An empty reference, or −1, says that the query is not in the map, and several rows of one query that several routes
    came by its place.

    Parameters
    ----------
    path : of the table
    query_names, reference_names : of the frames
    routes : (place,) number of the route of each place, as far as it is known

    Raises
    ------
    InputError
        If it is no such table, names what is not there, or gives a query two places on one route.
    """
    lines, cells = read_cells(Path(path))
    shown = quoted(Path(path).name, 200)
    query = next((name for name in QUERY_COLUMNS if name in cells), None)
    reference = next((name for name in REFERENCE_COLUMNS if name in cells), None)
    if query is None or reference is None:
        raise InputError(f"--truth {shown} has the columns {', '.join(cells)}, expected query and reference")
    of_query, of_reference = _numbers_by_name(query_names), _numbers_by_name(reference_names)
    slip = ": one that nothing was matched with, as --map would know?" if "" in reference_names else ""
    by_route: dict[int, dict[int, int]] = {}
    for line, own_text, text in zip(lines, cells[query], cells[reference], strict=True):
        own = _number(own_text, of_query, f"line {line} of --truth {shown} names the query")
        known = (
            -1
            if text in ("", "-1")
            else _number(text, of_reference, f"line {line} of --truth {shown} names the place", slip)
        )
        places = by_route.setdefault(own, {})
        route = NOWHERE if known < 0 else int(routes[known]) if known < len(routes) else 0
        if places.setdefault(route, known) != known or (NOWHERE in places and len(places) > 1):
            raise InputError(
                f"line {line} of --truth {shown} gives query {own} another place than a line above, expected one "
                "for each on a route: names that are numbers, which count before the numbers from 0?"
            )
    return {own: tuple(place for place in places.values() if place >= 0) for own, places in by_route.items()}


def read_cells(path: Path) -> tuple[Integers, dict[str, list[str]]]:
    """Lines (row,) of a table with a header, and the cells of each column, by its name.

    Raises
    ------
    InputError
        If it is no such table.
    """
    try:
        table = open_table(path)
        lines, _, columns = read_columns(table, [], list(range(len(table.header))))
    except InputError as error:
        raise InputError(f"{quoted(path.name, 200)}: {error}") from None
    return lines, dict(zip(table.header, columns, strict=True))


def _numbers_by_name(names: Sequence[str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for number, name in enumerate(names):
        found[name] = None if name in found else number  # a name that occurs twice says nothing
    return found


def _number(text: str, names: Mapping[str, Any], start: str, slip: str = "") -> int:
    if (number := names.get(text, names.get(frame_name(text)))) is not None:
        return int(number)
    with suppress(ValueError):
        if (number := int(text)) >= 0:
            return number
    raise InputError(f"{start} {quoted(text)}, expected a number from 0 or the name of one frame{slip}")
