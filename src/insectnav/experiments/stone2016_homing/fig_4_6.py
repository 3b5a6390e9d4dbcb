"""Fig. 4.6: two aligned views 3.6 m apart: pixels fall apart, Zernike amplitudes stay alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from insectnav.angles import unit_vector
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_homing.comparisons import ROWS_ABOVE
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
from insectnav.metrics.statistics import bootstrap_error
from insectnav.vision.descriptors import zernike_amplitudes, zernike_pairs
from insectnav.worlds import render_layers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

FIGURE = "Fig. 4.6"
TITLE = "two aligned views 3.6 m apart, their difference and their amplitudes"
DISPLACEMENT = 3.6  # [m] Fig. 4.6b
N_COEFFICIENTS = 50  # Fig. 4.6d
DIRECTIONS = np.arange(8) * np.pi / 4.0  # [rad] in which all references are left
DRAWN = (7, 2)  # reference and direction of the pair that is drawn: eastwards from the place of Fig. 4.4
MEASURES = ("misaligned", "pixels_apart", "amplitudes_apart", "correlation", "correlation_of_detail")


@dataclass(frozen=True, kw_only=True)
class Cell:
    """All pairs of views in one world."""

    world: str
    corner: float  # [m]
    supersampling: int = 4


def grid(scale: str) -> Sequence[Cell]:
    """The one world at any scale."""
    world = stage("clearing")
    return [Cell(world=world, corner=CORNERS[world])]


def pair_places(corner: float) -> np.ndarray:
    """Both places of each pair whose second is in the box, too, (pair, 2, xy) [m]; the drawn pair comes first."""
    first = np.repeat(reference_places(0.0), len(DIRECTIONS), axis=0)
    second = first + DISPLACEMENT * np.tile(unit_vector(DIRECTIONS), (len(first) // len(DIRECTIONS), 1))
    drawn = DRAWN[0] * len(DIRECTIONS) + DRAWN[1]
    order = np.r_[drawn, np.delete(np.arange(len(first)), drawn)]
    pairs = np.stack([first, second], axis=1)[order]
    return np.asarray(pairs[((pairs >= 0.0) & (pairs <= SIZE)).all(axis=(1, 2))] + corner)


def simulate(cell: Cell, seed: int) -> Arrays:
    """Views, amplitudes of the drawn pair, and what is alike and what not in all pairs."""
    pairs = pair_places(cell.corner)
    layers = render_layers(
        open_world(cell.world), pairs.reshape(-1, 2), 0.0, ("grey", "alpha"), supersampling=cell.supersampling
    )
    views = layers["grey"].reshape(len(pairs), 2, *layers["grey"].shape[1:])
    plants = layers["alpha"].reshape(views.shape)[:, :, :ROWS_ABOVE]
    amplitudes = normalised(zernike_amplitudes(views))
    found = np.stack([pair_measures(*each) for each in zip(views, plants, amplitudes, strict=True)])
    return {
        "view": (("which", "row", "column"), views[0]),
        "amplitude": (("which", "coefficient"), amplitudes[0]),
        "measure": (("pair", "measure"), found),
    }


def normalised(amplitudes: np.ndarray) -> np.ndarray:
    """The first 50 amplitudes over the length of their vector, (..., 50)."""
    first = amplitudes[..., :N_COEFFICIENTS]
    return np.asarray(first / np.linalg.norm(first, axis=-1, keepdims=True))


def pair_measures(views: np.ndarray, plants: np.ndarray, amplitudes: np.ndarray) -> np.ndarray:
    """What `MEASURES` names, of two views, their plants above the horizon and their normalised amplitudes.

    Misaligned is the share of pixels with a plant in either view that have none in the other. Apart is the distance of
    two vectors over the length of the first. Detail is what changes with the azimuth: amplitudes with m > 0.
    """
    first, second = plants > 0.5
    either, both = (first | second).sum(), (first & second).sum()
    detail = zernike_pairs(16)[1][:N_COEFFICIENTS] > 0
    return np.array(
        [
            1.0 - both / either,
            np.linalg.norm(views[0] - views[1]) / np.linalg.norm(views[0]),
            np.linalg.norm(amplitudes[0] - amplitudes[1]) / np.linalg.norm(amplitudes[0]),
            np.corrcoef(amplitudes)[0, 1],
            np.corrcoef(amplitudes[:, detail])[0, 1],
        ]
    )


def summarise(results: Results) -> Table:
    """Each measure of the drawn pair, and its mean over all pairs."""
    rows = []
    for cell, arrays in results:
        for k, name in enumerate(MEASURES):
            values = arrays["measure"][:, k]
            rows.append(
                {
                    "world": cell.world,
                    "measure": name,
                    "drawn_pair": float(values[0]),
                    "mean": float(values.mean()),
                    "standard_error": bootstrap_error(values, np.mean),
                    "least": float(values.min()),
                    "largest": float(values.max()),
                    "n": len(values),
                }
            )
    return rows


def draw(results: Results) -> Figure:
    """Both views, their difference, and the amplitudes of both."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 3.5), layout="constrained")
    panels = figure.subplots(2, 2)
    views = results["view"][0]
    _draw_view(panels[0, 0], views[0], "gray", 1.0)
    name_panel(panels[0, 0], "a", "facing north")
    _draw_view(panels[0, 1], views[1], "gray", 1.0)
    name_panel(panels[0, 1], "b", f"facing north, {DISPLACEMENT:g} m to the east")
    reds = LinearSegmentedColormap.from_list("difference", ["white", COLOURS["red"], "#7A0000"])
    image = _draw_view(panels[1, 0], np.abs(views[0] - views[1]), reds, 1.0)
    bar = figure.colorbar(image, ax=panels[1, 0], orientation="horizontal", shrink=0.6, pad=0.02, aspect=30)
    bar.set_label("absolute difference")
    bar.outline.set_linewidth(0.6)
    name_panel(panels[1, 0], "c", "difference")
    _draw_amplitudes(panels[1, 1], results["amplitude"][0])
    name_panel(panels[1, 1], "d", "Zernike amplitudes")
    return figure


