"""Five descriptors side by side on the city walk of Fig. 4: sky in bits, contour, Zernike, harmonics, and grey."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge, with_error
from insectnav.experiments.stone2014_places import fig_4ab
from insectnav.experiments.stone2014_places.route_pairs import (
    TOLERANCE,
    Run,
    contrast_of,
    less_of,
    pooled,
    route_pairs,
    share_of,
)
from insectnav.experiments.stone2014_places.sequence_ways import CONTOUR, DESCRIPTORS, UV, VISIBLE, ZERNIKE, Way
from insectnav.experiments.stone2014_places.walks import Walk, both_walks, whole_or_why_not

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "section 4.1"
TITLE = "Fourier, Zernike and harmonic descriptors of the sky side by side on the rendered city walk"
NAMES = tuple(way.name for way in DESCRIPTORS)
SHOWN = dict(zip(NAMES, ("purple", "red", "green", "blue", "orange"), strict=True))
DASHED = "UV, spherical harmonics"  # which would hide the curve of Zernike
UNDER_TREES = 0.03  # [share of the solid angle above the horizon] that trees cover where one is under them; assumed
UNTESTED = {"precision under overhead cables less elsewhere, Fourier contour": "no cables hang over the built streets"}
TURNED = "rig turned by 180° for the queries"


# The same frames as of `fig_4ab`.
Cell, grid, simulate = fig_4ab.Cell, fig_4ab.grid, fig_4ab.simulate


@lru_cache(maxsize=2)
def _all_runs(results: Results) -> dict[str, dict[str, list[Run]]]:
    """Runs of each descriptor with the rig as it was carried, and turned."""
    walks = both_walks(results)
    pairs = route_pairs(tuple(walks), results.cells[0].every)
    return {
        way.name: {"as carried": way.runs(walks, pairs), TURNED: way.runs(walks, pairs, is_turned=True)}
        for way in DESCRIPTORS
    }


def summarise(results: Results) -> Table:
    """A row for each descriptor and for each way of carrying the rig."""
    walks, found = both_walks(results), _all_runs(results)
    return [
        {"descriptor": name, "rig": rig, "kind": "rendered"}
        | _row(runs, walks, way)
        | _less(runs, walks, {"binary_sky": found[UV.name][rig], "contour": found[CONTOUR.name][rig]})
        for way, (name, of_rigs) in zip(DESCRIPTORS, found.items(), strict=True)
        for rig, runs in of_rigs.items()
    ]


def _row(runs: Sequence[Run], walks: Mapping[str, Walk], way: Way) -> dict[str, Any]:
    score = pooled(runs)
    is_matched = np.concatenate([run.is_matched for run in runs])
    is_right = np.concatenate([run.is_right() for run in runs])[is_matched]
    is_under = _is_under(runs, walks)[is_matched]
    distance = np.concatenate([run.distance for run in runs])[is_matched]
    less, error = contrast_of(is_right.astype(np.float64), is_under, distance)
    under, elsewhere = (
        share_of(is_right[some], distance[some]) if some.any() else (float("nan"),) * 2
        for some in (is_under, ~is_under)
    )
    return {
        "metric": way.metric,
        "n_frames": sum(len(walk) for walk in walks.values()),
        "n_features": way.features(next(iter(walks.values()))).shape[1],
        "n_runs": len(runs),
        "n_matches": int(is_matched.sum()),
        "recall_at_full_precision": 100.0 * score.recall,
        "recall_error": 100.0 * score.recall_error,
        "precision_at_full_recall": 100.0 * score.precision,
        "precision_error": 100.0 * score.precision_error,
        "precision_under_trees": 100.0 * under[0],
        "precision_under_trees_error": 100.0 * under[1],
        "precision_elsewhere": 100.0 * elsewhere[0],
        "precision_elsewhere_error": 100.0 * elsewhere[1],
        "under_trees_less_elsewhere": 100.0 * less,
        "under_trees_error": 100.0 * error,
        "matches_under_trees": int(is_under.sum()),
    }


def _is_under(runs: Sequence[Run], walks: Mapping[str, Walk]) -> NDArray[np.bool_]:
    """Which queries of all runs are under trees."""
    trees = [walks[run.pair.query_day]["tree_share"][run.queries] for run in runs]
    return np.asarray(np.concatenate(trees) > UNDER_TREES)


def _less(runs: Sequence[Run], walks: Mapping[str, Walk], others: Mapping[str, Sequence[Run]]) -> dict[str, float]:
    """Precision less that of others on the same frames, everywhere and under trees [%]."""
    row: dict[str, float] = {}
    is_under = _is_under(runs, walks)
    for name, of_other in others.items():
        for what, chosen in (("precision", None), ("precision_under_trees", is_under)):
            less, error = less_of(runs, of_other, chosen)
            row |= {f"{what}_less_{name}": 100.0 * less, f"{what}_less_{name}_error": 100.0 * error}
    return row


def draw(results: Results) -> Figure:
    """Precision over recall as carried and turned, and precision under trees and elsewhere."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 2.5), layout="constrained")
    panels = figure.subplots(1, 3)
    rows = summarise(results)
    for letter, axes, rig in zip("ab", panels, ("as carried", TURNED), strict=False):
        for name, colour in SHOWN.items():
            curve = pooled(_all_runs(results)[name][rig]).curve
            style = (0, (3.0, 1.5)) if name == DASHED else "-"
            axes.plot(curve.recall, curve.precision, drawstyle="steps-pre", color=COLOURS[colour], label=name)
            axes.lines[-1].set_linestyle(style)
        axes.set(xlabel="recall", ylabel="precision", xlim=(0.0, 1.02), ylim=(0.0, 1.02))
        name_panel(axes, letter, rig)
    panels[0].legend(loc="lower left")
    axes = panels[2]
    carried = [row for row in rows if row["rig"] == "as carried"]
    for shift, column, colour in ((-0.18, "precision_elsewhere", "sky"), (0.18, "precision_under_trees", "green")):
        values = [row[column] for row in carried]
        errors = [row[f"{column}_error"] for row in carried]
        label = column.removeprefix("precision_").replace("_", " ")
        place, how = np.arange(len(carried)) + shift, {"color": COLOURS[colour], "error_kw": {"lw": 0.7}}
        axes.barh(place, values, 0.34, xerr=errors, label=label, **how)
    axes.set_yticks(range(len(carried)), [row["descriptor"] for row in carried])
    axes.invert_yaxis()
    axes.set(xlim=(0.0, 165.0), xlabel="precision of all matches (%)", xticks=range(0, 101, 20))
    axes.legend(loc="lower right")
    name_panel(axes, "c", "under trees and elsewhere")
    return figure


