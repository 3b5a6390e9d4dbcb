"""Ext. Data Fig. 6: what each cell makes of its input, and all connections, as measured on the circuit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import unit_vector
from insectnav.central_complex import N_CELLS, THESIS, Rates, Senses, initial_state, step
from insectnav.central_complex.connectivity import DIRECTIONS, PROJECTIONS
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2017_path_integration.connection_signs import measure_signs
from insectnav.experiments.stone2017_path_integration.response_panels import draw_responses_and_connections

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Ext. Data Fig. 6"
TITLE = "input and output of every cell type, and all connections"
NOISE_LEVELS = (0.0, 0.1)
POPULATIONS = ("tl", "cl1", "tb1", "cpu4", "pontine", "cpu1", "tn2")
LABELS = {"tl": "TL", "cl1": "CL1", "tb1": "TB1", "cpu4": "CPU4", "pontine": "pontine", "cpu1": "CPU1", "tn2": "TN2"}
HIGHEST_SPEED = 1.0  # [steps per time step]: flow from −1 to 1


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One noise level."""

    noise: float
    n_samples: int = 20_000  # of each population


def grid(scale: str) -> Sequence[Cell]:
    """Without and with noise."""
    return [Cell(noise=noise, n_samples=20_000 if scale == "full" else 3000) for noise in NOISE_LEVELS]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Input and output of one cell of each population per sample, in circuits of random state; signs of connections."""
    rng = np.random.default_rng(seed)
    n = cell.n_samples
    heading = rng.uniform(-np.pi, np.pi, n)
    course = rng.uniform(-np.pi, np.pi, n)
    velocity = rng.uniform(0.0, HIGHEST_SPEED, (n, 1)) * unit_vector(course)
    before = replace(
        initial_state(THESIS, (n,), seed=seed), tb1=rng.uniform(size=(n, 8)), memory=rng.uniform(size=(n, 16))
    )
    _, rates = step(before, Senses(heading=heading, velocity=velocity), THESIS, noise=cell.noise)
    inputs = cell_inputs(heading, velocity, before.tb1, rates)
    pick = np.arange(n)
    chosen = {name: pick % N_CELLS[name] for name in POPULATIONS}
    currents = np.stack([inputs[name][pick, chosen[name]] for name in POPULATIONS])
    outputs = np.stack([getattr(rates, name)[pick, chosen[name]] for name in POPULATIONS])
    excitation, inhibition = (part[pick, chosen["tb1"]] for part in tb1_inputs(before.tb1, rates))
    return {
        "input": (("population", "sample"), currents),
        "output": (("population", "sample"), outputs),
        "tb1_excitation": (("sample",), excitation),
        "tb1_inhibition": (("sample",), inhibition),
        **{f"sign_{name}": ((f"{name}_target", f"{name}_source"), sign) for name, sign in measure_signs().items()},
    }


def tb1_inputs(tb1_before: NDArray[Any], rates: Rates) -> tuple[NDArray[Any], NDArray[Any]]:
    """What arrives at TB1 from CL1 and from TB1 of the step before, both (sample, 8) and without strength."""
    wiring = THESIS.connectivity
    return rates.cl1 @ wiring.cl1_to_tb1.T, tb1_before @ wiring.tb1_to_tb1.T


def cell_inputs(
    heading: NDArray[Any], velocity: NDArray[Any], tb1_before: NDArray[Any], rates: Rates
) -> dict[str, NDArray[Any]]:
    """Input I of every cell from the rates of those that it listens to, (sample, cell) by population.

    Parameters
    ----------
    heading : (sample,) array [rad]
    velocity : (sample, 2) array [steps per time step]
    tb1_before : (sample, 8) array
        Rates of TB1 in the step before.
    rates : Rates
        Of this step.

    Notes
    -----
    The equations of Stone et al. 2017, Methods, Layers 1 to 6, doi 10.1016/j.cub.2017.08.052.
    """
    wiring = THESIS.connectivity
    excitation, inhibition = tb1_inputs(tb1_before, rates)
    eyes = heading[:, None] + THESIS.tn_preference * np.array([1.0, -1.0])  # right, left
    return {
        "tl": np.cos(heading[:, None] - np.tile(DIRECTIONS, 2)),
        "cl1": -rates.tl,
        "tb1": THESIS.cl1_to_tb1_strength * excitation - THESIS.tb1_to_tb1_strength * inhibition,
        "cpu4": rates.memory,
        "pontine": rates.cpu4 @ wiring.cpu4_to_pontine.T,
        "cpu1": THESIS.cpu4_to_cpu1_strength * rates.cpu4 @ wiring.cpu4_to_cpu1.T
        - THESIS.pontine_to_cpu1_strength * rates.pontine @ wiring.pontine_to_cpu1.T
        - THESIS.tb1_to_cpu1_strength * rates.tb1 @ wiring.tb1_to_cpu1.T,
        "tn2": np.sum(unit_vector(eyes) * velocity[:, None], axis=-1),
    }


def fit_sigmoid(current: NDArray[Any], rate: NDArray[Any]) -> tuple[float, float]:
    """Slope a and bias b of ``rate = 1 / (1 + exp(b − a · current))``, by least squares on the logit.

    Parameters
    ----------
    current, rate : (sample,) arrays
        Rates within 0…1, without noise.
    """
    slope, offset = np.polyfit(current, np.log(rate / (1.0 - rate)), 1)
    return float(slope), float(-offset)


def summarise(results: Results) -> Table:
    """Slope and bias of each population, fitted to its responses without noise, and the noise of its responses."""
    quiet, noisy = results.only(noise=0.0), results.only(noise=0.1)
    rows = []
    for rank, population in enumerate(POPULATIONS):
        current, rate = results["input"][quiet, rank], results["output"][quiet, rank]
        if population == "tn2":
            is_forward = current > 0.0
            slope, offset = np.polyfit(current[is_forward], rate[is_forward], 1)
            bias, negative = -offset, float(rate[~is_forward].max())
            expected = np.clip(results["input"][noisy, rank], 0.0, 1.0)
        else:
            slope, bias = fit_sigmoid(current, rate)
            negative = float("nan")
            expected = 1.0 / (1.0 + np.exp(bias - slope * results["input"][noisy, rank]))
        is_half = np.abs(expected - 0.5) < 0.15  # where noise of 0.1 is hardly ever clipped
        rest = (results["output"][noisy, rank] - expected)[is_half]
        rows.append(
            {
                "population": population,
                "n_cells": N_CELLS[population],
                "slope": float(slope),
                "bias": float(bias),
                "lowest_input": float(current.min()),
                "highest_input": float(current.max()),
                "highest_rate_at_negative_flow": negative,
                "noise_sd": float(np.std(rest, ddof=1)),
                "noise_sd_standard_error": float(np.std(rest, ddof=1) / np.sqrt(2.0 * rest.size)),
                "n_noise": rest.size,
                **_ring_share(population, results, quiet),
                **_connection_counts(population, results, quiet),
            }
        )
    return rows


def _ring_share(population: str, results: Results, cell: int) -> dict[str, float]:
    """Share of the inhibition by TB1 in the input of TB1, from a regression of its logit on both inputs."""
    if population != "tb1":
        return {"share_of_lateral_inhibition": float("nan")}
    rate = results["output"][cell, POPULATIONS.index("tb1")]
    inputs = [results["tb1_excitation"][cell], results["tb1_inhibition"][cell], np.ones(rate.size)]
    (excitation, inhibition, _), *_ = np.linalg.lstsq(np.stack(inputs, axis=1), np.log(rate / (1.0 - rate)), rcond=None)
    return {"share_of_lateral_inhibition": float(-inhibition / (excitation - inhibition))}


def _connection_counts(population: str, results: Results, cell: int) -> dict[str, int]:
    """Connections that the population makes, by the sign of their measured effect."""
    signs = [results[f"sign_{name}"][cell] for name, (_, source) in PROJECTIONS.items() if source == population]
    return {
        "n_excitatory_synapses": sum(int(np.sum(sign > 0)) for sign in signs),
        "n_inhibitory_synapses": sum(int(np.sum(sign < 0)) for sign in signs),
    }


def draw(results: Results) -> Figure:
    """Responses of every population without and with noise, their slope and bias; below, all connections."""
    signs = {name: results[f"sign_{name}"][0] for name in PROJECTIONS}
    weights = {name: sign * getattr(THESIS.connectivity, name) for name, sign in signs.items()}
    return draw_responses_and_connections(results, summarise(results), LABELS, weights)


def caption(results: Results) -> str:
    """What is shown, and of how many samples."""
    return (
        "Top: rate of every cell type against its input, without (upper row) and with noise of 0.1 (lower row; dots: "
        f"single cells, line: mean and SD in bins), in n = {results.cells[0].n_samples} circuits of random memory, "
        "ring activity, heading and velocity; a and b are fitted to the responses without noise. The grey line is the "
        "fit beyond the inputs that occur. Bottom: all connections, rows: receiving cells, columns: sending cells; the "
        "colour is the weight with the sign of the effect that a stronger synapse was measured to have on the "
        "receiving cell (of the noduli cells on memory, of CPU1 on the turn)."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Slopes, biases, numbers of cells, noise, signs and strengths of the connections."""
    rows = {LABELS[row["population"]]: row for row in table}
    ours = {f"number of {label} cells": (float(row["n_cells"]), 0.0) for label, row in rows.items()}
    for label, row in rows.items():
        ours[f"slope a of {label}"] = (row["slope"], 0.0)
        ours[f"bias b of {label}"] = (row["bias"], 0.0)
        ours[f"noise of {label}"] = (row["noise_sd"], row["noise_sd_standard_error"])
    ours["rate of TN2 at negative flow"] = (rows["TN2"]["highest_rate_at_negative_flow"], 0.0)
    ours["share of lateral inhibition in the input of TB1"] = (rows["TB1"]["share_of_lateral_inhibition"], 0.0)
    ours |= {name: (value, 0.0) for name, value in _wiring_numbers().items()}
    why = f"noise was measured on {min(rows[label]['n_noise'] for label in rows)} responses or more of each population"
    return [judge(value, *ours[name], why=why) for name, value in published.items()]


def _wiring_numbers() -> dict[str, float]:
    """Signs and strengths of all connections."""
    signs = measure_signs()
    numbers = {f"sign of {name.replace('_', ' ')}": float(np.sign(sign.sum())) for name, sign in signs.items()}
    cells = {name: sign for name, sign in signs.items() if not name.endswith("motor")}  # which turns to both sides
    numbers["projections of both signs"] = float(sum((s > 0).any() and (s < 0).any() for s in cells.values()))
    wiring = THESIS.connectivity
    strengths = [getattr(wiring, name) for name in PROJECTIONS if name != "tb1_to_tb1"]
    numbers["different strengths of connections but those between TB1 cells"] = float(
        len({value for matrix in strengths for value in matrix[matrix != 0.0].tolist()})
    )
    weights = wiring.tb1_to_tb1
    wave = np.cos(DIRECTIONS[:, None] - DIRECTIONS)
    numbers["correlation of TB1-TB1 weights with the cosine of the angle"] = float(
        np.corrcoef(weights.ravel(), wave.ravel())[0, 1]
    )
    return numbers
