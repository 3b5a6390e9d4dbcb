"""How different each query is from each reference."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice
from insectnav.lanes import LANES
from insectnav.matching.blocks import run_blocks

Reals = NDArray[np.floating[Any]]
METRICS = ("cosine", "euclidean", "absolute", "hamming", "openseqslam-v1")
QUERIES_PER_BLOCK = 64
PRODUCTS_AT_ONCE = 2**21  # 16 MiB in double precision
FEW_QUERIES = 4  # to which no product is made: on the move, its library's threads would cost more than they save
FEW_FEATURES = 512  # to which products are in double precision: short vectors are often nearly the same
NEAR = {4: 1e-2, 8: 1e-9}  # of both squares, by bytes of a number: nearer pairs are computed from the vectors


def difference_matrix(
    references: ArrayLike, queries: ArrayLike, metric: str = "cosine", *, workers: int | None = None
) -> Reals:
    """Difference of each reference and each query, (reference, query) float32; 0 where they are the same.

    Parameters
    ----------
    references, queries : (reference, feature) and (query, feature) arrays
        Descriptors in the order of their route, from `insectnav.vision.descriptors` or from anywhere else. A row of NaN
        stands for a frame that is missing.
    metric : str
        With vectors a and b of n features:
        "cosine": ``1 − a·b / (|a| |b|)``, and 1 for a vector without length;
        "euclidean": ``|a − b|``;
        "absolute": ``Σ |a_i − b_i| / n``;
        "hamming": share of features that differ, of bits;
        "openseqslam-v1": ``Σ |a_i − b_i|`` over the number of references, exact for bytes.
    workers : threads, apart from those of the library for matrix products; they change nothing in the results

    Returns
    -------
    (reference, query) array of float32
        A column lies in memory in one piece. Rows and columns of missing frames are NaN.

    Raises
    ------
    InputError
        If the numbers of features differ, a vector is partly NaN or infinite, the metric is unknown or wants bits.

    Notes
    -----
    "cosine" and "euclidean" by a matrix product, in double precision up to 512 features, above in single. Of pairs that
    are so near that its rounding would show, the difference is taken vector from vector: equal vectors differ by 0, and
    near ones are right to five digits. "euclidean" takes the mean of the references off first.
    """
    return prepare_references(references, metric).differences(queries, workers=workers)


@dataclass(frozen=True, kw_only=True, eq=False)
class References:
    """Descriptors of a route, ready to be compared; made by `prepare_references`.

    Parameters
    ----------
    vectors : (reference, …) array in the form that the metric wants
    is_missing : (reference,) which frames have no descriptor
    metric : one of `METRICS`
    n_features : of the descriptors
    middle : (feature,) what is taken off each vector
    has_length : (reference,) which vectors are not 0
    """

    vectors: NDArray[Any]
    is_missing: NDArray[np.bool_]
    metric: str
    n_features: int
    middle: Reals
    has_length: NDArray[np.bool_]

    def differences(self, queries: ArrayLike, *, workers: int | None = None) -> Reals:
        """Difference of each reference and each query, (reference, query), as `difference_matrix` says."""
        vectors, is_missing = checked_vectors("queries", queries)
        if vectors.shape[1] != self.n_features:
            raise InputError(
                f"references have {self.n_features} features and queries {vectors.shape[1]}, expected as many: "
                "the same descriptor?"
            )
        out = np.empty((len(vectors), len(self.vectors)), np.float32)
        if self.metric in ("cosine", "euclidean"):
            _by_product(self, self.in_form(vectors), workers, out)
        else:
            _by_sum(self, self.in_form(vectors), workers, out)
        out[is_missing] = np.nan
        out[:, self.is_missing] = np.nan
        return out.T

    def in_form(self, vectors: NDArray[Any]) -> NDArray[Any]:
        """Vectors (frame, feature) in the form that the metric wants."""
        return _in_form("queries", vectors, self.metric, self.middle, self.vectors.dtype)


def prepare_references(references: ArrayLike, metric: str = "cosine") -> References:
    """References brought once into the form in which queries are compared with them.

    Parameters
    ----------
    references, metric
        As of `difference_matrix`.

    Raises
    ------
    InputError
        As of `difference_matrix`.
    """
    check_choice("metric", metric, METRICS)
    vectors, is_missing = checked_vectors("references", references)
    n_features = vectors.shape[1]
    middle = np.zeros(n_features)
    if metric in ("cosine", "euclidean"):
        dtype = np.dtype(np.float64 if n_features <= FEW_FEATURES else np.float32)
        if metric == "euclidean" and not is_missing.all():
            middle = vectors[~is_missing].mean(axis=0, dtype=np.float64)
    elif metric == "hamming":
        dtype = np.dtype(np.uint64)
    else:
        dtype = vectors.dtype if vectors.dtype in (np.uint8, np.float32) else np.dtype(np.float64)
    return References(
        vectors=_in_form("references", vectors, metric, middle, dtype),
        is_missing=is_missing,
        metric=metric,
        n_features=n_features,
        middle=middle,
        has_length=np.asarray(vectors.any(axis=1)),
    )


def checked_vectors(name: str, vectors: ArrayLike) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Descriptors (frame, feature) in one piece, with 0 for those of missing frames, and which these are.

    Raises
    ------
    InputError
        If they are not real numbers of that shape, or NaN or infinite in part.
    """
    array = np.asarray(vectors)
    if array.dtype.kind not in "biuf" or array.ndim != 2 or 0 in array.shape:
        raise InputError(
            f"{name} have shape {array.shape} and type {array.dtype.name}, expected real numbers (frame, feature)"
        )
    is_missing = np.zeros(len(array), bool)
    if array.dtype.kind != "f":
        return np.ascontiguousarray(array), is_missing
    with np.errstate(invalid="ignore", over="ignore"):
        is_bad = ~np.isfinite(array.sum(axis=1, dtype=np.float64))
    for frame in np.flatnonzero(is_bad):
        is_missing[frame] = np.isnan(array[frame]).all()
        if not is_missing[frame] and not np.isfinite(array[frame]).all():
            raise InputError(
                f"the descriptor of frame {frame} of the {name} is NaN or infinite in part, expected finite numbers, "
                "or NaN throughout for a frame that is missing"
            )
    if is_missing.any():
        array = np.where(is_missing[:, None], array.dtype.type(0), array)
    return np.ascontiguousarray(array), is_missing


