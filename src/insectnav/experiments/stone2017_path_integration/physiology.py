"""Figs 1 to 3: the model's own compass and flow cells, recorded and analysed as the bee's were."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import wrap
from insectnav.central_complex import THESIS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import DOUBLE_COLUMN, letter_panels
from insectnav.experiments.published import Published, Verdict, judge, read_published
from insectnav.experiments.stone2017_path_integration.physiology_panels import (
    draw_axial_tuning,
    draw_expansion,
    draw_flow_tuning,
    draw_heading_tuning,
    draw_shifts,
)
from insectnav.experiments.stone2017_path_integration.physiology_table import compass_rows, find, flow_rows, lag_rows
from insectnav.experiments.stone2017_path_integration.virtual_recordings import (
    DARK,
    FlowProtocol,
    flow_protocol,
    poisson_spikes,
    recorded_rates,
    sensed_heading,
    spike_generator,
    turning_stimulus,
)
from insectnav.metrics.physiology import background_rate, mean_rate, preferred_expansion_point, tuning_curve
from insectnav.metrics.polarisation_tuning import polarisation_tuning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Reals = NDArray[np.floating[Any]]

FIGURE = "Figs 1–3"
TITLE = "compass and flow cells of the model, analysed as a lab's recordings"
COMPASS, FLOW = ("tl", "cl1", "tb1"), ("tn1", "tn2")
SPEEDS_DEG = (60.0, 30.0)  # [°/s] Methods
COMPASS_SHIFT_DEG = 26.5  # half of Fig. 1h's difference: the shift that Ext. Data Fig. 9a would need to be the bee's
TOP_FLOW_DEG = 90.0  # [°/s] Fig. 2: grating velocity taken to drive TN2 to its highest rate
VELOCITIES = np.linspace(-1.0, 1.0, 13)  # parts of that
AZIMUTHS = np.arange(-8, 8) * (np.pi / 8.0)  # [rad] of the expansion
N_BINS = 36  # of 10° in a whole turn
_AFTER = 0.5  # [s] from the end of movement: what comes later outlasts it
_TRIALS_APART = 1_000_000  # trial numbers, so that each stimulus has noise of its own


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One kind of compass stimulus; the same flow stimuli in all.

    Parameters
    ----------
    stimulus : "heading", whose angle comes back after 360°, or "polariser", after 180°
    anticipation_deg : compass shift of Ext. Data Fig. 9a [°]
    noise : σ_r of all cells
    step_ms : what a time step of the model is taken to last [ms]
    peak_rate : what a rate of 1 is taken to be [impulses/s]; Fig. 2: TN2 up to 150
    n_turns : of 360° each way and speed; Ext. Data Fig. 5b
    n_animals : one cell of each kind is recorded in each animal
    """

    stimulus: str = "heading"
    anticipation_deg: float = 0.0
    noise: float = 0.1
    step_ms: float = 10.0
    peak_rate: float = 150.0
    n_turns: int = 2
    n_animals: int = 160  # Fig. 1

    @property
    def is_polariser(self) -> bool:
        """Whether angles half a turn apart are the same."""
        return self.stimulus == "polariser"


def grid(scale: str) -> Sequence[Cell]:
    """Both stimuli with and without compass shift; a heading without noise, and with steps of 100 ms."""
    n_animals = 160 if scale == "full" else 16
    shown: list[dict[str, Any]] = [
        {"stimulus": stimulus, "anticipation_deg": shift}
        for stimulus in ("heading", "polariser")
        for shift in (0.0, COMPASS_SHIFT_DEG)
    ]
    return [Cell(n_animals=n_animals, **changes) for changes in [*shown, {"noise": 0.0}, {"step_ms": 100.0}]]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What the analyses find in each animal's cells."""
    return {**_record_compass(cell, seed), "static_rate": _static_rates(cell), **_record_flow(cell, seed)}


