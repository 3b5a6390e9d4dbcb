import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import fabmap_oracle
from insectnav.checks import InputError
from insectnav.matching import chow_liu_tree
from insectnav.matching.chow_liu import mutual_information


def correlated_bags(n_images=200, n_words=6, seed=0):
    """Words that copy one another with some errors, along a tree of their own."""
    rng = np.random.default_rng(seed)
    bags = rng.random((n_images, n_words)) < rng.uniform(0.2, 0.6, n_words)
    for word in range(1, n_words):
        copies = rng.random(n_images) < rng.uniform(0.3, 0.9)
        bags[copies, word] = bags[copies, rng.integers(word)]
    return bags


@pytest.mark.parametrize("seed", range(4))
def test_tree_has_the_greatest_information_of_all_trees(seed):
    bags = correlated_bags(seed=seed)
    weight = {(a, b): fabmap_oracle.information(bags, a, b) for a in range(6) for b in range(a + 1, 6)}
    trees = list(fabmap_oracle.spanning_trees(6))
    assert len(trees) == 6**4  # Cayley: n^(n − 2) labelled trees
    best = max(trees, key=lambda edges: sum(weight[edge] for edge in edges))
    tree = chow_liu_tree(bags)
    found = {tuple(sorted((q, p))) for q, p in enumerate(tree.parent.tolist()) if q != p}
    assert found == set(best)
    assert tree.root in max(best, key=weight.get)


def test_information_is_that_of_scikit_learn_and_of_the_plain_way():
    from sklearn.metrics import mutual_info_score

    bags = correlated_bags()
    found = mutual_information(bags)
    for a in range(6):
        for b in range(6):
            assert found[a, b] == pytest.approx(mutual_info_score(bags[:, a], bags[:, b]), abs=1e-12)
            assert found[a, b] == pytest.approx(fabmap_oracle.information(bags, a, b), abs=1e-12)


def test_tree_of_more_words_weighs_as_much_as_that_of_networkx():
    import networkx

    bags = correlated_bags(400, 80, seed=3)
    information, tree = mutual_information(bags), chow_liu_tree(bags)
    graph = networkx.from_numpy_array(np.triu(information, 1) + np.triu(information, 1).T)
    expected = networkx.maximum_spanning_tree(graph).size(weight="weight")
    word = np.arange(80)
    kept = word != tree.parent
    assert information[word, tree.parent][kept].sum() == pytest.approx(expected, rel=1e-12)
    assert kept.sum() == 79


def test_probabilities_are_counts_kept_from_0_and_1():
    bags = np.zeros((20, 3), bool)
    bags[:10, 0] = True
    bags[:8, 1] = True  # only with word 0
    tree = chow_liu_tree(bags)
    assert tree.root == 0
    assert_array_equal(tree.parent[:2], [0, 0])
    assert_allclose(tree.marginal, [0.98 * 0.5 + 0.01, 0.98 * 0.4 + 0.01, 0.01])
    assert tree.given_present[1] == pytest.approx(0.98 * 0.8 + 0.01)
    assert tree.given_absent[1] == pytest.approx(0.01)
    assert tree.given_present[0] == tree.given_absent[0] == tree.marginal[0]


def test_probabilities_given_the_parent_are_shares_of_the_images_with_and_without_it():
    bags = correlated_bags()
    tree = chow_liu_tree(bags)
    for word, parent in enumerate(tree.parent):
        if word == parent:
            continue
        with_parent, without = bags[bags[:, parent], word].mean(), bags[~bags[:, parent], word].mean()
        assert tree.given_present[word] == pytest.approx(0.98 * with_parent + 0.01)
        assert tree.given_absent[word] == pytest.approx(0.98 * without + 0.01)


@settings(deadline=None, max_examples=50)
@given(st.integers(2, 12), st.integers(10, 40), st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_any_bags_give_a_tree(n_words, n_images, seed, share):
    tree = chow_liu_tree(np.random.default_rng(seed).random((n_images, n_words)) < share)
    steps = np.arange(n_words)
    for _ in range(n_words):
        steps = tree.parent[steps]
    assert (steps == tree.root).all()
    for probability in (tree.marginal, tree.given_present, tree.given_absent):
        assert ((probability >= 0.01 - 1e-12) & (probability <= 0.99 + 1e-12)).all()


@pytest.mark.parametrize(
    ("bags", "message"),
    [
        (np.ones((9, 4), bool), "9 training images, expected at least 10"),
        (np.ones((20, 1), bool), "1 words, expected at least 2"),
        (np.ones((20, 4), int), "int64 values, expected True or False for each word: counts"),
        (np.ones(20, bool), "shape"),
    ],
)
def test_bad_bags_are_refused(bags, message):
    with pytest.raises(InputError, match=message):
        chow_liu_tree(bags)
