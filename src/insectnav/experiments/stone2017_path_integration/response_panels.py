"""How Ext. Data Fig. 6 is drawn: responses of cells above, connections below."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

N_DOTS = 400
N_BINS = 12
SIGNED = "RdBu_r"  # red excites, blue inhibits; told apart by the colour-blind
PER_ROW = 5


def draw_responses_and_connections(
    results: Results, table: Table, labels: Mapping[str, str], weights: Mapping[str, NDArray[Any]]
) -> Figure:
    """The figure: a column of two panels for each population; then a matrix for each projection.

    Parameters
    ----------
    results : Results
        Of `insectnav.experiments.stone2017_path_integration.ed_6`.
    table : rows of its table
    labels : population to label
    weights : projection to signed (target, source) array
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 6.6), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.0, 1.15), hspace=0.04)
    above, below = parts
    panels = above.subplots(2, len(labels), sharex="col", sharey=True)
    for column, row in enumerate(table):
        _draw_responses(panels[:, column], results, row, column)
        panels[0, column].set_title(labels[row["population"]])
    for axes, text in zip(panels[:, 0], ("rate, no noise", "rate, noise 0.1"), strict=True):
        axes.set_ylabel(text)
    above.supxlabel("input I", fontsize=7.0)
    _draw_matrices(below, weights, labels)
    return figure


def _draw_responses(panels: NDArray[Any], results: Results, row: Mapping[str, Any], column: int) -> None:
    """Upper panel: without noise, with the fit; lower panel: with noise, mean and SD in bins of the input."""
    quiet, noisy = results.only(noise=0.0), results.only(noise=0.1)
    low, high = min(row["lowest_input"], -0.2), max(row["highest_input"], 0.2)
    margin = 0.25 * (high - low)
    wide = np.linspace(low - margin, high + margin, 100)
    is_linear = row["population"] == "tn2"
    fit = np.clip(wide, 0.0, 1.0) if is_linear else 1.0 / (1.0 + np.exp(row["bias"] - row["slope"] * wide))
    for axes, cell in zip(panels, (quiet, noisy), strict=True):
        axes.plot(wide, fit, color="0.6", linewidth=0.8, zorder=1)
        current, rate = results["input"][cell, column], results["output"][cell, column]
        axes.plot(current[:N_DOTS], rate[:N_DOTS], ".", color=COLOURS["sky"], markersize=1.5, zorder=2, alpha=0.6)
        axes.set_ylim(-0.03, 1.03)
    middle, mean, sd = _binned(results["input"][noisy, column], results["output"][noisy, column])
    style = {"color": COLOURS["blue"], "zorder": 3}
    panels[1].errorbar(middle, mean, sd, linewidth=1.0, elinewidth=0.6, **style)
    words = "linear,\nslope {slope:.2f}" if is_linear else "a = {slope:.2f}\nb = {bias:.2f}"
    is_low = is_linear or row["population"] in ("tl", "cpu1")  # the corner that the curve leaves free
    where = (0.04, 0.98, "left", "top") if is_low else (0.97, 0.03, "right", "bottom")
    text = words.format(slope=row["slope"] + 0.0, bias=round(row["bias"], 6) + 0.0)
    x, y, horizontal, vertical = where
    panels[0].text(x, y, text, transform=panels[0].transAxes, ha=horizontal, va=vertical, fontsize=6)


def _binned(current: NDArray[Any], rate: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Middle, mean rate and SD in bins of equal width that hold enough samples."""
    edges = np.linspace(current.min(), current.max(), N_BINS + 1)
    bins = np.clip(np.digitize(current, edges) - 1, 0, N_BINS - 1)
    full = [k for k in range(N_BINS) if np.sum(bins == k) >= 10]
    means = [float(rate[bins == k].mean()) for k in full]
    return (edges[:-1] + np.diff(edges) / 2.0)[full], np.array(means), np.array([rate[bins == k].std() for k in full])


def _draw_matrices(figure: Any, weights: Mapping[str, NDArray[Any]], labels: Mapping[str, str]) -> None:
    """One panel for each projection, red for excitation and blue for inhibition."""
    n_rows = -(-len(weights) // PER_ROW)
    panels = figure.subplots(n_rows, PER_ROW, squeeze=False)
    names = {**labels, "motor": "motor"}
    image = None
    for axes, (name, matrix) in zip(panels.ravel(), weights.items(), strict=False):
        source, _, target = name.partition("_to_")
        image = _draw_matrix(axes, matrix)
        axes.set_title(f"{names.get(source, 'TN2')} → {names[target]}", fontsize=7)
    for axes in panels.ravel()[len(weights) :]:
        axes.set_axis_off()
    bar = figure.colorbar(image, ax=panels, shrink=0.6, pad=0.01, aspect=30)
    bar.set_label("weight, with the sign of its effect")


def _draw_matrix(axes: Axes, matrix: NDArray[Any]) -> Any:
    """Weights (target, source) from −1 to 1, with the first and last cell numbered."""
    image = axes.imshow(matrix, cmap=SIGNED, vmin=-1.0, vmax=1.0, interpolation="none", aspect="auto")
    n_targets, n_sources = matrix.shape
    axes.set_box_aspect(min(max(n_targets / n_sources, 0.4), 1.5))  # two rows or columns would be too thin
    axes.set_xticks([0, n_sources - 1], ["1", str(n_sources)])
    axes.set_yticks([0, n_targets - 1], ["1", str(n_targets)])
    for spine in axes.spines.values():
        spine.set_visible(True)
    return image
