"""What leaves, weather, tilt, sway and the segmentation do to the results of Fig. 4 on the rendered walk."""

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
from insectnav.experiments.stone2014_places import compass_runs
from insectnav.experiments.stone2014_places.compass_runs import both_directions, queries_of
from insectnav.experiments.stone2014_places.route_pairs import (
    TOLERANCE,
    Run,
    Score,
    contrast_of,
    less_of,
    pooled,
    route_pairs,
    share_of,
)
from insectnav.experiments.stone2014_places.sequence_ways import DESCRIPTORS
from insectnav.experiments.stone2014_places.street_trees import CROWNS
from insectnav.experiments.stone2014_places.walk import DAYS, VARIATIONS
from insectnav.experiments.stone2014_places.walk_frames import Section, section_arrays, sections
from insectnav.experiments.stone2014_places.walks import Walk, both_walks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 4"
TITLE = "how the results on the rendered walk move with leaves, weather, tilt, sway and segmentation"
EVERY = 10  # [s] from frame to frame: the first of the ten test sets, and a tenth of the references of the compass
MIRROR_SIZE = 345  # [px] half the published size
FINER = "pixels of 0.5°"
QUICK = {"stop": 300, "resolution_deg": 3.0, "mirror_size": 115}
QUICK_NAMES = ("as set", "no sway at all")
AS_SET, NO_TREES, UNDER_CROWNS = "as set", "no trees over the way", "crowns over the way"
# What is told apart on the stretches that have crowns over them under one variation.
KEYS = dict(zip([way.name for way in DESCRIPTORS], ("uv", "contour", "zernike", "harmonics", "visible"), strict=True))
UNTESTED = {
    "sky covered by traffic and pedestrians": (
        "by construction: the rig is carried 2 m high on level ground, the tallest built person has 1.8 m, cars 1.5 m"
    ),
}
# By quantity: a variation and a column of the table.
WANTED = {
    "precision, bare trees on both days less as set, UV": (
        "bare trees on both days", "uv_precision_less_as_set",
    ),
    "precision, one weather less as set, UV": ("one weather and sun", "uv_precision_less_as_set"),
    "precision, one weather less as set, visible": ("one weather and sun", "visible_precision_less_as_set"),
    "precision there with crowns over the way less without trees, UV": (
        UNDER_CROWNS, "uv_on_stretches_less_without_trees",
    ),
    "precision under crowns less elsewhere, UV": (UNDER_CROWNS, "uv_on_stretches_less_elsewhere"),
    "precision under crowns, visible less UV": (UNDER_CROWNS, "visible_on_stretches_less_uv"),
    "precision under crowns less elsewhere, Fourier contour": (UNDER_CROWNS, "contour_on_stretches_less_elsewhere"),
    "precision under crowns, Zernike less Fourier contour": (UNDER_CROWNS, "zernike_on_stretches_less_contour"),
}  # fmt: skip
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
    """What came out under a variation.

    Scores of SeqSLAM, UV and visible; on the stretches of `CROWNS`, precision and precision less that elsewhere of each
    of `KEYS`; precision of the compass on skies of bits; each with its standard error. Runs by `KEYS`, and which of
    their queries are on these stretches.
    """

    runs: Mapping[str, Sequence[Run]]
    is_there: NDArray[np.bool_]

    uv: Score
    visible: Score
    on_stretches: Mapping[str, tuple[float, float]]
    less_elsewhere: Mapping[str, tuple[float, float]]
    compass: tuple[float, float]
    right_pixels: float


@lru_cache(maxsize=2)
def _found(results: Results) -> dict[str, _Found]:
    """What came out under each variation."""
    found = {}
    for name, wanted in _variations(results).items():
        walks = both_walks(results, **wanted)
        pairs = route_pairs(tuple(walks), EVERY)
        runs = {KEYS[way.name]: way.runs(walks, pairs) for way in DESCRIPTORS}
        there = {key: _on_stretches(of_way, walks) for key, of_way in runs.items()}
        right, distance = [], []
        for reference, query in both_directions(walks):
            queries = queries_of(query)
            turns = compass_runs.sky_turns(reference, query, queries, centred=True, reduction=1)
            run = compass_runs.found(reference, query, queries, turns)
            right.append(run.is_right())
            distance.append(run.distance)
        compass = share_of(np.concatenate(right), np.concatenate(distance))
        pixels = float(np.mean([walk["right_pixels"].mean() for walk in walks.values()]))
        found[name] = _Found(
            runs=runs,
            is_there=np.concatenate([_is_there(run, walks) for run in runs["uv"]]),
            uv=pooled(runs["uv"]),
            visible=pooled(runs["visible"]),
            on_stretches={key: share for key, (share, _) in there.items()},
            less_elsewhere={key: less for key, (_, less) in there.items()},
            compass=compass,
            right_pixels=pixels,
        )
    return found


