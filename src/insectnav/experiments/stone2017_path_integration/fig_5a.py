"""Fig. 5a: one trip out and back, then the search; and the same trip with obstacles on the way home."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.perturbations import Circle, Wall
from insectnav.angles import bearing, wrap
from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.obstructed_trips import (
    FARTHEST_SOUTH,
    MARGIN,
    OBSTACLES,
    detour,
    draw_obstacles,
    draw_shares,
    home_arrays,
    home_findings,
    trips_from_south,
    turned,
)
from insectnav.experiments.stone2017_path_integration.straight_flights import fly
from insectnav.experiments.stone2017_path_integration.trips import (
    HOME_RANGE,
    N_STEPS,
    PRESET_LINES,
    PRESET_NAMES,
    draw_home_range,
    example_trip,
    ways_home,
)
from insectnav.metrics.path_integration import summary
from insectnav.metrics.search import NEVER, first_arrival
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 5a"
TITLE = "a trip out, the way home and the search, without and with obstacles"
NOISE = 0.1  # legend of Fig. 5
SEARCHED = 500  # [steps] after arrival, over which the distance from the nest is averaged
LOOKS = {"none": ("blue", "free way"), "both": ("red", "obstacles")}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """The way home free or obstructed, under one set of constants."""

    obstacles: str
    preset: str
    n_trials: int


def grid(scale: str) -> Sequence[Cell]:
    """Free and obstructed, under both sets of constants."""
    n_trials = 1000 if scale == "full" else 200
    return [Cell(obstacles=name, preset=preset, n_trials=n_trials) for preset in PRESETS for name in LOOKS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """The trial that is drawn, and how many trials came home, how near and how directly."""
    circuit = circuit_params(preset=cell.preset)
    obstacles = OBSTACLES[cell.obstacles]
    arrays, _ = trips_from_south(cell.n_trials, circuit, noise=NOISE, seed=seed, perturbations=obstacles)
    home = ways_home(arrays, N_STEPS)
    arrival = first_arrival(home, HOME_RANGE)
    route = example_trip(seed)
    in_the_way = around(obstacles, route[1])
    example = fly(route, circuit, n_inbound=N_STEPS, noise=NOISE, seed=seed, perturbations=in_the_way)
    return {
        **home_arrays(arrays, home, arrival),
        "searched_at": (("trial",), _distance_after(home, arrival), {"units": "steps"}),
        "path": (("step", "xy"), example.position[0], {"units": "steps"}),
    }


def around(obstacles: Sequence[Any], velocity: np.ndarray) -> list[Any]:
    """Obstacles that lie to the south of the nest, turned to where the route (1, step, 2) ends."""
    by = wrap(bearing(velocity.sum(axis=1)) - np.pi)

    def place(point: Sequence[float]) -> tuple[float, float]:
        x, y = turned(np.array([point]), by)[0].tolist()
        return x, y

    return [
        Circle(centre=place(o.centre), radius=o.radius)
        if isinstance(o, Circle)
        else Wall(start=place(o.start), end=place(o.end))
        for o in obstacles
    ]


def _distance_after(home: np.ndarray, arrival: np.ndarray) -> np.ndarray:
    """Mean distance from the nest in the steps after arrival, (trial,); NaN where there are not so many."""
    distance = np.linalg.norm(home, axis=-1)
    mean = np.full(len(home), np.nan)
    for trial, first in enumerate(arrival):
        if first != NEVER and first + SEARCHED <= distance.shape[1]:
            mean[trial] = distance[trial, first : first + SEARCHED].mean()
    return mean


def summarise(results: Results) -> Table:
    """How near and how directly the agents came home that had the obstacles before them."""
    return [_row(cell, arrays) for cell, arrays in results]


def _row(cell: Cell, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    searched = arrays["searched_at"][arrays["is_beyond"]]
    example = np.linalg.norm(arrays["path"][N_STEPS - 1 :], axis=-1)
    return {
        "preset": cell.preset,
        "obstacles": cell.obstacles,
        **home_findings(arrays),
        "way_over_straight_standard_error": bootstrap_error(detour(arrays), np.median),
        "median_distance_searched_at": summary(searched).median,
        "distance_searched_at_standard_error": bootstrap_error(searched, np.median),
        "example_closest_distance": float(example.min()),
    }


def draw(results: Results) -> Figure:
    """The trial without and with obstacles under both sets of constants, and the distances of all trials."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 5.4), layout="constrained")
    places = figure.add_gridspec(2, 3)
    for row, preset in enumerate(results.by("preset")):
        for column, name in enumerate(LOOKS):
            axes = figure.add_subplot(places[row, column])
            _draw_trial(axes, results["path"][results.only(preset=preset, obstacles=name)], name)
            name_panel(axes, "abcd"[2 * row + column], PRESET_NAMES[preset])
            if row == column == 0:
                axes.legend(loc="best")
    near, way = figure.add_subplot(places[0, 2]), figure.add_subplot(places[1, 2])
    for cell, arrays in results:
        colour, label = LOOKS[cell.obstacles]
        look = {"color": COLOURS[colour], "linestyle": PRESET_LINES[cell.preset]}
        if cell.preset == results.cells[0].preset:
            look["label"] = label
        draw_shares(near, arrays["closest_distance"][arrays["is_beyond"]], **look)
        draw_shares(way, detour(arrays), **look)
    near.set_xlim(0.0, 25.0)
    near.axvline(HOME_RANGE, color=COLOURS["grey"], linestyle="--", linewidth=0.7)
    near.set_xlabel("closest distance to the nest (steps)")
    way.set_xlim(1.0, 4.0)
    way.set_xlabel("way walked home over straight way")
    for axes, letter in ((near, "e"), (way, "f")):
        axes.set_ylim(0.0, 102.0)
        axes.set_ylabel("trials with at most that (%)")
        name_panel(axes, letter)
    for preset, line in PRESET_LINES.items():
        way.plot([], [], line, color="black", label=PRESET_NAMES[preset])
    way.legend(loc="lower right")
    return figure


