"""Fig. 4.1: the outline of a sky, its coordinates, their frequencies, and the sky redrawn from ten of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.recordings.files import N_SKIES
from insectnav.experiments.stone2016_places.one_sky import (
    NUMBER,
    PHOTOGRAPH,
    RENDERED,
    one_sky,
    sky_text,
    source,
)
from insectnav.vision.descriptors import contour_amplitudes, contour_coefficients, redraw_contour, sky_contour
from insectnav.vision.descriptors.sky_region import middle_region

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 4.1"
TITLE = "the outline of a sky as a signal, its frequencies, and the sky redrawn from ten of them"
N_CORNERS, N_FREQUENCIES, N_POINTS = 5000, 100, 2000
TEN = 10  # coefficients 0, 1, −1, 2, −2 … 5
COEFFICIENTS = (3, 5, TEN, 2 * TEN + 1, 65, 2 * N_FREQUENCIES + 1)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One sky.

    Parameters
    ----------
    sky : "photograph" or "rendered"
    number : of the photograph along its walk
    """

    sky: str
    number: int


def grid(scale: str) -> Sequence[Cell]:
    """The sky that is drawn, then all others of the walk, or every eighth; of rendered skies there is one."""
    if source() == RENDERED:
        return [Cell(sky=RENDERED, number=NUMBER)]
    others = [number for number in range(0, N_SKIES, 1 if scale == "full" else 8) if number != NUMBER]
    return [Cell(sky=PHOTOGRAPH, number=number) for number in (NUMBER, *others)]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Mask, outline, coefficients, overlap of the redrawn sky with it, and what a turn changes."""
    mask = one_sky(cell.sky, cell.number)
    contour = sky_contour(mask)
    outline = np.full(N_CORNERS, np.nan, complex)
    outline[: len(contour)] = contour
    coefficients = contour_coefficients(contour, N_FREQUENCIES)
    region = middle_region(mask)
    overlap = [_overlap(region, coefficients[:n]) for n in COEFFICIENTS]
    amplitudes = contour_amplitudes(mask)
    change = np.abs(contour_amplitudes(np.rot90(mask)) - amplitudes).max() / amplitudes.max()
    return {
        "mask": (("row", "column"), mask),
        "outline": (("corner", "xy"), _pairs(outline), {"units": "half the picture"}),
        "coefficient": (("order", "xy"), _pairs(coefficients), {"frequencies": "0, 1, -1, 2, -2, ..."}),
        "overlap": (("n_coefficients",), np.array(overlap), {"n_coefficients": COEFFICIENTS}),
        "change_by_quarter_turn": ((), np.float64(change), {"units": "largest amplitude"}),
    }


def _pairs(values: NDArray[Any]) -> NDArray[Any]:
    return np.stack([values.real, values.imag], axis=-1)


def _overlap(region: NDArray[np.bool_], coefficients: NDArray[Any]) -> float:
    """What the sky and the one redrawn have in common, as a share of what either has."""
    import cv2

    size = region.shape[0]
    curve = redraw_contour(coefficients, N_POINTS) * size / 2.0
    corners = np.rint(np.stack([curve.real, -curve.imag], axis=-1) + (size - 1) / 2.0).astype(np.int32)
    drawn = cv2.fillPoly(np.zeros(region.shape, np.uint8), [corners], 1) > 0
    return float((drawn & region).sum() / (drawn | region).sum())


def summarise(results: Results) -> Table:
    """How much of each sky comes back from so many coefficients."""
    return [
        {
            "sky": cell.sky,
            "number": cell.number,
            "coefficients": n,
            "overlap": float(share),
            "change_by_quarter_turn": float(arrays["change_by_quarter_turn"]),
        }
        for cell, arrays in results
        for n, share in zip(COEFFICIENTS, arrays["overlap"], strict=True)
    ]


def medians(table: Table) -> dict[int, float]:
    """Overlap in the middle of all skies, by the number of coefficients."""
    return {n: float(np.median([row["overlap"] for row in table if row["coefficients"] == n])) for n in COEFFICIENTS}


def draw(results: Results) -> Figure:
    """The four panels of the published figure."""
    from matplotlib.figure import Figure

    arrays = next(arrays for _, arrays in results)
    outline = arrays["outline"][np.isfinite(arrays["outline"]).all(axis=1)]
    coefficients = arrays["coefficient"] @ np.array([1.0, 1j])
    figure = Figure(figsize=(DOUBLE_COLUMN, 3.6), layout="constrained")
    axes = figure.subplot_mosaic("aabbb;cccdd")
    _draw_sky(axes["a"], arrays["mask"], outline, "blue")
    name_panel(axes["a"], "a", "sky and its outline")
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(outline, axis=0), axis=1))])
    along = length / (length[-1] + np.linalg.norm(outline[0] - outline[-1]))
    for axis, name, colour in ((0, "x", "blue"), (1, "y", "orange")):
        axes["b"].plot(along, outline[:, axis], color=COLOURS[colour], label=name)
    axes["b"].set(xlabel="length along the outline", ylabel="coordinate (half the picture)", xlim=(0, 1))
    axes["b"].legend(loc="lower right", ncols=2)
    name_panel(axes["b"], "b", "coordinates")
    number = np.arange(1, len(coefficients))
    frequency = (number + 1) // 2 * np.where(number % 2 == 1, 1, -1)
    is_kept = number < TEN
    for kept, colour, word in ((True, "red", "first ten, with 0"), (False, "grey", "others")):
        shown = is_kept == kept
        axes["c"].vlines(frequency[shown], 1e-5, np.abs(coefficients[1:][shown]), color=COLOURS[colour], label=word)
    axes["c"].set(xlabel="waves along the outline", ylabel="amplitude", yscale="log", xlim=(-50, 50), ylim=(1e-4, 2.0))
    axes["c"].legend(loc="upper right")
    name_panel(axes["c"], "c", "frequencies")
    curve = redraw_contour(coefficients[:TEN], N_POINTS)
    _draw_sky(axes["d"], arrays["mask"], _pairs(np.append(curve, curve[0])), "red")
    name_panel(axes["d"], "d", f"from {TEN} coefficients")
    return figure


def _draw_sky(axes: Axes, mask: NDArray[np.bool_], outline: NDArray[Any], colour: str) -> None:
    axes.imshow(0.35 + 0.6 * mask, cmap="gray", vmin=0, vmax=1, extent=(-1, 1, -1, 1), interpolation="nearest")
    axes.plot(*outline.T, color=COLOURS[colour], linewidth=1.0)
    axes.set(xticks=[], yticks=[], xlim=(-1, 1), ylim=(-1, 1))


def caption(results: Results) -> str:
    """What is shown."""
    cell, n = results.cells[0], len(results.cells)
    first = {row["coefficients"]: row["overlap"] for row in summarise(results) if row["number"] == cell.number}
    middle = medians(summarise(results))
    others = f" In the middle of {n} skies of one walk it is {100 * middle[TEN]:.0f} %, many being torn by trees."
    return (
        "a, A segmented sky (light) and the outline of the region nearest to the middle. b, Its coordinates along its "
        "length. c, Amplitudes of their frequencies; phases, which a turn changes, are dropped to compare skies. "
        f"d, The outline redrawn from its first {TEN} coefficients, the frequencies 0, 1, −1 … 5: it has "
        f"{100 * first[TEN]:.0f} % in common with the sky, from {2 * TEN + 1} coefficients "
        f"{100 * first[2 * TEN + 1]:.0f} %.{others if n > 1 else ''} {sky_text(cell.sky)}"
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What caption and text say."""
    middle = medians(table)
    ours = {
        "overlap of the sky redrawn from ten coefficients": middle[TEN],
        "change of an amplitude by a turn": max(float(row["change_by_quarter_turn"]) for row in table),
    }
    drawn = float(table[COEFFICIENTS.index(TEN)]["overlap"])
    why = (
        f"the median of {len(table) // len(COEFFICIENTS)} skies, many torn by trees; from {2 * TEN + 1} coefficients "
        f"it is {middle[2 * TEN + 1]:.2f}, and {drawn:.2f} from ten of the sky that is drawn"
    )
    return [judge(value, ours[name], why=why) for name, value in published.items()]