def pack_bits(name: str, vectors: NDArray[Any]) -> NDArray[np.uint64]:
    """Bits (frame, feature) in words of 64, (frame, word), the last filled up with zeros.

    Raises
    ------
    InputError
        If there is anything but 0 and 1.
    """
    if vectors.dtype.kind != "b":
        if not ((vectors == 0) | (vectors == 1)).all():
            raise InputError(f"{name} hold values other than 0 and 1, expected bits for the metric 'hamming'")
        vectors = vectors.astype(bool)
    packed = np.packbits(vectors, axis=1)
    words = np.zeros((len(packed), -(-packed.shape[1] // 8) * 8), np.uint8)
    words[:, : packed.shape[1]] = packed
    return words.view(np.uint64)


def _in_form(name: str, vectors: NDArray[Any], metric: str, middle: Reals, dtype: np.dtype[Any]) -> NDArray[Any]:
    if metric == "hamming":
        return pack_bits(name, vectors)
    if dtype == np.uint8:
        if vectors.dtype != np.uint8:
            raise InputError(
                f"{name} hold {vectors.dtype.name} values, expected bytes as the references: one option apart?"
            )
        return vectors
    if metric == "euclidean":
        vectors = vectors - middle
    elif metric == "cosine":
        vectors = _unit(vectors, dtype)
    n = vectors.shape[1]
    in_lanes = np.zeros((len(vectors), -(-n // LANES) * LANES), dtype)
    in_lanes[:, :n] = vectors
    return in_lanes


def _unit(vectors: NDArray[Any], dtype: np.dtype[Any]) -> Reals:
    """Vectors over their lengths; 0 where there is no length."""
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors, dtype=np.float64))[:, None]
    scale = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
    return np.asarray(vectors * scale.astype(dtype))


def _by_product(references: References, query: NDArray[Any], workers: int | None, out: Reals) -> None:
    from insectnav.matching.difference_kernel import finish_products

    reference, is_cosine = references.vectors, references.metric == "cosine"
    if is_cosine:
        power = np.ones(len(query) + len(reference))
    else:
        power = np.concatenate([np.einsum("ij,ij->i", v, v, dtype=np.float64) for v in (query, reference)])
    n_rows, is_few = query.shape[1] // LANES, len(query) <= FEW_QUERIES
    least = np.inf if is_few else NEAR[reference.itemsize]  # few: all pairs vector from vector
    size = max(QUERIES_PER_BLOCK, PRODUCTS_AT_ONCE // len(reference))
    for start in range(0, len(query), size):
        if is_few:
            product = np.zeros(out.shape, reference.dtype)
        else:
            product = query[start : start + size] @ reference.T  # not in threads of ours, which would hinder its own

        def run(first: int, last: int, start: int = start, product: Reals = product) -> None:
            rows, piece = out[start + first : start + last], product[first:last]
            finish_products(query, reference, n_rows, power, least, start + first, start + last, piece, out)
            if is_cosine:
                rows *= 0.5  # |a − b|² = 2 − 2 a·b of unit vectors
            else:
                np.sqrt(rows, out=rows)

        run_blocks(run, len(out[start : start + size]), QUERIES_PER_BLOCK, workers)
    if is_cosine:
        out[~query.any(axis=1)] = 1.0
        out[:, ~references.has_length] = 1.0


def _by_sum(references: References, query: NDArray[Any], workers: int | None, out: Reals) -> None:
    from insectnav.matching import difference_kernel

    reference = references.vectors
    scale = float(len(reference) if references.metric == "openseqslam-v1" else references.n_features)
    n_rows = query.shape[1] // LANES

    def run(first: int, last: int) -> None:
        if references.metric == "hamming":
            difference_kernel.count_unequal_bits(query, reference, first, last, scale, out)
        elif reference.dtype == np.uint8:
            difference_kernel.sum_byte_differences(query, reference, first, last, scale, out)
        else:
            difference_kernel.sum_real_differences(query, reference, n_rows, first, last, scale, out)

    run_blocks(run, len(query), QUERIES_PER_BLOCK, workers)
