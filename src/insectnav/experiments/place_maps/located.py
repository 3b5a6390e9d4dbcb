"""Queries located in a map: matches, names and positions together, their table, and what they amount to in numbers."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.experiments.place_maps.truth import Truth, read_cells
from insectnav.metrics.retrieval import (
    PrecisionRecall,
    area_under_curve,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
)

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]
MATCH_COLUMNS = (
    "query",
    "name",
    "frame",
    "time_s",
    "reference",
    "reference_name",
    "route",
    "score",
    "speed",
    "is_kept",
    "x",
    "y",
    "z",
)
READ_COLUMNS = ("query", "frame", "reference", "route", "score", "speed", "time_s", "has_sequence", *"xyz")
MAX_PLACES = 10_000_000  # of a table of matches, whose places in between take memory, too
ANGLE_COLUMNS = ("heading_deg", "pitch_deg", "roll_deg")  # of the query in the frame of its match


@dataclass(frozen=True, kw_only=True, eq=False)
class Located:
    """Queries and their matches.

    Parameters
    ----------
    names, times : (query,) of the queries; times [s], NaN if unknown
    reference : (query,) number of the place, −1 where there is none
    score, speed : (query,) as of `insectnav.matching.Matches`
    place_names, place_positions, place_routes : (place,) of the map; positions (place, 3) [m], NaN if unknown
    half_sequence : queries at either end that have no whole sequence about them
    threshold : matches of this score or less are kept; None keeps all
    angles_deg : (query, 3) heading, pitch and roll of each query in the frame of its match [°]; None if unknown
    query_positions : (query, 3) [m], NaN if unknown; None if no query has one
    truth : None if nothing is known
    frames : (query,) number of each among all frames of its source, from 0; None if all frames were taken
    """

    names: Sequence[str]
    times: Reals
    reference: Integers
    score: Reals
    speed: Reals
    place_names: Sequence[str]
    place_positions: Reals
    place_routes: Integers
    half_sequence: int = 0
    threshold: float | None = None
    angles_deg: Reals | None = None
    query_positions: Reals | None = None
    truth: Truth | None = None
    frames: Integers | None = None

    @property
    def is_matched(self) -> Bools:
        """Whether each query has a match."""
        return np.asarray(self.reference >= 0)

    @property
    def is_kept(self) -> Bools:
        """Whether each query has a match that is good enough."""
        if self.threshold is None:
            return self.is_matched
        with np.errstate(invalid="ignore"):
            return np.asarray(self.is_matched & (self.score <= self.threshold))

    @property
    def has_sequence(self) -> Bools:
        """Whether each query has a whole sequence about it."""
        query = np.arange(len(self.reference))
        return np.asarray((query >= self.half_sequence) & (query < len(query) - self.half_sequence))

    @property
    def positions(self) -> Reals:
        """Where each query was, by its match, (query, 3) [m]; NaN where there is none or it is not known."""
        places = self.place_positions[np.maximum(self.reference, 0)]
        return np.where(self.is_matched[:, None], places, np.nan)

    @property
    def can_be_matched(self) -> Bools:
        """Whether a right match of each query exists: its place in the map, and a whole sequence about it."""
        if self.truth is None:
            return self.has_sequence
        return self.truth.is_known & self.truth.is_in_map & self.has_sequence

    def curve(self) -> PrecisionRecall | None:
        """Precision and recall at all scores; None without a truth, or if no query can be matched.

        Queries that cannot be judged count for nothing.
        """
        if self.truth is None or not self.can_be_matched.any():
            return None
        score = np.where(self.truth.is_known & self.is_matched, self.score, np.nan)
        able = self.can_be_matched | (self.truth.is_right & np.isfinite(score))
        return precision_recall(self.truth.is_right, score, able)

    def rows(self) -> list[dict[str, Any]]:
        """One for each query, for a table."""
        truth, kept, place, whole = self.truth, self.is_kept, self.positions, self.has_sequence
        frames = range(len(self.names)) if self.frames is None else self.frames.tolist()
        rows = []
        for k, reference in enumerate(self.reference.tolist()):
            row: dict[str, Any] = {
                "query": k,
                "name": self.names[k],
                "frame": frames[k],
                "time_s": float(self.times[k]),
                "reference": reference,
                "reference_name": self.place_names[reference] if reference >= 0 else "",
                "route": int(self.place_routes[reference]) if reference >= 0 else "",
                "score": float(self.score[k]),
                "speed": float(self.speed[k]),
                "is_kept": int(kept[k]),
                "has_sequence": int(whole[k]),
                **{axis: float(place[k, n]) for n, axis in enumerate("xyz")},
            }
            if self.angles_deg is not None:
                row |= dict(zip(ANGLE_COLUMNS, self.angles_deg[k].round(9).tolist(), strict=True))
            if truth is not None:
                row |= {
                    "true_reference": _number_of_place(float(truth.reference[k])),
                    "is_right": int(truth.is_right[k]) if truth.is_known[k] and reference >= 0 else "",
                    "error": float(truth.error[k]),
                    "error_unit": truth.unit,
                }
            rows.append(row)
        return rows


def numbers(found: Located) -> dict[str, Any]:
    """What the matches amount to: counts, precision and recall, errors; by name.

    Parameters
    ----------
    found : Located
    """
    result: dict[str, Any] = {
        "queries": len(found.reference),
        "places": len(found.place_names),
        "matched": int(found.is_matched.sum()),
        "kept": int(found.is_kept.sum()),
        "score_median": _median(found.score[found.is_matched]),
        "speed_median": _median(found.speed[found.is_matched]),
    }
    if found.threshold is not None:
        result["threshold"] = found.threshold
    truth, curve = found.truth, found.curve()
    if truth is None:
        return result
    judged = truth.is_known & found.is_matched
    kept = truth.is_known & found.is_kept
    result |= {
        "judged": int(judged.sum()),
        "kept_judged": int(kept.sum()),
        "kept_right": int((truth.is_right & kept).sum()),
        "can_be_matched": int(found.can_be_matched.sum()),
        "right": int((truth.is_right & judged).sum()),
        "tolerance": truth.tolerance,
        "unit": truth.unit,
    }
    if curve is not None:
        result |= {
            "precision_of_all": precision_at_full_recall(curve),
            "recall_of_all": float(curve.recall[-1]) if len(curve.recall) else 0.0,
            "recall_at_full_precision": recall_at_full_precision(curve),
            "threshold_of_full_precision": _last_threshold(curve),
            "area": area_under_curve(curve),
        }
    if found.threshold is not None:
        n_right, n_able = result["kept_right"], result["can_be_matched"]
        result |= {
            "precision_kept": n_right / int(kept.sum()) if kept.any() else None,
            "recall_kept": n_right / n_able if n_able else None,
        }
    errors = truth.error[kept & np.isfinite(truth.error)]
    if errors.size:
        result |= {
            "errors_known": int(errors.size),
            "error_median": float(np.median(errors)),
            "error_mean": float(errors.mean()),
            "error_90_percent": float(np.quantile(errors, 0.9)),
            "error_largest": float(errors.max()),
        }
    return result


def read_matches(path: str | os.PathLike[str]) -> Located:
    """Matches of a table that `insectnav map locate` wrote, without what only the map knows.

    Raises
    ------
    InputError
        If it is no such table.
    """
    place = Path(path)
    lines, cells = read_cells(place)
    shown = quoted(place.name, 200)
    missing = [name for name in ("query", "reference", "score") if name not in cells]
    if missing:
        raise InputError(
            f"{shown} lacks the column{'s' if len(missing) > 1 else ''} {', '.join(missing)}, expected a table of "
            "matches as `insectnav map locate` writes it"
        )
    values = {name: _column(cells, name, lines, shown) for name in READ_COLUMNS}
    if not np.array_equal(values["query"], np.arange(len(lines))):
        raise InputError(
            f"{shown} does not number its queries 0, 1, 2, …, expected all of them in order: sorted or cut?"
        )
    reference = _whole_numbers(values["reference"], "reference", -1, lines, shown)
    if (lacks := np.flatnonzero((reference >= 0) & np.isnan(values["score"]))).size:
        raise InputError(f"line {lines[lacks[0]]} of {shown} has a match without a score, expected one for each match")
    routes = _whole_numbers(np.where(reference >= 0, values["route"], 0.0), "route", 0, lines, shown)
    frames = np.where(np.isnan(values["frame"]), values["query"], values["frame"])
    return _without_map(cells, reference, routes, _whole_numbers(frames, "frame", 0, lines, shown), values)


def _whole_numbers(values: Reals, name: str, missing: int, lines: Integers, shown: str) -> Integers:
    """Values of a column that counts, from `missing`, which an empty cell stands for."""
    counts = np.where(np.isnan(values), missing, values)
    is_off = (counts != np.round(counts)) | (counts < missing) | (counts > MAX_PLACES)
    if is_off.any():
        row = int(np.argmax(is_off))
        raise InputError(
            f"line {lines[row]} of {shown} has the {name} {counts[row]:g}, expected a whole number from {missing} to "
            f"{MAX_PLACES}"
        )
    return np.asarray(counts, np.int64)


def _without_map(
    cells: dict[str, list[str]], reference: Integers, route: Integers, frames: Integers, values: dict[str, Reals]
) -> Located:
    """Of the map the places that were matched: those in between have neither names nor positions."""
    n_places = int(reference.max(initial=0)) + 1  # one at least, which no query matches if none has a match
    names, positions = [""] * n_places, np.full((n_places, 3), np.nan)
    routes, unnamed = np.zeros(n_places, np.int64), [""] * len(reference)
    for name, place in zip(cells.get("reference_name", unnamed), reference.tolist(), strict=True):
        if place >= 0:
            names[place] = name
    seen = reference[reference >= 0]
    routes[seen] = route[reference >= 0]
    positions[seen] = np.stack([values[axis] for axis in "xyz"], axis=-1)[reference >= 0]
    return Located(
        names=cells.get("name", unnamed),
        times=values["time_s"],
        reference=reference,
        score=values["score"],
        speed=values["speed"],
        place_names=names,
        place_positions=positions,
        place_routes=routes,
        half_sequence=int(np.argmax(values["has_sequence"] != 0)),  # all of them where the table does not say
        frames=frames,
    )


def _column(cells: dict[str, list[str]], name: str, lines: Integers, shown: str) -> Reals:
    values = np.full(len(lines), np.nan)
    for number, text in enumerate(cells.get(name, ())):
        if text:
            try:
                values[number] = float(text)
            except ValueError:
                raise InputError(
                    f"line {lines[number]} of {shown} has the {name} {quoted(text)}, expected a number"
                ) from None
    return values


def write_rows(file: Any, rows: Sequence[dict[str, Any]]) -> None:
    """Rows of `Located.rows` as CSV to an open file; numbers with all digits they have, NaN as an empty cell."""
    names = list(rows[0]) if rows else list(MATCH_COLUMNS)
    writer = csv.writer(file)
    writer.writerow(names)
    for row in rows:
        writer.writerow([_cell(row[name]) for name in names])


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return repr(float(value)).removesuffix(".0") if np.isfinite(value) else ""
    return value


def _number_of_place(value: float) -> int | float | str:
    """Number of a true place, between two of them as a fraction; an empty cell where there is none."""
    if not np.isfinite(value):
        return ""
    return int(value) if value.is_integer() else value


def _median(values: Reals) -> float:
    return float(np.median(values)) if values.size else float("nan")


def _last_threshold(curve: PrecisionRecall) -> float:
    """Largest score up to which every match is right; NaN if the best match is wrong."""
    is_whole = curve.precision == 1.0
    return float(curve.threshold[is_whole].max()) if is_whole.any() else float("nan")
