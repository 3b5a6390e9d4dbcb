"""Columns that say which frame a row is of, and when it was taken."""

from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, check_finite, check_range

SECONDS = {"_s": 1.0, "_ms": 1e-3, "_us": 1e-6, "_ns": 1e-9}  # endings of names
TIMES = {
    f"{name}{ending}": factor
    for name in ("time", "t", "timestamp", "#timestamp", "unix", "unix_time")
    for ending, factor in SECONDS.items()
}
FRAMES = dict.fromkeys(("frame", "frame_number", "frame_index"), 1.0)
NAMES = dict.fromkeys(("file", "filename", "file_name", "name", "image", "image_name"), 1.0)
MAX_FRAME = 2**53


def whole_numbers(name: str, values: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """Numbers of frames as integers; refuses fractions and what is missing."""
    check_finite(name, values)
    check_range(name, values, -MAX_FRAME, MAX_FRAME)
    if (values != np.floor(values)).any():
        raise InputError(f"{name} holds fractions, expected whole numbers of frames: times?")
    return values.astype(np.int64)
