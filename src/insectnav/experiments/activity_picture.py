"""A picture of the activity of all cells over a trip, after Stone et al. 2017, Fig. 5b."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from insectnav.experiments.figures import COLOURS, RATES
from insectnav.records import plural_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

LABELS = {
    "tl": "TL",
    "cl1": "CL1",
    "tb1": "TB1",
    "tn2": "TN2",
    "memory": "Memory",
    "cpu4": "CPU4",
    "pontine": "Pontine",
    "cpu1": "CPU1",
}
GAP = 4  # rows of the picture between populations
N_COLUMNS = 800  # of the picture


def draw_activity(
    axes: Axes,
    activity: Mapping[str, np.ndarray],
    *,
    n_outbound: int,
    time_per_step: float = 1.0,
    time_unit: str = "step",
) -> AxesImage:
    """Populations below each other, one row for each cell, time across, the turning point marked.

    Parameters
    ----------
    axes : Axes
    activity : name of population, as in LABELS, to (step, cell) array
        Rates are divided by the highest of their population.
    n_outbound : int
        Steps up to the turning point.
    time_per_step : float
    time_unit : str

    Notes
    -----
    They make a single picture: eight sets of axes would take several times as long to draw.
    """
    n_steps = len(next(iter(activity.values())))
    blocks, first_row = [], 0
    for population, label in LABELS.items():
        rates = shorten(np.asarray(activity[population], float).T)
        n_cells = len(rates)
        rows_per_cell = 4 if n_cells == 2 else 16 // n_cells
        height = n_cells * rows_per_cell
        middle = first_row + height / 2.0
        axes.text(-0.07, middle, label, transform=axes.get_yaxis_transform(), ha="right", va="center")
        for cell in (0, n_cells - 1):
            row = first_row + (cell + 0.5) * rows_per_cell
            axes.text(
                -0.012, row, str(cell + 1), transform=axes.get_yaxis_transform(), fontsize=5, ha="right", va="center"
            )
        blocks += [
            np.repeat(rates / max(rates.max(), 1e-12), rows_per_cell, axis=0),
            np.full((GAP, rates.shape[1]), np.nan),
        ]
        first_row += height + GAP
    picture = np.ma.masked_invalid(np.concatenate(blocks[:-1]))
    extent = (0.0, n_steps * time_per_step, len(picture), 0.0)
    image = axes.imshow(picture, aspect="auto", interpolation="none", cmap=RATES, vmin=0.0, vmax=1.0, extent=extent)
    axes.axvline(n_outbound * time_per_step, color=COLOURS["orange"], linewidth=1.0)
    axes.text(n_outbound * time_per_step, -0.5, "turning point", ha="center", va="bottom", fontsize=6)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(f"time ({plural_unit(time_unit)})")
    return image


def draw_rate_scale(axes: Axes, image: AxesImage) -> None:
    """The colours of the picture in axes of their own."""
    bar = axes.figure.colorbar(image, cax=axes)
    bar.set_label("rate / highest of the population")


def shorten(rates: np.ndarray, n_columns: int = N_COLUMNS) -> np.ndarray:
    """Rates (cell, step) averaged over as many steps as one dot of the picture covers.

    Parameters
    ----------
    rates : (cell, step) array
    n_columns : int
        The most there may be.

    Returns
    -------
    (cell, column) array
    """
    n_per_column = -(-rates.shape[1] // n_columns)
    starts = np.arange(0, rates.shape[1], n_per_column)
    return np.add.reduceat(rates, starts, axis=1) / np.diff(starts, append=rates.shape[1])
