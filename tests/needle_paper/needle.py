"""Buffon's needle, as long as the boards are wide: it lies across a line with probability 2/π."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict, judge

FIGURE = "Fig. 1"
TITLE = "π from needles < 1 & boards"
N_BATCHES = 4


@dataclass(frozen=True, kw_only=True)
class Cell:
    n_throws: int


def grid(scale: str) -> Sequence[Cell]:
    return [Cell(n_throws=n) for n in ((1000, 20000) if scale == "quick" else (1000, 20000, 50000))]


def simulate(cell: Cell, seed: int) -> Arrays:
    rng = np.random.default_rng([seed, cell.n_throws])
    angle = rng.uniform(0.0, np.pi, (N_BATCHES, cell.n_throws))
    distance = rng.uniform(0.0, 0.5, (N_BATCHES, cell.n_throws))
    crossed = (distance <= 0.5 * np.sin(angle)).sum(axis=-1)
    return {"crossed": (("batch",), crossed, {"units": "1"})}


def summarise(results: Results) -> Table:
    rows = []
    for cell, arrays in results:
        n = N_BATCHES * cell.n_throws
        share = float(arrays["crossed"].sum()) / n
        error = 2.0 / share * math.sqrt((1.0 - share) / (n * share))  # of 2/share, by its slope
        rows.append({"n": n, "pi": 2.0 / share, "standard_error": error})
    return rows


def draw(results: Results) -> Figure:
    figure = Figure(figsize=(3.0, 2.0), layout="constrained")
    axes = figure.subplots()
    rows = summarise(results)
    axes.errorbar([r["n"] for r in rows], [r["pi"] for r in rows], [r["standard_error"] for r in rows], marker="o")
    axes.set_xlabel("throws")
    axes.set_ylabel("π")
    return figure


def caption(results: Results) -> str:
    return f"Twice the reciprocal share of needles that lie across a line (n = {len(results.cells)} numbers of throws)."


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    best = table[-1]
    why = f"{best['n']} throws give {best['pi']:.4f}: no length of needle gives 3.2"
    verdicts = []
    for quantity, number in published.items():
        reason = "we count no needles that broke" if quantity == "broken needles" else ""
        verdicts.append(judge(number, best["pi"], best["standard_error"], why=why, not_comparable=reason))
    return verdicts
