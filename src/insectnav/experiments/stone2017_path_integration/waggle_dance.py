"""The place of the agent, read out of its memory as a waggle dance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.angles import bearing, unit_vector, wrap
from insectnav.central_complex import PRESETS, VARIANTS, circuit_params, decode_waggle_dance
from insectnav.central_complex.connectivity import DIRECTIONS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import DOUBLE_COLUMN, letter_panels
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.body_offsets import (
    N_INBOUND,
    N_OUTBOUND,
    RANDOM,
    SPEED,
    search_place,
    southward_flight,
    turned_body,
)
from insectnav.experiments.stone2017_path_integration.columns import circular_columns, mean_columns, median_columns
from insectnav.experiments.stone2017_path_integration.straight_flights import fly
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS, NOISE_LEVELS, PRESET_NAMES
from insectnav.experiments.stone2017_path_integration.waggle_panels import (
    draw_bearings,
    draw_distances,
    draw_mismatch,
    draw_noise,
    draw_variants,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "text: Supplementary Notes and Discussion"
TITLE = "waggle dances: bearing and distance read out of the memory"
STANDARD = "partially-holonomic"
NOISE = 0.1  # Ext. Data Fig. 9: the level of all trials with disturbances
OFFSETS_DEG = (0.0, 45.0, 90.0, RANDOM)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Read-outs after random trips, or after straight flights with the body turned, and then a way home."""

    preset: str
    variant: str
    noise: float
    trip: str = "random"  # or "turned body"
    offset_deg: float = 0.0
    n_trials: int = 1000


def grid(scale: str) -> Sequence[Cell]:
    """All noise levels of the circuit of the paper, two of the others, and four angles between body and course."""
    n_trials = 1000 if scale == "full" else 100
    conditions: list[dict[str, Any]] = [{"variant": STANDARD, "noise": noise} for noise in NOISE_LEVELS]
    conditions += [{"variant": v, "noise": noise} for v in VARIANTS if v != STANDARD for noise in (0.0, NOISE)]
    conditions += [
        {"variant": STANDARD, "noise": NOISE, "trip": "turned body", "offset_deg": offset} for offset in OFFSETS_DEG
    ]
    return [Cell(preset=preset, n_trials=n_trials, **condition) for preset in PRESETS for condition in conditions]


def simulate(cell: Cell, seed: int) -> Arrays:
    """True and decoded places of the turning points, and where the agent then looks for the nest."""
    circuit = circuit_params(cell.variant, cell.preset)
    has_offset = cell.trip == "turned body"
    if has_offset:
        route = southward_flight(cell.n_trials)
    else:
        route = route_arrays(cell.n_trials, N_STEPS, RouteParams(), seed)
    trials = fly(
        route,
        circuit,
        n_inbound=N_INBOUND if has_offset else 0,
        noise=cell.noise,
        seed=seed,
        perturbations=[turned_body(cell.offset_deg)] if has_offset else [],
        dtype="float64",
    )
    nothing = np.full(cell.n_trials, np.nan)
    angle, share = search_place(trials.position) if has_offset else (nothing, nothing)
    n_outbound = len(route[0][0])
    true = trials.position[:, n_outbound - 1]
    dance = decode_waggle_dance(trials.memory_at_turn, circuit)
    degrees, steps = {"units": "deg"}, {"units": "steps"}
    return {
        "true_bearing": (("trial",), np.degrees(bearing(true)), degrees),
        "true_distance": (("trial",), np.linalg.norm(true, axis=-1), steps),
        "bearing": (("trial",), np.degrees(dance.bearing), degrees),
        "distance": (("trial",), dance.distance, steps),
        "place_error": (
            ("trial",), np.linalg.norm(dance.distance[:, None] * unit_vector(dance.bearing) - true, axis=-1), steps,
        ),
        "bearing_of_2017_code": (("trial",), np.degrees(mirrored_bearing(trials.memory_at_turn)), degrees),
        "bearing_of_peak": (("trial",), np.degrees(peak_bearing(trials.memory_at_turn)), degrees),
        "search_angle": (("trial",), np.degrees(angle), degrees),
        "search_share": (("trial",), share),
    }  # fmt: skip


