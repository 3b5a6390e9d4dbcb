"""Lookup by constellations on a recording: the railway of Nordland at other speeds, beside SeqSLAM."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.recordings.files import MISSING, N_NORDLAND, nordland
from insectnav.matching import (
    Matches,
    SeqSlamParams,
    constellation_index,
    difference_matrix,
    locate_by_constellations,
    seqslam,
)
from insectnav.vision.descriptors import patch_normalised

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "recording"
TITLE = "constellations of peaks on a railway, at the map's speed and others, beside SeqSLAM"
TOLERANCE = 5  # [frame of the map]
FIRST = 17  # frame from which on the train moves
MAP_EVERY = 2  # [frame]
COLUMNS, PIXELS = "columns", "pixels"
LENIENT, STRICT = "SeqSLAM, speeds 0.5 to 2", "SeqSLAM, speeds 0.8 to 1.2"
CONSTELLATIONS = "constellations"
WAYS = {  # name -> (descriptor, colour, line)
    f"{CONSTELLATIONS}, {COLUMNS}": (COLUMNS, "blue", "-o"),
    f"{LENIENT}, {COLUMNS}": (COLUMNS, "orange", "-o"),
    f"{LENIENT}, {PIXELS}": (PIXELS, "orange", "--o"),
    f"{STRICT}, {PIXELS}": (PIXELS, "grey", "--o"),
}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One way to find one drive.

    Parameters
    ----------
    way : one of `WAYS`
    season : of the query: "winter", or "summer", of which the map takes other frames
    every : frames from one query to the next; the map has every second
    n_frames : of the recording; 0 if it was not found
    """

    way: str
    season: str
    every: int
    n_frames: int


def grid(scale: str) -> Sequence[Cell]:
    """Speeds of half the map's to twice, in both seasons, at any scale."""
    n_frames = len(nordland("summer"))
    return [
        Cell(way=way, season=season, every=every, n_frames=n_frames)
        for season in ("summer", "winter")
        for way in WAYS
        for every in (1, 2, 3, 4)
    ]


def describe(frames: NDArray[Any], descriptor: str) -> NDArray[Any]:
    """Patch-normalised pixels, or their means down each column: a spectrum whose neighbours are side by side."""
    pixels = patch_normalised(frames)
    return pixels if descriptor == PIXELS else pixels.reshape(len(frames), *frames.shape[1:]).mean(axis=1)


def simulate(cell: Cell, seed: int) -> Arrays:
    """How many frames of the map each match is off; infinite where a query has none, NaN where there is no query."""
    off = np.full(N_NORDLAND, np.nan)
    if cell.n_frames:
        start = FIRST + (cell.season == "summer")  # frames between those of the map
        known, seen = nordland("summer")[FIRST::MAP_EVERY], nordland(cell.season)[start :: cell.every]
        descriptor = WAYS[cell.way][0]
        matches = _match(cell.way, describe(known, descriptor), describe(seen, descriptor))
        truth = (start - FIRST + cell.every * np.arange(len(seen))) / MAP_EVERY
        off[: len(seen)] = np.where(matches.reference >= 0, matches.reference - truth, np.inf)
    return {"off": (("query",), off, {"units": "frame of the map"})}


def _match(way: str, known: NDArray[Any], seen: NDArray[Any]) -> Matches:
    if way.startswith(CONSTELLATIONS):
        return locate_by_constellations(constellation_index(known), seen)
    slowest, fastest = (0.5, 2.0) if way.startswith(LENIENT) else (0.8, 1.2)
    difference = difference_matrix(known, seen)
    return seqslam(difference, SeqSlamParams(sequence_length=20, slowest=slowest, fastest=fastest))


def summarise(results: Results) -> Table:
    """A row for each cell; a query without a match is not found."""
    rows = []
    for cell, arrays in results:
        off = arrays["off"][~np.isnan(arrays["off"])]
        rows.append(
            {
                "way": cell.way,
                "season": cell.season,
                "speed": cell.every / MAP_EVERY,
                "kind": "real recording" if cell.n_frames else MISSING,
                "queries": len(off),
                "found": float(np.mean(np.abs(off) <= TOLERANCE)) if len(off) else float("nan"),
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """Share found over the speed, in the season of the map and in the other."""
    from matplotlib.figure import Figure

    table = summarise(results)
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.7), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, letter, season in zip(panels, "ab", ("summer", "winter"), strict=True):
        for way, (_, colour, line) in WAYS.items():
            rows = [row for row in table if (row["way"], row["season"]) == (way, season)]
            speeds, shares = [row["speed"] for row in rows], [100.0 * row["found"] for row in rows]
            axes.plot(speeds, shares, line, markersize=3, color=COLOURS[colour], label=way)
        if not results.cells[0].n_frames:
            axes.text(0.5, 0.5, "not found", transform=axes.transAxes, ha="center")
        axes.set(xlabel="speed (frames of the map for each query)", xticks=[0.5, 1.0, 1.5, 2.0], ylim=(-2, 104))
        name_panel(axes, letter, f"{season}, map of summer")
    panels[0].set_ylabel(f"found within {TOLERANCE} frames (%)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(WAYS))
    return figure


def caption(results: Results) -> str:
    """What is shown, and of which frames."""
    n_frames = results.cells[0].n_frames
    used = f"n = {n_frames} frames of each season" if n_frames else MISSING
    return (
        f"Nordland, a railway in summer and winter ({used}, without the first {FIRST}, while the train stands); the "
        f"map is every second frame of summer. Share of queries found within {TOLERANCE} frames of the map, over the "
        "speed: queries are every frame to every fourth, and one without a match, as near the ends of the drive, "
        "counts as not found. At speeds 1 and 2 queries of summer lie half way between frames of the map and those of "
        "winter at them; at 0.5 and 1.5 half of each do either. Columns: means of the patch-normalised frame down each "
        "of its 64 columns; pixels: all of it. Sequences of SeqSLAM have 20 steps."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What section 4.4.4 says of speed, in the season of the map."""
    (first, *_) = WAYS
    share = {row["speed"]: float(row["found"]) for row in table if (row["way"], row["season"]) == (first, "summer")}
    ours = share[2.0] / share[1.0] if share[1.0] > 0 else float("nan")
    missing = "" if table[0]["queries"] else MISSING
    why = f"at the map's speed {share[1.0]:.2f} are found, at twice the speed {share[2.0]:.2f}"
    return [judge(value, ours, why=why, not_comparable=missing) for value in published.values()]
