"""Films whose frames are not at an even rate, as telephones take them."""

import struct
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

TABLE_OF_TIMES = (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stts")  # each in the one before it, ISO 14496-12


def uneven_film(path: Path, pictures: np.ndarray, seconds: Sequence[float]) -> Path:
    """An MP4 of pictures (frame, rows, columns), each of which is shown for so many seconds.

    OpenCV writes films of an even rate alone: their table of times is put in place of another.
    """
    n, rows, columns = pictures.shape
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (columns, rows))
    for picture in pictures:
        writer.write(np.dstack([picture] * 3))
    writer.release()
    film = bytearray(path.read_bytes())
    places = []
    begin, end = 0, len(film)
    for kind in TABLE_OF_TIMES:
        place = film.index(kind, begin, end) - 4
        begin, end = place + 8, place + _size(film, place)
        places.append(place)
    (entries, _, length) = struct.unpack(">III", film[begin + 4 : begin + 16])  # all n frames of one length, 0.1 s
    assert entries == 1
    lengths = [(1, round(10 * length * one)) for one in seconds]
    assert len(lengths) == n
    table = struct.pack(">I4sII", 16 + 8 * n, b"stts", 0, n) + b"".join(struct.pack(">II", *one) for one in lengths)
    longer = len(table) - (end - places[-1])
    film[places[-1] : end] = table
    for place in places[:-1]:
        film[place : place + 4] = struct.pack(">I", _size(film, place) + longer)
    edits = film.index(b"edts")
    film[edits : edits + 4] = b"free"  # which ended the film where it did before
    path.write_bytes(film)
    return path


def _size(film: bytearray, place: int) -> int:
    return int(struct.unpack(">I", film[place : place + 4])[0])
