"""How Ext. Data Fig. 7 is drawn: memories as sinusoids, and the turns they make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import wrap
from insectnav.central_complex import PRESETS
from insectnav.central_complex.connectivity import DIRECTIONS
from insectnav.experiments.experiment import Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.stone2017_path_integration.trips import PRESET_NAMES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HALVES = ("right", "left")
HALF_COLOURS = {"right": "red", "left": "orange"}
PRESET_COLOURS = {"thesis": "blue", "code-2017": "purple"}
FINE = np.radians(np.arange(0.0, 361.0, 3.0))


def draw_memories(
    results: Results,
    table: Table,
    courses: NDArray[Any],
    facings: NDArray[Any],
    home: float,
    shown: Mapping[str, float],
) -> Figure:
    """The panels of the figure.

    Parameters
    ----------
    results : Results
        Of `insectnav.experiments.stone2017_path_integration.ed_7`.
    table : rows of its table
    courses, facings : (n,) arrays [rad]
        Of the panels a and g.
    home : float [rad]
        Direction of home in d to f.
    shown : name of a facing direction to the direction of home from there [deg]
    """
    from matplotlib.figure import Figure

    thesis = results.only(preset="thesis")
    memory = results["memory"][thesis]
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.7), layout="constrained")
    rows: Any = figure.subfigures(2, 1)
    panels = [*rows[0].subplots(1, 3), *rows[1].subplots(1, 4, width_ratios=(1.0, 1.0, 0.35, 1.15))]
    _draw_charge(panels[0], results["charge"][thesis], courses)
    _draw_sum(panels[1], results["leg_memory"][thesis])
    _draw_halves(panels[2], memory, 0.0, home, ("d", "memory by column"))
    _draw_halves(panels[3], memory, 45.0, home, ("e", "turned by the 45° of its flow"), with_mean=True)
    _draw_halves(panels[4], memory, -45.0, home, ("f", "as CPU1 compares them"))
    _draw_facings(panels[4], home, shown)
    _draw_ratios(panels[5], table[thesis], shown)
    _draw_turns(panels[6], results, facings)
    for axes in (panels[2], panels[3], panels[4]):
        axes.set_xlabel("direction (deg)")
    panels[2].set_ylabel("memory")
    panels[3].set_ylabel("memory")
    panels[4].set_ylabel("memory")
    return figure


def _draw_charge(axes: Axes, charge: NDArray[Any], courses: NDArray[Any]) -> None:
    """Charge of either half against the direction of motion."""
    for half, name in enumerate(HALVES):
        axes.plot(np.degrees(courses), charge[:, half], color=COLOURS[HALF_COLOURS[name]], label=f"{name} half")
    for angle in (-45.0, 45.0):
        axes.axvline(angle, color=COLOURS["grey"], linewidth=0.6, linestyle=":")
    name_panel(axes, "a", "what charges the memory")
    axes.set_xlabel("motion relative to the body (deg)")
    axes.set_ylabel("charge / highest")
    axes.set_xticks(np.arange(-180, 181, 90))
    axes.set_ylim(0.0, 1.3)
    axes.legend(loc="upper right", ncols=2)


def _draw_sum(axes: Axes, memory: NDArray[Any]) -> None:
    """Memories of two legs, of both added, and of the direct way; the halves turned to where their flow comes from."""
    patterns = np.array([_aligned(flight) for flight in memory])
    added = patterns[0] + patterns[1]
    style: dict[str, Any] = {"linestyle": "none", "markersize": 3.5}
    for pattern, colour, label in ((patterns[0], "sky", "1 to 2"), (patterns[1], "green", "2 to 3")):
        axes.plot(np.degrees(FINE), _sinusoid(pattern), color=COLOURS[colour])
        axes.plot(np.degrees(DIRECTIONS), pattern, marker="o", color=COLOURS[colour], label=label, **style)
    axes.plot(np.degrees(DIRECTIONS), added, marker="o", color="black", label="sum of both", **style)
    axes.plot(np.degrees(FINE), _sinusoid(patterns[3]), color="black", linestyle="--", label="1 to 3, direct")
    name_panel(axes, "c", "adding motions")
    axes.set_xlabel("direction (deg)")
    axes.set_ylabel("memory less its mean")
    axes.set_xticks(np.arange(0, 361, 90))
    axes.set_ylim(-1.25 * np.abs(added).max(), 1.9 * np.abs(added).max())
    axes.legend(loc="upper right", ncols=2)


def _aligned(halves: NDArray[Any]) -> NDArray[Any]:
    """Mean of both halves (2, 8), each turned by one column to where its flow comes from, (8,)."""
    return (np.roll(halves[0], 1) + np.roll(halves[1], -1)) / 2.0


def _sinusoid(values: NDArray[Any]) -> NDArray[Any]:
    """The mean and the first harmonic of values at the eight directions, over all directions."""
    first = np.fft.fft(values)[1] / 4.0
    return np.mean(values) + np.abs(first) * np.cos(FINE + np.angle(first))


def _draw_halves(
    axes: Axes, memory: NDArray[Any], turned_deg: float, home: float, title: tuple[str, str], *, with_mean: bool = False
) -> None:
    """Both halves of the memory, the right one turned clockwise by an angle and the left one anticlockwise."""
    once_more = [*range(8), 0]  # 0° again, as 360°
    columns = round(turned_deg / 45.0)
    readers = {"right": "of left-turning CPU1", "left": "of right-turning CPU1"}
    for half, name in enumerate(HALVES):
        turned = np.roll(memory[half], columns if name == "right" else -columns)
        beneath = half == 1 and columns == 0  # where both lie on each other
        line: dict[str, Any] = {"color": COLOURS[HALF_COLOURS[name]], "zorder": 3 + half}
        label = readers[name] if columns < 0 else f"{name} half"
        axes.plot(np.degrees(FINE), _sinusoid(turned), linestyle="--" if beneath else "-", **line)
        size = 2.5 if beneath else 4.5
        axes.plot(np.arange(0, 361, 45), turned[once_more], "o", markersize=size, label=label, **line)
    if with_mean:
        mean = _sinusoid(_aligned(memory))
        axes.plot(np.degrees(FINE), mean, color=COLOURS["grey"], linestyle="--", label="mean", zorder=6)
    where = float(np.degrees(home)) % 360.0
    axes.plot([where, where], [0.0, 0.75], transform=axes.get_xaxis_transform(), color="black", lw=0.7, linestyle=":")
    axes.text(where, 0.76, "home", transform=axes.get_xaxis_transform(), ha="center", va="bottom", fontsize=6)
    low, high = min(_sinusoid(memory[0]).min(), memory.min()), memory.max()
    axes.set_ylim(low - 0.05 * (high - low), high + 0.6 * (high - low))
    name_panel(axes, *title)
    axes.set_xticks(np.arange(0, 361, 90))
    axes.legend(loc="upper left", ncols=1 if columns < 0 else 2, columnspacing=1.0, handletextpad=0.4)


def _draw_facings(axes: Axes, home: float, shown: Mapping[str, float]) -> None:
    """The numbered facing directions as green lines."""
    for name in (name for name in shown if name.isdigit()):
        facing = float(np.degrees(wrap(home - np.radians(shown[name])))) % 360.0
        line: dict[str, Any] = {"color": COLOURS["green"], "linewidth": 1.0, "zorder": 1}
        axes.plot([facing, facing], [0.0, 0.66], transform=axes.get_xaxis_transform(), **line)
        words: dict[str, Any] = {"color": COLOURS["green"], "ha": "right", "va": "bottom", "fontsize": 8}
        axes.text(facing, 0.66, f"{name} ", transform=axes.get_xaxis_transform(), **words)


def _draw_ratios(axes: Axes, row: Mapping[str, Any], shown: Mapping[str, float]) -> None:
    """Activity of right-turning over left-turning CPU1 in the numbered facing directions."""
    names = [name for name in shown if name.isdigit()]
    axes.bar(np.arange(len(names)), [row[f"right_over_left_{name}"] for name in names], color=COLOURS["green"])
    axes.axhline(1.0, color="black", linewidth=0.6, linestyle=":")
    axes.set_xticks(np.arange(len(names)), names)
    axes.set_xlabel("facing")
    axes.set_ylabel("CPU1, right / left")


def _draw_turns(axes: Axes, results: Results, facings: NDArray[Any]) -> None:
    """Turn against the direction of home, for both sets of constants."""
    order: Sequence[int] = [*range(len(facings)), 0]  # −180° once more, as 180°
    angle = np.append(np.degrees(facings), 180.0)
    for preset in PRESETS:
        index = results.only(preset=preset)
        turn = np.degrees(results["turn"][index].astype(float))[order]
        colour = COLOURS[PRESET_COLOURS[preset]]
        quiet = np.degrees(results["turn_without_noise"][index])[order]
        axes.plot(angle, quiet, color=colour, linewidth=0.8)
        bars: dict[str, Any] = {
            "fmt": "o",
            "markersize": 2.5,
            "elinewidth": 0.6,
            "color": colour,
            "label": PRESET_NAMES[preset],
        }
        axes.errorbar(angle, turn.mean(axis=1), turn.std(axis=1, ddof=1), **bars)
    axes.axhline(0.0, color="black", linewidth=0.6, linestyle=":")
    axes.axvline(0.0, color="black", linewidth=0.6, linestyle=":")
    name_panel(axes, "g", "steering")
    axes.set_xlabel("home relative to facing (deg)")
    axes.set_ylabel("turn in a step (deg), right positive")
    axes.set_ylim(-55.0, 75.0)
    axes.set_xticks(np.arange(-180, 181, 90))
    axes.legend(loc="upper left")
