"""A robot outdoors on the route that it knows: how far from its place each view is put, by single panoramas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.recordings.files import MISSING, OTHER_RECORDING, Drive, sussex
from insectnav.matching import difference_matrix, nearest_view, turn_matrix
from insectnav.metrics.retrieval import position_error
from insectnav.vision.descriptors import DESCRIPTORS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "recording"
TITLE = "a robot on a route that it knows: position by single panoramas, by turning them or not"
N_VIEWS = 102
COMPASS = "visual compass, all turns"
COLOUR = {COMPASS: "blue", "retinotopic": "orange", "frequency-strip": "grey"}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One comparison of views.

    Parameters
    ----------
    way : how views are compared
    n_places : views of the known drive; 0 if the recording was not found
    """

    way: str
    n_places: int


def grid(scale: str) -> Sequence[Cell]:
    """All of the recording at any scale."""
    n_places = len(sussex("training").views)
    return [Cell(way=way, n_places=n_places) for way in COLOUR]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Distance from where each view was taken to where its match was, and both places; NaN where not tracked."""
    there, matched = np.full((N_VIEWS, 2), np.nan), np.full((N_VIEWS, 2), np.nan)
    error = np.full(N_VIEWS, np.nan)
    if cell.n_places:
        known, seen = sussex("training"), sussex("test")
        reference = _nearest(cell.way, known, seen)
        there[:], matched[:] = seen.position, known.position[reference]
        error[:] = position_error(known.position, seen.position, reference)
    return {
        "error": (("view",), error, {"units": "m"}),
        "taken": (("view", "xy"), there, {"units": "m"}),
        "matched": (("view", "xy"), matched, {"units": "m"}),
    }


def _nearest(way: str, known: Drive, seen: Drive) -> np.ndarray:
    if way == COMPASS:
        return nearest_view(turn_matrix(known.views, seen.views)).reference
    describe = DESCRIPTORS[way]
    return np.asarray(difference_matrix(describe(known.views), describe(seen.views), describe.metric).argmin(axis=0))


def summarise(results: Results) -> Table:
    """A row for each comparison."""
    rows = []
    for cell, arrays in results:
        error = arrays["error"][np.isfinite(arrays["error"])]
        middle, most = (100.0 * np.quantile(error, q) if len(error) else np.nan for q in (0.5, 1.0))
        rows.append(
            {
                "way": cell.way,
                "kind": "real recording" if cell.n_places else MISSING,
                "places": cell.n_places,
                "tracked_views": len(error),
                "median_cm": float(middle),
                "most_cm": float(most),
                "within_50_cm": float(np.mean(error < 0.5)) if len(error) else float("nan"),
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """Where views were taken and matched, and how many are how far off."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 2.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 2.0))
    for cell, arrays in results:
        error = np.sort(arrays["error"][np.isfinite(arrays["error"])])
        if not len(error):
            right.text(0.5, 0.5, "not found", transform=right.transAxes, ha="center")
            continue
        share = np.arange(1, len(error) + 1) / len(error)
        right.plot(100 * error, share, drawstyle="steps-post", color=COLOURS[COLOUR[cell.way]], label=cell.way)
        if cell.way == COMPASS:
            for start, end in zip(arrays["taken"], arrays["matched"], strict=True):
                left.plot(*np.stack([start, end]).T, color=COLOURS["grey"], linewidth=0.6)
            left.plot(*arrays["taken"].T, ".", color=COLOURS["blue"], markersize=3, label="taken")
            left.plot(*arrays["matched"].T, ".", color=COLOURS["orange"], markersize=3, label="matched with")
            left.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    left.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", xticks=[0, 1, 2])
    name_panel(left, "a", COMPASS)
    right.set(xlabel="off by at most (cm)", ylabel="share of views", xscale="log", ylim=(0, 1.02))
    name_panel(right, "b", "position error")
    if results.cells[0].n_places:
        right.legend(loc="lower right")
    return figure


def caption(results: Results) -> str:
    """What is shown, and of which views."""
    cell = results.cells[0]
    used = f"{cell.n_places} views of one drive are the map" if cell.n_places else MISSING
    return (
        f"A robot outdoors (recording of the University of Sussex, panoramas of 120 × 25 pixels; {used}). a, Where "
        "each tracked view of a second drive was taken, and where the view was taken that resembles it most after any "
        "turn. b, Distance between the two, cumulated, for views compared after all turns, as they are, and by the "
        "amplitudes of their frequencies along the horizon."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The visual compass of RSS 2014 beside ours: another recording."""
    ours = next(100.0 * float(row["within_50_cm"]) for row in table if row["way"] == COMPASS)
    return [judge(value, ours, not_comparable=OTHER_RECORDING) for value in published.values()]
