"""Cameras: which pixel sees a direction, and where a pixel looks.

Pixels are given as (column, row), from the left upper corner of the picture: the pixel in column 0 and row 0 reaches
from 0 to 1 in both, and its centre is at (0.5, 0.5). OpenCV puts that centre at (0, 0): add 0.5 to its principal point.

A camera has a frame of its own, as an eye has: +y along its optical axis, +z towards the top of the picture, +x to the
right of it. Its mounting is the heading, pitch and roll of this frame in that of the eye (`sphere.rotation_matrix`). A
camera that looks up shows the animal's left on its right, as a map of the stars does; one that looks down into a mirror
does not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import wrap
from insectnav.checks import (
    InputError,
    as_numbers,
    check_choice,
    check_count,
    check_finite,
    check_radians,
    check_range,
    check_shape,
)
from insectnav.vision.camera_models import PROJECTIONS, Reals, check_increases
from insectnav.vision.sphere import (
    azimuth_elevation,
    check_directions,
    great_circle_angle,
    panorama_shape,
    rotation_matrix,
    to_eye,
    to_world,
)
from insectnav.vision.sphere import directions as directions_along

EQUIRECTANGULAR = "equirectangular"
MODELS = (*PROJECTIONS, EQUIRECTANGULAR)
LENSES = tuple(name for name, one in PROJECTIONS.items() if not (one.n_coefficients or one.is_mirrored))
AHEAD = (0.0, 0.0, 0.0)  # [rad] heading, pitch, roll
UPWARDS = (-np.pi, np.pi / 2, 0.0)  # the axis at the zenith, the top of the picture ahead
_ANGLE_SLACK, _PIXEL_SLACK = 1e-9, 1e-6  # [rad], [px] for what lies on the very edge

Bools = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A camera with a single viewpoint.

    Parameters
    ----------
    model : "equidistant", "equisolid", "stereographic", "orthographic", "pinhole", "kannala-brandt",
        "parabolic-mirror" or "equirectangular"
    size : (rows, columns) of the picture
    focal_length : (along columns, along rows) [px]; of the parabolic mirror the radius at which it shows 90° from its
        axis, of an equirectangular picture the pixels in a radian
    centre : (column, row) of the principal point [px]
    field : least and largest angle from the optical axis that is seen [rad]; an equirectangular picture has no other
        limit than its edges
    coefficients : k1 … k4 of the Kannala-Brandt model, none of the others
    mounting : heading, pitch and roll of the camera in the eye [rad]; the axis of a mirror points to the camera
    masked_sectors : (start, end) of sectors that show a holder or the like [rad], clockwise in the picture from its top
    """

    model: str
    size: tuple[int, int]
    focal_length: tuple[float, float]
    centre: tuple[float, float]
    field: tuple[float, float] = (0.0, np.pi / 2)
    coefficients: tuple[float, ...] = ()
    mounting: tuple[float, float, float] = AHEAD
    masked_sectors: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        check_choice("model", self.model, MODELS)
        for name, length in (("size", 2), ("focal_length", 2), ("centre", 2), ("field", 2), ("mounting", 3)):
            values = as_numbers(name, getattr(self, name))
            check_shape(name, values, (length,))
            check_finite(name, values)
        for count in self.size:
            check_count("size", count)
        check_range("focal_length", self.focal_length, 1e-6, np.inf, "px")
        check_radians("mounting", self.mounting)
        sectors = as_numbers("masked_sectors", self.masked_sectors or np.empty((0, 2)))
        check_shape("masked_sectors", sectors, ("n", 2))
        check_finite("masked_sectors", sectors)
        check_radians("masked_sectors", sectors)
        _check_optics(self)

    @property
    def rotation(self) -> Reals:
        """Rotation of the camera in the eye, eye ← camera, (3, 3)."""
        return rotation_matrix(*self.mounting)

    @property
    def wraps(self) -> bool:
        """Whether the right edge of the picture is also its left edge."""
        return self.model == EQUIRECTANGULAR and abs(2 * np.pi * self.focal_length[0] - self.size[1]) < 1e-6

    def project(self, directions: ArrayLike) -> tuple[Reals, Bools]:
        """Pixels that see directions, and whether they are seen at all.

        Parameters
        ----------
        directions : (..., 3) array of unit vectors in the frame of the eye

        Returns
        -------
        pixels : (..., 2) array of column, row [px]; NaN where the direction is not seen
        seen : (...) array of bool: in the field, in the picture and in no masked sector

        Raises
        ------
        InputError
            If directions are not unit vectors (..., 3).
        """
        vectors = np.asarray(check_directions("directions", directions), dtype=np.float64)
        local = to_eye(vectors, self.rotation)
        if self.model == EQUIRECTANGULAR:
            azimuth, elevation = azimuth_elevation(local)
            offset, seen = np.stack([azimuth, -elevation], axis=-1), np.ones(azimuth.shape, dtype=bool)
        else:
            offset, seen = self._picture_offset(local)
        pixels = np.asarray(self.centre) + np.asarray(self.focal_length) * offset
        if self.wraps:  # what lies beyond the seam is on its other side
            pixels[..., 0] = np.mod(pixels[..., 0], self.size[1])
        seen &= self._is_in_picture(pixels) & ~self._is_masked(offset)
        return np.where(seen[..., None], pixels, np.nan), seen

    def look(self, pixels: ArrayLike) -> Reals:
        """Directions in which pixels look: the inverse of `project`.

        Parameters
        ----------
        pixels : (..., 2) array of column, row [px]

        Returns
        -------
        (..., 3) array of unit vectors in the frame of the eye; NaN outside the picture and outside the field. Masked
        sectors have their directions
        """
        places = as_numbers("pixels", pixels).astype(np.float64)
        check_shape("pixels", places, (..., 2))
        offset = (places - np.asarray(self.centre)) / np.asarray(self.focal_length)
        if self.wraps:
            offset[..., 0] = wrap(offset[..., 0])
        if self.model == EQUIRECTANGULAR:
            seen = (np.abs(offset[..., 0]) <= np.pi + _ANGLE_SLACK) & (
                np.abs(offset[..., 1]) <= np.pi / 2 + _ANGLE_SLACK
            )
            azimuth, elevation = np.where(seen, offset[..., 0], 0.0), np.where(seen, -offset[..., 1], 0.0)
            local = directions_along(azimuth, np.clip(elevation, -np.pi / 2, np.pi / 2))
        else:
            local, seen = self._local_direction(offset)
        seen = seen & self._is_in_picture(places)
        return np.where(seen[..., None], to_world(local, self.rotation), np.nan)

    def pixel_directions(self) -> Reals:
        """Directions of the centres of all pixels, (rows, columns, 3); NaN where a pixel shows none."""
        rows, columns = np.arange(self.size[0]) + 0.5, np.arange(self.size[1]) + 0.5
        return self.look(np.stack(np.meshgrid(columns, rows), axis=-1))

    def pixels_seen(self) -> Bools:
        """Whether each pixel, by its centre, shows a direction and is not masked, (rows, columns)."""
        vectors = self.pixel_directions()
        shown = np.isfinite(vectors[..., 0])
        seen = np.zeros(self.size, dtype=bool)
        seen[shown] = self.project(vectors[shown])[1]
        return seen

    def check_sees(self, direction: ArrayLike, name: str = "direction") -> None:
        """Refuse directions that the camera does not see; names the first.

        Raises
        ------
        InputError
            If a direction is out of the field, out of the picture or in a masked sector.
        """
        vectors = np.asarray(check_directions(name, direction), dtype=np.float64)
        missed = ~np.atleast_1d(self.project(vectors)[1])
        if not missed.any():
            return
        first = vectors.reshape(-1, 3)[np.argmax(np.ravel(missed))]
        azimuth, elevation = np.rad2deg(azimuth_elevation(first))
        away = np.rad2deg(great_circle_angle(first, self.rotation[:, 1]))
        least, most = (0.0, 180.0) if self.model == EQUIRECTANGULAR else np.rad2deg(self.field)
        raise InputError(
            f"{name} at azimuth {azimuth:.4g}°, elevation {elevation:.4g}° is {away:.4g}° from the axis of the "
            f"{self.model} camera, expected {least:.4g} to {most:.4g}° and an unmasked pixel: another mounting?"
        )

    def _picture_offset(self, local: Reals) -> tuple[Reals, Bools]:
        """Place in the picture from its centre [focal lengths], right and down, and whether it is in the field."""
        projection = PROJECTIONS[self.model]
        across = np.hypot(local[..., 0], local[..., 2])
        theta = np.arctan2(across, local[..., 1])
        seen = (theta >= self.field[0] - _ANGLE_SLACK) & (theta <= self.field[1] + _ANGLE_SLACK)
        inside = np.minimum(np.where(seen, theta, 0.0), self.field[1])
        scale = projection.radius(inside, self.coefficients) / np.where(across > 0.0, across, 1.0)
        side = -1.0 if projection.is_mirrored else 1.0
        return np.stack([side * local[..., 0] * scale, -local[..., 2] * scale], axis=-1), seen

    def _local_direction(self, offset: Reals) -> tuple[Reals, Bools]:
        """Direction in the camera's frame of a place in the picture, and whether it is in the field."""
        projection = PROJECTIONS[self.model]
        radius = np.hypot(offset[..., 0], offset[..., 1])
        theta = projection.angle(radius, self.coefficients, self.field[1])
        seen = (theta >= self.field[0] - _ANGLE_SLACK) & (theta <= self.field[1] + _ANGLE_SLACK)
        theta = np.where(seen, theta, 0.0)
        scale = np.sin(theta) / np.where(radius > 0.0, radius, 1.0)
        side = -1.0 if projection.is_mirrored else 1.0
        return np.stack([side * offset[..., 0] * scale, np.cos(theta), -offset[..., 1] * scale], axis=-1), seen

    def _is_in_picture(self, pixels: Reals) -> Bools:
        limit = np.array([self.size[1], self.size[0]]) + _PIXEL_SLACK
        return np.asarray(((pixels >= -_PIXEL_SLACK) & (pixels <= limit)).all(axis=-1))

    def _is_masked(self, offset: Reals) -> Bools:
        angle = np.arctan2(offset[..., 0], -offset[..., 1])
        masked: Bools = np.zeros(angle.shape, dtype=bool)
        for start, end in self.masked_sectors:
            np.logical_or(masked, np.mod(angle - start, 2 * np.pi) <= np.mod(end - start, 2 * np.pi), out=masked)
        return masked


