"""Uniform random numbers, drawn at leisure."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.rng import trial_streams

FIGURE = "Fig. 1"
TITLE = "means of uniform numbers"
PACE = "SLOW_PAPER_PACE"  # an environment variable; 0 is no time at all
HOLD = "SLOW_PAPER_HOLD"  # another; cells of this level and above last until they are killed
FOREVER = 600.0  # [s], which is longer than a test waits for anything
N_TRIALS = {"quick": 2000, "full": 4000}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Numbers of one stream; what else happens says `does`."""

    purpose: str
    is_even: bool
    level: float
    n_trials: int = 100
    seconds: float = 0.0
    does: str = "nothing"


def grid(scale: str) -> Sequence[Cell]:
    """Sixteen cells that take unequal times."""
    return [
        Cell(
            purpose=purpose,
            is_even=level % 2 == 0,
            level=float(level),
            n_trials=N_TRIALS[scale],
            seconds=0.1 + 0.05 * (5 * level % 8),
        )
        for purpose in ("süß", "sour")
        for level in range(8)
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """The numbers, and the cell's misdeed."""
    is_held = cell.level >= float(os.environ.get(HOLD, "inf"))
    time.sleep(FOREVER if is_held else cell.seconds * float(os.environ.get(PACE, "1")))
    if cell.does == "raises":
        raise ZeroDivisionError("no such level")
    if cell.does == "dies":
        os._exit(9)
    words = trial_streams(seed, np.arange(cell.n_trials), f"{cell.purpose} {cell.level}")
    numbers = words.astype(np.float32) / 2.0**32
    return {
        "numbers": (("trial", "word"), numbers, {"units": "1", "range": (0.0, 1.0)}),
        "mean": ((), numbers.astype(float).mean()),
        "zeros": (("word",), np.zeros(4, bool)),
        "nothing": (("trial", "never"), np.empty((cell.n_trials, 0), np.int16)),
    }


def summarise(results: Results) -> Table:
    """Mean of each cell."""
    return [
        {"purpose": cell.purpose, "is_even": cell.is_even, "level": cell.level, "mean": float(arrays["mean"])}
        for cell, arrays in results
    ]


def draw(results: Results) -> Figure:
    """Means over levels."""
    figure = Figure(figsize=(2.0, 1.5), layout="constrained")
    axes = figure.subplots()
    for purpose, cells in results.by("purpose").items():
        axes.plot([results.cells[index].level for index in cells], results["mean"][cells], label=purpose)
    axes.set_xlabel("level")
    axes.set_ylabel("mean")
    return figure


def caption(results: Results) -> str:
    """What is shown."""
    return f"Means of uniform numbers (n = {results.cells[0].n_trials})."


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Means of even and odd cells; 8 cells of at least 4 · 2000 numbers each."""
    verdicts = []
    for name, value in published.items():
        means = [row["mean"] for row in table if row["is_even"] == ("even" in name)]
        verdicts.append(judge(value, float(np.mean(means)), float(np.std(means) / len(means) ** 0.5)))
    return verdicts
