"""Migration: a fixed bump of memory, or of weights, and the course that it holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.agents.perturbations import ClampCells, Displace, FreezeMemory, SetMemory, WeightNoise
from insectnav.agents.simulation import TrialArrays
from insectnav.angles import bearing, wrap
from insectnav.central_complex import PRESETS, CircuitParams, circuit_params
from insectnav.central_complex.connectivity import DIRECTIONS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import DOUBLE_COLUMN, letter_panels
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.columns import circular_columns, median_columns
from insectnav.experiments.stone2017_path_integration.migration_panels import (
    draw_courses,
    draw_disturbances,
    draw_flights,
    draw_reversal,
    draw_spread,
)
from insectnav.experiments.stone2017_path_integration.straight_flights import fly, straight_flight
from insectnav.experiments.stone2017_path_integration.trips import NOISE_COLOURS, NOISE_LEVELS, PRESET_NAMES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "text: Supplementary Notes, Discussion"
TITLE = "migration: a fixed bump of memory holds a course"
N_STEPS = 3000
N_SETTLING = 100  # [steps] to turn from the random heading at the start to the course
DISTURBED_AT = 1500  # step
N_GOALS_OF_WEIGHTS = 8  # a set of weights is that of a circuit, not of a trial
AMPLITUDE = 0.25  # of the bump: the memory of a flight of 8 · 0.25 cos 45° / 2h = 283 steps
NOISE = 0.1  # Ext. Data Fig. 9: the level of all trials with disturbances
DISTURBANCES = {
    "none": "none",
    "carried": "carried off",
    "turned": "turned\nby force",
    "weight noise": "weights\nSD 5 %",
    "compass noise": "TL cells\nnoise 0.4",
    "reversal": "bump reversed",
}
N_SHOWN = 16
SHOWN_EVERY = 10  # [steps]


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Flights of migrants with goals all round, from random headings."""

    preset: str
    noise: float
    store: str = "memory"  # or "weights": where the bump is
    disturbance: str = "none"  # of DISTURBANCES
    n_trials: int = 1000


def grid(scale: str) -> Sequence[Cell]:
    """All noise levels, all disturbances, and a bump of weights."""
    n_trials = 1000 if scale == "full" else 96
    conditions: list[dict[str, Any]] = [{"noise": noise} for noise in NOISE_LEVELS]
    conditions += [{"noise": NOISE, "disturbance": name} for name in DISTURBANCES if name != "none"]
    conditions += [{"noise": NOISE, "store": "weights"}]
    return [Cell(preset=preset, n_trials=n_trials, **condition) for preset in PRESETS for condition in conditions]


def memory_bump(goal: ArrayLike, amplitude: float = AMPLITUDE) -> NDArray[np.float64]:
    """Memory (..., 16) that steers along a bearing.

    Parameters
    ----------
    goal : (...) array [rad]
    amplitude : float
        Of the sinusoid, at most 0.5.

    Notes
    -----
    M = ½ + A cos(d_i − (goal + 180°)) in both halves, with d_i the direction of column i: the closed form of what a
    straight flight away from the goal leaves behind, exactly so in the idealised circuit; from its end the goal is the
    way home. Stone et al. 2017, Supplementary Notes.
    """
    outbound = np.asarray(goal, float)[..., None] + np.pi
    return 0.5 + amplitude * np.cos(np.tile(DIRECTIONS, 2) - outbound)


def biased_circuit(circuit: CircuitParams, goal: float) -> CircuitParams:
    """The circuit with the bump in its CPU4 to CPU1 weights instead of its memory.

    Parameters
    ----------
    circuit : CircuitParams
    goal : float [rad]

    Notes
    -----
    Each weight is multiplied by the rate that its CPU4 cell would have with the bump, over the rate that it has with an
    even memory: "biased synaptic weights between memory and steering cells", Stone et al. 2017, Supplementary
    Discussion.
    """
    bump = _cpu4_rate(memory_bump(goal), circuit) / _cpu4_rate(np.full(16, circuit.memory_start), circuit)
    wiring = circuit.connectivity
    return replace(circuit, connectivity=replace(wiring, cpu4_to_cpu1=wiring.cpu4_to_cpu1 * bump))


