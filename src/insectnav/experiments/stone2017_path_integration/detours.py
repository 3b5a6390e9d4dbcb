"""Text: forced deviations on the way home, by obstacles and by being carried away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.perturbations import Displace
from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.obstructed_trips import (
    FARTHEST_SOUTH,
    MARGIN,
    OBSTACLES,
    draw_obstacles,
    draw_shares,
    home_arrays,
    home_findings,
    trips_from_south,
)
from insectnav.experiments.stone2017_path_integration.trips import (
    HOME_RANGE,
    N_STEPS,
    PRESET_LINES,
    PRESET_NAMES,
    draw_home_range,
    ways_home,
)
from insectnav.metrics.path_integration import summary
from insectnav.metrics.search import NEVER, first_arrival, search_centre

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "text"
TITLE = "obstacles on the way home, and being carried away"
CARRIED = (100.0, 0.0)  # [steps] to the east
UNDERWAY = 80  # [steps] after the start for home
N_INBOUND = 2500  # [steps]
SETTLED = 1000  # [steps] at the end of the way home, over which the place searched is averaged
CONDITIONS = ("none", "circle", "wall", "ring", "carried at the start", "carried underway")
DRAWN_NOISE = 0.1
N_PATHS = 3
AT_NEST = 5.0  # [steps] where a path that is drawn ends
LOOKS = {"none": "black", "circle": "orange", "wall": "blue", "ring": "red"}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One thing that happens on the way home, under one set of constants."""

    condition: str
    preset: str
    noise: float
    n_trials: int


