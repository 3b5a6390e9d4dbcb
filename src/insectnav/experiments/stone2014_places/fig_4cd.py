"""Fig. 4c, d: place and heading on a city walk from single pictures, by a visual compass on skies and on grey."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge, more, with_error
from insectnav.experiments.stone2014_places import compass_runs, fig_4ab
from insectnav.experiments.stone2014_places.compass_runs import CompassRun, both_directions, queries_of
from insectnav.experiments.stone2014_places.route_pairs import TOLERANCE, TOLERANCES, Pair, less_of, share_of
from insectnav.experiments.stone2014_places.sequence_ways import UV as UV_SEQUENCE
from insectnav.experiments.stone2014_places.walk_maps import draw_directions
from insectnav.experiments.stone2014_places.walks import both_walks, whole_or_why_not

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 4c, d"
TITLE = "place and heading on a rendered city walk from single pictures, by a visual compass"
UV, UV_UNMOVED, UV_AFTER = "UV, binary sky", "UV, sky not centred", "UV, SeqSLAM first"
GREY, COLOUR, NORMAL = "visible, grey", "visible, colour", "visible, grey, normalised"
WAYS = (UV, UV_UNMOVED, UV_AFTER, GREY, COLOUR, NORMAL)
UNMOVED_REDUCTION = 3  # of the mirror picture where it is not centred: bits enough, a ninth of the time
AWAY = float(np.deg2rad(45.0))  # [rad] from the course, at which a direction leads away from the way; assumed
FAR = 100.0  # [m] to a match far from the current location; assumed

# The same frames as of `fig_4ab`.
Cell, grid, simulate = fig_4ab.Cell, fig_4ab.grid, fig_4ab.simulate


@lru_cache(maxsize=2)
def _all_runs(results: Results) -> dict[str, list[CompassRun]]:
    """Of each way, either day as the reference of the other."""
    runs: dict[str, list[CompassRun]] = {name: [] for name in WAYS}
    for reference, query in both_directions(both_walks(results)):
        queries = queries_of(query)
        sky = compass_runs.sky_turns(reference, query, queries, centred=True, reduction=1)
        turns = {
            UV: sky,
            UV_UNMOVED: compass_runs.sky_turns(reference, query, queries, centred=False, reduction=UNMOVED_REDUCTION),
            GREY: compass_runs.grey_turns(reference, query, queries),
            COLOUR: compass_runs.colour_turns(reference, query, queries),
            NORMAL: compass_runs.normal_turns(reference, query, queries),
        }
        for name, matrix in turns.items():
            runs[name].append(compass_runs.found(reference, query, queries, matrix))
        pair = Pair(reference_day=reference.day, reference_start=0, query_day=query.day, query_start=0)
        (sequence,) = UV_SEQUENCE.runs(both_walks(results), [pair])
        runs[UV_AFTER].append(compass_runs.found_after(reference, query, sequence, queries, sky))
    return runs


def summarise(results: Results) -> Table:
    """A row for each way, of both directions together and of each."""
    rows = []
    n_frames = sum(len(walk) for walk in both_walks(results).values())
    for name, runs in _all_runs(results).items():
        of_uv = _all_runs(results)[UV]
        each = [(run.query_day, [run], [uv]) for run, uv in zip(runs, of_uv, strict=True)]
        for which, chosen, uv in (("both", runs, of_uv), *each):
            about = {"way": name, "queries_of": which, "kind": "rendered", "n_frames": n_frames}
            rows.append(about | _row(chosen, uv))
    return rows


def leads_away(run: CompassRun) -> NDArray[np.bool_]:
    """Where the advised direction leads away from the way, (query,)."""
    return np.asarray(run.astray > AWAY)


def _row(runs: Sequence[CompassRun], of_uv: Sequence[CompassRun]) -> dict[str, Any]:
    """Precision, how far advised directions lie off the course, and both less those of skies of the same queries."""
    is_matched = np.concatenate([run.is_matched for run in runs])
    right = np.concatenate([run.is_right() for run in runs])[is_matched]
    error = np.concatenate([run.error for run in runs])[is_matched]
    astray = np.concatenate([run.astray for run in runs])[is_matched]
    distance = np.concatenate([run.distance for run in runs])[is_matched]
    precision, precision_error = share_of(right, distance)
    away, away_error = share_of(np.concatenate([leads_away(run) for run in runs])[is_matched], distance)
    less, less_error = less_of(runs, of_uv)
    away_less, away_less_error = less_of(runs, of_uv, is_so=leads_away)
    far, far_error = (float("nan"),) * 2 if right.all() else share_of(error[~right] > FAR, distance[~right])
    row: dict[str, Any] = {
        "n_matches": len(right),
        "precision": 100.0 * precision,
        "precision_error": 100.0 * precision_error,
        "precision_less_uv": 100.0 * less,
        "precision_less_uv_error": 100.0 * less_error,
        "median_error_m": float(np.median(error)),
        "median_astray_deg": float(np.rad2deg(np.median(astray))),
        "median_astray_where_right_deg": float(np.rad2deg(np.median(astray[right]))) if right.any() else float("nan"),
        "leads_away": 100.0 * away,
        "leads_away_error": 100.0 * away_error,
        "leads_away_less_uv": 100.0 * away_less,
        "leads_away_less_uv_error": 100.0 * away_less_error,
        "wrong_far_away": 100.0 * far,
        "wrong_far_away_error": 100.0 * far_error,
    }
    return row | {f"precision_within_{t:.0f}_m": 100.0 * float((error <= t).mean()) for t in TOLERANCES}


def draw(results: Results) -> Figure:
    """Maps of the directions that the compass advises, and how precise each way is."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.9), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(3.1, 1.8))
    maps, lower = parts
    walks = both_walks(results)
    for letter, axes, name in zip("cd", maps.subplots(1, 2), (UV, GREY), strict=True):
        run = drawn_run(results, name)
        query = walks[run.query_day]
        draw_directions(axes, query["position"][run.queries], run.advised, run.is_right(), query["position"])
        axes.legend(loc="upper left")
        name_panel(axes, letter, f"{name}: {100.0 * run.is_right().mean():.1f} % right")
    bars, astray = lower.subplots(1, 2, width_ratios=(1.35, 1.0))
    _draw_bars(bars, [row for row in summarise(results) if row["queries_of"] == "both"])
    name_panel(bars, "e", f"precision within {TOLERANCE:.0f} m")
    for name, colour in ((UV, "purple"), (UV_AFTER, "blue"), (GREY, "orange"), (COLOUR, "red"), (NORMAL, "grey")):
        angle = np.concatenate([run.astray[run.is_matched] for run in _all_runs(results)[name]])
        astray.plot(np.rad2deg(np.sort(angle)), np.arange(1, len(angle) + 1) / len(angle), color=COLOURS[colour])
        astray.lines[-1].set_label(name)
    astray.set(
        xlabel="advised direction off the course (deg)", ylabel="share of queries", xlim=(0, 180), ylim=(0, 1.02)
    )
    astray.set_xticks(range(0, 181, 45))
    astray.legend(loc="lower right")
    name_panel(astray, "f", "headings")
    return figure