def caption(results: Results) -> str:
    """What is shown."""
    row = next(row for row in summarise(results) if row["descriptor"] == UV.name)
    return (
        "Rendered, no photograph: the walks of Fig. 4a, b, by SeqSLAM with five descriptors on the same frames, "
        f"{row['n_runs']} runs, {row['n_matches']} matches, right within {TOLERANCE:.0f} m. a, As carried. b, With the "
        "rig turned by 180° on its pole for the test sets: bits and grey are turned; amplitudes, which such a turn "
        "leaves as they are, are those of a. c, "
        f"Precision of all matches where trees cover more than {100.0 * UNDER_TREES:.0f} % above the horizon, and "
        "elsewhere, as carried; whiskers are standard errors by stretches of 100 m of the way."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What section 4.1 of the thesis says of contours and Zernike moments, in words."""
    rows = {row["descriptor"]: row for row in table if row["rig"] == "as carried"}
    contour, zernike, sky = rows[CONTOUR.name], rows[ZERNIKE.name], rows[UV.name]
    ours = {
        "precision, Zernike less Fourier contour": with_error(zernike, "precision_less_contour"),
        "precision, Zernike less binary sky": with_error(zernike, "precision_less_binary_sky"),
        "precision under trees, visible less UV, binary sky": with_error(
            rows[VISIBLE.name], "precision_under_trees_less_binary_sky"
        ),
        "precision under trees less elsewhere, Fourier contour": (
            contour["under_trees_less_elsewhere"],
            contour["under_trees_error"],
        ),
    } | dict.fromkeys(UNTESTED, (float("nan"), 0.0))
    why = "a rendered city. Precision of all, elsewhere, under trees: " + "; ".join(
        f"{name} {row['precision_at_full_recall']:.1f}, {row['precision_elsewhere']:.1f}, "
        f"{row['precision_under_trees']:.1f} %"
        for name, row in rows.items()
    )
    part = whole_or_why_not(sky["n_frames"])
    return [
        judge(value, *ours[value.quantity], why=why, not_comparable=UNTESTED.get(value.quantity, part))
        for value in published.values()
    ]
