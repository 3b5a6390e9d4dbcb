"""Extended Data Fig. 9b–d: very long routes, very fast ones, and a speed signal that lags."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.perturbations import FilterSpeed, ScaleSpeed
from insectnav.angles import circular_std
from insectnav.central_complex import PRESETS, CircuitParams, circuit_params, decode_home_vector
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import (
    N_STEPS,
    PRESET_NAMES,
    random_trips,
    ways_home,
)
from insectnav.metrics.path_integration import bearing_error, length_ratio, summary
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 9b–d"
TITLE = "homing after very long and very fast routes, and with a smoothed speed signal"
LENGTHS = (1500, 5000, 10000, 20000)  # [steps]
LONG = 10000  # [steps] the longest of Fig. 5c, and beyond the 5000 after which the memory saturates
SPEEDS = (1.0, 1.4, 1.8, 2.2, 2.6, 3.0)  # Ext. Data Fig. 9a
FAST = 2.2  # drawn
FILTERS = (1, 2, 5, 10, 20, 50)  # [steps] Ext. Data Fig. 9a
DRAWN_FILTER = 50
N_INBOUND = 3000  # [steps] enough to cover all ways home and begin to search
SETTLED = 500  # [steps] at the end of the way home, over which the place searched is averaged
N_PATHS, N_POINTS = 3, 300  # drawn
LIMIT = 1e-3  # a memory cell this close to 0 or 1 is saturated
LINES = {"thesis": ("black", "-", "o"), "code-2017": ("orange", "--", "s")}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One length, speed or filter under one set of constants."""

    panel: str
    preset: str
    n_trials: int
    noise: float = 0.1
    n_outbound: int = N_STEPS
    speed: float = 1.0
    filter_steps: int = 1


def grid(scale: str) -> Sequence[Cell]:
    """Lengths (b), speeds (c) and filters (d) under both sets of constants."""
    n_trials = 200 if scale == "full" else 40
    cells: list[Cell] = []
    for preset in PRESETS:
        b = Cell(panel="b", preset=preset, n_trials=n_trials)
        c, d = replace(b, panel="c"), replace(b, panel="d", noise=0.0)
        cells += [replace(b, n_outbound=length) for length in LENGTHS]
        cells += [replace(c, speed=speed) for speed in SPEEDS]
        cells += [replace(d, filter_steps=n) for n in FILTERS]
    return cells


def simulate(cell: Cell, seed: int) -> Arrays:
    """What the memory holds at the turning point, how far the agent then goes, and some of the paths."""
    circuit = circuit_params(preset=cell.preset)
    perturbations = (ScaleSpeed(factor=cell.speed), FilterSpeed(n_steps=cell.filter_steps))
    arrays = random_trips(
        cell.n_trials, circuit, noise=cell.noise, seed=seed, n_outbound=cell.n_outbound, n_inbound=N_INBOUND,
        perturbations=perturbations, record=("memory",),
    )  # fmt: skip
    home = ways_home(arrays, N_INBOUND)
    way = -home[:, 0]
    decoded = decode_home_vector(arrays.memory_at_turn, circuit)
    covered = home[:, -SETTLED:].mean(axis=1) - home[:, 0]
    memory = arrays.activity[:, : cell.n_outbound]
    is_full = (memory <= LIMIT) | (memory >= 1.0 - LIMIT)
    reference = _reference(cell, circuit, seed)
    track = -decode_home_vector(memory[:, :N_STEPS], circuit)
    return {
        "distance": (("trial",), np.linalg.norm(way, axis=-1), {"units": "steps"}),
        "decoded_over_true": (("trial",), length_ratio(decoded, way)),
        "bearing_error": (("trial",), bearing_error(decoded, way), {"units": "rad"}),
        "homed_over_true": (("trial",), np.sum(covered * way, axis=-1) / np.sum(way**2, axis=-1)),
        "ever_saturated": (("trial",), is_full.any(axis=(1, 2))),
        "saturated_at_turn": (("trial",), is_full[:, -1].mean(axis=1)),
        "memory_level": (("trial",), arrays.memory_at_turn.mean(axis=1)),
        "displaced": (("trial",), np.linalg.norm(track[:, -1] - reference, axis=-1), {"units": "steps"}),
        "out": (("path", "point", "xy"), _thinned(arrays.position[:N_PATHS, : cell.n_outbound]), {"units": "steps"}),
        "home": (("path", "point", "xy"), _thinned(home[:N_PATHS]), {"units": "steps"}),
        "true_track": (("point", "xy"), _thinned(arrays.position[0, :N_STEPS]), {"units": "steps"}),
        "decoded_track": (("point", "xy"), _thinned(track[0]), {"units": "steps"}),
    }


