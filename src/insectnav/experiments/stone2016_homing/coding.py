"""How catchment areas depend on the code: order and weights of Zernike functions, degrees of harmonics, frequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_homing.area_table import area_row, paired_row
from insectnav.experiments.stone2016_homing.comparisons import order_amplitudes
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
from insectnav.vision.descriptors import (
    frequency_strip,
    harmonic_amplitudes,
    zernike_amplitudes,
    zernike_pairs,
    zernike_weights,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "text"
TITLE = "catchment area against order and weights of the frequency code"
ORDERS = (2, 4, 8, 16, 32)  # highest n, l or number of cycles
FAMILIES = {  # name → what a figure calls it and its colour
    "zernike-stone": ("Zernike, weights n + 1", "blue"),
    "zernike-orthonormal": ("Zernike, weights sqrt(n + 1)", "sky"),
    "zernike-raw": ("Zernike, weights 1", "purple"),
    "harmonic-orders": ("harmonics, each l and |m|", "green"),
    "harmonic-degrees": ("harmonics, each l", "yellow"),
    "frequency-strip": ("horizon strip", "red"),
}
CODES = (("retinotopic", 0), *((family, order) for family in FAMILIES for order in ORDERS))


@dataclass(frozen=True, kw_only=True)
class Cell:
    """The box on one grid, at one kind of heading."""

    world: str
    corner: float  # [m]
    heading: str
    spacing: float  # [m]
    supersampling: int = 4


def grid(scale: str) -> Sequence[Cell]:
    """Both headings on grids of 10 and 5 cm; quickly, one of 20 cm."""
    world = stage("clearing")
    spacings, rays = ((0.1, 0.05), 4) if scale == "full" else ((0.2,), 2)
    return [
        Cell(world=world, corner=CORNERS[world], heading=heading, spacing=spacing, supersampling=rays)
        for spacing in spacings
        for heading in HEADINGS
    ]


def family_features(views: ArrayLike) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """Features of each family up to the highest order, and the order of each of them."""
    most = ORDERS[-1]
    raw = zernike_amplitudes(views, most, weights="raw")
    n = zernike_pairs(most)[0]
    found: dict[str, tuple[NDArray[Any], NDArray[Any]]] = {
        f"zernike-{kind}": (raw * zernike_weights(most, kind), n) for kind in ("stone", "orthonormal", "raw")
    }
    degree = np.concatenate([np.full(each + 1, each) for each in range(most + 1)])
    found["harmonic-orders"] = (order_amplitudes(views, most + 1), degree)
    found["harmonic-degrees"] = (harmonic_amplitudes(views, most + 1), np.arange(most + 1))
    found["frequency-strip"] = (frequency_strip(views, most), np.arange(most + 1))
    return found


class CodeDistances:
    """A measure for `survey`: distances by all codes, (n, code, remembered), from expansions that are made once.

    Parameters
    ----------
    remembered : (remembered, rows, columns) array
    """

    def __init__(self, remembered: ArrayLike) -> None:
        self._remembered = family_features(remembered)

    def __call__(self, views: ArrayLike) -> NDArray[Any]:
        """Distances of views (n, rows, columns)."""
        rows = []
        for family, (values, order) in family_features(views).items():
            squares = (values[:, None] - self._remembered[family][0]) ** 2
            total = np.cumsum(squares, axis=-1)  # features stand in ascending order
            last = np.searchsorted(order, ORDERS, side="right") - 1
            rows.append(np.sqrt(total[..., last]))
        return np.moveaxis(np.concatenate(rows, axis=-1), -1, 1)


def simulate(cell: Cell, seed: int) -> Arrays:
    """Catchment area of each place by each code."""
    found = surfaces_of(cell, open_world(cell.world), {"retinotopic": "aligned"}, seed, measure=CodeDistances)
    by_code = [found["retinotopic"], *np.moveaxis(found["measure"], -1, 0)]
    area = [areas(surface, cell.spacing, SUCCESS_CELLS * cell.spacing) for surface in by_code]
    return {
        "area": (("code", "reference"), np.array(area, np.float32), {"units": "m2"}),
        "roughness": (("code",), np.array([roughness(surface) for surface in by_code])),
    }


def summarise(results: Results) -> Table:
    """Mean area and SD of each code, with paired tests against pixels and against the highest order of its family."""
    rows = []
    for cell, arrays in results:
        for k, (family, order) in enumerate(CODES):
            highest = CODES.index((family, ORDERS[-1])) if order else 0
            where = {"world": cell.world, "heading": cell.heading, "spacing_m": cell.spacing}
            where |= {"family": family, "order": order}
            area = arrays["area"]
            rows.append(
                where
                | area_row(area[k])
                | {"roughness": float(arrays["roughness"][k])}
                | paired_row(area[k], area[0], "retinotopic")
                | paired_row(area[k], area[highest], "highest_order")
            )
    return rows


def draw(results: Results) -> Figure:
    """Mean area against order, a line for each family, a panel for each grid and heading."""
    from matplotlib.figure import Figure

    n_rows = len(results.by("spacing"))
    figure = Figure(figsize=(DOUBLE_COLUMN, 0.5 + 2.2 * n_rows), layout="constrained")
    panels = figure.subplots(n_rows, 2, sharex=True, sharey=True, squeeze=False)
    for letter, axes, (cell, arrays) in zip("abcd", panels.ravel(), results, strict=False):
        _draw_orders(axes, arrays["area"].astype(float))
        words = "facing north" if cell.heading == "aligned" else "random headings"
        name_panel(axes, letter, f"views every {100.0 * cell.spacing:g} cm, {words}")
    for axes in panels[-1]:
        axes.set_xlabel("highest order (n, l or cycles)")
    for axes in panels[:, 0]:
        axes.set_ylabel(f"catchment area (m², of {SIZE**2:g})")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_orders(axes: Axes, area: np.ndarray) -> None:
    """Means with standard errors, side by side; the line is that of pixels."""
    error = area.std(axis=-1, ddof=1) / area.shape[-1] ** 0.5
    mean = area.mean(axis=-1)
    axes.axhline(mean[0], color=COLOURS["orange"], linewidth=1.0, label="retinotopic")
    axes.axhspan(mean[0] - error[0], mean[0] + error[0], color=COLOURS["orange"], alpha=0.25, linewidth=0.0)
    for shift, (family, (label, colour)) in enumerate(FAMILIES.items()):
        places = [CODES.index((family, order)) for order in ORDERS]
        x = np.arange(len(ORDERS)) + 0.06 * (shift - 2.5)
        axes.errorbar(
            x, mean[places], yerr=error[places], fmt="o-", color=COLOURS[colour], markersize=2.5, elinewidth=0.6,
            label=label,
        )  # fmt: skip
    axes.set_xticks(range(len(ORDERS)), [f"{order}" for order in ORDERS])
    axes.set_yscale("log")
    axes.set_ylim(0.01, SIZE**2)


def caption(results: Results) -> str:
    """What is shown, and of how many places."""
    n = results["area"].shape[-1]
    return (
        f"Catchment areas in a box of {SIZE:g} × {SIZE:g} m (mean and standard error of n = {n} places) by amplitudes "
        "up to an order: of Zernike functions with three weights, of spherical harmonics for each degree l and order "
        "|m| or for each degree alone, and of the frequencies of a strip of ±15° about the horizon. Orange: pixel by "
        f"pixel. Success within {SUCCESS_CELLS:g} cells. {place_text(results.cells[0].world)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Whether low frequencies reach farther than high ones, as section 4.3 says of a robot's strip."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "area up to order <n> over that up to order 32, <family>, <heading>, <spacing> cm"."""
    if stands_in(table[0]["world"]):
        return judge(value, float("nan"), not_comparable=NOT_THE_WORLD)
    what, family, heading, spacing = value.quantity.split(", ")
    rows = [
        row
        for row in table
        if row["family"] == family and row["heading"] == heading and spacing == f"{100.0 * row['spacing_m']:g} cm"
    ]
    row = next((row for row in rows if row["order"] == int(what.split()[4])), None)
    if row is None:
        return judge(value, float("nan"), not_comparable=f"views every {spacing} are surveyed at full scale alone")
    each = ", ".join(
        f"{other['mean_area_m2']:.3g} m2 ({other['roughness']:.2f}) up to {other['order']}" for other in rows
    )
    why = f"areas, and in brackets the roughness of the surfaces (noise has 1.73): {each}: the rougher, the smaller"
    return judge(value, row["over_highest_order"], row["over_highest_order_standard_error"], why=why)
