"""Fig. 5d: which way the agent goes when it starts for home."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from insectnav.angles import circular_mean, circular_std
from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import (
    HOME_RANGE,
    N_STEPS,
    NOISE_COLOURS,
    NOISE_LEVELS,
    PRESET_NAMES,
    random_trips,
    ways_home,
)
from insectnav.metrics.path_integration import departure_error
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 5d"
TITLE = "course on leaving the turning point, against the direction of home"
BIN_WIDTH_DEG = 10.0  # Fig. 5d


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One noise level under one set of constants."""

    preset: str
    noise: float
    n_trials: int = 1000  # Fig. 5d


def grid(scale: str) -> Sequence[Cell]:
    """All noise levels under both sets of constants."""
    n_trials = 1000 if scale == "full" else 200
    return [Cell(preset=preset, noise=noise, n_trials=n_trials) for preset in PRESETS for noise in NOISE_LEVELS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Angle from home to the course of each trial on leaving the circle; NaN where it never does."""
    arrays = random_trips(cell.n_trials, circuit_params(preset=cell.preset), noise=cell.noise, seed=seed)
    error = departure_error(ways_home(arrays, N_STEPS), HOME_RANGE)
    return {"departure_error": (("trial",), error, {"units": "rad"})}


def summarise(results: Results) -> Table:
    """Circular mean and SD for each noise level."""
    rows = []
    for cell, arrays in results:
        error = arrays["departure_error"][np.isfinite(arrays["departure_error"])]
        rows.append(
            {
                "preset": cell.preset,
                "noise": cell.noise,
                "circular_mean_deg": float(np.degrees(circular_mean(error))),
                "circular_sd_deg": float(np.degrees(circular_std(error))),
                "circular_sd_standard_error_deg": float(np.degrees(bootstrap_error(error, circular_std))),
                "n": error.size,
                "n_never_left": arrays["departure_error"].size - error.size,
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """Share of the trials in each bin of 10°, a line for each noise level, a panel for each set of constants."""
    from matplotlib.figure import Figure

    edges = np.arange(-180.0, 180.1, BIN_WIDTH_DEG)
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.6), layout="constrained")
    panels = figure.subplots(1, len(PRESETS), sharex=True, sharey=True)
    for axes, (preset, cells) in zip(panels, results.by("preset").items(), strict=True):
        for index in cells:
            noise = results.cells[index].noise
            counts, _ = np.histogram(np.degrees(results["departure_error"][index]), edges)
            share = 100.0 * counts / counts.sum()
            axes.stairs(share, edges, color=COLOURS[NOISE_COLOURS[noise]], linewidth=1.0, label=f"{noise:g}")
        axes.set_title(PRESET_NAMES[preset], loc="left")
        axes.set_xlabel("course minus direction of home (deg)")
        axes.set_xticks(np.arange(-180, 181, 60))
        axes.set_xlim(-180.0, 180.0)
    panels[0].set_ylabel("trials (% in a bin of 10°)")
    panels[-1].legend(title="noise $\\sigma_r$")
    return figure


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    n_trials = results.cells[0].n_trials
    return (
        f"Direction in which the agent leaves a circle of {HOME_RANGE:g} steps round the turning point of a random "
        f"trip of {N_STEPS} steps, from the direction of home (bins of {BIN_WIDTH_DEG:g}°; n = {n_trials} trials for "
        "each noise level, with the same routes in all)."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Circular SD at two noise levels, under the constants of the 2017 code."""
    ours = {f"circular SD at noise {row['noise']:g}": row for row in table if row["preset"] == "code-2017"}
    return [
        judge(value, ours[name]["circular_sd_deg"], ours[name]["circular_sd_standard_error_deg"])
        for name, value in published.items()
    ]
