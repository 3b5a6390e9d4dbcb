"""The skyline: the highest elevation that is occupied, over any azimuths."""

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats, wrap
from insectnav.checks import as_numbers, check_count, check_finite, check_radians, check_shape
from insectnav.worlds.renderer import check_size, run_views
from insectnav.worlds.world import World, check_positions

N_GUARDS = 8  # azimuths added all round, so that no edge can span all of them


def skyline(
    world: World, positions: npt.ArrayLike, azimuths: int | npt.ArrayLike = 360, *, workers: int | None = None
) -> Floats:
    """Highest elevation that the mesh occupies over each azimuth (n, azimuth) [rad], at least 0: the horizon.

    Parameters
    ----------
    world : World
    positions : (n, 2 or 3) array of x, y and perhaps z [m]
    azimuths : (azimuth,) array [rad], clockwise from +y, in the world: not turned with a heading. Or how many, spread
        evenly as the columns of a panorama with heading 0 are
    workers : threads; None for as many as there are cores

    Raises
    ------
    InputError
        If a position is outside the world, or azimuths are not angles in radians.

    Notes
    -----
    Exact to rounding: a vertical half-plane meets the edge of a triangle at one elevation in closed form, see
    `insectnav.worlds.panorama_runs`. Nothing is sampled in elevation.
    """
    from insectnav.worlds.panorama_runs import RUNS_PER_TRIANGLE
    from insectnav.worlds.skyline_kernel import SkylineWork, find_skylines

    position, wanted = check_positions(world, positions), _azimuths(azimuths)
    check_size((len(position), len(wanted)), 2)
    guards = -np.pi + (np.arange(N_GUARDS) + 0.5) * 2 * np.pi / N_GUARDS
    azimuth, place = np.unique(np.concatenate([wanted, guards]), return_inverse=True)
    across = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=-1)
    found = np.empty((len(position), len(azimuth)))

    def run_task(first: int, last: int) -> None:
        n_triangles = world.mesh.n_triangles
        work = SkylineWork(
            angle=np.empty(3 * n_triangles),
            column=np.empty(3 * n_triangles, np.int64),
            run=np.empty((RUNS_PER_TRIANGLE * n_triangles, 3), np.int32),
            bound=np.empty((RUNS_PER_TRIANGLE * n_triangles, 8)),
        )
        find_skylines(first, last, world.corners, azimuth, across, position, work, found)

    run_views(run_task, len(position), workers)
    return found[:, place[: len(wanted)]]


def _azimuths(azimuths: int | npt.ArrayLike) -> Floats:
    if isinstance(azimuths, int):
        check_count("azimuths", azimuths)
        return -np.pi + (np.arange(azimuths) + 0.5) * (2 * np.pi / azimuths)
    array = as_numbers("azimuths", azimuths).astype(np.float64)
    check_shape("azimuths", array, ("azimuth",))
    check_finite("azimuths", array)
    check_radians("azimuths", array)
    return wrap(array)
