"""Panels that Figs 5, 8 and 9 share: correspondences, precision over recall, round pictures."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.figures import COLOURS
from insectnav.experiments.stone2016_places.recognition import Recognised

PLATE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0}


def draw_correspondence(axes: Any, answer: Recognised) -> None:
    """Matched reference frame over query frame: right ones green, wrong ones red, and the truth as a line."""
    query, is_match = np.arange(len(answer.score)), np.isfinite(answer.score)
    right, wrong = is_match & answer.is_right, is_match & ~answer.is_right
    axes.plot(query, answer.truth, color=COLOURS["grey"], linewidth=0.5, zorder=1)
    for chosen, colour in ((wrong, "red"), (right, "green")):
        axes.scatter(query[chosen], answer.reference[chosen], s=1.6, color=COLOURS[colour], linewidths=0, zorder=2)
    share = 100.0 * right.sum() / max(is_match.sum(), 1)
    axes.text(0.03, 0.95, f"{share:.0f} % right", transform=axes.transAxes, va="top", fontsize=6.0, bbox=PLATE)


def draw_curve(axes: Any, answer: Recognised, colour: str, label: str, style: Any = "-") -> None:
    """Precision over recall [%], one step for each distinct score."""
    curve = answer.curve
    axes.plot(100.0 * curve.recall, 100.0 * curve.precision, style, color=colour, label=label, linewidth=0.9)
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(0.0, 102.0)


def draw_frame(axes: Any, picture: NDArray[Any]) -> None:
    """A round picture, grey or in colour; what lies outside the circle is left white."""
    rows, columns = picture.shape[:2]
    y, x = np.mgrid[:rows, :columns] + 0.5
    inside = (x - columns / 2) ** 2 + (y - rows / 2) ** 2 <= (min(rows, columns) / 2) ** 2
    values = np.asarray(picture, np.float64) * (1.0 if picture.dtype == bool else 1.0 / 255.0)
    grey = values if values.ndim == 3 else np.repeat(values[..., None], 3, axis=-1)
    axes.imshow(np.where(inside[..., None], grey, 1.0), interpolation="antialiased")
    axes.axis("off")
