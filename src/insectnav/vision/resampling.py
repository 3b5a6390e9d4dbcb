"""Images onto directions: what an eye, or a grid of directions, sees through a camera.

Each direction has a field of its own, a Gaussian about it. The image is looked up at many directions that are spread
in this field, so that no pixel within it is missed and nothing finer than it is aliased. All of it is linear, and
therefore done once, when the resampler is built: afterwards an image is one sparse matrix product.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, check_finite, check_range, check_shape
from insectnav.vision.cameras import Bools, Camera
from insectnav.vision.sphere import GOLDEN_ANGLE, Reals, check_directions, to_world

HALF_MAXIMUM_IN_SIGMA = float(2.0 * np.sqrt(2.0 * np.log(2.0)))  # full width at half maximum of a Gaussian
_MIN_SAMPLES, _MAX_SAMPLES = 128, 2048
_SAMPLES_PER_PIXEL_SQUARED = 16.0  # of the width; some four in each pixel out to 2.6 sigma
_CHUNK = 500_000  # samples that are worked on together


@runtime_checkable
class Viewer(Protocol):
    """Whatever looks along directions: a `SphereGrid`, a `CompoundEye`."""

    @property
    def directions(self) -> Reals:
        """Unit vectors, (n, 3)."""

    @property
    def acceptance(self) -> Reals:
        """Full width at half maximum of the field of each, (n,) [rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Resampler:
    """Values on directions of images of one camera; made by `resampler`.

    Parameters
    ----------
    weights : (n, rows · columns) sparse matrix, float32; a row adds up to 1, or to 0 where the direction is not seen
    size : (rows, columns) of the images
    coverage : (n,) share of the field of each direction that the camera saw, 0 to 1
    seen : (n,) whether that share is large enough for a value
    """

    weights: Any
    size: tuple[int, int]
    coverage: Reals
    seen: Bools

    def __call__(self, images: ArrayLike, *, unseen: float = np.nan) -> NDArray[np.float32]:
        """Values on the directions, of images as they are or with bands.

        Parameters
        ----------
        images : (..., rows, columns) or (..., rows, columns, band) array of any real type or bool; not scaled
        unseen : value of directions that the camera does not see

        Returns
        -------
        (..., n) or (..., n, band) array, float32

        Raises
        ------
        InputError
            If the images are not of the camera's size.
        """
        stack, has_bands = self._stack(np.asarray(images))
        values = np.empty((len(stack), len(self.seen), stack.shape[-1]), dtype=np.float32)
        for image, out in zip(stack, values, strict=True):
            pixels = np.ascontiguousarray(image, dtype=np.float32)
            out[:] = self.weights @ pixels.reshape(-1, pixels.shape[-1])
        values[:, ~self.seen] = unseen
        lead = np.shape(images)[: -3 if has_bands else -2]
        values = values.reshape(*lead, *values.shape[1:])
        return values if has_bands else values[..., 0]

    def _stack(self, images: NDArray[Any]) -> tuple[NDArray[Any], bool]:
        """Images as (image, rows, columns, band), and whether bands were given."""
        if images.dtype.kind not in "biuf":
            raise InputError(f"images hold {images.dtype.name} values, expected real numbers")
        if images.shape[-2:] == self.size:
            return images.reshape(-1, *self.size, 1), False
        if images.shape[-3:-1] == self.size:
            return images.reshape(-1, *self.size, images.shape[-1]), True
        turned = images.shape[-2:] == self.size[::-1] or images.shape[-3:-1] == self.size[::-1]
        rows, columns = self.size
        raise InputError(
            f"images have shape {images.shape}, expected (..., {rows}, {columns}) or (..., {rows}, {columns}, bands), "
            f"the size of the camera{': turned by 90°?' if turned else ''}"
        )


def resampler(
    camera: Camera,
    viewer: Viewer | ArrayLike,
    *,
    acceptance: ArrayLike | None = None,
    rotation: ArrayLike | None = None,
    mask: ArrayLike | None = None,
    least_coverage: float = 0.5,
    n_samples: int | None = None,
) -> Resampler:
    """Resampler from images of a camera to the directions of a grid or an eye.

    Parameters
    ----------
    camera : what took the images
    viewer : grid, compound eye, or (n, 3) array of unit vectors in the frame in which the camera is mounted
    acceptance : (n,) array or number [rad], full width at half maximum of the Gaussian field of each direction; None
        for the viewer's own
    rotation : (3, 3) array, camera's eye ← viewer, of `sphere.rotation_matrix`; None if they share one frame
    mask : (rows, columns) array of bool, True where the image may be used; None for all that the camera sees
    least_coverage : share of its field that must be seen for a direction to have a value
    n_samples : looked up in each field; None for about four in each pixel, at least 128 and at most 2048

    Raises
    ------
    InputError
        If directions are no unit vectors, an acceptance is missing, negative or in degrees, or the mask is of another
        size.

    Notes
    -----
    Samples lie on a spiral with equal weights, radii by the quantiles of the Gaussian, scaled so that its second moment
    is exact, and turned four times by 90°, so that no direction is preferred. Lookups are bilinear between the centres
    of pixels. Pixels that are masked, or whose centre the camera does not see, are left out and the rest are scaled up.
    Of an image of pure noise the values so found have an error of a tenth of their own standard deviation.
    """
    directions, widths = _directions_and_widths(viewer, acceptance)
    if rotation is not None:
        matrix = np.asarray(rotation, dtype=np.float64)
        check_shape("rotation", matrix, (3, 3))
        directions = to_world(directions, matrix)
    check_range("least_coverage", least_coverage, 1e-6, 1.0)
    usable = camera.pixels_seen()
    if mask is not None:
        given = np.asarray(mask)
        check_shape("mask", given, camera.size)
        usable = usable & given.astype(bool)
    if n_samples is None:
        n_samples = _sample_count(camera, directions, widths)
    check_count("n_samples", n_samples)
    weights, coverage = _weights(camera, directions, widths, usable, _unit_spiral(n_samples), least_coverage)
    return Resampler(weights=weights, size=camera.size, coverage=coverage, seen=coverage >= least_coverage)


def _directions_and_widths(viewer: Viewer | ArrayLike, acceptance: ArrayLike | None) -> tuple[Reals, Reals]:
    """Directions (n, 3) and full widths at half maximum (n,), checked."""
    given = acceptance
    if isinstance(viewer, Viewer):
        directions = check_directions("directions", viewer.directions).astype(np.float64)
        given = viewer.acceptance if acceptance is None else acceptance
    else:
        directions = check_directions("directions", viewer).astype(np.float64)
    check_shape("directions", directions, ("n", 3))
    if given is None:
        raise InputError("acceptance is missing, expected the width of the field of each direction in radians")
    check_finite("acceptance", given)
    check_range("acceptance", given, 0.0, np.pi, "rad", "degrees?")
    widths = np.asarray(given, dtype=np.float64)
    if widths.ndim:
        check_shape("acceptance", widths, (len(directions),))
    return directions, np.broadcast_to(widths, (len(directions),))


def _tangents(directions: Reals) -> tuple[Reals, Reals]:
    """Two unit vectors across each direction (n, 3), at right angles to each other."""
    # The axis of the frame that is farthest from the direction cannot be parallel to it.
    axis = np.eye(3)[np.argmin(np.abs(directions), axis=-1)]
    first = np.cross(directions, axis)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return first, np.cross(directions, first)


def _sample_count(camera: Camera, directions: Reals, widths: Reals) -> int:
    """Samples for about four in each pixel of the field of a typical direction; a multiple of four."""
    step = 1e-4
    first, second = _tangents(directions)
    here, seen = camera.project(directions)
    moved = [camera.project(_unit(directions + step * tangent))[0] for tangent in (first, second)]
    jacobian = np.stack([there - here for there in moved], axis=-1) / step
    pixels_per_radian = np.sqrt(
        np.abs(jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0])
    )
    pixels = (widths * pixels_per_radian)[seen & np.isfinite(pixels_per_radian)]
    typical = float(np.median(pixels)) if pixels.size else 0.0
    return 4 * int(np.ceil(np.clip(_SAMPLES_PER_PIXEL_SQUARED * typical**2, _MIN_SAMPLES, _MAX_SAMPLES) / 4))


