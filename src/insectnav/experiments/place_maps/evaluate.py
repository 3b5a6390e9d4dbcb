"""Matches judged by what is known of the truth: those of a table, or those just made."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.experiments.place_maps.locate import LocateParams, Search, on_other_routes, truth_in_frames
from insectnav.experiments.place_maps.located import Located, numbers, read_matches
from insectnav.experiments.place_maps.opening import check_one_frame
from insectnav.experiments.place_maps.page import lead_sentence
from insectnav.experiments.place_maps.report import summary
from insectnav.experiments.place_maps.truth import Truth, by_position
from insectnav.experiments.place_maps.whereabouts import check_clock_of_positions, position_table, positions_by_key
from insectnav.matching.places import MapAbout, PlaceMap

NO_TRUTH = "nothing is known of the truth, expected --same-index, --truth FILE, or --positions FILE with --tolerance-m"


def evaluate_search(search: Search, params: LocateParams, place_map: PlaceMap) -> dict[str, Any]:
    """What matches amount to that were just made, with precision and recall at all scores.

    Raises
    ------
    InputError
        If nothing is known of the truth.
    """
    if search.found.truth is None:
        raise InputError(NO_TRUTH)
    return summary(search, params, place_map) | {"curve": _curve(search.found)}


def evaluate_table(path: str | os.PathLike[str], params: LocateParams, place_map: str | None) -> dict[str, Any]:
    """What the matches of a table amount to, with precision and recall at all scores.

    Parameters
    ----------
    path : of a table of `insectnav map locate`
    params : of which the truth, the threshold and the positions of the queries are used
    place_map : folder of the map; None to know of its places only what the table says

    Raises
    ------
    InputError
        If it is no such table, or nothing is known of the truth.
    """
    found = replace(read_matches(path), threshold=params.threshold)
    notes = []
    if place_map is not None:
        opened = PlaceMap.open(place_map)
        if opened.n_places < len(found.place_names):
            raise InputError(
                f"the table has matches up to place {len(found.place_names) - 1}, expected a map with as many: "
                "another map?"
            )
        _check_names(found, opened.names)
        found = replace(
            found,
            place_names=opened.names,
            place_positions=np.asarray(opened.positions),
            place_routes=np.asarray(opened.routes),
        )
    elif params.truth.tolerance_m is not None:
        notes.append("without --map, only places that were matched are known: recall counts queries near one of these")
    about = None if place_map is None else opened.about
    found = replace(found, truth=_truth(found, params, about))
    notes.extend(on_other_routes(found))
    values = numbers(found) | ({} if place_map is not None else {"places": None})
    source = "" if found.truth is None else found.truth.source
    return {
        "matches": str(path),
        "lead": lead_sentence(values),
        "numbers": values,
        "truth": source,
        "notes": notes,
        "curve": _curve(found),
    }


def _check_names(found: Located, names: Sequence[str]) -> None:
    """Refuse a map whose places are called otherwise than in the table, where that has names."""
    for place in np.unique(found.reference[found.is_matched]).tolist():
        said, there = found.place_names[place], names[place]
        if said and not _is_same_name(said, there):
            raise InputError(
                f"place {place} is called {quoted(said)} in the table and {quoted(there)} in the map, expected the map "
                "that the frames were located in"
            )


def _is_same_name(said: str, there: str) -> bool:
    """Whether names are the same; of numbers a spreadsheet may have dropped zeros, or digits after the sixth."""
    with suppress(ValueError):
        return said == there or math.isclose(float(said), float(there), rel_tol=1e-5)
    return False


def _truth(found: Located, params: LocateParams, about: MapAbout | None) -> Truth:
    known, where, is_whole_map = params.truth, params.frames.where, about is not None
    if known.is_in_frames and not is_whole_map and found.place_routes.any():
        raise InputError("the matches lie on several routes, expected --map to know where each begins")
    truth = truth_in_frames(found, known, is_whole_map)
    if truth is not None:
        return truth
    check_clock_of_positions(where)
    table = position_table(where, about.origin_deg if about else None)
    if known.tolerance_m is None or where.positions is None or table is None:
        raise InputError(NO_TRUTH)
    if about is not None:
        check_one_frame(table.origin_deg, about.origin_deg)
    elif table.origin_deg is not None:
        raise InputError("--positions are latitudes and longitudes, expected --map for the origin of its x and y")
    times = found.times if np.isfinite(found.times).any() else None
    query = positions_by_key(table, where, found.names, times, found.frames)
    if query is None:
        raise InputError(
            f"{quoted(where.positions, 200)} has times, which the table of matches has not, expected names or numbers "
            "of frames"
        )
    source = f"positions of {Path(where.positions).name} (--positions), over the ground"
    return by_position(found.reference, query, found.place_positions, known.tolerance_m, source)


def _curve(found: Located) -> dict[str, Any] | None:
    curve = found.curve()
    if curve is None:
        return None
    return {"precision": curve.precision, "recall": curve.recall, "threshold": curve.threshold}
