"""How Fig. 4h is drawn: cells as dots, connections as lines."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Results
from insectnav.experiments.figures import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CELL_COLOURS = {"tb1": "green", "cpu4": "purple", "cpu1": "sky"}
CELL_LABELS = {"tb1": "TB1", "cpu4": "CPU4", "cpu1": "CPU1"}
SHOWN_CELL = ("tb1", 0)  # whose connections to other TB1 cells are solid
LARGEST_WIDTH = 1.8  # [point] of the strongest connection between TB1 cells


def draw_circuit(axes: Axes, graph: Any, place: NDArray[np.float64]) -> None:
    """Cells and connections of a laid-out circuit.

    Parameters
    ----------
    axes : Axes
    graph : networkx Graph
        From `insectnav.experiments.stone2017_path_integration.fig_4h.circuit_graph`.
    place : (node, 2) array
        In the order of its nodes.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.patheffects import Normal, Stroke

    where = dict(zip(graph, place, strict=True))
    labels = set()
    for (a, b), style, label in _lines(graph):
        outline = [Stroke(linewidth=style["linewidths"] + 0.7, foreground="0.35"), Normal()]
        is_yellow = style["colors"] == COLOURS["yellow"]  # too pale on white without an outline
        lines = LineCollection([[where[a], where[b]]], **style, path_effects=outline if is_yellow else None)
        axes.add_collection(lines)
        if label not in labels:
            labels.add(label)
            line = {"color": style["colors"], "linewidth": 1.2, "linestyle": style["linestyles"]}
            axes.plot([], [], label=label, **line, path_effects=outline if is_yellow else None)
    for population, label in CELL_LABELS.items():
        nodes = [node for node in graph if node[0] == population]
        xy = np.array([where[node] for node in nodes])
        dots: dict[str, Any] = {
            "s": 48,
            "color": COLOURS[CELL_COLOURS[population]],
            "edgecolors": "black",
            "linewidths": 0.4,
        }
        axes.scatter(*xy.T, zorder=4, label=label, **dots)
        for (_, cell), (x, y) in zip(nodes, xy, strict=True):
            axes.text(x, y, str(cell % 8 + 1), fontsize=5, ha="center", va="center_baseline", zorder=5)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.margins(0.06)


def _lines(graph: Any) -> Iterator[tuple[tuple, dict[str, Any], str]]:
    """Both ends, style and label of each connection; the faint ones first."""
    strongest = max((e["weight"] for *_, e in graph.edges(data=True) if e["projection"] == "tb1_to_tb1"), default=1.0)
    for a, b, edge in sorted(graph.edges(data=True), key=lambda edge: SHOWN_CELL in edge[:2]):
        if edge["projection"] == "tb1_to_tb1":
            is_shown = SHOWN_CELL in (a, b)
            style = {
                "colors": COLOURS["green"] if is_shown else COLOURS["grey"],
                "linewidths": LARGEST_WIDTH * edge["weight"] / strongest * (1.0 if is_shown else 0.5),
                "linestyles": "-" if is_shown else "--",
                "zorder": 2 if is_shown else 1,
            }
            yield (a, b), style, "TB1–TB1, of one cell" if is_shown else "TB1–TB1, of the others"
        elif edge["projection"] == "cpu4_to_cpu1":
            memory, steering = (a, b) if a[0] == "cpu4" else (b, a)
            is_right = (memory[1] - steering[1]) % 8 == 1
            style = {"colors": COLOURS["orange" if is_right else "yellow"], "linewidths": 1.4, "linestyles": "-"}
            yield (a, b), style | {"zorder": 3}, f"CPU4–CPU1, shifted {'right' if is_right else 'left'}"
        else:
            yield (a, b), {"colors": "0.45", "linewidths": 0.6, "linestyles": "-", "zorder": 2}, "TB1–CPU4, TB1–CPU1"


def draw_shapes(axes: Axes, results: Results) -> None:
    """Stress against roundness of all layouts of the whole circuit, in order or not.

    Parameters
    ----------
    axes : Axes
    results : Results
        Of `insectnav.experiments.stone2017_path_integration.fig_4h`.
    """
    index = results.only(algorithm="kamada-kawai", has_tb1_ring=True)
    stress, innermost, is_in_order = (results[name][index] for name in ("stress", "innermost", "is_in_order"))
    for chosen, marker, colour, label in (
        (is_in_order, "o", "blue", "columns in order"),
        (~is_in_order, "x", "red", "not in order"),
    ):
        axes.scatter(innermost[chosen], stress[chosen], s=12, marker=marker, color=COLOURS[colour], label=label)
    axes.set_xlim(0.0, 1.03)
    axes.set_xlabel("innermost / mean distance of a column")
    axes.set_ylabel("stress of the layout")
    axes.set_title("whole circuit, all layouts", loc="left")
    axes.legend(loc="lower left")
