"""Leaving results on disk: whole or not at all."""

import csv
import json
import math
import os
import platform
import secrets
import shutil
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from insectnav import __version__
from insectnav.checks import InputError, quoted

PROVENANCE = "provenance.json"  # in every folder of results
ONE_CHUNK = 2**25  # [byte] smaller arrays are not divided
RESULTS = frozenset(  # a folder of these and nothing else may be replaced
    {PROVENANCE, "figure.png", "figure.pdf", "caption.txt", "table.csv", "comparison.csv", "summary.json", "data.zarr"}
)
PROVEN_RESULTS = frozenset(  # with provenance beside them alone: of masks, of places
    {"masks", "overlays", "methods.csv", "tests.csv", "matches.csv", "page.html", "figures"}
)


@contextmanager
def results_folder(destination: str | os.PathLike[str], option: str = "--out") -> Iterator[Path]:
    """A temporary folder beside the destination, renamed to it when the block ends well and removed when it does not.

    Parameters
    ----------
    destination : folder
    option : by which the user named it

    Raises
    ------
    InputError
        If the destination cannot be written, is a file, or holds other things than earlier results.
    """
    check_destination(destination, option)
    final = Path(os.path.realpath(destination))  # a link stays, and what it points to is replaced
    temporary = final.with_name(f".{final.name}.{secrets.token_hex(4)}.part")
    new_parents = [parent for parent in final.parents if not parent.exists()]
    try:
        with written_to(destination, option):
            temporary.mkdir(parents=True)
        yield temporary
        with written_to(destination, option):
            replace_folder(final, temporary)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        for parent in new_parents:
            with suppress(OSError):
                parent.rmdir()  # only where it is empty


def check_destination(destination: str | os.PathLike[str], option: str = "--out") -> None:
    """Refuse, before any work is done, a destination that results could not be moved to.

    Parameters
    ----------
    destination : folder
    option : by which the user named it

    Raises
    ------
    InputError
        If the destination is no name, is a file, cannot be written, or holds other things than earlier results.
    """
    check_not_empty(destination, option)
    final = Path(os.path.realpath(destination))
    shown = f"{option} {quoted(destination, limit=200)}"
    with written_to(destination, option):
        if final.exists() and not final.is_dir():
            raise InputError(f"{shown} is a file, expected a folder or a new name")
        there = {item.name for item in final.iterdir()} if final.is_dir() else set()
        others = there - RESULTS - (PROVEN_RESULTS if PROVENANCE in there else set())
        if others:
            example = quoted(min(others))
            raise InputError(
                f"{shown} holds other files, such as {example}, expected a new name or a folder of results alone"
            )
        check_room(final, shown)


def check_not_empty(destination: str | os.PathLike[str], option: str = "--out") -> None:
    """Refuse a name without a letter, which the system would take for the present folder.

    Parameters
    ----------
    destination : as the user named it
    option : by which

    Raises
    ------
    InputError
        If it is empty.
    """
    if not os.fspath(destination):
        raise InputError(f"{option} is an empty name, expected a folder or '.': a variable that is not set?")


def check_room(place: Path, shown: str) -> None:
    """Refuse, before any work is done, a place for a file or folder in whose folder nothing can be made.

    Parameters
    ----------
    place : of which the folder, and those above it, need not exist
    shown : how a sentence begins that names it

    Raises
    ------
    InputError
        If a file is in the way, or the folder may not be written: found out by making a folder in it, since neither a
        disk that is only read nor what a system keeps under /proc shows in the rights.
    OSError
        If the place cannot be looked at.
    """
    existing = place.parent
    while not existing.exists():
        existing = existing.parent
    if not existing.is_dir():
        raise InputError(f"{shown} cannot be written, since {quoted(existing, 200)} is a file, expected a folder")
    probe = existing / f".insectnav-{secrets.token_hex(4)}"
    try:
        probe.mkdir()
    except OSError as error:
        raise InputError(
            f"{shown} cannot be written ({error.strerror}), expected a place where you may make files and folders"
        ) from None
    finally:
        with suppress(OSError):
            probe.rmdir()