def _draw_view(axes: Axes, values: np.ndarray, colours: str | Colormap, largest: float) -> AxesImage:
    image = axes.imshow(values, cmap=colours, vmin=0.0, vmax=largest, extent=(-180, 180, -15, 90))
    axes.set(xticks=range(-180, 181, 90), yticks=(0, 45, 90), xlabel="azimuth (deg)", ylabel="elevation (deg)")
    return image


def _draw_amplitudes(axes: Axes, amplitudes: np.ndarray) -> None:
    """Amplitudes of both views, in the order of the pairs n, m, on a scale of factors."""
    place = np.arange(1, N_COEFFICIENTS + 1)
    axes.plot(place, amplitudes[0], "o-", color=COLOURS["blue"], markersize=2.5, linewidth=0.6, label="view a")
    axes.plot(place, amplitudes[1], "s-", color=COLOURS["orange"], markersize=2.5, linewidth=0.6, label="view b")
    axes.set_yscale("log")
    axes.set_xlim(0.0, N_COEFFICIENTS + 1.0)
    axes.set(xlabel="coefficient (n, m in order)", ylabel="normalised amplitude")
    axes.legend(loc="upper right")


def caption(results: Results) -> str:
    """What is shown, and of how many pairs."""
    (cell,) = results.cells
    n = results["measure"].shape[1]
    return (
        f"a, b, Views from two places {DISPLACEMENT:g} m apart, both facing north; the first is that of Fig. 4.4. c, "
        f"Absolute difference of their pixels. d, First {N_COEFFICIENTS} Zernike amplitudes of both (stone weights), "
        f"divided by the length of their vector. The table tells what is alike in n = {n} such pairs: from the twenty "
        f"references in {len(DIRECTIONS)} directions, where the second place is in the box, too. "
        f"{cell.supersampling}² rays a pixel of 1°. {place_text(cell.world)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Whether most of the skyline misaligns, and whether amplitudes remain alike."""
    return [_verdict(table, value) for value in published.values()]


QUANTITIES = {
    "share of plant pixels that misalign": "misaligned",
    "correlation of the first 50 normalised amplitudes": "correlation",
    "correlation of those of the first 50 with m > 0": "correlation_of_detail",
}


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "<measure>, drawn pair" or "<measure>, all pairs"."""
    if stands_in(table[0]["world"]):
        return judge(value, float("nan"), not_comparable=NOT_THE_WORLD)
    what, _, which = value.quantity.partition(", ")
    by_name = {row["measure"]: row for row in table}
    row = by_name[QUANTITIES[what]]
    pixels, amplitudes = by_name["pixels_apart"], by_name["amplitudes_apart"]
    why = (
        f"from {row['least']:.2f} to {row['largest']:.2f} in {row['n']} pairs; pixels are {pixels['mean']:.2f} of "
        f"their length apart, amplitudes {amplitudes['mean']:.2f}"
    )
    if which == "drawn pair":
        return judge(value, row["drawn_pair"], why=why)
    return judge(value, row["mean"], row["standard_error"], why=why)
