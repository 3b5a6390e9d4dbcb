"""Recorded routes from the folder that INSECTNAV_DATA names; tests that use them are marked `data` and skip without."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")


def load_images(paths):
    """Grey images (n, rows, columns)."""
    if not paths:
        pytest.skip(f"{DATA} is missing, or holds other data")
    for path in paths:
        if not path.exists():
            pytest.skip(f"{path} is missing")
    return np.stack([cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in paths])


def nordland(season, frames=range(1200)):
    """Frames of the railway, (n, 32, 64)."""
    return load_images([DATA / "nordland" / season / f"{frame:05d}.png" for frame in frames])


def sussex(kind):
    """Panoramas (n, 25, 120) of a robot, kind "snapshot" or "test", and positions (n, 2) [cm], NaN off the track."""
    folder = DATA / "sussex_route"
    n, times, path = {
        "snapshot": (455, "training.csv", "training_path_scaled.csv"),
        "test": (102, "testing_infomax.csv", "testing_path_infomax_scaled.csv"),
    }[kind]
    images = load_images([folder / f"{kind}_{i}.png" for i in range(n)])
    taken = np.loadtxt(folder / times, delimiter=",", skiprows=1, usecols=0)
    track = np.loadtxt(folder / path, delimiter=",", ndmin=2)
    track = track[np.isfinite(track).all(axis=1)]
    position = [np.interp(taken, track[:, 0] / 1000, track[:, k], np.nan, np.nan) for k in (1, 2)]
    return images, np.stack(position, axis=-1)