@contextmanager
def written_to(destination: str | os.PathLike[str], option: str = "--out") -> Iterator[None]:
    """Context in which what the system refuses to write becomes one sentence about the destination.

    Parameters
    ----------
    destination : file or folder
    option : by which the user named it

    Raises
    ------
    InputError
        If the disk is full, say, or the place may not be written.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"{option} {quoted(destination, limit=200)} cannot be written ({error.strerror})") from None


def replace_folder(final: Path, temporary: Path) -> None:
    """Rename to the final name; what is there is renamed first, and comes back if that fails."""
    old = temporary.with_suffix(".old")  # may be there from a process that was killed between two renames
    if not final.exists():
        temporary.rename(final)
    elif final == Path.cwd():
        _refill(final, temporary, old)
    else:
        shutil.rmtree(old, ignore_errors=True)
        final.rename(old)
        try:
            temporary.rename(final)
        except OSError:
            old.rename(final)
            raise
    shutil.rmtree(old, ignore_errors=True)


def _refill(final: Path, temporary: Path, old: Path) -> None:
    """Exchange the contents of the folder the user stands in, which a new folder of the same name would leave empty.

    Provenance comes last: a folder without it is no result.
    """
    shutil.rmtree(old, ignore_errors=True)
    old.mkdir()
    for item in list(final.iterdir()):
        item.rename(old / item.name)
    for item in sorted(temporary.iterdir(), key=lambda item: item.name == PROVENANCE):
        item.rename(final / item.name)
    temporary.rmdir()


def to_json(value: Any) -> str:
    """Strict JSON, indented: NumPy numbers as numbers, NaN and infinity as null, names that are no UTF-8 escaped."""
    text = json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def plain(value: Any) -> Any:
    """The same as what JSON knows: lists, text, numbers; NaN and infinity as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def write_table(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> None:
    """Rows with the same keys as CSV; numbers with six significant digits, NaN as an empty cell.

    Where there may be no rows, ``columns`` says what they would have had.

    Raises
    ------
    ValueError
        If there are neither rows nor columns, or a row has other keys than the first.
    """
    if not rows and columns is None:
        raise ValueError(f"{path.name} would be empty, expected rows")
    expected = set(columns or rows[0])
    for number, row in enumerate(rows):
        if set(row) != expected:
            raise ValueError(f"row {number} of {path.name} lacks or adds {', '.join(sorted(expected ^ set(row)))}")
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(columns or rows[0]))
        writer.writeheader()
        for row in rows:
            writer.writerow({key: _cell(value) for key, value in row.items()})


def _cell(value: Any) -> Any:
    if isinstance(value, float | np.floating):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return value


def write_arrays(path: Path, arrays: Mapping[str, tuple], attributes: Mapping[str, Any]) -> None:
    """Named arrays with named dimensions as a zarr group that ``xarray.open_zarr`` reads.

    Parameters
    ----------
    path : Path
    arrays : name -> (dimensions, array) or (dimensions, array, attributes)
    attributes : of the group
    """
    import zarr

    group = zarr.create_group(path, attributes=plain(attributes))
    for name, (dimensions, values, *own_attributes) in arrays.items():
        values = np.asarray(values)
        attrs = plain(own_attributes[0]) if own_attributes else None
        chunks = chunk_shape(values.shape, values.dtype.itemsize)
        group.create_array(name, data=values, chunks=chunks, dimension_names=dimensions, attributes=attrs)
    consolidate(group)


def chunk_shape(shape: Sequence[int], itemsize: int) -> tuple[int, ...]:
    """Shape of the chunks of an array: all of it, or leading axes divided so that none is larger than ONE_CHUNK."""
    chunks = [max(1, length) for length in shape]
    for axis, length in enumerate(chunks):
        chunks[axis] = max(1, min(length, ONE_CHUNK // (itemsize * math.prod(chunks[axis + 1 :]))))
    return tuple(chunks)


def consolidate(group: Any) -> None:
    """Gather the metadata of a complete zarr group in one place, where xarray looks for it."""
    import zarr

    with warnings.catch_warnings():  # that the format of consolidated metadata may still change
        warnings.simplefilter("ignore", UserWarning)
        zarr.consolidate_metadata(group.store)


def provenance(seconds: float) -> dict[str, Any]:
    """What a result was made with: versions, machine, command, when it was finished and the seconds it took."""
    packages = ("numpy", "numba", "scipy", "xarray", "zarr", "matplotlib")
    return {
        "insectnav": __version__,
        "python": platform.python_version(),
        "packages": {package: version(package) for package in packages},
        "machine": {"system": platform.system(), "processor": platform.machine(), "cores": os.cpu_count()},
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "seconds": round(seconds, 3),
    }
