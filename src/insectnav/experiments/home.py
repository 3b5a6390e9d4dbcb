"""Home from a recorded track: fly the circuit along it, let it steer back, and measure how well it did."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.agents.motion import MotionParams
from insectnav.agents.recorded_routes import MAX_STEPS, route_from_track
from insectnav.agents.routes import RouteParams, route_arrays
from insectnav.agents.simulation import TrialArrays, TrialParams, simulate_trials
from insectnav.agents.trials import describe, split_recorded
from insectnav.central_complex import PRESETS, VARIANTS, circuit_params, decode_home_vector
from insectnav.checks import InputError, check_choice, check_count, check_range
from insectnav.experiments.figure_process import HOME_FIGURE, FigureProcess
from insectnav.experiments.results import PROVENANCE, provenance, results_folder, to_json, write_arrays, write_table
from insectnav.metrics.path_integration import bearing_error, length_ratio, summary
from insectnav.metrics.straightness import distance_left, tortuosity
from insectnav.records import Track

Reals = NDArray[np.floating[Any]]

SEARCH_RADIUS = 20.0  # [steps] thesis, Ext. Data Fig. 8: the home range that counts as found
RANDOM_STEPS = 1500  # thesis, Fig. 5a
MAX_TRIALS = 1_000_000
MAX_DRAWN = 100  # ways home in the figure
POINTS_DRAWN = 500  # of each way home but the first
MAX_SAMPLES = 100_000_000  # of all trials: about 3 GB at the most
SHOWN = ("tl", "cl1", "tb1", "tn2", "memory", "cpu4", "pontine", "cpu1")  # thesis, Fig. 5b


@dataclass(frozen=True, kw_only=True)
class HomeParams:
    """What `insectnav home` is run with.

    Raises
    ------
    InputError
        If a name is unknown or a number out of its range.
    """

    preset: str = "thesis"
    variant: str = "partially-holonomic"
    noise: float = 0.1  # σ_r, thesis Fig. 5
    n_trials: int = 100
    n_inbound: int | None = None  # default: see `homing_steps`
    seed: int = 0

    def __post_init__(self) -> None:
        check_choice("preset", self.preset, PRESETS)
        check_choice("variant", self.variant, VARIANTS)
        check_range("noise", self.noise, 0.0, 10.0)
        check_count("trials", self.n_trials)
        check_range("trials", self.n_trials, 1, MAX_TRIALS)
        check_count("seed", self.seed, minimum=0)
        if self.n_inbound is not None:
            check_count("homing steps", self.n_inbound)
            check_range("homing steps", self.n_inbound, 1, MAX_STEPS)


class Trip(NamedTuple):
    """An outbound journey in the steps of the model, and what its steps are."""

    name: str
    heading: Reals  # (step,) [rad]
    velocity: Reals  # (step, 2) [steps per time step]
    nest: Reals  # (2,) [length_unit]
    steps_per_unit: float
    length_unit: str
    time_per_step: float
    time_unit: str
    heading_source: str
    notes: tuple[str, ...]
    track: Mapping[str, Any]  # what was read

    @property
    def turning_point(self) -> Reals:
        """Where the way home starts, seen from the nest, (2,) [steps]."""
        return self.velocity.sum(axis=0)

    @property
    def ends_at_nest(self) -> bool:
        """True where the way home is shorter than a step, which has no direction worth the name."""
        return bool(np.linalg.norm(self.turning_point) < 1.0)


class Homing(NamedTuple):
    """A trip and the ways home from it."""

    trip: Trip
    params: TrialParams
    arrays: TrialArrays
    activity: Mapping[str, Reals]  # (step, cell) of trial 0, by population
    home_vector: Reals  # (trial, 2) [steps] as decoded at the turning point


def random_trip(seed: int) -> Trip:
    """A random foraging trip of 1500 steps."""
    heading, velocity = route_arrays(1, RANDOM_STEPS, RouteParams(), seed)
    return Trip(
        name="random foraging trip",
        heading=heading[0],
        velocity=velocity[0],
        nest=np.zeros(2),
        steps_per_unit=1.0,
        length_unit="step",
        time_per_step=1.0,
        time_unit="step",
        heading_source="model",
        notes=(),
        track={},
    )


def recorded_trip(track: Track, steps_per_unit: float | None = None) -> Trip:
    """An animal's track as a trip; see `insectnav.agents.route_from_track`."""
    route = route_from_track(track, steps_per_unit=steps_per_unit)
    return Trip(
        name=track.name,
        heading=route.heading,
        velocity=route.velocity,
        nest=route.nest,
        steps_per_unit=route.steps_per_unit,
        length_unit=track.length_unit,
        time_per_step=route.time_per_step,
        time_unit=track.time_unit,
        heading_source=route.heading_source,
        notes=(*track.notes, *route.notes),
        track={
            "samples": track.n_samples,
            "samples_interpolated": track.n_interpolated,
            "duration": track.duration,
            "length": float(np.linalg.norm(np.diff(track.position, axis=0), axis=1).sum()),
        },
    )


