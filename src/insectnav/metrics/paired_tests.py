"""Two measurements of the same things, such as two methods on the same pictures: which is larger, which varies more."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_finite, check_shape

Reals = NDArray[np.floating[Any]]
MAX_EXACT_PAIRS = 50  # all 2⁵⁰ choices of signs are still counted as whole numbers; beyond, the normal will do


class RankTest(NamedTuple):
    """Two measurements, compared thing by thing."""

    statistic: float  # the lesser of the sums of ranks that speak for the first and for the second
    p: float  # two-sided; 1 where no pair differs
    n: int  # pairs that differ
    rank_biserial: float  # effect size: from −1, the second is always the larger, to 1, the first always


class SpreadTest(NamedTuple):
    """Two variances, compared; NaN where one of them is 0 or there is a single pair."""

    ratio: float  # of the first over the second
    p: float  # two-sided


def paired_wilcoxon(first: ArrayLike, second: ArrayLike) -> RankTest:
    """Wilcoxon's signed-rank test of pairs, with its effect size.

    Parameters
    ----------
    first, second : (n,) arrays, paired

    Raises
    ------
    InputError
        If they are not pairs, or a value is not finite.

    Notes
    -----
    Wilcoxon (1945), Biometrics Bulletin 1:80, doi 10.2307/3001968, as in Stone et al. (2014), section III.A. Pairs
    without a difference are left out, and equal differences share the mean of their ranks. Of up to 50 pairs p is
    exact: the share of all choices of signs whose sum is as far out. Beyond, it is from the normal approximation. The
    effect size is the matched-pairs rank-biserial correlation, the share of the sum of ranks that speaks for the first
    less that for the second: Kerby (2014), Comprehensive Psychology 3:1, doi 10.2466/11.IT.3.1.
    """
    from scipy.stats import rankdata, wilcoxon

    difference = np.subtract(*_pairs(first, second))
    difference = difference[difference != 0.0]
    if not difference.size:
        return RankTest(0.0, 1.0, 0, 0.0)
    ranks, is_positive = rankdata(np.abs(difference)), difference > 0.0
    above, below = float(ranks[is_positive].sum()), float(ranks[~is_positive].sum())
    if difference.size <= MAX_EXACT_PAIRS:
        p = _share_of_signs(ranks, min(above, below))
    else:
        p = float(wilcoxon(difference, method="asymptotic").pvalue)
    return RankTest(min(above, below), p, int(difference.size), (above - below) / (above + below))


def variance_ratio(first: ArrayLike, second: ArrayLike) -> SpreadTest:
    """F test of whether two measurements vary as much.

    Parameters
    ----------
    first, second : (n,) arrays, paired

    Raises
    ------
    InputError
        If they are not pairs, or a value is not finite.

    Notes
    -----
    F with n − 1 and n − 1 degrees of freedom, twice the smaller tail. It takes both for normal and independent, which
    accuracies of the same pictures are not: read its p with care. Stone et al. (2014), section III.A.
    """
    from scipy.stats import f

    one, other = _pairs(first, second)
    if len(one) < 2 or not one.var() or not other.var():
        return SpreadTest(float("nan"), float("nan"))
    ratio, freedom = float(one.var(ddof=1) / other.var(ddof=1)), len(one) - 1
    tail = min(float(f.cdf(ratio, freedom, freedom)), float(f.sf(ratio, freedom, freedom)))
    return SpreadTest(ratio, min(1.0, 2.0 * tail))


def _share_of_signs(ranks: Reals, lesser: float) -> float:
    """Share of all choices of signs that give a sum of ranks at least as far out, on either side."""
    doubled = np.rint(2.0 * ranks).astype(np.int64)  # whole numbers also where ranks are shared
    n_choices = np.zeros(doubled.sum() + 1)  # that give each sum
    n_choices[0] = 1.0
    for rank in doubled:
        n_choices[rank:] = n_choices[rank:] + n_choices[:-rank]
    tail = float(n_choices[: round(2.0 * lesser) + 1].sum())
    return min(1.0, 2.0 * tail / 2.0 ** len(ranks))


def _pairs(first: ArrayLike, second: ArrayLike) -> tuple[Reals, Reals]:
    one, other = np.asarray(first, float), np.asarray(second, float)
    for name, values in (("first", one), ("second", other)):
        check_shape(name, values, ("n",))
        check_finite(name, values)
    if len(one) != len(other) or not len(one):
        raise InputError(f"{len(one)} and {len(other)} values are given, expected pairs")
    return one, other
