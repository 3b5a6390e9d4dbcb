"""Stored vectors: to a feeder, home, from one feeder to another, and two in sequence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.agents.perturbations import SetMemory
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.central_complex import PRESETS, CircuitParams, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.columns import (
    circular_columns,
    mean_columns,
    median_columns,
    share_columns,
)
from insectnav.experiments.stone2017_path_integration.straight_flights import Route, fly, straight_flight
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, N_STEPS, PRESET_NAMES
from insectnav.metrics.path_integration import departure_error
from insectnav.metrics.straightness import distance_left, tortuosity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "text: Supplementary Notes"
TITLE = "stored vectors: to a feeder, home, and by a shortcut"
TASKS = {
    "outward": "nest to feeder A",
    "homebound": "feeder A to nest",
    "shortcut": "feeder A to feeder B",
    "sequence": "A + B to nest",
}
NOISES = (0.0, 0.1)
N_SHOWN = 4
SHOWN = 0  # of these, in the figure
SHOWN_EVERY = 5  # [steps]
LONGEST = 60.0  # [steps] closest distance in the figure
N_POINTS = 20  # of the straight line from A to B that are held against the known routes


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One use of stored vectors."""

    preset: str
    noise: float
    task: str  # of TASKS
    n_trials: int = 1000


class Feeder(NamedTuple):
    """A place at the end of a random trip, and what the memory held there."""

    route: Route
    path: NDArray[np.floating]  # (trial, step, 2) [steps]
    memory: NDArray[np.floating]  # (trial, 16)

    @property
    def place(self) -> NDArray[np.float64]:
        """(trial, 2) [steps] from the nest."""
        return self.path[:, -1].astype(float)


