"""Visual compass: views compared after all turns on the spot, for place and heading at once."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import wrap
from insectnav.checks import InputError, as_numbers, check_count, check_range, check_shape
from insectnav.matching.difference import pack_bits
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
CORRELATIONS_PER_BLOCK = 2**20  # complex numbers: 16 MiB
N_TURNS = 90  # of 4°, Stone, Mangan, Ardin & Webb, RSS 2014, section II-F


class TurnMatrix(NamedTuple):
    """The best of all turns for each pair of views, (reference, query) arrays."""

    difference: Reals  # after that turn; NaN where a view is missing
    turn: Reals  # [rad] to make at the query, positive to the right, so as to face as at the reference


class VisualCompass(NamedTuple):
    """The nearest reference of each query after any turn, (query,) arrays."""

    reference: Integers  # −1 where there is none
    turn: Reals  # [rad] as of `TurnMatrix`; NaN where there is none
    difference: Reals  # NaN where there is none


def turn_matrix(
    references: ArrayLike, queries: ArrayLike, *, normalise: bool = True, workers: int | None = None
) -> TurnMatrix:
    """Least root mean square difference of each pair of panoramas over all turns by whole columns, and that turn.

    Parameters
    ----------
    references, queries : (reference, rows, columns) and (query, rows, columns) arrays
        Panoramas of 360°, the middle column straight ahead, the left half to the left; grey, or bits of a sky. A view
        of NaN stands for one that is missing.
    normalise : bool
        Takes the mean off each view and divides by its standard deviation first, which takes out brightness and
        contrast; a constant view then differs by sqrt(2) from all, as one without any likeness. Without it the
        difference of two skies of bits is the square root of the share that differs.
    workers : threads; they change nothing in the results

    Returns
    -------
    TurnMatrix
        The turn is in [−π, π), to a column; the first of equals, counted to the right. `seqslam` takes the difference.

    Raises
    ------
    InputError
        If the panoramas are not of one size, or partly NaN.

    Notes
    -----
    Zeil, Hofmann & Chahl 2003, J. Opt. Soc. Am. A 20(3):450, doi 10.1364/JOSAA.20.000450; Labrosse 2006, J. Field
    Robotics 23(10):913, doi 10.1002/rob.20159. The mean square difference is that of both squares less twice their
    correlation, and the correlations of all turns are one inverse Fourier transform. Below about 1e-8 of the
    brightness a difference is rounding.
    """
    reference, is_missing_reference = _checked_views("references", references, normalise)
    query, is_missing_query = _checked_views("queries", queries, normalise)
    if reference.shape[1:] != query.shape[1:]:
        raise InputError(
            f"references are of {reference.shape[1:]} rows and columns and queries of {query.shape[1:]}, expected the "
            "same: one camera, one resolution?"
        )
    columns = reference.shape[-1]
    square, best = _best_turns(reference, query, normalise, workers)
    difference = np.sqrt(np.maximum(square, 0.0) / (reference.shape[1] * columns))
    difference[is_missing_query] = np.nan
    difference[:, is_missing_reference] = np.nan
    return TurnMatrix(difference.T, wrap(best * (2.0 * np.pi / columns)).T)


def _best_turns(
    reference: NDArray[np.float64], query: NDArray[np.float64], is_normal: bool, workers: int | None
) -> tuple[Reals, Integers]:
    """Sum of squared differences after the best turn, and that turn in columns, (query, reference) each."""
    columns = reference.shape[-1]
    spectrum = np.ascontiguousarray(np.conj(np.fft.rfft(reference)).transpose(2, 1, 0))  # (frequency, row, reference)

    def power(views: NDArray[np.float64]) -> Reals:
        # Normal views have the power of their pixels, also constant ones, which so resemble none rather than all.
        return np.full(len(views), float(views[0].size)) if is_normal else np.einsum("nrc,nrc->n", views, views)

    reference_power = power(reference)
    square, best = np.empty((len(query), len(reference))), np.empty((len(query), len(reference)), np.int64)

    def run(first: int, last: int) -> None:
        views = query[first:last]
        waves = np.fft.rfft(views).transpose(2, 0, 1) @ spectrum
        correlation = np.fft.irfft(np.ascontiguousarray(waves.transpose(1, 2, 0)), columns)
        turn = correlation.argmax(axis=-1)
        highest = np.take_along_axis(correlation, turn[..., None], axis=-1)[..., 0]
        square[first:last], best[first:last] = power(views)[:, None] + reference_power - 2.0 * highest, turn

    run_blocks(run, len(query), max(1, CORRELATIONS_PER_BLOCK // (len(reference) * columns)), workers)
    return square, best


def disk_turn_matrix(
    references: ArrayLike, queries: ArrayLike, n_turns: int = N_TURNS, *, workers: int | None = None
) -> TurnMatrix:
    """Least share of bits that differ between each pair of skies over all turns of the query, and that turn.

    Parameters
    ----------
    references, queries : (reference, size, size) and (query, size, size) arrays of bits
        Skies as disks with the zenith in the middle, straight ahead at the top and azimuth clockwise, as of
        `wrap_to_disk`; mirror the image of a camera that looks up. What is outside the disk does not count.
    n_turns : int
        Turns over the whole circle.
    workers : threads; they change nothing in the results

    Returns
    -------
    TurnMatrix
        The turn is in [−π, π); the first of equals, counted to the right.

    Raises
    ------
    InputError
        If the skies are not of one square size, or not of bits.

    Notes
    -----
    Stone, Mangan, Ardin & Webb, RSS 2014, section II-F: the sum of the exclusive or of both images at each rotation;
    images are turned by taking the nearest pixel.
    """
    check_count("n_turns", n_turns)
    reference, query = _checked_disks("references", references), _checked_disks("queries", queries)
    if reference.shape != (len(reference), *query.shape[1:]):
        raise InputError(f"references have shape {reference.shape} and queries {query.shape}, expected one size")
    difference, turn = _best_disk_turns(reference, query, n_turns, workers)
    return TurnMatrix(difference.T, wrap(turn).T)


def _best_disk_turns(
    reference: NDArray[np.bool_], query: NDArray[np.bool_], n_turns: int, workers: int | None
) -> tuple[Reals, Reals]:
    """Share of the disk that differs after the best turn, and that turn [rad], (query, reference) each."""
    from insectnav.matching.difference_kernel import count_unequal_bits

    size = reference.shape[-1]
    place = (2.0 * np.arange(size) + 1.0) / size - 1.0
    right, up = (axis.ravel() for axis in np.meshgrid(place, -place))
    is_inside = np.hypot(right, up) <= 1.0
    right, up, n_inside = right[is_inside], up[is_inside], float(is_inside.sum())
    words = pack_bits("references", reference.reshape(len(reference), -1)[:, is_inside])
    pixels = query.reshape(len(query), -1)
    difference, turn = np.full((len(query), len(reference)), np.inf), np.zeros((len(query), len(reference)))
    share = np.empty((len(query), len(reference)))
    for k in range(n_turns):
        angle = 2.0 * np.pi * k / n_turns
        turned = pack_bits("queries", np.take(pixels, _turned_pixels(right, up, angle, size), axis=1))

        def count(first: int, last: int, turned: NDArray[np.uint64] = turned) -> None:
            count_unequal_bits(turned[first:last], words, n_inside, share[first:last])

        run_blocks(count, len(query), 16, workers)
        is_better = share < difference
        difference[is_better], turn[is_better] = share[is_better], angle
    return difference, turn


def nearest_view(turns: TurnMatrix) -> VisualCompass:
    """The reference that each query resembles most after any turn, with that turn.

    Parameters
    ----------
    turns : TurnMatrix

    Notes
    -----
    The visual compass of Stone et al., RSS 2014: no memory of the sequence, place and heading from one view. The
    heading of the query is that of the reference less the turn.
    """
    difference = np.where(np.isnan(turns.difference), np.inf, turns.difference)
    best = difference.argmin(axis=0)
    query = np.arange(len(best))
    is_known = np.isfinite(difference[best, query])
    return VisualCompass(
        np.where(is_known, best, -1),
        np.where(is_known, turns.turn[best, query], np.nan),
        np.where(is_known, difference[best, query], np.nan),
    )


def turns_of_matches(
    references: ArrayLike, queries: ArrayLike, matched: ArrayLike, *, normalise: bool = True
) -> VisualCompass:
    """The turn of each query that makes it most like the reference it was matched with: SeqSLAM first, then compass.

    Parameters
    ----------
    references, queries, normalise
        As of `turn_matrix`.
    matched : (query,) array of whole numbers
        `Matches.reference`; −1 where there is none.

    Raises
    ------
    InputError
        As of `turn_matrix`; or if a match is none of the references.

    Notes
    -----
    Suggested in Stone et al., RSS 2014, section IV: one view is turned for each query in place of all.
    """
    match = as_numbers("matched", matched)
    views = np.asarray(queries)
    check_shape("matched", match, (len(views),))
    reference = np.asarray(references)
    if match.dtype.kind not in "iu":
        raise InputError(f"matched holds {match.dtype.name} values, expected whole numbers, −1 where there is no match")
    check_range("matched", match, -1, len(reference) - 1, slip="matched with another map?")
    result = VisualCompass(match.astype(np.int64), np.full(len(views), np.nan), np.full(len(views), np.nan))
    for query in np.flatnonzero(match >= 0):
        pair = turn_matrix(reference[match[query]][None], views[query][None], normalise=normalise, workers=1)
        result.turn[query], result.difference[query] = pair.turn[0, 0], pair.difference[0, 0]
    result.turn[np.isnan(result.difference)] = np.nan
    return result


def _checked_views(name: str, views: ArrayLike, normalise: bool) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Views in double precision, 0 for those that are missing, and which these are."""
    array = np.asarray(views)
    if array.dtype.kind not in "biuf" or array.ndim != 3 or 0 in array.shape:
        raise InputError(
            f"{name} have shape {array.shape} and type {array.dtype.name}, expected real numbers (view, rows, columns)"
        )
    values = array.astype(np.float64)
    is_missing = np.asarray(np.isnan(values).all(axis=(1, 2)))
    is_bad = np.asarray(~np.isfinite(values).all(axis=(1, 2))) & ~is_missing
    if is_bad.any():
        raise InputError(
            f"view {np.flatnonzero(is_bad)[0]} of the {name} is NaN or infinite in part, expected finite "
            "numbers, or NaN throughout for a view that is missing"
        )
    values[is_missing] = 0.0
    if normalise:
        values -= values.mean(axis=(1, 2), keepdims=True)
        deviation = values.std(axis=(1, 2), keepdims=True)
        values = np.divide(values, deviation, out=np.zeros_like(values), where=deviation > 1e-12)
    return values, is_missing


def _checked_disks(name: str, skies: ArrayLike) -> NDArray[np.bool_]:
    array = np.asarray(skies)
    if array.ndim != 3 or 0 in array.shape or array.shape[1] != array.shape[2]:
        raise InputError(f"{name} have shape {array.shape}, expected (sky, size, size)")
    if array.dtype.kind != "b" and not ((array == 0) | (array == 1)).all():
        raise InputError(f"{name} hold values other than 0 and 1, expected skies of bits")
    return array.astype(bool)


def _turned_pixels(right: Reals, up: Reals, angle: float, size: int) -> Integers:
    """The pixel, in a flat image, that comes to lie at each place when the eye turns to the right."""
    # What lies at azimuth a + angle comes to lie at a. A little more, so that quarter turns go from centre to centre.
    along = right * np.cos(angle) + up * np.sin(angle), right * np.sin(angle) - up * np.cos(angle)
    column, row = (((axis + 1.0) * (size / 2.0) + 1e-9).astype(np.int64) for axis in along)
    return np.asarray(np.minimum(row, size - 1) * size + np.minimum(column, size - 1))
