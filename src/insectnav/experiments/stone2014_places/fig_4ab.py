"""Fig. 4a, b: a city walk found again on another day by SeqSLAM, from skies of bits and from grey pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge, with_error
from insectnav.experiments.stone2014_places.route_pairs import (
    TOLERANCE,
    TOLERANCES,
    Run,
    Score,
    begins_at_first,
    contrast_of,
    less_of,
    pooled,
    route_pairs,
)
from insectnav.experiments.stone2014_places.sequence_ways import AS_PUBLISHED, MAJORITY, MASKED, OTHERS, UV, VISIBLE
from insectnav.experiments.stone2014_places.walk_frames import Section, section_arrays, sections
from insectnav.experiments.stone2014_places.walk_maps import draw_correspondence, draw_places, inset
from insectnav.experiments.stone2014_places.walks import Walk, both_walks, whole_or_why_not
from insectnav.metrics.retrieval import precision_at_full_recall, recall_at_full_precision

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 4a, b"
TITLE = "a rendered city walk found again by SeqSLAM: skies of bits in UV, grey in visible light"
WAYS = (*AS_PUBLISHED, *OTHERS)
UNTESTED = {
    "precision at 100 % recall, UV less previous results of SeqSLAM": "those are of other recordings, not run here",
    "precision under scaffolding less elsewhere, UV": (
        "scaffolds of the built city stand within 1.3 m of the fronts and reach over no part of the walk, by the kerb"
    ),
}
# Seven minutes, a frame every five seconds.
QUICK = {"every": 5, "stop": 420, "resolution_deg": 3.0, "mirror_size": 173}


@dataclass(frozen=True, kw_only=True)
class Cell(Section):
    """A section of a day's walk; parameters as of `walk_frames.Section`."""


def grid(scale: str) -> Sequence[Cell]:
    """All frames of both days in sections of a minute, or every fifth of seven minutes at 3°."""
    settings = sections(60) if scale == "full" else sections(84, **QUICK)
    return [Cell(**setting) for setting in settings]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What is kept of the frames of a section."""
    return section_arrays(Section(**asdict(cell)), seed)


@lru_cache(maxsize=2)
def _all_runs(results: Results) -> dict[str, list[Run]]:
    """Runs of each way on all pairs."""
    walks = both_walks(results)
    pairs = route_pairs(tuple(walks), results.cells[0].every)
    return {way.name: way.runs(walks, pairs) for way in WAYS}


@lru_cache(maxsize=2)
def _scores(results: Results) -> dict[str, Score]:
    return {name: pooled(runs) for name, runs in _all_runs(results).items()}


def summarise(results: Results) -> Table:
    """A row for each way and set of runs."""
    walks, runs_of_uv = both_walks(results), _all_runs(results)[UV.name]
    rows = []
    for way in WAYS:
        runs = _all_runs(results)[way.name]
        for which, chosen in (("all", runs), ("reference from the first frame", _of_first(runs))):
            rows.append({"way": way.name, "runs": which, "kind": "rendered"} | _row(chosen, walks))
            of_uv = runs_of_uv if which == "all" else _of_first(runs_of_uv)
            less, error = less_of(chosen, of_uv)
            rows[-1] |= {"precision_less_uv": 100.0 * less, "precision_less_uv_error": 100.0 * error}
    return rows


def _of_first(runs: Sequence[Run]) -> list[Run]:
    return [run for run in runs if begins_at_first(run.pair)]


def _row(runs: Sequence[Run], walks: Mapping[str, Walk]) -> dict[str, Any]:
    score = pooled(runs)
    each = [precision_at_full_recall(run.curve) for run in runs]
    recalls = [recall_at_full_precision(run.curve) for run in runs]
    row: dict[str, Any] = {
        "n_frames": sum(len(walk) for walk in walks.values()),
        "n_runs": len(runs),
        "n_matches": int(sum(run.is_matched.sum() for run in runs)),
        "recall_at_full_precision": 100.0 * score.recall,
        "recall_error": 100.0 * score.recall_error,
        "precision_at_full_recall": 100.0 * score.precision,
        "precision_error": 100.0 * score.precision_error,
        "mean_recall_of_runs": 100.0 * float(np.mean(recalls)),
        "lowest_precision_of_runs": 100.0 * min(each),
        "highest_precision_of_runs": 100.0 * max(each),
    }
    row |= {f"precision_within_{t:.0f}_m": 100.0 * pooled(runs, t).precision for t in TOLERANCES}
    return row | conditions(runs, walks)


def conditions(runs: Sequence[Run], walks: Mapping[str, Walk]) -> dict[str, float]:
    """What frames show at right and at wrong matches [%].

    Mean shares of sky and trees above the horizon, of right pixels of masks, and of bits of the sky that change.
    """
    found: dict[str, float] = {}
    is_right = np.concatenate([run.is_right()[run.is_matched] for run in runs])
    distance = np.concatenate([run.distance[run.is_matched] for run in runs])
    of_queries = [(walks[run.pair.query_day], run) for run in runs]
    parts = {
        name: [walk[name][run.queries][run.is_matched] for walk, run in of_queries]
        for name in ("sky_share", "tree_share", "right_pixels")
    } | {"sky_change": [change_of_sky(walk, run.queries)[run.is_matched] for walk, run in of_queries]}
    for name, each in parts.items():
        values = np.concatenate(each).astype(np.float64)
        less, error = contrast_of(values, ~is_right, distance)
        found |= {f"{name}_wrong_less_right": 100.0 * less, f"{name}_error": 100.0 * error}
        for word, chosen in (("right", is_right), ("wrong", ~is_right)):
            found[f"{name}_where_{word}"] = 100.0 * float(values[chosen].mean()) if chosen.any() else float("nan")
    return found


def change_of_sky(walk: Walk, frames: NDArray[np.int64]) -> NDArray[np.float64]:
    """Share of the bits of the sky that change from frame to frame of a set, mean of before and after, (frame,)."""
    skies = walk.binary_skies()[frames]
    between = (skies[1:] != skies[:-1]).mean(axis=1)
    before, after = np.concatenate([between[:1], between]), np.concatenate([between, between[-1:]])
    return np.asarray((before + after) / 2.0)


def worst(runs: Sequence[Run]) -> Run:
    """The run with the lowest precision of all matches; of equals that with the lower recall without error."""
    return min(
        runs, key=lambda run: (precision_at_full_recall(run.curve), recall_at_full_precision(run.curve))
    )  # fmt: skip


def draw(results: Results) -> Figure:
    """The worst test set of each kind of light as a map, with its matches and an example; precision over recall."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 5.1), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(3.1, 2.0))
    maps, lower = parts
    for letter, axes, way in zip("ab", maps.subplots(1, 2), AS_PUBLISHED, strict=True):
        run = worst(_all_runs(results)[way.name])
        _draw_run(axes, run, both_walks(results), is_uv=way is UV)
        name_panel(axes, letter, f"{way.name}, worst test set")
    curves, bars = lower.subplots(1, 2, width_ratios=(1.0, 1.35))
    for name, colour in zip(
        [way.name for way in (*AS_PUBLISHED, OTHERS[0])], ("purple", "orange", "blue"), strict=True
    ):
        curve = _scores(results)[name].curve
        curves.plot(curve.recall, curve.precision, drawstyle="steps-pre", color=COLOURS[colour], label=name)
    lowest = min(score.precision for score in _scores(results).values())
    curves.set(xlabel="recall", ylabel="precision", xlim=(0.0, 1.02), ylim=(min(0.75, lowest - 0.15), 1.005))
    curves.plot([0.81, 0.94], [1.0, 0.94], "x", color=COLOURS["purple"], markersize=4, label="published, UV")
    curves.plot([0.97], [0.97], "x", color=COLOURS["orange"], markersize=4, label="published, visible")
    curves.legend(loc="lower left")
    name_panel(curves, "c", f"all runs, within {TOLERANCE:.0f} m")
    _draw_bars(bars, _scores(results))
    name_panel(bars, "d", "recall without error, precision of all")
    return figure


