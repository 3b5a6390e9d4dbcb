"""How different each query is from each reference."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice
from insectnav.lanes import LANES
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
METRICS = ("cosine", "euclidean", "absolute", "hamming", "openseqslam-v1")
QUERIES_PER_BLOCK = 64
BLOCKS_LAID = 8  # of 16 references each, that one thread brings into form at a time
NEAR_SINGLE, NEAR_DOUBLE = 2.0**-6, 2.0**-20  # cosine differences below which 1 − a·b has lost too many digits
ROOM = 1e-9, 1e15  # of the largest feature, so that squares of differences have some in single precision
FEW_FEATURES = 512  # to which sums are in double precision: short vectors are often nearly the same


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
    workers : threads; they change nothing in the results

    Returns
    -------
    (reference, query) array of float32
        A column lies in memory in one piece. Rows and columns of missing frames are NaN.

    Raises
    ------
    InputError
        If the numbers of features differ, a vector is partly NaN or infinite, the metric is unknown or wants bits, or a
        difference is beyond single precision.

    Notes
    -----
    Each difference is summed feature by feature, in double precision up to 512 features, above in single with the sums
    of 512 features, of products 128, added up in double: equal vectors differ by 0, near ones keep their digits, and a
    difference does not depend on what else is compared. "cosine" subtracts a·b from 1, good to about 5e-7 in single
    precision; of nearer vectors, below 2⁻⁶ in single and 2⁻²⁰ in double, it sums ``|a − b|² / 2`` of unit vectors,
    which is the same and keeps its digits. "euclidean" takes the mean of the references off first where it sums in
    single precision, and divides by a power of 2 where squares would have no room in it, which changes no digit.
    """
    return prepare_references(references, metric).differences(queries, workers=workers)


class Common(NamedTuple):
    """What all references together decide, also where only a part of them is compared."""

    n_references: int
    middle: Reals  # (feature,) taken off each vector
    unit: float = 1.0  # a power of 2 that vectors are divided by, where their squares have no room in single precision


@dataclass(frozen=True, kw_only=True, eq=False)
class References:
    """Descriptors of a route, ready to be compared; made by `prepare_references`.

    Parameters
    ----------
    vectors : of the references in the form that the metric wants
    is_missing : (reference,) which frames have no descriptor
    metric : one of `METRICS`
    n_features : of the descriptors
    common : what all references together decide
    has_length : (reference,) which vectors are not 0
    """

    vectors: NDArray[Any]
    is_missing: NDArray[np.bool_]
    metric: str
    n_features: int
    common: "Common"
    has_length: NDArray[np.bool_]

    def differences(self, queries: ArrayLike, *, workers: int | None = None) -> Reals:
        """Difference of each reference and each query, (reference, query), as `difference_matrix` says."""
        vectors, is_missing = checked_vectors("queries", queries)
        if vectors.shape[1] != self.n_features:
            raise InputError(
                f"references have {self.n_features} features and queries {vectors.shape[1]}, expected as many: "
                "the same descriptor?"
            )
        if self.vectors.dtype == np.uint8 and vectors.dtype != np.uint8:
            raise InputError(
                f"queries hold {vectors.dtype.name} values, expected bytes as the references: one option apart?"
            )
        out = np.empty((len(vectors), len(self.is_missing)), np.float32)

        def compare(first: int, last: int) -> None:
            _compare(self, vectors[first:last], out[first:last])
            if not np.isfinite(out[first:last]).all():
                raise InputError(
                    f"a difference by {self.metric} is beyond 3e38, or 1e18 times what references come to, expected "
                    "features of moderate size: of another unit, or damaged?"
                )

        run_blocks(compare, len(vectors), QUERIES_PER_BLOCK, workers)
        if self.metric == "cosine":
            out[~vectors.any(axis=1)] = 1.0
            out[:, ~self.has_length] = 1.0
        out[is_missing] = np.nan
        out[:, self.is_missing] = np.nan
        return out.T


def prepare_references(references: ArrayLike, metric: str = "cosine", *, common: Common | None = None) -> References:
    """References brought once into the form in which queries are compared with them.

    Parameters
    ----------
    references, metric
        As of `difference_matrix`.
    common : of all references, where these are a part of them

    Raises
    ------
    InputError
        As of `difference_matrix`.
    """
    check_choice("metric", metric, METRICS)
    vectors, is_missing = checked_vectors("references", references)
    common = common or common_of(vectors, is_missing, metric)
    if metric == "hamming":
        prepared: NDArray[Any] = pack_bits("references", vectors)
    elif vectors.dtype == np.uint8 and metric in ("absolute", "openseqslam-v1"):
        prepared = vectors
    else:
        prepared = _side_by_side(vectors, metric, common)
    return References(
        vectors=prepared,
        is_missing=is_missing,
        metric=metric,
        n_features=vectors.shape[1],
        common=common,
        has_length=np.asarray(vectors.any(axis=1)) if metric == "cosine" else ~is_missing,
    )


