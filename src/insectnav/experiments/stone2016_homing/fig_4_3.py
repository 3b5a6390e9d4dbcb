"""Fig. 4.3: the world from above with the test area, a panoramic view in it, and the same view wrapped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_homing.places import (
    CORNERS,
    NOT_THE_WORLD,
    SIZE,
    open_world,
    place_text,
    reference_places,
    stage,
    stands_in,
)
from insectnav.vision.descriptors import wrap_to_disk
from insectnav.worlds import render_panorama

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 4.3"
TITLE = "the simulated world from above, a panoramic view and the view wrapped"
REFERENCE = 7  # where the view is from: the place of Fig. 4.4
GROUND_HEIGHT = 1e-6  # [m] triangles nowhere above it are ground


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One view of one world."""

    world: str
    corner: float  # [m]
    supersampling: int = 4


def grid(scale: str) -> Sequence[Cell]:
    """The one world at any scale."""
    world = stage("clearing")
    return [Cell(world=world, corner=CORNERS[world])]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Plants as triangles, lowest first, the view from the reference place, and its disk."""
    world = open_world(cell.world)
    corners = np.asarray(world.mesh.vertices, np.float32)
    plants = corners[corners[..., 2].max(axis=1) > GROUND_HEIGHT]
    plants = plants[np.argsort(plants[..., 2].max(axis=1), kind="stable")]
    place = reference_places(cell.corner)[REFERENCE]
    view = render_panorama(world, place[None], 0.0, supersampling=cell.supersampling)[0]
    apart = np.hypot(*np.moveaxis(plants[..., :2].reshape(-1, 2) - (cell.corner + SIZE / 2.0), -1, 0))
    return {
        "plant": (("triangle", "vertex", "xyz"), plants, {"units": "m"}),
        "view": (("row", "column"), view),
        "disk": (("disk_row", "disk_column"), wrap_to_disk(view)),
        "nearest_plant": ((), np.float32(apart.min()), {"units": "m", "long_name": "from the middle of the test area"}),
    }


def summarise(results: Results) -> Table:
    """Size of world and view."""
    rows = []
    for cell, arrays in results:
        plants, view = arrays["plant"], arrays["view"]
        x, y, _ = np.ptp(plants.reshape(-1, 3), axis=0)
        inside = (np.abs(plants[..., :2] - (cell.corner + SIZE / 2.0)) < SIZE / 2.0).all(axis=-1).any()
        rows.append(
            {
                "world": cell.world,
                "triangles_of_plants": len(plants),
                "extent_x_m": float(x),
                "extent_y_m": float(y),
                "highest_m": float(plants[..., 2].max()),
                "plants_in_test_area": bool(inside),
                "nearest_plant_to_its_middle_m": float(arrays["nearest_plant"]),
                "view_rows": view.shape[0],
                "view_columns": view.shape[1],
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """The map on the left, the view and its disk on the right."""
    from matplotlib.figure import Figure

    (cell,) = results.cells
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.5), layout="constrained")
    spec = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.0), height_ratios=(1.0, 2.4))
    _draw_map(figure.add_subplot(spec[:, 0]), results["plant"][0], cell.corner)
    axes = figure.add_subplot(spec[0, 1])
    axes.imshow(results["view"][0], cmap="gray", vmin=0.0, vmax=1.0, extent=(-180, 180, -15, 90), aspect="equal")
    axes.set(xticks=range(-180, 181, 90), yticks=(0, 45, 90), xlabel="azimuth (deg)", ylabel="elevation (deg)")
    name_panel(axes, "b", "panoramic view, facing north")
    axes = figure.add_subplot(spec[1, 1])
    disk = results["disk"][0]
    axes.imshow(disk, cmap="gray", vmin=0.0, vmax=1.0, extent=(-1, 1, -1, 1), clip_path=_circle(axes), clip_on=True)
    for x, y, word in ((0.0, 0.55, "N"), (0.55, 0.0, "E"), (0.0, -0.55, "S"), (-0.55, 0.0, "W")):
        axes.text(x, y, word, ha="center", va="center", fontsize=6.0, color=COLOURS["blue"])
    axes.set_axis_off()
    name_panel(axes, "c", "the view wrapped")
    return figure


def _circle(axes: Axes) -> object:
    from matplotlib.patches import Circle

    return Circle((0.0, 0.0), 1.0, transform=axes.transData)


def _draw_map(axes: Axes, plants: np.ndarray, corner: float) -> None:
    """Plants darker the higher they are, the test area, its references and the place of the view."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Rectangle

    height = plants[..., 2].max(axis=1)
    shapes = PolyCollection(
        list(plants[..., :2]), array=height, cmap="Greens", rasterized=True, linewidths=0.5, edgecolors="face"
    )
    shapes.set_clim(-0.8 * height.max(), height.max())
    axes.add_collection(shapes)
    axes.add_patch(Rectangle((corner, corner), SIZE, SIZE, facecolor=COLOURS["orange"], alpha=0.35, zorder=0.5))
    places = reference_places(corner)
    axes.plot(*places.T, ".", color=COLOURS["red"], markersize=1.8, markeredgewidth=0.0)
    axes.plot(*places[REFERENCE], "+", color=COLOURS["blue"], markersize=6.0, markeredgewidth=1.2)
    low, high = plants[..., :2].reshape(-1, 2).min(axis=0), plants[..., :2].reshape(-1, 2).max(axis=0)
    axes.set_xlim(low[0] - 1.0, high[0] + 1.0)
    axes.set_ylim(low[1] - 1.0, high[1] + 1.0)
    axes.set_aspect("equal")
    axes.set(xlabel="x (m)", ylabel="y (m)")
    bar = axes.figure.colorbar(shapes, ax=axes, orientation="horizontal", shrink=0.7, boundaries=None, pad=0.02)
    bar.ax.set_xlim(0.0, height.max())
    bar.set_label("height of a plant (m)")
    bar.outline.set_linewidth(0.6)
    name_panel(axes, "a", "the world from above, north up")


def caption(results: Results) -> str:
    """What is shown."""
    (cell,) = results.cells
    return (
        f"a, The world from above with the test area of {SIZE:g} × {SIZE:g} m (orange), the twenty reference places "
        "(dots) and the place of the view (cross). b, The view from there at 0.01 m above the ground, 360 × 105 pixels "
        f"of 1°, {cell.supersampling}² rays a pixel. c, The same wrapped: the zenith in the middle, the lower edge of "
        f"the view at the rim. {place_text(cell.world)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What the text says of world and view."""
    row = table[0]
    ours = {
        "columns of the view over its degrees": row["view_columns"] / 360.0,
        "plants inside the test area": float(row["plants_in_test_area"]),
    }
    return [
        judge(value, float("nan"), not_comparable=NOT_THE_WORLD)
        if stands_in(row["world"])
        else judge(value, ours[value.quantity], why=f"the view has {row['view_columns']} columns")
        for value in published.values()
    ]