def grid(scale: str) -> Sequence[Cell]:
    """All uses, without noise and with, under both sets of constants."""
    n_trials = 1000 if scale == "full" else 100
    return [
        Cell(preset=preset, noise=noise, task=task, n_trials=n_trials)
        for preset in PRESETS
        for noise in NOISES
        for task in TASKS
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """How the agent goes to its goal, and how near it comes within 1500 steps."""
    circuit = circuit_params(preset=cell.preset)
    a = find_feeder(cell.n_trials, circuit, cell.noise, seed, first_trial=0)
    b = find_feeder(cell.n_trials, circuit, cell.noise, seed, first_trial=cell.n_trials)
    path, goal = fly_to_goal(cell, circuit, a, b, seed)
    to_goal = path - goal[:, None]
    shown = slice(0, N_SHOWN)
    steps = {"units": "steps"}
    return {
        "distance": (("trial",), np.linalg.norm(to_goal[:, 0], axis=-1), steps),
        "closest_distance": (("trial",), np.linalg.norm(to_goal, axis=-1).min(axis=1), steps),
        "course_error": (("trial",), np.degrees(departure_error(to_goal, HOME_RANGE)), {"units": "deg"}),
        "distance_left": (("trial",), distance_left(to_goal)),
        "unvisited": (("trial",), unvisited_share(path[:, 0], goal, a, b)),
        "goal": (("shown", "xy"), goal[shown].astype(np.float32), steps),
        "path": (("shown", "point", "xy"), path[shown, ::SHOWN_EVERY].astype(np.float32), steps),
        "route_a": (("shown", "route_point", "xy"), a.path[shown, ::SHOWN_EVERY].astype(np.float32), steps),
        "route_b": (("shown", "route_point", "xy"), b.path[shown, ::SHOWN_EVERY].astype(np.float32), steps),
    }


def find_feeder(n_trials: int, circuit: CircuitParams, noise: float, seed: int, first_trial: int) -> Feeder:
    """A random trip of 1500 steps to a feeder, and the memory that is stored there.

    Parameters
    ----------
    n_trials : int
    circuit : CircuitParams
    noise : float
    seed, first_trial : int
        Routes and noise are those of trials first_trial, first_trial + 1, ...
    """
    route = route_arrays(n_trials, N_STEPS, RouteParams(), seed, "float32", first_trial=first_trial)
    trip = fly(route, circuit, noise=noise, seed=seed, first_trial=first_trial)
    return Feeder(route, trip.position, trip.memory_at_turn)


def fly_to_goal(
    cell: Cell, circuit: CircuitParams, a: Feeder, b: Feeder, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Paths (trial, step, 2) from where stored vectors are loaded, and goals (trial, 2), from the nest [steps].

    Parameters
    ----------
    cell : Cell
    circuit : CircuitParams
    a, b : Feeder
    seed : int

    Notes
    -----
    The agent at the nest has an even memory: a stored one with the other sign leads to the place where it was stored.
    At A the present memory less that of B is the vector from A to B. Added to an even memory, those of A and B are the
    way home from A + B. Stone et al. 2017, Supplementary Notes.
    """
    nest = np.zeros_like(a.place)
    if cell.task == "shortcut":
        trial = fly(
            a.route, circuit, n_inbound=N_STEPS, noise=cell.noise, seed=seed,
            perturbations=[SetMemory(memory=b.memory, step=N_STEPS, mode="subtract")],
        )  # fmt: skip
        return trial.position[:, N_STEPS - 1 :].astype(float), b.place
    start, goal, loads = {
        "outward": (nest, a.place, [SetMemory(memory=a.memory, mode="subtract")]),
        "homebound": (a.place, nest, [SetMemory(memory=a.memory, mode="add")]),
        "sequence": (
            a.place + b.place,
            nest,
            [SetMemory(memory=a.memory, mode="add"), SetMemory(memory=b.memory, mode="add")],
        ),
    }[cell.task]
    at_rest = straight_flight(np.zeros(cell.n_trials), 1, 0.0)
    trial = fly(
        at_rest, circuit, n_inbound=N_STEPS, noise=cell.noise, seed=seed,
        first_trial=2 * cell.n_trials, perturbations=loads,
    )  # fmt: skip
    return trial.position.astype(float) + start[:, None], goal


def unvisited_share(
    start: NDArray[np.floating], goal: NDArray[np.floating], a: Feeder, b: Feeder
) -> NDArray[np.float64]:
    """Share of the straight line from start to goal that lies 20 steps or more from both known routes, (trial,).

    Parameters
    ----------
    start, goal : (trial, 2) arrays [steps]
    a, b : Feeder
    """
    along = np.linspace(0.0, 1.0, N_POINTS)[:, None]
    line = start[:, None] + along * (goal - start)[:, None]
    nearest = np.full(line.shape[:2], np.inf)
    for feeder in (a, b):
        for known in np.moveaxis(feeder.path[:, ::SHOWN_EVERY], 1, 0):
            nearest = np.minimum(nearest, np.linalg.norm(line - known[:, None], axis=-1))
    return np.mean(nearest >= HOME_RANGE, axis=1)


def summarise(results: Results) -> Table:
    """Closest distance to the goal, course and straightness for each use."""
    rows = []
    for cell, arrays in results:
        rows.append(
            {
                "preset": cell.preset,
                "noise": cell.noise,
                "task": cell.task,
                **median_columns("distance", arrays["distance"]),
                **median_columns("closest_distance", arrays["closest_distance"]),
                **share_columns("share_in_range", arrays["closest_distance"] < HOME_RANGE),
                **circular_columns("course_error", arrays["course_error"]),
                "tortuosity": tortuosity(arrays["distance_left"]),
                **mean_columns("unvisited", arrays["unvisited"]),
                "n": cell.n_trials,
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """A column for each use: two trials above, the distribution of the closest distance below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.2), layout="constrained")
    panels = figure.subplots(2, len(TASKS), height_ratios=(1.3, 1.0))
    for letter, (task, words), above, below in zip("abcd", TASKS.items(), *panels, strict=True):
        index = results.only(preset="thesis", noise=NOISES[-1], task=task)
        _draw_trial(above, {name: results[name][index][SHOWN] for name in ("path", "goal", "route_a", "route_b")}, task)
        name_panel(above, letter)
        above.set_title(words, fontsize=7.0)
        _draw_closest(below, results, task)
    panels[0, 0].set_ylabel("y (steps)")
    panels[1, 0].set_ylabel("share of trials")
    figure.legend(*panels[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.legend(*panels[0, 2].get_legend_handles_labels(), loc="outside upper center", ncols=6)
    return figure


def _draw_trial(axes: Axes, trial: Mapping[str, NDArray[np.floating]], task: str) -> None:
    """The known routes, the way to the goal, and the search there; A + B is where B begins at A."""
    a, b = trial["route_a"], trial["route_b"]
    offset = a[-1] if task == "sequence" else np.zeros(2)
    axes.plot(*a.T, color=COLOURS["grey"], linewidth=0.8, label="route to A")
    if task in ("shortcut", "sequence"):
        axes.plot(*(b + offset).T, color=COLOURS["orange"], linewidth=0.8, label="route to B")
        axes.plot(*(b[-1] + offset), marker="s", color=COLOURS["orange"], linestyle="none", markersize=4.0, label="B")
    axes.plot(*trial["path"].T, color=COLOURS["blue"], linewidth=0.8, label="flight with the stored vector", zorder=3)
    axes.plot(*a[-1], marker="s", color=COLOURS["grey"], linestyle="none", markersize=4.0, label="A", zorder=4)
    axes.plot(
        0.0, 0.0, marker="o", color="white", markeredgecolor="black", linestyle="none", markersize=4.0, label="nest",
        zorder=5,
    )  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (steps)")


def _draw_closest(axes: Axes, results: Results, task: str) -> None:
    """Cumulative distribution of the closest distance to the goal."""
    for preset, colour in zip(PRESETS, ("blue", "red"), strict=True):
        for noise, style in zip(NOISES, ("--", "-"), strict=True):
            index = results.only(preset=preset, noise=noise, task=task)
            closest = np.append(np.sort(results["closest_distance"][index]), np.inf)
            share = np.arange(1, closest.size + 1) / (closest.size - 1)
            closest, share = np.minimum(closest, 2.0 * LONGEST), np.minimum(share, 1.0)  # drawn on to the right edge
            label = f"{PRESET_NAMES[preset]}, noise {noise:g}"
            axes.step(closest, share, where="post", color=COLOURS[colour], linestyle=style, label=label)
    axes.axvline(HOME_RANGE, color=COLOURS["grey"], linewidth=0.6)
    axes.set_xlim(0.0, LONGEST)
    axes.set_ylim(0.0, 1.03)
    axes.set_xlabel("closest distance (steps)")


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    n_trials = results.cells[0].n_trials
    unvisited = 100.0 * results["unvisited"][results.where(task="shortcut")].mean()
    return (
        f"Vectors stored at the ends of random trips of {N_STEPS} steps to feeders A and B, and flights of {N_STEPS} "
        "steps with them. a, nest to A: an even memory less that of A; b, A to nest: an even memory plus that of A; c, "
        f"A to B: the memory at A less that of B ({unvisited:.0f} % of the straight line lies {HOME_RANGE:g} steps or "
        "more from both known routes); d, A + B to nest: an even memory plus those of A and B. Above, one trial with "
        f"the thesis constants at noise {NOISES[-1]:g}. Below, cumulative distributions of the closest distance to the "
        f"goal (n = {n_trials} trials each; constants and noise as labelled; line: home range, {HOME_RANGE:g} steps)."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Claims in words beside the thesis' constants at the noise of the paper."""
    rows = {row["task"]: row for row in table if row["preset"] == "thesis" and row["noise"] == NOISES[-1]}
    names = {
        "outward": "closest distance to the remembered feeder, outward vector",
        "homebound": "closest distance to the nest, homebound vector",
        "shortcut": "closest distance to feeder B on the shortcut from feeder A",
        "sequence": "closest distance to the nest after two vectors in sequence",
    }
    ours = {
        name: (rows[task]["closest_distance"], rows[task]["closest_distance_error"]) for task, name in names.items()
    }
    shortcut = rows["shortcut"]
    course = (shortcut["course_error_deg"], shortcut["course_error_error_deg"])
    ours["course on leaving feeder A minus direction of B"] = course
    near = ", ".join(f"{TASKS[task]} {100.0 * row['share_in_range']:.0f} %" for task, row in rows.items())
    why = f"trials that come within {HOME_RANGE:g} steps: {near}"
    return [judge(value, *ours[name], why=why) for name, value in published.items()]
