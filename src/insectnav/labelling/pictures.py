"""The pictures that are labelled, and the files that belong to them."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.datasets.image_folder import PICTURES, RAW

Bytes = NDArray[np.uint8]
SUFFIXES = frozenset((*PICTURES, *RAW))
MASK, STROKES = "_mask.png", "_strokes.png"  # after the name of the picture
SCREEN_QUANTILES = (0.005, 0.995)  # of a picture of more than 8 bits, shown as black and white; for the screen alone
SCREEN_QUALITY = 95  # of its JPEG


def list_pictures(names: Sequence[str | os.PathLike[str]]) -> list[Path]:
    """Image files, in the order given and by name within a folder; masks and strokes of this program left out.

    Parameters
    ----------
    names : paths of images or folders

    Raises
    ------
    InputError
        If a name leads nowhere, is no image, there are none, or two would share a mask.
    """
    found: list[Path] = []
    for name in map(Path, names):
        if name.is_dir():
            found += sorted(path for path in name.iterdir() if _is_picture(path) and not _is_made_here(path))
        elif not name.is_file():
            raise InputError(f"{quoted(name, 200)} is missing, expected an image or a folder of images")
        elif not _is_picture(name):
            raise InputError(f"{quoted(name, 200)} has no ending of an image, expected {', '.join(sorted(SUFFIXES))}")
        else:
            found.append(name)
    if not found:
        raise InputError("no image was found, expected an image or a folder of images")
    unique = list({path.resolve(): path for path in found}.values())
    stems: dict[str, Path] = {}
    for path in unique:
        if (other := stems.setdefault(path.stem, path)) is not path:
            raise InputError(f"{quoted(other, 200)} and {quoted(path, 200)} would share a mask: label one at a time")
    return unique


def _is_picture(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES and not path.name.startswith(".") and path.is_file()


def _is_made_here(path: Path) -> bool:
    return path.name.endswith((MASK, STROKES))


def on_screen(picture: NDArray[Any]) -> bytes:
    """The picture as a JPEG for the page; more than 8 bits are stretched between two quantiles."""
    import cv2

    if picture.dtype != np.uint8:
        low, high = np.quantile(picture[:: max(1, len(picture) // 500)], SCREEN_QUANTILES)
        grey = (picture - float(low)) * (255.0 / max(float(high) - float(low), 1e-12))
        picture = np.clip(grey, 0.0, 255.0).astype(np.uint8)
    shown = picture[..., ::-1] if picture.ndim == 3 else picture
    return cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, SCREEN_QUALITY])[1].tobytes()
