# %% [markdown]
# # An experiment of your own
#
# How strongly must the cells of the heading ring (TB1) inhibit each other? The text of Stone et al. 2017 says 0.33;
# here the strength runs from nothing to three times that, without and with noise. The module has the same parts as a
# published experiment, so that it runs on all cores or a cluster, resumes, and leaves figure, table, data and
# provenance.

# %%
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from insectnav.agents import random_routes, run_trials
from insectnav.central_complex import THESIS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, SINGLE_COLUMN
from insectnav.metrics.path_integration import summary
from insectnav.sweep import executor, run_experiment

FIGURE = "own"
TITLE = "closest distance to the nest against the strength of inhibition within the heading ring"


# %% A cell is one point of the grid: plain numbers and words, so that any machine can be told what to do.
@dataclass(frozen=True, kw_only=True)
class Cell:
    strength: float
    noise: float
    n_trials: int


def grid(scale: str) -> Sequence[Cell]:
    n_trials = 1000 if scale == "full" else 100
    strengths = np.linspace(0.0, 1.0, 7).round(3).tolist()
    return [Cell(strength=s, noise=noise, n_trials=n_trials) for noise in (0.0, 0.1, 0.2) for s in strengths]


# %% What happens in a cell: arrays by name, with their dimensions and units.
def simulate(cell: Cell, seed: int) -> Arrays:
    routes = random_routes(cell.n_trials, 1500, seed=seed)
    circuit = replace(THESIS, tb1_to_tb1_strength=cell.strength)
    trials = run_trials(routes, circuit, noise=cell.noise, seed=seed)
    return {"closest_distance": (("trial",), trials["closest_distance"].values, {"units": "steps"})}


# %% What comes of all cells: a table, a figure, its caption, and the comparison with published numbers, if any.
def summarise(results: Results) -> Table:
    return [
        {"strength": cell.strength, "noise": cell.noise, **summary(arrays["closest_distance"])._asdict()}
        for cell, arrays in results
    ]


def draw(results: Results):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(SINGLE_COLUMN, 2.5), layout="constrained")
    axes = figure.subplots()
    for (noise, cells), colour in zip(results.by("noise").items(), ("black", "blue", "green"), strict=True):
        strength = [results.cells[i].strength for i in cells]
        axes.plot(strength, np.median(results["closest_distance"][cells], -1), ".-", color=COLOURS[colour], label=noise)
    axes.set_yscale("log")
    axes.set_xlabel("strength of inhibition TB1 to TB1")
    axes.set_ylabel("closest distance, median (steps)")
    axes.legend(title="noise $\\sigma_r$")
    return figure


def caption(results: Results) -> str:
    return f"Median closest distance to the nest; n = {results.cells[0].n_trials} trips of 1500 steps out and back."


def compare(table: Table, published: object) -> Sequence:
    return []


# %% Run it. On a cluster: executor(cluster="tcp://…").
if __name__ == "__main__":
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    with executor(workers=1) as on:
        outcome = run_experiment(sys.modules["__main__"], "inhibition", out, scale="quick", on=on)
    print((outcome.folder / "table.csv").read_text())
    print("figure, table and data:", outcome.folder)