def _check_optics(camera: Camera) -> None:
    """Refuse a field or coefficients that the model cannot have."""
    projection = PROJECTIONS.get(camera.model)
    limit = np.pi
    if projection is not None:
        limit = projection.max_angle if projection.includes_max else projection.max_angle - 1e-6
    check_range("field", camera.field, 0.0, limit, "rad from the axis", f"degrees, or too wide for {camera.model}?")
    if not camera.field[0] < camera.field[1]:
        raise InputError(
            f"field goes from {camera.field[0]:g} to {camera.field[1]:g} rad, expected the least angle first"
        )
    n_coefficients = 0 if projection is None else projection.n_coefficients
    if len(camera.coefficients) > n_coefficients:
        raise InputError(
            f"coefficients has {len(camera.coefficients)} values, expected at most {n_coefficients} for {camera.model}"
        )
    check_finite("coefficients", camera.coefficients or (0.0,))
    if camera.coefficients:
        check_increases(camera.coefficients, camera.field[1])


def fisheye(
    size: tuple[int, int],
    field_of_view: float,
    *,
    model: str = "equidistant",
    radius: float | None = None,
    mounting: tuple[float, float, float] = UPWARDS,
) -> Camera:
    """Fisheye camera whose round picture lies in the middle of the image.

    Parameters
    ----------
    size : (rows, columns)
    field_of_view : [rad] from rim to rim
    model : "equidistant", "equisolid", "stereographic", "orthographic" or "pinhole"
    radius : [px] of the round picture; None if it touches the nearer edges
    mounting : heading, pitch, roll [rad]; by default it looks up, with the top of the picture ahead
    """
    check_choice(
        "model", model, [name for name, one in PROJECTIONS.items() if not (one.n_coefficients or one.is_mirrored)]
    )
    check_range("field_of_view", field_of_view, 1e-6, 2 * np.pi, "rad", "degrees?")
    rim = min(size) / 2 if radius is None else radius
    most = PROJECTIONS[model].max_angle
    check_range("field_of_view", field_of_view / 2, 0.0, most, "rad on each side", f"too wide for {model}?")
    focal = float(rim / PROJECTIONS[model].radius(np.asarray(field_of_view / 2), ()))
    return Camera(
        model=model,
        size=size,
        focal_length=(focal, focal),
        centre=(size[1] / 2, size[0] / 2),
        field=(0.0, field_of_view / 2),
        mounting=mounting,
    )


