"""Ext. Data Fig. 7: memories are sinusoids that add, and their comparison turns the agent towards home."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.agents.motion import MotionParams
from insectnav.agents.simulation import TrialParams, simulate_trials
from insectnav.angles import bearing, unit_vector, wrap
from insectnav.central_complex import (
    PRESETS,
    CircuitParams,
    Senses,
    circuit_params,
    decode_home_vector,
    initial_state,
    step,
)
from insectnav.central_complex.connectivity import DIRECTIONS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.fig_4h import column_shifts
from insectnav.experiments.stone2017_path_integration.memory_panels import draw_memories
from insectnav.experiments.stone2017_path_integration.trips import PRESET_NAMES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 7"
TITLE = "how memories add, and why the agent turns left or right"
NOISE = 0.1  # of the turns
LEGS = ((np.radians(30.0), 200), (np.radians(140.0), 150))  # heading and steps, from 1 to 2 and from 2 to 3
SPEED = 0.5  # [steps per time step]
FLIGHT = (np.radians(110.0), 500)  # heading and steps of the flight that charges the memory of d to g
HOME = FLIGHT[0] - np.pi  # [rad] from there
COURSES = np.radians(np.arange(-180.0, 180.0, 5.0))  # of motion relative to the body
FACINGS = np.radians(np.arange(-180.0, 180.0, 15.0))  # from facing to home: positive where home is on the right
SETTLING = 10  # [steps] in which the compass ring takes on a new heading
SHOWN = {"1": -90.0, "2": 90.0, "3": 0.0, "away": -180.0}  # [deg] the facing directions of f


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One set of constants."""

    preset: str
    n_trials: int = 1000  # for each facing direction


