"""Table I: how much of eighteen pictures is labelled right, in visible light, ultraviolet, and ultraviolet with green.

The pictures are rendered, the masks of the sky exact.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2014_sky_segmentation.photographs import FullSpectrum, Photograph, shown, take
from insectnav.experiments.stone2014_sky_segmentation.scenes import NUMBERS, SCENES, lit_scene
from insectnav.experiments.stone2014_sky_segmentation.table_1_panels import draw_scenes
from insectnav.experiments.stone2014_sky_segmentation.ways import WAYS, sky_mask
from insectnav.metrics.paired_tests import paired_wilcoxon, variance_ratio
from insectnav.metrics.segmentation import accuracy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Table I"
TITLE = "accuracy of sky segmentation in eighteen rendered scenes: UV, UV-green and visible light"
N_SHOWN = 150  # [px] width of the pictures in the figure
QUICK = (5, 6, 8, 10, 17)  # numbers of the scenes of the quick grid
NAMES = tuple(way.name for way in WAYS)
STAND_IN = "our scene is a rendered stand-in: of the place itself nothing but its name is known"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One scene.

    Parameters
    ----------
    scene : name in `scenes.SCENES`
    reduction, supersampling : as of `photographs.FullSpectrum`
    """

    scene: str
    reduction: int
    supersampling: int


def grid(scale: str) -> Sequence[Cell]:
    """All scenes at 604 × 403 pixels, or five of them at 75 × 50."""
    if scale == "full":
        return [Cell(scene=scene.name, reduction=1, supersampling=4) for scene in SCENES]
    return [Cell(scene=SCENES[number].name, reduction=8, supersampling=4) for number in QUICK]


def photograph_of(cell: Cell, seed: int) -> Photograph:
    """The photograph that is taken of the scene of a cell."""
    number = NUMBERS[cell.scene]
    scene, how = SCENES[number], FullSpectrum(reduction=cell.reduction, supersampling=cell.supersampling)
    return take(lit_scene(number), scene.eye_height, float(np.deg2rad(scene.pitch_deg)), how, seed)


def simulate(cell: Cell, seed: int) -> Arrays:
    """Accuracy of each way, and the pictures and labels that are shown."""
    picture = photograph_of(cell, seed)
    masks = [sky_mask(picture, way, seed) for way in WAYS]
    right = np.array([accuracy(mask, picture.sky) for mask in masks])
    step = max(1, round(picture.uv.shape[1] / N_SHOWN))
    labels = np.stack([picture.sky, *(masks[NAMES.index(name)] for name in ("k-means, visible", "k-means, UV"))])
    return {
        "accuracy": (("way",), 100.0 * right, {"units": "percent", "ways": ", ".join(NAMES)}),
        "sky_share": ((), np.array(picture.sky.mean()), {"units": "1"}),
        "visible": (("row", "column", "band"), shown(picture.visible, N_SHOWN), {"units": "sRGB"}),
        "uv": (("row", "column"), shown(picture.uv, N_SHOWN), {"units": "sRGB"}),
        "labels": (("label", "label_row", "label_column"), _reduced(labels, step), {"units": "sky, by k-means"}),
    }


