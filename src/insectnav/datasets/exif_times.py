"""When a camera says that a picture was taken (EXIF 2.32, CIPA DC-008, section 4.6)."""

import struct
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from insectnav.checks import InputError, quoted
from insectnav.datasets.clocks import zone_hours
from insectnav.datasets.picture_headers import exif_block

MAX_BYTES = 64 * 2**20  # of the beginning of a file; cameras write what they know before the picture
MAX_ENTRIES = 1000  # of a directory
_POINTER, _TAKEN, _FRACTION, _ZONE = 0x8769, 0x9003, 0x9291, 0x9011


class CameraTime(NamedTuple):
    """A camera's clock [s] since 1970 as if it showed UTC, and by how many hours it says to be ahead of UTC."""

    clock: float
    utc_offset_h: float | None


def read_exif_time(path: str | PathLike[str]) -> CameraTime | None:
    """When a picture was taken (DateTimeOriginal with its fraction and zone); None where it does not say.

    Parameters
    ----------
    path : JPEG, TIFF (raw files of many cameras are TIFF too) or PNG

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_BYTES)
    except OSError as error:
        raise InputError(f"{quoted(path, 200)} cannot be read ({error.strerror})") from None
    block = exif_block(data)
    try:
        return _taken(block) if block is not None else None
    except (struct.error, IndexError, ValueError):  # a damaged block says nothing
        return None


def _taken(block: bytes) -> CameraTime | None:
    order = {b"II": "<", b"MM": ">"}[block[:2]] if block[:2] in (b"II", b"MM") else None
    if order is None:
        return None
    (start,) = struct.unpack(order + "I", block[4:8])
    pointer = _entries(block, order, start).get(_POINTER)
    if pointer is None:
        return None
    entries = _entries(block, order, struct.unpack(order + "I", pointer[8:12])[0])
    text = _text(block, order, entries.get(_TAKEN))
    if not text:
        return None
    clock = datetime.strptime(text[:19], "%Y:%m:%d %H:%M:%S").replace(tzinfo=UTC).timestamp()
    fraction = _text(block, order, entries.get(_FRACTION))
    if fraction.isascii() and fraction.isdigit():
        clock += float("0." + fraction)
    return CameraTime(clock, zone_hours(_text(block, order, entries.get(_ZONE))))


def _entries(block: bytes, order: str, start: int) -> dict[int, bytes]:
    """The entries of 12 bytes of a directory, by tag."""
    (n_entries,) = struct.unpack(order + "H", block[start : start + 2])
    pieces = [block[start + 2 + 12 * k : start + 14 + 12 * k] for k in range(min(n_entries, MAX_ENTRIES))]
    return {struct.unpack(order + "H", piece[:2])[0]: piece for piece in pieces}


def _text(block: bytes, order: str, entry: bytes | None) -> str:
    """Text of an entry without its end and spaces; nothing where it is missing or no text."""
    if entry is None:
        return ""
    kind, count = struct.unpack(order + "HI", entry[2:8])
    if kind != 2 or count > 100:
        return ""
    start = struct.unpack(order + "I", entry[8:12])[0] if count > 4 else None
    data = entry[8 : 8 + count] if start is None else block[start : start + count]
    return data.split(b"\0")[0].decode("ascii", "replace").strip()
