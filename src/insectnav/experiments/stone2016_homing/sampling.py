"""How catchment areas depend on spacing, rays a pixel and success radius: what section 4.3 leaves open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

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
    roughness,
    stage,
    stands_in,
    surfaces_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "text"
TITLE = "catchment area against spacing of views, rays a pixel and success radius"
NAMES = ("retinotopic", "zernike", "zernike-orthonormal", "harmonic-orders")
WIDE_RADIUS = 0.3  # [m] one radius for all spacings: 1.5 cells of the coarsest
RULES = (f"{SUCCESS_CELLS:g} cells", f"{WIDE_RADIUS:g} m")
RAYS = (1, 2, 4, 8)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """The box surveyed once, with so many rays along each side of a pixel."""

    world: str
    corner: float  # [m]
    heading: str
    spacing: float  # [m] of the finest grid
    n_spacings: int  # each twice the one before
    supersampling: int


def grid(scale: str) -> Sequence[Cell]:
    """All numbers of rays at both headings, down to 5 cm, and most rays at 2 cm; quickly, two of them at 20 cm."""
    world = stage("clearing")
    surveys = [(0.05, 3, rays) for rays in RAYS] + [(0.02, 3, 8)] if scale == "full" else [(0.2, 1, 1), (0.2, 1, 2)]
    return [
        Cell(
            world=world,
            corner=CORNERS[world],
            heading=heading,
            spacing=spacing,
            n_spacings=n_spacings,
            supersampling=rays,
        )
        for spacing, n_spacings, rays in surveys
        for heading in HEADINGS
    ]


def spacings(cell: Cell) -> list[float]:
    """Of the finest grid, of every second sample of it, and so on [m]."""
    return [cell.spacing * 2**k for k in range(cell.n_spacings)]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Catchment area of each place by each comparison, at each spacing and success radius."""
    found = surfaces_of(cell, open_world(cell.world), measures_by(NAMES), seed)
    area = [
        [
            [areas(found[name], cell.spacing, radius, every=2**k) for radius in (SUCCESS_CELLS * spacing, WIDE_RADIUS)]
            for k, spacing in enumerate(spacings(cell))
        ]
        for name in NAMES
    ]
    rough = [[roughness(found[name], every=2**k) for k in range(cell.n_spacings)] for name in NAMES]
    return {
        "area": (("comparison", "level", "rule", "reference"), np.array(area, np.float32), {"units": "m2"}),
        "roughness": (("comparison", "level"), np.array(rough)),
    }


def summarise(results: Results) -> Table:
    """Mean area and SD, with a paired test against pixels, and the ratio to the area at the finest spacing."""
    rows = []
    for cell, arrays in results:
        for k, name in enumerate(NAMES):
            for level, spacing in enumerate(spacings(cell)):
                for rule, rule_name in enumerate(RULES):
                    area = arrays["area"][:, level, rule]
                    where = {"world": cell.world, "heading": cell.heading, "comparison": name, "spacing_m": spacing}
                    where |= {"rays_along_a_pixel": cell.supersampling, "success_radius": rule_name}
                    where |= {"roughness": float(arrays["roughness"][k, level])}
                    finest = paired_row(area[k], arrays["area"][k, 0, rule], "finest")
                    rows.append(where | area_row(area[k]) | paired_row(area[k], area[0], "retinotopic") | finest)
    return rows


