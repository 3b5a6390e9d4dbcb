"""Pictures of a route as features: grey or the sky, as the camera took it or on the sphere, by a named descriptor."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_choice, quoted
from insectnav.experiments.place_maps.view_cameras import (
    AHEAD,
    GRID_DEG,
    GRID_ELEVATION_DEG,
    ViewCamera,
    grid,
    grid_resampler,
)
from insectnav.vision.descriptors import DESCRIPTORS
from insectnav.vision.descriptors.lanczos import resize
from insectnav.vision.sky_channels import CHANNELS
from insectnav.vision.sky_segmentation import METHODS, segment

Picture = NDArray[Any]
Features = NDArray[np.float32]

TURNED, ROTATED = "turned-views", "rotations"  # views that are compared after all turns, and after all rotations
COMPARED = {  # what stands for their source
    TURNED: "all turns on the spot: Zeil et al. 2003, doi 10.1364/JOSAA.20.000450",
    ROTATED: "all rotations, over what both saw: insectnav.matching.rotation",
}
NAMES = (*DESCRIPTORS, *COMPARED)
OF_PICTURES = ("patch-normalised", "patch-normalised-v1", "retinotopic")  # all others are of panoramas
OF_GREY = (*OF_PICTURES, "frequency-strip", TURNED)  # all others are of the sky
TURNED_COLUMNS = 120  # of 3°, as of the views that docs/place-recognition.md measures
SIZE, ROUND_SIZE = (32, 64), (64, 64)  # [pixel] to which pictures are brought: OpenSeqSLAM's, and a square for disks
VIEW_SIZE = "view_size"  # in the settings of a map
NO_SKY, MASK = "none", "mask"  # grey instead of the sky; pictures that are masks already
UNKNOWN = 128  # in a mask
SKY_METHODS = tuple(name for name in METHODS if name != "fixed")
SKY_OF_VECTORS = "--sky is given with features that are computed already, expected it with pictures"
LARGEST_FEATURES = 1_000_000  # of a vector from elsewhere


@dataclass(frozen=True, kw_only=True)
class DescribeParams:
    """How frames become features.

    Parameters
    ----------
    descriptor : one of `insectnav.vision.descriptors.DESCRIPTORS`, "turned-views" or "rotations"; of vectors from
        elsewhere any word
    camera : what took the pictures
    sky : None for what the descriptor is made for; "none" for grey; "mask" for pictures that are masks of the sky;
        else a method of `insectnav segment`, NAME or NAME:CHANNELS
    metric : of `insectnav.matching.METRICS`; None for the descriptor's own
    is_vectors : whether frames come as features already
    view_size : rows and columns of the views of "turned-views", of the pictures of "rotations"; None until `settled`

    Raises
    ------
    InputError
        If a name is unknown, or the camera does not see what the descriptor wants.
    """

    descriptor: str = "patch-normalised"
    camera: ViewCamera = AHEAD
    sky: str | None = None
    metric: str | None = None
    is_vectors: bool = False
    view_size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.is_vectors:
            if self.sky is not None:
                raise InputError(SKY_OF_VECTORS)
            return
        check_choice("descriptor", self.descriptor, NAMES)
        if self.metric not in (None, self.used_metric):
            raise InputError(
                f"--metric is {quoted(self.metric)}, expected {self.used_metric} with {self.descriptor}, or no "
                "--metric: it is for features of your own"
            )
        if self.sky not in (None, NO_SKY, MASK):
            method, colon, channels = str(self.sky).partition(":")
            check_choice("sky", method, (NO_SKY, MASK, *SKY_METHODS))
            if colon:
                check_choice("channels of the sky", channels, tuple(CHANNELS))
        if self.camera.kind == "ahead" and not self.is_of_pictures:
            raise InputError(
                f"descriptor {self.descriptor} wants the sky all round and --camera is ahead, expected --camera "
                f"panorama, fisheye or mirror, or one of {', '.join(OF_PICTURES)}"
            )

    @property
    def is_of_pictures(self) -> bool:
        """Whether it takes pictures as the camera gives them, not panoramas."""
        return self.descriptor in OF_PICTURES

    @property
    def is_of_sky(self) -> bool:
        """Whether masks of the sky are described, not grey."""
        return self.sky != NO_SKY and (self.sky is not None or self.descriptor not in OF_GREY)

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns to which pictures are brought."""
        return ROUND_SIZE if self.camera.is_round else SIZE

    @property
    def used_metric(self) -> str:
        """By which features are compared."""
        if self.is_vectors:
            return self.metric or "cosine"
        return "euclidean" if self.descriptor in COMPARED else DESCRIPTORS[self.descriptor].metric

    def settled(self, picture: Picture) -> DescribeParams:
        """The same with all that follows from the first picture: how the sky is cut out, as `insectnav segment` does.

        Parameters
        ----------
        picture : (rows, columns) or (rows, columns, 3) array, or a vector
        """
        if self.is_vectors:
            return self
        sky = (self.sky or ("skylight" if picture.ndim == 3 else "watershed")) if self.is_of_sky else NO_SKY
        return replace(self, sky=sky, view_size=self.view_size or self._size_of_views(picture.shape[:2]))

    def _size_of_views(self, size: tuple[int, ...]) -> tuple[int, int] | None:
        if self.descriptor == ROTATED:
            return size[0], size[1]
        if self.descriptor != TURNED:
            return None
        if self.camera.kind != "panorama":
            return round((GRID_ELEVATION_DEG[1] - GRID_ELEVATION_DEG[0]) * TURNED_COLUMNS / 360.0), TURNED_COLUMNS
        return max(1, round(size[0] * TURNED_COLUMNS / size[1])), TURNED_COLUMNS

    def settings(self) -> dict[str, str | float]:
        """All else that the features follow from, for the map to keep."""
        if self.is_vectors:
            return {}
        kept: dict[str, str | float] = {"sky": str(self.sky)}
        if self.is_of_pictures:
            return kept | {"size": "{}x{}".format(*self.size)}
        if self.view_size is not None:
            kept |= {VIEW_SIZE: "{}x{}".format(*self.view_size)}
        if self.descriptor == TURNED and self.camera.kind == "panorama":  # no matter which elevations it shows
            return kept
        return kept | {"pixel_deg": GRID_DEG, "elevation_deg": "{:g} to {:g}".format(*GRID_ELEVATION_DEG)}

    def in_words(self) -> list[tuple[str, str]]:
        """What is done and assumed, for a person: names and sentences."""
        if self.is_vectors:
            return [("Features", f"{self.descriptor}, computed elsewhere"), ("Compared by", self.used_metric)]
        if self.is_of_pictures:
            where = "of pictures brought to {} × {} pixels".format(*self.size)
            where += ", the middle square of each" if self.camera.is_round else ""
        elif self.descriptor == TURNED:
            where = "of panoramas of {} × {} pixels".format(*(self.view_size or SIZE))
        else:
            where = f"on panoramas of {GRID_DEG:g}° from {GRID_ELEVATION_DEG[0]:g}° to {GRID_ELEVATION_DEG[1]:g}°"
        sky = {NO_SKY: "grey", MASK: "masks of the sky, given as pictures"}.get(
            str(self.sky), f"masks of the sky, cut out by {self.sky}"
        )
        unseen = "; what the camera does not see counts as ground"
        if self.is_of_pictures or self.descriptor == ROTATED:
            unseen = "; what only one of two cameras sees does not count" if self.descriptor == ROTATED else ""
        source = COMPARED.get(self.descriptor) or DESCRIPTORS[self.descriptor].source
        return [
            ("Descriptor", f"{self.descriptor} {where} ({source})"),
            ("Described", sky + (unseen if self.is_of_sky else "")),
            ("Camera", self.camera.in_words),
            ("Compared by", "mean squared difference" if self.descriptor == ROTATED else self.used_metric),
        ]