def homing_steps(trip: Trip, motion: MotionParams) -> int:
    """Time for the way home when none is asked for: as long as out, or twice the straight way if that is longer."""
    terminal_speed = motion.acceleration * (1.0 - motion.drag) / motion.drag
    straight = float(np.linalg.norm(trip.turning_point))
    return max(len(trip.heading), int(np.ceil(2.0 * straight / terminal_speed)))


def simulate(trip: Trip, params: HomeParams, progress: Callable[[int], None] | None = None) -> Homing:
    """Ways home from the end of a trip, and the activity of all cells in the first of them."""
    motion = MotionParams()
    settings: dict[str, Any] = {
        "circuit": circuit_params(params.variant, params.preset),
        "motion": motion,
        "n_inbound": params.n_inbound or homing_steps(trip, motion),
        "noise": params.noise,
        "seed": params.seed,
    }
    trials = TrialParams(**settings)
    n_trials = params.n_trials
    if (n_samples := n_trials * (len(trip.heading) + trials.n_inbound)) > MAX_SAMPLES:
        raise InputError(
            f"trials times steps are {n_samples:.2g}, expected {MAX_SAMPLES:.0e} at most: fewer trials or homing steps?"
        )
    heading = np.broadcast_to(trip.heading, (n_trials, *trip.heading.shape))
    velocity = np.broadcast_to(trip.velocity, (n_trials, *trip.velocity.shape))
    arrays = simulate_trials(heading, velocity, np.arange(n_trials), trials, progress=progress)
    recorded = TrialParams(**settings, record=SHOWN)
    first = simulate_trials(heading[:1], velocity[:1], np.arange(1), recorded)
    activity = {name: cells[0] for name, cells in split_recorded(first.activity, recorded.recorded).items()}
    return Homing(trip, trials, arrays, activity, decode_home_vector(arrays.memory_at_turn, trials.circuit))


def summarise(homing: Homing) -> list[dict[str, Any]]:
    """One row for each measure, lengths in the unit of the track."""
    trip, arrays = homing.trip, homing.arrays
    unit, per_unit = trip.length_unit, trip.steps_per_unit
    true_vector = np.broadcast_to(-trip.turning_point, homing.home_vector.shape)
    if trip.ends_at_nest:
        true_vector = np.full_like(true_vector, np.nan)  # there is no home vector to compare with
    error = np.degrees(bearing_error(homing.home_vector, true_vector))
    way_home = arrays.position[:, len(trip.heading) - 1 :]
    left = np.full(len(way_home), np.nan) if trip.ends_at_nest else distance_left(way_home)
    measures = {
        "closest_distance": (unit, arrays.closest_distance / per_unit),
        "came_within_search_radius": ("share of trials", arrays.closest_distance <= SEARCH_RADIUS),
        "decoded_bearing_error": ("deg", error),
        "decoded_bearing_error_absolute": ("deg", np.abs(error)),
        "decoded_length": (unit, np.linalg.norm(homing.home_vector, axis=-1) / per_unit),
        "decoded_over_true_length": ("1", length_ratio(homing.home_vector, true_vector)),
        "straightness": ("1", 1.0 - left),
    }
    rows = [{"quantity": name, "unit": u, **summary(values)._asdict()} for name, (u, values) in measures.items()]
    blank = dict.fromkeys(("median", "sd", "p90"), float("nan"))
    straight = float(np.linalg.norm(trip.turning_point)) / per_unit
    return [
        {"quantity": "distance_of_turning_point", "unit": unit, "mean": straight, **blank, "n": 1},
        *rows,
        {"quantity": "tortuosity", "unit": "1", "mean": tortuosity(left), **blank, "n": rows[-1]["n"]},
    ]


