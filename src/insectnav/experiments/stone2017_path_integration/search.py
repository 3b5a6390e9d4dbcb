"""Text: the search round the nest that emerges where nothing tells the agent to stop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.angles import bearing, wrap
from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import (
    HOME_RANGE,
    N_STEPS,
    NOISE_COLOURS,
    NOISE_LEVELS,
    PRESET_NAMES,
    draw_home_range,
    random_trips,
    ways_home,
)
from insectnav.metrics.path_integration import summary
from insectnav.metrics.polarisation_tuning import rayleigh_test
from insectnav.metrics.search import NEVER, Loops, first_arrival, homeward_turn, search_centre, search_loops, searching
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "text"
TITLE = "search round the nest when nothing tells the agent to stop"
FAR = 2.0 * HOME_RANGE  # [steps] a loop leaves the home range by at least its own radius
WINDOW = 500  # [steps] distances are summarised over
MAX_LOOPS = 12  # kept of each trial
THIRD = 2  # loop whose direction is tested: the first ones still overshoot along the way home
BIN_EDGES = np.array([0.0, 10.0, 20.0, 30.0, 40.0, 60.0, 80.0, 120.0])  # [steps]
PRESETS_OWN = 0.0  # motor gain: that of the set of constants
QUICKER_GAIN = 0.5  # [rad] of the thesis, also tried in the 2017 code's circuit
DRAWN_NOISE = 0.1  # of the example and of the comparison: the default of the paper


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One noise level under one set of constants."""

    preset: str
    noise: float
    n_trials: int
    n_inbound: int = 6000
    motor_gain: float = PRESETS_OWN  # [rad]


def grid(scale: str) -> Sequence[Cell]:
    """All noise levels under both sets of constants, and the 2017 code's circuit with a quicker turn."""
    n_trials = 400 if scale == "full" else 60
    cells = [Cell(preset=preset, noise=noise, n_trials=n_trials) for preset in PRESETS for noise in NOISE_LEVELS]
    return [*cells, Cell(preset="code-2017", noise=DRAWN_NOISE, n_trials=n_trials, motor_gain=QUICKER_GAIN)]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Arrival, centre, loops and turns of each trial's search, and the path of the first trial."""
    circuit = circuit_params(preset=cell.preset)
    if cell.motor_gain != PRESETS_OWN:
        circuit = replace(circuit, motor_gain=cell.motor_gain)
    arrays = random_trips(cell.n_trials, circuit, noise=cell.noise, seed=seed, n_inbound=cell.n_inbound)
    path = ways_home(arrays, cell.n_inbound)
    arrival = first_arrival(path, HOME_RANGE)
    centre = search_centre(path, arrival)
    is_search = searching(path.shape[1], arrival)
    round_centre = np.where(is_search[..., None], path - centre[:, None], np.inf)
    loops = search_loops(round_centre, HOME_RANGE, FAR)
    direction, reach = _first_loops(loops, bearing(-path[:, 0]))
    turns = np.array([homeward_turn(p[None], BIN_EDGES, w[None]) for p, w in zip(path, is_search, strict=True)])
    return {
        "arrival": (("trial",), arrival, {"long_name": "first step in the home range, -1 for never"}),
        "centre": (("trial", "xy"), centre, {"units": "steps"}),
        "n_loops": (("trial",), np.bincount(loops.trial, minlength=cell.n_trials)),
        "loop_direction": (("trial", "loop"), direction, {"units": "rad", "zero": "course from turning point to nest"}),
        "loop_reach": (("trial", "loop"), reach, {"units": "steps"}),
        "homeward_turn": (("trial", "bin"), turns, {"units": "rad per step"}),
        "distance": (("trial", "window"), _distance_since(path, arrival), {"units": "steps"}),
        "path": (("step", "xy"), path[0].astype(np.float32), {"units": "steps"}),
    }


