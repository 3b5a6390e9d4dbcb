import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import fabmap_oracle
from insectnav.checks import InputError
from insectnav.matching import FabMapParams, chow_liu_tree, fabmap
from insectnav.metrics.retrieval import precision_recall, recall_at_full_precision

N_WORDS = 7


def made_bags(n, n_words=N_WORDS, seed=0):
    """Images that hold things, each thing with several words, so that words depend on one another."""
    rng = np.random.default_rng(seed)
    words_of = np.random.default_rng(99).random((n_words // 2 + 1, n_words)) < 0.4
    things = rng.random((n, len(words_of))) < 0.3
    return (rng.random((n, n_words)) < 0.8) & (things @ words_of) | (rng.random((n, n_words)) < 0.05)


def plain(tree, params=None):
    """The tree in the form of the oracle."""
    words = range(tree.n_words)
    chow_liu = params is None or params.dependence == "chow-liu"
    return {
        "parent": {q: int(tree.parent[q]) if chow_liu and tree.parent[q] != q else None for q in words},
        "p": {q: float(tree.marginal[q]) for q in words},
        "given": {q: (float(tree.given_absent[q]), float(tree.given_present[q])) for q in words},
    }


TREE = chow_liu_tree(made_bags(60, seed=1))
PLACES, QUERIES = made_bags(9, seed=2), made_bags(5, seed=3)
QUERIES[:, 0] |= ~QUERIES.any(axis=1)  # a word in each


@pytest.mark.parametrize("detector", [(0.39, 0.0), (0.7, 0.1)])
@pytest.mark.parametrize("dependence", ["chow-liu", "naive"])
@pytest.mark.parametrize("new_place", ["sampled", "mean-field"])
def test_all_probabilities_are_those_of_the_plain_way(detector, dependence, new_place):
    seen, false = detector
    params = FabMapParams(seen_if_there=seen, seen_if_not_there=false, dependence=dependence, new_place=new_place)
    found, tree = fabmap(PLACES, QUERIES, TREE, params), plain(TREE, params)
    for q, query in enumerate(QUERIES):
        values = [fabmap_oracle.likelihood(place, query, tree, seen, false) for place in PLACES]
        assert_allclose(found.log_likelihood[:, q], np.log(values), rtol=1e-12)
        samples = None if new_place == "mean-field" else TREE.training
        expected = fabmap_oracle.posterior(PLACES, query, samples, tree, p_seen=seen, p_false=false)
        assert found.new_place[q] == pytest.approx(expected[-1], rel=1e-10)
        assert found.reference[q] == np.argmax(expected[:-1])
        assert found.probability[q] == pytest.approx(max(expected[:-1]), rel=1e-10)
        raw = fabmap_oracle.posterior(PLACES, query, samples, tree, 1.0, p_seen=seen, p_false=false)
        assert found.score[q] == pytest.approx(math.log(sum(raw) - max(raw[:-1])), rel=1e-9)


@pytest.mark.parametrize(
    "params", [FabMapParams(), FabMapParams(seen_if_not_there=0.2), FabMapParams(dependence="naive")]
)
def test_likelihoods_of_all_that_can_be_seen_add_up_to_1(params):
    everything = np.array(list(itertools.product([False, True], repeat=N_WORDS)))
    found = fabmap(PLACES, everything, TREE, params)
    assert_allclose(np.exp(found.log_likelihood).sum(axis=1), 1.0, rtol=1e-12)


def test_an_inverted_index_gives_the_same_but_for_a_constant():
    """As FAB-MAP 2.0 counts: a place by its words alone, and of a query only words that it or their parents have."""
    tree = plain(TREE)

    def gain(q, z, z_parent):
        """ln of p(z | z_parent, place with q) over the same without it."""
        there, not_there = (
            sum(
                (
                    fabmap_oracle.of(0.39 * e, z)
                    if tree["parent"][q] is None
                    else fabmap_oracle.word_given(z, e, z_parent, tree["p"][q], tree["given"][q], 0.39, 0.0)
                )
                * fabmap_oracle.of(fabmap_oracle.exists(tree["p"][q], was_seen, 0.39, 0.0), e)
                for e in (0, 1)
            )
            for was_seen in (True, False)
        )
        return math.log(there / not_there)

    found = fabmap(PLACES, QUERIES, TREE).log_likelihood
    for k, query in enumerate(QUERIES):
        parents = [tree["parent"][q] for q in range(N_WORDS)]
        active = [q for q, p in enumerate(parents) if query[q] or (p is not None and query[p])]
        scores = []
        for place in PLACES:
            score = sum(gain(q, False, False) for q in np.flatnonzero(place))
            for q in (q for q in active if place[q]):
                score += gain(q, query[q], parents[q] is not None and query[parents[q]]) - gain(q, False, False)
            scores.append(score)
        assert_allclose(found[:, k] - found[0, k], np.array(scores) - scores[0], atol=1e-10)


def test_a_word_of_a_place_is_expected_there_as_often_as_it_is_detected():
    """Without dependence and false detections: p(z = 1 | seen at L) = PzGe, which can be told by hand."""
    found = fabmap(np.eye(N_WORDS, dtype=bool), np.eye(N_WORDS, dtype=bool), TREE, FabMapParams(dependence="naive"))
    p = TREE.marginal
    unseen = 0.39 * 0.61 * p / (0.61 * p + 1 - p)
    for place in range(N_WORDS):
        others = np.delete(unseen, place)
        assert found.log_likelihood[place, place] == pytest.approx(math.log(0.39) + np.log1p(-others).sum())


@settings(deadline=None, max_examples=40)
@given(
    st.integers(1, 20), st.integers(1, 20), st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([0.9, 0.99, 1.0])
)
def test_posterior_adds_up_to_1(n_places, n_queries, seed, motion, smoothing):
    places, queries = made_bags(n_places, seed=seed), made_bags(n_queries, seed=seed + 1)
    params = FabMapParams(motion=motion, smoothing=smoothing)
    found = fabmap(places, queries, TREE, params)
    seen = queries.any(axis=1)
    assert_array_equal(np.isnan(found.probability), ~seen)
    assert_array_equal(found.reference == -1, ~seen)
    # of one place, its probability and that of a new one are all there is
    alone = fabmap(places[:1], queries, TREE, params)
    assert_allclose((alone.probability + alone.new_place)[seen], 1.0, rtol=1e-12)
    assert ((found.probability + found.new_place)[seen] <= 1.0 + 1e-12).all()
    raw = (found.probability - (1 - smoothing) / (n_places + 1)) / smoothing
    assert_allclose((raw + np.exp(found.score))[seen], 1.0, rtol=1e-9)


def test_motion_weighs_places_next_to_the_last_one():
    """A place seen, then a view without any word: what is left is the posterior moved on, by hand."""
    queries = np.stack([PLACES[4], np.zeros(N_WORDS, bool), PLACES[4]])
    params = FabMapParams(motion=True)
    found = fabmap(PLACES, queries, TREE, params)
    n = len(PLACES)

    def posterior(likelihoods, before):
        moved = np.full(n, 1 / n)
        if before is not None:
            moved = (before[[0, *range(n - 1)]] + before[:n] + before[[*range(1, n), n - 1]]) / 3
        values = np.append(likelihoods[:-1] * moved, likelihoods[-1] * 0.9)
        return 0.99 * values / values.sum() + 0.01 / (n + 1)

    samples = np.exp(fabmap(TREE.training, queries, TREE).log_likelihood).mean(axis=0)
    likelihoods = np.concatenate([np.exp(found.log_likelihood), samples[None]])
    first = posterior(likelihoods[:, 0], None)
    second = posterior(np.ones(n + 1), first)
    third = posterior(likelihoods[:, 2], second)
    assert found.probability[0] == pytest.approx(first[:n].max())
    assert np.isnan(found.probability[1])
    assert found.new_place[2] == pytest.approx(third[n])
    assert found.reference[2] == third[:n].argmax()


def test_samples_are_chosen_by_the_seed():
    few = FabMapParams(n_samples=10)
    one, same, other = (fabmap(PLACES, QUERIES, TREE, replace(few, seed=s)).new_place for s in (0, 0, 1))
    assert_array_equal(one, same)
    assert (one != other).all()


def test_one_by_one_as_all_at_once_and_in_many_blocks():
    queries = made_bags(700, seed=8)
    found = fabmap(PLACES, queries, TREE)
    for query in (0, 255, 256, 699):
        alone = fabmap(PLACES, queries[[query]], TREE)
        assert_allclose(alone.log_likelihood[:, 0], found.log_likelihood[:, query], rtol=1e-13)
        assert_allclose(alone.score[0], found.score[query], rtol=1e-12)


def test_weight_of_a_new_place_is_its_prior():
    """By Bayes' rule the odds of a new place grow as its weight does."""
    even, heavy = (fabmap(PLACES, QUERIES, TREE, FabMapParams(new_place_weight=w, smoothing=1.0)) for w in (1 / 9, 1.0))
    default = fabmap(PLACES, QUERIES, TREE, FabMapParams(smoothing=1.0))
    assert_allclose(even.new_place, default.new_place, rtol=1e-12)
    odds = [found.new_place / (1 - found.new_place) for found in (even, heavy)]
    assert_allclose(odds[1], 9 * odds[0], rtol=1e-9)


def test_places_of_many_words_are_found_again_and_new_ones_are_not_sure():
    bags = made_bags(400, 300, seed=5)
    tree, places, elsewhere = chow_liu_tree(bags[:300]), bags[300:350], bags[350:]
    again = places ^ (np.random.default_rng(0).random(places.shape) < 0.03)
    found = fabmap(places, np.concatenate([again, elsewhere]), tree, FabMapParams(new_place_weight=1.0))
    assert_array_equal(found.reference[:50], np.arange(50))
    assert (found.probability[:50] > 0.9).mean() > 0.9
    assert found.new_place[:50].max() < 0.1
    assert (found.new_place[50:] > found.probability[50:]).mean() > 0.7
    right = np.arange(100) == found.reference
    right[50:] = False
    curve = precision_recall(right, found.score, np.arange(100) < 50)
    assert recall_at_full_precision(curve) > 0.9


@pytest.mark.parametrize(
    ("places", "queries", "message"),
    [
        (PLACES[:, :5], QUERIES, "reference_bags has 5 words, expected 7 as the tree: bags of another vocabulary"),
        (PLACES, QUERIES[:, :5], "query_bags has 5 words, expected 7"),
        (PLACES.astype(float), QUERIES, "float64 values, expected True or False"),
        (PLACES[:0], QUERIES, "reference_bags are empty"),
        (PLACES[0], QUERIES, "shape"),
    ],
)
def test_bad_bags_are_refused(places, queries, message):
    with pytest.raises(InputError, match=message):
        fabmap(places, queries, TREE)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("seen_if_there", 1.0, "seen_if_there is 1"),
        ("seen_if_not_there", 0.5, "interchanged"),
        ("new_place", "sampling", "did you mean sampled"),
        ("n_samples", 0, "n_samples"),
        ("smoothing", 1.2, "smoothing"),
        ("new_place_weight", 0.0, "new_place_weight"),
        ("dependence", "tree", "unknown"),
    ],
)
def test_bad_parameters_are_refused(field, value, message):
    with pytest.raises(InputError, match=message):
        FabMapParams(**{field: value})
