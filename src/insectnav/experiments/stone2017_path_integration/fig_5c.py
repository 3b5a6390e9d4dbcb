"""Fig. 5c: how near to the nest the way home leads after trips of 10 to 10 000 steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.motion import MotionParams
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.agents.simulation import TrialParams, simulate_trials
from insectnav.central_complex import PRESETS, circuit_params, decode_home_vector
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.trips import (
    HOME_RANGE,
    N_STEPS,
    NOISE_COLOURS,
    NOISE_LEVELS,
    PRESET_NAMES,
)
from insectnav.metrics.path_integration import length_ratio
from insectnav.metrics.statistics import bootstrap_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 5c"
TITLE = "closest distance to the nest against the length of the trip out"
RANDOM_WALK = "random walk"
LENGTHS = tuple(int(length) for length in np.rint(np.geomspace(10.0, 10_000.0, 20)))  # [steps] Methods
PART = 256  # trials at a time: their routes take 60 MB at most
SHOWN_NOISE = 0.1  # of decoded distance and saturation
MARKERS = {**dict.fromkeys(PRESETS, "o"), RANDOM_WALK: "s"}


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One length of the trip out, for one agent at one noise level."""

    agent: str  # name of a set of constants, or "random walk"
    noise: float
    n_steps: int  # out, and as many home
    n_trials: int = 1000  # Fig. 5c


