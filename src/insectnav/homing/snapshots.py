"""Views compared with a remembered one: aligned, at random headings, or over all turns, as a visual compass."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import wrap
from insectnav.checks import InputError, check_choice, check_count, check_finite, check_radians
from insectnav.vision.descriptors.brightness import as_views, batches, brightness

Reals = NDArray[np.floating[Any]]
COMPARISONS = ("aligned", "random", "compass")
WHOLE_COLUMN = 1e-9  # [column] a turn this near to whole columns is one: no interpolation


class Compass(NamedTuple):
    """The best match over all turns on the spot; arrays of the leading shape of the views."""

    difference: Reals  # root mean square pixel difference there
    turn: Reals  # [rad] to make, positive to the right, so as to face as in the remembered view


def turn_views(views: ArrayLike, turn: ArrayLike) -> Reals:
    """Panoramas as seen after a turn on the spot, (..., rows, columns).

    Parameters
    ----------
    views : (..., rows, columns) array
        All 360°, the middle column straight ahead, the left half to the left. Bytes count as 0 to 1.
    turn : (...) array [rad]
        Positive to the right; of the leading shape of the views, or one for all.

    Returns
    -------
    (..., rows, columns) array
        Exact for turns by whole columns; between columns interpolated linearly, which blurs.
    """
    check_finite("turn", turn)
    check_radians("turn", turn)
    values = brightness(views)
    columns = values.shape[-1]
    shift = np.broadcast_to(np.asarray(turn, float) * columns / (2.0 * np.pi), values.shape[:-2])[..., None, None]
    near = np.rint(shift)
    shift = np.where(np.abs(shift - near) < WHOLE_COLUMN, near, shift)
    whole = np.floor(shift)
    first = (np.arange(columns) + whole.astype(int)) % columns
    left = np.take_along_axis(values, np.broadcast_to(first, values.shape), axis=-1)
    share = (shift - whole).astype(values.dtype)
    if not share.any():
        return left
    right = np.take_along_axis(values, np.broadcast_to((first + 1) % columns, values.shape), axis=-1)
    return np.asarray(left * (1 - share) + right * share)


def random_headings(shape: int | tuple[int, ...], seed: int) -> Reals:
    """Headings [rad] of the given shape, uniform over the circle; the same for the same seed on any machine."""
    check_count("seed", seed, minimum=0)
    generator = np.random.Generator(np.random.PCG64(seed))
    return wrap(2.0 * np.pi * generator.random(shape))


def rms_difference(views: ArrayLike, remembered: ArrayLike) -> Reals:
    """Root mean square pixel difference of each view from the remembered one, (...).

    Parameters
    ----------
    views : (..., rows, columns) array
    remembered : (rows, columns) array
        The same pixels, of a heading that is known to be the same. Bytes count as 0 to 1.

    Notes
    -----
    Zeil, Hofmann & Chahl 2003, J. Opt. Soc. Am. A 20(3):450, doi 10.1364/JOSAA.20.000450.
    """
    array, reference = _views_and_reference(views, remembered)
    stack = array.reshape(-1, *reference.shape)
    difference = np.empty(len(stack))
    for piece, values in batches(stack):
        apart = (values - reference).reshape(len(values), -1)
        difference[piece] = np.sqrt(np.einsum("np,np->n", apart, apart) / reference.size)
    return difference.reshape(array.shape[:-2])[()]


def difference_by_turn(views: ArrayLike, remembered: ArrayLike) -> Reals:
    """Root mean square pixel difference after each turn by whole columns, (..., columns): rotational functions.

    Parameters
    ----------
    views : (..., rows, columns) array
    remembered : (rows, columns) array

    Returns
    -------
    (..., columns) array
        Entry k: after a turn of k columns to the right, 2π k / columns.

    Notes
    -----
    The mean square difference is that of both squares less twice their correlation, which for all turns at once is one
    inverse Fourier transform: columns · log(columns) operations in the place of columns². Below about 1e-8 of the
    brightness a difference is rounding.
    """
    array, reference = _views_and_reference(views, remembered)
    stack, columns = array.reshape(-1, *reference.shape), reference.shape[-1]
    waves = np.conj(np.fft.rfft(reference, axis=-1))
    difference = np.empty((len(stack), columns))
    for piece, values in batches(stack):
        correlation = np.fft.irfft(np.einsum("nrk,rk->nk", np.fft.rfft(values, axis=-1), waves), columns, axis=-1)
        squares = np.einsum("nrc,nrc->n", values, values) + np.sum(reference**2)
        difference[piece] = np.sqrt(np.maximum(squares[:, None] - 2.0 * correlation, 0.0) / reference.size)
    return difference.reshape(*array.shape[:-2], columns)


def visual_compass(views: ArrayLike, remembered: ArrayLike) -> Compass:
    """Least difference over all turns by whole columns, and the turn that gives it.

    Parameters
    ----------
    views : (..., rows, columns) array
    remembered : (rows, columns) array

    Returns
    -------
    Compass
        Two arrays (...). The turn is in [−π, π), to a column; the first of equals, counted to the right.

    Notes
    -----
    Zeil et al. 2003; Labrosse 2006, J. Field Robotics 23(10):913, doi 10.1002/rob.20159.
    """
    array, reference = _views_and_reference(views, remembered)
    best = np.argmin(difference_by_turn(array, reference), axis=-1)
    turn = wrap(best * (2.0 * np.pi / reference.shape[-1]))
    stack, turns = array.reshape(-1, *reference.shape), np.ravel(turn)
    difference = np.empty(len(stack))  # again from the pixels: correlation leaves 1e-8 where there is none
    for piece, values in batches(stack):
        difference[piece] = rms_difference(turn_views(values, turns[piece]), reference)
    return Compass(difference.reshape(array.shape[:-2])[()], turn)


def difference_surface(
    views: ArrayLike, remembered: ArrayLike, comparison: str = "aligned", *, seed: int | None = None
) -> Reals:
    """Image difference function: how far each view is from the remembered one, (...).

    Parameters
    ----------
    views : (..., rows, columns) array
        Views at the positions of a grid (y, x) or of a line, all at the heading of the remembered one.
    remembered : (rows, columns) array
    comparison : str
        "aligned": at that heading. "random": each view at a random heading of its own, the remembered one as it is.
        "compass": the least over all turns.
    seed : int
        Of the random headings: the same seed, the same surface.

    Raises
    ------
    InputError
        If the shapes differ, the comparison is unknown or "random" has no seed.
    """
    check_choice("comparison", comparison, COMPARISONS)
    if comparison == "aligned":
        return rms_difference(views, remembered)
    if comparison == "compass":
        return visual_compass(views, remembered).difference
    if seed is None:
        raise InputError("comparison is 'random' without a seed, expected a whole number that fixes the headings")
    array, reference = _views_and_reference(views, remembered)
    stack = array.reshape(-1, *reference.shape)
    headings = random_headings(len(stack), seed)
    difference = np.empty(len(stack))
    for piece, values in batches(stack):
        difference[piece] = rms_difference(turn_views(values, headings[piece]), reference)
    return difference.reshape(array.shape[:-2])[()]


def feature_distance(features: ArrayLike, remembered: ArrayLike) -> Reals:
    """Euclidean distance of each descriptor vector from the remembered one, (...).

    Parameters
    ----------
    features : (..., feature) array
        From one of `insectnav.vision.descriptors.DESCRIPTORS`.
    remembered : (feature,) array
    """
    check_finite("features", features)
    check_finite("remembered features", remembered)
    vectors, reference = np.asarray(features), np.asarray(remembered)
    if reference.ndim != 1 or vectors.shape[-1:] != reference.shape:
        raise InputError(
            f"features have shape {vectors.shape} and the remembered ones {reference.shape}, "
            "expected (..., feature) and (feature,): the same descriptor?"
        )
    return np.linalg.norm(vectors - reference, axis=-1)


def _views_and_reference(views: ArrayLike, remembered: ArrayLike) -> tuple[NDArray[Any], Reals]:
    """Views as given, and the remembered one as brightness in double precision; refuses unlike shapes."""
    array, reference = as_views(views), as_views(remembered)
    if reference.ndim != 2 or array.shape[-2:] != reference.shape:
        raise InputError(
            f"views have shape {array.shape} and the remembered one {reference.shape}, "
            "expected (..., rows, columns) and (rows, columns)"
        )
    ((_, values),) = batches(reference[None])
    return array, values[0]
