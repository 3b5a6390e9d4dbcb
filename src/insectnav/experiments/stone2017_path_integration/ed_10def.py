"""Extended Data Fig. 10d-f: the body looks another way than it flies; three circuits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import circular_mean, unit_vector, wrap
from insectnav.central_complex import PRESETS, circuit_params, decode_waggle_dance
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.body_offsets import (
    COURSE_DEG,
    N_INBOUND,
    N_OUTBOUND,
    RANDOM,
    SPEED,
    STEPS_PER_OFFSET,
    search_place,
    southward_flight,
    stored_bearing_error,
    turned_body,
)
from insectnav.experiments.stone2017_path_integration.columns import circular_columns, mean_columns, share_columns
from insectnav.experiments.stone2017_path_integration.straight_flights import fly
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, PRESET_NAMES
from insectnav.metrics.path_integration import departure_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 10d–f"
TITLE = "optic flow from another direction than the body's: three circuits"
VARIANTS = ("non-holonomic", "partially-holonomic", "fully-holonomic")  # d, e, f
OFFSETS_DEG = (0.0, 45.0, -45.0, 90.0, 135.0, 180.0, RANDOM)
NOISE = 0.1  # Ext. Data Fig. 9: the level of all trials with disturbances
N_SHOWN = 3  # paths of each condition
ARROWS_AT = -110.0  # [steps] east of the path


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One circuit with one angle between body and course."""

    preset: str
    variant: str
    offset_deg: float  # positive clockwise; `RANDOM`: drawn anew every 25 steps
    n_trials: int = 1000