def grid(scale: str) -> Sequence[Cell]:
    """All lengths, and 1500 steps, at all noise levels under both sets of constants, and the random walk."""
    lengths, n_trials = ((*LENGTHS, N_STEPS), 1000) if scale == "full" else ((*LENGTHS[:16:5], N_STEPS), 100)
    agents = [(preset, noise) for preset in PRESETS for noise in NOISE_LEVELS] + [(RANDOM_WALK, 0.0)]
    return [
        Cell(agent=agent, noise=noise, n_steps=n_steps, n_trials=n_trials)
        for n_steps in sorted(lengths, reverse=True)  # the longest first: no core is left alone with them
        for agent, noise in agents
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Closest distance of each trial on the way home, its distance at the turn, and what its memory held there."""
    if cell.agent == RANDOM_WALK:
        closest, at_turn = _random_walk(cell, seed)
        nothing = np.full(cell.n_trials, np.nan, np.float32)
        ratio, saturated, empty = nothing, nothing, nothing
    else:
        parts = list(_trips(cell, seed))
        closest, at_turn, ratio, saturated, empty = (np.concatenate(values) for values in zip(*parts, strict=True))
    return {
        "closest_distance": (("trial",), closest.astype(np.float32), {"units": "steps"}),
        "distance_at_turn": (("trial",), at_turn.astype(np.float32), {"units": "steps"}),
        "decoded_over_true_distance": (("trial",), ratio.astype(np.float32)),
        "saturated_memory": (("trial",), saturated.astype(np.float32), {"long_name": "share of cells at 0 or 1"}),
        "empty_memory": (("trial",), empty.astype(np.float32), {"long_name": "share of cells at 0"}),
    }


def _random_walk(cell: Cell, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Trips whose random route goes on for as long as the way home: closest distance, and that at the turn."""
    distance = []
    for first in range(0, cell.n_trials, PART):
        n_here = min(PART, cell.n_trials - first)
        _, velocity = route_arrays(n_here, 2 * cell.n_steps, RouteParams(), seed, "float32", first_trial=first)
        position = np.cumsum(velocity, axis=1, dtype=float)[:, cell.n_steps - 1 :]
        distance.append(np.linalg.norm(position, axis=-1))
    return np.concatenate([part.min(axis=1) for part in distance]), np.concatenate([part[:, 0] for part in distance])


def _trips(cell: Cell, seed: int) -> Iterator[tuple[np.ndarray, ...]]:
    """Measures of trips with the circuit, part by part."""
    circuit = circuit_params(preset=cell.agent)
    params = TrialParams(
        circuit=circuit,
        motion=MotionParams(),
        n_inbound=cell.n_steps,
        noise=cell.noise,
        seed=seed,
        keep_paths=False,
    )
    for first in range(0, cell.n_trials, PART):
        trials = np.arange(first, min(first + PART, cell.n_trials))
        heading, velocity = route_arrays(len(trials), cell.n_steps, RouteParams(), seed, "float32", first_trial=first)
        arrays = simulate_trials(heading, velocity, trials, params)
        turn, memory = velocity.sum(axis=1, dtype=float), arrays.memory_at_turn
        ratio = length_ratio(decode_home_vector(memory, circuit), turn)
        saturated = np.mean((memory <= 0.0) | (memory >= 1.0), axis=1)
        empty = np.mean(memory <= 0.0, axis=1)
        yield arrays.closest_distance, np.linalg.norm(turn, axis=-1), ratio, saturated, empty


def summarise(results: Results) -> Table:
    """Closest distance, decoded over true distance and saturation for each agent, noise level and length."""
    rows = []
    for cell, arrays in results:
        closest, saturated = arrays["closest_distance"].astype(float), arrays["saturated_memory"]
        is_trip = cell.agent != RANDOM_WALK
        rows.append(
            {
                "agent": cell.agent,
                "noise": cell.noise,
                "n_steps": cell.n_steps,
                "mean": float(np.mean(closest)),
                "mean_standard_error": float(np.std(closest, ddof=1) / np.sqrt(closest.size)),
                "sd": float(np.std(closest, ddof=1)),
                "sd_standard_error": bootstrap_error(closest, np.std),
                "median": float(np.median(closest)),
                "median_standard_error": bootstrap_error(closest, np.median),
                "within_home_range": float(np.mean(closest <= HOME_RANGE)),
                "median_distance_at_turn": float(np.median(arrays["distance_at_turn"])),
                "median_decoded_over_true": float(np.median(arrays["decoded_over_true_distance"])),
                "share_of_cells_saturated": float(np.mean(saturated)),
                "share_of_cells_empty": float(np.mean(arrays["empty_memory"])),
                "share_of_trips_saturated": float(np.mean(saturated > 0.0)) if is_trip else float("nan"),
                "n": closest.size,
            }
        )
    return sorted(rows, key=lambda row: (row["agent"], row["noise"], row["n_steps"]))


def _courses(table: Table) -> dict[tuple[str, float], dict[str, np.ndarray]]:
    """Columns of the table over the lengths, for each agent and noise level."""
    keys = dict.fromkeys((row["agent"], row["noise"]) for row in table)
    return {
        key: {
            name: np.array([row[name] for row in table if (row["agent"], row["noise"]) == key])
            for name in table[0]
            if name not in ("agent", "noise")
        }
        for key in keys
    }


def draw(results: Results) -> Figure:
    """Mean ± SD and median of the closest distance against length; what the memory held at the turn."""
    from matplotlib.figure import Figure

    courses = _courses(summarise(results))
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.6), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True)
    for column, preset in enumerate(PRESETS):
        _draw_distances(panels[0, column], courses, preset, "mean")
        _draw_distances(panels[1, column], courses, preset, "median")
        panels[0, column].set_title(PRESET_NAMES[preset], loc="left")
    panels[0, 0].set_ylabel("closest distance to the nest (steps)\nmean and SD")
    panels[1, 0].set_ylabel("closest distance to the nest (steps)\nmedian")
    _draw_memory(panels[:, 2], courses)
    for axes in panels[1]:
        axes.set_xlabel("length of the trip out (steps)")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, title="noise $\\sigma_r$", loc="outside lower center", ncols=len(labels))
    return figure


