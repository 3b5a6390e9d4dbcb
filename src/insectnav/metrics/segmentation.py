"""How good masks of the sky are, and how much they change: against the truth, and against each other.

Masks are arrays of bool, True for sky; `valid` says which pixels count. The measures of Stone, Mangan, Ardin & Webb
(2014), RSS, doi 10.15607/RSS.2014.X.047, section III.A, and two that are common since.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError

Bools = NDArray[np.bool_]
Reals = NDArray[np.float64]


def accuracy(mask: ArrayLike, truth: ArrayLike, valid: ArrayLike | None = None) -> Any:
    """Share of the pixels that are labelled as in the truth; a number, or one for each mask of a batch.

    Parameters
    ----------
    mask, truth : (..., rows, columns) arrays of bool
    valid : (..., rows, columns) array of bool, False where the truth is unknown

    Notes
    -----
    Σ_valid [mask = truth] / Σ_valid 1; NaN where no pixel counts.
    """
    one, other, counts = _checked(mask, truth, valid)
    return _ratio(_number((one == other) & counts), _number(counts))


def intersection_over_union(mask: ArrayLike, truth: ArrayLike, valid: ArrayLike | None = None) -> Any:
    """Sky in both over sky in either; a number, or one for each mask of a batch.

    Notes
    -----
    |M ∩ T| / |M ∪ T| among the pixels that count: 1 where neither has sky, 0 where only one has. Jaccard (1912), New
    Phytol. 11:37, doi 10.1111/j.1469-8137.1912.tb05611.x.
    """
    one, other, counts = _checked(mask, truth, valid)
    union = _number((one | other) & counts)
    ratio = np.where(union > 0, _number(one & other & counts) / np.maximum(union, 1), 1.0)
    return float(ratio) if ratio.ndim == 0 else ratio


def skyline_error(mask: ArrayLike, truth: ArrayLike, valid: ArrayLike | None = None) -> float:
    """Mean distance between two skylines [px], of any shape; infinite if only one of them exists, 0 if neither.

    Parameters
    ----------
    mask, truth : (rows, columns) arrays of bool

    Notes
    -----
    A skyline is the set of sides between two neighbours in a row or column, both of which count, that are sky and
    ground. With L and K the skylines of mask and truth and d the distance between the middles of sides,

        (Σ_{a ∈ L} min_{b ∈ K} d(a, b) + Σ_{b ∈ K} min_{a ∈ L} d(a, b)) / (|L| + |K|).

    It is symmetric. A straight skyline that is 3 px off everywhere has 3.
    """
    from scipy.spatial import cKDTree

    one, other, counts = _checked(mask, truth, valid)
    if one.ndim != 2:
        raise InputError(f"mask has shape {one.shape}, expected (rows, columns), one picture at a time")
    ours, theirs = skyline(one, counts), skyline(other, counts)
    if not len(ours) or not len(theirs):
        return 0.0 if len(ours) == len(theirs) else float("inf")
    there = cKDTree(theirs).query(ours)[0]
    back = cKDTree(ours).query(theirs)[0]
    return float((there.sum() + back.sum()) / (len(ours) + len(theirs)))


def skyline(mask: ArrayLike, valid: ArrayLike | None = None) -> Reals:
    """Middles of the sides between pixels of sky and ground, (n, 2) row and column [px]; the first pixel is at 0, 0."""
    sky = np.asarray(mask, dtype=bool)
    counts = np.ones(sky.shape, bool) if valid is None else np.asarray(valid, dtype=bool)
    down = (sky[1:] != sky[:-1]) & counts[1:] & counts[:-1]
    right = (sky[:, 1:] != sky[:, :-1]) & counts[:, 1:] & counts[:, :-1]
    return np.concatenate([np.argwhere(down) + np.array([0.5, 0.0]), np.argwhere(right) + np.array([0.0, 0.5])])


def label_entropy(masks: ArrayLike) -> Reals:
    """Entropy of the label of each pixel over a time lapse [bit], (rows, columns); its mean is the published measure.

    Parameters
    ----------
    masks : (frame, rows, columns) array of bool

    Notes
    -----
    p = Σ_t x_t / T, H₂ = −p log₂ p − (1 − p) log₂(1 − p), Stone et al. (2014), Eqs. 1 and 2: 0 for a pixel that never
    changes, 1 for one that is sky half of the time.
    """
    from scipy.special import entr

    labels = _stack(masks)
    p = labels.mean(axis=0, dtype=np.float64)
    return np.asarray((entr(p) + entr(1.0 - p)) / np.log(2.0))


def label_correlation(masks: ArrayLike) -> Reals:
    """Pearson correlation of each pair of masks over their pixels, (frame, frame); NaN for a mask of one value.

    Parameters
    ----------
    masks : (frame, rows, columns) array of bool

    Notes
    -----
    r(x, y) = cov*(x, y) / sqrt(var*(x) var*(y)), Stone et al. (2014), Eq. 3.
    """
    stack = _stack(masks)
    labels = stack.reshape(len(stack), -1).astype(np.float32)
    labels -= labels.mean(axis=1, keepdims=True, dtype=np.float64).astype(np.float32)
    covariance = (labels @ labels.T).astype(np.float64)
    deviation = np.sqrt(np.diag(covariance))
    deviation = np.where(deviation > 0.0, deviation, np.nan)
    return np.asarray(np.clip(covariance / deviation[:, None] / deviation, -1.0, 1.0))


def _stack(masks: ArrayLike) -> Bools:
    labels = np.asarray(masks, dtype=bool)
    if labels.ndim != 3 or not labels.size:
        raise InputError(f"masks has shape {labels.shape}, expected (frame, rows, columns)")
    return labels


def _checked(mask: ArrayLike, truth: ArrayLike, valid: ArrayLike | None) -> tuple[Bools, Bools, Bools]:
    one, other = np.asarray(mask), np.asarray(truth)
    counts = np.ones(one.shape, bool) if valid is None else np.asarray(valid)
    for name, array in (("mask", one), ("truth", other), ("valid", counts)):
        if array.dtype.kind != "b":
            raise InputError(f"{name} holds {array.dtype.name} values, expected True and False: compare with 0 first?")
        if array.ndim < 2:
            raise InputError(f"{name} has shape {array.shape}, expected (rows, columns)")
        if array.shape[-2:] != one.shape[-2:]:
            raise InputError(
                f"{name} has {array.shape[-2]} × {array.shape[-1]} pixels and the mask {one.shape[-2]} × "
                f"{one.shape[-1]}, expected the same: the truth of another picture, or one that was resized?"
            )
    first, second, third = np.broadcast_arrays(one, other, counts)
    return first, second, third


def _number(labels: Bools) -> NDArray[np.int64]:
    return np.asarray(labels.sum(axis=(-2, -1)))


def _ratio(part: NDArray[np.int64], whole: NDArray[np.int64]) -> Any:
    ratio = np.where(whole > 0, part / np.maximum(whole, 1), np.nan)
    return float(ratio) if ratio.ndim == 0 else ratio
