"""What SeqSLAM is given of each frame of a walk, and by what measure frames are compared."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.stone2014_places.mirror import mirror_pixels, unwrapped
from insectnav.experiments.stone2014_places.route_pairs import Pair, Run, run_pair
from insectnav.experiments.stone2014_places.walk_frames import GREY_SIZE, grey_of, reduced
from insectnav.experiments.stone2014_places.walks import Walk
from insectnav.matching import OPENSEQSLAM_V1, SeqSlamParams
from insectnav.vision.descriptors import NOTHING, patch_normalised

SMOOTHED = 3  # frames whose majority is taken, the last of them the present one
UNWRAPPED_DEG = 1.0  # [°] of the panorama in which the sky of the mirror is unwrapped
WHITE = 255.0  # what stands for the sky where it is masked out
PATCH = 8  # [px] OpenSeqSLAM; 2 × 2 patches in 16 × 16 pixels


@dataclass(frozen=True, kw_only=True)
class Way:
    """Features of frames, the metric for them and the search.

    Parameters
    ----------
    name : as tables have it
    features : of a walk, (frame, feature)
    metric : of `insectnav.matching.METRICS`
    params : of SeqSLAM
    turned : the same features if the rig were turned by 180° on its pole; None where they would not change
    """

    name: str
    features: Callable[[Walk], NDArray[Any]]
    metric: str
    params: SeqSlamParams = OPENSEQSLAM_V1
    turned: Callable[[Walk], NDArray[Any]] | None = None

    def runs(self, walks: Mapping[str, Walk], pairs: list[Pair], *, is_turned: bool = False) -> list[Run]:
        """SeqSLAM on all pairs; `is_turned` turns the rig on its pole for the queries."""
        features = {day: self.features(walk) for day, walk in walks.items()}
        of_queries = None
        if is_turned and self.turned is not None:
            of_queries = {day: self.turned(walk) for day, walk in walks.items()}
        return [run_pair(walks, features, self.metric, pair, self.params, of_queries) for pair in pairs]


def _smoothed_skies(walk: Walk) -> NDArray[np.bool_]:
    """Majority of each bit of the sky over the last frames."""
    skies = walk.binary_skies().astype(np.int8)
    padded = np.concatenate([np.repeat(skies[:1], SMOOTHED - 1, axis=0), skies])
    votes = sum(padded[k : k + len(skies)] for k in range(SMOOTHED))
    return np.asarray(2 * votes > SMOOTHED)


def _patches(grey: NDArray[np.uint8]) -> NDArray[Any]:
    return patch_normalised(grey, size=None, patch_px=PATCH, rounded=True, flat_patch=NOTHING)


@lru_cache(maxsize=4)
def _grey_below(walk: Walk) -> NDArray[np.uint8]:
    """Unwrapped grey of 16 × 16 pixels with the sky, as the ultraviolet camera has it, in one white."""
    rows, columns = walk["colours"].shape[1:3]
    pixels = mirror_pixels(walk.mirror_size, UNWRAPPED_DEG)
    below = []
    for frame, colours in enumerate(walk["colours"]):
        sky = unwrapped(walk.mirror_sky(frame), pixels).astype(np.float32)
        share = reduced(sky, (rows, columns))
        below.append(reduced(grey_of(colours) * (1.0 - share) + WHITE * share, (GREY_SIZE, GREY_SIZE)))
    return np.rint(below).astype(np.uint8)


def _kept(name: str) -> Callable[[Walk], NDArray[Any]]:
    def features(walk: Walk) -> NDArray[Any]:
        return walk[name]

    return features


def _half_turned(pictures: NDArray[Any]) -> NDArray[Any]:
    return np.ascontiguousarray(pictures[:, ::-1, ::-1])


def _turned_skies(walk: Walk) -> NDArray[Any]:
    skies = walk.binary_skies()
    side = int(np.sqrt(skies.shape[1]))
    return _half_turned(skies.reshape(-1, side, side)).reshape(len(skies), -1)


UV = Way(name="UV, binary sky", features=Walk.binary_skies, metric="hamming", turned=_turned_skies)
VISIBLE = Way(
    name="visible, grey",
    features=lambda walk: _patches(walk["grey"]),
    metric="openseqslam-v1",
    turned=lambda walk: _patches(_half_turned(walk["grey"])),
)
AS_PUBLISHED = (UV, VISIBLE)
MAJORITY = Way(name="UV, majority of three frames", features=_smoothed_skies, metric="hamming")
MASKED = (
    Way(name="visible, sky masked out", features=lambda walk: _patches(_grey_below(walk)), metric="openseqslam-v1"),
    Way(
        name="visible, sky masked out, no patches",
        features=lambda walk: _grey_below(walk).reshape(len(walk), -1),
        metric="openseqslam-v1",
    ),
)
OTHERS = (
    MAJORITY,
    Way(name="UV, contrast from its bound", features=Walk.binary_skies, metric="hamming", params=SeqSlamParams()),
    Way(
        name="visible, contrast from its bound",
        features=lambda walk: _patches(walk["grey"]),
        metric="openseqslam-v1",
        params=SeqSlamParams(),
    ),
    Way(name="visible, unwrapped", features=lambda walk: _patches(walk["grey_unwrapped"]), metric="openseqslam-v1"),
    Way(
        name="visible, no patches",
        features=lambda walk: walk["grey"].reshape(len(walk), -1),
        metric="openseqslam-v1",
    ),
    *MASKED,
)
CONTOUR = Way(name="UV, Fourier contour", features=_kept("contour"), metric="euclidean")
ZERNIKE = Way(name="UV, Zernike", features=_kept("zernike"), metric="euclidean")
DESCRIPTORS = (
    UV,
    CONTOUR,
    ZERNIKE,
    Way(name="UV, spherical harmonics", features=_kept("harmonics"), metric="euclidean"),
    VISIBLE,
)
