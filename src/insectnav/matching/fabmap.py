"""FAB-MAP: the probability that an image was taken at each known place, or at none, from the words that it holds."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice, check_count, check_range
from insectnav.matching.chow_liu import ChowLiuTree, checked_bags

Reals = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]
QUERIES_PER_BLOCK, PLACES_PER_BLOCK = 256, 1024  # whose words are in memory as real numbers together


@dataclass(frozen=True, kw_only=True)
class FabMapParams:
    """The model of detection and of new places; numbers of OpenFABMAP's sample settings and of its source (2015)."""

    seen_if_there: float = 0.39  # PzGe, probability that a word is detected where its thing exists
    seen_if_not_there: float = 0.0  # PzGne, the same where it does not
    new_place: str = "sampled"  # likelihood of a new place: mean of training images as places, or "mean-field"
    n_samples: int = 1000  # training images that stand for new places; all, if there are fewer
    seed: int = 0  # of their choice
    dependence: str = "chow-liu"  # of words: along the tree, or "naive", none
    smoothing: float = 0.99  # sFactor, share of the posterior; the rest is spread evenly over all places
    motion: bool = False  # whether a place is likely if it or a neighbour was likely one query before
    new_place_weight: float | None = None  # prior of a new place over that of all known ones; None: see `weight_of_new`

    def __post_init__(self) -> None:
        check_range("seen_if_there", self.seen_if_there, 1e-9, 1.0 - 1e-9)
        check_range("seen_if_not_there", self.seen_if_not_there, 0.0, self.seen_if_there, slip="the two interchanged?")
        check_choice("new_place", self.new_place, ("sampled", "mean-field"))
        check_count("n_samples", self.n_samples)
        check_count("seed", self.seed, minimum=0)
        check_choice("dependence", self.dependence, ("chow-liu", "naive"))
        check_range("smoothing", self.smoothing, 0.0, 1.0)
        if self.new_place_weight is not None:
            check_range("new_place_weight", self.new_place_weight, 1e-300, 1e300)

    def weight_of_new(self, n_places: int) -> float:
        """Prior of a new place over that of all known ones; by default that of one of them, with motion Pnew, 0.9."""
        if self.new_place_weight is not None:
            return self.new_place_weight
        return 0.9 if self.motion else 1.0 / n_places


class FabMapMatches(NamedTuple):
    """Where each query probably was taken."""

    reference: Integers  # (query,) the most probable place; −1 where nothing was detected
    probability: Reals  # (query,) of that place, after smoothing; NaN where nothing was detected
    log_likelihood: Reals  # (reference, query) ln p(words of the query | place)
    new_place: Reals  # (query,) probability of a place that is not in the map; NaN where nothing was detected
    score: Reals  # (query,) ln(1 − p) of the match before smoothing: the lower, the surer; probabilities soon reach 1


def fabmap(
    reference_bags: ArrayLike, query_bags: ArrayLike, tree: ChowLiuTree, params: FabMapParams | None = None
) -> FabMapMatches:
    """The most probable place of each query, with its probability and that of a new place.

    Parameters
    ----------
    reference_bags : (reference, word) array of bool
        Words seen at each place of the map, once; of `Vocabulary.bags`.
    query_bags : (query, word) array of bool
    tree : of `chow_liu_tree`, from other images
    params : FabMapParams

    Returns
    -------
    FabMapMatches
        The most probable place is given even where a new place is more probable: compare `probability` and
        `new_place`. `score` is for `insectnav.metrics.retrieval`.

    Raises
    ------
    InputError
        If the bags are of another vocabulary than the tree, or there is no reference.

    Notes
    -----
    Cummins & Newman 2008, IJRR 27, doi 10.1177/0278364908090961, and 2011, IJRR 30, doi 10.1177/0278364910385483. With
    z_q whether word q is seen, p its parent, and e_q whether what gives rise to it exists at place L:

        ``p(Z | L) = Π_q Σ_e p(z_q | e, z_p) p(e_q = e | L)``

        ``p(z_q | e, z_p) = β / (α + β)`` with ``α = p(z_q) p(¬z_q | e) p(¬z_q | z_p)``
        and ``β = p(¬z_q) p(z_q | e) p(z_q | z_p)``

        ``p(e | L) ∝ p(z_q seen at L | e) p(e)``

    with ``p(e = 1) = p(z = 1)``, as OpenFABMAP has it (Glover et al. 2012, doi 10.1109/ICRA.2012.6224843). All places
    are equally likely before, a new one as likely as each of them, unless `new_place_weight` says otherwise. With
    motion, their weights are means of the posterior of the query before at the place and its two neighbours, and a
    query in which nothing was detected is no evidence.
    """
    params = params or FabMapParams()
    references = checked_bags("reference_bags", reference_bags, tree.n_words)
    queries = checked_bags("query_bags", query_bags, tree.n_words)
    if not len(references):
        raise InputError("reference_bags are empty, expected at least one place")
    table = _log_table(tree, params)
    log_likelihood = _log_likelihood(references, queries, tree, table)
    log_new = _log_new_place(queries, tree, table, params)
    is_seen: Bools = np.asarray(queries.any(axis=1))
    posterior = _posterior(np.where(is_seen, np.concatenate([log_likelihood, log_new[None]]), 0.0), params)
    return _matches(log_likelihood, posterior, is_seen)


