"""Arrays on disk in the format of zarr, in folders that appear whole or not at all: of maps of places, and of FAB-MAP.

A folder of arrays holds one file for each, uncompressed, which is mapped into memory. Arrays of others are data: their
description must be one that this module writes, and the file must have just the size that it says.
"""

import fcntl
import hashlib
import json
import math
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted

LOCK_FILE = "lock"
SYNCHRONISED_AT_ONCE = 8
LARGEST_JSON = 2**22  # [byte]
LARGEST_SIZE = 2**40  # along an axis: larger ones are damage, and would not fit into products
IN_MEMORY = 2**20  # [byte] files up to this size are read at once
TYPES = ("bool", "uint8", "int64", "float32", "float64")
Arrays = Mapping[str, tuple[tuple[str, ...], NDArray[Any]]]  # name -> dimensions, values


class DamagedError(InputError):
    """Something in a map is not as it was written."""


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold a map for this writer alone; the system lets go of it however the process ends.

    Raises
    ------
    InputError
        If another writer holds it, or the folder may not be written.
    """
    with written(folder):
        descriptor = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"the map {shown(folder)} is being written by another: wait for it to end") from None
        yield
    finally:
        os.close(descriptor)


@contextmanager
def written(folder: Path, what: str = "map") -> Iterator[None]:
    """Context in which what the system refuses to write becomes one sentence about the map.

    Parameters
    ----------
    folder : Path
    what : the folder holds

    Raises
    ------
    InputError
        If the disk is full, say, or the folder may not be written.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"the {what} {shown(folder)} cannot be written ({error.strerror})") from None


def check_named(folder: Path) -> None:
    """Refuse a folder that is to be made but has no name.

    Raises
    ------
    InputError
        If it is the present one, which an empty name stands for as well.
    """
    if not folder.name:
        raise InputError(f"{shown(folder)} is named, expected the name of a new folder: a variable that is not set?")


@contextmanager
def whole_folder(final: Path) -> Iterator[Path]:
    """A temporary folder beside the final one, which is on disk and renamed when the block has ended well."""
    check_named(final)
    temporary = final.with_name(f".{final.name}.{secrets.token_hex(4)}.partial")
    try:
        temporary.mkdir(parents=True)
        yield temporary
        # All at once: a system that waits for its disk then waits once.
        with ThreadPoolExecutor(SYNCHRONISED_AT_ONCE) as pool:
            list(pool.map(synchronise, [temporary, *temporary.rglob("*")]))
        temporary.rename(final)
        synchronise(final.parent)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def remove_partial(folder: Path) -> None:
    """Drop what a process that was killed has left; only the one writer may."""
    for path in folder.glob(".*.partial"):
        shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)


def synchronise(path: Path) -> None:
    """Have the system put a file or a folder on disk before going on."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_json(path: Path, record: Mapping[str, Any]) -> None:
    """Strict JSON under a temporary name, on disk, then renamed."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        temporary.write_text(json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False), encoding="utf-8")
        synchronise(temporary)
        temporary.replace(path)
        synchronise(path.parent)
    finally:
        temporary.unlink(missing_ok=True)


def read_json(path: Path) -> dict[str, Any]:
    """The record in a small file.

    Raises
    ------
    DamagedError
        If there is none.
    FileNotFoundError
        If there is no such file.
    """
    try:
        if path.stat().st_size > LARGEST_JSON:
            raise DamagedError(f"{shown(path)} is larger than {LARGEST_JSON} bytes")
        record = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        raise DamagedError(f"{shown(path)} is no JSON") from None
    if not isinstance(record, dict):
        raise DamagedError(f"{shown(path)} holds no record")
    return record


def write_arrays(folder: Path, arrays: Arrays) -> None:
    """Each array as one chunk of a zarr group, uncompressed."""
    folder.mkdir(exist_ok=True)
    group = {"attributes": {}, "zarr_format": 3, "node_type": "group"}
    (folder / "zarr.json").write_text(json.dumps(group, indent=2), encoding="utf-8")
    for name, (dimensions, values) in arrays.items():
        about = _description(list(values.shape), values.dtype.name, dimensions)
        chunk = chunk_file(folder / name, values.ndim)
        chunk.parent.mkdir()
        (folder / name / "zarr.json").write_text(json.dumps(about, indent=2), encoding="utf-8")
        if values.size:
            with chunk.open("wb") as file:  # `tofile` does not say why the system refuses
                file.write(np.ascontiguousarray(values, values.dtype.newbyteorder("<")).data)