def _first_loops(loops: Loops, course_home: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions from the course home and reaches, (trial, loop), NaN where a trial has fewer loops."""
    number = np.arange(loops.trial.size) - np.searchsorted(loops.trial, loops.trial)
    is_kept = number < MAX_LOOPS
    place = loops.trial[is_kept], number[is_kept]
    direction, reach = np.full((2, course_home.size, MAX_LOOPS), np.nan)
    direction[place] = wrap(loops.direction - course_home[loops.trial])[is_kept]
    reach[place] = loops.reach[is_kept]
    return direction, reach


def _distance_since(path: np.ndarray, arrival: np.ndarray) -> np.ndarray:
    """Mean distance from the nest in each window since arrival, (trial, window); NaN where the path ends before."""
    distance = np.linalg.norm(path, axis=-1)
    n_windows = (path.shape[1] - 1) // WINDOW
    means = np.full((len(path), n_windows), np.nan)
    for trial, first in enumerate(arrival):
        if first != NEVER:
            whole = distance[trial, first:][: (path.shape[1] - first) // WINDOW * WINDOW].reshape(-1, WINDOW)
            means[trial, : len(whole)] = whole.mean(axis=1)[:n_windows]
    return means


def summarise(results: Results) -> Table:
    """How many come home, where and how they search."""
    return [_row(cell, arrays) for cell, arrays in results]


def _row(cell: Cell, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    has_arrived = arrays["arrival"] != NEVER
    offset = np.linalg.norm(arrays["centre"], axis=-1)
    third = _finite(arrays["loop_direction"][:, THIRD])
    between = _finite(wrap(np.diff(arrays["loop_direction"], axis=1)))
    turns = np.degrees(arrays["homeward_turn"])
    near, far = turns[:, BIN_EDGES[:-1] < HOME_RANGE], turns[:, BIN_EDGES[:-1] >= FAR]
    contrast = _row_mean(far) - _row_mean(near)
    return {
        "preset": cell.preset,
        "noise": cell.noise,
        "motor_gain": cell.motor_gain or circuit_params(preset=cell.preset).motor_gain,
        "n": cell.n_trials,
        "arrived": float(has_arrived.mean()),
        "median_centre_offset": summary(offset).median,
        "centre_offset_standard_error": bootstrap_error(offset, np.median),
        "median_loops": summary(arrays["n_loops"][has_arrived]).median,
        "loops_standard_error": bootstrap_error(arrays["n_loops"][has_arrived], np.median),
        "median_reach": summary(arrays["loop_reach"]).median,
        "third_loop_resultant": _resultant(third),
        "third_loop_p_value": float(rayleigh_test(third, axial=False).p_value) if third.size > 2 else np.nan,
        "third_loop_n": third.size,
        "successive_resultant": _resultant(between),
        "successive_angle_deg": float(np.degrees(np.angle(np.exp(1j * between).sum()))) if between.size else np.nan,
        "successive_n": between.size,
        "turn_contrast_deg": summary(contrast).mean,
        "turn_contrast_standard_error_deg": summary(contrast).sd / np.sqrt(max(1, summary(contrast).n)),
        "median_distance_at_first": summary(arrays["distance"][:, 0]).median,
        "median_distance_at_last": summary(arrays["distance"][:, -3]).median,
    }


def _finite(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _row_mean(values: np.ndarray) -> np.ndarray:
    """Mean of the finite values of each row; NaN for a row without any."""
    is_finite = np.isfinite(values)
    n = is_finite.sum(axis=1)
    return np.divide(np.sum(values, axis=1, where=is_finite), n, out=np.full(len(n), np.nan), where=n > 0)


def _resultant(angles: np.ndarray) -> float:
    return float(np.abs(np.exp(1j * angles).mean())) if angles.size else float("nan")


def draw(results: Results) -> Figure:
    """Two searches, directions of loops, distance since arrival and turns towards home."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 5.0), layout="constrained")
    places = figure.add_gridspec(2, 6, height_ratios=(1.0, 0.95))
    presets = list(results.by("preset"))
    for column, preset in enumerate(presets):
        axes = figure.add_subplot(places[0, 2 * column : 2 * column + 2])
        _draw_path(axes, results["path"][_drawn(results, preset)])
        name_panel(axes, "ab"[column], PRESET_NAMES[preset])
    _draw_directions(figure.add_subplot(places[0, 4:]), results)
    late = figure.add_subplot(places[1, :3])
    turns = figure.add_subplot(places[1, 3:])
    _draw_distance(late, results)
    _draw_turns(turns, results)
    return figure


def _drawn(results: Results, preset: str) -> int:
    return results.only(preset=preset, noise=DRAWN_NOISE, motor_gain=PRESETS_OWN)


def _draw_path(axes: Axes, path: np.ndarray) -> None:
    """The way home in grey, then the search, each third of it in a colour."""
    arrival = int(first_arrival(path[None], HOME_RANGE)[0])
    axes.plot(*path[: arrival + 1].T, color=COLOURS["grey"], linewidth=0.7, label="way home")
    thirds = np.array_split(np.arange(arrival, len(path)), 3)
    for part, name, label in zip(thirds, ("sky", "blue", "black"), ("search, first", "second", "last"), strict=True):
        axes.plot(*path[part].T, color=COLOURS[name], linewidth=0.6, label=f"{label} third")
    draw_home_range(axes)
    axes.set_aspect("equal", adjustable="box")
    low, high = path[arrival:].min(axis=0), path[arrival:].max(axis=0)
    middle, half = (low + high) / 2.0, 0.62 * (high - low).max()
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + 1.35 * half)
    axes.legend(loc="upper left", ncols=2, columnspacing=0.8, handlelength=1.0)


