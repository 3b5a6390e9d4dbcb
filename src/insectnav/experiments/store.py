"""Results of a grid on disk, cell by cell: what is finished stays, whatever happens to the rest."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.experiments.experiment import Arrays, Results, cell_text
from insectnav.experiments.results import chunk_shape, consolidate, plain, written_to

DATA = "data.zarr"
FINISHED = "finished"  # a folder with one empty file for each finished cell


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Hold a file for this process alone; the system lets go of it however the process ends.

    Raises
    ------
    InputError
        If another process holds it.
    """
    while not _is_named(descriptor := os.open(file, os.O_RDWR | os.O_CREAT, 0o666), file):
        os.close(descriptor)
    try:
        yield
    finally:
        file.unlink(missing_ok=True)
        os.close(descriptor)


def _is_named(descriptor: int, file: Path) -> bool:
    """Lock an open file; false if it has lost its name to the end of the run that held it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise InputError(f"{quoted(file.parent, 200)} is being written by another run: wait for it to end") from None
    try:
        return os.path.samestat(os.fstat(descriptor), file.stat())
    except FileNotFoundError:
        return False


class _Layout(NamedTuple):
    """What an array must have in common with that of the same name in all other cells."""

    dtype: np.dtype[Any]
    sizes: dict[str, int]  # of the dimensions, in order
    attributes: dict[str, Any]

    def __str__(self) -> str:
        return f"{self.dtype} {tuple(self.sizes.items())} {self.attributes}"


class CellStore:
    """A zarr group of arrays (cell, ...), each cell in chunks of its own, and a list of the cells that are finished.

    Parameters
    ----------
    folder : Path
        DATA and FINISHED are made in it with the first cell.
    cells : sequence of cells
    about : attributes of the group
    """

    def __init__(self, folder: Path, cells: Sequence[Any], about: Mapping[str, Any]) -> None:
        self.folder, self.cells, self.about = folder, cells, dict(about)
        self._parameters = [field.name for field in fields(cells[0])]
        self._arrays: dict[str, Any] = {}  # open for writing
        self._layouts: dict[str, _Layout] = {}

    def finished(self) -> set[int]:
        """Indices of the cells that are on disk."""
        folder = self.folder / FINISHED
        return {int(path.name) for path in folder.iterdir() if path.name.isdigit()} if folder.is_dir() else set()

    def write(self, index: int, arrays: Arrays) -> None:
        """Put one cell on disk, then note that it is there.

        Raises
        ------
        ValueError
            If its arrays could not be stored, or have other names, dimensions, types or attributes than those before.
        InputError
            If the disk is full, or the folder cannot be written.
        """
        where = f"cell {index + 1} of {len(self.cells)} ({cell_text(self.cells[index])})"
        found = {name: (tuple(given[0]), np.asarray(given[1]), *given[2:]) for name, given in arrays.items()}
        layouts = {name: _layout(f"{name} of {where}", *given) for name, given in found.items()}
        with written_to(self.folder):
            if not self._arrays:
                self._open(layouts, where)
            _compare(layouts, self._layouts, where)
            for name, (_, values, *_attributes) in found.items():
                self._arrays[name][index] = values
            (self.folder / FINISHED).mkdir(exist_ok=True)
            (self.folder / FINISHED / str(index)).touch()

    def _check_names(self, layouts: Mapping[str, _Layout], where: str) -> None:
        """Refuse names that stand for two things."""
        sizes: dict[str, int] = {"cell": len(self.cells)}
        for name, layout in layouts.items():
            for dimension, size in layout.sizes.items():
                if dimension == "cell" or sizes.setdefault(dimension, size) != size:
                    raise ValueError(f"{name} of {where} has {size} along {dimension!r}, which is {sizes[dimension]}")
        # The values along a dimension may have its name: xarray takes them for its coordinate.
        own = {name for name, layout in layouts.items() if name in layout.sizes}
        twice = set(self._parameters) & (set(layouts) | set(sizes)) | set(layouts) & set(sizes) - own
        if twice:
            raise ValueError(
                f"{where} returned {sorted(layouts)} with dimensions {sorted(sizes)}, expected other names than "
                f"{sorted(twice)}: each is an array, a dimension or a parameter"
            )

    def _open(self, layouts: Mapping[str, _Layout], where: str) -> None:
        """Open the group for writing, or make it, from the first cell that comes."""
        import zarr

        # A finished cell has all its chunks, also those that are all zero: +0 and -0 stay what they are.
        with zarr.config.set({"array.write_empty_chunks": True}):
            if self.finished():
                group = zarr.open_group(self.folder / DATA, mode="r+", use_consolidated=False)
            else:
                self._check_names(layouts, where)
                shutil.rmtree(self.folder / DATA, ignore_errors=True)  # of a run that was killed before its first cell
                group = self._create(layouts)
            arrays: dict[str, Any] = dict(group.arrays())
        self._arrays = {name: array for name, array in arrays.items() if name not in self._parameters}
        self._layouts = {
            name: _Layout(
                array.dtype,
                dict(zip(array.metadata.dimension_names[1:], array.shape[1:], strict=True)),
                dict(array.attrs),
            )
            for name, array in self._arrays.items()
        }

    def _create(self, layouts: Mapping[str, _Layout]) -> Any:
        import zarr

        group = zarr.create_group(self.folder / DATA, attributes=plain(self.about))
        for name in self._parameters:
            values = _parameter([getattr(cell, name) for cell in self.cells])
            group.create_array(name, data=values, dimension_names=("cell",))
        for name, (dtype, sizes, attributes) in layouts.items():
            shape = tuple(sizes.values())
            group.create_array(
                name,
                shape=(len(self.cells), *shape),
                chunks=(1, *chunk_shape(shape, dtype.itemsize)),
                dtype=dtype,
                dimension_names=("cell", *sizes),
                attributes=attributes,
            )
        return group

    def read(self) -> Results:
        """All cells, from disk."""
        import zarr

        group: Any = zarr.open_group(self.folder / DATA, mode="r", use_consolidated=False)
        names = [name for name in sorted(group.array_keys()) if name not in self._parameters]
        return Results(self.cells, {name: group[name][...] for name in names})

    def complete(self) -> None:
        """Leave the group as readers want it; the list of finished cells stays until `forget_progress`."""
        import zarr

        with written_to(self.folder):
            for part in (self.folder / DATA).rglob("*.partial"):  # of a process that was killed while it wrote
                part.unlink()
            consolidate(zarr.open_group(self.folder / DATA, use_consolidated=False))

    def forget_progress(self) -> None:
        """Drop the list of finished cells."""
        shutil.rmtree(self.folder / FINISHED, ignore_errors=True)

    def remove_if_empty(self) -> None:
        """Leave nothing behind where no cell is finished."""
        if not self.finished():
            shutil.rmtree(self.folder, ignore_errors=True)


def _layout(name: str, dimensions: tuple[str, ...], values: NDArray[Any], attributes: Any = None) -> _Layout:
    """What must be the same in all cells; refuses what zarr and xarray could not hold."""
    if values.dtype.kind not in "biufc":
        raise ValueError(f"{name} holds {values.dtype.name} values, expected numbers or truth values")
    if len(set(dimensions)) != values.ndim or len(dimensions) != values.ndim:
        raise ValueError(f"{name} has dimensions {dimensions} and shape {values.shape}, expected a name for each axis")
    return _Layout(values.dtype, dict(zip(dimensions, values.shape, strict=True)), plain(attributes or {}))


def _compare(found: Mapping[str, _Layout], expected: Mapping[str, _Layout], where: str) -> None:
    """Refuse a cell that does not fit those before it."""
    if set(found) != set(expected):
        raise ValueError(f"{where} returned {sorted(found)}, expected {sorted(expected)} as from the cells before")
    for name, layout in found.items():
        if layout != expected[name] or list(layout.sizes) != list(expected[name].sizes):
            raise ValueError(f"{name} of {where} is {layout}, expected {expected[name]} as from the cells before")


def _parameter(values: Sequence[Any]) -> NDArray[Any]:
    """A parameter of all cells as an array that zarr can hold."""
    return np.array(values, np.dtypes.StringDType()) if isinstance(values[0], str) else np.array(values)