def _record_compass(cell: Cell, seed: int) -> dict[str, tuple]:
    """Tuning of one TL, CL1 and TB1 cell of each animal to turns both ways at both speeds."""
    shape = (len(COMPASS), len(SPEEDS_DEG), 2, cell.n_animals)
    preferred, width = np.empty(shape, np.float32), np.empty(shape, np.float32)
    is_significant = np.empty(shape, bool)
    rate = np.full((*shape, N_BINS), np.nan, np.float32)
    for k, speed in enumerate(SPEEDS_DEG):
        stimulus = turning_stimulus(speed, cell.n_turns, cell.step_ms)
        heading = sensed_heading(stimulus, np.radians(cell.anticipation_deg), cell.is_polariser)
        at_rest = np.zeros((heading.size, 2))
        for animal, rates in _recordings(cell, heading, at_rest, seed, k):
            for kind, population in enumerate(COMPASS):
                activity = rates[population]
                generator = spike_generator(seed, (animal, kind, k))
                recorded = activity[:, animal % activity.shape[1]]
                spikes = poisson_spikes(recorded, cell.step_ms, cell.peak_rate, generator)
                found = polarisation_tuning(spikes, stimulus.time, stimulus.angle, axial=cell.is_polariser)
                for way, turn in enumerate(found[:2]):
                    at = (kind, k, way, animal)
                    preferred[at], width[at] = np.degrees(turn.test.mean_angle), np.degrees(turn.width)
                    is_significant[at] = turn.test.is_significant
                    rate[at][: turn.histogram.rate.size] = turn.histogram.rate
    dimensions = ("compass_kind", "turning_speed", "way", "animal")
    return {
        "preferred_angle": (dimensions, preferred, {"units": "deg"}),
        "tuning_width": (dimensions, width, {"units": "deg"}),
        "is_significant": (dimensions, is_significant),
        "compass_rate": ((*dimensions, "bin"), rate, {"units": "1/s"}),
    }


def _recordings(cell: Cell, heading: Reals, velocity: Reals, seed: int, number: int) -> Any:
    """Rates of each animal under one stimulus, each stimulus with noise of its own."""
    options = {"seed": seed, "first_trial": number * _TRIALS_APART, "n_animals": cell.n_animals}
    return recorded_rates(heading, velocity, THESIS, noise=cell.noise, **options)


def _static_rates(cell: Cell) -> tuple:
    """Rate 0 to 1 of the first cell of each kind at every degree of a stimulus at rest, without noise or spikes."""
    n_settling = 40  # steps, in which the ring of TB1 cells comes to rest
    angle = np.radians(np.arange(360.0)) * (2.0 if cell.is_polariser else 1.0)
    heading = np.repeat(wrap(angle), n_settling)
    options = {"seed": 0, "first_trial": 0, "n_animals": 1}
    _, rates = next(recorded_rates(heading, np.zeros((heading.size, 2)), THESIS, noise=0.0, **options))
    curves = [rates[population][n_settling - 1 :: n_settling, 0] for population in COMPASS]
    return ("compass_kind", "degree"), np.array(curves, np.float32)


def _bouts(cell: Cell) -> tuple[FlowProtocol, dict[str, slice]]:
    """All bouts of optic flow, and which of them are of which kind.

    Translation along the body axis is as fast as drives the cells, whose axes lie φ_TN to either side, over their
    whole range; expansion points all round are shown at the top speed that the cells signal along those axes.
    """
    along = VELOCITIES / np.cos(THESIS.tn_preference)
    translation = np.column_stack([np.zeros_like(along), along])
    expansion = np.column_stack([np.sin(AZIMUTHS), np.cos(AZIMUTHS)])
    velocity = np.concatenate([translation, np.zeros((2, 2)), expansion])
    turning = np.zeros(len(velocity))
    ends = np.cumsum([len(translation), 2, len(expansion)])
    kinds = {
        name: slice(a, b) for name, a, b in zip(("velocity", "rotation", "azimuth"), (0, *ends), ends, strict=False)
    }
    turning[kinds["rotation"]] = np.radians([-TOP_FLOW_DEG, TOP_FLOW_DEG])
    return flow_protocol(velocity, turning, cell.step_ms), kinds


def _record_flow(cell: Cell, seed: int) -> dict[str, tuple]:
    """Rates of both TN1 and both TN2 cells of each animal in every bout, and their preferred expansion points."""
    protocol, kinds = _bouts(cell)
    shape = (len(FLOW), 2, cell.n_animals)
    conditions = {"velocity": VELOCITIES, "rotation": np.array([-1.0, 1.0]), "azimuth": AZIMUTHS}
    rate = {name: np.empty((*shape, values.size), np.float32) for name, values in conditions.items()}
    background, point = np.empty(shape, np.float32), np.empty(shape, np.float32)
    dark = np.empty((*shape, 2), np.float32)
    after = protocol.stop[kinds["velocity"]][[0, -1]] + _AFTER
    for animal, rates in _recordings(cell, protocol.heading, protocol.velocity, seed, len(SPEEDS_DEG)):
        for kind, side in np.ndindex(len(FLOW), 2):
            generator = spike_generator(seed, (animal, len(COMPASS) + kind, side))
            spikes = poisson_spikes(rates[FLOW[kind]][:, side], cell.step_ms, cell.peak_rate, generator)
            at = (kind, side, animal)
            background[at] = background_rate(spikes, protocol.onset)
            dark[at] = mean_rate(spikes, after, after + DARK - _AFTER)
            for name, values in conditions.items():
                bouts = kinds[name]
                rate[name][at] = tuning_curve(spikes, protocol.start[bouts], protocol.stop[bouts], values).rate
            point[at] = np.degrees(preferred_expansion_point(AZIMUTHS, rate["azimuth"][at]).azimuth)
    dimensions, units = ("flow_kind", "side", "animal"), {"units": "1/s"}
    return {
        "background_rate": (dimensions, background, units),
        "rate_in_dark": ((*dimensions, "end"), dark, units),
        "expansion_point": (dimensions, point, {"units": "deg"}),
        **{f"rate_by_{name}": ((*dimensions, name), values, units) for name, values in rate.items()},
    }


