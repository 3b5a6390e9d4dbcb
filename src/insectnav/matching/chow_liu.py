"""Which words tend to occur together: the tree of dependences that keeps most of their mutual information."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_shape

Reals = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]
LEAST_IMAGES = 10  # of training; assumed: fewer say nothing about pairs of words
WORDS_AT_ONCE = 64  # whose information with all others is in memory together
LEAST_PROBABILITY = 0.01  # of a word, present or absent, whatever the training: OpenFABMAP, chowliutree.cpp


@dataclass(frozen=True, kw_only=True, eq=False)
class ChowLiuTree:
    """How often words occur, alone and given the word that they hang on; made by `chow_liu_tree`.

    Parameters
    ----------
    parent : (word,) the word that each hangs on; the root on itself
    marginal : (word,) probability that the word is seen
    given_present, given_absent : (word,) the same if its parent is seen, and if not; those of the root are its marginal
    training : (image, word) the bags that this was counted from, of which new places are samples
    """

    parent: Integers
    marginal: Reals
    given_present: Reals
    given_absent: Reals
    training: Bools

    @property
    def n_words(self) -> int:
        """How many words there are."""
        return len(self.parent)

    @property
    def root(self) -> int:
        """The word that hangs on none."""
        return int(np.flatnonzero(self.parent == np.arange(self.n_words))[0])


def checked_bags(name: str, bags: ArrayLike, n_words: int | None = None) -> Bools:
    """Bags of words as (frame, word) bool; refuses counts, and another number of words.

    Raises
    ------
    InputError
        If the array is none of these.
    """
    array = np.asarray(bags)
    if array.dtype != np.bool_:
        raise InputError(f"{name} holds {array.dtype.name} values, expected True or False for each word: counts?")
    check_shape(name, array, ("frame", "word"))
    if n_words is not None and array.shape[1] != n_words:
        raise InputError(
            f"{name} has {array.shape[1]} words, expected {n_words} as the tree: bags of another vocabulary?"
        )
    return array


def chow_liu_tree(bags: ArrayLike) -> ChowLiuTree:
    """The tree of words for which the mutual information along its edges is greatest.

    Parameters
    ----------
    bags : (image, word) array of bool
        Of training images, as of `Vocabulary.bags`: places like those of the map, each of them once.

    Raises
    ------
    InputError
        If these are no bags, fewer than ten images, or one word.

    Notes
    -----
    Chow & Liu 1968, doi 10.1109/TIT.1968.1054142, as in Cummins & Newman 2008, IJRR 27, doi 10.1177/0278364908090961.
    Information is of the frequencies as counted. The probabilities that are kept are ``0.98 f + 0.01`` of a frequency
    f, so that nothing is impossible, and 0.01 where the parent never was so, as OpenFABMAP has it. The root is an end
    of the strongest edge. Time and memory grow with the square of the number of words.
    """
    seen = checked_bags("bags", bags)
    if len(seen) < LEAST_IMAGES:
        raise InputError(
            f"bags are of {len(seen)} training images, expected at least {LEAST_IMAGES}, better a thousand"
        )
    if seen.shape[1] < 2:
        raise InputError(f"bags have {seen.shape[1]} words, expected at least 2")
    both = _counts_together(seen)
    n = np.diag(both).astype(np.int64)
    parent = _strongest_tree(both, len(seen))
    with_parent = both[np.arange(len(n)), parent].astype(np.int64)
    marginal = _kept(n, np.full(len(n), len(seen)))
    is_root = parent == np.arange(len(n))
    return ChowLiuTree(
        parent=parent,
        marginal=marginal,
        given_present=np.where(is_root, marginal, _kept(with_parent, n[parent])),
        given_absent=np.where(is_root, marginal, _kept(n - with_parent, len(seen) - n[parent])),
        training=np.array(seen),
    )


def mutual_information(bags: ArrayLike) -> Reals:
    """What each word says about each other one, (word, word) [nat]; on the diagonal the entropy.

    Raises
    ------
    InputError
        If these are no bags.
    """
    seen = checked_bags("bags", bags)
    if not len(seen):
        raise InputError("bags are of no image, expected some")
    return _information(_counts_together(seen), len(seen), slice(None))


def _counts_together(seen: Bools) -> Reals:
    """In how many images both words are, (word, word); whole numbers in single precision."""
    if len(seen) >= 2**24:
        raise InputError(f"bags are of {len(seen)} images, expected fewer than {2**24}, which single precision counts")
    ones = seen.astype(np.float32)
    return ones.T @ ones


def _information(both: Reals, n_images: int, words: slice) -> Reals:
    """Mutual information of some words with all, (some word, word) [nat].

    ``Σ p_ab ln(p_ab / (p_a p_b))`` is ``(Σ t(n_ab) − Σ t(n_a) − Σ t(n_b) + t(n)) / n``, ``t(k) = k ln k`` of counts,
    which are few whole numbers and are looked up.
    """
    count = np.arange(n_images + 1)
    t = count * np.log(np.maximum(count, 1))
    n = np.diag(both).astype(np.int64)
    alone = t[n] + t[n_images - n]
    first, together = n[words, None], both[words].astype(np.int64)
    pairs = t[together] + t[first - together] + t[n - together] + t[n_images - first - n + together]
    return np.asarray(np.maximum((pairs - alone[words, None] - alone + t[-1]) / n_images, 0.0))


def _strongest_tree(both: Reals, n_images: int) -> Integers:
    """Parents of the spanning tree with the most information, (word,), by Prim's algorithm from the strongest edge."""
    n_words = len(both)
    root, most = 0, -1.0
    for start in range(0, n_words, WORDS_AT_ONCE):
        rows = _information(both, n_images, slice(start, start + WORDS_AT_ONCE))
        rows[np.arange(len(rows)), start + np.arange(len(rows))] = -1.0
        if rows.max() > most:
            root, most = start + int(np.argmax(rows)) // n_words, float(rows.max())
    parent, strength = np.full(n_words, root), _information(both, n_images, slice(root, root + 1))[0]
    is_outside = np.ones(n_words, bool)
    is_outside[root] = False
    for _ in range(n_words - 1):
        word = int(np.argmax(np.where(is_outside, strength, -np.inf)))
        is_outside[word] = False
        weight = _information(both, n_images, slice(word, word + 1))[0]
        is_stronger = is_outside & (weight > strength)
        parent[is_stronger] = word
        strength[is_stronger] = weight[is_stronger]
    return parent


def _kept(count: Integers, total: Integers) -> Reals:
    """Probability from a count, away from 0 and 1."""
    frequency = count / np.maximum(total, 1)
    return np.asarray(LEAST_PROBABILITY + (1.0 - 2.0 * LEAST_PROBABILITY) * frequency)