def common_of(vectors: NDArray[Any], is_missing: NDArray[np.bool_], metric: str) -> Common:
    """What all references (frame, feature) together decide."""
    if metric != "euclidean" or vectors.shape[1] <= FEW_FEATURES or is_missing.all():
        return Common(len(vectors), np.zeros(vectors.shape[1]))
    known = vectors[~is_missing] if is_missing.any() else vectors
    largest = max(float(known.max()), -float(known.min()))
    has_room = ROOM[0] < largest < ROOM[1] or not largest
    unit = 1.0 if has_room else 2.0 ** int(np.clip(np.frexp(largest)[1], -500, 500))
    return Common(len(vectors), known.mean(axis=0, dtype=np.float64), unit)


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


def _precision(vectors: NDArray[Any], metric: str) -> np.dtype[Any]:
    """In which differences from these references are summed."""
    is_single = vectors.dtype == np.float32 or metric in ("cosine", "euclidean")
    return np.dtype(np.float32 if is_single and vectors.shape[1] > FEW_FEATURES else np.float64)


def _scaled(vectors: NDArray[Any], metric: str, common: Common, dtype: np.dtype[Any]) -> Reals:
    """Vectors over their lengths or less the middle, in the precision in which differences are summed."""
    if metric == "cosine":
        return unit_vectors(vectors, dtype)
    if metric == "euclidean":
        vectors = vectors - common.middle
        if common.unit != 1.0:
            vectors = vectors / common.unit
    with np.errstate(over="ignore"):  # what is too large shows in the differences
        return vectors.astype(dtype, copy=False)


def unit_vectors(vectors: NDArray[Any], dtype: np.dtype[Any]) -> Reals:
    """Vectors over their lengths; 0 where there is no length."""
    length = _lengths(vectors)
    is_extreme = ~((length > 1e-30) & (length < 1e30))  # whose squares, or inverse in single precision, have no room
    if is_extreme.any():
        largest = np.abs(vectors[is_extreme]).max(axis=1, keepdims=True)
        vectors = vectors.copy()
        vectors[is_extreme] = vectors[is_extreme] / np.where(largest > 0, largest, 1)
        length[is_extreme] = _lengths(vectors[is_extreme])
    scale = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)[:, None]
    return np.asarray(vectors * scale.astype(dtype)).astype(dtype, copy=False)


def _lengths(vectors: NDArray[Any]) -> Reals:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors, dtype=np.float64)))


def _side_by_side(vectors: NDArray[Any], metric: str, common: Common) -> Reals:
    """Scaled vectors, sixteen side by side: (block, feature, lane), as compiled code takes them; zeros at the end."""
    n, n_features = vectors.shape
    blocks = np.zeros((-(-n // LANES), n_features, LANES), _precision(vectors, metric))

    def lay(first: int, last: int) -> None:
        scaled = _scaled(vectors[first * LANES : last * LANES], metric, common, blocks.dtype)
        n_whole = len(scaled) // LANES
        whole = scaled[: n_whole * LANES].reshape(n_whole, LANES, n_features)
        blocks[first : first + n_whole] = whole.transpose(0, 2, 1)
        if len(scaled) % LANES:
            blocks[-1, :, : len(scaled) % LANES] = scaled[n_whole * LANES :].T

    run_blocks(lay, len(blocks), BLOCKS_LAID)
    return blocks


def _compare(references: References, queries: NDArray[Any], out: Reals) -> None:
    """Fill ``out`` (query, reference) with the differences of some queries."""
    from insectnav.matching import difference_kernel

    reference, metric, common = references.vectors, references.metric, references.common
    scale = float(common.n_references if metric == "openseqslam-v1" else references.n_features)
    if metric == "hamming":
        difference_kernel.count_unequal_bits(pack_bits("queries", queries), reference, scale, out)
        return
    if reference.dtype == np.uint8:
        difference_kernel.sum_byte_differences(queries, reference, scale, out)
        return
    scaled = np.ascontiguousarray(_scaled(queries, metric, common, reference.dtype))
    if metric in ("absolute", "openseqslam-v1"):
        difference_kernel.sum_differences(scaled, reference, False, False, scale, out)
    elif metric == "euclidean":
        difference_kernel.sum_differences(scaled, reference, True, True, common.unit**-2, out)
    else:
        near = NEAR_DOUBLE if reference.dtype == np.float64 else NEAR_SINGLE
        difference_kernel.subtract_cosines(scaled, reference, near, out)
