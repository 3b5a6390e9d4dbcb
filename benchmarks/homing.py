"""How fast a place is surveyed: time for each view and peak memory, and the ratio to rendering and describing plainly.

The plain way renders a few views at once with all cores, keeps them, and describes them afterwards. Wall time drifts on
shared machines, so each survey stands between two plain runs, and the median of the ratios is what to quote. Run it by
``make bench``. With ``--full`` it then surveys the 501 × 501 views of thesis section 4.3 once, at 4 × 4 rays a pixel,
with Zernike amplitudes and pixel differences to twenty places: minutes.
"""

import resource
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

from insectnav.datasets.known_worlds import find_world
from insectnav.homing import distance_from, grid_positions, survey
from insectnav.vision.descriptors import zernike_amplitudes
from insectnav.worlds import World, load_world, render_panorama

N_RUNS = 5


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def stage() -> tuple[str, World, float]:
    path = find_world("clearing")
    if path is not None:
        return "clearing world", load_world(path), 0.0
    return "built ant world", load_world("ant-world", seed=0), -5.0


def main() -> None:
    name, world, corner = stage()
    x, y = np.meshgrid((1.0, 3.0, 5.0, 7.0, 9.0), (1.2, 3.8, 6.2, 8.8))
    places = np.stack([x, y], axis=-1).reshape(-1, 2) + corner
    remembered = render_panorama(world, places, 0.0)
    measures = {"pixels": distance_from(remembered), "zernike": zernike_amplitudes}
    grid = grid_positions(10.0, 0.4, (corner, corner))
    n_views = grid[..., 0].size

    def plain() -> None:
        views = render_panorama(world, grid.reshape(-1, 2), 0.0)
        for measure in measures.values():
            measure(views)

    def streamed(workers: int | None) -> Callable[[], object]:
        return lambda: survey(world, grid, 0.0, measures, workers=workers)

    streamed(1)()
    print(f"{name}: {n_views} views of 360 × 105 pixels, 4 × 4 rays; peak memory so far {peak_mib():.0f} MiB")
    for label, workers in (("one thread", 1), ("all cores", None)):
        times, ratios = [], []
        before = seconds(plain)
        for _ in range(N_RUNS):
            times.append(seconds(streamed(workers)) / n_views)
            after = seconds(plain)
            ratios.append(times[-1] * n_views / ((before + after) / 2.0))
            before = after
        print(
            f"{f'survey, {label}':28s} {1e3 * statistics.median(times):7.3f} ms a view, "
            f"{statistics.median(ratios):.2f} of the time of all views at once ({min(ratios):.2f} … {max(ratios):.2f})",
            flush=True,
        )
    if "--full" in sys.argv:
        grid = grid_positions(10.0, 0.02, (corner, corner))
        took = seconds(lambda: survey(world, grid, 0.0, measures))
        print(f"{grid[..., 0].size} views in {took:.0f} s, {1e3 * took / grid[..., 0].size:.3f} ms a view")
    print(f"peak memory of all this {peak_mib():.0f} MiB")


if __name__ == "__main__":
    main()
