"""Fig. 3: how reliably the sky of one place is labelled over days of four weathers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import DOUBLE_COLUMN, RATES, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2014_sky_segmentation.photographs import FullSpectrum, shown, take
from insectnav.experiments.stone2014_sky_segmentation.table_1_panels import label_picture
from insectnav.experiments.stone2014_sky_segmentation.time_lapse import (
    DAY,
    EYE_HEIGHT,
    PITCH,
    WEATHERS,
    lapse_place,
    lapse_sky,
    moments,
)
from insectnav.experiments.stone2014_sky_segmentation.ways import IN_TABLE, sky_mask
from insectnav.metrics.segmentation import accuracy, label_correlation, label_entropy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 3"
TITLE = "labels of one rendered place over days of four weathers: entropy, correlation, accuracy"
WAYS = tuple(way for way in IN_TABLE if way.method != "gmm" and way.light != "uv-green")
NAMES = tuple(way.name for way in WAYS)
KMEANS = {"visible": "k-means, visible", "UV": "k-means, UV"}
OTHER_PLACE = "our place is another one, and rendered"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One moment.

    Parameters
    ----------
    weather : of `insectnav.worlds.clouds.weather_clouds`
    minute : of the day, UTC
    reduction, supersampling : as of `photographs.FullSpectrum`
    """

    weather: str
    minute: int
    reduction: int
    supersampling: int


def grid(scale: str) -> Sequence[Cell]:
    """Every ten minutes of four days at 201 × 134 pixels, or three moments of each at 75 × 50."""
    every = moments()
    chosen, reduction = (every, 3) if scale == "full" else (every[2 :: len(every) // 3], 8)
    return [
        Cell(weather=weather, minute=minute, reduction=reduction, supersampling=4)
        for weather in WEATHERS
        for minute in chosen
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Labels of one moment by each way, how many are right, and the pictures."""
    how = FullSpectrum(reduction=cell.reduction, supersampling=cell.supersampling)
    lit = lapse_place().under(lapse_sky(cell.weather, cell.minute))
    picture = take(lit, EYE_HEIGHT, PITCH, how, seed + cell.minute)
    masks = np.stack([sky_mask(picture, way, seed) for way in WAYS])
    right = np.array([accuracy(mask, picture.sky) for mask in masks])
    return {
        "accuracy": (("way",), 100.0 * right, {"units": "percent", "ways": ", ".join(NAMES)}),
        "sun_elevation": ((), np.array(lit.sky.sun_elevation), {"units": "rad"}),
        "labels": (("way", "row", "column"), masks),
        "sky": (("row", "column"), picture.sky),
        "visible": (("shown_row", "shown_column", "band"), shown(picture.visible, 150), {"units": "sRGB"}),
        "uv": (("shown_row", "shown_column"), shown(picture.uv, 150), {"units": "sRGB"}),
    }


def summarise(results: Results) -> Table:
    """A row for each weather and way, and for all together."""
    rows = []
    sets = {name: results.where(weather=weather) for weather, name in WEATHERS.items()}
    for weather, cells in {**sets, "all": np.arange(len(results.cells))}.items():
        for k, name in enumerate(NAMES):
            right, labels = results["accuracy"][cells, k], results["labels"][cells, k]
            correlation = _pairs(label_correlation(labels))
            rows.append(
                {
                    "weather": weather,
                    "way": name,
                    "kind": "rendered",
                    "n": len(cells),
                    "accuracy": float(right.mean()),
                    "accuracy_sd": float(right.std(ddof=1)),
                    "lowest_accuracy": float(right.min()),
                    "mean_entropy": float(label_entropy(labels).mean()),
                    "mean_correlation": float(correlation.mean()),
                    "lowest_correlation": float(correlation.min()),
                }
            )
    return rows


def _pairs(correlation: Any) -> Any:
    """The correlations of different frames; a frame of one label alone correlates with none."""
    return np.nan_to_num(correlation[np.triu_indices(len(correlation), 1)])


def draw(results: Results) -> Figure:
    """Examples of each weather above, entropy and correlation of visible light and UV below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.4), layout="constrained")
    engine: Any = figure.get_layout_engine()
    engine.set(w_pad=0.02, h_pad=0.02)
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.5, 2.9))
    upper, lower = parts
    _draw_examples(upper, results)
    panels = lower.subplots(2, 3, width_ratios=(1.5, 1.0, 1.9))
    for row, (light, name) in enumerate(KMEANS.items()):
        labels = results["labels"][:, NAMES.index(name)]
        entropy = panels[row, 0].imshow(label_entropy(labels), cmap=RATES, vmin=0.0, vmax=1.0)
        correlation = panels[row, 1].imshow(label_correlation(labels), cmap=RATES, vmin=0.0, vmax=1.0)
        name_panel(panels[row, 0], "be"[row], f"entropy, {light}: mean {label_entropy(labels).mean():.4f} bit")
        name_panel(panels[row, 1], "cf"[row], f"correlation, {light}")
        panels[row, 0].axis("off")
        ends = np.cumsum([len(cells) for cells in results.by("weather").values()])
        panels[row, 1].set_xticks(ends - 0.5, [])
        middles = ends - 0.5 - np.diff([0, *ends]) / 2.0
        panels[row, 1].set_yticks(middles, list(WEATHERS.values()), fontsize=5.0)
        panels[row, 1].tick_params(axis="y", length=0)
        lower.colorbar(entropy, ax=panels[row, 0], fraction=0.03)
        lower.colorbar(correlation, ax=panels[row, 1], fraction=0.05)
        _draw_course(panels[row, 2], results, name)
        name_panel(panels[row, 2], "dg"[row], f"labelled right, {light}")
    panels[0, 2].legend(loc="lower left", ncols=2)
    panels[1, 2].set_xlabel("time of day (h, UTC)")
    lowest = min(results["accuracy"][:, [NAMES.index(n) for n in KMEANS.values()]].min() - 2.0, 90.0)
    for axes in panels[:, 2]:
        axes.set_ylim(lowest, 100.5)
        axes.set_ylabel("%")
    return figure


