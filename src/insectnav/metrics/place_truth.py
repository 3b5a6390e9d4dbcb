"""Which reference each query should be matched with: by position, or by key frames that a person matched."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_finite, check_range, check_shape

Reals = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]


class TrueMatches(NamedTuple):
    """The true match of each query; (query,) arrays."""

    reference: Reals  # number of the reference, between two of them as a fraction; NaN where there is none
    can_be_matched: Bools  # whether the place is in the map
    is_known: Bools  # whether the truth is known; where not, leave the query out of every score


def true_matches_by_position(
    reference_position: ArrayLike, query_position: ArrayLike, tolerance_m: float
) -> TrueMatches:
    """The nearest reference of each query, where one is within the tolerance.

    Where a route comes by the same place twice other references may be right as well: whether a match is right follows
    from `metrics.retrieval.position_error` ≤ tolerance, not from the number of the reference.

    Parameters
    ----------
    reference_position : (reference, 2 or 3) array [m], NaN where not known
    query_position : (query, 2 or 3) array [m], NaN where not known
        Heights count if given; those of a satellite receiver are so far off that x and y alone are better.
    tolerance_m : [m], state it with every result

    Raises
    ------
    InputError
        If shapes do not go together, the tolerance is negative, or no reference has a position.

    Notes
    -----
    A query is matched to the map as far as it is known: one beside references without position cannot be matched.
    """
    query = as_numbers("query_position", query_position).astype(float)
    reference = as_numbers("reference_position", reference_position).astype(float)
    check_shape("query_position", query, ("query", "axis"))
    check_range("number of coordinates", query.shape[1], 2, 3)
    check_shape("reference_position", reference, ("reference", query.shape[1]))
    check_range("tolerance", tolerance_m, 0.0, np.inf, "m")
    rows = np.flatnonzero(np.isfinite(reference).all(axis=-1))
    if not rows.size:
        raise InputError("no reference has a position, expected some: from another clock, or no table of positions?")
    is_known = np.isfinite(query).all(axis=-1)
    nearest, distance = _nearest(query[is_known], reference[rows])
    found = np.full(len(query), np.nan)
    found[is_known] = np.where(within(distance, tolerance_m, query, reference), rows[nearest], np.nan)
    return TrueMatches(found, np.isfinite(found), is_known)


def within(distance: Reals, tolerance: float, *positions: Reals) -> Bools:
    """Whether distances are at most the tolerance, but for the rounding of the positions that they are between.

    Parameters
    ----------
    distance : (...) array, NaN where not known
    tolerance : in the same unit
    positions : arrays in that unit, NaN where not known
    """
    largest = max(float(np.max(np.abs(one), where=np.isfinite(one), initial=0.0)) for one in positions)
    with np.errstate(invalid="ignore"):
        return np.asarray(distance <= tolerance + 4 * np.spacing(largest))


def true_matches_by_frames(
    key_frames: ArrayLike, query_frame: ArrayLike, reference_frame: ArrayLike | None = None
) -> TrueMatches:
    """The true reference of each query, interpolated linearly between key frames that a person has matched.

    Parameters
    ----------
    key_frames : (key frame, 2) array of numbers of frames
        A frame of the queries and the one of the references that was taken at the same place, frames of the queries
        increasing. NaN for the second: not in the map, from the key frame before to that after.
    query_frame : (query,) array
        Numbers of the frames that are queries, as the key frames count them.
    reference_frame : (reference,) array, increasing
        Numbers of the frames that are references, as the key frames count them; None if these count the references.

    Raises
    ------
    InputError
        If shapes do not agree, key frames of the queries do not increase, or those of the references are not there.

    Notes
    -----
    As the truth of Stone, Differt, Milford & Webb (ICRA 2016) was made; frames are interpolated, whichever of them are
    references. Queries before the first key frame and after the last are not known.
    """
    keys = as_numbers("key_frames", key_frames).astype(float)
    check_shape("key_frames", keys, ("key frame", 2))
    query = as_numbers("query_frame", query_frame).astype(float)
    check_shape("query_frame", query, ("query",))
    check_finite("query_frame", query)
    check_finite("key frames of the queries", keys[:, 0])
    if len(keys) < 2 or (np.diff(keys[:, 0]) <= 0).any():
        raise InputError(
            f"there are {len(keys)} key frames, expected two at least with frames of the queries that increase: rows "
            "out of order, or query and reference exchanged?"
        )
    is_known = (query >= keys[0, 0]) & (query <= keys[-1, 0])
    after = np.clip(np.searchsorted(keys[:, 0], query), 1, len(keys) - 1)
    first, last = keys[after - 1], keys[after]
    # Multiplied before it is divided, so that whole numbers come out whole: a tolerance may be 0.
    between = first[:, 1] + (query - first[:, 0]) * (last[:, 1] - first[:, 1]) / (last[:, 0] - first[:, 0])
    on_key = np.searchsorted(keys[:, 0], query).clip(0, len(keys) - 1)
    found = np.where(keys[on_key, 0] == query, keys[on_key, 1], between)  # a key frame beside a gap is known
    found = np.where(is_known, found, np.nan)
    if reference_frame is not None:
        found = _numbered(found, keys[:, 1], reference_frame)
    return TrueMatches(found, np.isfinite(found), is_known)


def _nearest(query: Reals, reference: Reals) -> tuple[NDArray[np.intp], Reals]:
    from scipy.spatial import cKDTree

    distance, index = cKDTree(reference).query(query)
    return np.asarray(index, np.intp), np.asarray(distance, float)


def _numbered(frame: Reals, key_frame: Reals, reference_frame: ArrayLike) -> Reals:
    """Which reference, as a fraction between two, a frame between key frames is; NaN stays."""
    frames = as_numbers("reference_frame", reference_frame).astype(float)
    check_shape("reference_frame", frames, ("reference",))
    check_finite("reference_frame", frames)
    if not frames.size or (np.diff(frames) <= 0).any():
        raise InputError("reference_frame does not increase, expected numbers of frames in order")
    known = key_frame[np.isfinite(key_frame)]
    check_range(
        "key frames of the references", known, float(frames[0]), float(frames[-1]), slip="numbers of another recording?"
    )
    return np.interp(frame, frames, np.arange(len(frames), dtype=float))
