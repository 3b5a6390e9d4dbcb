"""The pictures that are labelled, and the files that belong to them."""

import os
import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted

Bytes = NDArray[np.uint8]
SUFFIXES = frozenset([".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".pgm", ".ppm"])
MASK, STROKES = "_mask.png", "_strokes.png"  # after the name of the picture
MAX_FILE_BYTES = 2**30
MAX_PIXELS = 2**27
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


def read_picture(path: Path) -> NDArray[Any]:
    """Pixels as they are stored, (rows, columns) or (rows, columns, 3) in red, green, blue; transparency is dropped.

    Raises
    ------
    InputError
        If the file cannot be read or is no image.
    """
    import cv2

    shown = quoted(path, 200)
    try:
        size = path.stat().st_size
        content = np.fromfile(path, np.uint8) if size <= MAX_FILE_BYTES else None
    except OSError as error:
        raise InputError(f"{shown} cannot be read ({error.strerror})") from None
    if content is None:
        raise InputError(f"{shown} has {size} bytes, expected at most {MAX_FILE_BYTES}")
    try:
        pixels = cv2.imdecode(content, cv2.IMREAD_UNCHANGED) if content.size else None
    except cv2.error:
        pixels = None
    if pixels is None or pixels.ndim not in (2, 3) or pixels.dtype.kind not in "uif":
        raise InputError(f"{shown} cannot be read as an image: cut short, or of another format?")
    if pixels.shape[0] * pixels.shape[1] > MAX_PIXELS:
        raise InputError(f"{shown} has {pixels.shape[1]} × {pixels.shape[0]} pixels, expected at most {MAX_PIXELS}")
    if pixels.ndim == 3:
        pixels = pixels[..., 2::-1] if pixels.shape[2] >= 3 else pixels[..., 0]
    return np.ascontiguousarray(pixels)


def write_picture(path: Path, pixels: NDArray[Any]) -> None:
    """Picture, grey or in red, green and blue, in the format of its ending; written under another name and renamed.

    Raises
    ------
    InputError
        If the place cannot be written.
    """
    import cv2

    stored = np.ascontiguousarray(pixels[..., ::-1] if pixels.ndim == 3 else pixels)
    content = cv2.imencode(path.suffix, stored)[1].tobytes()
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_bytes(content)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{quoted(path, 200)} cannot be written ({error.strerror})") from None


def on_screen(picture: NDArray[Any]) -> bytes:
    """The picture as a JPEG for the page; more than 8 bits are stretched between two quantiles."""
    import cv2

    if picture.dtype != np.uint8:
        low, high = np.quantile(picture[:: max(1, len(picture) // 500)], SCREEN_QUANTILES)
        grey = (picture - float(low)) * (255.0 / max(float(high) - float(low), 1e-12))
        picture = np.clip(grey, 0.0, 255.0).astype(np.uint8)
    shown = picture[..., ::-1] if picture.ndim == 3 else picture
    return cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, SCREEN_QUALITY])[1].tobytes()
