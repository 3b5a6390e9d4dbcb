"""Made pictures with a known sky, and the real photographs, for the tests of segmentation."""

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")


class Scene(NamedTuple):
    picture: np.ndarray  # (rows, columns, 3) uint8
    sky: np.ndarray  # (rows, columns) bool


def hills(rows: int = 60, columns: int = 80, noise: float = 6.0, seed: int = 0) -> Scene:
    """Blue sky above brown hills, with the noise of a sensor; the skyline is a wave."""
    rng = np.random.default_rng(seed)
    height = rows * (0.45 + 0.15 * np.sin(np.arange(columns) * 4 * np.pi / columns))
    sky = np.arange(rows)[:, None] + 0.5 < height
    colours = np.where(sky[..., None], [150.0, 180.0, 230.0], [80.0, 70.0, 50.0])
    return Scene(np.clip(colours + rng.normal(0, noise, (rows, columns, 3)), 0, 255).astype(np.uint8), sky)


def disk(size: int = 90, noise: float = 6.0) -> Scene:
    """A fisheye picture that looks up: sky within a wavy rim of ground, white paper outside the round picture."""
    rng = np.random.default_rng(1)
    down, right = np.mgrid[:size, :size] + 0.5 - size / 2
    away, azimuth = np.hypot(down, right) / (size / 2), np.arctan2(down, right)
    sky = away < 0.65 + 0.15 * np.sin(3 * azimuth)
    colours = np.where(sky[..., None], [150.0, 180.0, 230.0], [80.0, 70.0, 50.0])
    colours = colours + rng.normal(0, noise, (size, size, 3))
    colours[away > 1.0] = 255.0
    return Scene(np.clip(colours, 0, 255).astype(np.uint8), sky)


def photographs(name: str, ending: str, step: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Every so many real photographs of a set: picture, sky, and where that is known."""
    from insectnav.datasets.image_folder import find_images, read_image, read_mask

    if not (DATA / name).is_dir():
        pytest.skip(f"{DATA / name} is missing")
    files = find_images([DATA / name]).files
    return [(read_image(path), *read_mask(path.with_name(f"{path.stem}{ending}.png"))) for path in files[::step]]