def grid(scale: str) -> Sequence[Cell]:
    """Both sets of constants."""
    return [Cell(preset=preset, n_trials=1000 if scale == "full" else 200) for preset in PRESETS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Memories after single legs, both and the way between; what flow charges them; turns of agents facing all ways."""
    circuit = circuit_params(preset=cell.preset)
    memory = fly([FLIGHT], circuit)
    turn, cpu1 = _turns(circuit, memory, cell.n_trials, NOISE, seed)
    quiet_turn, _ = _turns(circuit, memory, 1, 0.0, seed)
    along_column = (np.round(FLIGHT[0] / DIRECTIONS[1]) * DIRECTIONS[1], FLIGHT[1])
    turn_along_column, _ = _turns(circuit, fly([along_column], circuit), 1, 0.0, seed, along_column[0] - np.pi)
    return {
        "leg_memory": (("flight", "half", "column"), _leg_memories(circuit_params("idealised", cell.preset))),
        "leg_memory_of_rates": (("flight", "half", "column"), _leg_memories(circuit)),
        "charge": (("course", "half"), _charge_by_course(circuit)),
        "ring": (("column",), _settled_ring(circuit)),
        "memory": (("half", "column"), memory.reshape(2, 8)),
        "turn": (("facing", "trial"), turn.astype(np.float32), {"units": "rad"}),
        "turn_without_noise": (("facing",), quiet_turn[:, 0], {"units": "rad"}),
        "turn_along_column": (("facing",), turn_along_column[:, 0], {"units": "rad"}),
        "cpu1_sum": (("facing", "trial", "side"), cpu1.astype(np.float32)),
    }


def fly(legs: Sequence[tuple[float, float]], circuit: CircuitParams) -> NDArray[Any]:
    """Memory (16,) after straight flights without noise, each of a heading [rad] and a length in steps at SPEED.

    Parameters
    ----------
    legs : sequence of (heading, number of steps)
    circuit : CircuitParams
    """
    heading = np.concatenate([np.full(int(n_steps), angle) for angle, n_steps in legs])
    return _memory_of(heading[None], SPEED * unit_vector(heading)[None], circuit)[0]


def _memory_of(heading: NDArray[Any], velocity: NDArray[Any], circuit: CircuitParams) -> NDArray[Any]:
    """Memory (trial, 16) at the end of routes, without noise."""
    params = TrialParams(
        circuit=circuit, motion=MotionParams(), n_inbound=0, noise=0.0, seed=0, dtype="float64", keep_paths=False
    )
    return simulate_trials(heading, velocity, np.arange(len(heading)), params).memory_at_turn


def _leg_memories(circuit: CircuitParams) -> NDArray[Any]:
    """Memory less that of an agent at rest for as long, (flight, half, column): first leg, second, both, direct."""
    to_third = sum(SPEED * n_steps * unit_vector(angle) for angle, n_steps in LEGS)
    n_steps = sum(n_steps for _, n_steps in LEGS)
    heading = np.full((1, n_steps), bearing(to_third))
    velocity = np.broadcast_to(to_third / n_steps, (1, n_steps, 2))
    memories = [fly([LEGS[0]], circuit), fly([LEGS[1]], circuit), fly(LEGS, circuit)]
    memories.append(_memory_of(heading, velocity, circuit)[0])
    memory = np.array(memories).reshape(4, 2, 8)
    return memory - memory.mean(axis=-1, keepdims=True)


def _charge_by_course(circuit: CircuitParams) -> NDArray[Any]:
    """How much motion in each direction relative to the body charges either half, (course, half), at most 1.

    The swing over the columns of each half after 100 steps, of agents that all look north.
    """
    n_steps = 100
    velocity = np.repeat(SPEED * unit_vector(COURSES)[:, None], n_steps, axis=1)
    memory = _memory_of(np.zeros((len(COURSES), n_steps)), velocity, circuit).reshape(-1, 2, 8)
    swing = np.abs(np.fft.fft(memory, axis=-1)[..., 1])
    return swing / swing.max()


def _settled_ring(circuit: CircuitParams) -> NDArray[Any]:
    """Rates of TB1 (8,) of an agent that looks north, without noise."""
    return _settle(circuit, np.zeros(1), np.full((1, 16), circuit.memory_start), 0.0, 0)[1].tb1[0]


def _settle(circuit: CircuitParams, heading: NDArray[Any], memory: NDArray[Any], noise: float, seed: int) -> Any:
    """State and rates of agents at rest that have looked along their headings for a while."""
    state = replace(initial_state(circuit, heading.shape, seed=seed), memory=memory)
    senses = Senses(heading=heading, velocity=np.zeros((*heading.shape, 2)))
    for _ in range(SETTLING):
        state, rates = step(state, senses, circuit, noise=noise)
    return state, rates


def _turns(
    circuit: CircuitParams, memory: NDArray[Any], n_trials: int, noise: float, seed: int, home: float = HOME
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Turns (facing, trial) [rad] and summed activity of right and left CPU1 (facing, trial, side)."""
    heading = np.repeat(wrap(home - FACINGS), n_trials)
    _, rates = _settle(circuit, heading, np.broadcast_to(memory, (heading.size, 16)), noise, seed)
    sums = rates.cpu1.reshape(len(FACINGS), n_trials, 2, 8).sum(axis=-1)
    return rates.motor.reshape(len(FACINGS), n_trials), sums


def summarise(results: Results) -> Table:
    """Sums of sinusoids, offsets of both halves of the memory and home decoded from it, and turns."""
    rows = []
    for cell, arrays in results:
        circuit = circuit_params(preset=cell.preset)
        reads = (
            np.argmax(circuit.connectivity.cpu4_to_cpu1, axis=1) // 8
        )  # which half of the memory each CPU1 cell does
        ring = np.abs(np.fft.rfft(arrays["ring"])[1:]) ** 2 * np.array([2.0, 2.0, 2.0, 1.0])
        row: dict[str, Any] = {
            "preset": cell.preset,
            **_sum_of_legs(arrays["leg_memory"], circuit_params("idealised", cell.preset), "idealised"),
            **_sum_of_legs(arrays["leg_memory_of_rates"], circuit, "rates"),
            "share_of_ring_in_first_harmonic": float(ring[0] / ring.sum()),
        }
        for half, name in enumerate(("right", "left")):
            charge = arrays["charge"][:, half]
            preferred = np.angle(np.sum(charge * np.exp(1j * COURSES)))
            row[f"preferred_motion_{name}_deg"] = float(np.degrees(preferred))
            shift = 45.0 * float(column_shifts()[reads == half].mean())
            row[f"steering_offset_{name}_deg"] = row[f"preferred_motion_{name}_deg"] + shift
        home = bearing(decode_home_vector(arrays["memory"].reshape(16), circuit))
        row["decoded_home_error_deg"] = float(np.degrees(wrap(home - HOME)))
        rows.append(row | _turn_columns(arrays))
    return rows


def _sum_of_legs(memory: NDArray[Any], circuit: CircuitParams, name: str) -> dict[str, float]:
    """Both legs' memories added up, against those of the flight along both and of the direct one: length and angle."""
    vector = decode_home_vector(memory.reshape(4, 16), circuit)
    added = decode_home_vector((memory[0] + memory[1]).reshape(16), circuit)
    columns = {}
    for label, other in (("both", vector[2]), ("direct", vector[3])):
        ratio = np.linalg.norm(added) / np.linalg.norm(other)
        columns[f"sum_over_{label}_{name}"] = float(ratio)
        columns[f"sum_minus_{label}_{name}_deg"] = float(np.degrees(wrap(bearing(added) - bearing(other))))
    return columns


def _turn_columns(arrays: Mapping[str, NDArray[Any]]) -> dict[str, float]:
    """Turn, share of right turns and activity of right over left CPU1 in the facing directions shown."""
    columns: dict[str, float] = {}
    for name, angle in SHOWN.items():
        facing = int(np.argmin(np.abs(np.degrees(FACINGS) - angle)))
        turn = np.degrees(arrays["turn"][facing].astype(float))
        right, left = arrays["cpu1_sum"][facing].astype(float).mean(axis=0)
        columns |= {
            f"turn_{name}_deg": float(turn.mean()),
            f"turn_{name}_standard_error_deg": float(turn.std(ddof=1) / np.sqrt(turn.size)),
            f"turn_{name}_without_noise_deg": float(np.degrees(arrays["turn_without_noise"][facing])),
            f"turn_{name}_along_column_deg": float(np.degrees(arrays["turn_along_column"][facing])),
            f"share_right_{name}": float(np.mean(turn > 0.0)),
            f"share_right_{name}_standard_error": 0.5 / float(np.sqrt(turn.size)),
            f"right_over_left_{name}": float(right / left),
        }
    return columns


def draw(results: Results) -> Figure:
    """Sums of sinusoids, both halves of the memory as they are, turned and as CPU1 compares them; turns."""
    return draw_memories(results, summarise(results), COURSES, FACINGS, HOME, SHOWN)


def caption(results: Results) -> str:
    """What is shown, and of how many trials."""
    first, second = (f"{n} steps along {np.degrees(angle):.0f}°" for angle, n in LEGS)
    angle, n_steps = FLIGHT
    return (
        "a, How strongly motion in each direction relative to the body charges either half of the memory, agents "
        f"looking north. c, Memory of the idealised circuit after {first} (1 to 2), {second} (2 to 3), both added, and "
        "after the direct way from 1 to 3. d to f, Memory of the rate model after a straight flight of "
        f"{n_steps} steps along {np.degrees(angle):.0f}°, no noise: by column (d), each half turned by the 45° of its "
        "flow, with their mean (e), and as CPU1 compares them (f) with the three facing directions and the summed "
        "activity of right over left CPU1 in each. g, Turn against the direction of home from where the agent faces, "
        f"mean and SD of n = {results.cells[0].n_trials} trials with noise {NOISE:g}; lines: without noise. Speed "
        f"{SPEED:g}; a and d to f with the thesis constants."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Offsets, sums and turns, under both sets of constants where they matter."""
    return [_verdict(table, value) for value in published.values()]


def _verdict(table: Table, value: Published) -> Verdict:
    """Quantities that depend on the set of constants end with its name."""
    name, _, constants = value.quantity.partition(", ")
    row = next((row for row in table if PRESET_NAMES[row["preset"]] == constants), table[0])
    plain = {
        "offset of the motion stored in the right half": "preferred_motion_right_deg",
        "offset of the motion stored in the left half": "preferred_motion_left_deg",
        "offset between memory and TB1 in CPU1 that reads the right half": "steering_offset_right_deg",
        "offset between memory and TB1 in CPU1 that reads the left half": "steering_offset_left_deg",
        "length of the sum over that of the direct way": "sum_over_direct_idealised",
        "direction of the sum minus that of the direct way": "sum_minus_direct_idealised_deg",
        "share of TB1 activity in the first harmonic": "share_of_ring_in_first_harmonic",
        "direction of the summed memories minus that of home": "decoded_home_error_deg",
        "turn facing away from home without noise": "turn_away_without_noise_deg",
        "right over left CPU1 facing direction 1": "right_over_left_1",
        "right over left CPU1 facing direction 2": "right_over_left_2",
        "right over left CPU1 facing direction 3": "right_over_left_3",
    }
    uncertain = {
        "turn facing direction 1": ("turn_1_deg", "turn_1_standard_error_deg"),
        "turn facing direction 2": ("turn_2_deg", "turn_2_standard_error_deg"),
        "turn facing direction 3": ("turn_3_deg", "turn_3_standard_error_deg"),
        "share of right turns facing away from home": ("share_right_away", "share_right_away_standard_error"),
    }
    why = (
        f"home lies between two columns and the memory has it {row['decoded_home_error_deg']:.1f}° off, so that the "
        "points of balance are not straight home and straight away from it; after a flight along a column the turns "
        f"there are {abs(row['turn_3_along_column_deg']):.3f} and {abs(row['turn_away_along_column_deg']):.3f}°"
    )
    ours, error = uncertain.get(name, (plain.get(name, ""), ""))
    return judge(value, row[ours], row[error] if error else 0.0, why=why)
