"""Frames described by several threads in their order; what cannot be described is a missing frame with a reason."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, counted
from insectnav.experiments.picture_sources import in_order
from insectnav.experiments.place_maps.describe import MASK, DescribeParams, describe, looks_like_mask
from insectnav.experiments.place_maps.frames import Frame
from insectnav.experiments.place_maps.thumbnails import thumbnail
from insectnav.workers import count_workers

Features = NDArray[np.float32]
MOST_NAMED = 5  # missing frames that are told one by one


@dataclass(frozen=True, kw_only=True, eq=False)
class Described:
    """A frame with its features, or why there are none, and a small picture of it."""

    frame: Frame
    features: Features | None
    picture: bytes = b""
    refusal: str = ""


def settled(frames: Iterator[Frame], params: DescribeParams) -> tuple[DescribeParams, Iterator[Frame], list[str]]:
    """Parameters with all that follows from the first frame that can be read, all frames, and what is to be said.

    Parameters
    ----------
    frames : to be described
    params : DescribeParams

    Raises
    ------
    InputError
        If none can be read.
    """
    waiting: list[Frame] = []
    refusals: list[str] = []
    for frame in frames:
        waiting.append(frame)
        try:
            picture = frame.read()
        except InputError as error:
            refusals.append(f"{frame.name}: {error}")
            continue
        notes = []
        if params.is_of_sky and not params.is_vectors and params.sky != MASK and looks_like_mask(picture):
            notes.append(f"{frame.name} holds two values alone, as a mask of the sky does: --sky mask takes it as such")
        return params.settled(picture), chain(waiting, frames), notes
    raise InputError(_none_of(refusals))


def described(
    frames: Iterator[Frame], params: DescribeParams, pictures: bool, workers: int | None
) -> Iterator[Described]:
    """Frames with their features.

    Parameters
    ----------
    frames : to be described
    params : DescribeParams
        As `settled`.
    pictures : whether small pictures are kept, too
    workers : threads; they change nothing in the results
    """

    def one(frame: Frame) -> Described:
        try:
            picture = frame.read()
        except InputError as error:
            return Described(frame=_without_picture(frame), features=None, refusal=str(error))
        small = thumbnail(picture) if pictures else b""
        try:
            features = describe(picture, params)
        except InputError as error:
            return Described(frame=_without_picture(frame), features=None, picture=small, refusal=str(error))
        return Described(frame=_without_picture(frame), features=features, picture=small)

    yield from in_order(one, frames, count_workers(workers))


def stacked(vectors: list[Features | None], n_features: int, metric: str) -> Features:
    """Features (frame, feature) with a row of NaN for each frame that is missing; of bits a row of zeros.

    Raises
    ------
    InputError
        If vectors differ in length.
    """
    missing = np.full(n_features, 0.0 if metric == "hamming" else np.nan, np.float32)
    for vector in vectors:
        if vector is not None and len(vector) != n_features:
            raise InputError(f"a frame has {len(vector)} features, expected {n_features} as the others")
    return np.stack([missing if vector is None else vector for vector in vectors])


class Remarks:
    """What is to be said of frames that were described; collects it as they come."""

    def __init__(self) -> None:
        self.missing: list[str] = []
        self.n_frames = 0
        self.n_equal = 0
        self.n_empty = 0
        self._before: Any = None

    def add(self, one: Described) -> None:
        """Take one more frame into account."""
        self.n_frames += 1
        if one.features is None:
            self.missing.append(f"{one.frame.name}: {one.refusal}")
            return
        self.n_empty += not one.features.any()
        self.n_equal += self._before is not None and np.array_equal(one.features, self._before)
        self._before = one.features

    @property
    def counts(self) -> dict[str, int]:
        """Frames that were described, and how many of them are missing."""
        return {"frames": self.n_frames, "missing": len(self.missing)}

    def check_any(self) -> None:
        """Refuse to end with nothing.

        Raises
        ------
        InputError
            If every frame is missing.
        """
        if len(self.missing) == self.n_frames:
            raise InputError(_none_of(self.missing))

    def sentences(self, metric: str) -> list[str]:
        """Notes for a person, without a final stop."""
        said = [f"missing frame {text}" for text in self.missing[:MOST_NAMED]]
        if len(self.missing) > MOST_NAMED:
            said.append(counted(len(self.missing) - MOST_NAMED, "more frame is missing", "more frames are missing"))
        if self.missing and metric == "hamming":
            said.append("bits have no value for what is missing: such places have no sky at all")
        if self.n_equal:
            said.append(
                f"{self._share(self.n_equal, 'looks', 'look')} just like the one before: the camera stood still; "
                "--every-m takes such places once"
            )
        if self.n_empty:
            said.append(f"{self._share(self.n_empty, 'has', 'have')} nothing to describe, as a blank picture has")
        return said

    def _share(self, number: int, one: str, many: str) -> str:
        """Some of all frames, with the verb of what they do."""
        return f"{number} of {counted(self.n_frames, 'frame')} {one if number == 1 else many}"


def _without_picture(frame: Frame) -> Frame:
    """The frame without what reads it, which of a film holds the picture."""
    return replace(frame, read=_gone)


def _gone() -> NDArray[Any]:
    raise InputError("the picture of this frame is not kept")


def _none_of(refusals: list[str]) -> str:
    if not refusals:
        return "there is no frame, expected some: a thinning that leaves none?"
    more = f" (and {len(refusals) - 1} more)" if len(refusals) > 1 else ""
    return f"no frame can be used, {refusals[0]}{more}"
