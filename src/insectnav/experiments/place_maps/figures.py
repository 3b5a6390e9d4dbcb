"""Figures of places found again: matches, the matrix of differences, precision over recall, the route, pairs."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.figures import (
    COLOURS,
    DOUBLE_COLUMN,
    RATES,
    journal_style,
    name_panel,
)
from insectnav.experiments.place_maps.located import Located
from insectnav.experiments.place_maps.truth import quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]
MOST_CELLS = 800  # of a side of the matrix that is drawn
MOST_LINES = 400  # from wrong matches to where the queries were


def match_kinds(found: Located) -> list[tuple[str, Bools, str, str]]:
    """Kinds of matches: word, which queries, colour, marker; told apart without colour, too.

    Parameters
    ----------
    found : Located
    """
    kept = found.is_kept
    if found.truth is None:
        return [("match", kept, COLOURS["blue"], ".")]
    right, known = found.truth.is_right, found.truth.is_known
    kinds = [
        ("right", kept & right, COLOURS["green"], "."),
        ("wrong", kept & known & ~right, COLOURS["red"], "x"),
        ("not judged", kept & ~known, COLOURS["grey"], "+"),
    ]
    return [kind for kind in kinds if kind[1].any()]


def draw_matches(found: Located, difference: Reals, places: Integers, queries: Integers) -> Figure:
    """Matches over the queries with their scores, and in the matrix of differences.

    Parameters
    ----------
    found : Located
    difference : (some places, some queries) array
    places, queries : numbers of these
    """
    from matplotlib.figure import Figure

    with journal_style():
        figure = Figure(figsize=(DOUBLE_COLUMN, 3.4), layout="constrained")
        axes = figure.subplot_mosaic("ab;cb", height_ratios=[3.0, 1.0], width_ratios=[1.0, 1.0])
        _draw_correspondences(axes["a"], found)
        _draw_scores(axes["c"], found)
        axes["c"].sharex(axes["a"])
        axes["a"].tick_params(labelbottom=False)
        _draw_matrix(axes["b"], found, difference, places, queries)
        for letter, title in (("a", "matches"), ("b", "differences"), ("c", "")):
            name_panel(axes[letter], letter, title)
    return figure


def _draw_correspondences(axes: Axes, found: Located) -> None:
    query = np.arange(len(found.reference))
    if found.truth is not None:
        axes.plot(*_truth_by_route(found), color=COLOURS["black"], linewidth=0.7, alpha=0.6, label="truth", zorder=1)
    for word, which, colour, marker in match_kinds(found):
        axes.plot(
            query[which], found.reference[which], marker, color=colour, markersize=3.0 if marker == "." else 3.5,
            markeredgewidth=0.8 if marker != "." else 0.0, label=f"{word} ({which.sum()})",
        )  # fmt: skip
    for first in np.flatnonzero(np.diff(found.place_routes)) + 1:
        axes.axhline(first - 0.5, color=COLOURS["grey"], linewidth=0.5, linestyle=":")
    axes.set(
        ylabel="place in the map", xlim=(-0.5, len(query) - 0.5), ylim=(-0.5, max(1, len(found.place_names)) - 0.5)
    )
    _legend(axes, loc="best", borderaxespad=0.2, handletextpad=0.4)


def _truth_by_route(found: Located) -> tuple[Reals, Reals]:
    """Queries and their true places, with a gap where the truth goes on along another route."""
    if found.truth is None:
        return np.empty(0), np.empty(0)
    reference = found.truth.reference
    places = np.clip(np.nan_to_num(reference), 0, len(found.place_routes) - 1).astype(np.int64)
    seams = np.flatnonzero(np.diff(found.place_routes[places])) + 1
    return np.insert(np.arange(len(reference), dtype=float), seams, np.nan), np.insert(reference, seams, np.nan)


def _legend(axes: Axes, **how: Any) -> None:
    """A legend, where there is something to name."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(**how)


def _draw_scores(axes: Axes, found: Located) -> None:
    query = np.arange(len(found.reference))
    for _, which, colour, marker in match_kinds(found):
        axes.plot(query[which], found.score[which], marker, color=colour, markersize=2.0, markeredgewidth=0.6)
    dropped = found.is_matched & ~found.is_kept
    axes.plot(query[dropped], found.score[dropped], ".", color=COLOURS["grey"], markersize=1.5, alpha=0.6)
    if found.threshold is not None:
        axes.axhline(found.threshold, color=COLOURS["black"], linewidth=0.6, linestyle="--")
    top = np.nanmax(found.score) if found.is_matched.any() else 1.0
    axes.set(xlabel="query", ylabel="score", ylim=(0.0, max(1.0, 1.05 * float(top))))


