"""Fig. 4.5: catchment areas of twenty places, by what views are compared by and at which headings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_homing.area_table import area_row, paired_row
from insectnav.experiments.stone2016_homing.comparisons import COMPARISONS, measures_by
from insectnav.experiments.stone2016_homing.places import (
    CORNERS,
    HEADINGS,
    NOT_THE_WORLD,
    SIZE,
    SUCCESS_CELLS,
    areas,
    open_world,
    place_text,
    stage,
    stands_in,
    surfaces_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 4.5"
TITLE = "catchment areas by comparison of views, aligned and at random headings"
NAMES = tuple(COMPARISONS)
SMALLEST_SHOWN = 0.002  # [m²] five starts on the finest grid; what is smaller stands at the edge


@dataclass(frozen=True, kw_only=True)
class Cell:
    """The box surveyed once, all views facing north or each at a heading of its own."""

    world: str
    corner: float  # [m]
    heading: str
    spacing: float  # [m] of the fine grid
    every: int  # the second grid has every so manieth sample of it; 1 where there is none
    supersampling: int = 4  # as in the published anti-aliased views


def grid(scale: str) -> Sequence[Cell]:
    """Both headings; at full scale on the thesis's grid of 2 cm, of which the 2018 code's of 10 cm is a part."""
    world = stage("clearing")
    spacing, every, rays = (0.02, 5, 4) if scale == "full" else (0.2, 1, 2)
    settings: dict[str, Any] = {"spacing": spacing, "every": every, "supersampling": rays}
    return [Cell(world=world, corner=CORNERS[world], heading=heading, **settings) for heading in HEADINGS]


def spacings(cell: Cell) -> dict[int, float]:
    """Which samples are taken, every one or every fifth, and how far apart they then are [m]."""
    return {every: round(cell.spacing * every, 6) for every in dict.fromkeys((1, cell.every))}


def simulate(cell: Cell, seed: int) -> Arrays:
    """Catchment area of each place by each comparison, on the fine and on the coarse grid."""
    found = surfaces_of(cell, open_world(cell.world), measures_by(NAMES), seed)
    area = [
        [
            areas(found[name], cell.spacing, SUCCESS_CELLS * spacing, every=every)
            for every, spacing in spacings(cell).items()
        ]
        for name in NAMES
    ]
    return {"area": (("comparison", "grid", "reference"), np.array(area, np.float32), {"units": "m2"})}


def summarise(results: Results) -> Table:
    """Mean area and its SD by comparison, grid and heading, with paired tests: against pixels, and between headings."""
    rows = []
    for index, cell in enumerate(results.cells):
        other = results["area"][1 - index]
        area = results["area"][index]
        for k, name in enumerate(NAMES):
            for level, spacing in enumerate(spacings(cell).values()):
                where = {"world": cell.world, "heading": cell.heading, "comparison": name, "spacing_m": spacing}
                rows.append(
                    where
                    | area_row(area[k, level])
                    | paired_row(area[k, level], area[0, level], "retinotopic")
                    | paired_row(area[k, level], other[k, level], "other_heading")
                )
    return rows


def draw(results: Results) -> Figure:
    """A panel for each grid: areas of the twenty places, and their mean, by comparison and heading."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 3.3), layout="constrained")
    grids = spacings(results.cells[0]).values()
    panels = figure.subplots(1, len(grids), sharey=True, squeeze=False)[0]
    for level, (axes, spacing) in enumerate(zip(panels, grids, strict=True)):
        _draw_areas(axes, results, level)
        name_panel(axes, "ab"[level], f"views every {100.0 * spacing:g} cm")
    panels[0].legend(loc="lower right", handletextpad=0.3)
    return figure


