"""What took the frames of a map, in a word of the command line, and the camera that this stands for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from threading import Lock

import numpy as np

from insectnav.checks import InputError, check_choice, check_range, quoted
from insectnav.vision import Camera, Resampler, fisheye, parabolic_mirror, resampler
from insectnav.vision.cameras import EQUIRECTANGULAR
from insectnav.vision.sphere import SphereGrid, equirectangular

KINDS = ("ahead", "panorama", "fisheye", "mirror")
GRID_DEG = 1.5  # pixel of the panorama on which skies are described; 60 degrees of harmonics need 3° at most
GRID_ELEVATION_DEG = (-15.0, 90.0)  # of the panoramas that the descriptors take
FIELD_OF_VIEW_DEG = 180.0  # of a fisheye that is not told
# Panoramas of square pixels whose height says which elevations they show: rendered ones, and whole spheres.
HEIGHTS_DEG = {105.0: (-15.0, 90.0), 180.0: (-90.0, 90.0)}
_LOCK = Lock()


@dataclass(frozen=True, kw_only=True)
class ViewCamera:
    """What took the pictures; made by `view_camera`.

    Parameters
    ----------
    kind : one of `KINDS`
    numbers : of a fisheye the field of view [deg]; of a panorama its lowest and highest elevation [deg], or nothing; of
        a mirror the radius at which it shows the horizon [px]
    """

    kind: str
    numbers: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """The word on the command line, in its shortest form."""
        return self.kind + (":" + ",".join(f"{number:g}" for number in self.numbers) if self.numbers else "")

    @property
    def is_round(self) -> bool:
        """Whether the picture is a disk with the zenith in its middle."""
        return self.kind in ("fisheye", "mirror")

    @property
    def in_words(self) -> str:
        """What is assumed of it, for a person."""
        if self.kind == "fisheye":
            return (
                f"a fisheye that looks up, {self.numbers[0]:g}° from rim to rim, equidistant, its disk touching the "
                "nearer edges of the picture"
            )
        if self.kind == "mirror":
            return f"a camera over a paraboloid mirror that shows the horizon {self.numbers[0]:g} pixels from its axis"
        if self.kind == "panorama":
            low_high = f" from {self.numbers[0]:g}° to {self.numbers[1]:g}° of elevation" if self.numbers else ""
            return f"panoramas of 360°{low_high}, straight ahead in their middle"
        return "a camera that looks ahead, the top of its pictures up"

    def of_size(self, size: tuple[int, int]) -> Camera:
        """The camera of pictures of (rows, columns).

        Raises
        ------
        InputError
            If it looks ahead, so that nobody knows how wide, or a panorama does not say which elevations it shows.
        """
        if self.kind == "ahead":
            raise InputError(
                "the camera looks ahead, expected one that sees the sky all round for this descriptor: "
                "--camera panorama, fisheye or mirror, or --descriptor patch-normalised"
            )
        if self.kind == "fisheye":
            return fisheye(size, float(np.deg2rad(self.numbers[0])))
        if self.kind == "mirror":
            return parabolic_mirror(size, self.numbers[0])
        return _panorama(size, self.numbers or _elevations(size))


AHEAD = ViewCamera(kind="ahead")


def view_camera(text: str) -> ViewCamera:
    """The camera that a word such as fisheye:180 stands for.

    Raises
    ------
    InputError
        If the kind is unknown or its numbers make no sense.
    """
    kind, colon, rest = text.strip().partition(":")
    check_choice("camera", kind, KINDS)
    try:
        numbers = tuple(float(part) for part in rest.split(",")) if colon else ()
    except ValueError:
        raise InputError(f"camera is {quoted(text)}, expected numbers after the colon as in fisheye:180") from None
    counts = {"ahead": (0,), "panorama": (0, 2), "fisheye": (0, 1), "mirror": (1,)}[kind]
    if len(numbers) not in counts:
        example = {"ahead": "ahead", "panorama": "panorama:-15,90", "fisheye": "fisheye:180", "mirror": "mirror:240"}
        what = " with its radius at the horizon in pixels" if kind == "mirror" else ""
        raise InputError(f"camera is {quoted(text)}, expected {kind}{what} as in {example[kind]}")
    if kind == "fisheye":
        numbers = numbers or (FIELD_OF_VIEW_DEG,)
        check_range("field of view of the camera", numbers[0], 1.0, 360.0, "degrees")
    if kind == "panorama" and numbers:
        check_range("elevation of the camera", numbers, -90.0, 90.0, "degrees")
        if not numbers[0] < numbers[1]:
            raise InputError(f"camera is {quoted(text)}, expected the lower elevation first")
    if kind == "mirror":
        check_range("radius of the mirror", numbers[0], 1.0, 1e5, "px")
    return ViewCamera(kind=kind, numbers=numbers)


def _elevations(size: tuple[int, int]) -> tuple[float, float]:
    """Elevations that a panorama of square pixels shows by its height alone."""
    height = 360.0 * size[0] / size[1]
    for known, elevations in HEIGHTS_DEG.items():
        if abs(height - known) <= 180.0 / size[1]:  # half a pixel
            return elevations
    raise InputError(
        f"a panorama of {size[0]} × {size[1]} pixels shows {height:.3g}° of elevation, expected --camera "
        "panorama:LOW,HIGH to say which, as in panorama:-15,60"
    )


def _panorama(size: tuple[int, int], elevation_deg: tuple[float, ...]) -> Camera:
    low, high = elevation_deg
    rows, columns = size
    pixels_per_degree = rows / (high - low)
    return Camera(
        model=EQUIRECTANGULAR,
        size=size,
        focal_length=(columns / (2 * np.pi), float(np.rad2deg(pixels_per_degree))),
        centre=(columns / 2, high * pixels_per_degree),
        field=(0.0, np.pi),
    )


@lru_cache(maxsize=1)
def grid() -> SphereGrid:
    """The directions on which skies are described: a panorama, its highest row first."""
    return equirectangular(GRID_DEG, GRID_ELEVATION_DEG)


def grid_resampler(camera: ViewCamera, size: tuple[int, int]) -> Resampler:
    """What brings pictures of (rows, columns) onto the directions of `grid`; made once, whichever thread asks first."""
    with _LOCK:
        return _grid_resampler(camera, size)


@lru_cache(maxsize=8)
def _grid_resampler(camera: ViewCamera, size: tuple[int, int]) -> Resampler:
    return resampler(camera.of_size(size), grid())
