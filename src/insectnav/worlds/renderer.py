"""Panoramas of a world: what an eye sees all round, from many places at once."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.checks import (
    InputError,
    as_numbers,
    check_choice,
    check_finite,
    check_radians,
    check_range,
    check_shape,
    quoted,
)
from insectnav.workers import count_workers, run_blocks
from insectnav.worlds.solids import check_outside_solids
from insectnav.worlds.world import World, check_positions

SUPERSAMPLING = (1, 2, 4, 8)
LAYERS = ("sky", "alpha", "nearness", "depth", "triangle")  # besides the bands
MAX_BYTES = 8 * 2**30  # of one call's results
TILE = 65536  # samples in the buffer of depths of a thread, so that it stays in the cache
VIEWS_PER_TASK = 16
SNAP = 1e-6  # [pixel] a heading this near to a whole number of pixels is one
Layers = dict[str, npt.NDArray[Any]]


def render_panorama(
    world: World,
    positions: npt.ArrayLike,
    headings: npt.ArrayLike,
    *,
    resolution_deg: float = 1.0,
    elevation_deg: tuple[float, float] = (-15.0, 90.0),
    supersampling: int = 4,
    band: str = "grey",
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> npt.NDArray[np.float32]:
    """Panoramas (n, row, column) in 0…1, row 0 on the zenith side, the middle straight ahead, left on the left.

    Parameters
    ----------
    world : World
    positions : (n, 2 or 3) array of x, y and perhaps z [m]; an eye without z is 0.01 m above the ground
    headings : (n,) array, or one for all [rad], clockwise from +y
    resolution_deg : width and height of a pixel in azimuth and elevation
    elevation_deg : lower and upper border of the picture
    supersampling : 1, 2, 4 or 8 rays along each side of a pixel, averaged
    band : one of `world.bands`
    workers : threads; None for as many as there are cores. They change nothing in the results
    progress : called with the number of views finished at a time

    Returns
    -------
    (n, row, column) array of float32

    Raises
    ------
    InputError
        If a position is outside the world or inside a solid, or an option makes no sense.

    Notes
    -----
    The view of thesis section 4.3 (360 × 105 pixels of 1°, eye at 0.01 m). Samples lie at the centres of equal parts of
    a pixel. A compiled buffer of depths, column by column; see `insectnav.worlds.panorama_runs`.
    """
    check_choice("band", band, world.bands)
    return render_layers(
        world,
        positions,
        headings,
        (band,),
        resolution_deg=resolution_deg,
        elevation_deg=elevation_deg,
        supersampling=supersampling,
        workers=workers,
        progress=progress,
    )[band]


def render_layers(
    world: World,
    positions: npt.ArrayLike,
    headings: npt.ArrayLike,
    layers: Sequence[str],
    *,
    resolution_deg: float = 1.0,
    elevation_deg: tuple[float, float] = (-15.0, 90.0),
    supersampling: int = 1,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Layers:
    """Several pictures of the same views, by name: bands of the world, and what else is known of each pixel.

    Parameters
    ----------
    layers : bands, and any of
        "sky", the share of a pixel in which the sky is seen; "alpha", the share that the mesh covers (the rest is
        ground); "nearness" [1/m], the mean of 1 / distance, 0 for the sky; "depth" [m], 1 / nearness, infinite for
        the sky; "triangle", the index of the nearest triangle, -1 for the sky and -2 for the ground
    world, positions, headings, resolution_deg, elevation_deg, supersampling, workers, progress
        As of `render_panorama`.

    Returns
    -------
    name → (n, row, column) array of float32, int32 for "triangle"

    Raises
    ------
    InputError
        If a layer is unknown, or as `render_panorama`.
    """
    from insectnav.worlds.panorama_kernel import render_views

    for layer in layers:
        check_choice("layer", layer, (*world.bands, *LAYERS))
    position, heading = _check_poses(world, positions, headings)
    grid = sampling_grid(resolution_deg, elevation_deg, supersampling)
    channels = [layer for layer in dict.fromkeys(layers) if layer in (*world.bands, "sky", "alpha")]
    views = _empty_views(position, heading, grid, layers, len(channels))
    scene = _pack_scene(world, channels, grid)

    def run_task(first: int, last: int) -> None:
        render_views(first, last, grid, scene, new_work(world, grid), views)

    run_views(run_task, len(position), workers, progress)
    if elevation_deg[1] > 0:
        check_outside_solids(world, position, views.sees_sky == 0)
    found: Layers = {name: views.value[:, channel] for channel, name in enumerate(channels)}
    found |= {"triangle": views.triangle, "nearness": views.nearness}
    if "depth" in layers:
        with np.errstate(divide="ignore"):
            found["depth"] = 1 / views.nearness
    return {layer: found[layer] for layer in layers}


def draw_samples(
    world: World,
    position: npt.NDArray[Any],
    rotation: npt.NDArray[Any],
    heading: float,
    resolution_deg: float,
    elevation_deg: tuple[float, float],
    supersampling: int,
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.float32]]:
    """Nearest triangle, and its nearness [1/m], in each sample of one panorama, both (pixel · sample,).

    Pixels follow each other row by row, and so do the samples of each. Where there is no triangle it is below 0.

    Parameters
    ----------
    position : (3,) array [m]
    rotation : (3, 3) array, world ← eye
    heading : of a level eye [rad]; NaN for one that is tilted, for which the world is turned about it instead
    world, resolution_deg, elevation_deg, supersampling
        As of `render_panorama`.
    """
    from insectnav.worlds.panorama_kernel import render_views

    s = supersampling
    grid = sampling_grid(resolution_deg / s, elevation_deg, 1)
    scene = _pack_scene(world, (), grid)
    if np.isnan(heading):
        turned = (world.corners.T.astype(np.float64) - position) @ rotation
        scene = scene._replace(corners=np.ascontiguousarray(turned.T, np.float32))
        position, heading = np.zeros(3), 0.0
    views = _empty_views(position[None], np.array([heading]), grid, ("triangle", "nearness"), 0)
    render_views(0, 1, grid, scene, new_work(world, grid), views)
    rows, columns = grid.n_rows // s, grid.n_columns // s

    def by_pixel(samples: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return samples[0].reshape(rows, s, columns, s).swapaxes(1, 2).reshape(-1)

    return by_pixel(views.triangle), by_pixel(views.nearness)


def sampling_grid(resolution_deg: float, elevation_deg: tuple[float, float], supersampling: int) -> Any:
    """Directions of all samples of a panorama, in the form that the kernel reads.

    Parameters
    ----------
    resolution_deg, elevation_deg, supersampling
        As of `render_panorama`.

    Raises
    ------
    InputError
        If the pixels do not fill the picture exactly, or there are too many.
    """
    from insectnav.worlds.panorama_kernel import Grid

    if supersampling not in SUPERSAMPLING:
        raise InputError(f"supersampling is {quoted(supersampling)}, expected one of 1, 2, 4, 8")
    check_range("resolution", resolution_deg, 0.02, 45, "degrees", "in radians?" if resolution_deg < 0.02 else "")
    check_range("elevation", elevation_deg, -90, 90, "degrees")
    low, high = elevation_deg
    if low >= high:
        raise InputError(f"elevation runs from {low:g} to {high:g} degrees, expected the lower border first")
    counts = []
    for name, span in (("the full circle", 360.0), ("the range of elevations", high - low)):
        n = round(span / resolution_deg)
        if n < 1 or abs(n * resolution_deg - span) > 1e-6 * span:
            raise InputError(f"resolution is {resolution_deg:g} degrees, expected a whole number of pixels in {name}")
        counts.append(n * supersampling)
    n_columns, n_rows = counts
    azimuth = -np.pi + (np.arange(n_columns) + 0.5) * (2 * np.pi / n_columns)
    step = np.deg2rad(high - low) / n_rows
    elevation = np.deg2rad(high) - (np.arange(n_rows) + 0.5) * step
    return Grid(
        across=np.stack([np.sin(azimuth), np.cos(azimuth)], axis=-1),
        tangent=np.tan(elevation).astype(np.float32),
        n_columns=n_columns,
        n_rows=n_rows,
        columns_per_radian=n_columns / (2 * np.pi),
        rows_per_radian=1 / step,
        top=float(np.deg2rad(high)),
        supersampling=int(supersampling),
    )


def new_work(world: World, grid: Any) -> Any:
    """Work space of a thread; what a view does not need is never touched and takes no memory.

    Parameters
    ----------
    world : World
    grid : of `sampling_grid`
    """
    from insectnav.worlds.panorama_kernel import Work
    from insectnav.worlds.panorama_runs import RUNS_PER_TRIANGLE

    n_triangles, n_columns, n_rows = world.mesh.n_triangles, len(grid.across), len(grid.tangent)
    tile = max(TILE, n_rows * grid.supersampling)
    return Work(
        across=np.empty((n_columns, 2)),
        angle=np.empty(3 * n_triangles),
        column=np.empty(3 * n_triangles, np.int32),
        run=np.empty((RUNS_PER_TRIANGLE * n_triangles, 3), np.int32),
        bound=np.empty((RUNS_PER_TRIANGLE * n_triangles, 8)),
        upper=np.empty(n_columns, np.int32),
        lower=np.empty(n_columns, np.int32),
        top=np.empty(n_columns, np.int32),
        near=np.zeros(tile, np.float32),
        triangle=np.zeros(tile, np.int32),
        total=np.empty(n_rows, np.float32),
        n_tile=tile,
    )


def run_views(
    task: Callable[[int, int], None], n: int, workers: int | None, progress: Callable[[int], None] | None = None
) -> None:
    """Run ``task(first, last)`` over 0…n in pieces, on several threads; a few views have a thread each.

    Parameters
    ----------
    task : what to do with the views from first up to last
    n : how many there are
    workers, progress
        As of `render_panorama`.
    """
    run_blocks(task, n, max(1, min(VIEWS_PER_TASK, -(-n // count_workers(workers)))), workers, progress)


def check_size(shape: tuple[int, ...], n_layers: int) -> None:
    """Refuse results that no ordinary machine can hold.

    Parameters
    ----------
    shape : of one layer
    n_layers : how many there are, of 4 bytes a number

    Raises
    ------
    InputError
        If they take more than 8 GiB.
    """
    size = 4.0 * n_layers * np.prod(np.array(shape, float))
    if size > MAX_BYTES:
        raise InputError(f"{shape[0]} views take {size / 2**30:.0f} GiB, expected at most 8: render them in parts")


def _check_poses(world: World, positions: npt.ArrayLike, headings: npt.ArrayLike) -> tuple[Any, Any]:
    position = check_positions(world, positions)
    heading = as_numbers("headings", headings).astype(np.float64)
    if heading.ndim:
        check_shape("headings", heading, (len(position),))
    check_finite("headings", heading)
    check_radians("headings", heading)
    return position, np.ascontiguousarray(np.broadcast_to(heading, len(position)))


def _empty_views(position: Any, heading: Any, grid: Any, layers: Sequence[str], n_channels: int) -> Any:
    """Poses in the form that the kernel reads, and arrays for what is asked for."""
    from insectnav.worlds.panorama_kernel import Views

    n_columns, n_rows = grid.n_columns // grid.supersampling, grid.n_rows // grid.supersampling
    n_views, shape = len(position), (len(position), n_rows, n_columns)
    has_nearness, has_triangle = bool({"nearness", "depth"} & set(layers)), "triangle" in layers
    check_size(shape, n_channels + has_nearness + has_triangle + ("depth" in layers))
    pixels = heading * n_columns / (2 * np.pi)
    is_whole = np.abs(pixels - np.rint(pixels)) < SNAP
    whole = np.where(is_whole, np.rint(pixels), np.floor(pixels))
    return Views(
        eye=position,
        phase=np.where(is_whole, 0.0, pixels - whole) * grid.supersampling,
        turn=whole.astype(np.int64),
        value=np.empty((n_views, n_channels, n_rows, n_columns), np.float32),
        nearness=np.empty(shape if has_nearness else (n_views, 0, 0), np.float32),
        triangle=np.empty(shape if has_triangle else (n_views, 0, 0), np.int32),
        sees_sky=np.zeros(n_views, np.uint8),
        n_channels=n_channels,
        has_nearness=has_nearness,
        has_triangle=has_triangle,
    )


def _pack_scene(world: World, channels: Sequence[str], grid: Any) -> Any:
    """Values of triangles and background for each channel; sky and alpha are channels of ones and zeros."""
    from insectnav.worlds.panorama_kernel import Scene

    is_sky = grid.tangent >= 0
    value = np.empty((len(channels), world.mesh.n_triangles), np.float32)
    background = np.empty((len(channels), len(grid.tangent)), np.float32)
    for row, name in enumerate(channels):
        if name in world.bands:
            value[row], background[row] = world.brightness[name], np.where(is_sky, world.sky[name], world.ground[name])
        else:
            value[row], background[row] = name == "alpha", is_sky & (name == "sky")
    elevation = np.arctan(grid.tangent.astype(np.float64))
    return Scene(
        corners=world.corners,
        value=value,
        background=background,
        ground_nearness=np.maximum(-np.sin(elevation), 0).astype(np.float32),
        cosine=np.cos(elevation).astype(np.float32),
        n_corners=world.corners.shape[1],
    )
