"""How certain a statistic is."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

N_RESAMPLES = 400  # the error of the error is then 1 in √800, 4 %
SEED = 2017  # the same data have the same error


def bootstrap_error(values: ArrayLike, statistic: Callable[..., Any]) -> float:
    """Standard error of a statistic of the finite values of a sample; NaN where there are fewer than two.

    Parameters
    ----------
    values : (n,) array
    statistic : callable
        Of arrays (..., n), along the last axis.

    Notes
    -----
    The bootstrap, Efron (1979), Ann. Statist. 7:1, doi 10.1214/aos/1176344552: SD of the statistic over 400 samples
    drawn from the sample with replacement, always the same of samples of one size.
    """
    sample = np.asarray(values, float)
    sample = sample[np.isfinite(sample)]
    if sample.size < 2:
        return float("nan")
    draws = np.random.default_rng(SEED).integers(sample.size, size=(N_RESAMPLES, sample.size))
    return float(np.std(statistic(sample[draws], axis=-1), ddof=1))