def mirrored_bearing(memory: NDArray[np.floating]) -> NDArray[np.floating]:
    """What the 2017 code returns as bearing, arg F (...) [rad], with F as in `decode_waggle_dance`.

    Parameters
    ----------
    memory : (..., 16) array
    """
    return wrap(np.angle(np.fft.fft(aligned_columns(memory), axis=-1)[..., 1]))


def peak_bearing(memory: NDArray[np.floating]) -> NDArray[np.floating]:
    """Bearing out (...) [rad] as the column with the highest charge says it: a multiple of 45°.

    Parameters
    ----------
    memory : (..., 16) array

    Notes
    -----
    F of a lone peak in column k is e^(−i k π/4), and the bearing out is −arg F.
    """
    return wrap(DIRECTIONS[np.argmax(aligned_columns(memory), axis=-1)])


def aligned_columns(memory: NDArray[np.floating]) -> NDArray[np.floating]:
    """Sum (..., 8) of both halves of the memory (..., 16), turned back by the 45° at which their noduli cells look."""
    return np.roll(memory[..., :8], 1, axis=-1) + np.roll(memory[..., 8:], -1, axis=-1)


def summarise(results: Results) -> Table:
    """Errors of bearing, distance and place for each condition, and of dance and search against each other."""
    return [_row(cell, arrays) for cell, arrays in results]


