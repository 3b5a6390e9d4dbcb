"""Extended Data Fig. 9a: how near the agent comes to the nest under six kinds of disturbance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.agents.perturbations import CompassShift, FilterSpeed, ScaleSpeed, WeightNoise
from insectnav.central_complex import PRESETS, CircuitParams, circuit_params, decode_home_vector
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.disturbance_panels import draw_panels
from insectnav.experiments.stone2017_path_integration.straight_flights import fly
from insectnav.experiments.stone2017_path_integration.trips import HOME_RANGE, N_STEPS, NOISE_LEVELS, random_trips
from insectnav.metrics.path_integration import bearing_error, length_ratio, summary
from insectnav.metrics.statistics import N_RESAMPLES, SEED, bootstrap_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 9a"
TITLE = "closest distance to the nest against six kinds of disturbance"
ANGLES_DEG = tuple(float(angle) for angle in np.linspace(0.0, 90.0, 9))  # x · 90°/8, x = 0 … 8
VALUES: dict[str, tuple[float, ...]] = {
    "noise": NOISE_LEVELS,
    "compass": ANGLES_DEG,
    "flow": ANGLES_DEG,
    "weights": (0.0, 0.01, 0.02, 0.05, 0.1, 0.2),
    "speed": (1.0, 1.4, 1.8, 2.2, 2.6, 3.0),
    "filter": (1.0, 2.0, 5.0, 10.0, 20.0, 50.0),
}
FORMS = {  # ways to do it; the first is drawn at both noise levels
    "weights": ("signs kept", "unclipped", "variance"),
    "filter": ("clean", "code-2017"),
}
NOISE = 0.1  # of all panels but the first
CONSTANT_FLOW = 0.5  # middle of the range of TN2, where the filter's noise is measured
N_LISTENED, LISTENED, SETTLING = 16, 700, 300  # trials, steps, steps that the filter takes to settle


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One disturbance of one size under one set of constants."""

    panel: str
    value: float
    form: str = ""
    preset: str
    noise: float
    n_trials: int = 1000  # Ext. Data Fig. 9a


