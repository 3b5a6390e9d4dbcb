"""Ways to cut out the sky: a method and the light in which it looks, as in Table I, and some beside them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.stone2014_sky_segmentation.photographs import Photograph
from insectnav.vision.sky_segmentation import segment

METHOD_NAMES = {"kmeans": "k-means", "gmm": "GMM", "watershed": "watershed", "otsu": "Otsu", "skylight": "skylight"}
LIGHT_NAMES = {"visible": "visible", "uv": "UV", "uv-green": "UV-G"}


@dataclass(frozen=True, kw_only=True)
class Way:
    """One way to label a photograph.

    Parameters
    ----------
    method : of `insectnav.vision.sky_segmentation.segment`
    light : "visible", "uv" or "uv-green"
    channels : as of `segment`
    """

    method: str
    light: str
    channels: str

    @property
    def name(self) -> str:
        """In words, as in published.csv."""
        space = {"lab-ab": " (CIELAB a, b)", "mean": " (mean of bands)" if self.light == "visible" else ""}
        return f"{METHOD_NAMES[self.method]}, {LIGHT_NAMES[self.light]}{space.get(self.channels, '')}"


def _way(method: str, light: str, channels: str | None = None) -> Way:
    return Way(
        method=method,
        light=light,
        channels=channels or {"visible": "rgb", "uv": "mean", "uv-green": "uv-green"}[light],
    )


IN_TABLE = (  # in the order of Table I
    *(_way(method, light) for method in ("kmeans", "gmm") for light in ("visible", "uv", "uv-green")),
    _way("watershed", "uv"),
)
BESIDE = (
    _way("watershed", "visible", "mean"),
    _way("otsu", "uv"),
    _way("otsu", "visible", "mean"),
    _way("kmeans", "visible", "lab-ab"),
    _way("gmm", "visible", "lab-ab"),
    _way("skylight", "visible"),
)
WAYS = (*IN_TABLE, *BESIDE)


def sky_mask(photograph: Photograph, way: Way, seed: int) -> NDArray[np.bool_]:
    """Where that way sees sky, (rows, columns)."""
    images = {"visible": photograph.visible, "uv": photograph.uv, "uv-green": photograph.uv_green}
    return segment(images[way.light], way.method, channels=way.channels, seed=seed).mask