def grid(scale: str) -> Sequence[Cell]:
    """All offsets for the three circuits under both sets of constants."""
    n_trials = 1000 if scale == "full" else 100
    return [
        Cell(preset=preset, variant=variant, offset_deg=offset, n_trials=n_trials)
        for preset in PRESETS
        for variant in VARIANTS
        for offset in OFFSETS_DEG
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What the memory holds at the turn, with and without noise, where the agent goes, and how near it comes.

    Without noise the memory alone is used: an agent that faces straight away from home is then at an unstable point.
    """
    circuit = circuit_params(cell.variant, cell.preset)
    is_fixed = cell.offset_deg != RANDOM
    error, ratio = stored_bearing_error(circuit, cell.offset_deg) if is_fixed else (math.nan, math.nan)
    trials = fly(
        southward_flight(cell.n_trials),
        circuit,
        n_inbound=N_INBOUND,
        noise=NOISE,
        seed=seed,
        perturbations=[turned_body(cell.offset_deg)],
    )
    dance = decode_waggle_dance(trials.memory_at_turn, circuit)
    angle, share = search_place(trials.position)
    course = departure_error(trials.position[:, N_OUTBOUND - 1 :], HOME_RANGE)
    degrees, steps = {"units": "deg"}, {"units": "steps"}
    return {
        "bearing_error_without_noise": ((), np.float64(np.degrees(error)), degrees),
        "distance_ratio_without_noise": ((), np.float64(ratio)),
        "bearing_error": (("trial",), np.degrees(wrap(dance.bearing - np.radians(COURSE_DEG))), degrees),
        "distance_ratio": (("trial",), dance.distance.astype(float) / (N_OUTBOUND * SPEED)),
        "course_error": (("trial",), np.degrees(course), degrees),
        "search_angle": (("trial",), np.degrees(angle), degrees),
        "search_share": (("trial",), share),
        "closest_distance": (("trial",), trials.closest_distance.astype(float), steps),
        "path": (("shown", "step", "xy"), trials.position[:N_SHOWN].astype(np.float32), steps),
        "body": (("outbound",), trials.heading[0, :N_OUTBOUND].astype(np.float32), {"units": "rad"}),
    }


def summarise(results: Results) -> Table:
    """Errors of the stored vector and of the way home, with standard errors."""
    rows = []
    for cell, arrays in results:
        row: dict[str, Any] = {
            "preset": cell.preset,
            "variant": cell.variant,
            "offset": "random" if cell.offset_deg == RANDOM else f"{cell.offset_deg:g}",
            "bearing_error_without_noise_deg": float(arrays["bearing_error_without_noise"]),
            "distance_ratio_without_noise": float(arrays["distance_ratio_without_noise"]),
            **circular_columns("bearing_error", arrays["bearing_error"]),
            **mean_columns("distance_ratio", arrays["distance_ratio"]),
            **circular_columns("course_error", arrays["course_error"]),
            **circular_columns("search_angle", arrays["search_angle"]),
            **mean_columns("search_share", arrays["search_share"]),
            **share_columns("share_home", arrays["closest_distance"] < HOME_RANGE),
            "median_closest_distance": float(np.median(arrays["closest_distance"])),
            "n": cell.n_trials,
        }
        rows.append(row)
    return rows


def draw(results: Results) -> Figure:
    """A row for each circuit, a column for each offset; the two sets of constants in two colours."""
    from matplotlib.figure import Figure

    shown = [offset for offset in OFFSETS_DEG if offset >= 0.0]
    figure = Figure(figsize=(DOUBLE_COLUMN, 4.6), layout="constrained")
    panels = figure.subplots(len(VARIANTS), len(shown), sharex=True, sharey=True)
    for letter, variant, row in zip("def", VARIANTS, panels, strict=True):
        for offset, axes in zip(shown, row, strict=True):
            for preset, colour in zip(PRESETS, ("blue", "red"), strict=True):
                index = results.only(preset=preset, variant=variant, offset_deg=offset)
                _draw_paths(axes, results["path"][index], colour, PRESET_NAMES[preset])
            _draw_body(axes, results["path"][index][0], results["body"][index])
            if letter == "d":
                axes.set_title("random" if offset == RANDOM else f"{offset:g}°", fontsize=7.0)
        row[0].set_ylabel(f"{variant}\ny (steps)")
        name_panel(row[0], letter)
    figure.supxlabel("x (steps)", fontsize=7.0)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


def _draw_paths(axes: Axes, paths: NDArray[np.floating], colour: str, label: str) -> None:
    """The nest, the way out and some ways home."""
    for k, path in enumerate(paths):
        home = path[N_OUTBOUND - 1 :]
        axes.plot(*home.T, color=COLOURS[colour], linewidth=0.6, label="_" if k else label, zorder=3)
    axes.plot(0.0, 0.0, marker="o", color="white", markeredgecolor="black", markersize=3.0, linestyle="none", zorder=5)
    axes.set_aspect("equal")
    axes.set_xlim(-170.0, 170.0)
    axes.set_ylim(-290.0, 90.0)


def _draw_body(axes: Axes, path: NDArray[np.floating], body: NDArray[np.floating]) -> None:
    """The way out and, beside it, grey arrows along the body."""
    axes.plot(*path[:N_OUTBOUND].T, color="black", linewidth=0.8, zorder=2)
    steps = np.arange(STEPS_PER_OFFSET // 2, N_OUTBOUND, 4 * STEPS_PER_OFFSET)
    arrow = 34.0 * unit_vector(body[steps])
    start = path[steps] + [ARROWS_AT, 0.0] - arrow / 2.0
    axes.quiver(
        *start.T, *arrow.T, color=COLOURS["grey"], angles="xy", scale_units="xy", scale=1.0, width=0.015,
        headwidth=4.0, headlength=5.0, headaxislength=4.5,
    )  # fmt: skip


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    n_trials = results.cells[0].n_trials
    index = [results.only(preset="thesis", variant=VARIANTS[1], offset_deg=offset) for offset in (45.0, 90.0)]
    clean = results["bearing_error_without_noise"][index] + 0.0
    noisy = np.degrees(circular_mean(np.radians(results["bearing_error"][index])))
    errors = " and ".join(f"{a:.1f}° ({b:.1f}° without noise)" for a, b in zip(noisy, clean, strict=True))
    return (
        f"Flights of {N_OUTBOUND} steps due south at speed {SPEED:g} (black) with the body (grey arrows beside the "
        f"path) turned by the angle above each column, or by a random one every {STEPS_PER_OFFSET} steps, and the "
        f"{N_INBOUND} steps home at noise {NOISE:g} ({N_SHOWN} of n = {n_trials} trials for each set of constants). "
        "Circle: nest. d, circuit with one speed signal for both sides; e, the circuit of the paper; f, with TN1 cells "
        "and a memory that can be subtracted from. The bearing that e stores is off by "
        f"{errors} at 45° and 90°."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Numbers restored from the 2017 code beside ours with its constants, claims in words beside the thesis'."""
    ours: dict[str, tuple[float, float, str]] = {}
    for preset in ("thesis", "code-2017"):
        for name, value in _quantities([row for row in table if row["preset"] == preset]).items():
            is_restored = name in published and "2017 code" in published[name].how_read
            if is_restored == (preset == "code-2017"):
                ours[name] = value
    return [judge(value, *ours[name][:2], why=ours[name][2]) for name, value in published.items()]


def _quantities(rows: Table) -> dict[str, tuple[float, float, str]]:
    """Value, standard error and what was measured beside it, by the name of the quantity."""
    ours: dict[str, tuple[float, float, str]] = {}
    for row in rows:
        condition = "random offsets" if row["offset"] == "random" else f"{row['offset']} deg"
        at = f"at {condition}, {row['variant']}"
        closest = f"the median closest distance is {row['median_closest_distance']:.0f} steps"
        length = f"the stored distance is {row['distance_ratio']:.3f} of the true one"
        bearing = f"the stored bearing is off by {row['bearing_error_deg']:.1f} deg"
        spread = f"{length}, and its bearing spreads by {row['bearing_error_sd_deg']:.0f} deg"
        stored = row["bearing_error_deg"]
        if row["offset"] == "180" and stored < -90.0:
            stored += 360.0  # the same angle, on the side of the offset
        ours |= {
            f"error of the stored bearing {at}": (stored, row["bearing_error_error_deg"], spread),
            f"course home minus direction of home {at}": (
                row["course_error_deg"], row["course_error_error_deg"], bearing,
            ),
            f"share of trials home {at}": (row["share_home"], row["share_home_error"], closest),
            f"direction of the search from the turning point {at}": (
                row["search_angle_deg"], row["search_angle_error_deg"], bearing,
            ),
            f"distance flown home over that of the nest {at}": (
                row["search_share"], row["search_share_error"], length,
            ),
        }  # fmt: skip
    return ours
