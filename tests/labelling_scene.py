"""A picture with a skyline to be labelled, and strokes on it."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np

from command_line import PATIENCE
from insectnav.labelling.desk import Desk
from insectnav.labelling.server import LabelServer

ROWS, COLUMNS = 90, 120


def is_sky() -> np.ndarray:
    """What is sky, (ROWS, COLUMNS)."""
    skyline = 45 + 12 * np.sin(np.arange(COLUMNS) / 12.0)
    return np.arange(ROWS)[:, None] < skyline


def picture(dtype: type = np.uint8) -> np.ndarray:
    """Red, green and blue, with a bright sky."""
    rng = np.random.default_rng(5)
    colours = np.where(is_sky()[..., None], [120, 160, 220], [70, 60, 40]) + rng.integers(-8, 9, (ROWS, COLUMNS, 3))
    return (colours * (257 if dtype == np.uint16 else 1)).astype(dtype)


def strokes() -> np.ndarray:
    """As they are stored: 255 sky, 0 ground, 128 elsewhere."""
    painted = np.full((ROWS, COLUMNS), 128, np.uint8)
    painted[8:12, 10:110], painted[78:82, 10:110] = 255, 0
    return painted


def leave(folder: Path, *names: str) -> None:
    """The picture under several names."""
    for name in names:
        cv2.imwrite(str(folder / name), picture(np.uint16 if name.endswith(".tif") else np.uint8)[..., ::-1])


def read(path: Path) -> np.ndarray:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


@contextmanager
def served(desk: Desk, patience_s: float = PATIENCE) -> Iterator[tuple[LabelServer, threading.Thread]]:
    """The page in a thread of its own, which ends with the block at the latest."""
    server = LabelServer(desk, patience_s)
    thread = threading.Thread(target=server.serve)
    thread.start()
    try:
        yield server, thread
    finally:
        server.end()
        thread.join(PATIENCE)
        assert not thread.is_alive()


def calls_of(server: LabelServer, name: str) -> list[None]:
    """A list that grows by one as soon as a method of the server has done its work."""
    calls: list[None] = []
    method = getattr(server, name)
    setattr(server, name, lambda: calls.append(method()))
    return calls