def _draw_distances(axes: Axes, courses: Mapping[Any, Mapping[str, np.ndarray]], preset: str, statistic: str) -> None:
    """One line for each noise level; the means with bars of one SD, moved a little apart."""
    shown = [key for key in courses if key[0] == preset] + [(RANDOM_WALK, 0.0)]
    lowest = 0.05
    for rank, (agent, noise) in enumerate(shown):
        course = courses[agent, noise]
        is_walk = agent == RANDOM_WALK
        colour = COLOURS["grey" if is_walk else NOISE_COLOURS[noise]]
        shift = 1.0 if statistic == "median" else 1.0 + 0.03 * (rank - len(shown) / 2.0)
        x, y = course["n_steps"] * shift, np.maximum(course[statistic], lowest)
        if statistic == "mean":
            bars = [y - np.maximum(y - course["sd"], lowest), course["sd"]]
            axes.errorbar(x, y, bars, fmt="none", ecolor=colour, elinewidth=0.6, alpha=0.6)
        line: dict[str, Any] = {"color": colour, "marker": MARKERS[agent], "linestyle": "--" if is_walk else "-"}
        label = RANDOM_WALK if is_walk else f"{noise:g}"
        axes.plot(x, y, markersize=2.2, linewidth=0.9, label=label, **line)
    axes.axhline(HOME_RANGE, color="black", linewidth=0.6, linestyle=":")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.minorticks_off()
    axes.set_ylim(lowest, 3000.0)


