"""Hand-made masks of real skies from one walk, as views of a camera that is tilted, turned and, if asked, misjudged."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from insectnav.vision import fisheye, rotation_matrix, to_world
from insectnav.vision.sphere import equirectangular, fibonacci

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
CAMERA = fisheye((320, 320), np.pi)
GRID = equirectangular(1.0)
_RAYS = equirectangular(0.5)  # two by two in each direction of the grid
Move = Callable[[np.ndarray], np.ndarray]


def sky_masks() -> np.ndarray:
    """The masks, (65, 320, 320) of bool in the order of the walk; skips the test where they are missing."""
    from matplotlib.image import imread

    paths = sorted((DATA / "fisheye_sky").glob("*_mask.png"))
    if not paths:
        pytest.skip(f"{DATA / 'fisheye_sky'} is missing")
    masks = [imread(path) for path in paths]
    return np.array([mask if mask.ndim == 2 else mask[..., 0] for mask in masks]) > 0.5


def tilted_view(mask: np.ndarray, rotation: np.ndarray, move: Move | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Share of sky and whether it was seen, of each direction of `GRID`: a camera, first ← then, sees its hemisphere.

    What the first photograph did not see is ground. ``move`` displaces directions of the first camera.
    """
    own = CAMERA.project(_RAYS.directions)[1]
    directions = to_world(_RAYS.directions, rotation)
    place, seen = CAMERA.project(directions if move is None else move(directions))
    column, row = (np.where(seen, np.clip(axis, 0, 319), 0).astype(int) for axis in place.T)
    share = _means(own)
    return _means(mask[row, column] & seen & own) / np.maximum(share, 1e-9), share >= 0.5


def _means(rays: np.ndarray) -> np.ndarray:
    return rays.reshape(180, 2, 360, 2).mean(axis=(1, 3)).ravel()


def random_rotation(rng: np.random.Generator, tilt: float) -> np.ndarray:
    """A tilt by that angle [rad] towards any azimuth, of a camera that is turned by any angle."""
    turn, towards = rng.uniform(-np.pi, np.pi, 2)
    aside = rotation_matrix(towards)
    return aside @ rotation_matrix(0.0, -tilt) @ aside.T @ rotation_matrix(turn)


def skyline_jitter(rng: np.random.Generator, sigma: float, correlation: float) -> Move:
    """Displacement in elevation by a smooth random field of that standard deviation and correlation length [rad]."""
    from scipy.ndimage import map_coordinates

    coarse = equirectangular(3.0)
    centres = fibonacci(int(10.0 / correlation**2)).directions
    field = np.exp((coarse.directions @ centres.T - 1.0) / correlation**2) @ rng.standard_normal(len(centres))
    field *= sigma / np.sqrt(np.average(field**2, weights=coarse.weights))
    padded = np.pad(field.reshape(60, 120), ((0, 0), (1, 1)), mode="wrap")

    def move(directions: np.ndarray) -> np.ndarray:
        azimuth = np.arctan2(directions[:, 0], directions[:, 1])
        elevation = np.arcsin(np.clip(directions[:, 2], -1.0, 1.0))
        place = [(np.pi / 2 - elevation) / np.deg2rad(3.0) - 0.5, (azimuth + np.pi) / np.deg2rad(3.0) + 0.5]
        raised = np.clip(elevation + map_coordinates(padded, place, order=1, mode="nearest"), -np.pi / 2, np.pi / 2)
        level = np.cos(raised)
        return np.stack([np.sin(azimuth) * level, np.cos(azimuth) * level, np.sin(raised)], axis=-1)

    return move
