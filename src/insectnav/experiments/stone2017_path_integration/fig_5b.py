"""Fig. 5b: activity of every cell over the trip of Fig. 5a, and how it builds up over trips out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.agents.motion import MotionParams
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.agents.simulation import TrialParams, simulate_trials
from insectnav.agents.trials import split_recorded
from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.activity_picture import LABELS, N_COLUMNS, draw_activity, draw_rate_scale
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS, PRESET_NAMES, example_trip
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 5b"
TITLE = "activity of all cells over a trip out and the way home"
NOISE = 0.1  # Fig. 5b
WINDOW = 50  # [steps] over which rates are averaged
PART = 128  # trials at a time: the activity of a trip out is 200 kB
BUILD_UP = {"cpu4": "CPU4", "pontine": "pontine"}
BUILD_UP_COLOURS = {"cpu4": "blue", "pontine": "orange"}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One set of constants."""

    preset: str
    n_trials: int = 1000  # trips over which the build-up is measured
    n_inbound: int = N_STEPS  # of the trip that is shown


def grid(scale: str) -> Sequence[Cell]:
    """Both sets of constants."""
    n_trials = 1000 if scale == "full" else 128
    return [Cell(preset=preset, n_trials=n_trials) for preset in PRESETS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Activity of all cells over one trip; mean rate and height of the pattern along many trips out."""
    circuit = circuit_params(preset=cell.preset)
    settings: dict[str, Any] = {"circuit": circuit, "motion": MotionParams(), "noise": NOISE, "seed": seed}
    params = TrialParams(**settings, n_inbound=cell.n_inbound, record=tuple(LABELS))
    trip = simulate_trials(*example_trip(seed), np.arange(1), params)
    activity = split_recorded(trip.activity[0], params.recorded)
    arrays: dict[str, tuple] = {
        f"activity_{name}": (("step", f"{name}_cell"), cells) for name, cells in activity.items()
    }
    settings |= {"n_inbound": 0, "record": tuple(BUILD_UP), "keep_paths": False}
    parts = [_build_up(cell, seed, first, TrialParams(**settings)) for first in range(0, cell.n_trials, PART)]
    for name in parts[0]:
        dimensions = ("trial",) if name == "mean_drive" else ("trial", "window")
        arrays[name] = (dimensions, np.concatenate([part[name] for part in parts]))
    return arrays


def _build_up(cell: Cell, seed: int, first: int, params: TrialParams) -> dict[str, np.ndarray]:
    """Mean rate and height of the pattern of CPU4 and pontine cells, (trial, window), and the memory's mean gain."""
    trials = np.arange(first, min(first + PART, cell.n_trials))
    heading, velocity = route_arrays(len(trials), N_STEPS, RouteParams(), seed, "float32", first_trial=first)
    trips = simulate_trials(heading, velocity, trials, params)
    # In units of the gain h: what the memory of a cell gains in a step before the loss, on average.
    gained = (trips.memory_at_turn.mean(axis=1, dtype=float) - params.circuit.memory_start) / N_STEPS
    values = {"mean_drive": (gained / params.circuit.memory_gain + params.circuit.memory_loss).astype(np.float32)}
    for name, rates in split_recorded(trips.activity, params.recorded).items():
        windows = rates.reshape(len(rates), -1, WINDOW, rates.shape[-1]).mean(axis=2, dtype=float)
        values[f"mean_rate_{name}"] = windows.mean(axis=-1).astype(np.float32)
        values[f"pattern_{name}"] = pattern_height(windows).astype(np.float32)
    return values


def pattern_height(rates: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """Amplitude of the sinusoid that lies over the eight columns, the mean of both halves, (...).

    Parameters
    ----------
    rates : (..., 16) array

    Notes
    -----
    ``|Σ_j r_j exp(−i j 45°)| / 4``, which is A for r_j = B + A cos(j 45° − φ).
    """
    halves = np.asarray(rates).reshape(*np.shape(rates)[:-1], 2, 8)
    return np.abs(np.fft.fft(halves, axis=-1)[..., 1]).mean(axis=-1) / 4.0


def summarise(results: Results) -> Table:
    """Rates at the start and at the end of trips out, and how often they have grown."""
    rows = []
    for cell, arrays in results:
        for name in BUILD_UP:
            rate, pattern = arrays[f"mean_rate_{name}"].astype(float), arrays[f"pattern_{name}"].astype(float)
            rows.append(
                {
                    "preset": cell.preset,
                    "population": name,
                    **_growth("mean_rate", rate),
                    **_growth("pattern", pattern),
                    "mean_drive": float(arrays["mean_drive"].mean(dtype=float)),
                    "n": len(rate),
                }
            )
    return rows


def _growth(name: str, values: NDArray[Any]) -> dict[str, float]:
    """First and last window of (trial, window), the mean of the ratio of the two means, and how often it grew."""
    start, end = values[:, 0], values[:, -1]
    return {
        f"{name}_start": float(start.mean()),
        f"{name}_turn": float(end.mean()),
        f"{name}_turn_over_start": float(end.mean() / start.mean()),
        f"{name}_turn_over_start_standard_error": bootstrap_error(end / start.mean(), np.mean),
        f"{name}_share_of_trips_grown": float(np.mean(end > start)),
    }


def draw(results: Results) -> Figure:
    """Activity of all cells under both sets of constants; below, what builds up over many trips out."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 6.3), layout="constrained")
    spec = figure.add_gridspec(2, 3, height_ratios=(3.2, 1.0), width_ratios=(1.0, 1.0, 0.035))
    image, previous = None, None
    for column, (cell, arrays) in enumerate(results):
        axes = figure.add_subplot(spec[0, column])
        image = draw_activity(axes, {name: arrays[f"activity_{name}"] for name in LABELS}, n_outbound=N_STEPS)
        axes.set_title(PRESET_NAMES[cell.preset], loc="left", pad=10.0)
        previous = figure.add_subplot(spec[1, column], sharex=previous, sharey=previous)
        _draw_build_up(previous, arrays, with_legend=column == 0)
    if image is not None:
        draw_rate_scale(figure.add_subplot(spec[0, 2]), image)
    return figure


def _draw_build_up(axes: Axes, arrays: Mapping[str, np.ndarray], *, with_legend: bool) -> None:
    """Mean ± SD over trips of the mean rate and of the height of the pattern, against time."""
    n_windows = arrays["mean_rate_cpu4"].shape[1]
    time = (np.arange(n_windows) + 0.5) * WINDOW
    for name, label in BUILD_UP.items():
        for measure, dashes, words in (("mean_rate", (0, (4, 1.5)), "mean rate"), ("pattern", "-", "pattern height")):
            values = arrays[f"{measure}_{name}"].astype(float)
            mean, sd = values.mean(axis=0), values.std(axis=0, ddof=1)
            colour = COLOURS[BUILD_UP_COLOURS[name]]
            axes.fill_between(time, mean - sd, mean + sd, color=colour, alpha=0.18, linewidth=0.0)
            axes.plot(time, mean, color=colour, linestyle=dashes, label=f"{label}, {words}")
    axes.set_xlim(0.0, n_windows * WINDOW)
    axes.set_ylim(0.0, 0.75)
    axes.set_xlabel("time of the trip out (steps)")
    if with_legend:
        axes.set_ylabel("rate")
        axes.legend(loc="upper left", ncols=2)


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    cell = results.cells[0]
    return (
        f"Top: activity of all cells over the trip of Fig. 5a, {N_STEPS} steps out and {cell.n_inbound} home, noise "
        f"{NOISE:g}; a row for each cell, rates divided by the highest of their population, averaged over "
        f"{-(-(N_STEPS + cell.n_inbound) // N_COLUMNS)} steps a dot. Memory is the charge of the CPU4 cells. Bottom: "
        "mean rate of CPU4 and pontine cells, and height of the sinusoid that lies over their columns, in windows of "
        f"{WINDOW} steps along n = {cell.n_trials} random trips out (mean and SD over trips)."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Whether activity grows along the trip out, as the text predicts, under both sets of constants."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities are named "<measure> of <population>, turn over start, <constants>"."""
    what, _, constants = value.quantity.split(", ")
    preset = next(preset for preset, name in PRESET_NAMES.items() if name == constants)
    label, _, population = what.rpartition(" of ")
    measure = {"mean rate": "mean_rate", "height of the pattern": "pattern"}[label]
    cells = {label: name for name, label in BUILD_UP.items()}[population]
    row = next(row for row in table if (row["preset"], row["population"]) == (preset, cells))
    why = (
        f"the mean goes from {row['mean_rate_start']:.3f} to {row['mean_rate_turn']:.3f}: in a step the memory gains "
        f"{row['mean_drive']:.3f} h and loses {circuit_params(preset=preset).memory_loss:g} h on average; it grows in "
        f"{100.0 * row['mean_rate_share_of_trips_grown']:.0f} % of the trips, and the height of the pattern over the "
        f"columns {row['pattern_turn_over_start']:.1f} times"
    )
    ours, error = row[f"{measure}_turn_over_start"], row[f"{measure}_turn_over_start_standard_error"]
    return judge(value, ours, error, why=why)
