"""Panels of decoded against true places, and of their errors by noise and circuit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.figures import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

N_POINTS = 200  # drawn of a cloud
SHOWN_VARIANTS = ("partially-holonomic", "non-holonomic", "fully-holonomic", "no-pontine", "idealised")


def draw_bearings(
    axes: Axes, true: NDArray[np.floating], decoded: NDArray[np.floating], mirrored: NDArray[np.floating]
) -> None:
    """Decoded bearing and arg F against the true bearing, all (trial,) [deg]."""
    limits = [-180.0, 180.0]
    axes.plot(limits, limits, color=COLOURS["grey"], linewidth=0.6)
    points: Any = {"linestyle": "none", "markersize": 2.0}
    axes.plot(true[:N_POINTS], decoded[:N_POINTS], "o", color=COLOURS["blue"], label="-arg F", **points)
    axes.plot(true[:N_POINTS], mirrored[:N_POINTS], "x", color=COLOURS["red"], label="arg F (2017 code)", **points)
    axes.set_xticks(np.arange(-180, 181, 90))
    axes.set_yticks(np.arange(-180, 181, 90))
    axes.set_xlabel("true bearing (deg)")
    axes.set_ylabel("decoded bearing (deg)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.55, 1.0), ncols=2, handletextpad=0.1, columnspacing=0.8)


def draw_distances(
    axes: Axes, true: NDArray[np.floating], decoded: NDArray[np.floating], label: str, colour: str
) -> None:
    """Decoded against true distance, both (trial,) [steps]."""
    far = 1.05 * float(true.max())
    axes.plot([0.0, far], [0.0, far], color=COLOURS["grey"], linewidth=0.6)
    axes.plot(
        true[:N_POINTS], decoded[:N_POINTS], "o", color=COLOURS[colour], markersize=2.0, linestyle="none", label=label
    )
    axes.set_xlabel("true distance (steps)")
    axes.set_ylabel("decoded distance (steps)")
    axes.legend(title="noise $\\sigma_r$", loc="upper left")


def draw_mismatch(
    axes: Axes,
    dance: NDArray[np.floating],
    search: NDArray[np.floating],
    labels: Sequence[str],
    name: str,
    colour: str,
) -> None:
    """Error of the danced bearing against that of the search, (condition, trial) [deg]: medians and quartiles."""
    axes.plot([-20.0, 65.0], [-20.0, 65.0], color=COLOURS["grey"], linewidth=0.6, zorder=0)
    low, x, high = np.percentile(search, [25, 50, 75], axis=1)
    bottom, y, top = np.percentile(dance, [25, 50, 75], axis=1)
    axes.errorbar(
        x, y, (y - bottom, top - y), (x - low, high - x), fmt="o", color=COLOURS[colour], markersize=3.0, linewidth=0.8,
        label=name,
    )  # fmt: skip
    if colour == "blue":
        for k, label in enumerate(labels):
            below = label in ("random", "0°")
            axes.annotate(
                label, (x[k], y[k]), (8 if label == "0°" else 0, -12 if below else 8), textcoords="offset points",
                ha="left" if label == "0°" else "right", fontsize=6.0,
            )  # fmt: skip
    axes.set_xlabel("error of the search (deg)")
    axes.set_ylabel("error of the danced bearing (deg)")
    axes.set_ylim(-55.0, 70.0)  # room for the legend
    axes.legend(loc="lower right")


def draw_noise(bearing_axes: Axes, distance_axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """Errors of bearing and distance against noise."""
    noise = [row["noise"] for row in rows]
    for name, label, colour in (
        ("absolute_bearing_error_deg", "sinusoid", "blue"),
        ("absolute_peak_error_deg", "peak column", "orange"),
    ):
        values, errors = [row[name] for row in rows], [row[f"{name}_error"] for row in rows]
        bearing_axes.errorbar(noise, values, errors, marker="o", markersize=3.0, color=COLOURS[colour], label=label)
    bearing_axes.set_ylim(bottom=0.0)
    bearing_axes.set_xlabel("noise $\\sigma_r$")
    bearing_axes.set_ylabel("|error of bearing| (deg)")
    bearing_axes.legend()
    ratio = [row["distance_ratio"] for row in rows]
    spread = np.hstack([_quartile_bars(row) for row in rows])
    distance_axes.errorbar(noise, ratio, spread, marker="o", markersize=3.0, color=COLOURS["blue"])
    distance_axes.axhline(1.0, color=COLOURS["grey"], linewidth=0.6)
    distance_axes.set_ylim(bottom=0.0)
    distance_axes.set_xlabel("noise $\\sigma_r$")
    distance_axes.set_ylabel("decoded over true distance")


def draw_variants(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """Ratio of distances for each circuit, without noise and with."""
    for k, name in enumerate(SHOWN_VARIANTS):
        for row in (row for row in rows if row["variant"] == name):
            is_clean = row["noise"] == 0.0
            axes.errorbar(
                [k + (-0.12 if is_clean else 0.12)], [row["distance_ratio"]], _quartile_bars(row), fmt="o",
                markersize=4.0,
                color=COLOURS["blue"], markerfacecolor=COLOURS["blue"] if is_clean else "white", linewidth=0.8,
                label=("without noise" if is_clean else f"noise {row['noise']:g}") if k == 0 else None,
            )  # fmt: skip
    axes.axhline(1.0, color=COLOURS["grey"], linewidth=0.6, zorder=0)
    axes.set_xticks(range(len(SHOWN_VARIANTS)), SHOWN_VARIANTS, rotation=30.0, ha="right")
    axes.set_ylabel("decoded over true distance")
    axes.legend(loc="lower left", bbox_to_anchor=(0.2, 1.0), ncols=2)


def _quartile_bars(row: Mapping[str, Any]) -> NDArray[np.floating]:
    """From the median down to the first and up to the third quartile, (2, 1)."""
    middle = row["distance_ratio"]
    return np.array([[middle - row["distance_ratio_q1"]], [row["distance_ratio_q3"] - middle]])