def _reduced(masks: Any, step: int) -> Any:
    """Masks (n, rows, columns) as most of the pixels of each block say, for the eye."""
    rows, columns = (length // step for length in masks.shape[1:])
    blocks = masks[:, : rows * step, : columns * step].reshape(len(masks), rows, step, columns, step)
    return blocks.mean(axis=(2, 4)) >= 0.5


def summarise(results: Results) -> Table:
    """A row for each scene, then mean, standard deviation and tests over all."""
    rows: list[dict[str, Any]] = []
    for cell, arrays in results:
        named = SCENES[NUMBERS[cell.scene]].is_named
        kind = "rendered, named in Table I" if named else "rendered, of the same kinds"
        rows.append(_row(cell.scene, kind, float(arrays["sky_share"]), arrays["accuracy"]))
    right = results["accuracy"]
    rows.append(_row("mean", "", float("nan"), right.mean(axis=0)))
    rows.append(_row("standard deviation", "", float("nan"), right.std(axis=0, ddof=1)))
    for reference in ("k-means, UV", "k-means, visible"):
        one = right[:, NAMES.index(reference)]
        others = right.T
        rows.append(
            _row(f"p, Wilcoxon against {reference}", "", float("nan"), [paired_wilcoxon(one, o).p for o in others])
        )
        rows.append(
            _row(f"p, F-ratio against {reference}", "", float("nan"), [variance_ratio(one, o).p for o in others])
        )
    return rows


def _row(scene: str, kind: str, sky_share: float, values: Any) -> dict[str, Any]:
    numbers = {name: float(value) for name, value in zip(NAMES, values, strict=True)}
    return {"scene": scene, "kind": kind, "sky_share": sky_share, **numbers}


def draw(results: Results) -> Figure:
    """The scenes with what k-means makes of them, and the accuracies of all ways."""
    return draw_scenes(results, NAMES)


def caption(results: Results) -> str:
    """What is shown."""
    cell = results.cells[0]
    size = FullSpectrum(reduction=cell.reduction).camera.size
    return (
        f"{len(results.cells)} scenes, all rendered ({size[1]} × {size[0]} pixels; exact masks), which stand in for "
        "the photographs of Table I: those with a star have the name of one. From left to right: visible light, "
        "ultraviolet, and the labels of k-means in either; white and black are sky and ground labelled right, blue is "
        "ground taken for sky, red is sky taken for ground; numbers are the share labelled right (%). Below: share "
        "labelled right by each method and light, a dot for each scene; bars are means, whiskers one standard "
        "deviation. Right of the line: ways that Table I has not. No photograph is in this figure."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Means, deviations, tests and claims; single scenes are not comparable."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    rows = {str(row["scene"]): row for row in table}
    n = sum(row["kind"] != "" for row in table)
    too_few = "" if n == len(SCENES) else f"needs all {len(SCENES)} scenes, this run has {n}"
    what, _, which = value.quantity.partition(": ")
    mean, spread = rows["mean"], rows["standard deviation"]
    if what == "mean":
        return judge(value, mean[which], spread[which] / np.sqrt(n), why=_worst(table, which), not_comparable=too_few)
    if what == "standard deviation":
        error = spread[which] / np.sqrt(2.0 * (n - 1))
        return judge(value, spread[which], error, why=_worst(table, which), not_comparable=too_few)
    if what.startswith("p of"):
        test = "Wilcoxon" if "Wilcoxon" in what else "F-ratio"
        p = rows[f"p, {test} against k-means, UV"][which]
        why = f"mean {mean[which]:.2f} against {mean['k-means, UV']:.2f} %, SD {spread[which]:.2f} against "
        return judge(value, p, why=f"{why}{spread['k-means, UV']:.2f}", not_comparable=too_few)
    one, _, other = which.partition(" and ")
    if what == "difference of the means":
        why = f"{one}: {mean[one]:.2f} %, {other}: {mean[other]:.2f} %; {_worst(table, one)}"
        return judge(value, mean[one] - mean[other], why=why, not_comparable=too_few)
    if what == "ratio of the standard deviations":
        why = f"{one}: {spread[one]:.2f}, {other}: {spread[other]:.2f}; {_worst(table, other)}"
        return judge(value, spread[one] / spread[other], why=why, not_comparable=too_few)
    ours = rows[what][which] if what in rows else float("nan")
    return judge(value, ours, not_comparable=STAND_IN)


def _worst(table: Table, which: str) -> str:
    """The three scenes in which a way does worst, and mean and deviation of the others."""
    scenes = sorted((row for row in table if row["kind"]), key=lambda row: row[which])
    worst = ", ".join(f"{row['scene']} {row[which]:.1f} %" for row in scenes[:3])
    rest = np.array([row[which] for row in scenes[3:]])
    if rest.size < 2:
        return "other scenes than the published"
    others = f"{rest.mean():.1f} ± {rest.std(ddof=1):.1f} % without these"
    return f"other scenes than the published; {which} is worst in: {worst}; {others}"
