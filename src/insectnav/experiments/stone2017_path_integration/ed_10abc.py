"""Extended Data Fig. 10a-c: current injected into compass, speed and steering cells."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.perturbations import ClampCells
from insectnav.angles import bearing, unit_vector, wrap
from insectnav.central_complex import PRESETS, circuit_params, decode_home_vector, decode_waggle_dance
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import DOUBLE_COLUMN, letter_panels
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.columns import (
    circular_columns,
    mean_columns,
    median_columns,
    share_columns,
)
from insectnav.experiments.stone2017_path_integration.injection_panels import (
    draw_compass_shift,
    draw_injected_paths,
    draw_spirals,
)
from insectnav.experiments.stone2017_path_integration.straight_flights import fly, straight_flight
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, PRESET_NAMES
from insectnav.metrics.path_integration import departure_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 10a–c"
TITLE = "current injected into compass, speed and steering cells"
N_OUTBOUND, SPEED = 500, 0.5  # [steps], [steps per time step]
N_INBOUND = 800
N_INJECTED = 200  # Supplementary Discussion
FIRST_STEP = {"out": 150, "home": N_OUTBOUND + 100}  # the text gives no time: the middle of either leg
NOISE = 0.1  # Ext. Data Fig. 9: the level of all trials with disturbances
SOUTH_DEG, NORTH_DEG = 180.0, 0.0
NUMBERS = {1: "one CPU1 cell is", 2: "two CPU1 cells are", 3: "three CPU1 cells are", 4: "four CPU1 cells are"}
FULL = 0.99  # a memory cell that cannot take up more, or only what it loses
N_ENLARGED = 30  # [steps] of the injected stretch
SHOWN_COLUMN = 1  # of the first CPU1 cell in the figure


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One injection: neighbouring cells of a population, on one leg of a straight flight and the way home."""

    preset: str
    population: str  # "none": no injection
    leg: str = "out"
    first_cell: int = 0
    n_cells: int = 1
    heading_deg: float = SOUTH_DEG
    n_trials: int = 1000

    def clamps(self) -> list[ClampCells]:
        """The injection; cells of one side of the brain are counted round in a circle."""
        if self.population == "none":
            return []
        n_columns = 2 if self.population == "tn2" else 8
        cells = tuple((self.first_cell + k) % n_columns for k in range(self.n_cells))
        first_step = FIRST_STEP[self.leg]
        end_step = first_step + N_INJECTED
        return [ClampCells(population=self.population, cells=cells, rate=1.0, first_step=first_step, end_step=end_step)]


