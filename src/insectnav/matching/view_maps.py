"""Views as maps on the faces of a cube, in which any direction is looked up by a division and four neighbours.

Each node of a map is a Gaussian mean of the view about it, over what was seen alone; where less than half of it was
seen the node is NaN. Values outside the mask therefore enter nowhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError
from insectnav.vision.sphere import Reals, SphereGrid

Singles = NDArray[np.float32]
Bools = NDArray[np.bool_]
LEAST_COVERAGE = 0.5  # of a node's Gaussian, below which it is not seen
_REACH_IN_SIGMA = 2.5  # where the Gaussian is cut, at 4 % of its height
_CELL_IN_SIGMA = 1.5  # width of the cells in the middle of a face, where they are widest
_MOST_SPACING_IN_SIGMA = 1.6  # of the grid; the sum over a square grid is then within 1.5 % of the integral


@dataclass(frozen=True, kw_only=True, eq=False)
class Blur:
    """From values on a grid to the nodes of a cube, by rows of a sparse matrix; made by `blur_to_cube`.

    Parameters
    ----------
    n_cells : cells along the side of a face
    starts : (node + 1,) where the row of each node begins
    columns : (entry,) directions of the grid
    weights : (entry,) solid angle times Gaussian, over the integral of the Gaussian: a node seen in full adds up to 1
    """

    n_cells: int
    starts: NDArray[np.int64]
    columns: NDArray[np.int32]
    weights: Singles

    @property
    def n_nodes(self) -> int:
        """Number of nodes of a map."""
        return len(self.starts) - 1

    def __call__(self, values: Singles, seen: Bools) -> Singles:
        """Maps (view, node) of values (view, direction), NaN where ``seen`` (view, direction) leaves too little."""
        from insectnav.matching.rotation_kernel import blur_views

        maps = np.empty((len(values), self.n_nodes), np.float32)
        blur_views(self.starts, self.columns, self.weights, values, seen, LEAST_COVERAGE, maps)
        return maps


def cube_nodes(n_cells: int) -> Reals:
    """Directions of the nodes (node, 3): face by face, +x −x +y −y +z −z, with a margin of half a cell.

    The nodes of a face are the middles of its cells and those of one more row all round, so that every place of the
    face lies between four of its own nodes.
    """
    along = (np.arange(n_cells + 2) - 0.5) * 2.0 / n_cells - 1.0
    u, v = np.meshgrid(along, along, indexing="ij")
    faces = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            face = np.empty((*u.shape, 3))
            face[..., axis], face[..., (axis + 1) % 3], face[..., (axis + 2) % 3] = sign, u, v
            faces.append(face.reshape(-1, 3))
    nodes = np.concatenate(faces)
    return nodes / np.linalg.norm(nodes, axis=-1, keepdims=True)


def blur_to_cube(grid: SphereGrid, sigma: float, name: str) -> Blur:
    """Blur of a grid by a Gaussian of standard deviation ``sigma`` [rad], onto nodes at most 1.5 sigma apart.

    Raises
    ------
    InputError
        If the grid is too coarse for the Gaussian.

    Notes
    -----
    The Gaussian is exp(−c²/2σ²) of the chord c, the von Mises-Fisher density: its integral over a cap is 2πσ² (1 −
    exp(−c²/2σ²)), c the chord of the cap's radius.
    """
    from scipy.spatial import cKDTree

    if grid.spacing > _MOST_SPACING_IN_SIGMA * sigma:
        raise InputError(
            f"the directions of {grid.name} are {np.rad2deg(grid.spacing):.3g}° apart, expected at most "
            f"{_MOST_SPACING_IN_SIGMA} times {name}, which is {np.rad2deg(sigma):.3g}°: a larger {name}?"
        )
    n_cells = int(np.ceil(2.0 / (_CELL_IN_SIGMA * sigma)))
    nodes = cube_nodes(n_cells)
    reach = _REACH_IN_SIGMA * sigma
    pairs = cKDTree(nodes).sparse_distance_matrix(cKDTree(grid.directions), reach, output_type="ndarray")
    order = np.lexsort((pairs["j"], pairs["i"]))
    row, column, chord = pairs["i"][order], pairs["j"][order], pairs["v"][order]
    integral = 2.0 * np.pi * sigma**2 * -np.expm1(-(reach**2) / (2.0 * sigma**2))
    weights = grid.weights[column] * np.exp(-(chord**2) / (2.0 * sigma**2)) / integral
    starts = np.searchsorted(row, np.arange(len(nodes) + 1))
    return Blur(n_cells=n_cells, starts=starts, columns=column.astype(np.int32), weights=weights.astype(np.float32))


def look_up(maps: Singles, n_cells: int, directions: Reals) -> Singles:
    """Values (map, ...) of maps (map, node) along directions (..., 3); NaN where one of four neighbours is not seen."""
    from insectnav.matching.rotation_kernel import look_up_all

    vectors = np.ascontiguousarray(directions, np.float32).reshape(-1, 3)
    values = np.empty((len(maps), len(vectors)), np.float32)
    look_up_all(maps, n_cells, vectors, values)
    return values.reshape(len(maps), *np.shape(directions)[:-1])
