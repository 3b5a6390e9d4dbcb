"""Paired tests against all choices of signs, and the definition of the F distribution."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, stats

from insectnav.checks import InputError
from insectnav.metrics.paired_tests import paired_wilcoxon, variance_ratio


@given(st.lists(st.integers(-6, 6), min_size=1, max_size=12))
def test_signed_ranks_by_counting_all_signs(values: list[int]):
    """Every choice of signs is as likely; equal differences share their ranks, equal pairs are left out."""
    difference = np.array([value for value in values if value], float)
    found = paired_wilcoxon(values, np.zeros(len(values)))
    assert found.n == len(difference)
    if not len(difference):
        return
    size = np.abs(difference)
    ranks = np.array([((size < one).sum() + 1 + (size <= one).sum()) / 2 for one in size])
    above, below = ranks[difference > 0].sum(), ranks[difference < 0].sum()
    sums = np.array(list(product((0, 1), repeat=len(ranks)))) @ ranks
    assert found.statistic == min(above, below)
    assert found.p == pytest.approx(min(1.0, 2 * (sums <= min(above, below)).mean()))
    assert found.rank_biserial == pytest.approx((above - below) / ranks.sum())


@pytest.mark.parametrize("n", [20, 50])
def test_ranks_of_unequal_differences_are_those_of_scipy(n: int):
    first, second = np.random.default_rng(n).normal(size=(2, n))
    expected = stats.wilcoxon(first, second, method="exact")
    found = paired_wilcoxon(first, second)
    assert (found.statistic, found.p) == (expected.statistic, expected.pvalue)


def test_many_pairs_are_judged_by_the_normal_distribution():
    """Mean n (n + 1) / 4 and variance n (n + 1) (2 n + 1) / 24 of the sum of ranks."""
    n, difference = 51, np.random.default_rng(0).normal(0.3, 1.0, 51)
    found = paired_wilcoxon(difference, np.zeros(n))
    z = (found.statistic - n * (n + 1) / 4) / np.sqrt(n * (n + 1) * (2 * n + 1) / 24)
    assert found.p == pytest.approx(2 * stats.norm.cdf(z))


def test_effect_is_one_where_all_are_larger_and_turns_with_the_order():
    first, second = 2.0 * np.arange(20.0) + 1.0, np.arange(20.0)
    assert paired_wilcoxon(first, second).rank_biserial == 1.0
    assert paired_wilcoxon(second, first).rank_biserial == -1.0
    assert paired_wilcoxon(first, second).p == pytest.approx(2.0 * 0.5**20)  # one of 2^20 choices, on both sides
    assert paired_wilcoxon(first, second).p == paired_wilcoxon(second, first).p


def test_variance_ratio_by_the_definition_of_f():
    rng = np.random.default_rng(1)
    one, other = rng.normal(0, 2, 12), rng.normal(0, 1, 12)
    found = variance_ratio(one, other)
    ratio = np.var(one, ddof=1) / np.var(other, ddof=1)
    assert found.ratio == pytest.approx(ratio)
    u, v = stats.chi2(11), stats.chi2(11)
    upper = integrate.quad(lambda x: v.pdf(x) * u.sf(ratio * x), 0, np.inf)[0]  # P(U / V > ratio)
    assert found.p == pytest.approx(2 * min(upper, 1 - upper), rel=1e-6)
    assert variance_ratio(other, one).p == pytest.approx(found.p)


def test_equal_measurements_do_not_differ():
    same = np.array([0.9, 0.8, 0.7])
    assert paired_wilcoxon(same, same) == (0.0, 1.0, 0, 0.0)
    assert variance_ratio(same, same) == (1.0, 1.0)
    assert np.isnan(variance_ratio(same, np.ones(3)).p)


def test_what_is_not_paired_is_refused():
    for test in (paired_wilcoxon, variance_ratio):
        with pytest.raises(InputError, match="expected pairs"):
            test([1.0, 2.0], [1.0])
        with pytest.raises(InputError, match="finite"):
            test([1.0, np.nan], [1.0, 2.0])