def _cpu4_rate(memory: NDArray[np.floating], circuit: CircuitParams) -> NDArray[np.floating]:
    return 1.0 / (1.0 + np.exp(circuit.cpu4_bias - circuit.cpu4_slope * memory))


def simulate(cell: Cell, seed: int) -> Arrays:
    """Courses before and after the middle of the flight, and how straight its first half is."""
    goal = wrap(2.0 * np.pi * np.arange(cell.n_trials) / cell.n_trials)
    if cell.store == "weights":
        goal = DIRECTIONS[np.arange(cell.n_trials) % N_GOALS_OF_WEIGHTS]
    start = np.random.default_rng(seed).uniform(-np.pi, np.pi, cell.n_trials)
    position = _flights(cell, goal, start, seed).astype(float)
    first, second = position[:, N_SETTLING:DISTURBED_AT], position[:, DISTURBED_AT + 2 * N_SETTLING :]
    walked = np.linalg.norm(np.diff(first, axis=1), axis=-1).sum(axis=1)
    displaced = first[:, -1] - first[:, 0]
    shown = np.linspace(0, cell.n_trials, N_SHOWN, endpoint=False).astype(int)
    degrees = {"units": "deg"}
    return {
        "goal": (("trial",), np.degrees(wrap(goal)), degrees),
        "course": (("trial",), np.degrees(bearing(displaced)), degrees),
        "course_after": (("trial",), np.degrees(bearing(second[:, -1] - second[:, 0])), degrees),
        "straightness": (("trial",), np.linalg.norm(displaced, axis=-1) / walked),
        "path": (("shown", "point", "xy"), position[shown, ::SHOWN_EVERY].astype(np.float32), {"units": "steps"}),
    }


def _flights(cell: Cell, goal: NDArray[np.floating], start: NDArray[np.floating], seed: int) -> NDArray[np.floating]:
    """Positions (trial, step, 2) of the migrants."""
    circuit = circuit_params(preset=cell.preset)
    route = straight_flight(start, 1, 0.0)
    options: dict[str, Any] = {"n_inbound": N_STEPS, "noise": _noise(cell), "seed": seed}
    if cell.store == "memory":
        perturbations = [SetMemory(memory=memory_bump(goal)), FreezeMemory(), *_disturbance(cell, goal)]
        return fly(route, circuit, perturbations=perturbations, **options).position
    position = np.empty((cell.n_trials, N_STEPS + 1, 2), np.float32)
    for k in range(min(N_GOALS_OF_WEIGHTS, cell.n_trials)):
        own = slice(k, None, N_GOALS_OF_WEIGHTS)
        flights: TrialArrays = fly(
            (route[0][own], route[1][own]),
            biased_circuit(circuit, goal[k]),
            perturbations=[FreezeMemory()],
            first_trial=k * cell.n_trials,
            **options,
        )
        position[own] = flights.position
    return position


def _noise(cell: Cell) -> float | dict[str, float]:
    """Noise of all cells alike, or stronger in the compass input."""
    if cell.disturbance != "compass noise":
        return cell.noise
    others = ("cl1", "tb1", "tn1", "tn2", "cpu4", "pontine", "cpu1")
    return {"tl": 0.4} | dict.fromkeys(others, cell.noise)


def _disturbance(cell: Cell, goal: NDArray[np.floating]) -> list[Any]:
    """What befalls the migrant half-way, or all the time."""
    match cell.disturbance:
        case "carried":
            return [Displace(step=DISTURBED_AT, by=(80.0, -60.0))]
        case "turned":
            end = DISTURBED_AT + 50
            return [ClampCells(population="cpu1", cells=range(4), rate=1.0, first_step=DISTURBED_AT, end_step=end)]
        case "weight noise":
            return [WeightNoise(sd=0.05)]
        case "reversal":
            return [SetMemory(memory=memory_bump(goal + np.pi), step=DISTURBED_AT)]
    return []


def summarise(results: Results) -> Table:
    """Errors of the held course, its spread, its change half-way, and straightness."""
    rows = []
    for cell, arrays in results:
        rows.append(
            {
                "preset": cell.preset,
                "noise": cell.noise,
                "store": cell.store,
                "disturbance": cell.disturbance,
                **circular_columns("course_error", arrays["course"] - arrays["goal"]),
                **circular_columns("course_error_after", arrays["course_after"] - arrays["goal"]),
                **circular_columns("change", arrays["course_after"] - arrays["course"]),
                **median_columns("straightness", arrays["straightness"]),
                "n": cell.n_trials,
            }
        )
    return rows