def _draw_matrix(axes: Axes, found: Located, difference: Reals, places: Integers, queries: Integers) -> None:
    from matplotlib.colors import Normalize

    finite = difference[np.isfinite(difference)]
    low, high = np.quantile(finite, (0.01, 0.99)) if finite.size else (0.0, 1.0)
    step = [float(values[1] - values[0]) if len(values) > 1 else 1.0 for values in (queries, places)]
    image = axes.imshow(
        difference, cmap=RATES, norm=Normalize(float(low), float(high)), aspect="auto", origin="lower",
        interpolation="nearest",
        extent=(queries[0] - 0.5, queries[-1] - 0.5 + step[0], places[0] - 0.5, places[-1] - 0.5 + step[1]),
    )  # fmt: skip
    axes.figure.colorbar(image, ax=axes, fraction=0.05, pad=0.02).set_label("difference")
    query = np.arange(len(found.reference))
    for word, which, _, marker in match_kinds(found):
        colour = COLOURS["red"] if word == "wrong" else "white"
        axes.plot(
            query[which], found.reference[which], marker, color=colour, markersize=1.4 if marker == "." else 2.4,
            markeredgewidth=0.6 if marker != "." else 0.0,
        )  # fmt: skip
    axes.set(xlabel="query", ylabel="place in the map", xlim=(-0.5, len(query) - 0.5))


def draw_precision(found: Located) -> Figure | None:
    """Precision over recall at all scores, and the scores of right and wrong matches; None where nothing is known.

    Parameters
    ----------
    found : Located
    """
    from matplotlib.figure import Figure

    curve = found.curve()
    if curve is None or found.truth is None:
        return None
    with journal_style():
        figure = Figure(figsize=(DOUBLE_COLUMN, 2.5), layout="constrained")
        axes = figure.subplot_mosaic("ab")
        recall, precision = np.append(0.0, curve.recall), np.append(curve.precision[:1], curve.precision)
        if len(precision) == len(recall):
            axes["a"].plot(recall, precision, drawstyle="steps-pre", color=COLOURS["blue"])
        axes["a"].plot(curve.recall[-1:], curve.precision[-1:], "o", color=COLOURS["blue"], markersize=3)
        axes["a"].set(xlabel="recall", ylabel="precision", xlim=(0, 1.02), ylim=(0, 1.02))
        name_panel(axes["a"], "a", f"within {quantity(found.truth.tolerance, found.truth.unit)}")
        judged = found.is_matched & found.truth.is_known
        edges = np.linspace(0.0, max(1.0, float(np.nanmax(found.score[judged], initial=1.0))), 41).tolist()
        for word, which, colour in (
            ("right", judged & found.truth.is_right, COLOURS["green"]),
            ("wrong", judged & ~found.truth.is_right, COLOURS["red"]),
        ):
            if which.any():
                style: Any = {"histtype": "stepfilled", "alpha": 0.6} if word == "right" else {"histtype": "step"}
                axes["b"].hist(found.score[which], edges, color=colour, label=f"{word} ({which.sum()})", **style)
        if found.threshold is not None:
            axes["b"].axvline(found.threshold, color=COLOURS["black"], linewidth=0.6, linestyle="--", label="threshold")
        axes["b"].set(xlabel="score (0 unique, 1 as good as another place)", ylabel="matches")
        _legend(axes["b"], loc="upper left")
        name_panel(axes["b"], "b", "scores")
    return figure


def draw_route(found: Located) -> Figure | None:
    """The route on its map, errors and headings along it; None if there are neither positions nor headings.

    Parameters
    ----------
    found : Located
    """
    from matplotlib.figure import Figure

    has_places = bool(np.isfinite(found.place_positions[:, :2]).all(axis=1).any())
    has_errors = found.truth is not None and bool(np.isfinite(found.truth.error).any())
    n_angles = 0 if found.angles_deg is None else int(np.isfinite(found.angles_deg).any(axis=0).sum())
    if not has_places and not n_angles:
        return None
    beside = [letter for letter, is_there in (("e", has_errors), ("h", n_angles > 0)) if is_there]
    columns = [*(["m"] if has_places else []), *(["r"] if beside else [])]
    rows: Any = [[letter if name == "r" else "m" for name in columns] for letter in beside or ["m"]]
    with journal_style():
        height = 3.4 if has_places else 1.7 * len(beside)
        figure = Figure(figsize=(DOUBLE_COLUMN, height), layout="constrained")
        ratios = [_map_share(found), 1.0] if len(columns) > 1 else [1.0]
        axes = figure.subplot_mosaic(rows, width_ratios=ratios)
        letters = iter("abc")
        if has_places:
            _draw_map(axes["m"], found)
            name_panel(axes["m"], next(letters), "on the map")
        if has_errors:
            _draw_error_over_queries(axes["e"], found)
            name_panel(axes["e"], next(letters), "distance from the truth")
        if n_angles:
            _draw_angles(axes["h"], found)
            name_panel(axes["h"], next(letters), "turned against the match")
    return figure


