"""What an experimenter does to the circuit during a trial, as data."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from insectnav.central_complex.layers import N_CELLS, POPULATIONS_WITH_RATE, ROW
from insectnav.checks import InputError, check_choice, check_count, check_range


@dataclass(frozen=True, kw_only=True)
class ClampCells:
    """Hold cells at a rate, whatever their input: 1 for an injected current, 0 for silenced or lost cells.

    Parameters
    ----------
    population : str
        "tl", "cl1", "tb1", "tn1", "tn2", "cpu4", "pontine" or "cpu1".
    cells : sequence of int, optional
        Indices within the population; all of them by default.
    rate : float
        From 0 to 1.
    first_step, end_step : int
        Steps of the trial, from ``first_step`` up to but not including ``end_step``; to the end by default.

    Raises
    ------
    InputError
        If the population, a cell, the rate or the interval does not exist.

    Notes
    -----
    Stone et al. 2017, Extended Data Fig. 10a–c: output of chosen cells set to 1 for 200 steps.
    """

    population: str
    cells: Sequence[int] | None = None
    rate: float
    first_step: int = 0
    end_step: int | None = None

    def __post_init__(self) -> None:
        check_choice("population to clamp", self.population, POPULATIONS_WITH_RATE)
        check_range("clamped rate", self.rate, 0.0, 1.0)
        check_count("first_step", self.first_step, minimum=0)
        if self.end_step is not None:
            check_count("end_step", self.end_step, minimum=self.first_step)
        if self.cells is not None:
            if not isinstance(self.cells, Sequence | range) or isinstance(self.cells, str):
                raise InputError(f"cells of {self.population} are {self.cells!r}, expected some as in (3, 4)")
            object.__setattr__(self, "cells", tuple(self.cells))
        for cell in self.cells or ():
            check_count(f"cell of {self.population}", cell, minimum=0)
            check_range(f"cell of {self.population}", cell, 0, N_CELLS[self.population] - 1)


class Clamps(NamedTuple):
    """Clamps of single cells in the form that compiled kernels read; of two on one cell, the later counts."""

    first_step: NDArray[np.int64]
    end_step: NDArray[np.int64]
    row: NDArray[np.int64]
    rate: NDArray[np.floating]


def pack_clamps(perturbations: Sequence[ClampCells], dtype: DTypeLike) -> Clamps:
    """One entry for each clamped cell."""
    if not isinstance(perturbations, Sequence):
        raise InputError(f"perturbations are a {type(perturbations).__name__}, expected a list of ClampCells")
    first_step, end_step, row, rate = [], [], [], []
    for clamp in perturbations:
        if not isinstance(clamp, ClampCells):
            raise InputError(f"perturbations hold a {type(clamp).__name__}, expected ClampCells")
        for cell in range(N_CELLS[clamp.population]) if clamp.cells is None else clamp.cells:
            first_step.append(clamp.first_step)
            end_step.append(np.iinfo(np.int64).max if clamp.end_step is None else clamp.end_step)
            row.append(ROW[clamp.population] + cell)
            rate.append(clamp.rate)
    return Clamps(
        first_step=np.array(first_step, np.int64),
        end_step=np.array(end_step, np.int64),
        row=np.array(row, np.int64),
        rate=np.array(rate, dtype),
    )