def summarise(results: Results) -> Table:
    """Mean, standard error and SD across animals of each quantity of each kind of cell, a row for each."""
    rows = []
    for cell, arrays in results:
        conditions = {
            "stimulus": cell.stimulus,
            "anticipation_deg": cell.anticipation_deg,
            "noise": cell.noise,
            "step_ms": cell.step_ms,
        }
        found = compass_rows(arrays, COMPASS, axial=cell.is_polariser)
        if cell.anticipation_deg == 0.0:
            found += lag_rows(arrays, COMPASS, SPEEDS_DEG, axial=cell.is_polariser, step_ms=cell.step_ms)
        rows += [conditions | row for row in [*found, *flow_rows(arrays, FLOW, VELOCITIES)]]
    return rows


def draw(results: Results) -> Figure:
    """Tuning to heading and to a polariser, shift between turns either way, tuning to flow and its expansion point."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 4.3), layout="constrained")
    places = figure.add_gridspec(2, 4, width_ratios=(1.0, 1.0, 1.0, 1.1))
    top = [figure.add_subplot(places[0, k]) for k in range(4)]
    bottom = [figure.add_subplot(places[1, k], projection="polar" if k == 3 else None) for k in range(4)]
    shown = {"noise": 0.1, "step_ms": 10.0}
    plain, shifted = (
        results.only(stimulus="heading", anticipation_deg=shift, **shown) for shift in (0.0, COMPASS_SHIFT_DEG)
    )
    polariser = results.only(stimulus="polariser", anticipation_deg=0.0, **shown)
    polariser_shifted = results.only(stimulus="polariser", anticipation_deg=COMPASS_SHIFT_DEG, **shown)
    bees = read_published(Path(__file__).with_name("published.csv"), "stone2017-physiology")
    draw_heading_tuning(top[:3], results["compass_rate"][[plain, shifted]].mean(axis=2), COMPASS)
    draw_axial_tuning(top[3], results["compass_rate"][polariser], COMPASS, bees["tuning width of TL"].value)
    published_shift = bees["shift between clockwise and anticlockwise turns, TL"].value
    draw_shifts(bottom[0], results["preferred_angle"][[polariser, polariser_shifted]], COMPASS, published_shift)
    for axes, kind in ((bottom[1], "tn2"), (bottom[2], "tn1")):
        index = FLOW.index(kind)
        rates = results["rate_by_velocity"][plain, index], results["background_rate"][plain, index]
        draw_flow_tuning(axes, *rates, TOP_FLOW_DEG * VELOCITIES, kind)
    draw_expansion(bottom[3], results["rate_by_azimuth"][plain], results["expansion_point"][plain], AZIMUTHS, FLOW)
    letter_panels((top[0], top[3], bottom[0], bottom[1], bottom[3]))
    return figure


def caption(results: Results) -> str:
    """What is shown, of how many animals, and what was assumed."""
    cell = results.cells[0]
    n_alike = len(range(2, cell.n_animals, 8))
    return (
        f"Cells of the model, recorded as in a lab: noise {cell.noise:g}, n = {cell.n_animals} animals, one cell of "
        f"each kind in each. Assumed: a rate of 1 is {cell.peak_rate:g} impulses/s, with Poisson spikes; a time step "
        f"is {cell.step_ms:g} ms; a grating at {TOP_FLOW_DEG:g}°/s drives TN2 to its highest rate; the compass is told "
        "a heading, or twice the angle of a polariser, as the model has no cells for polarised light. a, Rate against "
        f"heading ({cell.n_turns} turns each way at {SPEEDS_DEG[0]:g} and {SPEEDS_DEG[1]:g}°/s) of the cells that are "
        f"wired to 90°, mean and SD of n = {n_alike}; dashed: with a compass shift of {COMPASS_SHIFT_DEG:g}° into the "
        "turn (Ext. Data Fig. 9a). b, Tuning to a polariser as in Fig. 1f, mean of the animals, both ways and speeds; "
        "bar: width at half maximum published for TL and CL1. c, Preferred angle of the polariser in anticlockwise "
        "minus that in clockwise turns, each animal at both speeds; dashed: published mean. d, TN2 and TN1 against "
        "velocity of translational flow (points: mean and SD; line: fit; band: background and its SD). e, Rate against "
        "the azimuth of the expansion, mean of the animals, and preferred points (ticks on the rim). Not simulated: "
        "receptive fields for moving bars, as the model's TN cells have no retina. The cells shown are the same under "
        "both sets of constants."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Published numbers and claims beside the recordings with noise and without compass shift."""
    conditions = {"anticipation_deg": 0.0, "noise": 0.1, "step_ms": 10.0}
    light = find(table, stimulus="polariser", **conditions)
    ours = find(table, stimulus="heading", **conditions)
    shifted = find(table, stimulus="polariser", **(conditions | {"anticipation_deg": COMPASS_SHIFT_DEG}))
    quantities = _compass_quantities(light, ours, shifted) | _flow_quantities(ours)
    return [judge(value, **quantities[name]) for name, value in published.items()]