def _matches(log_likelihood: Reals, posterior: "_Posterior", is_seen: Bools) -> FabMapMatches:
    reference = np.argmax(posterior.log[:-1], axis=0)

    def known(values: Reals) -> Reals:
        return np.where(is_seen, values, np.nan)

    return FabMapMatches(
        np.where(is_seen, reference, -1),
        known(posterior.smoothed[reference, np.arange(len(reference))]),
        log_likelihood,
        known(posterior.smoothed[-1]),
        known(_log_of_all_else(posterior.log, reference)),
    )


def _log_table(tree: ChowLiuTree, params: FabMapParams) -> Reals:
    """``ln p(z_q | z_p, place)``, (seen at the place, z_p, z_q, word); the first axis has a third row, a new place."""
    seen, marginal = np.array([params.seen_if_not_there, params.seen_if_there]), tree.marginal
    given = np.stack([tree.given_absent, tree.given_present])
    if params.dependence == "naive":
        given = np.stack([marginal, marginal])
    word = np.array([1.0 - marginal, marginal])  # (z, word)
    detected = np.array([1.0 - seen, seen])  # (z, e)
    parted = np.array([1.0 - given, given])  # (z, z_p, word)
    # β of z; its α is the β of ¬z
    weight = word[::-1, None, None] * detected[:, :, None, None] * parted[:, None]  # (z, e, z_p, word)
    likelihood = weight / weight.sum(axis=0)
    exists = detected[:, 1, None] * marginal  # (seen at the place, word)
    exists = exists / (exists + detected[:, 0, None] * (1.0 - marginal))
    exists = np.concatenate([exists, marginal[None]])[:, None, None]  # and of a new place
    mixed = exists * likelihood[:, 1].swapaxes(0, 1) + (1.0 - exists) * likelihood[:, 0].swapaxes(0, 1)
    return np.log(mixed)


def _log_likelihood(places: Bools, queries: Bools, tree: ChowLiuTree, table: Reals) -> Reals:
    """``ln p(query | place)``, (place, query): where nothing was seen, and what each word seen there adds."""
    gain = table[1] - table[0]  # (z_p, z, word)
    found = np.empty((len(places), len(queries)))
    word = np.arange(tree.n_words)
    for first in range(0, len(queries), QUERIES_PER_BLOCK):
        block = slice(first, first + QUERIES_PER_BLOCK)
        z = queries[block].astype(np.int64)
        z_p = z[:, tree.parent]
        more = gain[z_p, z, word].T
        nothing = table[0, z_p, z, word].sum(axis=1)
        for start in range(0, len(places), PLACES_PER_BLOCK):
            part = slice(start, start + PLACES_PER_BLOCK)
            found[part, block] = places[part].astype(np.float64) @ more + nothing
    return found


def _log_new_place(queries: Bools, tree: ChowLiuTree, table: Reals, params: FabMapParams) -> Reals:
    """``ln p(query | new place)``, (query,)."""
    if params.new_place == "mean-field":
        z = queries.astype(np.int64)
        return np.asarray(table[2, z[:, tree.parent], z, np.arange(tree.n_words)].sum(axis=1))
    samples = tree.training
    if len(samples) > params.n_samples:
        rng = np.random.Generator(np.random.PCG64(params.seed))
        samples = samples[np.sort(rng.choice(len(samples), params.n_samples, replace=False))]
    return _log_sum(_log_likelihood(samples, queries, tree, table)) - np.log(len(samples))


class _Posterior(NamedTuple):
    log: Reals  # (reference + 1, query) before smoothing, the new place last
    smoothed: Reals  # probabilities


def _posterior(log: Reals, params: FabMapParams) -> _Posterior:
    n_places = len(log) - 1
    log[-1] += np.log(params.weight_of_new(n_places))
    if params.motion:
        prior = np.full(n_places, 1.0 / n_places)
        for query in range(log.shape[1]):
            with np.errstate(divide="ignore"):  # without smoothing a place may become impossible
                log[:-1, query] += np.log(prior)
            log[:, query] -= _log_sum(log[:, query])
            prior = _moved(_smoothed(log[:-1, query], n_places, params))
    else:
        log[:-1] -= np.log(n_places)
        log -= _log_sum(log)
    return _Posterior(log, _smoothed(log, n_places, params))


def _smoothed(log: Reals, n_places: int, params: FabMapParams) -> Reals:
    return np.asarray(params.smoothing * np.exp(log) + (1.0 - params.smoothing) / (n_places + 1))


def _moved(probability: Reals) -> Reals:
    """Mean of each place and its two neighbours; the ends are neighbours of themselves."""
    padded = np.pad(probability, 1, mode="edge")
    return np.asarray((padded[:-2] + probability + padded[2:]) / 3.0)


def _log_sum(log: Reals) -> Reals:
    """``ln Σ exp`` over the first axis."""
    greatest = log.max(axis=0)
    return np.asarray(greatest + np.log(np.exp(log - greatest).sum(axis=0)))


def _log_of_all_else(log: Reals, reference: Integers) -> Reals:
    """``ln Σ exp`` of all rows but the one of each column."""
    others = log.copy()
    others[reference, np.arange(log.shape[1])] = -np.inf
    return _log_sum(others)
