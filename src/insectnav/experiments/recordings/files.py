"""Recordings in the folder that INSECTNAV_DATA names, as arrays; empty ones where a recording is missing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.datasets.image_folder import read_image, read_mask

FOLDER = "INSECTNAV_DATA"  # variable that names the folder
MISSING = f"not found: set {FOLDER} to the folder that has it"
OTHER_RECORDING = "another recording: those of the paper were not published"
N_NORDLAND, N_SKIES = 1200, 65

Bytes = NDArray[np.uint8]
Reals = NDArray[np.floating[Any]]


class Drive(NamedTuple):
    """Panoramas along a drive and where they were taken."""

    views: Bytes  # (view, 25, 120)
    position: Reals  # (view, 2) [m], NaN where it was not tracked


def place_of(recording: str) -> Path | None:
    """Folder of a recording, None where it is missing."""
    folder = os.environ.get(FOLDER)
    place = Path(folder or "") / recording
    return place if folder and place.is_dir() else None


def nordland(season: str) -> Bytes:
    """The railway in "summer" or "winter", (1200, 32, 64); without frames where it is missing."""
    place = place_of("nordland")
    if place is None:
        return np.empty((0, 32, 64), np.uint8)
    return _frames(tuple(place / season / f"{number:05d}.png" for number in range(N_NORDLAND)), (32, 64))


def sussex(drive: str) -> Drive:
    """A robot's "training" drive, 455 views, or its "test" drive, 102; without views where it is missing."""
    place = place_of("sussex_route")
    if place is None:
        return Drive(np.empty((0, 25, 120), np.uint8), np.empty((0, 2)))
    n, name, taken, track = {
        "training": (455, "snapshot", "training.csv", "training_path_scaled.csv"),
        "test": (102, "test", "testing_infomax.csv", "testing_path_infomax_scaled.csv"),
    }[drive]
    views = _frames(tuple(place / f"{name}_{number}.png" for number in range(n)), (25, 120))
    time_s = np.loadtxt(place / taken, delimiter=",", skiprows=1, usecols=0)[:n]
    tracked = np.loadtxt(place / track, delimiter=",", ndmin=2)
    tracked = tracked[np.isfinite(tracked).all(axis=1)]
    position = [np.interp(time_s, tracked[:, 0] / 1e3, tracked[:, axis] / 1e2, np.nan, np.nan) for axis in (1, 2)]
    return Drive(views, np.stack(position, axis=-1))


@lru_cache(maxsize=1)
def sky_masks() -> NDArray[np.bool_]:
    """Sky of 65 photographs along one walk, marked by hand, (65, 320, 320); without any where they are missing."""
    place = place_of("fisheye_sky")
    if place is None:
        return np.empty((0, 320, 320), bool)
    paths = sorted(place.glob("*_mask.png"))[:N_SKIES]
    return np.array([read_mask(path)[0] for path in paths]).reshape(-1, 320, 320)


@lru_cache(maxsize=4)
def _frames(paths: Sequence[Path], shape: tuple[int, int]) -> Bytes:
    """Grey frames, (frame, rows, columns)."""
    frames = np.empty((len(paths), *shape), np.uint8)
    for frame, path in zip(frames, paths, strict=True):
        picture = read_image(path)
        grey = picture if picture.ndim == 2 else _grey(picture)
        if grey.shape != shape or grey.dtype != np.uint8:
            raise InputError(
                f"{quoted(path.name)} has {grey.shape[0]} × {grey.shape[1]} pixels of {grey.dtype}, expected "
                f"{shape[0]} × {shape[1]} bytes: another recording in its place?"
            )
        frame[:] = grey
    frames.setflags(write=False)
    return frames


def _grey(picture: NDArray[Any]) -> Bytes:
    import cv2

    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