def grid(scale: str) -> Sequence[Cell]:
    """Every TB1 cell on both legs, both TN2 cells facing south and north, and one to four CPU1 cells from each column.

    CPU1 cells are those of one side, which turn the agent to the right; the other side is its mirror image.
    """
    n_trials = 1000 if scale == "full" else 64
    both_ways = (SOUTH_DEG, NORTH_DEG)
    cells: list[dict[str, Any]] = [{"population": "none", "heading_deg": h, "n_cells": 0} for h in both_ways]
    cells += [{"population": "tb1", "first_cell": k, "leg": leg} for leg in ("out", "home") for k in range(8)]
    cells += [{"population": "tn2", "first_cell": k, "heading_deg": h} for h in both_ways for k in range(2)]
    cells += [
        {"population": "cpu1", "first_cell": k, "n_cells": n, "leg": "home"} for n in range(1, 5) for k in range(8)
    ]
    return [Cell(preset=preset, n_trials=n_trials, **cell) for preset in PRESETS for cell in cells]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What the memory holds at the turn, with and without noise, and what the agent does on the way home.

    At zero noise the agent faces straight away from home, an unstable point: there the memory alone is used.
    """
    circuit, clamps = circuit_params(preset=cell.preset), cell.clamps()
    heading = np.radians(cell.heading_deg)
    clean = fly(straight_flight(heading, N_OUTBOUND, SPEED), circuit, perturbations=clamps, dtype="float64")
    clean_dance = decode_waggle_dance(clean.memory_at_turn[0], circuit)
    route = straight_flight(np.full(cell.n_trials, heading), N_OUTBOUND, SPEED)
    trials = fly(
        route, circuit, n_inbound=N_INBOUND, noise=NOISE, seed=seed, perturbations=clamps, record=("motor", "tb1")
    )
    dance = decode_waggle_dance(trials.memory_at_turn, circuit)
    to_nest = np.broadcast_to(-unit_vector(heading), (cell.n_trials, 2))
    stored_home = wrap(bearing(decode_home_vector(trials.memory_at_turn, circuit)) - bearing(to_nest))
    course = departure_error(trials.position[:, N_OUTBOUND - 1 :], HOME_RANGE)
    first = FIRST_STEP["home"]
    during = trials.position[:, first - 1 : first + N_INJECTED].astype(float)
    flown = np.linalg.norm(np.diff(during, axis=1), axis=-1).sum(axis=1)
    turned = trials.activity[:, first : first + N_INJECTED, 8].sum(axis=1, dtype=float)
    drift = wrap(bearing(during[:, -1] - during[:, 0]) - bearing(to_nest))
    degrees, steps = {"units": "deg"}, {"units": "steps"}
    return {
        "shift_without_noise": ((), np.degrees(wrap(clean_dance.bearing - heading)), degrees),
        "distance_without_noise": ((), clean_dance.distance, steps),
        "shift": (("trial",), np.degrees(wrap(dance.bearing - heading)), degrees),
        "distance": (("trial",), dance.distance.astype(float), steps),
        "share_full": ((), np.mean(trials.memory_at_turn > FULL)),
        "course_minus_stored": (("trial",), np.degrees(wrap(course - stored_home)), degrees),
        "course_during": (("trial",), np.degrees(drift), degrees),
        "turned": (("trial",), turned / (2.0 * np.pi), {"units": "turns"}),
        "radius": (("trial",), flown / np.abs(turned), steps),
        "compass": (("direction",), trials.activity[:, FIRST_STEP["out"] - 1, :8].mean(axis=0)),
        "path": (("step", "xy"), trials.position[0].astype(np.float32), steps),
    }


def summarise(results: Results) -> Table:
    """Stored vectors and turning of each injection, with standard errors."""
    rows = []
    for cell, arrays in results:
        normal = results.only(preset=cell.preset, population="none", heading_deg=cell.heading_deg)
        rows.append(_row(cell, arrays, {name: values[normal] for name, values in results.arrays.items()}))
    return rows


def _row(cell: Cell, arrays: Mapping[str, Any], normal: Mapping[str, Any]) -> dict[str, Any]:
    """Means over trials; the trials of the injection and of the normal flight share their noise."""
    distance, turned = arrays["distance"], arrays["turned"]
    ratio = distance.mean() / normal["distance"].mean()
    rest = (distance - ratio * normal["distance"]) / normal["distance"].mean()  # error of a ratio of paired means
    return {
        "preset": cell.preset,
        "population": cell.population,
        "leg": cell.leg,
        "first_cell": cell.first_cell,
        "n_cells": cell.n_cells,
        "heading_deg": cell.heading_deg,
        "shift_without_noise_deg": float(arrays["shift_without_noise"]),
        "distance_ratio_without_noise": float(arrays["distance_without_noise"] / normal["distance_without_noise"]),
        **circular_columns("shift", arrays["shift"]),
        "rate_before": float(arrays["compass"][cell.first_cell]) if cell.population == "tb1" else math.nan,
        "share_full": float(arrays["share_full"]),
        "distance_ratio": float(ratio),
        "distance_ratio_error": mean_columns("rest", rest)["rest_error"],
        **mean_columns("stored_east", distance * np.sin(np.radians(cell.heading_deg + arrays["shift"]))),
        **circular_columns("course_minus_stored", arrays["course_minus_stored"]),
        **circular_columns("course_during", arrays["course_during"]),
        **mean_columns("turned", turned),
        **share_columns("share_turned_right", turned > 0.0),
        **median_columns("radius", arrays["radius"]),
        "n": cell.n_trials,
    }


def draw(results: Results) -> Figure:
    """A row for each set of constants: paths with a TB1 cell, its shift, paths with TN2 and with CPU1 injected."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 5.6), layout="constrained")
    panels = figure.subplots(len(PRESETS), 5, width_ratios=(1.0, 1.1, 0.8, 1.5, 0.7))
    for row, preset in zip(panels, PRESETS, strict=True):
        _draw_outbound(row[:3], results, preset)
        cpu1 = results.where(preset=preset, population="cpu1", first_cell=SHOWN_COLUMN)
        normal = results.only(preset=preset, population="none", heading_deg=SOUTH_DEG)
        shown = {"none": normal} | {str(n): int(index) for n, index in zip(NUMBERS, cpu1, strict=True)}
        draw_injected_paths(row[3], results["path"], shown, _stretch("home"), N_OUTBOUND, apart=110.0)
        draw_spirals(row[4], results["path"][cpu1], _stretch("home"), n_steps=N_ENLARGED, apart=15.0)
        row[0].set_ylabel(f"{PRESET_NAMES[preset]}\ny (steps)")
    letter_panels(panels[0, [0, 2, 3]])
    for axes, title in ((panels[1, 0], "TB1 cell"), (panels[1, 2], "TN2 cell")):
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2, title=title, columnspacing=1.0)
    panels[0, 3].set_title("number of CPU1 cells", fontsize=7.0)
    panels[0, 4].set_title("enlarged", fontsize=7.0)
    return figure


