"""What a descriptor is: a named way of turning views into vectors that are compared by their distance."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, kw_only=True)
class Descriptor:
    """Features (..., feature) of views (..., rows, columns); call it with the views."""

    name: str
    describe: Callable[[ArrayLike], NDArray[Any]]
    is_heading_free: bool  # whether turning the eye leaves the features
    source: str
    metric: str = "euclidean"  # by which its features are compared, of `insectnav.matching.METRICS`

    def __call__(self, views: ArrayLike) -> NDArray[np.floating[Any]]:
        """Features (..., feature) of the views, as floats; ``describe`` gives bits and bytes as such."""
        features = self.describe(views)
        return features if features.dtype.kind == "f" else features.astype(np.float32)
