"""Frames of a video, one after the other, without holding more than one of them."""

import os
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import Floats
from insectnav.checks import InputError, check_count, quoted
from insectnav.datasets.image_folder import MAX_PIXELS


class VideoFacts(NamedTuple):
    """What the file says of itself; n_frames is 0 where it does not say."""

    n_frames: int
    frames_per_second: float
    size: tuple[int, int]


def video_facts(path: str | os.PathLike[str]) -> VideoFacts:
    """Number of frames, frames per second and (rows, columns) as the file says.

    Raises
    ------
    InputError
        If the file cannot be opened as a video.
    """
    import cv2

    with closing(_Capture(path)) as capture:
        return VideoFacts(
            max(0, round(capture.get(cv2.CAP_PROP_FRAME_COUNT))),
            float(capture.get(cv2.CAP_PROP_FPS)),
            (round(capture.get(cv2.CAP_PROP_FRAME_HEIGHT)), round(capture.get(cv2.CAP_PROP_FRAME_WIDTH))),
        )


class VideoFrame(NamedTuple):
    """A frame of a video."""

    number: int  # from 0
    time: float  # [s] after the first, at which the file has it shown: not at an even rate in films of telephones
    picture: NDArray[np.uint8]  # (rows, columns, 3) red, green, blue


def video_frames(path: str | os.PathLike[str], step: int = 1) -> Iterator[tuple[int, NDArray[np.uint8]]]:
    """Number, from 0, and picture (rows, columns, 3) red, green, blue of every `step`-th frame.

    Raises
    ------
    InputError
        If the file cannot be opened as a video, or holds no frame that can be decoded.
    """
    return ((frame.number, frame.picture) for frame in timed_video_frames(path, step))


def timed_video_frames(path: str | os.PathLike[str], step: int = 1) -> Iterator[VideoFrame]:
    """Every `step`-th frame, with its time; at the rate of the video where frames have no times of their own.

    Raises
    ------
    InputError
        As of `video_frames`.
    """
    import cv2

    check_count("step", step)
    with closing(_Capture(path)) as capture:
        for number, time in capture.grab_all():
            if number % step:
                continue
            is_there, frame = capture.source.retrieve()
            if not is_there:
                break
            yield VideoFrame(number, time, np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB), np.uint8))


def video_times(path: str | os.PathLike[str]) -> Floats:
    """Times (frame,) [s] of all frames after the first, as of `timed_video_frames`; every one is decoded to know them.

    Raises
    ------
    InputError
        As of `video_frames`.
    """
    with closing(_Capture(path)) as capture:
        return np.array([time for _, time in capture.grab_all()])


class _Capture:
    """An open video; to be closed."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        import cv2

        place, name = Path(path), quoted(Path(path).name, 200)
        self.name = name
        if not place.is_file():
            raise InputError(f"{name} does not exist, expected a video")
        self.source = cv2.VideoCapture(str(place), cv2.CAP_FFMPEG)
        if not self.source.isOpened():
            raise InputError(f"{name} cannot be opened as a video, expected MP4, AVI, MOV or the like: truncated?")
        rows, columns = self.get(cv2.CAP_PROP_FRAME_HEIGHT), self.get(cv2.CAP_PROP_FRAME_WIDTH)
        if rows * columns > MAX_PIXELS:
            self.close()
            raise InputError(f"{name} has frames of {rows:g} × {columns:g} pixels, expected at most {MAX_PIXELS:.0e}")

    def grab_all(self) -> Iterator[tuple[int, float]]:
        """Number and time [s] of every frame, which can be retrieved until the next is asked for."""
        import cv2

        number, rate = 0, float(self.get(cv2.CAP_PROP_FPS))
        while self.source.grab():
            time = round(float(self.get(cv2.CAP_PROP_POS_MSEC)), 3) / 1000  # of which nothing is finer
            if number and not time > 0:
                time = number / rate if rate > 0 else float("nan")
            yield number, time
            number += 1
        if number == 0:
            raise InputError(f"{self.name} holds no frame that can be decoded: truncated?")

    def get(self, what: int) -> Any:
        return self.source.get(what)

    def close(self) -> None:
        self.source.release()