def _draw_directions(axes: Axes, results: Results) -> None:
    """Share of the third loops in each bin of direction, from the course home."""
    edges = np.linspace(-180.0, 180.0, 13)
    for preset, name in zip(results.by("preset"), ("black", "orange"), strict=False):
        directions = results["loop_direction"][_drawn(results, preset)][:, THIRD]
        angles = np.degrees(_finite(directions))
        share = 100.0 * np.histogram(angles, edges)[0] / max(1, angles.size)
        label = f"{PRESET_NAMES[preset]} (n = {angles.size})"
        axes.stairs(share, edges, color=COLOURS[name], linewidth=1.0, label=label)
    axes.axhline(100.0 / 12.0, color=COLOURS["grey"], linestyle=":", linewidth=0.7, label="no preference")
    axes.set_xticks(np.arange(-180, 181, 90))
    axes.set_ylim(0.0, 25.0)
    axes.set_xlabel("third loop from course home (deg)")
    axes.set_ylabel("trials (% in a bin of 30°)")
    name_panel(axes, "c")
    axes.legend(loc="upper left")


def _own(results: Results) -> list[Any]:
    """Cells whose constants are those of their set."""
    return [(cell, arrays) for cell, arrays in results if cell.motor_gain == PRESETS_OWN]


def _draw_distance(axes: Axes, results: Results) -> None:
    for cell, arrays in _own(results):
        middle = np.array([summary(column).median for column in arrays["distance"].T])
        has_enough = np.isfinite(arrays["distance"]).sum(axis=0) >= max(3, cell.n_trials // 3)
        time = (np.arange(middle.size) + 0.5) * WINDOW
        style = "-" if cell.preset == results.cells[0].preset else "--"
        label = f"{cell.noise:g}" if style == "-" else None
        axes.plot(time[has_enough], middle[has_enough], style, color=COLOURS[NOISE_COLOURS[cell.noise]], label=label)
    axes.axhline(HOME_RANGE, color=COLOURS["grey"], linestyle=":", linewidth=0.7)
    axes.set_yscale("log")
    axes.set_xlabel("time since arrival (steps)")
    axes.set_ylabel("median distance from the nest (steps)")
    name_panel(axes, "d")
    axes.legend(title="noise $\\sigma_r$", ncols=5, loc="upper left")
    axes.set_ylim(10.0, 1500.0)


def _draw_turns(axes: Axes, results: Results) -> None:
    middles = (BIN_EDGES[:-1] + BIN_EDGES[1:]) / 2.0
    for cell, arrays in _own(results):
        turns = np.degrees(arrays["homeward_turn"])
        n = np.isfinite(turns).sum(axis=0)
        mean = np.array([summary(column).mean for column in turns.T])
        is_drawn = n >= max(3, cell.n_trials // 5)
        style = "-" if cell.preset == results.cells[0].preset else "--"
        axes.plot(middles[is_drawn], mean[is_drawn], style, marker="o", markersize=2.5,
                  color=COLOURS[NOISE_COLOURS[cell.noise]])  # fmt: skip
    names = list(results.by("preset"))
    for style, preset in zip(("-", "--"), names, strict=False):
        axes.plot([], [], style, color="black", label=PRESET_NAMES[preset])
    axes.axhline(0.0, color=COLOURS["grey"], linewidth=0.6)
    axes.set_xlabel("distance from the nest (steps)")
    axes.set_ylabel("turn towards the nest (deg per step)")
    name_panel(axes, "e")
    axes.legend(loc="upper left")


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    cell = results.cells[0]
    quiet = results.only(preset="code-2017", noise=0.0, motor_gain=PRESETS_OWN)
    overshoot = summary(results["loop_reach"][quiet][:, 0]).median
    return (
        f"Search after a random trip of {N_STEPS} steps, in {cell.n_inbound} steps with the circuit steering. a, b, "
        f"One trial under each set of constants (noise {DRAWN_NOISE:g}); dashed: the home range of {HOME_RANGE:g} "
        "steps. c, Direction in which the third loop goes from the centre of the search, from the course home, at "
        f"noise {DRAWN_NOISE:g}; a loop leaves the {HOME_RANGE:g} steps round that centre and goes {FAR:g} steps or "
        f"farther. d, Distance from the nest in windows of {WINDOW} steps since the first step in the home range. "
        "Without noise and under the 2017 code's constants agents first fly far past the nest: their first loops reach "
        f"{overshoot:.0f} steps (median). "
        f"e, Mean turn to the side on which the nest lies. Colours as in d; n = {cell.n_trials} trials for each line, "
        "less those that have not come home by then."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The words of the paper on the search, at its default noise, under both sets of constants."""
    columns = {
        "closed loops": ("median_loops", "loops_standard_error"),
        "distance of the centre of the search from the nest": ("median_centre_offset", "centre_offset_standard_error"),
        "turn towards the nest, far minus near": ("turn_contrast_deg", "turn_contrast_standard_error_deg"),
    }
    resultants = {
        "resultant of third loops' directions": ("third_loop_resultant", "third_loop_n"),
        "resultant of angles between successive loops": ("successive_resultant", "successive_n"),
    }
    verdicts = []
    for name, value in published.items():
        quantity, _, preset = name.rpartition(", ")
        rows = [row for row in table if row["preset"] == preset and row["noise"] == DRAWN_NOISE]
        if quantity in columns:
            ours, error = columns[quantity]
            verdicts.append(judge(value, rows[0][ours], rows[0][error]))
        else:
            ours, n = resultants[quantity]
            why = _why(rows) if quantity.endswith("successive loops") else ""
            # Root mean square length of the resultant of n directions without any preference.
            verdicts.append(judge(value, rows[0][ours], float(1.0 / np.sqrt(max(1, rows[0][n]))), why=why))
    return verdicts


def _why(rows: Sequence[Mapping[str, Any]]) -> str:
    own, quicker = rows[0], rows[-1]
    return (
        f"successive loops lie {abs(own['successive_angle_deg']):.0f} deg apart on average: an agent that comes back "
        "from one loop overshoots and begins the next on the other side; with a motor gain "
        f"of {quicker['motor_gain']:g} in place of {own['motor_gain']:g} rad the resultant is "
        f"{quicker['successive_resultant']:.2f} in place of {own['successive_resultant']:.2f}; third loops, taken over "
        f"trials, show no preference (Rayleigh p = {own['third_loop_p_value']:.2f})"
    )