def _draw_map(axes: Axes, found: Located) -> None:
    for number, route in enumerate(np.unique(found.place_routes)):
        way = found.place_positions[found.place_routes == route]
        axes.plot(*way[:, :2].T, color=COLOURS["grey"], linewidth=0.8, label="" if number else "map", zorder=1)
    seen = found.positions if found.query_positions is None else found.query_positions
    _draw_errors(axes, found)
    for word, which, colour, marker in match_kinds(found):
        shown = which & np.isfinite(seen[:, :2]).all(axis=1)
        if shown.any():
            axes.plot(
                *seen[shown, :2].T, marker, color=colour, markersize=3.5, label=f"{word} ({shown.sum()})",
                markeredgewidth=0.8 if marker != "." else 0.0,
            )  # fmt: skip
    axes.set(xlabel="x (m)", ylabel="y (m)")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(loc="best")


def _draw_error_over_queries(axes: Axes, found: Located) -> None:
    if found.truth is None:
        return
    query = np.arange(len(found.reference))
    for _, which, colour, marker in match_kinds(found):
        axes.plot(query[which], found.truth.error[which], marker, color=colour, markersize=3, markeredgewidth=0.7)
    axes.axhline(found.truth.tolerance, color=COLOURS["black"], linewidth=0.6, linestyle="--")
    axes.text(0.99, found.truth.tolerance, "tolerance ", ha="right", va="bottom", fontsize=6,
              transform=axes.get_yaxis_transform())  # fmt: skip
    axes.set(xlabel="query", ylabel=f"error ({found.truth.unit})", xlim=(-0.5, len(query) - 0.5))
    largest = float(np.nanmax(found.truth.error[found.is_kept], initial=0.0))  # of what is drawn
    highest = max(1.15 * found.truth.tolerance, 1.05 * largest)
    if 0.0 < highest < np.inf:
        axes.set_ylim(-0.03 * highest, highest)  # marks at 0 are seen whole


def _draw_angles(axes: Axes, found: Located) -> None:
    if found.angles_deg is None:
        return
    query, kept = np.arange(len(found.reference)), found.is_kept
    for name, column, colour, marker in (
        ("heading", 0, "blue", "."),
        ("pitch", 1, "orange", "x"),
        ("roll", 2, "purple", "+"),
    ):
        values = np.where(kept, found.angles_deg[:, column], np.nan)
        if np.isfinite(values).any():
            axes.plot(query, values, marker, color=COLOURS[colour], markersize=3, markeredgewidth=0.6, label=name)
    axes.axhline(0.0, color=COLOURS["grey"], linewidth=0.5, zorder=0)
    axes.set(xlabel="query", ylabel="angle (deg)", xlim=(-0.5, len(query) - 0.5))
    _legend(axes, loc="best", ncols=3)


def _draw_errors(axes: Axes, found: Located) -> None:
    """Lines from where queries were to where their matches are."""
    if found.query_positions is None or found.truth is None:
        return
    wrong = np.flatnonzero(found.is_kept & found.truth.is_known & ~found.truth.is_right)[:MOST_LINES]
    for k in wrong:
        ends = np.stack([found.query_positions[k, :2], found.positions[k, :2]])
        axes.plot(*ends.T, color=COLOURS["red"], linewidth=0.4, alpha=0.7, zorder=1)


def _map_share(found: Located) -> float:
    """Width of the map against that of the panel beside it, by how long the route is against its height."""
    places = found.place_positions[np.isfinite(found.place_positions[:, :2]).all(axis=1), :2]
    across, up = np.ptp(places, axis=0) if len(places) else (1.0, 1.0)
    return float(np.clip(across / max(up, 1e-9), 0.6, 1.6))


def draw_pairs(pairs: Sequence[tuple[str, NDArray[Any], NDArray[Any]]]) -> Figure:
    """Queries above and their matches below, a column for each pair.

    Parameters
    ----------
    pairs : title, picture of the query, picture of its match
    """
    from matplotlib.figure import Figure

    with journal_style():
        ratio = max(picture.shape[0] / picture.shape[1] for _, *both in pairs for picture in both)
        width = DOUBLE_COLUMN / len(pairs)
        figure = Figure(figsize=(DOUBLE_COLUMN, 2 * width * ratio + 0.6), layout="constrained")
        axes = np.atleast_2d(figure.subplots(2, len(pairs), squeeze=False))
        for column, (title, *pictures) in enumerate(pairs):
            for row, picture in enumerate(pictures):
                axes[row, column].imshow(picture, cmap="gray", interpolation="nearest")
                axes[row, column].set(xticks=[], yticks=[])
                axes[row, column].spines[:].set_visible(False)
            axes[0, column].set_title("\n".join(wrap(title, 18)), fontsize=6, verticalalignment="bottom")
        axes[0, 0].set_ylabel("query")
        axes[1, 0].set_ylabel("match")
    return figure


def drawn_numbers(count: int) -> NDArray[np.int64]:
    """Evenly spaced numbers of rows, few enough to be drawn."""
    return np.arange(0, count, -(-count // MOST_CELLS))