def _draw_examples(part: Any, results: Results) -> None:
    """Visible light and UV with their labels at one moment of each weather."""
    panels = part.subplots(2, 2 * len(WEATHERS))
    for axes in panels.ravel():
        axes.axis("off")
    for place, (weather, cells) in enumerate(results.by("weather").items()):
        k = int(cells[len(cells) // 2])
        column, truth = 2 * place, results["sky"][k]
        panels[0, column].imshow(results["visible"][k])
        panels[1, column].imshow(results["uv"][k], cmap="gray", vmin=0, vmax=255)
        for row, name in enumerate(KMEANS.values()):
            panels[row, column + 1].imshow(label_picture(results["labels"][k, NAMES.index(name)], truth))
        cell = results.cells[k]
        title = f"{WEATHERS[weather]}, {cell.minute // 60}:{cell.minute % 60:02d}"
        if place:
            panels[0, column].set_title(title, loc="left", fontsize=6.0)
        else:
            name_panel(panels[0, 0], "a", title)


def _draw_course(axes: Any, results: Results, name: str) -> None:
    for weather, colour in zip(WEATHERS, ("C1", "C0", "C2", "C7"), strict=True):
        cells = results.where(weather=weather)
        hours = [results.cells[k].minute / 60.0 for k in cells]
        right = results["accuracy"][cells, NAMES.index(name)]
        axes.plot(hours, right, ".-", color=colour, markersize=3, linewidth=0.7, label=WEATHERS[weather])


def caption(results: Results) -> str:
    """What is shown."""
    size = FullSpectrum(reduction=results.cells[0].reduction).camera.size
    n = {len(cells) for cells in results.by("weather").values()}
    return (
        f"A street, rendered ({size[1]} × {size[0]} pixels), under the sky of Edinburgh on {DAY} in four weathers, "
        f"{min(n)} moments each, from sunrise to sunset as far as the sun stands 2° high; clouds drift, nothing else "
        "moves. No photograph is in this figure. a, One moment of each: visible light, its labels by k-means, "
        "ultraviolet, its labels; blue is ground taken for sky, red is sky taken for ground. b, e, Entropy of the "
        "label of each pixel over all moments. c, f, Correlation of the labels of each two moments. d, g, Share "
        "labelled right."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Claims on visible light and UV over all weathers; single numbers belong to another place."""
    rows = {row["way"]: row for row in table if row["weather"] == "all"}
    visible, uv = rows[KMEANS["visible"]], rows[KMEANS["UV"]]
    claims = {
        "accuracy of UV less that of visible light": uv["accuracy"] - visible["accuracy"],
        "deviation of the accuracy of visible light over that of UV": visible["accuracy_sd"] / uv["accuracy_sd"],
        "entropy of visible light over that of UV": visible["mean_entropy"] / uv["mean_entropy"],
        "lowest correlation of UV less that of visible light": uv["lowest_correlation"] - visible["lowest_correlation"],
        "mean correlation of UV less that of visible light": uv["mean_correlation"] - visible["mean_correlation"],
    }
    numbers = {
        "accuracy": "accuracy",
        "standard deviation of the accuracy": "accuracy_sd",
        "mean entropy": "mean_entropy",
    }
    verdicts = []
    for value in published.values():
        if value.quantity in claims:
            verdicts.append(judge(value, claims[value.quantity], why=_why(table)))
            continue
        what, _, light = value.quantity.rpartition(", ")
        verdicts.append(judge(value, rows[KMEANS[light]][numbers[what]], not_comparable=OTHER_PLACE))
    return verdicts


def _why(table: Table) -> str:
    """Accuracy in each weather."""
    parts = [
        f"{row['weather']} {row['way'].rpartition(', ')[2]} {row['accuracy']:.1f} ± {row['accuracy_sd']:.1f} %"
        for row in table
        if row["way"] in KMEANS.values()
    ]
    return f"by k-means: {', '.join(parts)}"