def drawn_run(results: Results, name: str) -> CompassRun:
    """The run that is drawn as a map: queries of the second day."""
    second = tuple(both_walks(results))[-1]
    return next(run for run in _all_runs(results)[name] if run.query_day == second)


def _draw_bars(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    for k, row in enumerate(rows):
        axes.barh(k, row["precision"], 0.7, xerr=row["precision_error"], color=COLOURS["sky"], error_kw={"lw": 0.7})
        axes.text(2.0, k, f"{row['precision']:.1f}", va="center", fontsize=5.5)
    axes.set_yticks(range(len(rows)), [row["way"] for row in rows])
    axes.invert_yaxis()
    axes.set(xlim=(0.0, 102.0), xlabel="precision (%)")
    for value, of in ((84.7, (0, 3)), (44.1, (3, len(rows)))):  # published, over the bars that they are of
        axes.plot([value, value], [of[0] - 0.45, of[1] - 0.55], color=COLOURS["black"], linewidth=1.0, linestyle=":")
    axes.lines[-1].set_label("published")
    axes.legend(loc="lower right")


def caption(results: Results) -> str:
    """What is shown."""
    walks, run = both_walks(results), drawn_run(results, UV)
    size = next(iter(walks.values())).mirror_size
    return (
        "Rendered, no photograph: the walks of Fig. 4a, b. Every tenth second of one day is compared with all frames "
        f"of the other (in c and d {len(run.queries)} of {run.query_day.capitalize()} with "
        f"{len(walks[run.reference_day])} of {run.reference_day.capitalize()}) after 90 turns of 4°; the nearest is "
        f"the match, right within {TOLERANCE:.0f} m. c, Skies of {size} × {size} bits by exclusive or; d, "
        "unwrapped grey of 180 × 28 pixels by absolute differences. Arrows: the direction that the compass advises, "
        "green where the place is right. e, Precision with either day as the reference of the other, standard errors "
        "by stretches of 100 m of the way; “SeqSLAM first” has no match near the ends, and skies that are not centred "
        f"are of 1/{UNMOVED_REDUCTION} of the side. f, Share of the queries whose "
        "advised direction is less than so far off the course of the way."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The published precision, and what the text says of headings and of SeqSLAM before the compass."""
    rows = {row["way"]: row for row in table if row["queries_of"] == "both"}
    uv = rows[UV]
    visible = max((rows[GREY], rows[COLOUR]), key=lambda row: row["precision"])
    ours = {
        "precision, UV": with_error(uv, "precision"),
        "precision, visible": with_error(visible, "precision"),
        "precision, UV less visible": more(visible, "precision_less_uv"),
        "directions that lead away, visible less UV": with_error(visible, "leads_away_less_uv"),
        "direction off the course, median, UV": (uv["median_astray_deg"], 0.0),
        "precision, sky centred less not centred, UV": more(rows[UV_UNMOVED], "precision_less_uv"),
        "wrong matches more than 100 m away, UV": with_error(uv, "wrong_far_away"),
        "wrong matches more than 100 m away, visible": with_error(visible, "wrong_far_away"),
        "precision, SeqSLAM first less compass alone, UV": with_error(rows[UV_AFTER], "precision_less_uv"),
    }
    why, part = _why(rows), whole_or_why_not(uv["n_frames"])
    return [judge(value, *ours[value.quantity], why=why, not_comparable=part) for value in published.values()]


def _why(rows: Mapping[str, Mapping[str, Any]]) -> str:
    parts = [
        f"{name} {row['precision']:.1f} % within {TOLERANCE:.0f} m ({row['precision_within_10_m']:.1f} % within 10 m), "
        f"{row['leads_away']:.1f} % lead away"
        for name, row in rows.items()
    ]
    return (
        f"a rendered city. {'; '.join(parts)}; the text names neither the tolerance nor the measure for grey; what "
        "tilt, leaves and weather do is measured by stone2014-walk-sensitivity"
    )
