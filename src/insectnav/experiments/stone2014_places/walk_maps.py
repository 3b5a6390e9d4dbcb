"""Maps of a walk as Fig. 4 has them: right places green, wrong ones red, ends without a match yellow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.figures import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RIGHT, WRONG, NEITHER = COLOURS["green"], COLOURS["red"], COLOURS["yellow"]


def draw_places(axes: Axes, position: Any, is_right: NDArray[np.bool_], is_matched: NDArray[np.bool_]) -> None:
    """A dot at each query (query, 2) [m] on the line of the walk."""
    axes.plot(*position.T, color=COLOURS["grey"], linewidth=0.5, zorder=0)
    for label, chosen, colour in (
        ("not matched", ~is_matched, NEITHER),
        ("right", is_matched & is_right, RIGHT),
        ("wrong", is_matched & ~is_right, WRONG),
    ):
        axes.plot(*position[chosen].T, "o", color=colour, markersize=2.4, markeredgewidth=0.0, label=label)
    frame_map(axes, position)


def draw_directions(axes: Axes, position: Any, direction: Any, is_right: NDArray[np.bool_], line: Any) -> None:
    """An arrow at each query in the direction (query,) [rad] that it is told to walk in."""
    axes.plot(*line.T, color=COLOURS["grey"], linewidth=0.5, zorder=0)
    for label, chosen, colour in (("right place", is_right, RIGHT), ("wrong place", ~is_right, WRONG)):
        known = chosen & np.isfinite(direction)
        axes.quiver(
            *position[known].T, np.sin(direction[known]), np.cos(direction[known]),
            color=colour, angles="xy", scale_units="xy", scale=0.042, width=0.0035, headwidth=5.0, label=label,
        )  # fmt: skip
    frame_map(axes, line, beside=(0.46, 0.36))


def frame_map(axes: Axes, position: Any, beside: tuple[float, float] = (0.48, 0.55)) -> None:
    """Equal scales, no ticks, a bar of 100 m; `beside` is room at the left and right as shares of the map."""
    low, high = position.min(axis=0), position.max(axis=0)
    span = max(float((high - low).max()), 100.0)
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.set_xlim(low[0] - beside[0] * span, high[0] + beside[1] * span)
    axes.set_ylim(low[1] - 0.1 * span, high[1] + 0.12 * span)
    for spine in axes.spines.values():
        spine.set_visible(False)
    start = high[0] + 0.08 * span, low[1] - 0.06 * span
    axes.plot([start[0], start[0] + 100.0], [start[1]] * 2, color=COLOURS["black"], linewidth=1.2)
    axes.text(start[0] + 50.0, start[1] + 0.015 * span, "100 m", ha="center", va="bottom", fontsize=5.0)


def inset(axes: Axes, bounds: tuple[float, float, float, float]) -> Any:
    """Axes within axes, with small numbers and an opaque ground."""
    small = axes.inset_axes(bounds)
    small.tick_params(labelsize=5.0, pad=1.0, length=1.5)
    small.patch.set_alpha(0.85)
    return small


def draw_correspondence(axes: Axes, reference: Any, is_right: NDArray[np.bool_], labels: tuple[str, str]) -> None:
    """Number of the match against number of the query, in an inset at the upper right."""
    small = inset(axes, (0.835, 0.66, 0.165, 0.24))
    query = np.arange(len(reference))
    for chosen, colour in ((is_right, RIGHT), ((reference >= 0) & ~is_right, WRONG)):
        small.plot(query[chosen], reference[chosen], ".", color=colour, markersize=1.5)
    small.set_xlabel(f"query, {labels[0].capitalize()}", fontsize=5.0, labelpad=1.0)
    small.set_ylabel(f"match, {labels[1].capitalize()}", fontsize=5.0, labelpad=1.0)
