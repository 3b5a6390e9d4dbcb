"""How catchment areas depend on the world: where in the clearing, in the Seville clutter, and in built worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.datasets.known_worlds import find_world
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_homing.area_table import area_row, paired_row
from insectnav.experiments.stone2016_homing.comparisons import COMPARISONS, measures_by
from insectnav.experiments.stone2016_homing.places import (
    HEADINGS,
    SIZE,
    STAND_IN,
    SUCCESS_CELLS,
    areas,
    open_world,
    stands_in,
    surfaces_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "text"
TITLE = "catchment area by world: clearing, clutter, and built worlds in between"
NAMES = ("retinotopic", "zernike", "zernike-orthonormal", "harmonic-orders", "compass")
CLEARINGS = (12.0, 3.0, 1.0)  # [m] radius without plants, of built worlds
N_WORLDS = 2  # built ones of each radius
PLACES = {  # what was published: world and corner of the box [m]
    "clearing, quadrant": ("clearing", 0.0),
    "clearing, middle": ("clearing", -5.0),
    "Seville": ("seville", 0.0),
}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One world, at one kind of heading."""

    label: str
    world: str
    corner: float  # [m]
    clearing: float  # [m] of a built world; 0 of a published one
    world_seed: int
    heading: str
    spacing: float  # [m]
    supersampling: int = 4


def grid(scale: str) -> Sequence[Cell]:
    """Published worlds that are there, and built ones; quickly, one of each kind on a coarse grid."""
    spacing, radii, n_worlds, rays = (0.1, CLEARINGS, N_WORLDS, 4) if scale == "full" else (0.2, (12.0,), 1, 2)
    places: list[dict[str, Any]] = [
        {"label": label, "world": world, "corner": corner, "clearing": 0.0, "world_seed": 0}
        for label, (world, corner) in PLACES.items()
        if find_world(world) is not None
    ]
    places += [
        {"label": f"built, {radius:g} m", "world": STAND_IN, "corner": -5.0, "clearing": radius, "world_seed": seed}
        for radius in radii
        for seed in range(n_worlds)
    ]
    if scale != "full":
        places = [place for place in places if place["world"] != "clearing"]
    return [
        Cell(**place, heading=heading, spacing=spacing, supersampling=rays) for place in places for heading in HEADINGS
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Catchment area of each place by each comparison, in one world."""
    changes = {"clearing": cell.clearing} if stands_in(cell.world) else {}
    world = open_world(cell.world, cell.world_seed, **changes)
    found = surfaces_of(cell, world, measures_by(NAMES), seed)
    area = [areas(found[name], cell.spacing, SUCCESS_CELLS * cell.spacing) for name in NAMES]
    return {"area": (("comparison", "reference"), np.array(area, np.float32), {"units": "m2"})}


def grouped(results: Results) -> dict[tuple[str, str], np.ndarray]:
    """Areas by kind of world and heading, (comparison, world × reference)."""
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for cell, arrays in results:
        found.setdefault((cell.label, cell.heading), []).append(arrays["area"])
    return {key: np.concatenate(parts, axis=-1) for key, parts in found.items()}


def summarise(results: Results) -> Table:
    """Mean area of each comparison in each kind of world, with paired tests against pixels."""
    rows = []
    for (label, heading), area in grouped(results).items():
        for k, name in enumerate(NAMES):
            where = {"world": label, "heading": heading, "comparison": name, "spacing_m": results.cells[0].spacing}
            rows.append(where | area_row(area[k]) | paired_row(area[k], area[0], "retinotopic"))
    return rows


def draw(results: Results) -> Figure:
    """A panel for each heading: mean area by kind of world, a mark for each comparison."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 3.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    areas_by = grouped(results)
    for letter, axes, heading in zip("ab", panels, HEADINGS, strict=True):
        _draw_worlds(axes, {label: area for (label, turned), area in areas_by.items() if turned == heading})
        name_panel(axes, letter, "facing north" if heading == "aligned" else "random headings")
    panels[0].set_ylabel(f"catchment area (m², of {SIZE**2:g})")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _draw_worlds(axes: Axes, areas_by: Mapping[str, np.ndarray]) -> None:
    """Means with standard errors, one comparison beside the other."""
    for k, name in enumerate(NAMES):
        values = [area[k].astype(float) for area in areas_by.values()]
        mean = np.array([each.mean() for each in values])
        error = np.array([each.std(ddof=1) / each.size**0.5 for each in values])
        axes.errorbar(
            np.arange(len(values)) + 0.13 * (k - (len(NAMES) - 1) / 2.0),
            mean,
            yerr=error,
            fmt="o",
            color=COLOURS[COMPARISONS[name].colour],
            markersize=3.5,
            elinewidth=0.7,
            label=COMPARISONS[name].label.replace("\n", " "),
        )
    axes.set_yscale("log")
    axes.set_ylim(0.02, SIZE**2)
    axes.set_xticks(range(len(areas_by)), [label.replace(", ", ",\n") for label in areas_by])


def caption(results: Results) -> str:
    """What is shown, and of how many places."""
    n_worlds = len(results.by("world_seed"))
    known = any(not stands_in(cell.world) for cell in results.cells)
    missing = "" if known else " The meshes of published worlds are not part of insectnav and were not found."
    return (
        f"Catchment areas in a box of {SIZE:g} × {SIZE:g} m, views every {100.0 * results.cells[0].spacing:g} cm, "
        f"success within {SUCCESS_CELLS:g} cells: mean and standard error of n = 20 places in each published world and "
        f"in each of {n_worlds} built ant-worlds, whose clearings have the radius given.{missing}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What was measured earlier in the Seville clutter, and what the thesis says of open ground."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "mean area (measured earlier), <comparison>, <heading>, <world>, 10 cm"."""
    _, name, heading, world, spacing = value.quantity.split(", ")
    wanted = {"comparison": name, "heading": heading, "world": world}
    row = next((row for row in table if wanted.items() <= row.items()), None)
    if row is None:
        return judge(
            value, float("nan"), not_comparable=f"the mesh of {world} is not part of insectnav and was not found"
        )
    if spacing != f"{100.0 * row['spacing_m']:g} cm":
        return judge(value, float("nan"), not_comparable=f"views every {spacing} are surveyed at full scale alone")
    why = f"areas from {row['least_m2']:.2f} to {row['largest_m2']:.2f} m2, median {row['median_m2']:.2f}"
    return judge(value, row["mean_area_m2"], row["standard_error_m2"], why=why)
