"""All synapses of the circuit, each matrix from its rule."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from insectnav.central_complex.layers import N_CELLS
from insectnav.checks import check_finite, check_shape

DIRECTIONS = np.arange(8) * (np.pi / 4.0)  # [rad] preferred heading of column i


PROJECTIONS = {  # name: (receiving population, sending population), in the order in which a step uses them
    "tl_to_cl1": ("cl1", "tl"),
    "cl1_to_tb1": ("tb1", "cl1"),
    "tb1_to_tb1": ("tb1", "tb1"),
    "tn_to_cpu4": ("cpu4", "tn2"),
    "tb1_to_cpu4": ("cpu4", "tb1"),
    "cpu4_to_pontine": ("pontine", "cpu4"),
    "cpu4_to_cpu1": ("cpu1", "cpu4"),
    "pontine_to_cpu1": ("cpu1", "pontine"),
    "tb1_to_cpu1": ("cpu1", "tb1"),
    "cpu1_to_motor": ("motor", "cpu1"),
}


def _one_to_one(source_of_target: NDArray[np.integer], n_sources: int) -> NDArray[np.float64]:
    matrix = np.zeros((len(source_of_target), n_sources))
    matrix[np.arange(len(source_of_target)), source_of_target] = 1.0
    return matrix


def _cl1_to_tb1() -> NDArray[np.float64]:
    """TB1 i listens to CL1 i and i + 8: the same direction in both hemispheres."""
    return np.tile(np.eye(8), 2)


def _tb1_to_tb1() -> NDArray[np.float64]:
    """TB1 cells inhibit each other the more, the more their directions differ: w_ij = (1 − cos(d_i − d_j)) / 2."""
    return (1.0 - np.cos(DIRECTIONS[:, None] - DIRECTIONS[None, :])) / 2.0


def _tn_to_cpu4() -> NDArray[np.float64]:
    """One noduli cell of each kind charges the eight CPU4 columns of its side."""
    return np.repeat(np.eye(2), 8, axis=0)


def _tb1_to_columns() -> NDArray[np.float64]:
    """TB1 i inhibits CPU4 i and i + 8, and CPU1 i and i + 8."""
    return np.tile(np.eye(8), (2, 1))


def _cpu4_to_cpu1() -> NDArray[np.float64]:
    """Steering cells read the memory of the other side, displaced by one column: Fig. 4g."""
    column = np.arange(8)
    return _one_to_one(np.concatenate([8 + (column - 1) % 8, (column + 1) % 8]), 16)


def _pontine_to_cpu1() -> NDArray[np.float64]:
    """Pontine cells bring the opposite column of the memory that excites the same steering cell: Ext. Data Fig. 5e."""
    column = np.arange(8)
    return _one_to_one(np.concatenate([8 + (column + 3) % 8, (column + 5) % 8]), 16)


def _cpu1_to_motor() -> NDArray[np.float64]:
    """The first eight steering cells turn the body to the right (row 0), the others to the left (row 1)."""
    return np.repeat(np.eye(2), 8, axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Connectivity:
    """Connection matrices, (target, source). Sign and strength of each projection stand in `CircuitParams`.

    Replace one to change the wiring: ``replace(params, connectivity=replace(params.connectivity, cpu4_to_cpu1=...))``.
    Any number of synapses of any weight may arrive at a cell.

    Raises
    ------
    InputError
        If a matrix has another shape or holds a NaN or an infinity.

    Notes
    -----
    Stone et al. 2017, Fig. 4 and Extended Data Fig. 6b (thesis), doi 10.1016/j.cub.2017.08.052, and the matrices of the
    authors' 2017 code. CPU1 cells 0…15 are, in the anatomical naming, CPU1b 2, CPU1a 1…14, CPU1b 1.
    """

    tl_to_cl1: NDArray[np.float64] = field(default_factory=lambda: np.eye(16))
    cl1_to_tb1: NDArray[np.float64] = field(default_factory=_cl1_to_tb1)
    tb1_to_tb1: NDArray[np.float64] = field(default_factory=_tb1_to_tb1)
    tn_to_cpu4: NDArray[np.float64] = field(default_factory=_tn_to_cpu4)  # TN1 and TN2 alike
    tb1_to_cpu4: NDArray[np.float64] = field(default_factory=_tb1_to_columns)
    cpu4_to_pontine: NDArray[np.float64] = field(default_factory=lambda: np.eye(16))
    cpu4_to_cpu1: NDArray[np.float64] = field(default_factory=_cpu4_to_cpu1)
    pontine_to_cpu1: NDArray[np.float64] = field(default_factory=_pontine_to_cpu1)
    tb1_to_cpu1: NDArray[np.float64] = field(default_factory=_tb1_to_columns)
    cpu1_to_motor: NDArray[np.float64] = field(default_factory=_cpu1_to_motor)

    def __post_init__(self) -> None:
        for projection, (target, source) in PROJECTIONS.items():
            matrix = np.array(getattr(self, projection), float)
            n_targets = 2 if target == "motor" else N_CELLS[target]
            check_shape(f"connectivity {projection}", matrix, (n_targets, N_CELLS[source]))
            check_finite(f"connectivity {projection}", matrix)
            matrix.flags.writeable = False
            object.__setattr__(self, projection, matrix)


STANDARD_WIRING = Connectivity()
