"""Spike trains whose rates are known: regular ones, and Poisson ones by thinning."""

from collections.abc import Callable

import numpy as np

RateFunction = Callable[[np.ndarray], np.ndarray]


def regular(rate: float, start: float, stop: float) -> np.ndarray:
    """Spikes at a constant rate, the first half an interval after the start, so that none falls on an edge."""
    return start + (np.arange(round(rate * (stop - start))) + 0.5) / rate


def poisson(rate: RateFunction, max_rate: float, stop: float, seed: int) -> np.ndarray:
    """Inhomogeneous Poisson process from 0 s on; Lewis and Shedler 1979, Naval Research Logistics 26:403."""
    rng = np.random.default_rng(seed)
    candidates = np.sort(rng.uniform(0.0, stop, rng.poisson(max_rate * stop)))
    return candidates[rng.uniform(0.0, max_rate, candidates.size) < rate(candidates)]
