"""Where up is in a picture, and which of its pixels count.

Brightness does not say which side of a threshold is sky: overcast sky is darker than snow below it. The geometry does:
sky is above. Each pixel has an elevation level, from 0 for the lowest up to `N_LEVELS` - 1, and `LEFT_OUT` where it
shows nothing: outside a round picture, in a masked sector, in the vignette of a lens hood.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_range
from insectnav.vision.cameras import Camera
from insectnav.vision.sky_levels import LEFT_OUT
from insectnav.vision.sky_thresholds import N_LEVELS
from insectnav.vision.sphere import azimuth_elevation

Bools = NDArray[np.bool_]
Levels = NDArray[np.uint8]

VIEWS = ("ahead", "up")
MIN_PIXELS = 16  # that count; fewer have no histogram


@dataclass(frozen=True, kw_only=True, eq=False)
class Geometry:
    """What a picture's pixels look at.

    Parameters
    ----------
    levels : (rows, columns) array of elevation levels, `LEFT_OUT` where a pixel does not count
    looks_up : whether the zenith lies within the picture, so that all of its rim is lower
    """

    levels: Levels
    looks_up: bool

    @property
    def valid(self) -> Bools:
        """Whether each pixel counts, (rows, columns)."""
        return np.asarray(self.levels != LEFT_OUT)

    def without(self, left_out: Bools) -> "Geometry":
        """The same with more pixels left out."""
        return Geometry(levels=np.where(left_out, np.uint8(LEFT_OUT), self.levels), looks_up=self.looks_up)


def geometry(
    size: tuple[int, int],
    *,
    view: str = "ahead",
    radius: float | None = None,
    camera: Camera | None = None,
    valid: ArrayLike | None = None,
) -> Geometry:
    """Geometry of a picture.

    Parameters
    ----------
    size : (rows, columns)
    view : "ahead", the top of the picture is up; or "up", its middle is the zenith
    radius : of the round picture of a view up [px]; None if it touches the nearer edges
    camera : takes the place of `view`: elevations are those of its pixels, and what it does not see is left out
    valid : (rows, columns) array of bool, False where a pixel is to be left out

    Raises
    ------
    InputError
        If sizes differ, or hardly a pixel is left.
    """
    check_choice("view", view, VIEWS)
    if radius is not None:
        if view != "up" or camera is not None:
            raise InputError("radius is given, expected it for a view up without a camera alone")
        check_range("radius", radius, 1.0, np.inf, "px")
    if camera is None:
        found = _levels_of_view(size, view, radius), view == "up"
    else:
        if tuple(camera.size) != size:
            raise InputError(
                f"the image has {size[0]} × {size[1]} pixels, expected the {camera.size[0]} × {camera.size[1]} of the "
                "camera: another camera, or a reduced picture?"
            )
        found = _levels_of_camera(camera)
    all_of_it = Geometry(levels=found[0], looks_up=found[1])
    if valid is not None:
        all_of_it = all_of_it.without(~checked_mask("valid", valid, size))
    n_valid = int(np.count_nonzero(all_of_it.valid))
    if n_valid < MIN_PIXELS:
        raise InputError(
            f"{n_valid} pixels of the image count, expected at least {MIN_PIXELS}: a mask that is inverted?"
        )
    return all_of_it


def checked_mask(name: str, mask: ArrayLike, size: tuple[int, int]) -> Bools:
    """A mask of the size of the picture, as bool.

    Raises
    ------
    InputError
        If it has another size, or holds neither bool nor two whole numbers one of which is 0.
    """
    array = np.asarray(mask)
    if array.shape != size:
        raise InputError(f"{name} has shape {array.shape}, expected {size} as the image has: another picture's mask?")
    if array.dtype.kind != "b":
        values = np.unique(as_numbers(name, array))
        if not (len(values) <= 2 and (0 in values or len(values) == 1)):
            raise InputError(f"{name} holds {len(values)} different values, expected True and False, or 0 and another")
    return array.astype(bool)


@lru_cache(maxsize=8)
def _levels_of_view(size: tuple[int, int], view: str, radius: float | None) -> Levels:
    rows, columns = size
    if view == "ahead":
        level = (N_LEVELS * (rows - 1 - np.arange(rows)) // rows).astype(np.uint8)
        return _read_only(np.repeat(level[:, None], columns, axis=1))
    rim = min(rows, columns) / 2.0 if radius is None else radius
    down, right = np.arange(rows) + 0.5 - rows / 2.0, np.arange(columns) + 0.5 - columns / 2.0
    away = np.hypot(down[:, None], right) / rim
    return _read_only(_as_levels(1.0 - away, away <= 1.0))


@lru_cache(maxsize=8)
def _levels_of_camera(camera: Camera) -> tuple[Levels, bool]:
    seen = camera.pixels_seen()
    elevation = np.zeros(camera.size)
    elevation[seen] = azimuth_elevation(camera.pixel_directions()[seen])[1]
    is_zenith_seen = bool(camera.project(np.array([0.0, 0.0, 1.0]))[1])
    return _read_only(_as_levels(elevation, seen)), is_zenith_seen and not camera.wraps


def _as_levels(height: NDArray[np.float64], counts: Bools) -> Levels:
    """Heights as levels from the lowest to the highest pixel that counts."""
    if not counts.any():
        return np.full(height.shape, LEFT_OUT, np.uint8)
    low, high = height[counts].min(), height[counts].max()
    level = np.minimum(N_LEVELS * (height - low) / max(high - low, 1e-12), N_LEVELS - 1)
    return np.where(counts, level, LEFT_OUT).astype(np.uint8)


def _read_only(levels: Levels) -> Levels:
    levels.setflags(write=False)
    return levels
