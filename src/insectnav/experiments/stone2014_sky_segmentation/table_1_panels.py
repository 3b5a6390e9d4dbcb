"""The figure of Table I: scenes with their labels, and the accuracies of all ways."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Results
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.stone2014_sky_segmentation.scenes import SCENES
from insectnav.experiments.stone2014_sky_segmentation.ways import IN_TABLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

N_COLUMNS = 3  # of scenes
LIGHT_COLOURS = {"visible": "orange", "UV-G": "green", "UV": "purple"}


def draw_scenes(results: Results, names: Sequence[str]) -> Figure:
    """All scenes of the results, and below them a dot for each scene and way."""
    from matplotlib.figure import Figure

    n_rows = -(-len(results.cells) // N_COLUMNS)
    height = 0.52 * n_rows
    figure = Figure(figsize=(DOUBLE_COLUMN, height + 2.2), layout="constrained")
    engine: Any = figure.get_layout_engine()
    engine.set(w_pad=0.01, h_pad=0.01, wspace=0.0, hspace=0.0)
    parts: Any = figure.subfigures(2, 1, height_ratios=(height, 2.2))
    upper, lower = parts
    panels = upper.subplots(n_rows, 4 * N_COLUMNS, squeeze=False, gridspec_kw={"wspace": 0.0, "hspace": 0.0})
    for axes in panels.ravel():
        axes.axis("off")
    right = {name: results["accuracy"][:, k] for k, name in enumerate(names)}
    for k, cell in enumerate(results.cells):
        row, column = divmod(k, N_COLUMNS)
        strip = panels[row, 4 * column : 4 * column + 4]
        numbers = right["k-means, visible"][k], right["k-means, UV"][k]
        _draw_scene(strip, {name: values[k] for name, values in results.arrays.items()}, cell.scene, numbers)
    _draw_accuracies(lower.subplots(), results["accuracy"], names)
    return figure


def _draw_scene(strip: Any, arrays: dict[str, Any], name: str, numbers: tuple[float, float]) -> None:
    star = "*" if next(scene.is_named for scene in SCENES if scene.name == name) else ""
    strip[0].set_title(name + star, loc="left", fontsize=5.0, pad=1.5)
    strip[0].imshow(arrays["visible"])
    strip[1].imshow(arrays["uv"], cmap="gray", vmin=0, vmax=255)
    truth = arrays["labels"][0]
    for axes, mask, number in zip(strip[2:], arrays["labels"][1:], numbers, strict=True):
        axes.imshow(label_picture(mask, truth))
        axes.text(0.97, 0.05, f"{number:.1f}", transform=axes.transAxes, ha="right", va="bottom", fontsize=4.5,
                  color="white", bbox={"facecolor": "black", "alpha": 0.6, "pad": 0.6, "linewidth": 0.0})  # fmt: skip


def label_picture(mask: Any, truth: Any) -> Any:
    """Labels in colour, (rows, columns, 3): black, white are right, blue is ground taken for sky, red the reverse."""
    from matplotlib.colors import to_rgb

    picture = np.repeat(np.where(truth, 1.0, 0.0)[..., None], 3, axis=-1)
    picture[mask & ~truth] = to_rgb(COLOURS["sky"])
    picture[~mask & truth] = to_rgb(COLOURS["red"])
    return picture


def _draw_accuracies(axes: Axes, right: Any, names: Sequence[str]) -> None:
    jitter = np.random.default_rng(0).uniform(-0.16, 0.16, len(right))
    for k, name in enumerate(names):
        light = name.partition(", ")[2].partition(" (")[0]
        colour = COLOURS[LIGHT_COLOURS[light]]
        axes.plot(k + jitter, right[:, k], "o", markersize=2.0, color=colour, alpha=0.7, markeredgewidth=0.0)
        spread = right[:, k].std(ddof=1)
        axes.errorbar(k, right[:, k].mean(), spread, fmt="_", color="black", markersize=12, linewidth=0.7)
    axes.axvline(len(IN_TABLE) - 0.5, color=COLOURS["grey"], linewidth=0.6, linestyle=":")
    axes.set_xticks(range(len(names)), [_in_lines(name) for name in names], fontsize=5.5)
    axes.set_ylabel("labelled right (%)")
    axes.set_ylim(min(45.0, right.min() - 2.0), 101.0)


def _in_lines(name: str) -> str:
    return name.replace(", ", "\n", 1).replace(" (mean of bands)", "\n(mean)").replace(" (CIELAB a, b)", "\n(a, b)")
