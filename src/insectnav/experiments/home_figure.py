"""The figure of `insectnav home`: paths on the left, activity of the circuit on the right."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.activity_picture import LABELS, draw_activity, draw_rate_scale
from insectnav.experiments.figure_process import serve
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, journal_style
from insectnav.records import plural_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
        axes, bar_axes = (figure.add_axes(box) for box in ((0.545, 0.1, 0.36, 0.825), (0.925, 0.1, 0.012, 0.825)))
        image = draw_activity(
            axes,
            {name: data[f"activity_{name}"] for name in LABELS},
            n_outbound=len(data["outbound"]),
            time_per_step=float(data["time_per_step"]),
            time_unit=str(data["time_unit"]),
        )
        axes.set_title("activity in trial 1", loc="left", pad=10.0)
        draw_rate_scale(bar_axes, image)
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


def _shorten_name(name: str, limit: int = 40) -> str:
    """The name, with its middle left out where it would not fit above the map; no character is taken as markup."""
    if len(name) > limit:
        name = f"{name[: limit // 2]}…{name[-limit // 2 + 1 :]}"
    return name.replace("$", r"\$")


if __name__ == "__main__":
    serve(draw)
