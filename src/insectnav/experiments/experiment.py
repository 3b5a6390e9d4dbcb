"""What an experiment is: a module with a grid of cells and five functions."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError
from insectnav.experiments.published import Published, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCALES = ("quick", "full")
LARGEST = 2**63 - 1  # whole number that zarr holds
Arrays = Mapping[str, tuple]  # name -> (dimensions, array) or (dimensions, array, attributes)
Table = Sequence[Mapping[str, Any]]  # rows with the same keys


class Experiment(Protocol):
    """One figure or table of a paper, as a module.

    A *cell* is one point of the grid of parameters: a frozen dataclass of numbers, words and truth values alone. Cells
    are simulated apart from each other, in any order and on any machine; what they return has the same names, shapes
    and types for all of them.
    """

    __name__: str
    __file__: str
    __package__: str
    Cell: type[Any]  # what the grid is made of
    FIGURE: str  # "Fig. 5c", or "text"
    TITLE: str  # what is shown, in a line

    def grid(self, scale: str) -> Sequence[Any]:
        """Cells of the "quick" grid, seconds in all, or of the "full" one, of the size that was published."""

    def simulate(self, cell: Any, seed: int) -> Arrays:
        """Results of one cell: named arrays with dimensions and units, the same bits wherever it runs."""

    def summarise(self, results: Results) -> Table:
        """Rows of table.csv."""

    def draw(self, results: Results) -> Figure:
        """The figure, with the axes and conditions of the published one."""

    def caption(self, results: Results) -> str:
        """What the figure shows, with numbers of trials and conditions, in a few sentences."""

    def compare(self, table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
        """Each published quantity beside ours; ``published`` holds those of this experiment."""


@dataclass(frozen=True, eq=False)
class Results:
    """What all cells returned, stacked.

    Parameters
    ----------
    cells : sequence of cells
    arrays : name -> (cell, ...) array
    """

    cells: Sequence[Any]
    arrays: Mapping[str, NDArray[Any]]

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.arrays[name]

    def where(self, **wanted: Any) -> NDArray[np.int64]:
        """Indices of the cells whose parameters have the wanted values, in the order of the grid."""
        found = [i for i, cell in enumerate(self.cells) if all(getattr(cell, k) == v for k, v in wanted.items())]
        return np.array(found, np.int64)

    def only(self, **wanted: Any) -> int:
        """Index of the one cell whose parameters have the wanted values.

        Raises
        ------
        LookupError
            If none or several have.
        """
        found = self.where(**wanted)
        if len(found) != 1:
            raise LookupError(f"{len(found)} cells have {wanted}, expected one")
        return int(found[0])

    def by(self, name: str) -> dict[Any, NDArray[np.int64]]:
        """Indices of the cells with each value of a parameter, in the order of the grid."""
        return {value: self.where(**{name: value}) for value in dict.fromkeys(getattr(c, name) for c in self.cells)}

    def __iter__(self) -> Iterator[tuple[Any, dict[str, NDArray[Any]]]]:
        """Each cell with its own arrays."""
        for i, cell in enumerate(self.cells):
            yield cell, {name: values[i] for name, values in self.arrays.items()}


def check_grid(cells: Sequence[Any]) -> None:
    """Refuse cells that could not be told apart, stored or sent to another machine.

    Raises
    ------
    InputError
        If there is no cell, two are equal, they are not of one frozen dataclass, or a parameter is anything but
        numbers, or words, or truth values, in all cells alike.
    """
    if not cells:
        raise InputError("the grid is empty, expected at least one cell")
    kind = type(cells[0])
    if not is_dataclass(kind) or kind.__hash__ is None or any(type(cell) is not kind for cell in cells):
        raise InputError("the grid holds other things than cells, expected instances of one frozen dataclass")
    for field in fields(kind):
        _check_parameter(field.name, [getattr(cell, field.name) for cell in cells])
    for cell, times in Counter(cells).items():
        if times > 1:
            raise InputError(f"{times} cells of the grid are equal ({cell_text(cell)}), expected all to differ")


def _check_parameter(name: str, values: Sequence[Any]) -> None:
    """Refuse what zarr could not hold as one array of cells, or what is not equal to itself."""
    if name == "cell":
        raise InputError("a cell parameter is called 'cell', expected another name: that is the dimension of the cells")
    for value in values:
        if not isinstance(value, bool | int | float | str):
            raise InputError(f"cell parameter {name} is a {type(value).__name__}, expected a number or a word")
        if value != value or (isinstance(value, int) and abs(value) > LARGEST):
            raise InputError(f"cell parameter {name} is {value}, expected a number of at most 63 bits")
    words = {str if isinstance(value, str) else bool if isinstance(value, bool) else float for value in values}
    if len(words) > 1:
        raise InputError(f"cell parameter {name} is a word in one cell and a number in another, expected one kind")


def cell_text(cell: Any) -> str:
    """The parameters of a cell for a message: ``preset='thesis', noise=0.1``."""
    return ", ".join(f"{name}={value!r}" for name, value in asdict(cell).items())


def paper_of(experiment: Experiment) -> str:
    """The paper that an experiment is from, as the folder of its module says; a module on its own is from none."""
    package = vars(import_module(experiment.__package__)) if experiment.__package__ else {}
    return str(package.get("PAPER", "none"))


@lru_cache(maxsize=1)
def code_version() -> str:
    """A name for this exact text of the package: results of another are not mixed with those of this one."""
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*")):
        if path.suffix in {".py", ".csv"} and path.is_file():
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


def results_key(experiment: Experiment, cells: Sequence[Any], seed: int) -> str:
    """Name of the folder of these results: it follows from the cells, the seed and the version of the code."""
    content = [experiment.__name__, int(seed), code_version(), [asdict(cell) for cell in cells]]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:12]