def _is_there(run: Run, walks: Mapping[str, Walk]) -> NDArray[np.bool_]:
    """Which queries are on the stretches of `CROWNS`, whatever stands there."""
    day = run.pair.query_day
    return CROWNS.covers(walks[day]["number"][run.queries] / (DAYS[day].n_frames - 1))


def _on_stretches(runs: Sequence[Run], walks: Mapping[str, Walk]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Precision of the matches on the stretches of `CROWNS`, and the same less that elsewhere, with standard errors."""
    is_matched = np.concatenate([run.is_matched for run in runs])
    is_right = np.concatenate([run.is_right() for run in runs])[is_matched]
    distance = np.concatenate([run.distance for run in runs])[is_matched]
    is_there = np.concatenate([_is_there(run, walks) for run in runs])[is_matched]
    if not is_there.any():
        return (float("nan"),) * 2, (float("nan"),) * 2
    return share_of(is_right[is_there], distance[is_there]), contrast_of(is_right.astype(float), is_there, distance)


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
    every = _found(results)
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
        | _percent(found.on_stretches, "on_stretches")
        | _percent(found.less_elsewhere, "on_stretches_less_elsewhere")
        | _less(found, every)
        for name, found in every.items()
    ]


def _less(found: _Found, every: Mapping[str, _Found]) -> dict[str, float]:
    """Precision less that of the same frames as set, without trees, and by others under the same variation [%]."""
    runs, there = found.runs, found.is_there
    row = {f"{key}_precision_less_as_set": less_of(runs[key], every[AS_SET].runs[key]) for key in ("uv", "visible")} | {
        "visible_on_stretches_less_uv": less_of(runs["visible"], runs["uv"], there),
        "zernike_on_stretches_less_contour": less_of(runs["zernike"], runs["contour"], there),
    }
    if NO_TREES in every:
        without = every[NO_TREES].runs
        row |= {f"{key}_on_stretches_less_without_trees": less_of(runs[key], without[key], there) for key in runs}
    return {name: 100.0 * less for name, (less, _) in row.items()} | {
        f"{name}_error": 100.0 * error for name, (_, error) in row.items()
    }


def _percent(shares: Mapping[str, tuple[float, float]], what: str) -> dict[str, float]:
    """Columns of shares and of their standard errors, in percent."""
    return {f"{key}_{what}": 100.0 * share for key, (share, _) in shares.items()} | {
        f"{key}_{what}_error": 100.0 * error for key, (_, error) in shares.items()
    }


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
        axes.set(xlabel="recall (%)" if "recall" in title else "precision (%)")
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
    """What the text says of foliage, of trees over the way and of weather."""
    rows = {row["variation"]: row for row in table}
    ours = {name: _ours(rows, *wanted) for name, wanted in WANTED.items()} | dict.fromkeys(UNTESTED)
    why = "a rendered city. UV and visible precision of SeqSLAM, of the UV compass: " + "; ".join(
        f"{name} {row['uv_precision']:.1f}, {row['visible_precision']:.1f}, {row['compass_precision']:.1f} %"
        for name, row in rows.items()
    )
    missing = "there is no such variation in the quick grid"
    verdicts = []
    for value in published.values():
        number = ours[value.quantity]
        if number is None:
            reason = UNTESTED.get(value.quantity, missing)
            verdicts.append(judge(value, float("nan"), not_comparable=reason))
        else:
            verdicts.append(judge(value, *number, why=why))
    return verdicts


def _ours(rows: Mapping[str, Mapping[str, Any]], name: str, column: str) -> tuple[float, float] | None:
    """A number of a variation; none if that is not there, or what it is less than."""
    return with_error(rows[name], column) if name in rows and column in rows[name] else None
