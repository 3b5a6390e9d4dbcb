"""Paired tests against tables by hand and the definition of the F distribution."""

from itertools import product

import numpy as np
import pytest
from scipy import integrate, stats

from insectnav.checks import InputError
from insectnav.metrics.paired_tests import paired_wilcoxon, variance_ratio


def test_signed_ranks_by_counting_all_signs():
    rng = np.random.default_rng(0)
    one, other = rng.normal(0.4, 1.0, 9), rng.normal(0.0, 1.0, 9)
    ranks = np.argsort(np.argsort(np.abs(one - other))) + 1
    positive = ranks[one > other].sum()
    least = min(positive, 45 - positive)
    sums = np.array([np.dot(signs, ranks) for signs in product((0, 1), repeat=9)])
    found = paired_wilcoxon(one, other)
    assert (found.statistic, found.n) == (least, 9)
    assert found.p == pytest.approx(min(1.0, 2 * (sums <= least).mean()))


def test_variance_ratio_by_the_definition_of_f():
    rng = np.random.default_rng(1)
    one, other = rng.normal(0, 2, 12), rng.normal(0, 1, 12)
    found = variance_ratio(one, other)
    ratio = np.var(one, ddof=1) / np.var(other, ddof=1)
    assert found.statistic == pytest.approx(ratio)
    u, v = stats.chi2(11), stats.chi2(11)
    upper = integrate.quad(lambda x: v.pdf(x) * u.sf(ratio * x), 0, np.inf)[0]  # P(U / V > ratio)
    assert found.p == pytest.approx(2 * min(upper, 1 - upper), rel=1e-6)
    assert variance_ratio(other, one).p == pytest.approx(found.p)


def test_equal_methods_have_no_test():
    same = np.array([0.9, 0.8, 0.7])
    assert np.isnan(paired_wilcoxon(same, same).p)
    assert np.isnan(variance_ratio(same, np.ones(3)).p)


def test_what_is_not_paired_is_refused():
    for test in (paired_wilcoxon, variance_ratio):
        with pytest.raises(InputError, match="expected pairs"):
            test([1.0, 2.0], [1.0])
        with pytest.raises(InputError, match="finite"):
            test([1.0, np.nan], [1.0, 2.0])
