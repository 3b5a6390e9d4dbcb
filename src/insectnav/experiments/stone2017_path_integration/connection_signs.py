"""Whether a connection excites or inhibits, found by making it stronger."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import unit_vector
from insectnav.central_complex import THESIS, CircuitParams, CircuitState, Senses, initial_state, step
from insectnav.central_complex.connectivity import PROJECTIONS

N_CIRCUITS = 64  # of random state, in which each synapse is tried
SEED = 2017  # of those states
CHANGE = 1e-4  # of a weight
LEAST = 1e-9  # effect on a rate that counts, well above rounding
OBSERVED = {"cpu4": "memory"}  # what changes at once where a cell integrates its input


@lru_cache(maxsize=1)
def measure_signs() -> dict[str, NDArray[np.int8]]:
    """Sign of the effect of every synapse of the circuit on its target, (target, source) by projection.

    Returns
    -------
    dict of projection to array
        1 where a stronger synapse raises the rate of its target in at least one of many circuits of random state and
        lowers it in none, −1 the other way round, 0 where there is no synapse or no effect, 2 where it does both.

    Notes
    -----
    The receiving populations are those of `insectnav.central_complex.connectivity.PROJECTIONS`; of what arrives at CPU4
    from TN2 and TB1 the effect on memory counts, of CPU1 that on the turn, to the right.
    """
    rng = np.random.default_rng(SEED)
    heading, course = rng.uniform(-np.pi, np.pi, (2, N_CIRCUITS))
    senses = Senses(heading=heading, velocity=unit_vector(course) * rng.uniform(0.2, 1.0, (N_CIRCUITS, 1)))
    state = replace(
        initial_state(THESIS, (N_CIRCUITS,)),
        tb1=rng.uniform(size=(N_CIRCUITS, 8)),
        memory=rng.uniform(0.2, 0.8, (N_CIRCUITS, 16)),
    )
    return {name: _signs(name, target, state, senses) for name, (target, _) in PROJECTIONS.items()}


def _signs(projection: str, target: str, state: CircuitState, senses: Senses) -> NDArray[np.int8]:
    """All synapses of one projection; those of different targets at once, since no target acts on another in a step."""
    matrix = getattr(THESIS.connectivity, projection)
    population = OBSERVED.get(target, target)
    before = _rate(population, THESIS, state, senses)
    signs = np.zeros(matrix.shape, np.int8)
    rows = range(len(matrix)) if target == "motor" else [slice(None)]  # both rows of the motor act on the one turn
    for row in rows:
        for source in range(matrix.shape[1]):
            is_synapse = matrix[row, source] != 0.0
            if not np.any(is_synapse):
                continue
            changed = matrix.copy()
            changed[row, source] += CHANGE * is_synapse
            wiring = replace(THESIS.connectivity, **{projection: changed})
            effect = _rate(population, replace(THESIS, connectivity=wiring), state, senses) - before
            rises, falls = (effect > LEAST).any(axis=0), (effect < -LEAST).any(axis=0)
            signs[row, source] = np.where(rises & falls, 2, rises.astype(int) - falls.astype(int))[()]
    return signs


def _rate(population: str, params: CircuitParams, state: CircuitState, senses: Senses) -> NDArray[Any]:
    """Rates (circuit, cell) after a step, and (circuit,) for the turn."""
    return getattr(step(state, senses, params)[1], population)
