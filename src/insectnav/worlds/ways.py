"""Ways: lines of way points on the ground."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats


def distance_to_way(positions: npt.ArrayLike, way: npt.ArrayLike) -> Floats:
    """Least distance from each position (..., 2) to a line of way points (n, 2), (...) array [m]."""
    positions, way = np.asarray(positions, dtype=np.float64), np.asarray(way, dtype=np.float64)
    starts = way[:-1] if len(way) > 1 else way
    legs = np.diff(way, axis=0) if len(way) > 1 else np.zeros_like(way)
    squared = np.maximum(legs[:, 0] ** 2 + legs[:, 1] ** 2, 1e-300)
    off = positions[..., None, :] - starts
    share = np.clip((off[..., 0] * legs[:, 0] + off[..., 1] * legs[:, 1]) / squared, 0.0, 1.0)
    dx, dy = off[..., 0] - share * legs[:, 0], off[..., 1] - share * legs[:, 1]
    return np.sqrt((dx**2 + dy**2).min(axis=-1))


def stepped(corners: Floats, step: float) -> Floats:
    """Way points about a step apart along straight legs between corners (n, 2), corners included."""
    legs = []
    for start, end in pairwise(corners):
        length = float(np.sqrt(((end - start) ** 2).sum()))
        share = np.arange(max(1, round(length / step))) / max(1, round(length / step))
        legs.append(start + share[:, None] * (end - start))
    return np.concatenate([*legs, corners[-1:]])
