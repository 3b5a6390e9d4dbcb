"""Small pictures of the places of a map, kept beside its descriptors, so that a match can be shown to a person."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.experiments.mask_pictures import displayed

FILE = "thumbnails.sqlite"
WIDTH, HEIGHT = 288, 192  # [px] at most
SMALL = 128  # [px] of a width up to which pictures are kept as they are, and nearly without loss
QUALITY, SMALL_QUALITY = 80, 95  # of JPEG
MOST_BYTES = 200_000  # of a small picture: larger ones are none of ours
MOST_PIXELS = 200_000


def thumbnail(picture: NDArray[Any]) -> bytes:
    """A picture as a small JPEG; nothing if it is none, as a vector is not."""
    import cv2

    if picture.ndim not in (2, 3):
        return b""
    rows, columns = picture.shape[:2]
    factor = min(1.0, WIDTH / columns, HEIGHT / rows)
    if factor < 1.0:
        size = (max(1, round(columns * factor)), max(1, round(rows * factor)))
        picture = cv2.resize(np.ascontiguousarray(picture), size, interpolation=cv2.INTER_AREA)
    shown = np.ascontiguousarray(displayed(picture)[..., ::-1])
    quality = SMALL_QUALITY if shown.shape[1] <= SMALL else QUALITY
    is_encoded, data = cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return data.tobytes() if is_encoded else b""


def picture_of(data: bytes) -> NDArray[np.uint8] | None:
    """A small JPEG as (rows, columns, 3) red, green, blue; None if it is none that we would have kept."""
    import cv2

    if not data or not data.startswith(b"\xff\xd8") or len(data) > MOST_BYTES:
        return None
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    if picture is None or picture.shape[0] * picture.shape[1] > MOST_PIXELS:
        return None
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)


def keep_thumbnails(folder: Path, first: int, pictures: Sequence[bytes]) -> None:
    """Keep small pictures of the places from a number on, all or none of them; empty ones are left out.

    Raises
    ------
    InputError
        If they cannot be written.
    """
    try:
        with closing(sqlite3.connect(folder / FILE)) as store, store:
            store.execute("CREATE TABLE IF NOT EXISTS thumbnails (place INTEGER PRIMARY KEY, jpeg BLOB NOT NULL)")
            store.execute("DELETE FROM thumbnails WHERE place >= ?", (first,))  # of a run that was killed
            rows = ((first + k, data) for k, data in enumerate(pictures) if data)
            store.executemany("INSERT INTO thumbnails VALUES (?, ?)", rows)
    except sqlite3.Error as error:
        raise InputError(f"small pictures cannot be kept in {quoted(folder, 200)} ({error}): --no-pictures") from None


def find_thumbnails(folder: Path, places: Iterable[int]) -> Mapping[int, bytes]:
    """Small pictures by the number of the place, of those that are there.

    Parameters
    ----------
    folder : of the map
    places : numbers wanted
    """
    path = folder / FILE
    if not path.is_file():
        return {}
    found: dict[int, bytes] = {}
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)) as store:
            for place in places:
                row = store.execute("SELECT jpeg FROM thumbnails WHERE place = ?", (int(place),)).fetchone()
                if row and isinstance(row[0], bytes):
                    found[int(place)] = row[0]
    except sqlite3.Error:  # damaged: a page without them is still a page
        return found
    return found
