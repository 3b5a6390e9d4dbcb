"""Fig. 4.4: how far views are from a remembered one, over the box, and from where the slope leads home."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_homing.comparisons import THESIS, measures_by
from insectnav.experiments.stone2016_homing.places import (
    CORNERS,
    HEADINGS,
    NOT_THE_WORLD,
    SIZE,
    SUCCESS_CELLS,
    open_world,
    place_text,
    reference_places,
    stage,
    stands_in,
    surfaces,
)
from insectnav.homing import catchment_area

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

FIGURE = "Fig. 4.4"
TITLE = "surfaces of distance from a remembered view, with catchment areas"
REFERENCE = 7  # of twenty, in the middle of the second row; which one the thesis shows is not told
TITLES = {
    ("retinotopic", "aligned"): "retinotopic,\naligned",
    ("retinotopic", "random"): "retinotopic,\nrandom headings",
    ("zernike", "aligned"): "frequency,\naligned",
    ("zernike", "random"): "frequency,\nrandom headings",
}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """The box on one grid."""

    world: str
    corner: float  # [m]
    spacing: float  # [m]
    supersampling: int = 4


def grid(scale: str) -> Sequence[Cell]:
    """The thesis's grid of 2 cm, and that of the 2018 code; quickly, one of 20 cm."""
    world = stage("clearing")
    spacings, rays = ((0.02, 0.1), 4) if scale == "full" else ((0.2,), 2)
    return [Cell(world=world, corner=CORNERS[world], spacing=spacing, supersampling=rays) for spacing in spacings]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Four surfaces and where their slope leads home, on a raster of one size for all grids."""
    place = reference_places(cell.corner)[REFERENCE]
    world = open_world(cell.world)
    pictures, inside, area = [], [], []
    settings: dict[str, Any] = {"seed": seed, "supersampling": cell.supersampling, "places": place[None]}
    found = {
        heading: surfaces(world, cell.corner, cell.spacing, heading, measures_by(THESIS), **settings)
        for heading in HEADINGS
    }
    for name, heading in TITLES:
        surface = found[heading][name][0]
        caught = catchment_area(surface, cell.spacing, place - cell.corner, SUCCESS_CELLS * cell.spacing)
        pictures.append(on_raster(surface))
        inside.append(on_raster(caught.is_inside))
        area.append(caught.area)
    return {
        "distance": (("surface", "y", "x"), np.array(pictures, np.float32)),
        "is_inside": (("surface", "y", "x"), np.array(inside)),
        "area": (("surface",), np.array(area, np.float32), {"units": "m2"}),
    }


N_RASTER = 500  # dots along a side: the cells of the finest grid


def on_raster(values: np.ndarray) -> np.ndarray:
    """Values of samples or cells (n, n) on a raster of the box, (500, 500): for each dot, the nearest."""
    nearest = np.minimum(((np.arange(N_RASTER) + 0.5) * len(values) / N_RASTER).astype(int), len(values) - 1)
    return values[np.ix_(nearest, nearest)]


def summarise(results: Results) -> Table:
    """Catchment area of each surface."""
    return [
        {
            "world": cell.world,
            "spacing_m": cell.spacing,
            "comparison": name,
            "heading": heading,
            "area_m2": float(area),
        }
        for cell, arrays in results
        for (name, heading), area in zip(TITLES, arrays["area"], strict=True)
    ]


def draw(results: Results) -> Figure:
    """A row for each grid, a panel for each surface."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 0.25 + 2.15 * len(results.cells)), layout="constrained")
    panels = figure.subplots(len(results.cells), 4, sharex=True, sharey=True, squeeze=False)
    letters = iter("abcdefgh")
    for row, (cell, arrays) in zip(panels, results, strict=True):
        for k, (axes, title) in enumerate(zip(row, TITLES.values(), strict=True)):
            image = _draw_surface(axes, arrays["distance"][k], arrays["is_inside"][k], cell.corner)
            area = float(arrays["area"][k])
            name_panel(axes, next(letters), f"{title}\n{100.0 * cell.spacing:g} cm: {area:.3g} m²")
        bar = figure.colorbar(image, ax=list(row), shrink=0.8, pad=0.01)
        bar.set_label("distance from the remembered\nview (share of the largest)")
        bar.outline.set_linewidth(0.6)
    for axes in panels[-1]:
        axes.set_xlabel("x (m)")
    for axes in panels[:, 0]:
        axes.set_ylabel("y (m)")
    return figure


def _draw_surface(axes: Axes, distance: np.ndarray, is_inside: np.ndarray, corner: float) -> AxesImage:
    """One surface in grey, the border of its catchment area in blue, and the remembered place."""
    sides = (corner, corner + SIZE)
    image = axes.imshow(
        distance / distance.max(), origin="lower", extent=(*sides, *sides), cmap="gray", vmin=0.0, vmax=1.0
    )
    middle = corner + (np.arange(N_RASTER) + 0.5) * SIZE / N_RASTER
    axes.contour(middle, middle, is_inside, [0.5], colors=COLOURS["sky"], linewidths=0.9)
    axes.plot(*reference_places(corner)[REFERENCE], "+", color=COLOURS["red"], markersize=5.0, markeredgewidth=1.0)
    axes.set_xticks(np.linspace(*sides, 3))
    axes.set_yticks(np.linspace(*sides, 3))
    return image


def caption(results: Results) -> str:
    """What is shown."""
    cell = results.cells[0]
    grids = ", ".join(f"{100.0 * each.spacing:g} cm" for each in results.cells)
    return (
        f"Distance of views from the one remembered at the cross, facing north, in a box of {SIZE:g} × {SIZE:g} m, by "
        f"the root mean square of pixel differences (retinotopic) and by Zernike amplitudes up to n = 16 (frequency). "
        "Views face north (aligned) or each its own way (random headings). Rows: spacing of the views "
        f"({grids}). Blue: border of the catchment area, from where steepest descent ends within {SUCCESS_CELLS:g} "
        f"cells of the cross. {cell.supersampling}² rays a pixel of 1°. {place_text(cell.world)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What the four panels show: which comparison reaches farther at which heading."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "frequency over retinotopic area, <heading>, <spacing> cm" or "retinotopic area, …"."""
    if stands_in(table[0]["world"]):
        return judge(value, float("nan"), not_comparable=NOT_THE_WORLD)
    what, heading, spacing = value.quantity.split(", ")
    area = {
        row["comparison"]: row["area_m2"]
        for row in table
        if row["heading"] == heading and spacing == f"{100.0 * row['spacing_m']:g} cm"
    }
    if not area:
        return judge(value, float("nan"), not_comparable=f"views every {spacing} are surveyed at full scale alone")
    ours = area["retinotopic"] if what == "retinotopic area" else area["zernike"] / max(area["retinotopic"], 1e-9)
    why = (
        f"at this place, with views every {spacing}, the areas are {area['retinotopic']:.3g} m2 (retinotopic) and "
        f"{area['zernike']:.3g} m2 (frequency); over twenty places see stone2016-fig-4-5"
    )
    return judge(value, ours, why=why)
