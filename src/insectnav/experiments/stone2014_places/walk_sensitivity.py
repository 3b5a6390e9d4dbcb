"""What leaves, weather, tilt, sway and the segmentation do to the results of Fig. 4 on the rendered walk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge, surplus
from insectnav.experiments.stone2014_places import compass_runs
from insectnav.experiments.stone2014_places.compass_runs import both_directions, queries_of
from insectnav.experiments.stone2014_places.route_pairs import TOLERANCE, Score, pooled, route_pairs, share_of
from insectnav.experiments.stone2014_places.sequence_ways import AS_PUBLISHED
from insectnav.experiments.stone2014_places.walk import VARIATIONS
from insectnav.experiments.stone2014_places.walk_frames import Section, section_arrays, sections
from insectnav.experiments.stone2014_places.walks import both_walks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 4"
TITLE = "how the results on the rendered walk move with leaves, weather, tilt, sway and segmentation"
EVERY = 10  # [s] from frame to frame: the first of the ten test sets, and a tenth of the references of the compass
MIRROR_SIZE = 345  # [px] half the published size
FINER = "pixels of 0.5°"
QUICK = {"stop": 300, "resolution_deg": 3.0, "mirror_size": 115}
QUICK_NAMES = ("as set", "no sway at all")
COLUMNS = ("uv_recall", "uv_precision", "visible_precision", "compass_precision")


@dataclass(frozen=True, kw_only=True)
class Cell(Section):
    """A section of a day's walk; parameters as of `walk_frames.Section`."""


def grid(scale: str) -> Sequence[Cell]:
    """Every tenth frame of both days in sections of ten minutes, under each variation."""
    if scale != "full":
        return [
            Cell(**setting)
            for name in QUICK_NAMES
            for setting in sections(30, every=EVERY, variation=name, supersampling=1, **QUICK)
        ]
    settings: dict[str, Any] = {"every": EVERY, "mirror_size": MIRROR_SIZE}
    cells = [Cell(**setting) for name in VARIATIONS for setting in sections(60, variation=name, **settings)]
    return cells + [Cell(**setting) for setting in sections(60, resolution_deg=0.5, **settings)]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What is kept of the frames of a section."""
    return section_arrays(Section(**asdict(cell)), seed)


@dataclass(frozen=True, kw_only=True)
class _Found:
    """Scores of SeqSLAM, UV and visible, and precision of the compass on skies of bits with its standard error."""

    uv: Score
    visible: Score
    compass: tuple[float, float]
    right_pixels: float


@lru_cache(maxsize=2)
def _found(results: Results) -> dict[str, _Found]:
    """What came out under each variation."""
    found = {}
    for name, wanted in _variations(results).items():
        walks = both_walks(results, **wanted)
        pairs = route_pairs(tuple(walks), EVERY)
        uv, visible = (pooled(way.runs(walks, pairs)) for way in AS_PUBLISHED)
        right, distance = [], []
        for reference, query in both_directions(walks):
            queries = queries_of(query)
            turns = compass_runs.sky_turns(reference, query, queries, centred=True, reduction=1)
            run = compass_runs.found(reference, query, queries, turns)
            right.append(run.is_right())
            distance.append(run.distance)
        compass = share_of(np.concatenate(right), np.concatenate(distance))
        pixels = float(np.mean([walk["right_pixels"].mean() for walk in walks.values()]))
        found[name] = _Found(uv=uv, visible=visible, compass=compass, right_pixels=pixels)
    return found


def _variations(results: Results) -> dict[str, dict[str, Any]]:
    """Parameters of the cells of each variation."""
    coarse = max(results.by("resolution_deg"))
    found: dict[str, dict[str, Any]] = {
        name: {"variation": name, "resolution_deg": coarse} for name in results.by("variation")
    }
    if len(results.by("resolution_deg")) > 1:
        found[FINER] = {"variation": "as set", "resolution_deg": min(results.by("resolution_deg"))}
    return found


def summarise(results: Results) -> Table:
    """A row for each variation."""
    return [
        {
            "variation": name,
            "kind": "rendered",
            "right_pixels": 100.0 * found.right_pixels,
            "uv_recall": 100.0 * found.uv.recall,
            "uv_recall_error": 100.0 * found.uv.recall_error,
            "uv_precision": 100.0 * found.uv.precision,
            "uv_precision_error": 100.0 * found.uv.precision_error,
            "visible_recall": 100.0 * found.visible.recall,
            "visible_precision": 100.0 * found.visible.precision,
            "visible_precision_error": 100.0 * found.visible.precision_error,
            "compass_precision": 100.0 * found.compass[0],
            "compass_precision_error": 100.0 * found.compass[1],
        }
        for name, found in _found(results).items()
    ]


def draw(results: Results) -> Figure:
    """The four published numbers under each variation."""
    from matplotlib.figure import Figure

    rows = summarise(results)
    figure = Figure(figsize=(DOUBLE_COLUMN, 0.9 + 0.22 * len(rows)), layout="constrained")
    panels = figure.subplots(1, len(COLUMNS), sharey=True)
    titles = (
        "UV, recall\nwithout error",
        "UV, precision\nof all",
        "visible, precision\nof all",
        "UV compass,\nprecision",
    )
    for letter, axes, column, title in zip("abcd", panels, COLUMNS, titles, strict=True):
        for k, row in enumerate(rows):
            colour = COLOURS["blue"] if k == 0 else COLOURS["grey"]
            axes.errorbar(row[column], k, xerr=row[f"{column}_error"], fmt="o", color=colour, markersize=3, lw=0.8)
        axes.axvline(rows[0][column], color=COLOURS["blue"], linewidth=0.5, linestyle=":")
        axes.set(xlabel="%")
        name_panel(axes, letter, title)
    panels[0].set_yticks(range(len(rows)), [row["variation"] for row in rows])
    panels[0].invert_yaxis()
    return figure


def caption(results: Results) -> str:
    """What is shown."""
    size, n_pairs = results.cells[0].mirror_size, len(route_pairs(every=EVERY))
    return (
        f"Rendered, no photograph: the walks of Fig. 4, a frame every {EVERY} s, mirror pictures of {size} × {size} "
        f"pixels, with one thing at a time set otherwise. a, b, c, SeqSLAM on {n_pairs} runs: the sets from the first "
        f"frames, in both directions; d, the visual compass, against a frame every {EVERY} s and not every second. "
        f"Right is within {TOLERANCE:.0f} m; whiskers are "
        "standard errors by stretches of 100 m of the way. The dotted line is what came out as set."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What the text says of foliage and of weather."""
    rows = {row["variation"]: row for row in table}
    as_set = rows["as set"]
    missing = "there is no such variation in the quick grid"
    others = {
        "precision, bare trees on both days less as set, UV": ("bare trees on both days", "uv_precision"),
        "precision, one weather less as set, UV": ("one weather and sun", "uv_precision"),
        "precision, one weather less as set, visible": ("one weather and sun", "visible_precision"),
    }
    why = "a rendered city. UV and visible precision of SeqSLAM, of the UV compass: " + "; ".join(
        f"{name} {row['uv_precision']:.1f}, {row['visible_precision']:.1f}, {row['compass_precision']:.1f} %"
        for name, row in rows.items()
    )
    verdicts = []
    for value in published.values():
        name, column = others[value.quantity]
        if name not in rows:
            verdicts.append(judge(value, float("nan"), not_comparable=missing))
            continue
        verdicts.append(judge(value, *surplus(rows[name], as_set, column), why=why))
    return verdicts