def describe(picture: Picture, params: DescribeParams) -> Features:
    """Features of one frame, (feature,) float32.

    Parameters
    ----------
    picture : (rows, columns) or (rows, columns, 3) array of uint8, uint16 or float32; a vector (feature,) if
        `is_vectors`
    params : DescribeParams
        As `settled`.

    Raises
    ------
    InputError
        If the picture has no sky and ground, is no mask where one is expected, or features are not finite.
    """
    if params.is_vectors:
        return _checked_vector(picture)
    view = _sky(picture, params).astype(np.uint8) * np.uint8(255) if params.is_of_sky else grey(picture)
    if params.is_of_pictures:
        view = resize(_middle_square(view) if params.camera.is_round else view, params.size)
    elif params.descriptor == TURNED and params.camera.kind == "panorama":  # whatever elevations it shows
        return _as_shares(resize(view, params.view_size or SIZE)).ravel()
    else:
        view = _on_grid(view, params)
    if params.descriptor == TURNED:
        return np.asarray(resize(view, params.view_size or SIZE), np.float32).ravel()
    if params.descriptor == ROTATED:
        return np.asarray(view, np.float32).ravel()
    return np.asarray(DESCRIPTORS[params.descriptor](view), np.float32)


def _on_grid(view: Picture, params: DescribeParams) -> Features:
    """A picture on the directions of the grid, (rows, columns) from 0 to 1; 0 where it is not seen."""
    if params.descriptor == ROTATED and view.shape != params.view_size:
        expected = " × ".join(map(str, params.view_size or ()))
        raise InputError(f"it has {view.shape[0]} × {view.shape[1]} pixels, expected {expected} as all others")
    values = grid_resampler(params.camera, view.shape)(view, unseen=0.0) / _full_scale(view)
    return np.asarray(values.reshape(grid().shape or (1, -1)), np.float32)


