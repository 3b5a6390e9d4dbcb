"""The figure of `insectnav home`: paths on the left, activity of the circuit on the right."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.figure_process import serve
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, RATES, journal_style
from insectnav.records import plural_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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


def draw(data: Mapping[str, Any]) -> Figure:
    """Outbound track and ways home; beside them the activity of every population over the first trial.

    Parameters
    ----------
    data : mapping
        As from `insectnav.experiments.home.figure_data`.

    Notes
    -----
    After Stone et al. 2017, Fig. 5a, b: rates are divided by the highest of their population.
    """
    from matplotlib.figure import Figure

    with journal_style():
        figure = Figure(figsize=(DOUBLE_COLUMN, 4.3))
        _draw_paths(figure.add_axes((0.08, 0.235, 0.37, 0.69)), data)
        _draw_activity(figure.add_axes((0.545, 0.1, 0.36, 0.825)), figure.add_axes((0.925, 0.1, 0.012, 0.825)), data)
    return figure


def _draw_paths(axes: Axes, data: Mapping[str, Any]) -> None:
    """Map in the unit of the track, with the nest, its search radius and the decoded home vector."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    unit = plural_unit(str(data["unit"]))
    radius = f"{float(data['search_radius']):.3g} {unit}"
    nest, turn = data["nest"], data["outbound"][-1]
    ways_home, first_way = data["homing"], data["first_homing"]
    n_drawn, n_trials = len(ways_home) + 1, int(data["n_trials"])
    faint = max(0.12, 0.8 / n_drawn**0.5)
    axes.add_collection(LineCollection(ways_home, colors=COLOURS["sky"], linewidths=0.4, alpha=faint, zorder=1))
    shown = f"n = {n_trials}" if n_trials == n_drawn else f"{n_drawn} of {n_trials}"
    axes.plot([], [], color=COLOURS["sky"], linewidth=0.8, label=f"ways home ({shown})")
    # No fi or fl in the labels: their ligature would take a second font in the PDF, and as long again to write it.
    axes.plot(*first_way.T, color=COLOURS["blue"], linewidth=0.8, zorder=3, label="way home of trial 1")
    axes.plot(*data["outbound"].T, color="0.25", linewidth=0.9, zorder=2, label="outbound")
    circle = Circle(tuple(nest), float(data["search_radius"]), fill=False, linestyle="--", linewidth=0.7, zorder=4)
    axes.add_patch(circle)
    vector = np.mean(data["home_vector"], axis=0)
    arrow = {"arrowstyle": "-|>", "color": COLOURS["red"], "linewidth": 1.2, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", xy=tuple(turn + vector), xytext=tuple(turn), arrowprops=arrow, zorder=6)
    axes.update_datalim([turn + vector, nest + data["search_radius"], nest - data["search_radius"]])
    axes.plot([], [], color=COLOURS["red"], linewidth=1.2, label="decoded home vector (mean)")
    dot: dict[str, Any] = {"marker": "o", "color": "white", "markeredgecolor": "black", "markersize": 4.5, "zorder": 5}
    axes.plot(*nest, **dot, linestyle="none", label="nest")
    axes.plot([], [], color="black", linewidth=0.7, linestyle="--", label=f"search radius ({radius})")
    square: dict[str, Any] = {"marker": "s", "color": COLOURS["orange"], "markersize": 3.5, "zorder": 5}
    axes.plot(*turn, **square, linestyle="none", label="turning point")
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"x ({unit})")
    axes.set_ylabel(f"y ({unit})")
    axes.set_title(_shorten_name(str(data["name"])), loc="left", pad=10.0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, handlelength=1.6, columnspacing=1.2)


def _draw_activity(axes: Axes, bar_axes: Axes, data: Mapping[str, Any]) -> None:
    """Populations below each other, one row for each cell, time across, the turning point marked.

    They make a single picture: eight sets of axes would take several times as long to draw.
    """
    n_outbound, n_steps = len(data["outbound"]), len(data["activity_tl"])
    time_per_step, time_unit = float(data["time_per_step"]), str(data["time_unit"])
    blocks, first_row = [], 0
    for population, label in LABELS.items():
        rates = _shorten(np.asarray(data[f"activity_{population}"], float).T)
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
    axes.set_title("activity in trial 1", loc="left", pad=10.0)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel(f"time ({plural_unit(time_unit)})")
    bar = axes.figure.colorbar(image, cax=bar_axes)
    bar.set_label("rate / highest of the population")


def _shorten_name(name: str, limit: int = 40) -> str:
    """The name, with its middle left out where it would not fit above the map; no character is taken as markup."""
    if len(name) > limit:
        name = f"{name[: limit // 2]}…{name[-limit // 2 + 1 :]}"
    return name.replace("$", r"\$")


def _shorten(rates: np.ndarray, n_columns: int = N_COLUMNS) -> np.ndarray:
    """Rates (cell, step) averaged over as many steps as one dot of the picture covers."""
    n_per_column = -(-rates.shape[1] // n_columns)
    starts = np.arange(0, rates.shape[1], n_per_column)
    return np.add.reduceat(rates, starts, axis=1) / np.diff(starts, append=rates.shape[1])


if __name__ == "__main__":
    serve(draw)
