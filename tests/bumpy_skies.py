"""Made-up views on the sphere that are known along every direction, and plain ways to compare them."""

from collections.abc import Callable

import numpy as np

from insectnav.vision import to_world
from insectnav.vision.sphere import SphereGrid, fibonacci

Function = Callable[[np.ndarray], np.ndarray]


def bumpy_sky(seed: int, n_bumps: int = 14, width_deg: float = 20.0) -> Function:
    """Brightness from 0 to 1 along directions (..., 3): smooth bumps, dark and bright, in random places."""
    rng = np.random.default_rng(seed)
    centres = rng.standard_normal((n_bumps, 3))
    centres /= np.linalg.norm(centres, axis=-1, keepdims=True)
    heights, sharpness = rng.choice([-1.5, 1.5], n_bumps), np.deg2rad(width_deg) ** -2

    def brightness(directions: np.ndarray) -> np.ndarray:
        total = np.exp((directions @ centres.T - 1.0) * sharpness) @ heights
        return 0.5 + 0.5 * np.tanh(total)

    return brightness


def seen_by(sky: Function, grid: SphereGrid, rotation: np.ndarray) -> np.ndarray:
    """What an eye that is turned by a rotation, world ← eye, sees of a sky on the directions of a grid."""
    return sky(to_world(grid.directions, rotation))


def cap(directions: np.ndarray, radius_deg: float = 90.0) -> np.ndarray:
    """Whether directions are no farther than that from straight up."""
    return directions[..., 2] >= np.cos(np.deg2rad(radius_deg)) - 1e-9


def cap_without_sector(directions: np.ndarray, start_deg: float, width_deg: float) -> np.ndarray:
    """Half of the sphere without a sector of azimuth, as a holder hides it."""
    azimuth = np.rad2deg(np.arctan2(directions[..., 0], directions[..., 1]))
    return cap(directions) & (np.mod(azimuth - start_deg, 360.0) > width_deg)


def plain_score(
    query: tuple[Function, Function],
    reference: tuple[Function, Function],
    rotation: np.ndarray,
    kind: str = "difference",
    n: int = 3000,
) -> float:
    """Score of two views (brightness, seen), each in its own frame, at a rotation reference ← query."""
    here = fibonacci(n).directions
    there = to_world(here, rotation)
    both = query[1](here) & reference[1](there)
    q, r = query[0](here[both]), reference[0](there[both])
    if kind == "difference":
        return float(1.0 - np.mean((q - r) ** 2))
    return float(np.corrcoef(q, r)[0, 1])
