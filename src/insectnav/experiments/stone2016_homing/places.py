"""Where the experiments take place: worlds, the box of 10 m, its grid of views and the twenty reference places."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.datasets.known_worlds import KNOWN_WORLDS, find_world, world_file
from insectnav.homing import catchment_area, distance_from, grid_positions, random_headings, survey
from insectnav.worlds import World, flat_world, load_world, read_mesh, render_panorama

Reals = NDArray[np.floating[Any]]
SIZE = 10.0  # [m] side of the box, thesis section 4.3
# Twenty evenly spaced places (section 4.3): the centres of 5 × 4 equal parts of the box, to the next multiple of 0.2 m,
# so that they are samples of every grid used here. Where in the box they lay is not told.
REFERENCE_X, REFERENCE_Y = (1.0, 3.0, 5.0, 7.0, 9.0), (1.2, 3.8, 6.2, 8.8)  # [m] from the corner
SUCCESS_CELLS = 1.5  # [spacing] radius within which a way has come home; assumed, see stone2016-sampling
HEADINGS = ("aligned", "random")
STAND_IN = "ant-world"
# Lower left corner of the box, x and y [m]: the public views of both files are from x, y = 0…10 m (for the clearing a
# quadrant, not its middle); the clearing of a built world is round the origin.
CORNERS: Mapping[str, float] = {"clearing": 0.0, "seville": 0.0, STAND_IN: -5.0}
NOT_THE_WORLD = (
    "the mesh of the clearing is not part of insectnav and was not found: this ran in the built ant-world in its place"
)


def stage(name: str) -> str:
    """The known world of that name where its file is found, else the built one that stands in for it."""
    return name if find_world(name) is not None else STAND_IN


def stands_in(world: str) -> bool:
    """Whether a world of a cell is none of those that were published."""
    return world not in KNOWN_WORLDS


def place_text(world: str) -> str:
    """What a caption says of the world."""
    if stands_in(world):
        return "Built ant-world, a stand-in: the mesh of the thesis's kind of world was not found."
    return f"World: {KNOWN_WORLDS[world].about}."


@lru_cache(maxsize=2)
def open_world(name: str, seed: int = 0, **parameters: float) -> World:
    """A known world in the grey of the published views, or a built one."""
    if name not in KNOWN_WORLDS:
        return load_world(name, seed=seed, **parameters)
    mesh = read_mesh(world_file(name))
    share = np.float32(KNOWN_WORLDS[name].grey_share)
    return flat_world(mesh, plants=None if mesh.grey is None else share * mesh.grey)


def reference_places(corner: float) -> Reals:
    """The twenty places, (20, 2) [m], row by row from the corner."""
    return np.stack(np.meshgrid(REFERENCE_X, REFERENCE_Y), axis=-1).reshape(-1, 2) + corner


def surfaces(
    world: World,
    corner: float,
    spacing: float,
    heading: str,
    describe: Mapping[str, Any],
    *,
    seed: int,
    supersampling: int = 4,
    places: Reals | None = None,
    measure: Any = None,
) -> dict[str, NDArray[np.float32]]:
    """Distance surfaces of all places' views, facing north, for each comparison: name → (place, y, x).

    Parameters
    ----------
    world : World
    corner, spacing : float [m]
    heading : {"aligned", "random"}
        Of the views on the grid: north, or each its own.
    describe : name → "aligned", "compass" or a descriptor
        As of `distance_from`.
    seed : int
        Of random headings.
    supersampling : int
    places : (n, 2) array [m]
        Remembered; the twenty references if None.
    measure : callable
        From the remembered views to a further measure of `survey`; what it gives is returned as "measure".
    """
    places = reference_places(corner) if places is None else places
    grid = grid_positions(SIZE, spacing, (corner, corner))
    turned = random_headings(grid.shape[:2], seed) if heading == "random" else 0.0
    remembered = render_panorama(world, places, 0.0, supersampling=supersampling)
    measures = {name: distance_from(remembered, by) for name, by in describe.items()}
    if measure is not None:
        measures["measure"] = measure(remembered)
    found = survey(world, grid, turned, measures, supersampling=supersampling)
    return {name: np.ascontiguousarray(np.moveaxis(values, -1, 0)) for name, values in found.items()}


def surfaces_of(
    cell: Any, world: World, describe: Mapping[str, Any], seed: int, measure: Any = None
) -> dict[str, NDArray[np.float32]]:
    """`surfaces` of a cell that has a corner, spacing, heading and supersampling."""
    settings: dict[str, Any] = {"seed": seed, "supersampling": cell.supersampling, "measure": measure}
    return surfaces(world, cell.corner, cell.spacing, cell.heading, describe, **settings)


def roughness(surface: NDArray[np.floating[Any]], *, every: int = 1) -> float:
    """How much of the change from sample to sample is no slope: 0 on a plane, sqrt(3) where samples are noise.

    ``sqrt(mean (f[j+1] - 2 f[j] + f[j-1])²) / sqrt(mean (f[j+1] - f[j-1])²)`` along x, over all places.

    Parameters
    ----------
    surface : (place, y, x) array
    every : int
        As of `areas`.
    """
    taken = surface[:, ::every, ::every].astype(float)
    bend = taken[..., 2:] - 2.0 * taken[..., 1:-1] + taken[..., :-2]
    slope = taken[..., 2:] - taken[..., :-2]
    return float(np.sqrt(np.mean(bend**2) / np.mean(slope**2)))


def areas(
    surface: NDArray[np.floating[Any]], spacing: float, success_radius: float, *, every: int = 1
) -> NDArray[np.float32]:
    """Catchment areas [m²] of the twenty references, of every sample of the grid or of every second, third …, (20,).

    Parameters
    ----------
    surface : (20, y, x) array
    spacing : float [m] of the surface
    success_radius : float [m]
    every : int
        Each how many of the samples are taken along both axes.
    """
    goals = reference_places(0.0)
    taken = surface[:, ::every, ::every]
    found = [
        catchment_area(one, spacing * every, goal, success_radius).area for one, goal in zip(taken, goals, strict=True)
    ]
    return np.array(found, np.float32)