def _unit(vectors: Reals) -> Reals:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _unit_spiral(n_samples: int) -> Reals:
    """Points (sample, 2) in the plane, of equal weight and spread as a Gaussian of standard deviation 1."""
    n_turned = -(-n_samples // 4)
    index = np.arange(n_turned)
    radius = np.sqrt(-2.0 * np.log1p(-(index + 0.5) / n_turned))
    radius *= np.sqrt(2.0 / np.mean(radius**2))
    angle = index[None, :] * GOLDEN_ANGLE + np.pi / 2 * np.arange(4)[:, None]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)


def _weights(
    camera: Camera, directions: Reals, widths: Reals, usable: Bools, spiral: Reals, least_coverage: float
) -> tuple[Any, Reals]:
    """Sparse matrix (direction, pixel), whose rows add up to 1 or 0, and the share of the field that was seen."""
    from scipy.sparse import csr_array, diags_array, vstack

    n_pixels, parts = usable.size, []
    chunk = max(1, _CHUNK // len(spiral))
    for start in range(0, max(len(directions), 1), chunk):
        here = slice(start, start + chunk)
        samples = _samples(directions[here], widths[here] / HALF_MAXIMUM_IN_SIGMA, spiral)
        pixel, share = _bilinear(camera, samples, usable)
        row = np.broadcast_to(np.arange(len(samples))[:, None, None], pixel.shape)
        kept = share > 0.0
        entries = (share[kept] / len(spiral), (row[kept], pixel[kept]))
        parts.append(csr_array(entries, shape=(len(samples), n_pixels)))
    matrix = vstack(parts, format="csr")
    coverage = np.minimum(np.asarray(matrix.sum(axis=1)).ravel(), 1.0)
    scale = np.where(coverage >= least_coverage, 1.0 / np.maximum(coverage, 1e-12), 0.0)
    weights = (diags_array(scale) @ matrix).tocsr().astype(np.float32)
    weights.eliminate_zeros()
    return weights, coverage


def _samples(directions: Reals, sigma: Reals, spiral: Reals) -> Reals:
    """Directions (n, sample, 3) that are spread about each direction, along great circles."""
    first, second = _tangents(directions)
    offset = sigma[:, None, None] * (spiral[:, :1] * first[:, None] + spiral[:, 1:] * second[:, None])
    angle = np.linalg.norm(offset, axis=-1, keepdims=True)
    return directions[:, None] * np.cos(angle) + offset * np.sinc(angle / np.pi)


def _bilinear(camera: Camera, samples: Reals, usable: Bools) -> tuple[NDArray[np.intp], Reals]:
    """Flat numbers of the four pixels about each sample, (n, sample, 4), and their shares, 0 where not usable."""
    rows, columns = camera.size
    places, seen = camera.project(samples)
    corner = np.where(seen[..., None], places, 0.5) - 0.5
    low = np.floor(corner)
    fraction = corner - low
    column = low[..., 0, None].astype(np.intp) + np.array([0, 1, 0, 1])
    row = low[..., 1, None].astype(np.intp) + np.array([0, 0, 1, 1])
    column = np.mod(column, columns) if camera.wraps else np.clip(column, 0, columns - 1)
    row = np.clip(row, 0, rows - 1)
    right, down = fraction[..., 0, None], fraction[..., 1, None]
    across = np.where(np.array([0, 1, 0, 1]) == 1, right, 1.0 - right)
    along = np.where(np.array([0, 0, 1, 1]) == 1, down, 1.0 - down)
    is_used = usable[row, column] & seen[..., None]
    return row * columns + column, np.where(is_used, across * along, 0.0)