def _draw_run(axes: Axes, run: Run, walks: Mapping[str, Walk], *, is_uv: bool) -> None:
    query = walks[run.pair.query_day]
    is_right, reference = run.is_right(), run.matches.reference
    draw_places(axes, query["position"][run.queries], is_right, run.is_matched)
    axes.legend(loc="upper left", handletextpad=0.1)
    draw_correspondence(axes, reference, is_right, (run.pair.query_day, run.pair.reference_day))
    wrong = np.flatnonzero(run.is_matched & ~is_right)
    example = run.queries[wrong[len(wrong) // 2] if len(wrong) else len(run.queries) // 2]
    small = inset(axes, (0.0, 0.0, 0.2, 0.08))
    if is_uv:
        small.imshow(query["uv"][example], cmap="gray", aspect="auto", vmin=0, vmax=255)
        sky = inset(axes, (0.02, 0.13, 0.15, 0.19))
        sky.imshow(query.mirror_skies([example])[0], cmap="gray", aspect="equal")
        sky.set(xticks=[], yticks=[])
    else:
        small.imshow(query["colours"][example], aspect="auto")
    small.set(xticks=[], yticks=[])
    small.set_title("matched wrongly" if len(wrong) else "a frame", fontsize=5.0, pad=1.5)


def _draw_bars(axes: Axes, scores: Mapping[str, Score]) -> None:
    for k, (_, score) in enumerate(scores.items()):
        for shift, value, error, colour in (
            (-0.18, score.recall, score.recall_error, "sky"),
            (0.18, score.precision, score.precision_error, "grey"),
        ):
            axes.barh(k + shift, 100.0 * value, 0.34, xerr=100.0 * error, color=COLOURS[colour], error_kw={"lw": 0.7})
    axes.set_yticks(range(len(scores)), list(scores))
    axes.invert_yaxis()
    axes.set(xlim=(0.0, 158.0), xlabel="recall, precision (%)", xticks=range(0, 101, 20))
    handles = [axes.patches[0], axes.patches[1]]
    names = ["recall at 100 % precision", "precision at 100 % recall"]
    axes.legend(handles, names, loc="center right", bbox_to_anchor=(1.0, 0.43))


def caption(results: Results) -> str:
    """What is shown."""
    walks = both_walks(results)
    length = max(walk["distance"].max() for walk in walks.values())
    n = {day: len(walk) for day, walk in walks.items()}
    n_runs = len(_all_runs(results)[UV.name])
    return (
        f"Rendered, no photograph: a walk of {length:.0f} m through a built city in January (overcast, bare trees, "
        f"{n['january']} frames) and in April (blue sky with clouds, some leaves, {n['april']} frames), on lines a "
        f"metre apart, carried by hand. SeqSLAM (ds = 10, R_window = 10) on {n_runs} runs, each route pair in both "
        f"directions; a match is right within {TOLERANCE:.0f} m. a, b, The run with the lowest precision of either "
        "light: green right, red wrong, yellow too near the ends for a sequence; upper right the number of the match "
        "over that of the query; lower left a frame that was matched wrongly, in a with the sky that was compared. c, "
        "Precision over recall of all runs under one threshold, recall of all queries that can be matched, which so "
        "ends where all matches are kept; crosses are the published numbers, those at “100 % recall” where recall is "
        "precision. d, Other ways "
        "(see the page); whiskers are standard errors by stretches of 100 m of the way."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The published precision and recall, and what the text says of failures."""
    rows = {row["way"]: row for row in table if row["runs"] == "all"}
    uv, visible = rows[UV.name], rows[VISIBLE.name]
    masked = max((rows[way.name] for way in MASKED), key=lambda row: row["precision_at_full_recall"])
    ours = {
        "recall at 100 % precision, UV": (uv["recall_at_full_precision"], uv["recall_error"]),
        "precision at 100 % recall, UV": _precision(uv),
        "precision at 100 % recall, visible": _precision(visible),
        "precision at 100 % recall, visible less UV": with_error(visible, "precision_less_uv"),
        "precision at 100 % recall, majority of three frames less one, UV": with_error(
            rows[MAJORITY.name], "precision_less_uv"
        ),
        "precision at 100 % recall, visible with the sky masked out less UV": with_error(masked, "precision_less_uv"),
        "trees above the horizon, wrong less right matches, UV": _at_wrong(uv, "tree_share"),
        "sky above the horizon, wrong less right matches, UV": _at_wrong(uv, "sky_share"),
        "sky above the horizon, wrong less right matches, visible": _at_wrong(visible, "sky_share"),
        "sky changed from frame to frame, wrong less right matches, UV": _at_wrong(uv, "sky_change"),
    } | dict.fromkeys(UNTESTED, (float("nan"), 0.0))
    why, part = _why(rows), whole_or_why_not(uv["n_frames"])
    return [
        judge(value, *ours[value.quantity], why=why, not_comparable=UNTESTED.get(value.quantity, part))
        for value in published.values()
    ]


def _precision(row: Mapping[str, Any]) -> tuple[float, float]:
    return row["precision_at_full_recall"], row["precision_error"]


def _at_wrong(row: Mapping[str, Any], name: str) -> tuple[float, float]:
    return row[f"{name}_wrong_less_right"], row[f"{name}_error"]


def _why(rows: Mapping[str, Mapping[str, Any]]) -> str:
    """How much the numbers depend on what the text leaves open, and what stood where matches were wrong."""
    uv, visible = rows[UV.name], rows[VISIBLE.name]
    mean = uv["mean_recall_of_runs"]
    within = ", ".join(f"{t:.0f} m {uv[f'precision_within_{t:.0f}_m']:.1f} %" for t in TOLERANCES)
    others = "; ".join(
        f"{way.name} {rows[way.name]['recall_at_full_precision']:.1f} % and "
        f"{rows[way.name]['precision_at_full_recall']:.1f} %"
        for way in OTHERS
    )
    return (
        f"a rendered city. One threshold for all runs: of single runs UV has a recall without error of {mean:.1f} % "
        f"in the mean, and precision from {uv['lowest_precision_of_runs']:.1f} to "
        f"{uv['highest_precision_of_runs']:.1f} %. UV precision within {within}; masks have "
        f"{uv['right_pixels_where_right']:.1f} % of their pixels right; trees cover "
        f"{uv['tree_share_where_wrong']:.1f} % above the horizon at wrong matches and "
        f"{uv['tree_share_where_right']:.1f} % at right ones (visible {visible['tree_share_where_wrong']:.1f} and "
        f"{visible['tree_share_where_right']:.1f} %); recall and precision otherwise: {others}; what sway, leaves and "
        "weather do is measured by stone2014-walk-sensitivity"
    )
