"""A day's walk put together from its sections, in the order in which it was walked."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2014_places.walk import DAYS
from insectnav.experiments.stone2014_places.walk_frames import SKY_SIZE
from insectnav.vision.descriptors import binary_sky

Bools = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Walk:
    """Frames of a day.

    Parameters
    ----------
    day : name of the day
    every : seconds from frame to frame
    mirror_size : [px] of the mirror pictures
    arrays : name -> (frame, ...), of `walk_frames.section_arrays`
    """

    day: str
    every: int
    mirror_size: int
    arrays: Mapping[str, NDArray[Any]]

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.arrays[name]

    def __len__(self) -> int:
        return len(self.arrays["number"])

    def sampled(self, start: int, step: int) -> NDArray[np.int64]:
        """Which frames were taken at second `start` and every `step` seconds after it."""
        number = self["number"]
        return np.flatnonzero((number >= start) & ((number - start) % step == 0))

    def binary_skies(self) -> Bools:
        """Skies of 90 × 90 bits, (frame, bit)."""
        return np.unpackbits(self["binary_sky"], axis=1, count=SKY_SIZE**2).astype(bool)

    def mirror_sky(self, frame: int) -> Bools:
        """The sky of one frame as the mirror shows it, (size, size): all of it, where it is."""
        size = self.mirror_size
        return np.unpackbits(self["mirror_sky"][frame], count=size**2).reshape(size, size).astype(bool)

    def mirror_skies(self, frames: Any, *, centred: bool = True, reduction: int = 1) -> Bools:
        """Skies as the mirror shows them, (frame, size, size): the region about its middle, perhaps shifted to it."""
        size = self.mirror_size
        masks = np.unpackbits(self["mirror_sky"][frames], axis=1, count=size**2).reshape(-1, size, size).astype(bool)
        small = size // reduction
        return binary_sky(masks, small, centre=centred).reshape(-1, small, small)


def walk_of(results: Results, day: str, **wanted: Any) -> Walk:
    """The walk of that day, of the cells that have the wanted parameters."""
    cells = results.where(day=day, **wanted)
    number = results["number"][cells].ravel()
    is_frame = number >= 0
    arrays = {name: values[cells].reshape(-1, *values.shape[2:])[is_frame] for name, values in results.arrays.items()}
    first = results.cells[int(cells[0])]
    return Walk(day=day, every=first.every, mirror_size=first.mirror_size, arrays=arrays)


def whole_or_why_not(n_frames: int) -> str:
    """Why numbers of so many frames are not to be held against published ones; nothing if all are there."""
    n_published = sum(day.n_frames for day in DAYS.values())
    if n_frames == n_published:
        return ""
    return f"{n_frames} frames of a part of the walk, expected all {n_published}: run it at full scale"


@lru_cache(maxsize=2)
def both_walks(results: Results, **wanted: Any) -> dict[str, Walk]:
    """Walks of both days."""
    return {day: walk_of(results, day, **wanted) for day in results.by("day")}
