"""The panorama as a disk image, zenith in the middle, and the Zernike coefficients of such images."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice, check_count
from insectnav.vision.descriptors.brightness import as_views, brightness, describe_batches
from insectnav.vision.descriptors.zernike_basis import (
    check_order,
    radial_polynomials,
    zernike_pairs,
    zernike_weights,
)

Reals = NDArray[np.floating[Any]]
Complexes = NDArray[np.complexfloating[Any, Any]]
DISK_SIZE = 210  # [pixel] twice the 105 rows of a view of 1°: no row is lost
INTERPOLATIONS = ("nearest", "bilinear")


class DiskBasis(NamedTuple):
    """The functions of one symmetry, on the pixels of the upper left quadrant of the disk."""

    functions: Reals  # (pixel, function), times the area of a pixel
    places: NDArray[np.int64]  # (functions,) which pairs they belong to
    is_sine: bool  # sines are the imaginary parts, odd from left to right; cosines the real ones, even
    is_odd_upright: bool  # odd from top to bottom


def wrap_to_disk(views: ArrayLike, size: int = DISK_SIZE, *, interpolation: str = "nearest") -> Reals:
    """Each panorama as a disk seen from above, (..., size, size): zenith in the middle, straight ahead at the top.

    Parameters
    ----------
    views : (..., rows, columns) array
        Panoramas as of `zernike_coefficients`.
    size : int
        Diameter [pixel]. The radius of a pixel's centre is linear in the angle from the zenith; the lower edge of the
        last row is at the edge of the image.
    interpolation : str
        "nearest" takes the pixel whose cell the centre falls in, as published work did; "bilinear" mixes four.

    Returns
    -------
    (..., size, size) array
        Of the precision of `brightness`; 0 outside the disk.

    Raises
    ------
    InputError
        If the views are not panoramas or an option is unknown.
    """
    check_count("size", size, minimum=2)
    check_choice("interpolation", interpolation, INTERPOLATIONS)
    values = brightness(views)
    rows, columns = values.shape[-2:]
    flat = values.reshape(*values.shape[:-2], rows * columns)
    if interpolation == "nearest":
        disk = np.take(flat, nearest_pixels(size, rows, columns), axis=-1)
    else:
        radius, azimuth = (array.ravel() for array in _disk_polar(size))
        row, column = np.minimum(radius, 1.0) * rows, (azimuth + np.pi) * columns / (2.0 * np.pi)
        disk = _bilinear(flat, row - 0.5, column - 0.5, (rows, columns))
    disk *= (_disk_polar(size)[0] <= 1.0).ravel()
    return np.asarray(disk.reshape(*values.shape[:-2], size, size))


@lru_cache(maxsize=4)
def nearest_pixels(size: int, rows: int, columns: int) -> NDArray[np.int64]:
    """Pixel of the panorama that holds the centre of each pixel of a disk image, (size²,); outside, one at the rim."""
    radius, azimuth = _disk_polar(size)
    # Rounded, so that a centre on the line between two pixels falls to the same side in all quadrants.
    row = np.minimum(np.round(radius * rows, 9).astype(int), rows - 1)
    column = np.round((azimuth + np.pi) * columns / (2.0 * np.pi), 9).astype(int) % columns
    return np.asarray(row * columns + column).ravel()


def zernike_disk_coefficients(disks: ArrayLike, order: int = 16) -> Complexes:
    """Integral of f R_nm(r) e^(−imθ) over each disk image, (..., pair) complex; see `zernike_pairs`.

    Parameters
    ----------
    disks : (..., size, size) array
        The disk touches the edges of the image; pixels whose centres lie beyond it are left out. Bytes count as 0 to 1.
    order : int
        Highest n, up to 50.

    Returns
    -------
    (..., pair) array of complex128
        θ runs clockwise from the top, as in `wrap_to_disk`.

    Raises
    ------
    InputError
        If the images are not square or the order is out of range.

    Notes
    -----
    As the code to Sun, Yue & Mangan 2020, eLife 9:e54026, doi 10.7554/eLife.54026, samples the disk. Square pixels at
    the rim cost accuracy: `zernike_coefficients` takes panoramas without this step.
    """
    check_order(order)
    array = as_views(disks)
    size = array.shape[-1]
    if array.shape[-2] != size:
        raise InputError(f"disk images have shape {array.shape}, expected square ones")
    return _coefficients(array, quadrant_pixels(size), size, order)


def zernike_disk_amplitudes(
    views: ArrayLike,
    order: int = 16,
    *,
    weights: str = "stone",
    size: int = DISK_SIZE,
    interpolation: str = "nearest",
) -> Reals:
    """Weighted moduli of the Zernike coefficients of each panorama by way of a disk image, (..., pair).

    Parameters
    ----------
    views, size, interpolation
        As of `wrap_to_disk`.
    order, weights
        As of `zernike_amplitudes`, which is faster, and more accurate.
    """
    check_order(order)
    check_choice("interpolation", interpolation, INTERPOLATIONS)
    factors = zernike_weights(order, weights)
    if interpolation == "bilinear":
        return np.abs(zernike_disk_coefficients(wrap_to_disk(views, size, interpolation="bilinear"), order)) * factors
    check_count("size", size, minimum=2)
    array = as_views(views)
    pixels = nearest_pixels(size, array.shape[-2], array.shape[-1])[quadrant_pixels(size)]  # no image in between
    return np.abs(_coefficients(array, pixels, size, order)) * factors


@lru_cache(maxsize=4)
def quadrant_pixels(size: int) -> NDArray[np.int64]:
    """Where the pixels of the disk lie in a flat image, (4, pixel): upper left, upper right, lower left, lower right.

    The same pixel of all four quadrants stands in a column. With an odd size the middle row and column belong to two.
    """
    half = (size + 1) // 2
    i, j = np.nonzero(_disk_polar(size)[0][:half, :half] <= 1.0)
    return np.stack([row * size + column for row in (i, size - 1 - i) for column in (j, size - 1 - j)])


@lru_cache(maxsize=4)
def disk_bases(size: int, order: int) -> tuple[DiskBasis, ...]:
    """Bases of disk images of this size, made once: a quadrant stands for all four, a quarter of the work."""
    pixels = quadrant_pixels(size)
    radius, azimuth = (array.ravel()[pixels[0]] for array in _disk_polar(size))
    n_same = 1 + sum((pixels[0] == pixels[k]).astype(int) for k in (1, 2, 3))  # on a middle row or column
    area = (2.0 / size) ** 2 / n_same
    radial = radial_polynomials(order, radius) * area[:, None]
    m = zernike_pairs(order)[1]
    bases = []
    for is_sine in (False, True):
        for is_odd_upright in (False, True):
            # cos mθ changes by (−1)^m from θ to π − θ, sin mθ by −(−1)^m; sin 0 is nothing
            places = np.flatnonzero((m % 2 == (is_odd_upright != is_sine)) & (m >= is_sine))
            waves = -np.sin(azimuth[:, None] * m[places]) if is_sine else np.cos(azimuth[:, None] * m[places])
            bases.append(DiskBasis(radial[:, places] * waves, places, is_sine, is_odd_upright))
    return tuple(bases)


def _disk_polar(size: int) -> tuple[Reals, Reals]:
    """Radius, and angle clockwise from the top, of the centre of each pixel, both (size, size)."""
    place = (2.0 * np.arange(size) + 1.0) / size - 1.0
    right, down = np.meshgrid(place, place)
    return np.hypot(right, down), np.arctan2(right, -down)


def _bilinear(flat: Reals, row: Reals, column: Reals, shape: tuple[int, int]) -> Reals:
    """Values (..., pixel) at fractional rows, held at the first and last, and columns, which go round."""
    rows, columns = shape
    row = np.clip(row, 0.0, rows - 1.0)
    top, left = np.minimum(row.astype(int), rows - 2) if rows > 1 else np.zeros(len(row), int), np.floor(column)
    below, right = (row - top).astype(flat.dtype), (column - left).astype(flat.dtype)
    first, second = left.astype(int) % columns, (left.astype(int) + 1) % columns
    bottom = np.minimum(top + 1, rows - 1)

    def along(level: NDArray[np.int64]) -> Reals:
        pair = (np.take(flat, level * columns + place, axis=-1) for place in (first, second))
        return np.asarray(next(pair) * (1 - right) + next(pair) * right)

    return np.asarray(along(top) * (1 - below) + along(bottom) * below)


def _coefficients(array: NDArray[Any], pixels: NDArray[np.int64], size: int, order: int) -> Complexes:
    """Coefficients (..., pair) of the disk whose quadrants are at these pixels of each view."""
    bases, n_pairs = disk_bases(size, order), len(zernike_pairs(order)[0])

    def project(values: NDArray[np.float64]) -> Complexes:
        corners = (np.take(values.reshape(len(values), -1), quadrant, axis=1) for quadrant in pixels)
        up_left, up_right, down_left, down_right = corners
        coefficients = np.zeros((len(values), n_pairs), complex)
        for is_sine, part in ((False, coefficients.real), (True, coefficients.imag)):
            up = up_left - up_right if is_sine else up_left + up_right
            down = down_left - down_right if is_sine else down_left + down_right
            for basis in (basis for basis in bases if basis.is_sine == is_sine):
                part[:, basis.places] = (up - down if basis.is_odd_upright else up + down) @ basis.functions
        return coefficients

    return describe_batches(array, project, n_pairs, complex)
