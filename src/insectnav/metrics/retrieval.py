"""How well places were recognised: precision, recall, and how far off in space."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_finite, check_range, check_shape

Reals = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]


class PrecisionRecall(NamedTuple):
    """One point for each distinct score, the best first; (threshold,) arrays."""

    precision: Reals  # right matches kept / matches kept
    recall: Reals  # right matches kept / queries that can be matched
    threshold: Reals  # matches of this score or less are kept


def right_matches(matched: ArrayLike, truth: ArrayLike, tolerance: float) -> Bools:
    """Whether each match is near enough to the true one, (query,): ``matched ≥ 0 and |matched − truth| ≤ tolerance``.

    Parameters
    ----------
    matched : (query,) array
        Number of the reference of each query, −1 where there is none.
    truth : (query,) array [reference frame]
        NaN where the place is not in the map: any match is then wrong.
    tolerance : float [reference frame]
        State it with every result.

    Raises
    ------
    InputError
        If the arrays differ in length or the tolerance is negative.
    """
    match, true = as_numbers("matched", matched).astype(float), as_numbers("truth", truth).astype(float)
    check_shape("matched", match, ("query",))
    check_shape("truth", true, match.shape)
    check_range("tolerance", tolerance, 0.0, np.inf)
    with np.errstate(invalid="ignore"):
        return np.asarray((match >= 0) & (np.abs(match - true) <= tolerance))


def precision_recall(is_right: ArrayLike, score: ArrayLike, can_be_matched: ArrayLike | None = None) -> PrecisionRecall:
    """Precision and recall as ever worse matches are kept, one point for each distinct score.

    ``precision(s) = R(s) / K(s)`` and ``recall(s) = R(s) / M``: of the K matches whose score is s or less, R are right;
    M queries can be matched.

    Parameters
    ----------
    is_right : (query,) array of bool
        Of `right_matches`, or by distance in space.
    score : (query,) array
        Lower is better; NaN where there is no match.
    can_be_matched : (query,) array of bool
        Which queries have a place in the map and frames enough around them; None for all that have a score. A match of
        another query is wrong, and lowers precision alone.

    Raises
    ------
    InputError
        If lengths differ, no query can be matched, or a match is right that cannot be.

    Notes
    -----
    As usual for place recognition (Milford & Wyeth, ICRA 2012): a query that is not matched, or wrongly, lowers recall,
    which so ends below 1. Thresholds are all scores that occur: a fixed number of them would miss the best ones.
    """
    scores = as_numbers("score", score)
    check_shape("score", scores, ("query",))
    right = _bools("is_right", is_right, scores.shape)
    is_kept = ~np.isnan(scores)
    able = is_kept if can_be_matched is None else _bools("can_be_matched", can_be_matched, scores.shape)
    if (right & is_kept & ~able).any():
        query = int(np.flatnonzero(right & is_kept & ~able)[0])
        raise InputError(f"query {query} is matched rightly but is said to be none that can be matched")
    if not able.any():
        raise InputError("no query can be matched, expected some: recall is a share of these")
    order = np.argsort(scores[is_kept], kind="stable")
    sorted_scores, sorted_right = scores[is_kept][order], right[is_kept][order]
    is_last = np.append(sorted_scores[1:] != sorted_scores[:-1], True)[: len(sorted_scores)]
    n_right = np.cumsum(sorted_right)[is_last]
    n_kept = np.arange(1, len(sorted_scores) + 1)[is_last]
    return PrecisionRecall(n_right / n_kept, n_right / able.sum(), sorted_scores[is_last])


def recall_at_full_precision(curve: PrecisionRecall) -> float:
    """Greatest recall of all thresholds at which every match is right; 0 if the best match is wrong."""
    return float(curve.recall[curve.precision == 1.0].max(initial=0.0))


def precision_at_full_recall(curve: PrecisionRecall) -> float:
    """Precision if all matches are kept, however bad their score; NaN if there are none."""
    return float(curve.precision[-1]) if len(curve.precision) else float("nan")


def area_under_curve(curve: PrecisionRecall) -> float:
    """Area under precision over recall, ``Σ_k (recall_k − recall_{k−1}) precision_k``; 1 if all is right.

    Notes
    -----
    Average precision, as `sklearn.metrics.average_precision_score` has it, times the share of the queries that are
    matched rightly with no threshold, which there is 1. Steps are not joined by straight lines, which would count what
    no threshold gives.
    """
    return float(np.sum(np.diff(curve.recall, prepend=0.0) * curve.precision))


def position_error(reference_position: ArrayLike, query_position: ArrayLike, matched: ArrayLike) -> Reals:
    """Distance from where each query was taken to where its match was, ``|x_q − x_match(q)|``, (query,).

    Parameters
    ----------
    reference_position : (reference, 2 or 3) array
        In any unit of length; NaN where it is not known.
    query_position : (query, 2 or 3) array
        In the same unit.
    matched : (query,) array of whole numbers
        −1 where there is no match.

    Returns
    -------
    (query,) array
        In that unit; NaN where there is no match or a position is not known.

    Raises
    ------
    InputError
        If shapes do not go together or a match is none of the references.
    """
    query = as_numbers("query_position", query_position).astype(float)  # differences of unsigned numbers wrap
    reference = as_numbers("reference_position", reference_position).astype(float)
    match = as_numbers("matched", matched)
    check_shape("query_position", query, ("query", "axis"))
    check_shape("reference_position", reference, ("reference", query.shape[1]))
    check_shape("matched", match, (len(query),))
    check_finite("matched", match)
    check_range("matched", match, -1, len(reference) - 1, slip="matched with another map?")
    whole = match.astype(np.int64)
    if (whole != match).any():
        row = int(np.argmax(whole != match))
        raise InputError(f"matched is {match[row]:g} for query {row}, expected the whole number of a reference, or −1")
    distance, is_matched = np.full(len(query), np.nan), whole >= 0
    distance[is_matched] = np.linalg.norm(query[is_matched] - reference[whole[is_matched]], axis=-1)
    return distance


def _bools(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Bools:
    array = np.asarray(values)
    if array.dtype.kind != "b":
        raise InputError(f"{name} holds {array.dtype.name} values, expected True or False")
    check_shape(name, array, shape)
    return array