def draw(results: Results) -> Figure:
    """Mean areas against spacing, a panel for each heading and success radius, a line for each number of rays."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.2), layout="constrained")
    panels = figure.subplots(len(RULES), len(NAMES), sharex=True, sharey=True)
    letters = iter("abcdefgh")
    for row, (axes_of_row, rule_name) in enumerate(zip(panels, RULES, strict=True)):
        for k, (axes, name) in enumerate(zip(axes_of_row, NAMES, strict=True)):
            _draw_lines(axes, results, k, row)
            name_panel(axes, next(letters), COMPARISONS[name].label)
        axes_of_row[0].set_ylabel(f"catchment area (m², of {SIZE**2:g})\nhome within {rule_name}")
    for axes in panels[-1]:
        axes.set_xlabel("spacing of views (cm)")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


RAY_COLOURS = {1: "red", 2: "orange", 4: "blue", 8: "black"}


def _draw_lines(axes: Axes, results: Results, k: int, rule: int) -> None:
    """Means with standard errors, a line for each number of rays; dashed at random headings."""
    for rays in results.by("supersampling"):
        for heading, words in (("aligned", "facing north"), ("random", "random headings")):
            found = {
                spacing: results["area"][index, k, level, rule].astype(float)
                for index in results.where(supersampling=rays, heading=heading)
                for level, spacing in enumerate(spacings(results.cells[index]))
            }
            area = np.array([found[spacing] for spacing in sorted(found)])
            axes.errorbar(
                100.0 * np.array(sorted(found)),
                np.maximum(area.mean(axis=-1), 0.01),
                yerr=area.std(axis=-1, ddof=1) / area.shape[-1] ** 0.5,
                color=COLOURS[RAY_COLOURS[rays]],
                linestyle="-" if heading == "aligned" else (0, (3, 1.5)),
                marker="o" if heading == "aligned" else "s",
                markersize=2.5,
                elinewidth=0.6,
                label=f"{rays} × {rays} rays, {words}",
            )
    axes.set_yscale("log")
    axes.set_ylim(0.01, SIZE**2)
    axes.set_xscale("log", base=2)
    axes.set_xticks([2, 5, 10, 20], ["2", "5", "10", "20"])
    axes.set_xticks([], minor=True)


def caption(results: Results) -> str:
    """What is shown, and of how many places."""
    n = results["area"].shape[-1]
    return (
        f"Catchment areas in a box of {SIZE:g} × {SIZE:g} m (mean and standard error of n = {n} places) against the "
        f"spacing of the views: coarser grids are parts of finer ones. Colours: rays a pixel of 1°. Dashed: random "
        f"headings. Above, a way is home within {SUCCESS_CELLS:g} cells of the place, below within {WIDE_RADIUS:g} m. "
        f"{place_text(results.cells[0].world)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Why aligned pixels do badly, in the thesis's words, and what was measured earlier."""
    return [_verdict(table, value) for value in published.values()]


COLUMNS = {
    "area over that at 5 cm": ("over_finest", "over_finest_standard_error"),
    "mean area (measured earlier)": ("mean_area_m2", "standard_error_m2"),
    "one-sided p of a larger area than retinotopic": ("p_larger_than_retinotopic", ""),
}


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "<what>, <comparison>, <heading>, <spacing> cm, <rays> rays along a pixel"."""
    if stands_in(table[0]["world"]):
        return judge(value, float("nan"), not_comparable=NOT_THE_WORLD)
    what, name, heading, spacing, rays = value.quantity.split(", ")
    wanted = {"comparison": name, "heading": heading, "rays_along_a_pixel": int(rays.split()[0])}
    rows = [row for row in table if wanted.items() <= row.items() and row["success_radius"] == RULES[0]]
    row = next((row for row in rows if spacing == f"{100.0 * row['spacing_m']:g} cm"), None)
    if row is None or (what.startswith("area over") and rows[0]["spacing_m"] != 0.05):
        return judge(value, float("nan"), not_comparable=f"views every {spacing} are surveyed at full scale alone")
    column, error = COLUMNS[what]
    each = "; ".join(f"{other['mean_area_m2']:.3g} m2 at {100.0 * other['spacing_m']:g} cm" for other in rows)
    more = [
        f"{other['mean_area_m2']:.3g} m2 with {other['rays_along_a_pixel']}² rays"
        for other in table
        if {"comparison": name, "heading": heading, "success_radius": RULES[0], "spacing_m": row["spacing_m"]}.items()
        <= other.items()
    ]
    pixels = row["mean_area_m2"] / row["over_retinotopic"]
    why = f"{each}; at {spacing}: {', '.join(more)}; pixels at the same headings, grid and rays: {pixels:.3g} m2"
    return judge(value, row[column], row[error] if error else 0.0, why=why)
