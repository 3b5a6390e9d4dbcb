"""Panels of migratory flights: paths, held courses, and what disturbs them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import bearing, unit_vector, wrap
from insectnav.experiments.figures import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_flights(axes: Axes, paths: NDArray[np.floating]) -> None:
    """Flights for goals evenly all round, beginning with north, and the goals as dashed lines.

    Parameters
    ----------
    axes : Axes
    paths : (goal, point, 2) array [steps]
    """
    far = 1.15 * np.abs(paths).max()
    for path, goal in zip(paths, _goals(paths), strict=True):
        x, y = far * unit_vector(goal)
        axes.plot([0.0, x], [0.0, y], color=COLOURS["grey"], linewidth=0.5, linestyle="--", zorder=1)
        axes.plot(*path.T, color=COLOURS["blue"], linewidth=0.8, zorder=2)
    axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", markersize=3.5, zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (steps)")
    axes.set_ylabel("y (steps)")


def draw_reversal(axes: Axes, paths: NDArray[np.floating], steps_per_point: int) -> None:
    """Course minus goal along flights for goals evenly all round, over ten points at a time.

    Parameters
    ----------
    axes : Axes
    paths : (goal, point, 2) array [steps]
    steps_per_point : int
    """
    moved = np.diff(paths[:, ::10].astype(float), axis=1)
    error = np.degrees(wrap(bearing(moved) - _goals(paths)[:, None] - np.pi / 2.0)) + 90.0  # from -90 up to 270
    steps = 10 * steps_per_point * (np.arange(error.shape[1]) + 0.5)
    axes.plot(steps, error.T, color=COLOURS["blue"], linewidth=0.6)
    axes.set_yticks([-90, 0, 90, 180, 270])
    axes.set_xlabel("step")
    axes.set_ylabel("course minus goal (deg)")


def _goals(paths: NDArray[np.floating]) -> NDArray[np.floating]:
    return 2.0 * np.pi * np.arange(len(paths)) / len(paths)


def draw_courses(axes: Axes, goal: NDArray[np.floating], course: NDArray[np.floating], label: str, colour: str) -> None:
    """Error of the held course against the goal, both (trial,) [deg]."""
    goal = np.degrees(wrap(np.radians(goal)))
    error = np.degrees(wrap(np.radians(course - goal)))
    axes.plot(goal, error, "o", color=COLOURS[colour], markersize=1.5, label=label)
    axes.set_xticks(np.arange(-180, 181, 90))
    axes.set_ylim(-5.0, 5.0)
    axes.set_xlabel("goal (deg)")
    axes.set_ylabel("held course minus goal (deg)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.55, 1.0), ncols=2, handletextpad=0.1)


def draw_spread(
    spread_axes: Axes, straight_axes: Axes, rows: Sequence[Mapping[str, Any]], label: str, colour: str
) -> None:
    """Circular SD of the held courses and straightness, against noise."""
    noise = [row["noise"] for row in rows]
    options: Any = {"marker": "o", "markersize": 3.0, "color": COLOURS[colour], "label": label}
    spread_axes.plot(noise, [row["course_error_sd_deg"] for row in rows], **options)
    straight_axes.plot(noise, [row["straightness"] for row in rows], **options)
    for axes in (spread_axes, straight_axes):
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("noise $\\sigma_r$")
    spread_axes.set_ylabel("SD of held courses (deg)")
    spread_axes.legend(loc="upper left")
    straight_axes.set_ylabel("straightness")


def draw_disturbances(axes: Axes, rows: Mapping[str, Mapping[str, Any]], label: str, colour: str) -> None:
    """Mean and SD of the error of the course after each disturbance."""
    place = np.arange(len(rows)) + (0.12 if colour == "red" else -0.12)
    mean = [row["course_error_after_deg"] for row in rows.values()]
    spread = [row["course_error_after_sd_deg"] for row in rows.values()]
    axes.errorbar(mean, place, xerr=spread, fmt="o", markersize=3.0, linewidth=0.8, color=COLOURS[colour], label=label)
    axes.axvline(0.0, color=COLOURS["grey"], linewidth=0.6, zorder=0)
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(-8.0, 8.0)
    axes.set_xlabel("course minus goal (deg)")
