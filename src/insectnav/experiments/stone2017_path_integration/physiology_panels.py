"""Panels of the recorded cells: tuning to heading, polariser and optic flow, as in Figs 1 to 3."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.figures import COLOURS
from insectnav.metrics.polarisation_tuning import aligned_tuning, preference_shift

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Reals = NDArray[np.floating[Any]]

KIND_COLOURS = {"tl": "black", "cl1": "green", "tb1": "purple", "tn1": "red", "tn2": "blue"}
WAYS = (("clockwise", "blue"), ("anticlockwise", "orange"))  # colours of Fig. 1e
SHOWN_DIRECTION = 2  # cells that are wired to 90°


def draw_heading_tuning(panels: Sequence[Axes], rate: Reals, kinds: Sequence[str]) -> None:
    """Rate against heading for turns either way, a panel for each kind of cell; dashed with compass shift.

    Parameters
    ----------
    panels : Axes for each kind
    rate : (2, kind, way, animal, bin) array [impulses/s]
        Without and with compass shift.
    kinds : names of the populations
    """
    n_bins = rate.shape[-1]
    angle = (np.arange(n_bins) + 0.5) * 360.0 / n_bins - 180.0
    for index, (axes, kind) in enumerate(zip(panels, kinds, strict=True)):
        for way, (name, colour) in enumerate(WAYS):
            alike = rate[:, index, way, SHOWN_DIRECTION::8]
            mean = alike.mean(axis=1)
            sd = alike[0].std(axis=0, ddof=1) if alike.shape[1] > 1 else 0.0
            axes.fill_between(angle, mean[0] - sd, mean[0] + sd, color=COLOURS[colour], alpha=0.25, linewidth=0.0)
            axes.plot(angle, mean[0], color=COLOURS[colour], label=name)
            axes.plot(angle, mean[1], color=COLOURS[colour], linestyle="--", linewidth=0.8)
        axes.text(0.5, 1.02, kind.upper(), transform=axes.transAxes, ha="center", fontsize=8.0)
        axes.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 90), ylim=(0.0, 180.0), xlabel="heading (deg)")
        axes.tick_params(labelleft=index == 0)
    panels[0].set_ylabel("rate (impulses/s)")
    panels[1].plot([], [], color="0.3", linestyle="--", linewidth=0.8, label="with compass shift")
    panels[1].legend(loc="upper center", handlelength=1.8)  # where CL1 has no data


def draw_axial_tuning(axes: Axes, rate: Reals, kinds: Sequence[str], published_width: float) -> None:
    """Tuning to a polariser, from 0 to 1 with the peak at 0, and the width at half maximum.

    Parameters
    ----------
    axes : Axes
    rate : (kind, speed, way, animal, bin) array [impulses/s]
        The later half of the bins is empty.
    kinds : names of the populations
    published_width : float [deg]
    """
    for index, kind in enumerate(kinds):
        tuning = aligned_tuning(rate[index, ..., : rate.shape[-1] // 2].astype(float))
        response = tuning.response.mean(axis=(0, 1, 2))
        angle = np.degrees(np.append(tuning.angle, np.pi / 2.0))  # both ends of half a turn are the same
        axes.plot(angle, np.append(response, response[0]), color=COLOURS[KIND_COLOURS[kind]], label=kind.upper())
    half = published_width / 2.0
    axes.plot([-half, half], [0.5, 0.5], color=COLOURS["grey"], linewidth=2.5, solid_capstyle="butt", zorder=0)
    axes.text(0.0, 0.46, f"bees: {published_width:g}°", ha="center", va="top", color=COLOURS["grey"], fontsize=6.0)
    axes.set(xlim=(-90.0, 90.0), xticks=np.arange(-90, 91, 45), ylim=(0.0, 1.05), yticks=(0.0, 0.5, 1.0))
    axes.set(xlabel="polariser from preference (deg)", ylabel="response (0 to peak)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.0), handlelength=1.2)


def draw_shifts(axes: Axes, preferred_deg: Reals, kinds: Sequence[str], published_shift: float) -> None:
    """Preferred angle in anticlockwise minus that in clockwise turns, each animal, without and with compass shift.

    Parameters
    ----------
    axes : Axes
    preferred_deg : (2, kind, speed, way, animal) array [deg]
        Of the polariser.
    kinds : names of the populations
    published_shift : float [deg]
    """
    angles = np.radians(preferred_deg.astype(float))
    shift = np.degrees(preference_shift(angles[..., 0, :], angles[..., 1, :]))
    for condition, (label, marker) in enumerate((("as is", "o"), ("compass shift", "^"))):
        for index, kind in enumerate(kinds):
            values = shift[condition, index].ravel()
            spread = np.linspace(-0.28, 0.28, values.size)
            axes.plot(
                index + spread, values, marker, color=COLOURS[KIND_COLOURS[kind]], markersize=1.6, alpha=0.6, mew=0
            )
        axes.plot([], [], marker, color="0.3", markersize=3.0, linestyle="none", label=label)
    axes.axhline(published_shift, color=COLOURS["grey"], linestyle="--", linewidth=0.8)
    axes.text(2.45, 66.0, f"bees: {published_shift:g}°", ha="right", color=COLOURS["grey"], fontsize=6.0)
    axes.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
    axes.set(xlim=(-0.5, 2.5), xticks=range(len(kinds)), ylim=(-20.0, 75.0), ylabel="shift (deg)")
    axes.set_xticklabels([kind.upper() for kind in kinds])
    axes.legend(loc="center", handlelength=1.0)


def draw_flow_tuning(axes: Axes, rate: Reals, background: Reals, velocity_deg: Reals, kind: str) -> None:
    """Rate against the velocity of translational flow, the background rate, and a straight line.

    Parameters
    ----------
    axes : Axes
    rate : (side, animal, velocity) array [impulses/s]
    background : (side, animal) array [impulses/s]
    velocity_deg : (velocity,) array [°/s]
    kind : name of the population
    """
    cells, colour = rate.reshape(-1, rate.shape[-1]).astype(float), COLOURS[KIND_COLOURS[kind]]
    is_fitted = velocity_deg >= 0.0 if kind == "tn2" else np.full(velocity_deg.shape, True)
    fit = np.polynomial.Polynomial.fit(velocity_deg[is_fitted], cells.mean(axis=0)[is_fitted], 1)
    middle, spread = float(background.mean()), float(background.std(ddof=1))
    axes.axhspan(middle - spread, middle + spread, color="0.85", linewidth=0.0)
    axes.axhline(middle, color=COLOURS["grey"], linewidth=0.8)
    axes.plot(velocity_deg[is_fitted], fit(velocity_deg[is_fitted]), color="0.3", linewidth=0.8)
    error = cells.std(axis=0, ddof=1)
    axes.errorbar(velocity_deg, cells.mean(axis=0), error, fmt="o", color=colour, markersize=2.5, elinewidth=0.7)
    axes.set(xlim=(-97.0, 97.0), xticks=(-90, -45, 0, 45, 90), ylim=(-5.0, 170.0), xlabel="velocity of flow (deg/s)")
    axes.text(0.5, 1.02, kind.upper(), transform=axes.transAxes, ha="center", fontsize=8.0)
    axes.set_ylabel("rate (impulses/s)")


def draw_expansion(axes: Any, rate: Reals, point_deg: Reals, azimuth: Reals, kinds: Sequence[str]) -> None:
    """Rate against the azimuth of the point of expansion, ahead at the top, right (solid) and left (dashed) cells.

    Parameters
    ----------
    axes : PolarAxes
    rate : (kind, side, animal, azimuth) array [impulses/s]
    point_deg : (kind, side, animal) array [deg]
        Preferred points.
    azimuth : (azimuth,) array [rad]
    kinds : names of the populations
    """
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    around = np.append(azimuth, azimuth[0])
    top = 165.0
    for index, kind in enumerate(kinds):
        for side, (name, line) in enumerate((("right", "-"), ("left", "--"))):
            mean = rate[index, side].mean(axis=0)
            colour = COLOURS[KIND_COLOURS[kind]]
            label = f"{kind.upper()} {name}"
            axes.plot(around, np.append(mean, mean[0]), color=colour, linestyle=line, label=label)
            points = np.radians(point_deg[index, side])
            axes.vlines(points, top - 12.0, top, color=colour, linewidth=0.5, alpha=0.5)
    axes.set_ylim(0.0, top)
    axes.set_yticks([50.0, 100.0, 150.0])
    axes.set_rlabel_position(180.0)  # where the lines leave most room
    for label in axes.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.3})
    axes.text(0.5, 1.17, "rate (impulses/s)", transform=axes.transAxes, ha="center", fontsize=7.0)
    axes.set_xticks(np.radians(np.arange(0, 360, 45)))
    axes.set_xticklabels(["0°", "45°", "90°", "135°", "180°", "-135°", "-90°", "-45°"])
    axes.tick_params(pad=0.0)
    axes.grid(linewidth=0.4)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2, handlelength=1.8, columnspacing=1.0)