def grid(scale: str) -> Sequence[Cell]:
    """All conditions, with and without noise, under both sets of constants."""
    n_trials = 1000 if scale == "full" else 100
    return [
        Cell(condition=condition, preset=preset, noise=noise, n_trials=n_trials)
        for preset in PRESETS
        for noise in (DRAWN_NOISE, 0.0)
        for condition in CONDITIONS
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """How near each trial came to the true nest and to the fictive one, and where it searched."""
    what, carried = happening(cell.condition)
    arrays, _ = trips_from_south(
        cell.n_trials, circuit_params(preset=cell.preset), noise=cell.noise, seed=seed, n_inbound=N_INBOUND,
        perturbations=what,
    )  # fmt: skip
    home = ways_home(arrays, N_INBOUND)
    start = np.linalg.norm(home[:, 0], axis=-1)
    settled = np.full(cell.n_trials, home.shape[1] - SETTLED)
    return {
        **home_arrays(arrays, home, first_arrival(home, HOME_RANGE)),
        "closest_to_fictive": (("trial",), np.linalg.norm(home - carried, axis=-1).min(axis=1), {"units": "steps"}),
        "centre": (("trial", "xy"), search_centre(home, settled), {"units": "steps"}),
        "path": (("path", "step", "xy"), _shown(home, start), {"units": "steps"}),
    }


def happening(condition: str) -> tuple[tuple[Any, ...], np.ndarray]:
    """Perturbations of a condition, and where the fictive nest lies (2,) [steps]."""
    steps = {"carried at the start": 0, "carried underway": UNDERWAY}
    if condition in steps:
        return (Displace(step=N_STEPS + steps[condition], by=CARRIED),), np.array(CARRIED, np.float32)
    return OBSTACLES[condition], np.zeros(2, np.float32)


def _shown(home: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Ways home of the first trials that begin beyond the obstacles; NaN where there are fewer."""
    paths = np.full((N_PATHS, *home.shape[1:]), np.nan, np.float32)
    found = np.flatnonzero(start > FARTHEST_SOUTH + MARGIN)[:N_PATHS]
    paths[: found.size] = home[found]
    return paths


def summarise(results: Results) -> Table:
    """How near the agents came that started beyond the obstacles, and where they searched."""
    return [_row(cell, arrays) for cell, arrays in results]


def _row(cell: Cell, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    beyond = arrays["is_beyond"]
    fictive, centre = arrays["closest_to_fictive"][beyond], arrays["centre"][beyond]
    _, carried = happening(cell.condition)
    return {
        "condition": cell.condition,
        "preset": cell.preset,
        "noise": cell.noise,
        **home_findings(arrays),
        "median_closest_to_fictive_nest": summary(fictive).median,
        "within_range_of_fictive_nest": float(np.mean(fictive <= HOME_RANGE)),
        "mean_centre_x": summary(centre[:, 0]).mean,
        "mean_centre_y": summary(centre[:, 1]).mean,
        "median_centre_to_nest": summary(np.linalg.norm(centre, axis=-1)).median,
        "median_centre_to_fictive_nest": summary(np.linalg.norm(centre - carried, axis=-1)).median,
    }


def draw(results: Results) -> Figure:
    """Ways home past obstacles and after being carried, distances of all trials, and where they searched."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 5.2), layout="constrained")
    panels = figure.subplots(2, 3)
    shown = ("circle", "wall", "ring", "carried underway")
    for letter, axes, condition in zip("abcd", panels.flat, shown, strict=False):
        _draw_paths(axes, results, condition)
        name_panel(axes, letter, condition)
    _draw_shares(panels[1, 1], results)
    _draw_centres(panels[1, 2], results)
    return figure


def _draw_paths(axes: Axes, results: Results, condition: str) -> None:
    """Three ways home under the constants of the thesis."""
    what, carried = happening(condition)
    paths = results["path"][results.only(condition=condition, preset="thesis", noise=DRAWN_NOISE)]
    if what and isinstance(what[0], Displace):
        axes.plot(*carried, marker="D", color="white", markeredgecolor="black", markersize=3.5, linestyle="none",
                  zorder=5, label="fictive nest")  # fmt: skip
        axes.legend(loc="lower right")
    else:
        draw_obstacles(axes, what)
    for path, name in zip(paths, ("blue", "red", "green"), strict=False):
        arrival = _arrival(path, carried)
        axes.plot(*_broken(path[: arrival + 1]).T, color=COLOURS[name], linewidth=1.0)
        axes.plot(*path[0], marker="x", color=COLOURS[name], markersize=4)
    draw_home_range(axes)


def _arrival(path: np.ndarray, nest: np.ndarray) -> int:
    """Step until which a path is drawn: it is at a nest, or as near as it comes."""
    first = int(first_arrival((path - nest)[None], AT_NEST)[0])
    return int(np.argmin(np.linalg.norm(path - nest, axis=-1))) if first == NEVER else first


def _broken(path: np.ndarray) -> np.ndarray:
    """A path with a gap where the animal is carried."""
    jump = np.flatnonzero(np.linalg.norm(np.diff(path, axis=0), axis=-1) > 10.0)
    return np.insert(path, jump + 1, np.nan, axis=0)


def _draw_shares(axes: Axes, results: Results) -> None:
    """Share of the trials up to each closest distance."""
    for preset, line in PRESET_LINES.items():
        for condition, colour in LOOKS.items():
            index = results.only(condition=condition, preset=preset, noise=DRAWN_NOISE)
            closest = results["closest_distance"][index][results["is_beyond"][index]]
            label = condition if preset == "thesis" else None
            draw_shares(axes, closest, linestyle=line, color=COLOURS[colour], label=label)
    axes.plot([], [], "--", color="black", label=PRESET_NAMES["code-2017"])
    axes.axvline(HOME_RANGE, color=COLOURS["grey"], linestyle="--", linewidth=0.7)
    axes.set_xlim(0.0, 1.25 * HOME_RANGE)
    axes.set_ylim(0.0, 102.0)
    axes.set_xlabel("closest distance to the nest (steps)")
    axes.set_ylabel("trials with at most that (%)")
    name_panel(axes, "e")
    axes.legend(loc="lower right", bbox_to_anchor=(0.8, 0.0))


def _draw_centres(axes: Axes, results: Results) -> None:
    """Centre of each search of animals that were left alone, and of those that were carried."""
    for condition, name, label in (("none", "grey", "left alone"), ("carried underway", "orange", "carried")):
        index = results.only(condition=condition, preset="thesis", noise=DRAWN_NOISE)
        centre = results["centre"][index][results["is_beyond"][index]]
        axes.plot(*centre.T, ".", color=COLOURS[name], markersize=2.5, label=label)
    axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", markersize=4.5, linestyle="none")
    axes.plot(*CARRIED, marker="D", color="white", markeredgecolor="black", markersize=4.5, linestyle="none")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (steps)")
    axes.set_ylabel("y (steps)")
    name_panel(axes, "f", "centre of the search")
    axes.legend(loc="upper left", markerscale=2.0)


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    cell = results.cells[0]
    n = int(results["is_beyond"][0].sum())
    return (
        f"Ways home after random trips of {N_STEPS} steps, turned about the nest (circle) so that home is due north "
        f"at the turning point (crosses), at noise {DRAWN_NOISE:g}. a–c, Past a circle, a wall and a ring of circles, "
        f"up to the nest (three trials, thesis constants). d, Carried {CARRIED[0]:g} steps east after "
        f"{UNDERWAY} steps of the way home (gap): the agents go on to the fictive nest (diamond), which lies as far "
        "from the true one. e, How near all trials come to the nest that start farther out than "
        f"{FARTHEST_SOUTH + MARGIN:g} steps: n = {n} of {cell.n_trials}. f, Mean position of each of these trials in "
        f"the last {SETTLED} of {N_INBOUND} steps, left alone and carried underway."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What the text says of forced deviations, at the default noise, under both sets of constants."""
    verdicts = []
    for name, value in published.items():
        quantity, condition, preset = name.split(", ")
        row, free = (
            next(r for r in table if (r["condition"], r["preset"], r["noise"]) == (wanted, preset, DRAWN_NOISE))
            for wanted in (condition, "none")
        )
        if quantity == "closest distance":
            ours, error = row["median_closest_distance"], row["closest_distance_standard_error"]
        else:
            share = row["within_home_range"]
            ours, error = share, float(np.sqrt(share * (1.0 - share) / row["n"]))
        why = (
            f"{row['within_home_range']:.0%} of {row['n']} trials come within {HOME_RANGE:g} steps of the nest, "
            f"{free['within_home_range']:.0%} where nothing is in the way"
        )
        verdicts.append(judge(value, ours, error, why=why))
    return verdicts
