"""How certain a statistic is."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from insectnav.checks import InputError

N_RESAMPLES = 400  # the error of the error is then 1 in √800, 4 %
SEED = 2017  # the same data have the same error
MAX_EXACT_PAIRS = 50  # beyond it the exact distribution takes long and the normal one is as good


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
    drawn from the sample with replacement.
    """
    sample = np.asarray(values, float)
    sample = sample[np.isfinite(sample)]
    if sample.size < 2:
        return float("nan")
    draws = np.random.default_rng(SEED).integers(sample.size, size=(N_RESAMPLES, sample.size))
    return float(np.std(statistic(sample[draws], axis=-1), ddof=1))


class PairedTest(NamedTuple):
    """Two measurements of the same things, compared thing by thing."""

    n: int  # pairs that differ
    median_difference: float  # of all pairs, the first less the second
    p: float  # two-sided; 1 where no pair differs
    rank_biserial: float  # effect size: from −1, the second is always the larger, to 1, the first always


def paired_test(first: ArrayLike, second: ArrayLike) -> PairedTest:
    """Wilcoxon's signed-rank test of pairs, with its effect size.

    Parameters
    ----------
    first, second : (n,) arrays

    Raises
    ------
    InputError
        If they are not of one length.

    Notes
    -----
    Wilcoxon (1945), Biometrics Bulletin 1:80, doi 10.2307/3001968; pairs without a difference are left out. p is exact
    where no two differences are equally large and n is at most 50, else from the normal approximation. The effect size
    is the matched-pairs rank-biserial correlation, the share of the sum of ranks that speaks for the first less that
    for the second: Kerby (2014), Comprehensive Psychology 3:1, doi 10.2466/11.IT.3.1.
    """
    from scipy.stats import rankdata, wilcoxon

    values = [np.asarray(sample, float) for sample in (first, second)]
    if values[0].ndim != 1 or values[0].shape != values[1].shape:
        raise InputError(f"samples have shapes {values[0].shape} and {values[1].shape}, expected pairs")
    difference = values[0] - values[1]
    differing = difference[difference != 0.0]
    if not differing.size:
        return PairedTest(0, float(np.median(difference)) if difference.size else float("nan"), 1.0, 0.0)
    size = np.abs(differing)
    is_exact = differing.size <= MAX_EXACT_PAIRS and len(np.unique(size)) == differing.size
    p = wilcoxon(differing, method="exact" if is_exact else "asymptotic").pvalue
    ranks = rankdata(size)
    effect = float(np.sum(np.sign(differing) * ranks) / ranks.sum())
    return PairedTest(int(differing.size), float(np.median(difference)), float(p), effect)