def grid(scale: str) -> Sequence[Cell]:
    """All disturbances, each with and without noise, in each form, under both sets of constants."""
    n_trials = 1000 if scale == "full" else 32
    return [
        Cell(panel=panel, value=value, form=form, preset=preset, noise=noise, n_trials=n_trials)
        for panel, values in VALUES.items()
        for form in FORMS.get(panel, ("",))
        if scale == "full" or form != "unclipped"
        for preset in PRESETS
        for value in values
        for noise in ((value,) if panel == "noise" else (NOISE, 0.0))
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Closest distance of each trial, the decoded over the true distance at the turn, and the noise of TN2."""
    circuit, perturbations = disturbed(cell)
    arrays = random_trips(cell.n_trials, circuit, noise=cell.noise, seed=seed, perturbations=perturbations)
    decoded = decode_home_vector(arrays.memory_at_turn, circuit)
    way = -arrays.position[:, N_STEPS - 1]
    tn2_sd = _tn2_sd(circuit, perturbations, cell.noise, seed) if cell.panel == "filter" else np.nan
    return {
        "closest_distance": (("trial",), arrays.closest_distance, {"units": "steps"}),
        "decoded_over_true": (("trial",), length_ratio(decoded, way)),
        "bearing_error": (("trial",), bearing_error(decoded, way), {"units": "rad"}),
        "tn2_sd": ((), np.array(tn2_sd)),
    }


def disturbed(cell: Cell) -> tuple[CircuitParams, list[Any]]:
    """The circuit of a cell and what is done to it."""
    circuit = circuit_params(preset=cell.preset)
    if cell.panel == "flow":
        return replace(circuit, tn_preference=np.radians(cell.value)), []
    if cell.panel == "compass":
        return circuit, [CompassShift(shift=np.radians(cell.value))]
    if cell.panel == "weights":
        sd = float(np.sqrt(cell.value)) if cell.form == "variance" else cell.value
        return circuit, [WeightNoise(sd=sd, keep_signs=cell.form != "unclipped")]
    if cell.panel == "speed":
        return circuit, [ScaleSpeed(factor=cell.value)]
    if cell.panel == "filter":
        return circuit, [FilterSpeed(n_steps=int(cell.value), form=cell.form)]
    return circuit, []


def _tn2_sd(circuit: CircuitParams, perturbations: Sequence[Any], noise: float, seed: int) -> float:
    """SD of the rate of TN2 on a straight flight whose flow is constant."""
    heading = np.zeros((N_LISTENED, LISTENED), np.float32)
    velocity = np.zeros((N_LISTENED, LISTENED, 2), np.float32)
    velocity[..., 1] = CONSTANT_FLOW / np.cos(circuit.tn_preference)
    route = heading, velocity
    flights = fly(route, circuit, noise=noise, seed=seed, record=("tn2",), perturbations=perturbations)
    return float(np.std(flights.activity[:, SETTLING:], dtype=float))


def summarise(results: Results) -> Table:
    """Closest distance and decoded distance under each disturbance."""
    return [_row(cell, arrays) for cell, arrays in results]


def _row(cell: Cell, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    closest = summary(arrays["closest_distance"])
    return {
        "panel": cell.panel,
        "form": cell.form,
        "preset": cell.preset,
        "value": cell.value,
        "noise": cell.noise,
        "n": cell.n_trials,
        "mean": closest.mean,
        "sd": closest.sd,
        "mean_standard_error": closest.sd / np.sqrt(closest.n),
        "median": closest.median,
        "median_standard_error": bootstrap_error(arrays["closest_distance"], np.median),
        "within_home_range": float(np.mean(arrays["closest_distance"] <= HOME_RANGE)),
        "median_decoded_over_true": summary(arrays["decoded_over_true"]).median,
        "decoded_over_true_standard_error": bootstrap_error(arrays["decoded_over_true"], np.median),
        "median_absolute_bearing_error_deg": float(np.degrees(np.median(np.abs(arrays["bearing_error"])))),
        "tn2_sd": float(arrays["tn2_sd"]),
    }


def draw(results: Results) -> Figure:
    """Six panels of mean ± SD."""
    return draw_panels(summarise(results))


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    return (
        f"Closest distance to the nest (mean ± SD) in {N_STEPS} steps home after a random trip of {N_STEPS} steps, n "
        f"= {results.cells[0].n_trials} trials for each point and the same routes in all. Dashed grey: the home range "
        f"of {HOME_RANGE:g} steps. Blue: noise {NOISE:g}, green: none; filled, solid: thesis constants, open, dashed: "
        "those of the 2017 code (drawn a little to the right). a, Noise of all cells. b, Compass shifted in the "
        "direction of the last turn on the way home; orange line: half of the 53° found between the two directions "
        "of turning in Megalopta. c, Preferred flow direction of TN2 from the body axis; orange line: Megalopta. d, "
        "Weights drawn once for each trial, relative SD; purple: the same numbers taken as variances, as the thesis "
        "prints them, at noise 0.1. Noise that may change signs, as in the 2017 code, is in the table: at these SDs "
        "it hardly ever does. e, Acceleration on the way out. f, Exponential moving average of the flow; red: with "
        "the noise added to the filter's own state, as in the 2017 code, at noise 0.1."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """All that the text says of the six panels, under both sets of constants."""
    ours = {name: numbers for preset in PRESETS for name, numbers in _quantities(table, preset).items()}
    return [judge(value, *ours[name][:2], why=ours[name][2]) for name, value in published.items()]


def _quantities(table: Table, preset: str) -> dict[str, tuple[float, float, str]]:
    """Ours, its standard error and, where it may differ, the measured reason; by name of the quantity."""

    def row(panel: str, value: float, noise: float, form: str | None = None) -> Mapping[str, Any]:
        form = FORMS.get(panel, ("",))[0] if form is None else form
        return next(
            r for r in table
            if (r["panel"], r["value"], r["noise"], r["form"], r["preset"]) == (panel, value, noise, form, preset)
        )  # fmt: skip

    def closest(r: Mapping[str, Any], why: str = "") -> tuple[float, float, str]:
        return r["mean"], r["mean_standard_error"], why

    found = {
        "closest distance at noise 0.1": closest(row("noise", 0.1, 0.1)),
        "closest distance at noise 0.2": closest(row("noise", 0.2, 0.2), _skew(row("noise", 0.2, 0.2))),
        "decoded over true distance at speed 3": (
            row("speed", 3.0, NOISE)["median_decoded_over_true"],
            row("speed", 3.0, NOISE)["decoded_over_true_standard_error"],
            "",
        ),
    }
    for noise in (0.0, NOISE):
        words = f"noise {noise:g}"

        def of(panel: str, noise: float = noise) -> dict[float, Mapping[str, Any]]:
            return {value: row(panel, value, noise) for value in VALUES[panel]}

        weights, speed, flow, compass = of("weights"), of("speed"), of("flow"), of("compass")
        best, best_error = _best(compass)
        found |= {
            f"closest distance at weight noise 0.05, {words}": closest(weights[0.05], _skew(weights[0.05])),
            f"weight noise 0.2 over 0.05, {words}": _ratio(weights[0.2], weights[0.05]),
            f"closest distance at speed 1.4, {words}": closest(speed[1.4], _skew(speed[1.4])),
            f"speed 3 over 1.4, {words}": _ratio(speed[3.0], speed[1.4]),
            f"preferred flow 67.5 over 45 deg, {words}": _ratio(flow[67.5], flow[45.0], _flow_scan(flow)),
            f"best compass shift, {words}": (best, best_error, _scan(compass)),
            f"best compass shift over none, {words}": _ratio(compass[best], compass[0.0], _scan(compass)),
            f"compass shift 90 deg over best, {words}": _ratio(compass[90.0], compass[best]),
        }
        if noise:
            worst = max((flow[angle] for angle in ANGLES_DEG if angle <= 45.0), key=lambda r: r["mean"])
            found["worst closest distance at preferred flow up to 45 deg, noise 0.1"] = closest(worst, _skew(worst))
        else:
            found["best preferred flow, noise 0"] = (*_best(flow), _flow_scan(flow))
    for n in VALUES["filter"][1:]:
        clean, slip = (row("filter", n, NOISE, form) for form in FORMS["filter"])
        found[f"closest distance with a clean filter of {n:g} steps"] = closest(clean, _filter_reason(n, clean, slip))
        found[f"closest distance with the 2017 filter of {n:g} steps"] = closest(slip, _filter_reason(n, clean, slip))
    return {f"{name}, {preset}": numbers for name, numbers in found.items()}


def _ratio(top: Mapping[str, Any], bottom: Mapping[str, Any], why: str = "") -> tuple[float, float, str]:
    """Ratio of two means, its standard error and the reason."""
    ratio = top["mean"] / bottom["mean"]
    relative = np.hypot(top["mean_standard_error"] / top["mean"], bottom["mean_standard_error"] / bottom["mean"])
    return ratio, float(ratio * relative), why or f"{_skew(top)}; below, {_skew(bottom)}"


def _skew(row: Mapping[str, Any]) -> str:
    return (
        f"the mean is {row['mean']:.1f} and the median {row['median']:.1f} steps, {row['within_home_range']:.0%} of "
        f"the trials come within {HOME_RANGE:g} steps"
    )


def _best(rows: Mapping[float, Mapping[str, Any]]) -> tuple[float, float]:
    """Angle of the smallest mean, and its SD where each mean is off by a draw from its standard error."""
    means, errors = (np.array([rows[angle][name] for angle in ANGLES_DEG]) for name in ("mean", "mean_standard_error"))
    draws = np.random.default_rng(SEED).normal(means, errors, (N_RESAMPLES, means.size))
    return ANGLES_DEG[int(np.argmin(means))], float(np.std(np.take(ANGLES_DEG, np.argmin(draws, axis=1))))


def _scan(rows: Mapping[float, Mapping[str, Any]]) -> str:
    """What was found over all angles."""
    return (
        f"from 0 to 90 deg in steps of 11.25 the means are {_values(rows, 'mean')} and the medians "
        f"{_values(rows, 'median')} steps"
    )


def _flow_scan(rows: Mapping[float, Mapping[str, Any]]) -> str:
    """The same, and whether it lies in the memory or on the way home."""
    error = "median_absolute_bearing_error_deg"
    best = min(ANGLES_DEG, key=lambda angle: rows[angle][error])
    return (
        f"{_scan(rows)}, but the bearing in the memory is off by {_values(rows, error)} deg (medians), least at "
        f"{best:g}: the difference arises on the way home, not in the memory"
    )


def _values(rows: Mapping[float, Mapping[str, Any]], name: str) -> str:
    return ", ".join(f"{rows[angle][name]:.1f}" for angle in ANGLES_DEG)


def filter_noise(n_steps: float, noise: float) -> float:
    """SD of a filter's state into which noise is added at each step: σ / √(1 − (1 − 1/n)²)."""
    return float(noise / np.sqrt(1.0 - (1.0 - 1.0 / n_steps) ** 2))


def _filter_reason(n: float, clean: Mapping[str, Any], slip: Mapping[str, Any]) -> str:
    return (
        f"TN2 at a constant flow of {CONSTANT_FLOW:g} varies by an SD of {clean['tn2_sd']:.3f} behind the clean "
        f"filter and {slip['tn2_sd']:.3f} where the noise goes into the filter's state, which has "
        f"{filter_noise(n, NOISE):.3f} before it is clipped; medians {clean['median']:.1f} and {slip['median']:.1f} "
        "steps"
    )