def parabolic_mirror(
    size: tuple[int, int],
    radius: float,
    *,
    field: tuple[float, float] = (0.0, np.pi / 2),
    centre: tuple[float, float] | None = None,
    mounting: tuple[float, float, float] = UPWARDS,
    masked_sectors: tuple[tuple[float, float], ...] = (),
) -> Camera:
    """Camera that looks down into a paraboloid mirror, which shows the horizon all round.

    Parameters
    ----------
    size : (rows, columns)
    radius : [px] at which the mirror shows directions 90° from its axis
    field : least and largest angle from the axis [rad]; the least leaves out the reflection of the camera itself
    centre : (column, row) of the axis [px]; None for the middle of the image
    mounting : heading, pitch and roll of the mirror [rad], its axis towards the camera
    masked_sectors : (start, end) [rad], clockwise in the picture from its top
    """
    return Camera(
        model="parabolic-mirror",
        size=size,
        focal_length=(radius, radius),
        centre=(size[1] / 2, size[0] / 2) if centre is None else centre,
        field=field,
        mounting=mounting,
        masked_sectors=masked_sectors,
    )


def panorama(resolution_deg: float = 1.0, elevation_deg: tuple[float, float] = (-15.0, 90.0)) -> Camera:
    """Camera whose pixels are those of `sphere.equirectangular`, and so of a rendered panorama.

    Parameters
    ----------
    resolution_deg : width and height of a pixel
    elevation_deg : lowest and highest elevation
    """
    rows, columns = panorama_shape(resolution_deg, elevation_deg)
    focal = columns / (2 * np.pi)
    return Camera(
        model=EQUIRECTANGULAR,
        size=(rows, columns),
        focal_length=(focal, focal),
        centre=(columns / 2, elevation_deg[1] / resolution_deg),
        field=(0.0, np.pi),
    )
