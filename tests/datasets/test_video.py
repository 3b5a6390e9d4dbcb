"""Frames of videos: their number, order and content; what is no video."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.datasets.video import timed_video_frames, video_facts, video_frames
from uneven_films import uneven_film


def written(path: Path, n_frames: int = 12) -> Path:
    """A video that grows brighter, and redder than blue."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for k in range(n_frames):
        writer.write(np.full((48, 64, 3), (10 * k, 10 * k, 10 * k + 40), np.uint8))  # blue, green, red
    writer.release()
    return path


def test_frames_come_in_order_and_in_red_green_blue(tmp_path: Path):
    path = written(tmp_path / "a.avi")
    assert video_facts(path) == (12, 10.0, (48, 64))
    found = list(video_frames(path))
    assert [number for number, _ in found] == list(range(12))
    for number, frame in found:
        assert np.abs(frame.mean(axis=(0, 1)) - [10 * number + 40, 10 * number, 10 * number]).max() < 6


def test_every_fifth_frame(tmp_path: Path):
    assert [number for number, _ in video_frames(written(tmp_path / "a.avi"), 5)] == [0, 5, 10]


def test_what_is_no_video_is_refused(tmp_path: Path):
    (tmp_path / "a.mp4").write_text("hello")
    for path, words in ((tmp_path / "a.mp4", "cannot be opened"), (tmp_path / "b.mp4", "does not exist")):
        with pytest.raises(InputError, match=words):
            video_facts(path)
        with pytest.raises(InputError, match=words):
            list(video_frames(path))
    with pytest.raises(InputError, match="step"):
        list(video_frames(written(tmp_path / "c.avi"), 0))


def test_frames_have_the_times_at_which_the_file_has_them_shown(tmp_path: Path):
    even = [time for _, time, _ in timed_video_frames(written(tmp_path / "a.avi"))]
    assert even == [k / 10 for k in range(12)]
    seconds = [0.1] * 4 + [0.5] * 4 + [0.04] * 4
    path = uneven_film(
        tmp_path / "b.mp4", np.arange(12, dtype=np.uint8)[:, None, None] + np.zeros((48, 64), np.uint8), seconds
    )
    found = list(timed_video_frames(path))
    np.testing.assert_allclose([time for _, time, _ in found], np.cumsum([0, *seconds[:-1]]), atol=1e-3)
    assert [(number, time) for number, time, _ in timed_video_frames(path, 5)] == [found[k][:2] for k in (0, 5, 10)]
