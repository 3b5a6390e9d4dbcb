"""Compressed parts of bags are unpacked within bounds: chunks of ROS 1, files and messages of ROS 2."""

import bz2
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any

from insectnav.checks import InputError, quoted

MAX_CHUNK = 2**30  # bytes, unpacked; ROS writes 768 kB, or one message if that is larger
MAX_METADATA = 16 * 2**20  # bytes
MAX_UNPACKED = 2**38  # bytes of the files of a folder; an hour of raw pictures, 1.2 MB thirty times a second, has half
PIECE = 2**20  # bytes that are unpacked at a time
METADATA = "metadata.yaml"


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


@contextmanager
def unpacked_folder(path: Path, name: str) -> Iterator[Path]:
    """The folder of a bag of ROS 2, or a temporary one with its files unpacked, if they are compressed as a whole.

    Parameters
    ----------
    path : of the folder, or of a file, of which nothing is known
    name : what to call it in a sentence

    Raises
    ------
    InputError
        If it is compressed in another way than by zstd, or unpacks to too much.
    """
    about = path / METADATA
    if not path.is_dir() or not about.is_file():
        yield path
        return
    if about.stat().st_size > MAX_METADATA:
        raise InputError(f"{METADATA} of {name} is larger than {MAX_METADATA} bytes, expected a list of topics")
    from ruamel.yaml import YAML

    words = YAML(typ="safe").load(about.read_text(encoding="utf-8"))
    bag = words.get("rosbag2_bagfile_information") if isinstance(words, dict) else None
    mode = str(bag.get("compression_mode") or "none").lower() if isinstance(bag, dict) else "none"
    if not isinstance(bag, dict) or mode == "none":
        yield path
        return
    if mode not in ("file", "message") or bag.get("compression_format") != "zstd":
        kind = quoted(bag.get("compression_format"))
        raise InputError(
            f"{name} is compressed by {kind}, expected zstd, of files or messages: ros2 bag convert unpacks it"
        )
    if mode == "message":
        yield path
        return
    with TemporaryDirectory(prefix="insectnav-") as temporary:
        folder = Path(temporary)
        packed = [path / PurePath(str(one)).name for one in bag["relative_file_paths"]]
        files = [folder / f"{number}-{one.stem}" for number, one in enumerate(packed)]
        _unpack_files(packed, files, name)
        bag |= {"relative_file_paths": [one.name for one in files], "compression_mode": "", "compression_format": ""}
        with (folder / METADATA).open("w", encoding="utf-8") as file:
            YAML(typ="safe").dump(words, file)
        yield folder


def _unpack_files(packed: Sequence[Path], files: Sequence[Path], name: str) -> None:
    """Unpack files one after the other, as long as there is room."""
    zstd = _zstd()
    room = min(MAX_UNPACKED, shutil.disk_usage(files[0].parent).free // 2 if files else 0)
    for source, target in zip(packed, files, strict=True):
        with zstd.open(source, "rb") as reading, target.open("wb") as writing:
            while piece := reading.read(PIECE):
                room -= len(piece)
                if room < 0:
                    raise InputError(
                        f"{name} unpacks to more than there is room for (half of the disk for temporary "
                        f"files, {MAX_UNPACKED / 2**30:.0f} GB at most): unpack it by ros2 bag convert"
                    )
                writing.write(piece)


def unpacker_of_messages(reader: Any) -> Callable[[bytes], bytes]:
    """What unpacks a message of an open reader of ROS 2 within bounds, which the reader then leaves as it is.

    Parameters
    ----------
    reader : rosbags.rosbag2.Reader
        Of a folder whose messages are compressed it would unpack them without a bound.
    """
    if getattr(reader.storage.metadata, "compression_mode", None) != "message":
        return bytes
    reader.storage.metadata = reader.storage.metadata._replace(compression_mode=None)
    return _unpack_message


def _unpack_message(data: bytes) -> bytes:
    decompressor = _zstd().ZstdDecompressor()
    unpacked = decompressor.decompress(data, MAX_CHUNK + 1)
    if len(unpacked) > MAX_CHUNK:
        raise InputError(f"unpacks to more than {MAX_CHUNK // 2**20} MB, expected less: damaged?")
    if not decompressor.eof:
        raise InputError("is compressed and ends before it should: damaged?")
    return bytes(unpacked)


def _zstd() -> Any:
    """What rosbags unpacks by: of Python from 3.14 on, before that of its own backport."""
    return import_module("compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd")


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
