"""Panels of Ext. Data Fig. 10a-c: paths with the injected stretch marked, and what each compass cell does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.figures import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PATH_COLOURS = ("black", "red", "purple", "green", "blue")


def draw_injected_paths(
    axes: Axes,
    paths: NDArray[np.floating],
    shown: Mapping[str, int],
    stretch: slice,
    n_outbound: int,
    apart: float = 0.0,
) -> None:
    """Ways home in colour, the way out in grey, and the stretch in which cells are injected as a broad pale line.

    Parameters
    ----------
    axes : Axes
    paths : (cell, step, 2) array [steps]
    shown : label -> index of the cell
    stretch : samples of the path
    n_outbound : int
    apart : float
        Paths are set side by side at this distance [steps], with their labels above.
    """
    for k, (label, index) in enumerate(shown.items()):
        x, y = paths[index].T
        x = x + k * apart
        axes.plot(x[stretch], y[stretch], color=COLOURS["sky"], linewidth=3.5, solid_capstyle="round", zorder=1)
        axes.plot(x[:n_outbound], y[:n_outbound], color=COLOURS["grey"], linewidth=1.0, zorder=2)
        axes.plot(x[n_outbound - 1 :], y[n_outbound - 1 :], color=COLOURS[PATH_COLOURS[k]], linewidth=0.6, label=label)
        axes.plot(x[0], y[0], marker="o", color="white", markeredgecolor="black", markersize=3.0, zorder=5)
        if apart:
            axes.text(k * apart, 75.0, label, ha="center", fontsize=6.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (steps)")
    axes.set_ylabel("y (steps)")


def draw_spirals(axes: Axes, paths: NDArray[np.floating], stretch: slice, n_steps: int, apart: float) -> None:
    """Beginnings of the injected stretches, enlarged, one below the other and each from the place where it begins.

    Parameters
    ----------
    axes : Axes
    paths : (number of cells, step, 2) array [steps]
    stretch : samples of the path
    n_steps : int
        Length of what is shown.
    apart : float
        [steps]
    """
    for k, path in enumerate(paths):
        x, y = (path[stretch][: n_steps + 1] - path[stretch.start]).T
        axes.plot(x, y - k * apart, color=COLOURS[PATH_COLOURS[k + 1]], linewidth=0.8)
        axes.text(-2.0, -k * apart, f"{k + 1}", ha="right", va="center", fontsize=6.0)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(-5.0, 13.0)
    axes.set_ylim(-apart * (len(paths) - 0.5), 0.8 * apart)
    axes.set_xlabel("x (steps)")
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)


def draw_compass_shift(axes: Axes, compass: NDArray[np.floating], shift: NDArray[np.floating]) -> None:
    """Shift of the stored bearing by each TB1 cell, mean and SD, over the rates that the cells had before.

    Parameters
    ----------
    axes : Axes
    compass : (8,) array
        Rates of TB1.
    shift : (8, trial) array [deg]
    """
    columns = np.arange(8)
    rates = axes.twinx()
    rates.bar(columns, compass, color=COLOURS["grey"], alpha=0.3, width=0.8)
    rates.set_ylim(0.0, 1.0)
    rates.set_yticks([0.0, 0.5, 1.0])
    rates.set_ylabel("rate of TB1 before")
    rates.spines["right"].set_visible(True)
    axes.set_zorder(rates.get_zorder() + 1)
    axes.patch.set_visible(False)
    spread = shift.std(axis=1, ddof=1)
    axes.errorbar(columns, shift.mean(axis=1), spread, fmt="o", color="black", markersize=3.0, linewidth=0.8)
    axes.axhline(0.0, color="black", linewidth=0.4)
    axes.set_ylim(-15.0, 15.0)
    axes.set_xticks(columns)
    axes.set_xlabel("injected TB1 cell")
    axes.set_ylabel("shift of stored bearing (deg)")