def figure_data(homing: Homing) -> dict[str, Any]:
    """What the figure shows, as arrays."""
    trip, n_outbound = homing.trip, len(homing.trip.heading)
    position = trip.nest + homing.arrays.position[:MAX_DRAWN] / trip.steps_per_unit
    stride = max(1, homing.params.n_inbound // POINTS_DRAWN)
    return {
        "name": trip.name,
        "unit": trip.length_unit,
        "nest": trip.nest,
        "outbound": position[0, :n_outbound],
        "first_homing": position[0, n_outbound - 1 :],
        "homing": position[1:, n_outbound - 1 :: stride],
        "n_trials": len(homing.arrays.position),
        "search_radius": SEARCH_RADIUS / trip.steps_per_unit,
        "home_vector": homing.home_vector / trip.steps_per_unit,
        "time_per_step": trip.time_per_step,
        "time_unit": trip.time_unit,
        **{f"activity_{name}": cells for name, cells in homing.activity.items()},
    }


def report(homing: Homing, rows: list[dict[str, Any]], params: HomeParams) -> dict[str, Any]:
    """Everything a program may want to know of a result."""
    trip = homing.trip
    return {
        "name": trip.name,
        "track": dict(trip.track),
        "scale": {
            "length_unit": trip.length_unit,
            "steps_per_length_unit": trip.steps_per_unit,
            "time_unit": trip.time_unit,
            "time_per_step": trip.time_per_step,
            "outbound_steps": len(trip.heading),
            "homing_steps": homing.params.n_inbound,
            "search_radius": SEARCH_RADIUS / trip.steps_per_unit,
        },
        "heading": trip.heading_source,
        "settings": {"preset": params.preset, "variant": params.variant, "trials": params.n_trials}
        | {"noise": params.noise, "seed": params.seed},
        "results": {row["quantity"]: {k: v for k, v in row.items() if k != "quantity"} for row in rows},
        "notes": [*trip.notes, *_notes(homing, rows)],
    }


def _notes(homing: Homing, rows: list[dict[str, Any]]) -> list[str]:
    """What the result itself makes worth saying."""
    trip, memory, notes = homing.trip, homing.arrays.memory_at_turn, []
    if trip.track.get("samples_interpolated"):
        notes.append(f"{trip.track['samples_interpolated']} missing samples were interpolated or cut off at the ends")
    if trip.ends_at_nest:
        notes.append("the track ends where it started: cut it at the turning point, there is no way home to measure")
    elif rows[-1]["n"] < len(memory):
        notes.append(f"{len(memory) - rows[-1]['n']} ways home are too short to measure their straightness")
    if saturated := float(np.mean((memory <= 0.0) | (memory >= 1.0))):
        notes.append(
            f"{100.0 * saturated:.0f} % of the memory cells were saturated at the turning point, which shortens the "
            "home vector: try fewer --steps-per-unit"
        )
    return notes


def run(
    trip: Trip,
    params: HomeParams,
    destination: str | PathLike[str],
    figure: FigureProcess | None = None,
    progress: Callable[[int], None] | None = None,
) -> dict[str, Any]:
    """Simulate, measure, draw, and leave it all in a folder: the report, also as JSON.

    Parameters
    ----------
    trip : Trip
    params : HomeParams
    destination : path
        A new folder, or one of earlier results, which is replaced.
    figure : FigureProcess, optional
        One for `insectnav.experiments.home_figure`, if it could be started earlier.
    progress : callable, optional
        Called with the number of trials just finished.

    Raises
    ------
    InputError
        If the destination cannot be written.
    """
    started = time.perf_counter()
    with results_folder(destination) as folder, figure or FigureProcess(HOME_FIGURE) as drawing:
        homing = simulate(trip, params, progress)
        drawing.draw(figure_data(homing), folder)
        rows = summarise(homing)
        result = report(homing, rows, params)
        write_table(folder / "table.csv", rows)
        write_arrays(folder / "data.zarr", _arrays(homing), describe(homing.params) | {"scale": result["scale"]})
        (folder / "summary.json").write_text(to_json(result) + "\n", encoding="utf-8")
        drawing.finish()
        (folder / PROVENANCE).write_text(to_json(provenance(time.perf_counter() - started)) + "\n", encoding="utf-8")
    return result


def _arrays(homing: Homing) -> dict[str, tuple]:
    """Names, dimensions and units of what goes into data.zarr."""
    trip, arrays = homing.trip, homing.arrays
    unit = {"units": trip.length_unit}
    position = trip.nest + arrays.position / trip.steps_per_unit
    is_homing = np.arange(arrays.heading.shape[1]) >= len(trip.heading)
    variables: dict[str, tuple] = {
        "trial": (("trial",), np.arange(len(arrays.heading))),
        "step": (("step",), np.arange(arrays.heading.shape[1])),
        "leg": (("step",), is_homing.astype(np.int8), {"flag_values": [0, 1], "flag_meanings": "out home"}),
        "heading": (("trial", "step"), arrays.heading, {"units": "rad", "zero": "+y", "positive": "clockwise"}),
        "position": (("trial", "step", "xy"), position.astype(arrays.position.dtype, copy=False), unit),
        "memory_at_turn": (("trial", "cell"), arrays.memory_at_turn),
        "home_vector_at_turn": (("trial", "xy"), homing.home_vector / trip.steps_per_unit, unit),
        "closest_distance": (("trial",), arrays.closest_distance / trip.steps_per_unit, unit),
    }
    for name, cells in homing.activity.items():
        variables[f"{name}_of_trial_0"] = (("step", f"{name}_cell"), cells)
    return variables
