"""Fig. 4h: the circuit drawn by forces between its cells is a ring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.central_complex import N_CELLS, THESIS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import DOUBLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.ring_drawing import draw_circuit, draw_shapes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 4h"
TITLE = "force-directed drawing of the circuit"
POPULATIONS = ("tb1", "cpu4", "cpu1")
N_COLUMNS = 8
STRENGTHS = {  # projection: strength of its synapses
    "tb1_to_tb1": THESIS.tb1_to_tb1_strength,
    "tb1_to_cpu4": 1.0,
    "cpu4_to_cpu1": THESIS.cpu4_to_cpu1_strength,
    "tb1_to_cpu1": THESIS.tb1_to_cpu1_strength,
}
ALGORITHMS = ("kamada-kawai", "fruchterman-reingold")


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One algorithm, for the whole circuit or without the connections between TB1 cells."""

    algorithm: str
    has_tb1_ring: bool
    n_layouts: int = 60  # from as many random starts


def grid(scale: str) -> Sequence[Cell]:
    """Both algorithms, with and without the connections between TB1 cells."""
    n_layouts = 60 if scale == "full" else 12
    return [
        Cell(algorithm=algorithm, has_tb1_ring=has_tb1_ring, n_layouts=n_layouts)
        for algorithm in ALGORITHMS
        for has_tb1_ring in (True, False)
    ]


def circuit_graph(has_tb1_ring: bool = True) -> Any:
    """The circuit as an undirected graph: nodes (population, index), edges with their projection and weight.

    Parameters
    ----------
    has_tb1_ring : bool
        With the connections between TB1 cells.
    """
    import networkx

    graph = networkx.Graph()
    graph.add_nodes_from((population, cell) for population in POPULATIONS for cell in range(N_CELLS[population]))
    for projection, strength in STRENGTHS.items():
        source, _, target = projection.partition("_to_")
        matrix = getattr(THESIS.connectivity, projection)
        if projection == "tb1_to_tb1" and not has_tb1_ring:
            continue
        for i, j in np.argwhere(matrix > 0.0).tolist():
            if (source, j) != (target, i):
                graph.add_edge((source, j), (target, i), projection=projection, weight=strength * float(matrix[i, j]))
    return graph


def simulate(cell: Cell, seed: int) -> Arrays:
    """Layouts from random starts, their stress, and whether each is a ring."""
    graph = circuit_graph(cell.has_tb1_ring)
    starts = np.random.default_rng(seed).normal(size=(cell.n_layouts, len(graph), 2))
    places = np.stack([_layout(graph, start, cell.algorithm) for start in starts])
    middles = column_middles(places)
    return {
        "place": (("layout", "node", "xy"), places.astype(np.float32)),
        "stress": (("layout",), stress(places, _graph_distances(graph))),
        "is_in_order": (("layout",), is_in_order(middles)),
        "innermost": (("layout",), innermost(middles)),
    }


def _layout(graph: Any, start: NDArray[np.float64], algorithm: str) -> NDArray[np.float64]:
    """Places (node, 2) where the forces balance, by an algorithm."""
    import networkx

    places = dict(zip(graph, start, strict=True))
    if algorithm == "kamada-kawai":  # springs between all cells, as long as their distance along connections
        found = networkx.kamada_kawai_layout(graph, pos=places, weight=None)
    else:  # connections attract by their strength, all cells repel each other
        found = networkx.spring_layout(graph, pos=places, weight="weight", iterations=200, seed=0)
    return np.array([found[node] for node in graph])


def _graph_distances(graph: Any) -> NDArray[np.float64]:
    """Fewest connections from each cell to each other, (node, node)."""
    import networkx

    paths = dict(networkx.all_pairs_shortest_path_length(graph))
    return np.array([[paths[a][b] for b in graph] for a in graph], float)