def _thinned(paths: np.ndarray) -> np.ndarray:
    """As many points of (..., step, 2) as are drawn, first and last among them."""
    points = np.linspace(0, paths.shape[-2] - 1, N_POINTS).round().astype(int)
    return paths[..., points, :].astype(np.float32)


def _reference(cell: Cell, circuit: CircuitParams, seed: int) -> np.ndarray:
    """Position (trial, 2) decoded after N_STEPS of the same routes without a filter; NaN but in panel d."""
    if cell.panel != "d":
        return np.full((cell.n_trials, 2), np.nan, np.float32)
    arrays = random_trips(cell.n_trials, circuit, noise=cell.noise, seed=seed, n_inbound=0)
    return -decode_home_vector(arrays.memory_at_turn, circuit)


def summarise(results: Results) -> Table:
    """Direction and length of what is decoded and of what is homed, and the lag."""
    return [_row(cell, arrays) for cell, arrays in results]


def _row(cell: Cell, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    row: dict[str, Any] = {
        "panel": cell.panel,
        "preset": cell.preset,
        "noise": cell.noise,
        "outbound_steps": cell.n_outbound,
        "speed": cell.speed,
        "filter_steps": cell.filter_steps,
        "n": cell.n_trials,
        "median_distance": summary(arrays["distance"]).median,
    }
    for name in ("decoded_over_true", "homed_over_true"):
        row[f"median_{name}"] = summary(arrays[name]).median
        row[f"{name}_standard_error"] = bootstrap_error(arrays[name], np.median)
    error = arrays["bearing_error"]
    return row | {
        "bearing_sd_deg": float(np.degrees(circular_std(error))),
        "bearing_sd_standard_error_deg": float(np.degrees(bootstrap_error(error, circular_std))),
        "median_absolute_bearing_error_deg": float(np.degrees(np.median(np.abs(error)))),
        "saturated_trials": float(np.mean(arrays["ever_saturated"])),
        "saturated_cells_at_turn": summary(arrays["saturated_at_turn"]).mean,
        "memory_level": summary(arrays["memory_level"]).mean,
        "median_displaced": summary(arrays["displaced"]).median,
        "displaced_standard_error": bootstrap_error(arrays["displaced"], np.median),
    }


def draw(results: Results) -> Figure:
    """Paths and decoded vectors for long routes and for fast ones, then the decoded track with a filter."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 6.9), layout="constrained")
    places = figure.add_gridspec(3, 6)
    shown: dict[str, dict[str, Any]] = {"b": {"n_outbound": LONG}, "c": {"speed": FAST}}
    words = {"b": f"{LONG} steps", "c": f"{FAST:g} × speed"}
    for row, (panel, wanted) in enumerate(shown.items()):
        for column, preset in enumerate(results.by("preset")):
            axes = figure.add_subplot(places[row, 2 * column : 2 * column + 2])
            _draw_paths(axes, results, results.only(panel=panel, preset=preset, **wanted))
            title = f"{words[panel]}, {preset} constants"
            if column == 0:
                name_panel(axes, panel, title)
            else:
                axes.set_title(title, loc="left")
            if row == column == 0:
                axes.legend(loc="best")
        stacked: Any = places[row, 4:].subgridspec(2, 1).subplots(sharex=True)
        ratio, error = stacked
        _draw_quartiles(ratio, results, panel, "decoded_over_true", np.asarray)
        ratio.axhline(1.0, color=COLOURS["grey"], linestyle=":", linewidth=0.7)
        ratio.set_ylim(0.0, 1.6)
        ratio.set_ylabel("decoded over\ntrue distance")
        _draw_quartiles(error, results, panel, "bearing_error", lambda angle: np.degrees(np.abs(angle)))
        error.set_ylim(bottom=0.0)
        error.set_ylabel("bearing error\n(deg)")
        error.set_xlabel("length of the route out (steps)" if panel == "b" else "speed (times the default)")
        if panel == "b":
            error.legend(loc="upper left")
    for column, coordinate in enumerate("xy"):
        _draw_track(figure.add_subplot(places[2, 2 * column : 2 * column + 2]), results, column, coordinate)
    displaced = figure.add_subplot(places[2, 4:])
    _draw_quartiles(displaced, results, "d", "displaced", np.asarray)
    displaced.set_xlabel("length of the filter (steps)")
    displaced.set_ylabel("displacement of\ndecoded position (steps)")
    return figure


def _draw_paths(axes: Axes, results: Results, index: int) -> None:
    for path, name in enumerate(("blue", "red", "green")[:N_PATHS]):
        label = {"out": "out", "home": "home"} if path == 0 else {}
        axes.plot(*results["out"][index][path].T, color=COLOURS[name], linewidth=0.4, alpha=0.5, label=label.get("out"))
        axes.plot(*results["home"][index][path].T, color=COLOURS[name], linewidth=1.1, label=label.get("home"))
        axes.plot(*results["home"][index][path][0], marker="x", color=COLOURS[name], markersize=4)
    axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", markersize=3.5, linestyle="none", zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (steps)")
    axes.set_ylabel("y (steps)")


def _draw_quartiles(
    axes: Axes, results: Results, panel: str, name: str, convert: Callable[[np.ndarray], np.ndarray]
) -> None:
    """Median and quartiles of an array of all trials against what is varied."""
    varied = {"b": "n_outbound", "c": "speed", "d": "filter_steps"}[panel]
    for preset, (colour, line, marker) in LINES.items():
        cells = results.where(panel=panel, preset=preset)
        over = [getattr(results.cells[i], varied) for i in cells]
        low, middle, high = np.percentile(convert(results[name][cells]), [25.0, 50.0, 75.0], axis=1)
        axes.errorbar(over, middle, (middle - low, high - middle), color=COLOURS[colour], linestyle=line,
                      marker=marker, markersize=3, capsize=2, label=PRESET_NAMES[preset])  # fmt: skip


def _draw_track(axes: Axes, results: Results, column: int, coordinate: str) -> None:
    """One coordinate of the true and of the decoded position over time."""
    time = np.linspace(0, N_STEPS - 1, N_POINTS)
    plain, filtered = (results.only(panel="d", preset="thesis", filter_steps=n) for n in (1, DRAWN_FILTER))
    axes.plot(time, results["true_track"][plain][:, column], color=COLOURS["grey"], linewidth=2.0, label="true")
    axes.plot(time, results["decoded_track"][plain][:, column], color=COLOURS["blue"], label="decoded")
    axes.plot(time, results["decoded_track"][filtered][:, column], color=COLOURS["red"], linestyle="--",
              label=f"decoded, filter of {DRAWN_FILTER} steps")  # fmt: skip
    axes.set_xlabel("time (steps)")
    axes.set_ylabel(f"{coordinate} (steps)")
    if column == 0:
        name_panel(axes, "d")
        axes.legend(loc="best")


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    n = results.cells[0].n_trials
    return (
        f"b, Routes of {LONG} steps: three of them, out (thin) and {N_INBOUND} steps home (thick) from the crosses to "
        "the nest (circle); right, distance in the memory at the turning point over the true one, and size of the "
        f"error of its bearing (median and quartiles, n = {n} trials each). c, The same for routes of {N_STEPS} "
        f"steps, paths at {FAST:g} times the default speed. Noise 0.1 in b and c. d, Position of one trial over time, "
        f"true and as decoded from the memory, without and with a moving average of {DRAWN_FILTER} steps of the speed "
        "signal (thesis constants, no noise); right, distance between the positions decoded at the turning point "
        f"with and without the filter (median and quartiles, n = {n})."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The words of the legend, under both sets of constants."""
    columns = {
        "decoded over true distance": ("median_decoded_over_true", "decoded_over_true_standard_error"),
        "distance homed over true distance": ("median_homed_over_true", "homed_over_true_standard_error"),
        "circular SD of decoded bearing": ("bearing_sd_deg", "bearing_sd_standard_error_deg"),
    }
    verdicts = []
    for name, value in published.items():
        quantity, condition, preset = name.split(", ")
        rows = [row for row in table if row["preset"] == preset]
        row = next(row for row in rows if _is_of(row, condition))
        if quantity == "displacement of decoded position":
            no_number = f"one example without a number; ours is displaced by {row['median_displaced']:.0f} steps"
            verdicts.append(judge(value, row["median_displaced"], not_comparable=no_number))
        elif quantity == "trials with saturated memory cells":
            share = row["saturated_trials"]
            verdicts.append(judge(value, share, float(np.sqrt(share * (1 - share) / row["n"]))))
        else:
            ours, error = columns[quantity]
            verdicts.append(judge(value, row[ours], row[error], why=_why(row)))
    return verdicts


def _is_of(row: Mapping[str, Any], condition: str) -> bool:
    number, _, unit = condition.partition(" ")
    column, panel = {"steps": ("outbound_steps", "b"), "x": ("speed", "c"), "filter": ("filter_steps", "d")}[unit]
    return bool(row["panel"] == panel and row[column] == float(number))


def _why(row: Mapping[str, Any]) -> str:
    return (
        f"memory cells hold {row['memory_level']:.2f} on average at the turning point, where "
        f"{row['saturated_cells_at_turn']:.0%} of them are at 0 or 1 (in {row['saturated_trials']:.0%} of the trials "
        "some are at some time): what a step adds no longer balances the loss of "
        f"{circuit_params(preset=row['preset']).memory_loss:g}, and the pattern is clipped away; the median size of "
        f"the bearing error is {row['median_absolute_bearing_error_deg']:.0f} deg"
    )