def _as_shares(view: Picture) -> Features:
    return view.astype(np.float32) / _full_scale(view)


def _full_scale(view: Picture) -> np.float32:
    """The largest value of whole numbers; floating-point numbers are taken as they are."""
    return np.float32(np.iinfo(view.dtype).max if view.dtype.kind == "u" else 1.0)


def grey(picture: Picture) -> Picture:
    """Brightness of a picture, (rows, columns), of the type given; of colours 0.299 red, 0.587 green, 0.114 blue."""
    import cv2

    return picture if picture.ndim == 2 else np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))


def looks_like_mask(picture: Picture) -> bool:
    """Whether a picture has hardly another value than black and white."""
    values = np.unique(picture)
    return len(values) <= 3 and int(values[-1]) > 0 and not set(values.tolist()) - {0, UNKNOWN, int(values[-1])}


def _sky(picture: Picture, params: DescribeParams) -> NDArray[np.bool_]:
    """Which pixels are sky."""
    if params.sky == MASK:
        return _given_mask(picture)
    method, colon, channels = str(params.sky).partition(":")
    camera = None
    is_as_taken = params.is_of_pictures or params.descriptor == TURNED
    if params.camera.is_round or not is_as_taken:
        camera = params.camera.of_size(picture.shape[:2])
    return segment(picture, method, channels=channels if colon else None, camera=camera).mask


def _given_mask(picture: Picture) -> NDArray[np.bool_]:
    """A picture as a mask: white is sky; black, and the 128 of the unknown, is not."""
    if picture.ndim == 3:
        if not (picture == picture[..., :1]).all():
            raise InputError(
                "it is in colour, expected a mask of black and white with --sky mask: the photograph itself?"
            )
        picture = picture[..., 0]
    if picture.any() and not looks_like_mask(picture):
        raise InputError(
            f"it holds {len(np.unique(picture))} values, expected 0 and one for sky with --sky mask: a photograph, "
            "or a mask that was stored as JPEG or resized?"
        )
    return np.asarray((picture == picture.max()) & (picture > 0) & (picture != UNKNOWN))


def _middle_square(view: Picture) -> Picture:
    side = min(view.shape)
    row, column = (view.shape[0] - side) // 2, (view.shape[1] - side) // 2
    return np.ascontiguousarray(view[row : row + side, column : column + side])


def _checked_vector(vector: Picture) -> Features:
    if vector.ndim != 1 or not 0 < vector.size <= LARGEST_FEATURES:
        raise InputError(f"its features have shape {vector.shape}, expected (feature,) of at most {LARGEST_FEATURES}")
    with np.errstate(over="ignore"):
        features = vector.astype(np.float32)
    if not np.isfinite(features).all():
        raise InputError("its features are NaN, infinite or beyond 3e38, expected finite numbers")
    return features
