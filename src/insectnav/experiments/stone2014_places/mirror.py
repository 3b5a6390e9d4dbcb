"""The round picture in a panoramic mirror, and how it goes over into panoramas and back."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.vision.cameras import Camera, panorama, parabolic_mirror

ELEVATIONS_DEG = (-15.0, 90.0)  # [°] that the mirror shows, assumed: its maker's field is not told
LARGEST_ANGLE = float(np.deg2rad(90.0 - ELEVATIONS_DEG[0]))  # [rad] from the zenith

Integers = NDArray[np.int64]
Bools = NDArray[np.bool_]


class MirrorPixels(NamedTuple):
    """Which pixels of a panorama and of a mirror picture show the same."""

    of_mirror: Integers  # (size, size) pixel of the panorama, in a flat array, that each pixel of the mirror shows
    seen: Bools  # (size, size) whether a pixel of the mirror shows anything
    of_panorama: Integers  # (rows, columns) pixel of the mirror, in a flat array, that each pixel of a panorama shows


def mirror_camera(size: int) -> Camera:
    """Camera over a paraboloid that fills a picture of size × size pixels: zenith in the middle, ahead at the top."""
    radius = size / 2.0 / np.tan(LARGEST_ANGLE / 2.0)
    return parabolic_mirror((size, size), float(radius), field=(0.0, LARGEST_ANGLE))


@lru_cache(maxsize=4)
def mirror_pixels(size: int, resolution_deg: float) -> MirrorPixels:
    """How a mirror picture and a panorama of that resolution go over into each other, by the nearest pixel."""
    mirror, whole = mirror_camera(size), panorama(resolution_deg, ELEVATIONS_DEG)
    seen = mirror.pixels_seen()
    look = mirror.pixel_directions()
    of_mirror = np.zeros((size, size), np.int64)
    of_mirror[seen] = _flat(whole, look[seen])
    return MirrorPixels(of_mirror, seen, _flat(mirror, whole.pixel_directions()))


def _flat(camera: Camera, directions: Any) -> Integers:
    """Pixels that see directions (..., 3), as places in a flat array."""
    pixels, _ = camera.project(directions)
    column, row = (np.minimum(pixels[..., k].astype(np.int64), camera.size[1 - k] - 1) for k in (0, 1))
    return np.asarray(row * camera.size[1] + column)


def in_mirror(picture: NDArray[Any], pixels: MirrorPixels) -> NDArray[Any]:
    """A panorama (rows, columns) as seen in the mirror, (size, size); 0 where it shows nothing."""
    return np.where(pixels.seen, picture.ravel()[pixels.of_mirror], picture.dtype.type(0))


def unwrapped(picture: NDArray[Any], pixels: MirrorPixels) -> NDArray[Any]:
    """A mirror picture (size, size) as a panorama, (rows, columns)."""
    return np.asarray(picture.ravel()[pixels.of_panorama])