def _draw_areas(axes: Axes, results: Results, level: int) -> None:
    """One dot a place, jittered by its number alone; bars are means with one SD."""
    jitter = 0.11 * (np.arange(results["area"].shape[-1]) / (results["area"].shape[-1] - 1) * 2.0 - 1.0)
    for k, name in enumerate(NAMES):
        for heading, offset, is_filled in (("aligned", -0.19, True), ("random", 0.19, False)):
            values = results["area"][results.only(heading=heading), k, level].astype(float)
            y, colour = k + offset, COLOURS[COMPARISONS[name].colour]
            style: dict[str, Any] = {
                "facecolors": colour if is_filled else "none",
                "edgecolors": colour,
                "linewidths": 0.5,
            }
            axes.scatter(np.maximum(values, SMALLEST_SHOWN), y + jitter, s=5.0, alpha=0.75, zorder=2, **style)
            mean, sd = values.mean(), values.std(ddof=1)
            ends = [[min(sd, mean - SMALLEST_SHOWN)], [sd]]
            axes.errorbar(mean, y, xerr=ends, fmt="|", color="black", markersize=9.0, elinewidth=0.7, zorder=3)
    for words, face in (("facing north", "black"), ("random headings", "none")):
        axes.scatter([], [], s=8.0, facecolors=face, edgecolors="black", linewidths=0.5, label=words)
    axes.set_yticks(range(len(NAMES)), [COMPARISONS[name].label for name in NAMES])
    axes.set_ylim(len(NAMES) - 0.5, -0.5)
    axes.set_xscale("log")
    axes.set_xlim(SMALLEST_SHOWN, SIZE**2)
    axes.set_xticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
    axes.set_xlabel(f"catchment area (m², of {SIZE**2:g})")


def caption(results: Results) -> str:
    """What is shown, and of how many places."""
    cell = results.cells[0]
    grids = " (a) and every ".join(f"{100.0 * spacing:g} cm" for spacing in spacings(cell).values())
    n = results["area"].shape[-1]
    return (
        f"Catchment areas in a box of {SIZE:g} × {SIZE:g} m round n = {n} evenly spaced places (dots; bars: mean and "
        f"SD), from views every {grids}{' (b)' if cell.every > 1 else ''}. Remembered views face north; views on the "
        f"grid face north (filled) or each its own way (open). {cell.supersampling}² rays a pixel of 1°, success "
        f"within {SUCCESS_CELLS:g} cells. {place_text(cell.world)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Claims of the thesis on its grid and on that of the 2018 code, and what was measured earlier on the latter."""
    return [_verdict(table, value) for value in published.values()]


COLUMNS = {  # of what a quantity names: value and standard error
    "one-sided p of a larger area than retinotopic": ("p_larger_than_retinotopic", ""),
    "area at random headings over aligned": ("over_other_heading", "over_other_heading_standard_error"),
    "mean area": ("mean_area_m2", "standard_error_m2"),
    "mean area (measured earlier)": ("mean_area_m2", "standard_error_m2"),
}


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "<what>, <comparison>, <heading>, <spacing> cm"."""
    what, name, heading, spacing = value.quantity.split(", ")
    wanted = {"comparison": name, "heading": heading}
    rows = [row for row in table if wanted.items() <= row.items()]
    row = next((row for row in rows if spacing == f"{100.0 * row['spacing_m']:g} cm"), None)
    if stands_in(table[0]["world"]):
        return judge(value, float("nan"), not_comparable=NOT_THE_WORLD)
    if row is None:
        return judge(value, float("nan"), not_comparable=f"views every {spacing} are surveyed at full scale alone")
    column, error = COLUMNS[what]
    others = [other for other in table if other["heading"] == heading and other["comparison"] in ("retinotopic", name)]
    means = "; ".join(
        f"{other['comparison']} {other['mean_area_m2']:.3g} m2 at {100.0 * other['spacing_m']:g} cm" for other in others
    )
    why = (
        f"mean areas, {heading}: {means}; of the same views, every one or every fifth; see stone2016-sampling for rays"
    )
    return judge(value, row[column], row[error] if error else 0.0, why=why)
