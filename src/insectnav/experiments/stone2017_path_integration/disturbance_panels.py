"""The six panels of Extended Data Fig. 9a."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from insectnav.experiments.experiment import Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, PRESET_NAMES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = {
    "noise": "noise $\\sigma_r$",
    "compass": "compass shift (deg)",
    "flow": "preferred flow $\\phi_{TN}$ (deg)",
    "weights": "weight noise $\\sigma_w$",
    "speed": "acceleration (times the default)",
    "filter": "length of the filter (steps)",
}
MEASURED = {"compass": 53.0 / 2.0, "flow": 45.0}  # [deg] Megalopta: between turns either way 53°, so half of it each
PRESET_LOOKS: dict[str, dict[str, Any]] = {
    "thesis": {"linestyle": "-", "marker": "o"},
    "code-2017": {"linestyle": "--", "marker": "o", "markerfacecolor": "white"},
}


class Series(NamedTuple):
    """A line of a panel."""

    form: str
    noise: float | None  # None: the noise is what is varied
    colour: str
    label: str


SERIES = {
    "noise": (Series("", None, "blue", ""),),
    "weights": (
        Series("signs kept", 0.1, "blue", "SD"),
        Series("signs kept", 0.0, "green", "SD"),
        Series("variance", 0.1, "purple", "variance"),
    ),
    "filter": (
        Series("clean", 0.1, "blue", "clean"),
        Series("clean", 0.0, "green", "clean"),
        Series("code-2017", 0.1, "red", "2017 code's filter"),
    ),
}
OTHERS = (Series("", 0.1, "blue", "noise 0.1"), Series("", 0.0, "green", "no noise"))


def draw_panels(table: Table) -> Figure:
    """Mean ± SD of the closest distance against each disturbance."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.6), layout="constrained")
    panels = figure.subplots(2, 3)
    for letter, axes, panel in zip("abcdef", panels.flat, LABELS, strict=True):
        for series in SERIES.get(panel, OTHERS):
            for preset in PRESET_LOOKS:
                _draw_series(axes, table, panel, series, preset)
        axes.axhline(HOME_RANGE, color=COLOURS["grey"], linestyle="--", linewidth=0.7)
        if panel in MEASURED:
            axes.axvline(MEASURED[panel], color=COLOURS["orange"], linewidth=1.2, zorder=0)
            axes.set_xticks(np.arange(0, 91, 22.5), ["0", "22.5", "45", "67.5", "90"])
        axes.set_xlabel(LABELS[panel])
        axes.set_ylim(bottom=0.0)
        name_panel(axes, letter)
    for axes in panels[:, 0]:
        axes.set_ylabel("closest distance to the nest (steps)")
    _explain(panels[0, 0], panels[1, 0], panels[1, 2])
    return figure


def _draw_series(axes: Axes, table: Table, panel: str, series: Series, preset: str) -> None:
    rows = [
        row
        for row in table
        if (row["panel"], row["preset"], row["form"]) == (panel, preset, series.form)
        and series.noise in (None, row["noise"])
    ]
    x = np.array([row["value"] for row in rows])
    if preset != "thesis":
        x = x + 0.012 * (x.max() - x.min())
    mean, sd = np.array([row["mean"] for row in rows]), np.array([row["sd"] for row in rows])
    below = np.minimum(sd, mean)  # no distance is negative
    axes.errorbar(x, mean, (below, sd), color=COLOURS[series.colour], linewidth=1.0, elinewidth=0.5, markersize=2.8,
                  capsize=1.5, capthick=0.5, **PRESET_LOOKS[preset])  # fmt: skip


def _explain(first: Axes, weights: Axes, filters: Axes) -> None:
    """Legends: sets of constants and noise levels once, then what only one panel has."""
    for preset, look in PRESET_LOOKS.items():
        first.plot([], [], color=COLOURS["blue"], markersize=2.8, label=PRESET_NAMES[preset], **look)
    first.plot([], [], color=COLOURS["blue"], label="b–f: noise 0.1")
    first.plot([], [], color=COLOURS["green"], label="b–f: no noise")
    first.legend(loc="upper left")
    weights.plot([], [], color=COLOURS["purple"], label="as a variance, noise 0.1")
    weights.legend(loc="upper left")
    filters.plot([], [], color=COLOURS["red"], label="2017 code's filter, noise 0.1")
    filters.legend(loc="upper left")