def _ours(rows: Mapping[tuple[str, str], Mapping[str, Any]], kind: str, quantity: str) -> dict[str, Any]:
    row = rows[kind, quantity]
    return {"ours": row["value"], "uncertainty": row["standard_error"]}


def _compass_quantities(light: Any, heading: Any, shifted: Any) -> dict[str, dict[str, Any]]:
    """What the recordings of compass cells give for each published quantity."""
    found: dict[str, dict[str, Any]] = {}
    for kind in ("TL", "CL1"):
        static, broad = (rows[kind, "tuning width without spikes"]["value"] for rows in (light, heading))
        moved = shifted[kind, "shift"]
        found[f"tuning width of {kind}"] = _ours(light, kind, "tuning width") | {
            "why": f"set by slopes and biases of the cells that were not fitted to it: the rates themselves, without "
            f"spikes or noise, have {static:.1f} deg for a polariser and {broad:.1f} deg for a heading"
        }
        found[f"shift between clockwise and anticlockwise turns, {kind}"] = _ours(light, kind, "shift") | {
            "why": f"these cells follow the present stimulus, without anticipation; with a compass shift of "
            f"{COMPASS_SHIFT_DEG:g} deg (Ext. Data Fig. 9a) the same analysis finds {moved['value']:.1f} ± "
            f"{moved['standard_error']:.1f} deg"
        }
    tuned = [light[kind, "share significantly tuned"] for kind in ("TL", "CL1")]
    found["share of TL and CL1 cells tuned to the polariser"] = {
        "ours": float(np.mean([row["value"] for row in tuned])),
        "uncertainty": float(np.hypot(*(row["standard_error"] for row in tuned)) / 2.0),
    }
    for extreme in ("least", "largest"):
        spacing = _ours(heading, "TB1", f"{extreme} spacing of preferred angles")
        found[f"{extreme} spacing of the preferred headings of TB1 cells"] = spacing
    return found


def _flow_quantities(rows: Any) -> dict[str, dict[str, Any]]:
    """What the recordings of flow cells give for each published quantity."""
    scale = "the model has rates from 0 to 1; how many impulses/s 1 stands for is assumed"
    dark = rows["TN1", "response to darkness after backward flow"]
    outlasting = {
        "why": f"TN cells of the model follow the present flow: from 0.5 to 3 s after backward flow the rate is the "
        f"background's plus {dark['value']:.3f} ± {dark['standard_error']:.3f} of the peak"
    }
    found = {
        "R² of a line through the rate of TN2 against forward velocity": _ours(rows, "TN2", "R² forward"),
        "rate of TN2 at 90 deg/s of forward flow": _ours(rows, "TN2", "peak rate") | {"not_comparable": scale},
        "peak rate of TN1": _ours(rows, "TN1", "peak rate") | {"not_comparable": scale},
        "share of TN1 cells whose response outlasts the stimulus": _ours(rows, "TN1", "share outlasting") | outlasting,
        "preferred expansion point of TN2 from straight ahead": _ours(rows, "TN2", "expansion point from body axis"),
        "preferred expansion point of TN1 from straight behind": _ours(rows, "TN1", "expansion point from body axis"),
        "least angle between the four preferred expansion points": _ours(
            rows, "TN", "least angle between expansion points"
        ),
        "azimuth where the receptive field of TN cells changes direction": {
            "ours": np.nan,
            "not_comparable": "not simulated: TN cells of the model are given flow, without a retina for bars",
        },
    }
    responses = {
        "TN2 in forward flow": ("TN2", "response to forward flow"),
        "TN1 in forward flow": ("TN1", "response to forward flow"),
        "TN1 in backward flow": ("TN1", "response to backward flow"),
        "TN2 in rotational flow": ("TN2", "response to rotational flow"),
        "TN1 in rotational flow": ("TN1", "response to rotational flow"),
    }
    return found | {f"{name}, change over peak": _ours(rows, *key) for name, key in responses.items()}
