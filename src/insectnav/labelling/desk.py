"""The desk that pictures lie on while they are labelled: what is open, what was saved."""

import threading
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.checks import InputError
from insectnav.datasets.image_folder import read_image
from insectnav.labelling.masks import Shares, grown, read_strokes, shares, write_labels
from insectnav.labelling.pictures import MASK, STROKES, Bytes, on_screen
from insectnav.vision.growcut import StrokeGrower


@dataclass(frozen=True, kw_only=True)
class Saved:
    """A mask that was saved.

    Parameters
    ----------
    picture, mask, strokes : paths
    shares : of the mask
    """

    picture: Path
    mask: Path
    strokes: Path
    shares: Shares


@dataclass(frozen=True, kw_only=True)
class _OpenPicture:
    shape: tuple[int, int]
    grower: StrokeGrower
    jpeg: bytes


class Desk:
    """Pictures by number, one of them open; may be used from several threads.

    Parameters
    ----------
    pictures : paths of images
    folder : where masks and strokes go, and where earlier ones are found
    """

    def __init__(self, pictures: Sequence[Path], folder: Path) -> None:
        self.pictures = tuple(pictures)
        self.folder = folder
        self.saved: dict[int, Saved] = {}
        self._lock, self._saving = threading.Lock(), threading.Lock()
        self._is_closed = False
        self._number = -1
        self._open: _OpenPicture | None = None

    def mask_path(self, number: int) -> Path:
        """Where the mask of a picture goes."""
        return self.folder / (self.pictures[number].stem + MASK)

    def strokes_path(self, number: int) -> Path:
        """Where its strokes go."""
        return self.folder / (self.pictures[number].stem + STROKES)

    def contents(self) -> list[dict[str, Any]]:
        """Name of each picture, and whether it has a mask already."""
        return [
            {"name": path.name, "labelled": self.mask_path(number).is_file()}
            for number, path in enumerate(self.pictures)
        ]

    def jpeg(self, number: int) -> bytes:
        """The picture for the screen, as large as it is."""
        with self._lock:
            return self._opened(number).jpeg

    def packed_strokes(self, number: int) -> bytes | None:
        """Strokes saved earlier, packed; None where there are none."""
        path = self.strokes_path(number)
        with self._lock:
            shape = self._opened(number).shape
        return zlib.compress(read_strokes(path, shape).tobytes(), 1) if path.is_file() else None

    def n_pixels(self, number: int) -> int:
        """Number of pixels of a picture."""
        with self._lock:
            rows, columns = self._opened(number).shape
        return rows * columns

    def grow(self, number: int, packed: bytes) -> bytes:
        """Labels of all pixels, packed, from packed strokes."""
        with self._lock:
            strokes = self._unpacked(number, packed)
            return zlib.compress(grown(self._opened(number).grower, strokes).tobytes(), 1)

    def save(self, number: int, packed: bytes) -> Saved:
        """Leave mask and strokes in the folder."""
        with self._saving, self._lock:
            if self._is_closed:
                raise InputError("nothing is saved any more, expected this before the program was told to end")
            strokes = self._unpacked(number, packed)
            labels = grown(self._opened(number).grower, strokes)
            mask, strokes_path = self.mask_path(number), self.strokes_path(number)
            write_labels(strokes_path, strokes)
            write_labels(mask, labels)
            saved = Saved(picture=self.pictures[number], mask=mask, strokes=strokes_path, shares=shares(labels))
            self.saved[number] = saved
            return saved

    def close(self) -> None:
        """Let what is being saved be saved whole, and nothing after it."""
        with self._saving:
            self._is_closed = True

    def _unpacked(self, number: int, packed: bytes) -> Bytes:
        """Strokes (rows, columns); what unpacks to more is not unpacked."""
        shape = self._opened(number).shape
        n_pixels = shape[0] * shape[1]
        try:
            content = zlib.decompressobj().decompress(packed, n_pixels + 1)
        except zlib.error:
            raise InputError("strokes cannot be unpacked, expected bytes packed by deflate") from None
        if len(content) != n_pixels:
            raise InputError(f"strokes have {len(content)} bytes or more, expected one for each of {n_pixels} pixels")
        strokes = np.frombuffer(content, np.uint8).reshape(shape)
        if strokes.max() > 2:
            raise InputError("strokes hold labels above 2, expected 0, 1 and 2")
        return strokes

    def _opened(self, number: int) -> _OpenPicture:
        """The picture, read if another one was open."""
        if self._open is None or self._number != number:
            pixels = read_image(self.pictures[number])
            self._open = _OpenPicture(
                shape=(pixels.shape[0], pixels.shape[1]), grower=StrokeGrower(pixels), jpeg=on_screen(pixels)
            )
            self._number = number
        return self._open
