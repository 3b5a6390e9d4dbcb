"""What a page says of places found again: numbers with their meaning, and everything that was set or assumed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from insectnav.checks import counted
from insectnav.experiments.place_maps.describe import ROTATED
from insectnav.experiments.place_maps.locate import LocateParams, Search
from insectnav.experiments.place_maps.truth import quantity
from insectnav.matching.places import PlaceMap

SAID = {  # of the numbers: what they are called, how they are written, what they are
    "queries": ("Queries", "d", "frames that were looked for"),
    "places": ("Places", "d", "in the map"),
    "matched": ("Matched", "d", "queries with a match, whatever its score"),
    "kept": ("Kept", "d", "matches whose score is at most the threshold; all where there is none"),
    "score_median": ("Score, median", ".3f", "of all matches: 0 is unique, 1 as good as another place"),
    "speed_median": ("Speed, median", ".2f", "places of the map per query"),
    "judged": ("Judged", "d", "matches of which it is known whether they are right"),
    "can_be_matched": (
        "Can be matched",
        "d",
        "queries whose place is in the map and that have a whole sequence about them",
    ),
    "right": ("Right", "d", "matches within the tolerance"),
    "kept_judged": ("Kept and judged", "d", "matches kept of which it is known whether they are right"),
    "kept_right": ("Kept and right", "d", "of these"),
    "precision_of_all": ("Precision of all matches", ".1%", "right matches of all that are judged, at full recall"),
    "recall_of_all": ("Recall of all matches", ".1%", "right matches of all queries that can be matched"),
    "recall_at_full_precision": ("Recall at 100 % precision", ".1%", "of the best matches before the first wrong one"),
    # With all its digits, or as --threshold it would leave out the last right match, or let a wrong one in.
    "threshold_of_full_precision": ("Score of the same", "", "up to which no match is wrong: a --threshold"),
    "area": ("Area under the curve", ".3f", "of precision over recall, by steps"),
    "threshold": ("Threshold", "", "given"),
    "precision_kept": ("Precision of what is kept", ".1%", "right matches of those kept"),
    "recall_kept": ("Recall of what is kept", ".1%", "right matches kept of all queries that can be matched"),
    "errors_known": ("Errors known", "d", "matches kept of which it is known how far off they are"),
    "error_median": ("Error, median", ".3g", "from the true place, of the matches kept"),
    "error_mean": ("Error, mean", ".3g", "of the same"),
    "error_90_percent": ("Error, 90 %", ".3g", "nine of ten matches are nearer"),
    "error_largest": ("Error, largest", ".3g", "of the same"),
}


def tiles(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The few numbers that matter most: value, what it is.

    Parameters
    ----------
    values : of `located.numbers`
    """
    found = [
        (
            f"{values['kept']} / {values['queries']}",
            "queries with a match" + (" that is kept" if "threshold" in values else ""),
        )
    ]
    if values.get("precision_kept") is not None:
        found.append((f"{values['precision_kept']:.1%}", "of these are right"))
        if values["recall_kept"] is not None:
            found.append((f"{values['recall_kept']:.1%}", "of what can be matched is found"))
    elif "precision_of_all" in values:
        if np.isfinite(values["precision_of_all"]):  # not where there is no match that can be judged
            found.append((f"{values['precision_of_all']:.1%}", "of all matches are right"))
        found.append((f"{values['recall_at_full_precision']:.1%}", "recall before the first wrong match"))
    if "error_median" in values:
        found.append((quantity(values["error_median"], values["unit"]), "off in the median"))
    if "precision_of_all" not in values and values["matched"]:
        found.append((f"{values['score_median']:.2f}", "median score (0 unique, 1 ambiguous)"))
        if np.isfinite(values["speed_median"]):
            found.append((f"{values['speed_median']:.2f}", "places per query"))
    return found


def numbers_in_words(values: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """All numbers that are known: what they are called, how they are written, what they are.

    Parameters
    ----------
    values : of `located.numbers`
    """
    rows = []
    for name, (title, form, what) in SAID.items():
        value = values.get(name)
        if value is None or (isinstance(value, float) and not np.isfinite(value)):
            continue
        shown = quantity(value, values["unit"]) if name.startswith("error_") else format(value, form)
        rows.append((title, shown, what))
    if "tolerance" in values:
        rows.append(("Tolerance", quantity(values["tolerance"], values["unit"]), "up to which a match is right"))
    return rows


def search_in_words(search: Search, by: str) -> str:
    """How matches were found, with the lengths that windows of places have on the ground.

    Parameters
    ----------
    search : Search
    by : "auto", "exact" or "index", as of `PlaceMap.locate`
    """
    seqslam, found = search.seqslam, search.found
    steps = np.linalg.norm(np.diff(found.place_positions[:, :2], axis=0), axis=1)[np.diff(found.place_routes) == 0]
    known = steps[np.isfinite(steps)]

    def places(count: int) -> str:
        return counted(count, "place") + (f" ({count * float(np.median(known)):.3g} m)" if known.size else "")

    around = places(seqslam.unique_window // 2)
    if not seqslam.n_steps:
        best, differences = "the most alike place", "difference"
        if search.describe.descriptor == ROTATED and not search.describe.is_vectors:
            best = "after all rotations the place with the least mean squared difference over what both saw"
            differences = "difference in the coarse search"
        return (
            f"frames one by one, {best}; the score is its {differences} over the least of all places farther than "
            f"{around} from it"
        )
    return (
        f"SeqSLAM (Milford & Wyeth 2012): sequences of {seqslam.n_steps + 1} frames, {seqslam.slowest:g} to "
        f"{seqslam.fastest:g} places per query, contrast over {places(seqslam.contrast_window)}, score against all "
        f"starts farther than {around}; search {by}"
    )


def settings_in_words(search: Search, params: LocateParams, place_map: PlaceMap) -> list[tuple[str, str]]:
    """Everything that was set or assumed: name, value.

    Parameters
    ----------
    search : Search
    params : LocateParams
    place_map : PlaceMap
    """
    found = search.found
    origin = place_map.about.origin_deg
    places, routes = counted(place_map.n_places, "place"), counted(int(found.place_routes.max()) + 1, "route")
    rows = [
        ("Map", f"{place_map.path}, {places} on {routes}"),
        *search.describe.in_words(),
        ("Frames taken", params.frames.thinning.in_words),
        ("Matched by", search_in_words(search, params.search)),
        ("Threshold", "none: all matches are kept" if found.threshold is None else f"scores up to {found.threshold}"),
        ("Truth", "none is known" if found.truth is None else f"{found.truth.source}, right within "
         + quantity(found.truth.tolerance, found.truth.unit)),
    ]  # fmt: skip
    if found.truth is not None:
        rows.append(
            ("Recall counts", "queries whose place is in the map and that have a whole sequence about them; a query "
             "that cannot be judged counts for nothing")
        )  # fmt: skip
    if origin is not None:
        rows.append(("Origin of x and y", f"latitude {origin[0]:.6f}°, longitude {origin[1]:.6f}° (x east, y north)"))
    describing, matching = search.seconds["describing"], search.seconds["matching"]
    rows.append(("Time taken", f"{describing:.2f} s to read and describe, {matching:.2f} s to match"))
    return rows
