"""Fig. 8, BMX Track: places recognised between two passages of a remote-controlled car."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict
from insectnav.experiments.stone2016_places.car_runs import (
    caption_of,
    car_sections,
    compare_runs,
    draw_runs,
    simulate_section,
    table_of,
)
from insectnav.experiments.stone2016_places.frames import Section
from insectnav.experiments.stone2016_places.sites import BMX

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 8"
TITLE = "BMX Track, rendered: FAB-MAP, SeqSLAM on grey pictures and on the sky, all rotations"
MADE_OF = "a built forest, its border with gardens and a suburban street"


@dataclass(frozen=True, kw_only=True)
class Cell(Section):
    """Frames of one passage."""


def grid(scale: str) -> Sequence[Cell]:
    """Two passages over the whole way and training passages elsewhere; or the beginnings, in small pictures."""
    return [Cell(**vars(section)) for section in car_sections(BMX.name, scale)]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What the methods compare, of each frame."""
    return simulate_section(cell, seed)


def summarise(results: Results) -> Table:
    """A row for each method and length of sequence."""
    return table_of(results)


def draw(results: Results) -> Figure:
    """Pictures, correspondences of four methods, precision over recall."""
    return draw_runs(results)


def caption(results: Results) -> str:
    """What the figure shows."""
    return caption_of(results, MADE_OF)


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The numbers of the text, and what it says in words."""
    return compare_runs(table, published)