def draw(results: Results) -> Figure:
    """Flights, reversal, held course against goal, spread and straightness against noise, and disturbances."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.9), layout="constrained")
    panels = figure.subplots(2, 3)
    undisturbed: dict[str, Any] = {"store": "memory", "disturbance": "none"}
    normal, reversal = (
        results.only(preset="thesis", noise=NOISE, store="memory", disturbance=name) for name in ("none", "reversal")
    )
    draw_flights(panels[0, 0], results["path"][normal])
    draw_reversal(panels[0, 1], results["path"][reversal], SHOWN_EVERY)
    for noise in (NOISE, 0.0):
        cell = results.only(preset="thesis", noise=noise, **undisturbed)
        draw_courses(
            panels[0, 2], results["goal"][cell], results["course"][cell], f"noise {noise:g}", NOISE_COLOURS[noise]
        )
    table = summarise(results)
    for preset, colour in zip(PRESETS, ("blue", "red"), strict=True):
        own = [row for row in table if row["preset"] == preset]
        by_noise = [row for row in own if row["store"] == "memory" and row["disturbance"] == "none"]
        draw_spread(panels[1, 0], panels[1, 1], by_noise, PRESET_NAMES[preset], colour)
        noisy = [row for row in own if row["noise"] == NOISE and row["disturbance"] != "reversal"]
        rows = {DISTURBANCES[row["disturbance"]]: row for row in noisy if row["store"] == "memory"}
        (rows["bump of\nweights"],) = [row for row in noisy if row["store"] == "weights"]
        draw_disturbances(panels[1, 2], rows, PRESET_NAMES[preset], colour)
    letter_panels(panels.flat)
    return figure


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    n_trials = results.cells[0].n_trials
    return (
        f"Flights of {N_STEPS} steps with a fixed memory, a sinusoid of amplitude {AMPLITUDE:g}, for n = {n_trials} "
        f"goals evenly all round, from random headings. a, {N_SHOWN} flights at noise {NOISE:g} (thesis constants; "
        f"dashed: goals). b, course of {N_SHOWN} flights, bump reversed at step {DISTURBED_AT}. c, course held from "
        f"step {N_SETTLING} to {DISTURBED_AT} against the goal. d, e, circular SD of the error of that course, and "
        f"displacement over path length (median), against noise. f, mean and SD of the error of the course after step "
        f"{DISTURBED_AT + 2 * N_SETTLING}, at noise {NOISE:g}: undisturbed; carried off by 100 steps at step "
        f"{DISTURBED_AT}; turned there for 50 steps by current into CPU1 cells; with noise on synaptic weights; with "
        "more noise in the compass input; with the bump in the CPU4 to CPU1 weights."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Claims in words beside the thesis' constants at the noise of the paper."""
    noisy = [row for row in table if row["preset"] == "thesis" and row["noise"] == NOISE]
    by_condition = {(row["store"], row["disturbance"]): row for row in noisy}
    normal, turned = by_condition["memory", "none"], by_condition["memory", "turned"]
    weights, reversal = by_condition["weights", "none"], by_condition["memory", "reversal"]
    n = normal["n"]
    spread = normal["course_error_sd_deg"]
    ours = {
        "held course minus direction of the bump": (normal["course_error_deg"], normal["course_error_error_deg"]),
        "circular SD of the held courses": (spread, spread / np.sqrt(2.0 * n)),
        "straightness of the flight": (normal["straightness"], normal["straightness_error"]),
        "turn of the course when the bump is reversed": (reversal["change_deg"] % 360.0, reversal["change_error_deg"]),
        "course after a disturbance minus course before": (turned["change_deg"], turned["change_error_deg"]),
        "held course minus direction of biased CPU4 to CPU1 weights": (
            weights["course_error_deg"], weights["course_error_error_deg"],
        ),
    }  # fmt: skip
    why = f"undisturbed courses spread by {spread:.2f} deg (SD), their straightness is {normal['straightness']:.3f}"
    return [judge(value, *ours[name], why=why) for name, value in published.items()]
