"""Two methods on the same pictures: whether one is better, and whether one is more even."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from insectnav.checks import InputError, check_finite, check_shape


class PairedTest(NamedTuple):
    """Statistic, two-sided p, and the number of pairs; NaN where the test is void."""

    statistic: float
    p: float
    n: int


def paired_wilcoxon(one: ArrayLike, other: ArrayLike) -> PairedTest:
    """Signed-rank test of whether two methods are as good as each other on the same pictures.

    Parameters
    ----------
    one, other : (n,) arrays, paired

    Notes
    -----
    Wilcoxon (1945), Biometrics Bull. 1:80, doi 10.2307/3001968: the lesser sum of ranks, pairs that are equal left out;
    p exact for up to 50 pairs without ties or equals, by the normal approximation otherwise, as in SciPy. Stone et al.
    (2014), section III.A.
    """
    from scipy.stats import wilcoxon

    first, second = _pairs(one, other)
    if (first == second).all():
        return PairedTest(float("nan"), float("nan"), len(first))
    found = wilcoxon(first, second)
    return PairedTest(float(found.statistic), float(found.pvalue), len(first))


def variance_ratio(one: ArrayLike, other: ArrayLike) -> PairedTest:
    """F test of whether two methods vary as much over pictures; the statistic is var(one) / var(other).

    Notes
    -----
    F with n − 1 and n − 1 degrees of freedom, twice the smaller tail. It takes both for normal and independent, which
    accuracies of the same pictures are not: read its p with care. Stone et al. (2014), section III.A.
    """
    from scipy.stats import f

    first, second = _pairs(one, other)
    if len(first) < 2 or not second.var() or not first.var():
        return PairedTest(float("nan"), float("nan"), len(first))
    ratio = float(first.var(ddof=1) / second.var(ddof=1))
    lower = float(f.cdf(ratio, len(first) - 1, len(second) - 1))
    upper = float(f.sf(ratio, len(first) - 1, len(second) - 1))
    return PairedTest(ratio, min(1.0, 2.0 * min(lower, upper)), len(first))


def _pairs(one: ArrayLike, other: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    first, second = np.asarray(one, float), np.asarray(other, float)
    for name, values in (("one", first), ("other", second)):
        check_shape(name, values, ("n",))
        check_finite(name, values)
    if len(first) != len(second) or not len(first):
        raise InputError(f"{len(first)} and {len(second)} values are given, expected pairs")
    return first, second