def _draw_trial(axes: Axes, path: np.ndarray, name: str) -> None:
    """Outbound route, way home and search, obstacles."""
    home = path[N_STEPS - 1 :]
    arrival = int(first_arrival(home[None], HOME_RANGE)[0])
    last = len(home) - 1 if arrival == NEVER else arrival
    draw_obstacles(axes, around(OBSTACLES[name], path[None, N_STEPS - 1 : N_STEPS]))
    axes.plot(*path[:N_STEPS].T, color=COLOURS["sky"], linewidth=0.8, label="out")
    axes.plot(*home[: last + 1].T, color=COLOURS["red"], linewidth=1.2, label="home")
    axes.plot(*home[last:].T, color="black", linewidth=0.5, label="search")
    axes.plot(*home[0], marker="x", color=COLOURS["red"], markersize=5)
    draw_home_range(axes)


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    cell = results.cells[0]
    n = int(results["is_beyond"][0].sum())
    return (
        f"One random trip of {N_STEPS} steps from the nest (circle) to the cross, then {N_STEPS} steps home and of "
        f"search (from the first step in the home range of {HOME_RANGE:g} steps, dashed), with the way free (a, c) "
        f"and with obstacles (b, d). Noise {NOISE:g}. e, f, How near and how directly all trials come home whose "
        f"turning point lies more than {FARTHEST_SOUTH + MARGIN:g} steps out, so that the obstacles, turned with each "
        f"route, are between it and the nest: n = {n} of {cell.n_trials}. Straight way: from the turning point to the "
        "home range."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The words of the legend and of the text, under both sets of constants."""
    columns = {
        "closest distance": ("median_closest_distance", "closest_distance_standard_error"),
        "way walked over straight way": ("median_way_over_straight", "way_over_straight_standard_error"),
        "distance from the nest during the search": (
            "median_distance_searched_at",
            "distance_searched_at_standard_error",
        ),
    }
    verdicts = []
    for name, value in published.items():
        quantity, condition, preset = name.split(", ")
        obstacles = {"free way": "none", "obstacles": "both"}[condition]
        row = next(row for row in table if row["preset"] == preset and row["obstacles"] == obstacles)
        ours, error = columns[quantity]
        why = (
            f"{row['within_home_range']:.0%} of {row['n']} trials come within {HOME_RANGE:g} steps of the nest, by "
            f"{row['median_way_over_straight']:.2f} times the straight way"
        )
        verdicts.append(judge(value, row[ours], row[error], why=why))
    return verdicts
