"""FAB-MAP, plainly: each probability as its equation says, one word, one place and one query at a time.

After Cummins & Newman 2008, doi 10.1177/0278364908090961; shares nothing with the package. Trees are dictionaries:
``parent[q]`` (None for the root), ``p[q] = p(z_q = 1)``, ``given[q] = (p(z_q = 1 | z_p = 0), p(z_q = 1 | z_p = 1))``.
"""

import itertools
import math


def of(probability, is_true):
    return probability if is_true else 1.0 - probability


def exists(p, was_seen, p_seen, p_false):
    """p(e = 1 | what was seen at the place), by Bayes' rule."""
    there = of(p_seen, was_seen) * p
    not_there = of(p_false, was_seen) * (1.0 - p)
    return there / (there + not_there)


def word_given(z, e, z_parent, p, given, p_seen, p_false):
    """p(z_q | e_q, z_p), of a word that hangs on another."""
    detector = p_seen if e else p_false
    conditional = given[1] if z_parent else given[0]
    alpha = of(p, z) * of(detector, not z) * of(conditional, not z)
    beta = of(p, not z) * of(detector, z) * of(conditional, z)
    return beta / (alpha + beta)


def likelihood(place, query, tree, p_seen=0.39, p_false=0.0):
    """p(query | place); a place None is a new one, of which only the marginals are known."""
    product = 1.0
    for q, p in tree["p"].items():
        there = p if place is None else exists(p, place[q], p_seen, p_false)
        total = 0.0
        for e in (False, True):
            parent = tree["parent"][q]
            if parent is None:
                word = of(p_seen if e else p_false, query[q])
            else:
                word = word_given(query[q], e, query[parent], p, tree["given"][q], p_seen, p_false)
            total += word * of(there, e)
        product *= total
    return product


def posterior(places, query, samples, tree, smoothing=0.99, **detector):
    """Probabilities of the places, and last of a new one, which is the mean of samples or, without any, mean field."""
    values = [likelihood(place, query, tree, **detector) for place in places]
    if samples is None:
        values.append(likelihood(None, query, tree, **detector))
    else:
        values.append(sum(likelihood(sample, query, tree, **detector) for sample in samples) / len(samples))
    total = sum(values)
    return [smoothing * value / total + (1.0 - smoothing) / len(values) for value in values]


def information(bags, a, b):
    """Mutual information of two words over images, in nats."""
    n, sum_ = len(bags), 0.0
    for x, y in itertools.product((False, True), repeat=2):
        both = sum(bag[a] == x and bag[b] == y for bag in bags) / n
        one, other = sum(bag[a] == x for bag in bags) / n, sum(bag[b] == y for bag in bags) / n
        if both:
            sum_ += both * math.log(both / (one * other))
    return sum_


def spanning_trees(n):
    """All sets of n − 1 edges that join n words without a circle."""
    for edges in itertools.combinations(itertools.combinations(range(n), 2), n - 1):
        group = list(range(n))
        for a, b in edges:
            if group[a] == group[b]:
                break
            group = [group[a] if g == group[b] else g for g in group]
        else:
            yield edges
