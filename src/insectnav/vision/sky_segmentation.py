"""Sky and ground: a mask of the sky in a picture, by one of several methods, and how far it is to be trusted.

Stone, Mangan, Ardin & Webb (2014), RSS, doi 10.15607/RSS.2014.X.047, cut the sky out of ultraviolet pictures by a
threshold in the valley of their histogram, or by clusters; Stone, Differt, Milford & Webb (2016), ICRA, by Otsu's
threshold. `skylight` is ours, for ordinary photographs. All give each pixel a score and a threshold for it, and the
geometry of the picture decides which side of the threshold is sky.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_choice, check_count, check_finite
from insectnav.vision.cameras import Camera
from insectnav.vision.sky_channels import (
    ONE_CHANNEL,
    Picture,
    channel_name,
    checked_picture,
    features,
    full_scale,
    one_channel,
)
from insectnav.vision.sky_clusters import kmeans_score, mixture_score
from insectnav.vision.sky_confidence import chance_of_being_higher, confidence
from insectnav.vision.sky_geometry import MIN_PIXELS, Bools, Geometry, geometry
from insectnav.vision.sky_thresholds import Histogram, histogram, otsu, watershed_islands, watershed_merge
from insectnav.vision.skylight import SkylightParams, skylight

Thresholder = Callable[[Histogram], "float | None"]
Clusterer = Callable[[NDArray[np.float32], int], tuple[NDArray[np.float32], float]]
THRESHOLDS: dict[str, Thresholder] = {
    "otsu": otsu,
    "watershed": watershed_merge,
    "watershed-islands": watershed_islands,
}
CLUSTERS: dict[str, Clusterer] = {"kmeans": kmeans_score, "gmm": mixture_score}
METHODS = (*THRESHOLDS, *CLUSTERS, "fixed", "skylight")
FLARE_SHARE = 0.98  # of the brightest value, from which on a pixel is flare; assumed
FLARE_MARGIN = 0.02  # of the shorter side by which flare is widened; assumed


@dataclass(frozen=True, kw_only=True, eq=False)
class SkyMask:
    """Which pixels of a picture are sky.

    Parameters
    ----------
    mask : (rows, columns) array of bool, True for sky; False where a pixel is left out
    threshold : of the channel, in the unit of the picture; of k-means the place between the centres along the line
        through them, of a mixture the probability 1/2, of skylight its score
    confidence : from 0, the mask may be noise, to 1; see `insectnav.vision.sky_confidence`
    valid : (rows, columns) array of bool, False where a pixel was left out
    method, channels : what was used
    is_sky_brighter : whether sky is above the threshold
    notes : what the user must be told
    """

    mask: Bools
    threshold: float
    confidence: float
    valid: Bools
    method: str
    channels: str
    is_sky_brighter: bool = True
    notes: tuple[str, ...] = ()

    @property
    def sky_fraction(self) -> float:
        """Share of sky among the pixels that count."""
        return float(np.count_nonzero(self.mask) / np.count_nonzero(self.valid))


def segment(
    image: ArrayLike,
    method: str = "watershed",
    *,
    channels: str | None = None,
    view: str = "ahead",
    radius: float | None = None,
    camera: Camera | None = None,
    valid: ArrayLike | None = None,
    threshold: float | None = None,
    leave_out_flare: bool = False,
    seed: int = 0,
    params: SkylightParams | None = None,
) -> SkyMask:
    """Mask of the sky in one picture.

    Parameters
    ----------
    image : (rows, columns) or (rows, columns, band) array of uint8, uint16 or any real type; bands are red, green,
        blue, or UV and green
    method : "otsu", "watershed" (merge) or "watershed-islands" on one channel; "kmeans" or "gmm" on one or more;
        "fixed", a `threshold` that is known or trained (`insectnav.vision.sky_training`); or "skylight", for
        photographs in colour
    channels : "mean" of all bands, "grey", "red", "green", "blue"; "rgb", "lab-ab" or "uv-green" for kmeans and gmm.
        None takes the mean where a method needs one channel, all bands where it does not
    view : "ahead", the top of the picture is up; "up", its middle is
    radius : of the round picture in a view up [px]; None if it touches the nearer edges
    camera : instead of `view`; its masked sectors and what it does not see are left out
    valid : (rows, columns) array of bool, False for pixels to be left out
    threshold : of "fixed", in the unit of the picture
    leave_out_flare : leave out pixels as bright as the brightest, and a margin about them
    seed : of kmeans and gmm
    params : of skylight; None for those of the view, `skylight.AHEAD` or `skylight.UP`

    Raises
    ------
    InputError
        If it is no picture, a choice is unknown, or all pixels that count have one value.

    Notes
    -----
    Sky is the class whose pixels lie higher in the mean of all pairs; "fixed" and "skylight" take the brighter one.
    What the confidence is made of: `insectnav.vision.sky_confidence`.
    """
    check_choice("method", method, METHODS)
    if (threshold is None) == (method == "fixed"):
        raise InputError("threshold is missing for method fixed" if threshold is None else
                         f"threshold is given, expected it with method fixed alone, not {method}")  # fmt: skip
    picture = checked_picture(image)
    chosen = channel_name(picture, channels, one=method in THRESHOLDS or method == "fixed")
    where = geometry(picture.shape[:2], view=view, radius=radius, camera=camera, valid=valid)
    if leave_out_flare:
        where = _without_flare(picture, where)
    if method == "skylight":
        return _by_skylight(picture, chosen, where, params)
    if method in CLUSTERS:
        return _by_clusters(picture, method, chosen, where, seed)
    return _by_threshold(picture, method, chosen, where, threshold)


def _by_threshold(picture: Picture, method: str, channels: str, where: Geometry, threshold: float | None) -> SkyMask:
    values = one_channel(picture, channels)
    notes: tuple[str, ...] = ()
    if threshold is not None:
        check_finite("threshold", threshold)
        found, is_brighter = float(threshold), True
    else:
        counts = _histogram_or_refuse(values, where, zoom=method.startswith("watershed"))
        valley = THRESHOLDS[method](counts)
        if valley is None:
            notes = ("the histogram has no two peaks; Otsu's threshold took the place of a valley",)
        found = otsu(counts) if valley is None else valley
        is_brighter = _is_sky_brighter(counts, found)
    mask = _divided(values, found, is_brighter, where)
    return SkyMask(
        mask=mask,
        threshold=found,
        confidence=0.0 if notes else confidence(values, mask, where.levels).total,
        valid=where.valid,
        method=method,
        channels=channels,
        is_sky_brighter=is_brighter,
        notes=notes,
    )


def _by_clusters(picture: Picture, method: str, channels: str, where: Geometry, seed: int) -> SkyMask:
    check_count("seed", seed, minimum=0)
    space = features(picture, channels)
    points = space[where.valid]
    if (points == points[0]).all():
        raise _one_value(float(points[0, 0]))
    of_points, threshold = CLUSTERS[method](points, seed)
    score = np.zeros(where.levels.shape, np.float32)
    score[where.valid] = of_points
    counts = histogram(score, where.levels)
    if counts is None:
        raise InputError(f"{method} finds one cluster alone, expected sky and ground: a covered lens?")
    is_brighter = _is_sky_brighter(counts, threshold)
    mask = _divided(score, threshold, is_brighter, where)
    return SkyMask(
        mask=mask,
        threshold=threshold * full_scale(picture) if method == "kmeans" and channels in ONE_CHANNEL else threshold,
        confidence=confidence(one_channel(picture, "mean"), mask, where.levels).total,
        valid=where.valid,
        method=method,
        channels=channels,
        is_sky_brighter=is_brighter,
    )


def _by_skylight(picture: Picture, channels: str, where: Geometry, params: SkylightParams | None) -> SkyMask:
    if channels in ("lab-ab", "uv-green"):
        raise InputError(f"skylight takes rgb or one channel, but channels are {channels}")
    chosen = picture if channels == "rgb" else one_channel(picture, channels)
    result = skylight(chosen, where, params)
    if result is None:
        raise _one_value(float(one_channel(chosen, "mean")[where.valid][0]))
    return SkyMask(
        mask=result.mask,
        threshold=result.threshold,
        confidence=confidence(result.brightness, result.reduced_mask, result.levels).total,
        valid=where.valid,
        method="skylight",
        channels=channels,
    )


def _is_sky_brighter(counts: Histogram, threshold: float) -> bool:
    """Whether the class above the threshold is the one that lies higher in the picture."""
    centres = counts.edge(0.5) + np.arange(counts.counts.shape[1]) * counts.width
    above = counts.counts[:, centres > threshold].sum(axis=1)
    below = counts.counts.sum(axis=1) - above
    return bool(chance_of_being_higher(above, below) >= 0.5)


def _divided(values: NDArray[Any], threshold: float, is_sky_brighter: bool, where: Geometry) -> Bools:
    from insectnav.vision.sky_histogram_kernel import split

    mask = np.empty(values.size, np.bool_)
    split(np.ravel(values), np.ravel(where.levels), np.float32(threshold), is_sky_brighter, mask)
    return mask.reshape(values.shape)


def _histogram_or_refuse(values: NDArray[Any], where: Geometry, zoom: bool) -> Histogram:
    counts = histogram(values, where.levels, zoom=zoom)
    if counts is None:
        raise _one_value(float(values[where.valid][0]))
    return counts


def _one_value(value: float) -> InputError:
    return InputError(
        f"all pixels of the image that count have the value {value:g}, expected sky and ground: a covered lens, or an "
        "exposure beyond the range?"
    )


def _without_flare(picture: Picture, where: Geometry) -> Geometry:
    """The geometry without pixels as bright as the brightest, and without those about them, which it outshines."""
    import cv2

    values = one_channel(picture, "mean").astype(np.float32)
    flare = (values >= FLARE_SHARE * values[where.valid].max()) & where.valid
    reach = 2 * max(1, round(FLARE_MARGIN * min(flare.shape))) + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    widened = cv2.dilate(flare.view(np.uint8), kernel).astype(bool)
    if np.count_nonzero(where.valid & ~widened) < MIN_PIXELS:
        raise InputError("flare covers the whole image, expected some of it to be less bright: an overexposed picture?")
    return where.without(widened)
