"""Fourier descriptors of the outline of the sky."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, check_finite
from insectnav.vision.descriptors.sky_region import Bools, as_masks, middle_region
from insectnav.vision.descriptors.wrapped_disk import wrap_to_disk

Reals = NDArray[np.floating[Any]]
Complexes = NDArray[np.complexfloating[Any, Any]]
N_FREQUENCIES = 32  # assumed; Fig. 4.1d of the thesis redraws a sky from ten


def sky_contour(mask: ArrayLike) -> Complexes:
    """Corners of the outline of the sky above, ``right + i up``, (corner,) complex, anticlockwise.

    Parameters
    ----------
    mask : (rows, columns) array
        Seen by an eye that looks up, True or bright where there is sky.

    Returns
    -------
    (corner,) array
        Centres of the outermost pixels of the connected region nearest to the middle of the image; the middle is 0,
        half the larger side of the image 1. Empty if there is no sky.

    Raises
    ------
    InputError
        If this is no view.
    """
    import cv2

    masks = as_masks(mask)
    if masks.ndim != 2:
        raise InputError(f"mask has shape {masks.shape}, expected one of (rows, columns)")
    region: Bools = middle_region(masks)
    outlines, _ = cv2.findContours(region.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return np.empty(0, complex)
    rows, columns = region.shape
    places = outlines[0][:, 0].astype(float)
    right, down = places[:, 0] - (columns - 1) / 2.0, places[:, 1] - (rows - 1) / 2.0
    contour = (right - 1j * down) * (2.0 / max(rows, columns))
    twice_area = np.sum(contour.real * np.roll(contour.imag, -1) - contour.imag * np.roll(contour.real, -1))
    return contour if twice_area >= 0.0 else contour[::-1].copy()


def contour_coefficients(contour: ArrayLike, n_frequencies: int = N_FREQUENCIES) -> Complexes:
    """Fourier coefficients of a closed polygon, by length along it, (2 n + 1,) complex: 0, 1, −1, 2, −2, ….

    ``z(l) = sum_k a_k exp(2π i k l / L)``, l from the first corner, L the whole length.

    Parameters
    ----------
    contour : (corner,) array of complex numbers
    n_frequencies : int
        Highest k.

    Returns
    -------
    (2 n + 1,) array of complex128
        Zeros for a contour without length, but its place at k = 0.

    Raises
    ------
    InputError
        If the contour is not finite or the number is no whole one from 1.

    Notes
    -----
    Persoon & Fu 1977, IEEE Trans. Systems, Man, Cybernetics 7(3):170, doi 10.1109/TSMC.1977.4309681. The integral along
    a polygon in closed form, which is what a discrete Fourier transform of points along it tends to as they come to lie
    densely; corners need not be equally far apart. Another first corner turns phases and leaves amplitudes.
    """
    check_count("n_frequencies", n_frequencies)
    corners = np.asarray(contour, complex)
    if corners.ndim != 1:
        raise InputError(f"contour has shape {corners.shape}, expected (corner,)")
    check_finite("contour", np.abs(corners))
    coefficients = np.zeros(2 * n_frequencies + 1, complex)
    if not corners.size:
        return coefficients
    side = np.roll(corners, -1) - corners
    corners, side = corners[side != 0.0], side[side != 0.0]
    if not corners.size:
        coefficients[0] = np.asarray(contour, complex)[0]
        return coefficients
    length = np.abs(side)
    reached = np.cumsum(length, dtype=np.longdouble)  # of thousands of corners: rounding would add up
    whole = float(reached[-1])
    coefficients[0] = np.sum((corners + side / 2.0) * length) / whole
    phase = np.exp(-2j * np.pi * np.concatenate([[0.0], reached[:-1] / reached[-1]]).astype(float))
    direction = side / length
    bend = np.roll(direction, 1) - direction
    wave = np.ones_like(phase)
    for k in range(1, n_frequencies + 1):
        wave = wave * phase
        scale = whole / (2.0 * np.pi * k) ** 2
        coefficients[2 * k - 1] = scale * np.sum(bend * wave)
        coefficients[2 * k] = scale * np.sum(bend * np.conj(wave))
    return coefficients


def redraw_contour(coefficients: ArrayLike, n_points: int = 360) -> Complexes:
    """Points (n_points,) along the closed curve that the coefficients of `contour_coefficients` stand for."""
    check_count("n_points", n_points)
    values = np.asarray(coefficients, complex)
    number = np.arange(1, len(values) + 1) // 2
    frequency = np.where(np.arange(len(values)) % 2 == 1, number, -number)
    along = np.arange(n_points) / n_points
    return np.asarray(np.exp(2j * np.pi * along[:, None] * frequency) @ values)


def contour_amplitudes(masks: ArrayLike, n_frequencies: int = N_FREQUENCIES) -> Reals:
    """Amplitudes of the outline of the sky at frequencies 1, −1, 2, −2, …, (..., 2 n): the same after a turn or shift.

    Parameters
    ----------
    masks : (..., rows, columns) array
        Seen by an eye that looks up, True or bright where there is sky.
    n_frequencies : int
        Highest number of waves along the outline. For fewer take a slice.

    Returns
    -------
    (..., 2 n) array of float64
        In halves of the larger side of the image. 0 where there is no sky, or a single pixel of it.

    Raises
    ------
    InputError
        If these are no views.

    Notes
    -----
    Stone 2017, thesis, section 4.1; Persoon & Fu 1977. A sky of many pieces, as under trees, is not one outline: only
    the piece nearest to the middle counts. The size of the sky stays in the amplitudes.
    """
    array = as_masks(masks)
    stack = array.reshape(-1, *array.shape[-2:])
    amplitudes = np.empty((len(stack), 2 * n_frequencies))
    for mask, out in zip(stack, amplitudes, strict=True):
        out[:] = np.abs(contour_coefficients(sky_contour(mask), n_frequencies)[1:])
    return amplitudes.reshape(*array.shape[:-2], 2 * n_frequencies)


def panorama_contour_amplitudes(views: ArrayLike, n_frequencies: int = N_FREQUENCIES) -> Reals:
    """`contour_amplitudes` of panoramas, by way of `wrap_to_disk`, (..., 2 n).

    Parameters
    ----------
    views : (..., rows, columns) array
        Panoramas up to the zenith, bright where there is sky.
    n_frequencies : int
        Highest number of waves along the outline.

    Raises
    ------
    InputError
        As of `wrap_to_disk`.

    Notes
    -----
    The disk has the 210 pixels that `wrap_to_disk` gives it; a pixel at least half as bright as can be is sky.
    """
    return contour_amplitudes(wrap_to_disk(views) >= 0.5, n_frequencies)