def chunk_file(array: Path, n_axes: int) -> Path:
    """Where the only chunk of an array lies."""
    return array / ".".join(["c", *("0" * n_axes)])


def arrays_digest(folder: Path, names: Mapping[str, tuple[str, ...]]) -> str:
    """A number that changes if any of the arrays does, by SHA-256.

    Parameters
    ----------
    folder : Path
    names : name -> dimensions, of the arrays in their order
    """
    digest = hashlib.sha256()
    for name, dimensions in names.items():
        with chunk_file(folder / name, len(dimensions)).open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()


def read_arrays(folder: Path, expected: Mapping[str, tuple[str, ...]]) -> dict[str, NDArray[Any]]:
    """Arrays by name, those of more than a megabyte mapped from disk.

    Parameters
    ----------
    folder : Path
    expected : name -> dimensions; a size that stands for one dimension must be the same everywhere

    Raises
    ------
    DamagedError
        If one is missing, has other dimensions, or its file another size than is said.
    """
    sizes: dict[str, int] = {}
    found = {}
    for name, dimensions in expected.items():
        found[name] = values = read_array(folder / name, dimensions)
        for dimension, size in zip(dimensions, values.shape, strict=True):
            if sizes.setdefault(dimension, size) != size:
                raise DamagedError(
                    f"{shown(folder / name)} has {size} along {dimension!r}, expected {sizes[dimension]}"
                )
    return found


def read_array(folder: Path, dimensions: tuple[str, ...]) -> NDArray[Any]:
    """The only chunk of an array, as its description says and not a byte more or less.

    Raises
    ------
    DamagedError
        If it is not so.
    """
    try:
        about = read_json(folder / "zarr.json")
    except OSError:
        raise DamagedError(f"the array {shown(folder)} is missing") from None
    shape, kind = cast(Any, about.get("shape")), cast(Any, about.get("data_type"))
    if not _is_shape(shape, len(dimensions)) or kind not in TYPES or about != _description(shape, kind, dimensions):
        raise DamagedError(f"the array {shown(folder)} is not described as an array {dimensions} is")
    dtype = np.dtype(kind).newbyteorder("<")
    if 0 in shape:
        return np.empty(shape, dtype)
    path, size = chunk_file(folder, len(shape)), math.prod(shape) * dtype.itemsize
    there = path.stat().st_size if path.is_file() else 0
    if there != size:
        raise DamagedError(f"the array {shown(folder)} has {there} bytes, expected {size}: cut off?")
    try:
        if size > IN_MEMORY:
            return np.memmap(path, dtype, "r", shape=tuple(shape))
        return np.fromfile(path, dtype).reshape(shape)
    except (OSError, ValueError) as error:
        raise DamagedError(f"the array {shown(folder)} cannot be read ({error})") from None


def _is_shape(shape: object, n_axes: int) -> bool:
    return (
        isinstance(shape, list)
        and len(shape) == n_axes
        and all(type(size) is int and 0 <= size <= LARGEST_SIZE for size in shape)
    )


def _description(shape: list[int], kind: str, dimensions: tuple[str, ...]) -> dict[str, Any]:
    """What the format of zarr (version 3) says about an array of one chunk without compression."""
    codec: dict[str, Any] = {"name": "bytes"}
    if np.dtype(kind).itemsize > 1:
        codec["configuration"] = {"endian": "little"}
    return {
        "shape": shape,
        "data_type": kind,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [max(size, 1) for size in shape]}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": np.zeros((), kind).item(),
        "codecs": [codec],
        "attributes": {},
        "dimension_names": list(dimensions),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }


def shown(path: Path) -> str:
    """A path within a sentence."""
    return quoted(path, 200)