def _row(cell: Cell, arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    error = _wrap_deg(arrays["bearing"] - arrays["true_bearing"])
    ratio = arrays["distance"] / arrays["true_distance"]
    has_search = bool(np.isfinite(arrays["search_share"]).all())
    correlation = float(np.corrcoef(arrays["distance"], arrays["search_share"])[0, 1]) if has_search else math.nan
    return {
        "preset": cell.preset,
        "variant": cell.variant,
        "noise": cell.noise,
        "trip": cell.trip,
        "offset": "random" if cell.offset_deg == RANDOM else f"{cell.offset_deg:g}",
        **circular_columns("bearing_error", error),
        **median_columns("absolute_bearing_error_deg", np.abs(error)),
        **median_columns(
            "absolute_peak_error_deg", np.abs(_wrap_deg(arrays["bearing_of_peak"] - arrays["true_bearing"]))
        ),
        **circular_columns("mirrored_sum", arrays["bearing_of_2017_code"] + arrays["true_bearing"]),
        **circular_columns("dance_minus_search", error - arrays["search_angle"]),
        **median_columns("distance_ratio", ratio),
        "distance_ratio_q1": float(np.percentile(ratio, 25)),
        "distance_ratio_q3": float(np.percentile(ratio, 75)),
        **mean_columns("mean_distance_ratio", ratio),
        "largest_place_error": float(arrays["place_error"].max()),
        "distance_correlation": correlation,
        "distance_correlation_error": (1.0 - correlation**2) / math.sqrt(cell.n_trials - 1),
        "n": cell.n_trials,
    }


def _wrap_deg(degrees: NDArray[np.floating]) -> NDArray[np.floating]:
    return np.degrees(wrap(np.radians(degrees)))


def draw(results: Results) -> Figure:
    """Decoded against true bearing and distance, dances after false optic flow, and errors by noise and circuit."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.8), layout="constrained")
    panels = figure.subplots(2, 3)
    standard = {"variant": STANDARD, "trip": "random"}
    noisy = results.only(preset="thesis", noise=NOISE, **standard)
    draw_bearings(
        panels[0, 0], results["true_bearing"][noisy], results["bearing"][noisy], results["bearing_of_2017_code"][noisy]
    )
    for noise, colour in ((0.0, "black"), (NOISE, "blue")):
        index = results.only(preset="thesis", noise=noise, **standard)
        draw_distances(panels[0, 1], results["true_distance"][index], results["distance"][index], f"{noise:g}", colour)
    for preset, colour in zip(PRESETS, ("blue", "red"), strict=True):
        turned = results.where(preset=preset, trip="turned body")
        error = _wrap_deg(results["bearing"][turned] - results["true_bearing"][turned])
        labels = [
            "random" if results.cells[k].offset_deg == RANDOM else f"{results.cells[k].offset_deg:g}°" for k in turned
        ]
        draw_mismatch(panels[0, 2], error, results["search_angle"][turned], labels, PRESET_NAMES[preset], colour)
    rows = [row for row in summarise(results) if row["trip"] == "random" and row["preset"] == "thesis"]
    draw_noise(panels[1, 0], panels[1, 1], [row for row in rows if row["variant"] == STANDARD])
    draw_variants(panels[1, 2], [row for row in rows if row["noise"] in (0.0, NOISE)])
    letter_panels(panels.flat)
    return figure


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    n_trials = results.cells[0].n_trials
    return (
        f"Place of the turning point as the memory holds it, after random trips of {N_STEPS} steps (a, b, d-f; thesis "
        f"constants; n = {n_trials} trips, the same in all conditions) and after {N_OUTBOUND} steps due south at speed "
        f"{SPEED:g} with the body turned (c). a, bearing at noise {NOISE:g}, and what the 2017 code returns, mirrored. "
        "b, distance. c, error of the danced bearing against that of the direction in which the agent then "
        f"searches for the nest ({N_INBOUND} steps), medians and quartiles for each angle between body and course. "
        "d, error of the bearing of the sinusoid and of the column with the highest charge, medians and standard "
        "errors. e, danced over true distance, medians and quartiles. f, the same for the five circuits without noise "
        f"(filled) and at noise {NOISE:g} (open)."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Numbers restored from the 2017 code beside ours with its constants, claims in words beside the thesis'."""
    ours = _quantities(table, "thesis")
    restored = _quantities(table, "code-2017")
    ours |= {name: restored[name] for name, value in published.items() if "2017 code" in value.how_read}
    return [judge(value, *ours[name][:2], why=ours[name][2]) for name, value in published.items()]


def _quantities(table: Table, preset: str) -> dict[str, tuple[float, float, str]]:
    """Value, standard error and what was measured beside it, by the name of the quantity."""

    def only(**wanted: Any) -> Mapping[str, Any]:
        wanted = {"preset": preset, "trip": "random"} | wanted
        (row,) = [row for row in table if all(row[name] == value for name, value in wanted.items())]
        return row

    clean, noisy = (only(variant=STANDARD, noise=noise) for noise in (0.0, NOISE))
    exact = only(variant="idealised", noise=0.0)
    random = only(trip="turned body", offset="random")
    idealised = f"in the idealised circuit it is {exact['distance_ratio']:.5f}"
    length = f"at noise {NOISE:g} the ratio is {noisy['distance_ratio']:.3f}, {idealised}"
    spread = f"the bearing errs by {clean['bearing_error_sd_deg']:.1f} deg (SD) without noise"
    far = f"the largest error of place is {clean['largest_place_error']:.1f} steps in the circuit of the paper"
    danced = f"the danced distance is {random['distance_ratio']:.2f} of the true one"
    ours = {
        f"absolute error of the danced bearing without noise, {STANDARD}": (
            *_value(clean, "absolute_bearing_error_deg"), spread,
        ),
        f"danced over true distance without noise, {STANDARD}": (*_value(clean, "distance_ratio"), length),
        "largest error of the decoded place, idealised": (exact["largest_place_error"], 0.0, far),
        "arg F of the 2017 code plus the true bearing": (
            clean["mirrored_sum_deg"], clean["mirrored_sum_error_deg"], spread,
        ),
        "absolute error of the bearing of the peak column without noise": (
            *_value(clean, "absolute_peak_error_deg"), spread,
        ),
        "danced distance against the distance flown home at random offsets": (
            *_value(random, "distance_correlation"), danced,
        ),
    }  # fmt: skip
    for offset in ("45", "90"):
        row = only(trip="turned body", offset=offset)
        ours[f"danced minus homing error of bearing at {offset} deg body offset"] = (
            row["dance_minus_search_deg"], row["dance_minus_search_error_deg"],
            f"the danced bearing is off by {row['bearing_error_deg']:.1f} deg",
        )  # fmt: skip
    return ours


def _value(row: Mapping[str, Any], name: str) -> tuple[float, float]:
    return row[name], row[f"{name}_error"]
