"""Results of a grid on disk, cell by cell: what is finished stays, whatever happens to the rest."""

from __future__ import annotations

import fcntl
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.experiments.experiment import Arrays, Results
from insectnav.experiments.results import consolidate, plain

DATA = "data.zarr"
FINISHED = "finished"  # one empty file for each finished cell
LOCK = "lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for this process alone; the system lets go of it however the process ends.

    Raises
    ------
    InputError
        If another process holds it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InputError(f"{quoted(folder, 200)} is being written by another run: wait for it to end") from None
        yield


class CellStore:
    """A zarr group of arrays (cell, ...), one chunk for each cell, and a list of the cells that are finished.

    Parameters
    ----------
    folder : Path
        Exists; DATA and FINISHED are made in it with the first cell.
    cells : sequence of cells
    attributes : of the group
    """

    def __init__(self, folder: Path, cells: Sequence[Any], attributes: Mapping[str, Any]) -> None:
        self._folder, self._cells, self._attributes = folder, cells, attributes
        self._group: Any = None

    def finished(self) -> set[int]:
        """Indices of the cells that are on disk."""
        folder = self._folder / FINISHED
        return {int(path.name) for path in folder.iterdir()} if folder.is_dir() else set()

    def clear(self) -> None:
        """Forget all that was finished."""
        for name in (FINISHED, DATA):
            shutil.rmtree(self._folder / name, ignore_errors=True)

    def write(self, index: int, arrays: Arrays) -> None:
        """Put one cell on disk, then note that it is there."""
        group = self._open(arrays)
        for name, (_, values, *_attributes) in arrays.items():
            if group[name].shape[1:] != np.shape(values):
                raise ValueError(
                    f"{name} of cell {index} has shape {np.shape(values)}, expected {group[name].shape[1:]}"
                )
            group[name][index] = values
        (self._folder / FINISHED).mkdir(exist_ok=True)
        (self._folder / FINISHED / str(index)).touch()

    def _open(self, arrays: Arrays) -> Any:
        """The group, made from the first cell that comes."""
        import zarr

        if self._group is None and self.finished():
            self._group = zarr.open_group(self._folder / DATA, mode="r+")
        elif self._group is None:
            self.clear()  # a run that was killed before its first cell was finished
            self._group = zarr.create_group(self._folder / DATA, attributes=plain(self._attributes))
            for field in fields(self._cells[0]):
                self._group.create_array(field.name, **_parameter([getattr(c, field.name) for c in self._cells]))
            for name, (dimensions, values, *attributes) in arrays.items():
                values = np.asarray(values)
                self._group.create_array(
                    name,
                    shape=(len(self._cells), *values.shape),
                    chunks=(1, *(max(1, n) for n in values.shape)),
                    dtype=values.dtype,
                    dimension_names=("cell", *dimensions),
                    attributes=plain(attributes[0]) if attributes else None,
                )
        return self._group

    def read(self) -> Results:
        """All cells, from disk."""
        import zarr

        group: Any = zarr.open_group(self._folder / DATA, mode="r")
        parameters = {field.name for field in fields(self._cells[0])}
        names = [name for name in sorted(group.array_keys()) if name not in parameters]
        return Results(self._cells, {name: group[name][...] for name in names})

    def seal(self) -> None:
        """Complete the group for readers, and drop the list of finished cells."""
        import zarr

        consolidate(zarr.open_group(self._folder / DATA))
        shutil.rmtree(self._folder / FINISHED, ignore_errors=True)
        (self._folder / LOCK).unlink(missing_ok=True)


def _parameter(values: Sequence[Any]) -> dict[str, Any]:
    """A parameter of all cells as an array that zarr can hold."""
    is_text = isinstance(values[0], str)
    array = np.array(values, np.dtypes.StringDType()) if is_text else np.array(values)
    return {"data": array, "dimension_names": ("cell",)}