def stress(places: NDArray[np.floating[Any]], distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far a layout is from drawing all distances true, (layout,): 0 where it does, whatever its scale.

    Parameters
    ----------
    places : (layout, node, 2) array
    distance : (node, node) array
        Fewest connections between two nodes.

    Notes
    -----
    ``mean over pairs of (k |x_i − x_j| / d_ij − 1)²`` at the scale k where it is least: the energy of the springs of
    Kamada & Kawai (1989), Information Processing Letters 31:7, doi 10.1016/0020-0190(89)90102-6.
    """
    pairs = np.triu_indices(len(distance), 1)
    drawn = np.linalg.norm(places[:, :, None] - places[:, None], axis=-1)[:, *pairs] / distance[pairs]
    # Least over k of the mean of (k q − 1)² is 1 − mean(q)² / mean(q²).
    return 1.0 - drawn.mean(axis=-1) ** 2 / (drawn**2).mean(axis=-1)


def column_middles(places: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Middle of the five cells of each column, from the middle of the drawing, (layout, 8, 2).

    Parameters
    ----------
    places : (layout, node, 2) array
        Nodes in the order of `circuit_graph`.
    """
    column = np.concatenate([np.arange(N_CELLS[population]) % N_COLUMNS for population in POPULATIONS])
    centred = np.asarray(places, float) - np.mean(places, axis=1, keepdims=True, dtype=float)
    return np.stack([centred[:, column == k].mean(axis=1) for k in range(N_COLUMNS)], axis=1)


def is_in_order(middles: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the columns follow each other round the middle as their directions do, either way round, (layout,).

    Parameters
    ----------
    middles : (layout, 8, 2) array
    """
    order = np.argsort(np.arctan2(middles[..., 1], middles[..., 0]), axis=1)
    step = (np.roll(order, -1, axis=1) - order) % N_COLUMNS
    return (step == 1).all(axis=1) | (step == N_COLUMNS - 1).all(axis=1)


def innermost(middles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of the innermost column from the middle over the mean of all: 1 for a circle, (layout,).

    Parameters
    ----------
    middles : (layout, 8, 2) array
    """
    radius = np.linalg.norm(middles, axis=-1)
    return radius.min(axis=1) / radius.mean(axis=1)


def summarise(results: Results) -> Table:
    """Whether the drawings are rings: the one of least stress, and how many of all."""
    rows = []
    for cell, arrays in results:
        best = int(np.argmin(arrays["stress"]))
        share = float(arrays["is_in_order"].mean())
        rows.append(
            {
                "algorithm": cell.algorithm,
                "has_tb1_ring": cell.has_tb1_ring,
                "least_stress": float(arrays["stress"][best]),
                "least_stress_is_in_order": float(arrays["is_in_order"][best]),
                "least_stress_innermost": float(arrays["innermost"][best]),
                "share_in_order": share,
                "share_in_order_standard_error": float(np.sqrt(share * (1.0 - share) / cell.n_layouts)),
                "highest_stress_in_order": _limit(arrays, True, np.max),
                "least_stress_out_of_order": _limit(arrays, False, np.min),
                "n": cell.n_layouts,
            }
        )
    return rows


def _limit(arrays: Mapping[str, NDArray[Any]], in_order: bool, limit: Any) -> float:
    chosen = arrays["stress"][arrays["is_in_order"] == in_order]
    return float(limit(chosen)) if chosen.size else float("nan")


def draw(results: Results) -> Figure:
    """The whole circuit and that without TB1–TB1 connections, in their layouts of least stress; all layouts."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 3.2), layout="constrained")
    panels = figure.subplots(1, 3, width_ratios=(1.25, 1.25, 1.0))
    for axes, has_tb1_ring in zip(panels[:2], (True, False), strict=True):
        index = results.only(algorithm="kamada-kawai", has_tb1_ring=has_tb1_ring)
        place = upright(results["place"][index, np.argmin(results["stress"][index])])
        draw_circuit(axes, circuit_graph(has_tb1_ring), place)
        axes.set_title("whole circuit" if has_tb1_ring else "without TB1–TB1 connections", loc="left")
    draw_shapes(panels[2], results)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, handlelength=2.2)
    return figure


def upright(place: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """The same drawing (node, 2) with column 1 on top, the others clockwise as their directions are, and mean radius 1.

    Parameters
    ----------
    place : (node, 2) array
    """
    place = np.asarray(place, float) - np.mean(place, axis=0, dtype=float)
    middles = column_middles(place[None])[0]
    area = np.sum(middles[:, 0] * np.roll(middles[:, 1], -1) - middles[:, 1] * np.roll(middles[:, 0], -1))
    if area > 0.0:  # anticlockwise
        place, middles = place * [-1.0, 1.0], middles * [-1.0, 1.0]
    angle = np.arctan2(middles[0, 0], middles[0, 1])
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return place @ rotation / np.linalg.norm(middles, axis=1).mean()


def caption(results: Results) -> str:
    """What is shown, and of how many layouts."""
    return (
        "The circuit of TB1, CPU4 and CPU1 cells, laid out by springs between all cells as long as their distance "
        f"along connections (Kamada–Kawai; the layout of least stress of n = {results.cells[0].n_layouts} random "
        "starts), with and without the connections between TB1 cells; numbers are columns. Between TB1 cells, solid: "
        "those of one cell, dashed: all others, width: strength. CPU1 cells listen to the CPU4 column to the right "
        "(orange) or to the left (yellow) of their TB1 column. Right: all layouts of the whole circuit; those whose "
        "columns are in order have the least stress."
    )


def column_shifts() -> NDArray[np.int64]:
    """By how many columns the CPU4 input of each CPU1 cell is shifted clockwise from its TB1 input, (16,)."""
    wiring = THESIS.connectivity
    memory, heading = (np.argmax(matrix, axis=1) for matrix in (wiring.cpu4_to_cpu1, wiring.tb1_to_cpu1))
    return (memory - heading + N_COLUMNS // 2) % N_COLUMNS - N_COLUMNS // 2


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Whether the circuit is a ring, and what the legend says of its connections."""
    rows = {(row["algorithm"], row["has_tb1_ring"]): row for row in table}
    whole, bare = rows["kamada-kawai", True], rows["kamada-kawai", False]
    shifts = column_shifts()
    weights = THESIS.connectivity.tb1_to_tb1[0]
    distance = np.minimum(np.arange(N_COLUMNS), N_COLUMNS - np.arange(N_COLUMNS))
    growth = [np.diff([weights[distance == d].mean() for d in range(5)]).min()]
    ours: dict[str, tuple[float, float]] = {
        "columns in order, layout of least stress": (whole["least_stress_is_in_order"], 0.0),
        "innermost over mean distance of a column from the middle": (whole["least_stress_innermost"], 0.0),
        "share of layouts in order, without TB1-TB1 connections": (
            bare["share_in_order"],
            bare["share_in_order_standard_error"],
        ),
        "shift of the CPU4 input of CPU1 cells, rightwards": (float(shifts.max()), 0.0),
        "shift of the CPU4 input of CPU1 cells, leftwards": (float(shifts.min()), 0.0),
        "CPU1 cells shifted rightwards": (float(np.sum(shifts > 0)), 0.0),
        "least growth of TB1-TB1 strength with distance by a column": (float(min(growth)), 0.0),
    }
    why = f"{100.0 * whole['share_in_order']:.0f} % of {whole['n']} layouts of the whole circuit are in order"
    return [judge(value, *ours[name], why=why) for name, value in published.items()]