def _draw_memory(panels: Sequence[Axes], courses: Mapping[Any, Mapping[str, np.ndarray]]) -> None:
    """Decoded over true distance, and the share of trips whose memory is saturated, at the turning point."""
    for preset, colour in zip(PRESETS, ("blue", "orange"), strict=True):
        course = courses[preset, SHOWN_NOISE]
        style: dict[str, Any] = {"color": COLOURS[colour], "marker": "o", "markersize": 2.2, "linewidth": 0.9}
        panels[0].plot(course["n_steps"], course["median_decoded_over_true"], **style, label=PRESET_NAMES[preset])
        panels[1].plot(course["n_steps"], 100.0 * course["share_of_trips_saturated"], **style)
        cells = style | {"linestyle": "--", "marker": "s"}
        panels[1].plot(course["n_steps"], 100.0 * course["share_of_cells_saturated"], **cells)
    panels[0].axhline(1.0, color="black", linewidth=0.6, linestyle=":")
    panels[0].set_ylim(0.0, 1.25)
    panels[0].set_ylabel("decoded / true distance (median)")
    panels[0].set_title(f"memory at the turn, $\\sigma_r$ = {SHOWN_NOISE:g}", loc="left")
    panels[0].legend(loc="lower right")
    panels[1].plot([], [], color="black", marker="o", markersize=2.2, linewidth=0.9, label="trips, any cell saturated")
    panels[1].plot([], [], color="black", marker="s", markersize=2.2, linewidth=0.9, linestyle="--", label="cells")
    for axes in panels:
        axes.minorticks_off()
    panels[1].set_ylim(-2.0, 102.0)
    panels[1].set_ylabel("saturated (%)")
    panels[1].legend(loc="upper left")


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    lengths = sorted({cell.n_steps for cell in results.cells})
    return (
        "Closest distance to the nest on a way home as long as the trip out, "
        f"{lengths[0]} to {lengths[-1]} steps: mean with bars of one SD (top) and median (bottom) of "
        f"n = {results.cells[0].n_trials} random trips for each length, noise level and set of constants; grey "
        f"squares: the random route simply goes on. Dotted: {HOME_RANGE:g} steps. Bars end at the lower edge where the "
        "SD exceeds the mean. Right: median of decoded over true distance at the turning point, and share of the trips "
        f"(dots) and of all memory cells (squares) at 0 or 1, at noise {SHOWN_NOISE:g}."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Numbers at 1500 steps, and what the text says of short and long trips."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    """The quantities are named by what is measured, and by the set of constants."""
    measure, _, conditions = value.quantity.partition(", ")
    measure = measure.removesuffix(" in the code")
    preset = next(preset for preset, name in PRESET_NAMES.items() if conditions.endswith(name))
    longest = max(row["n_steps"] for row in table)
    course = _courses(table)[preset, SHOWN_NOISE]
    if measure == "share of trips with saturated memory":
        rank = int(np.flatnonzero(course["n_steps"] <= int(conditions.partition(" ")[0]))[-1])
        share = float(course["share_of_trips_saturated"][rank])
        error = float(np.sqrt(share * (1.0 - share) / course["n"][rank]))
        return judge(value, share, error, why=_why_saturated(course, rank), not_comparable=_too_short(longest))
    if measure == "largest median at any length":
        worst = int(np.argmax(course["median"]))
        error = float(course["median_standard_error"][worst])
        why = _why_far(course, worst)
        return judge(value, float(course["median"][worst]), error, why=why, not_comparable=_too_short(longest))
    noise = float(conditions.removeprefix("noise ").partition(",")[0])
    row = next(r for r in table if (r["agent"], r["noise"], r["n_steps"]) == (preset, noise, N_STEPS))
    if measure == "median over that of a random walk":
        walk = next(r for r in table if r["agent"] == RANDOM_WALK and r["n_steps"] == N_STEPS)
        return judge(value, row["median"] / walk["median"], row["median_standard_error"] / walk["median"])
    why = f"median {row['median']:.2f}, mean {row['mean']:.2f}, SD {row['sd']:.2f} of {row['n']} trials"
    return judge(value, row[measure], row[f"{measure}_standard_error"], why=why)


def _why_saturated(course: Mapping[str, np.ndarray], rank: int) -> str:
    """How many cells are saturated after trips of that length, and from which length on half of the trips are."""
    from_length = saturation_length(course["n_steps"], course["share_of_trips_saturated"])
    when = f"from {from_length:.0f} steps on" if np.isfinite(from_length) else "at no length"
    return (
        f"after {course['n_steps'][rank]} steps {100.0 * course['share_of_cells_saturated'][rank]:.2f} % of the cells "
        f"are at 0 or 1, {100.0 * course['share_of_cells_empty'][rank]:.2f} % at 0; half of the trips have one {when}"
    )


def _why_far(course: Mapping[str, np.ndarray], worst: int) -> str:
    """What goes with the largest median of the closest distance."""
    return (
        f"at {course['n_steps'][worst]} steps, where the median turning point is "
        f"{course['median_distance_at_turn'][worst]:.0f} steps from the nest, decoded over true distance is "
        f"{course['median_decoded_over_true'][worst]:.2f} and "
        f"{100.0 * course['share_of_cells_saturated'][worst]:.1f} % of the memory cells are saturated, "
        f"{100.0 * course['share_of_cells_empty'][worst]:.1f} % empty; the smallest median is "
        f"{course['median'].min():.1f}, at {course['n_steps'][np.argmin(course['median'])]} steps"
    )


def _too_short(longest: int) -> str:
    """Why a quick run says nothing of long trips; empty if it was not one."""
    return "" if longest >= LENGTHS[-1] else f"needs trips of {LENGTHS[-1]} steps, those of this run end at {longest}"


def saturation_length(n_steps: np.ndarray, share_saturated: np.ndarray) -> float:
    """Length [steps] at which half of the trips have a saturated memory cell; NaN if none of the lengths reaches it.

    Parameters
    ----------
    n_steps : (length,) array
        Ascending.
    share_saturated : (length,) array
        Share of the trips of each length that have one.

    Notes
    -----
    Interpolated between lengths, on the logarithm of length.
    """
    above = np.flatnonzero(share_saturated >= 0.5)
    if above.size == 0:
        return float("nan")
    if above[0] == 0:
        return float(n_steps[0])
    pair = slice(above[0] - 1, above[0] + 1)
    return float(np.exp(np.interp(0.5, share_saturated[pair], np.log(n_steps[pair]))))
