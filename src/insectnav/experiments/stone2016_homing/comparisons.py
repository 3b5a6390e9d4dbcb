"""What views are compared by: names, words and colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.angles import FULL_TURN, unit_vector
from insectnav.vision.descriptors import (
    DESCRIPTORS,
    harmonic_coefficients,
    harmonic_pairs,
)
from insectnav.vision.descriptors.brightness import brightness
from insectnav.worlds.world import SKY

Reals = NDArray[np.floating[Any]]
ROWS_ABOVE = 90  # of views from −15° to 90° at 1°: those above the horizon


def landmark_vectors(views: ArrayLike) -> Reals:
    """Average landmark vectors (..., 2) of views that all face north: above the horizon, what is darker than the sky.

    As `insectnav.homing.average_landmark_vector` (Lambrinos et al. 2000), but each pixel weighs as much as it is darker
    than the sky: a yes or no for pixels of 1° would jump from place to place.
    """
    darkness = (SKY - brightness(views)[..., :ROWS_ABOVE, :]).sum(axis=-2, dtype=float)
    columns = darkness.shape[-1]
    towards = unit_vector((np.arange(columns) + 0.5) * FULL_TURN / columns - np.pi)
    return np.asarray(darkness @ towards / darkness.sum(axis=-1, keepdims=True))


def order_amplitudes(views: ArrayLike, n_degrees: int = 17) -> Reals:
    """Amplitude of each degree l and order |m| of spherical harmonics, (..., pair): the same for all headings.

    As of Zernike functions, and unlike amplitudes of whole degrees, tilts change them.
    """
    coefficients = harmonic_coefficients(views, n_degrees)
    degree, order = harmonic_pairs(n_degrees)
    positive = order >= 0
    mirrored = degree[positive] ** 2 + degree[positive] - order[positive]  # where −m stands
    first, second = coefficients[..., positive], coefficients[..., mirrored]
    return np.asarray(np.where(order[positive] == 0, np.abs(first), np.hypot(first, second)))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A way to compare views.

    Parameters
    ----------
    label : str
        As a figure has it.
    by : "aligned", "compass" or a function
        As of `insectnav.homing.distance_from`.
    colour : str
        Of `insectnav.experiments.figures.COLOURS`.
    """

    label: str
    by: Any
    colour: str


COMPARISONS: Mapping[str, Comparison] = {
    "retinotopic": Comparison(label="retinotopic", by="aligned", colour="orange"),
    "zernike": Comparison(label="Zernike, n ≤ 16", by=DESCRIPTORS["zernike"], colour="blue"),
    "zernike-orthonormal": Comparison(
        label="Zernike, n ≤ 40,\northonormal", by=DESCRIPTORS["zernike-orthonormal"], colour="sky"
    ),
    "harmonic-orders": Comparison(label="harmonics, l, |m|,\nl ≤ 16", by=order_amplitudes, colour="green"),
    "spherical-harmonics": Comparison(
        label="harmonics, l < 60", by=DESCRIPTORS["spherical-harmonics"], colour="yellow"
    ),
    "frequency-strip": Comparison(label="horizon strip", by=DESCRIPTORS["frequency-strip"], colour="purple"),
    "compass": Comparison(label="best over all turns", by="compass", colour="red"),
    "landmark-vector": Comparison(label="landmark vector", by=landmark_vectors, colour="grey"),
}
THESIS = ("retinotopic", "zernike")  # the two of section 4.3


def measures_by(names: tuple[str, ...]) -> dict[str, Any]:
    """What `surfaces` takes, of comparisons by their names."""
    return {name: COMPARISONS[name].by for name in names}
