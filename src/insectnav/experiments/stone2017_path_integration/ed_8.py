"""Ext. Data Fig. 8: examples of random trips and the ways home from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, N_STEPS, PRESET_NAMES, random_trips
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 8"
TITLE = "example routes, with the home range round the nest"
NOISE = 0.1  # as in Fig. 5a
N_DRAWN = 12
N_COLUMNS = 4
PRESET_COLOURS = {"thesis": "blue", "code-2017": "orange"}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One set of constants."""

    preset: str
    n_trials: int = 1000


def grid(scale: str) -> Sequence[Cell]:
    """Both sets of constants."""
    return [Cell(preset=preset, n_trials=1000 if scale == "full" else 200) for preset in PRESETS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Paths of the first trials, and how near all of them came to the nest and when."""
    arrays = random_trips(cell.n_trials, circuit_params(preset=cell.preset), noise=NOISE, seed=seed)
    distance = np.linalg.norm(arrays.position[:, N_STEPS:], axis=-1)
    is_home = distance <= HOME_RANGE
    arrival = np.where(is_home.any(axis=1), np.argmax(is_home, axis=1) + 1.0, np.nan)
    return {
        "path": (("drawn", "step", "xy"), arrays.position[:N_DRAWN].astype(np.float32), {"units": "steps"}),
        "closest_distance": (("trial",), arrays.closest_distance.astype(np.float32), {"units": "steps"}),
        "arrival": (("trial",), arrival.astype(np.float32), {"units": "steps", "long_name": "first within home range"}),
    }


def summarise(results: Results) -> Table:
    """Share of the trips that came within the home range, of all and of those drawn."""
    rows = []
    for cell, arrays in results:
        is_home = arrays["closest_distance"] <= HOME_RANGE
        share = float(is_home.mean())
        rows.append(
            {
                "preset": cell.preset,
                "share_home": share,
                "share_home_standard_error": float(
                    np.sqrt(max(share * (1.0 - share), 1.0 / is_home.size) / is_home.size)
                ),
                "share_home_of_drawn": float(is_home[:N_DRAWN].mean()),
                "n_drawn": min(N_DRAWN, is_home.size),
                "median_closest": float(np.median(arrays["closest_distance"])),
                "median_closest_standard_error": bootstrap_error(arrays["closest_distance"], np.median),
                "largest_closest": float(arrays["closest_distance"].max()),
                "median_arrival": float(np.nanmedian(arrays["arrival"])) if is_home.any() else float("nan"),
                "n": is_home.size,
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """A map for each trip: the way out, and the ways home under both sets of constants."""
    from matplotlib.figure import Figure

    n_drawn = results["path"].shape[1]
    n_rows = -(-n_drawn // N_COLUMNS)
    figure = Figure(figsize=(DOUBLE_COLUMN, 1.85 * n_rows + 0.35), layout="constrained")
    panels = figure.subplots(n_rows, N_COLUMNS, squeeze=False)
    for trial, axes in enumerate(panels.ravel()):
        if trial >= n_drawn:
            axes.set_axis_off()
            continue
        _draw_trip(axes, results, trial)
    for axes in panels[-1]:
        axes.set_xlabel("x (steps)")
    for axes in panels[:, 0]:
        axes.set_ylabel("y (steps)")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _draw_trip(axes: Axes, results: Results, trial: int) -> None:
    """One trip with its ways home, the nest, the home range and the turning point."""
    from matplotlib.patches import Circle

    outbound = results["path"][0, trial, :N_STEPS]
    axes.plot(*outbound.T, color=COLOURS["grey"], linewidth=0.7, label="out")
    for index, cell in enumerate(results.cells):
        home = results["path"][index, trial, N_STEPS - 1 :]
        colour = COLOURS[PRESET_COLOURS[cell.preset]]
        axes.plot(*home.T, color=colour, linewidth=0.6, label=f"home, {PRESET_NAMES[cell.preset]}")
    circle: dict[str, Any] = {"fill": False, "linestyle": "--", "linewidth": 0.8, "edgecolor": "black", "zorder": 4}
    axes.add_patch(Circle((0.0, 0.0), HOME_RANGE, **circle))
    axes.plot([], [], color="black", linestyle="--", linewidth=0.8, label=f"home range, {HOME_RANGE:g} steps")
    mark: dict[str, Any] = {"linestyle": "none", "markersize": 3.0, "markeredgewidth": 0.6, "zorder": 5}
    axes.plot(*outbound[-1], marker="s", color=COLOURS["red"], label="turning point", **mark)
    axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", label="nest", **mark)
    axes.set_title(str(trial + 1), loc="left", fontsize=6.5, pad=2.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=4)


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    shares = ", ".join(
        f"{100.0 * row['share_home']:.1f} % with {PRESET_NAMES[row['preset']]}" for row in summarise(results)
    )
    return (
        f"The first {results['path'].shape[1]} random trips, {N_STEPS} steps out and {N_STEPS} home, noise {NOISE:g}; "
        f"the same trips out for both sets of constants. Of n = {results.cells[0].n_trials} trips, those that came "
        f"within {HOME_RANGE:g} steps of the nest: {shares}."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Success as the figure illustrates it, under both sets of constants."""
    verdicts = []
    for value in published.values():
        what, _, constants = value.quantity.partition(", ")
        row = next(row for row in table if PRESET_NAMES[row["preset"]] == constants)
        why = f"the farthest trip came to {row['largest_closest']:.1f} steps, the median to {row['median_closest']:.2f}"
        ours = {
            "share of trips that reach the home range": (row["share_home"], row["share_home_standard_error"]),
            "closest distance": (row["median_closest"], row["median_closest_standard_error"]),
        }
        verdicts.append(judge(value, *ours[what], why=why))
    return verdicts
