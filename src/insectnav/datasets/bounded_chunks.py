"""Compressed parts of bags: those that are unpacked stay within bounds, others are refused."""

import bz2
from collections.abc import Callable
from pathlib import Path
from typing import Any

from insectnav.checks import InputError

MAX_CHUNK = 2**30  # bytes, unpacked; ROS writes 768 kB, or one message if that is larger
MAX_METADATA = 16 * 2**20  # bytes


def bound_chunks(reader: Any) -> None:
    """Let an open reader of ROS 1 unpack no chunk beyond bounds.

    Parameters
    ----------
    reader : rosbags.rosbag1.Reader
        Its chunks name their functions that unpack them, of which those of rosbags know no bound.
    """
    from rosbags.rosbag1.reader import decompressors

    bounded = {decompressors["bz2"]: _unpack_bz2, decompressors["lz4"]: _unpack_lz4}
    for position, chunk in reader.chunks.items():
        reader.chunks[position] = chunk._replace(decompressor=bounded.get(chunk.decompressor, chunk.decompressor))


def refuse_compression(path: Path, name: str) -> None:
    """Refuse a folder of ROS 2 whose files or messages are compressed as such, for which rosbags knows no bound.

    Parameters
    ----------
    path : of the folder, or of a file, of which nothing is known
    name : what to call it in a sentence
    """
    about = path / "metadata.yaml"
    if not path.is_dir() or not about.is_file():
        return
    if about.stat().st_size > MAX_METADATA:
        raise InputError(f"metadata.yaml of {name} is larger than {MAX_METADATA} bytes, expected a list of topics")
    for line in about.read_text(encoding="utf-8", errors="replace").splitlines():
        key, _, value = line.strip().partition(":")
        if key.strip("\"' ") == "compression_mode" and value.strip("\"' ").lower() not in ("", "none"):
            raise InputError(
                f"{name} is compressed by {value.strip().lower()}, expected a bag that is not: ros2 bag convert does it"
            )


def _unpack_bz2(data: bytes) -> bytes:
    return _within(bz2.BZ2Decompressor().decompress, data)


def _unpack_lz4(data: bytes) -> bytes:
    from lz4.frame import LZ4FrameDecompressor

    return _within(LZ4FrameDecompressor().decompress, data)


def _within(unpack: Callable[[bytes, int], bytes], data: bytes) -> bytes:
    unpacked = unpack(data, MAX_CHUNK + 1)
    if len(unpacked) > MAX_CHUNK:
        raise InputError(f"a chunk of the bag unpacks to more than {MAX_CHUNK // 2**20} MB, expected less: damaged?")
    return unpacked
