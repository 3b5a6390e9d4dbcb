"""How fast views are rendered: one line each, with the ratio to rays by embreex measured in the same run.

Wall time drifts on shared machines, so each fast measurement stands between two of embreex's, and the median of the
ratios is what to quote. The two public ant worlds are used where INSECTNAV_DATA has them, a built one otherwise. Run it
by ``make bench``.
"""

import os
import resource
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from insectnav.vision.sphere import equirectangular, rotation_matrix, to_world
from insectnav.worlds import World, load_world, render_panorama, skyline

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
PUBLIC = {"clearing": "antworld_clearing_stone2018.npz", "seville": "antworld_seville2009.npz"}
N_VIEWS, N_RAY_VIEWS, N_RUNS = 256, 6, 7
DIRECTIONS = equirectangular(1.0, (-15.0, 90.0)).directions


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def work_done(function: Callable[[], object]) -> float:
    """Processor seconds of all threads."""
    started = time.process_time()
    function()
    return time.process_time() - started


def worlds() -> dict[str, World]:
    found = {name: load_world(DATA / file) for name, file in PUBLIC.items() if (DATA / file).exists()}
    return found or {"built ant world": load_world("ant-world", seed=1)}


def some_views(world: World) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    middle, half = world.extent.mean(axis=0), np.minimum(4.0, np.ptp(world.extent, axis=0) * 0.4)
    return middle + half * rng.uniform(-1, 1, (N_VIEWS, 2)), rng.uniform(-np.pi, np.pi, N_VIEWS)


def embreex_views(world: World, positions: np.ndarray, headings: np.ndarray) -> Callable[[], float]:
    """Seconds for one ray in each of the 360 × 105 directions of a view: casting alone, all else is done before."""
    scene, rays = EmbreeScene(), []
    TriangleMesh(scene, np.array(world.mesh.vertices))
    for (x, y), heading in zip(positions[:N_RAY_VIEWS], headings[:N_RAY_VIEWS], strict=True):
        look = np.float32(to_world(DIRECTIONS, rotation_matrix(heading)))
        rays.append((np.tile(np.float32([x, y, 0.01]), (len(look), 1)), look))
    return lambda: seconds(lambda: [scene.run(*pair, output=True) for pair in rays]) / N_RAY_VIEWS


def compare(name: str, run: Callable[[], object], rays: Callable[[], float], rays_per_pixel: int) -> float:
    """Print the median time of a view, and how many times as long embreex takes for as many rays; return the time."""
    run()  # compiles, or loads what was compiled
    times, ratios = [], []
    before = rays()
    for _ in range(N_RUNS):
        times.append(seconds(run) / N_VIEWS)
        after = rays()
        ratios.append(rays_per_pixel * (before + after) / 2.0 / times[-1])
        before = after
    median = statistics.median(times)
    print(
        f"{name:42s} {1e3 * median:8.3f} ms a view   embreex {statistics.median(ratios):6.1f} times as long "
        f"({min(ratios):.1f} … {max(ratios):.1f})",
        flush=True,
    )
    return median


def measure(name: str, world: World) -> None:
    positions, headings = some_views(world)
    rays = embreex_views(world, positions, headings)
    rays()
    print(f"{name}: {world.mesh.n_triangles} triangles, {N_VIEWS} views of 360 × 105 pixels; medians of {N_RUNS} runs")
    print(f"{'embreex, one ray a pixel':42s} {1e3 * statistics.median(rays() for _ in range(N_RUNS)):8.3f} ms a view")

    def views(supersampling: int, workers: int) -> Callable[[], object]:
        return lambda: render_panorama(world, positions, headings, supersampling=supersampling, workers=workers)

    for supersampling in (1, 4):
        rays_per_pixel = supersampling**2
        compare(f"{rays_per_pixel} rays a pixel, one core", views(supersampling, 1), rays, rays_per_pixel)
        compare(f"{rays_per_pixel} rays a pixel, two cores", views(supersampling, 2), rays, rays_per_pixel)
        gains = [seconds(views(supersampling, 1)) / seconds(views(supersampling, 2)) for _ in range(N_RUNS)]
        work = [work_done(views(supersampling, 2)) / work_done(views(supersampling, 1)) for _ in range(N_RUNS)]
        print(
            f"{'two cores over one, run by run':42s} {statistics.median(gains):8.2f} times as fast, "
            f"with {statistics.median(work):.2f} of the processor time: what is missing to 2 others took"
        )
    skyline(world, positions[:1], 1440)
    time_of_one = statistics.median(seconds(lambda: skyline(world, positions, 1440, workers=1)) for _ in range(N_RUNS))
    print(f"{'exact skyline, 1440 azimuths, one core':42s} {1e3 * time_of_one / N_VIEWS:8.3f} ms a place")


def main() -> None:
    for name, world in worlds().items():
        measure(name, world)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"{'peak memory of all this':42s} {megabytes:8.0f} MiB")


if __name__ == "__main__":
    main()