def _draw_outbound(panels: Sequence[Axes], results: Results, preset: str) -> None:
    """TB1: paths and shifts; TN2: paths."""
    out, facing = {"preset": preset, "leg": "out"}, round(SOUTH_DEG / 45.0)
    normal = results.only(population="none", heading_deg=SOUTH_DEG, **out)
    tb1 = results.where(population="tb1", **out)
    shown = {"none": normal} | {f"{k}": int(tb1[k]) for k in (facing - 1, facing, facing + 1)}
    draw_injected_paths(panels[0], results["path"], shown, _stretch("out"), N_OUTBOUND)
    draw_compass_shift(panels[1], results["compass"][normal], results["shift"][tb1])
    for heading, hidden in ((SOUTH_DEG, ""), (NORTH_DEG, "_")):
        right, left = results.where(population="tn2", heading_deg=heading, **out)
        shown = {f"{hidden}left": int(left), f"{hidden}right": int(right)}
        draw_injected_paths(panels[2], results["path"], shown, _stretch("out"), N_OUTBOUND)


def _stretch(leg: str) -> slice:
    """Samples of the injected stretch of a path, with the one it starts from."""
    return slice(FIRST_STEP[leg] - 1, FIRST_STEP[leg] + N_INJECTED)


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    cell = results.cells[0]
    return (
        f"Output of chosen cells set to 1 for {N_INJECTED} steps (pale blue), at noise {NOISE:g}, after {N_OUTBOUND} "
        f"steps of tethered flight at speed {SPEED:g}; one of n = {cell.n_trials} trials is drawn, way out in grey. "
        "a, one TB1 cell on the way out, due south, and the shift of the stored bearing by each of the eight (points "
        "and lines: mean and SD of the trials; bars: rates of the TB1 cells before the injection). b, one TN2 cell on "
        "the way out, facing south and north. c, one to four neighbouring CPU1 cells that turn the agent to the right, "
        f"from step {FIRST_STEP['home'] - N_OUTBOUND} of the way home on (paths side by side), and the first "
        f"{N_ENLARGED} steps of that."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Numbers restored from the 2017 code beside ours with its constants, claims in words beside the thesis'."""
    code = [row for row in table if row["preset"] == "code-2017"]
    thesis = [row for row in table if row["preset"] == "thesis"]
    ours, restored = _findings(thesis), _findings(code)
    ours |= {name: restored[name] for name, value in published.items() if "2017 code" in value.how_read}
    return [judge(value, *ours[name][:2], why=ours[name][2]) for name, value in published.items()]


def _findings(rows: Table) -> dict[str, tuple[float, float, str]]:
    """Value, standard error and what was measured beside it, by the name of the quantity."""
    tb1 = _select(rows, population="tb1", leg="out")
    rates = ", ".join(f"{row['rate_before']:.2f}" for row in tb1)
    tn2 = _select(rows, population="tn2", heading_deg=SOUTH_DEG)[0]
    cpu1 = _select(rows, population="cpu1")
    spread = ", ".join(
        f"{min(row['turned'] for row in _select(cpu1, n_cells=n)):.1f} to "
        f"{max(row['turned'] for row in _select(cpu1, n_cells=n)):.1f}"
        for n in NUMBERS
    )
    whys = (
        f"the rates of TB1 cells 0 to 7 before the injection are {rates}",
        f"without noise the shift is {tn2['shift_without_noise_deg']:.1f} deg and the ratio "
        f"{tn2['distance_ratio_without_noise']:.2f}; {100.0 * tn2['share_full']:.0f} % of the memory cells are full",
        f"by the column of the first cell, one to four cells make it turn {spread} times",
    )
    findings = (_compass_cells(rows), _speed_cells(rows), _steering_cells(rows))
    return {name: (*value, why) for part, why in zip(findings, whys, strict=True) for name, value in part.items()}


def _select(rows: Table, **wanted: Any) -> list[Mapping[str, Any]]:
    return [row for row in rows if all(row[name] == value for name, value in wanted.items())]


def _compass_cells(rows: Table) -> dict[str, tuple[float, float]]:
    """TB1: value and standard error; of mirror images the weaker where an effect is claimed, else the strongest."""
    out, home = (_select(rows, population="tb1", leg=leg) for leg in ("out", "home"))
    shift = [(abs(row["shift_deg"]), row["shift_error_deg"]) for row in out]
    course = max((abs(row["course_during_deg"]), row["course_during_error_deg"]) for row in home)
    facing = round(SOUTH_DEG / 45.0)  # the column of the heading, about which the compass activity is symmetric
    beside = [(facing - 1) % 8, (facing + 1) % 8]
    others = [shift[cell] for cell in range(8) if cell not in beside]
    strongest = max(range(8), key=lambda cell: shift[cell])
    # TB1 is inhibited at the heading: the peak of its activity is four columns from there
    from_peak = 180.0 - 45.0 * abs((strongest - facing + 4) % 8 - 4)
    memory = [(row["course_minus_stored_deg"], row["course_minus_stored_error_deg"]) for row in out]
    return {
        "shift of the stored bearing by a TB1 cell beside the bump": min(shift[cell] for cell in beside),
        "largest shift of the stored bearing by any other TB1 cell": max(others),
        "angle from the peak of TB1 activity to the cell with most effect": (from_peak, 0.0),
        # one cell at eight headings 45° apart is the same as eight cells at one heading: the columns form a circle
        "range of the effect of one TB1 cell over eight headings": (max(shift)[0] - min(shift)[0], max(shift)[1]),
        "change of course while a TB1 cell is injected on the way home": course,
        "course home minus direction of the stored home with a TB1 cell injected": max(
            (memory[cell] for cell in beside), key=lambda value: abs(value[0])
        ),
    }


def _speed_cells(rows: Table) -> dict[str, tuple[float, float]]:
    """TN2: the mean of both sides facing south, the ratio of facing south to facing north."""
    south = _select(rows, population="tn2", heading_deg=SOUTH_DEG)
    north = _select(rows, population="tn2", heading_deg=NORTH_DEG)
    towards = [1.0 - 2.0 * row["first_cell"] for row in south]  # cell 0 looks to the right, cell 1 to the left
    shift = sum(side * row["shift_deg"] for side, row in zip(towards, south, strict=True)) / 2.0
    a, b = south[0], north[0]
    opposite = a["stored_east"] / b["stored_east"]
    relative = math.hypot(a["stored_east_error"] / a["stored_east"], b["stored_east_error"] / b["stored_east"])
    return {
        "shift of the stored bearing by TN2 towards the injected side": (shift, _pooled(south, "shift_error_deg")),
        "stored distance with TN2 injected over that without": (
            sum(row["distance_ratio"] for row in south) / 2.0,
            _pooled(south, "distance_ratio_error"),
        ),
        "eastward shift by TN2 facing south over that facing north": (opposite, abs(opposite) * relative),
    }


def _steering_cells(rows: Table) -> dict[str, tuple[float, float]]:
    """CPU1: means over the eight columns from which one to four neighbours are counted."""
    cpu1 = _select(rows, population="cpu1")
    ours: dict[str, tuple[float, float]] = {}
    for n, words in NUMBERS.items():
        columns = _select(cpu1, n_cells=n)
        turned = sum(row["turned"] for row in columns) / len(columns)
        ours[f"full turns while {words} injected"] = (turned, _pooled(columns, "turned_error"))
    radius = {n: np.array([row["radius"] for row in _select(cpu1, n_cells=n)]) for n in (2, 4)}
    tightness = radius[4] / radius[2]
    ours["radius of turning with four CPU1 cells over that with two"] = (
        float(tightness.mean()), float(tightness.std(ddof=1) / np.sqrt(tightness.size)),
    )  # fmt: skip
    ranks = np.argsort(np.argsort([row["turned"] for row in cpu1]))
    correlation = float(np.corrcoef([row["n_cells"] for row in cpu1], ranks)[0, 1])
    ours["rank correlation of the number of CPU1 cells with the angle turned"] = (
        correlation, (1.0 - correlation**2) / math.sqrt(len(cpu1) - 1),
    )  # fmt: skip
    share = sum(row["share_turned_right"] for row in cpu1) / len(cpu1)
    n_trials = sum(row["n"] for row in cpu1)
    ours["share of trials that turn to the side of the injected CPU1 cells"] = (
        share, math.sqrt(share * (1.0 - share) / n_trials),
    )  # fmt: skip
    return ours


def _pooled(rows: Table, error: str) -> float:
    """Standard error of the mean of several rows."""
    return math.sqrt(sum(row[error] ** 2 for row in rows)) / len(rows)
