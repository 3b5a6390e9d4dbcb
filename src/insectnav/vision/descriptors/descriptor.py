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
    describe: Callable[[ArrayLike], NDArray[np.floating[Any]]]
    is_heading_free: bool  # whether turning the eye leaves the features
    source: str

    def __call__(self, views: ArrayLike) -> NDArray[np.floating[Any]]:
        """Features (..., feature) of the views."""
        return self.describe(views)
