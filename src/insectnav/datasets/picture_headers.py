"""What the bytes of a picture say before it is decoded: its kind, its size, and whether the file is complete.

Decoders fill the missing part of a truncated file with grey and go on, and allocate whatever a header asks for.
"""

import struct
from typing import NamedTuple

MAX_ENTRIES = 1000  # of a TIFF directory
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # start of frame, of all codings
_TIFF_TYPES = {3: "H", 4: "I"}  # unsigned numbers of 2 and 4 bytes; what sizes and offsets come in


class Header(NamedTuple):
    """Kind of a picture, its size, and whether all of it is there."""

    kind: str
    rows: int
    columns: int
    is_complete: bool


def read_header(data: bytes) -> Header | None:
    """Header of a PNG, JPEG or TIFF file; None where the bytes are none of them, or break off in the header."""
    try:
        if data.startswith(b"\x89PNG\r\n\x1a\n"):
            columns, rows = struct.unpack(">II", data[16:24])
            return Header("PNG", rows, columns, data.rstrip(b"\0").find(b"IEND", len(data) // 2) > 0)
        if data.startswith(b"\xff\xd8\xff"):
            return _jpeg_header(data)
        if data[:4] in (b"II*\0", b"MM\0*"):
            return _tiff_header(data)
    except (struct.error, IndexError):
        return None
    return None


def _jpeg_header(data: bytes) -> Header | None:
    """Walk from segment to segment up to the coded picture, after which only the end marker is searched for."""
    at = 2
    size: tuple[int, int] | None = None
    while at < len(data):
        if data[at] != 0xFF:
            return None
        marker = data[at + 1]
        if marker == 0xFF or marker == 0x01 or 0xD0 <= marker <= 0xD7:  # filling, and markers without a segment
            at += 1 if marker == 0xFF else 2
            continue
        (length,) = struct.unpack(">H", data[at + 2 : at + 4])
        if marker in _JPEG_FRAMES:
            rows, columns = struct.unpack(">HH", data[at + 5 : at + 9])
            size = (rows, columns)
        if marker == 0xDA:
            return Header("JPEG", *size, data.find(b"\xff\xd9", at + length) > 0) if size else None
        at += 2 + length
    return Header("JPEG", *size, False) if size else None


def _tiff_header(data: bytes) -> Header | None:
    """Size and extent of the first picture of a TIFF file (TIFF 6.0, section 2)."""
    order = "<" if data[:2] == b"II" else ">"
    (start,) = struct.unpack(order + "I", data[4:8])
    (n_entries,) = struct.unpack(order + "H", data[start : start + 2])
    if n_entries > MAX_ENTRIES:
        return None
    tags = {}
    for k in range(n_entries):
        entry = data[start + 2 + 12 * k : start + 14 + 12 * k]
        tag, kind, count = struct.unpack(order + "HHI", entry[:8])
        if kind in _TIFF_TYPES and tag in (256, 257, 273, 279, 324, 325) and count <= len(data):
            code = f"{order}{count}{_TIFF_TYPES[kind]}"
            length = struct.calcsize(code)
            offset = start + 10 + 12 * k if length <= 4 else struct.unpack(order + "I", entry[8:])[0]
            tags[tag] = struct.unpack(code, data[offset : offset + length])
    if not {256, 257} <= set(tags):
        return None
    offsets, lengths = tags.get(273, tags.get(324, ())), tags.get(279, tags.get(325, ()))
    end = max((offset + length for offset, length in zip(offsets, lengths, strict=False)), default=0)
    return Header("TIFF", tags[257][0], tags[256][0], 0 < end <= len(data))


def exif_block(data: bytes) -> bytes | None:
    """What a camera wrote beside the picture (EXIF), itself a TIFF; None where there is nothing."""
    try:
        if data[:4] in (b"II*\0", b"MM\0*"):
            return data
        if data.startswith(b"\x89PNG\r\n\x1a\n"):
            return _png_exif(data)
        return _jpeg_exif(data) if data.startswith(b"\xff\xd8\xff") else None
    except (struct.error, IndexError):
        return None


def _png_exif(data: bytes) -> bytes | None:
    """The chunk eXIf (PNG, third edition, section 11.3.4.5)."""
    at = 8
    while at + 8 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"eXIf":
            return data[at + 8 : at + 8 + length]
        at += 12 + length
    return None


def _jpeg_exif(data: bytes) -> bytes | None:
    """The segment APP1 that begins with Exif, before the coded picture."""
    at = 2
    while data[at] == 0xFF and data[at + 1] != 0xDA:
        (length,) = struct.unpack(">H", data[at + 2 : at + 4])
        if data[at + 1] == 0xE1 and data[at + 4 : at + 10] == b"Exif\0\0":
            return data[at + 10 : at + 2 + length]
        at += 2 + length
    return None
