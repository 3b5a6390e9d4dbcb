"""How fast lit views are rendered: one line each, with the ratio to plain NumPy measured in the same run.

The plain way shades the same samples, without shadows, array by array (`tests/shading_oracle.py`). Wall time drifts on
shared machines, so each fast measurement stands between two plain ones, and the median of the ratios is what to quote.
Run it by ``make bench``.
"""

import resource
import statistics
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from insectnav.vision import panorama
from insectnav.worlds import light_world, render
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.sky import Sky
from shading_oracle import shade

BANDS = ("uv", "blue", "green", "red")
CAMERA = panorama(1.0)
N_RUNS = 5
SKY = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(40.0))


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def plain_views(world, eye) -> Callable[[], object]:
    rays = CAMERA.pixel_directions().reshape(-1, 3)
    seen = render(world, [eye], camera=CAMERA, layers=("triangle", "nearness"), supersampling=1)
    triangle, nearness = seen["triangle"].reshape(-1), seen["nearness"].reshape(-1)
    return lambda: shade(world, rays, triangle, nearness, eye)


def measure(name: str) -> None:
    built = build_world(name, seed=1)
    x, y = built.route[len(built.route) // 3]
    eye = np.array([x, y, built.ground_height((x, y)) + BUILDERS[name].eye_height])
    world = light_world(built, SKY)
    first = seconds(lambda: world.packed)
    other = min(seconds(lambda: world.under(replace(SKY)).packed) for _ in range(N_RUNS))
    print(f"{name}: {built.mesh.n_triangles} triangles, a panorama of 360 × 105 pixels in four bands, one core")
    print(f"{'light of a new world, of another sky':42s} {first:8.2f} s, {other:.2f} s")
    for shadows in (False, True):
        lit = replace(world, shadows=shadows)
        plain = plain_views(replace(world, shadows=False), eye)
        for supersampling in (1, 4):
            places = np.tile(eye, (4, 1))

            def views(lit=lit, places=places, supersampling=supersampling) -> object:
                return render(lit, places, camera=CAMERA, layers=BANDS, supersampling=supersampling, workers=1)

            views()
            times, ratios, before = [], [], seconds(plain)
            for _ in range(N_RUNS):
                times.append(seconds(views) / len(places))
                after = seconds(plain)
                ratios.append(supersampling**2 * (before + after) / 2 / times[-1])
                before = after
            kind = f"{supersampling**2} rays a pixel, {'with' if shadows else 'no'} shadows"
            print(
                f"{kind:42s} {1e3 * statistics.median(times):8.1f} ms a view   plain NumPy without shadows "
                f"{statistics.median(ratios):.1f} times as long ({min(ratios):.1f} … {max(ratios):.1f})",
                flush=True,
            )


def main() -> None:
    for name in ("ant-world", "city", "forest-trail"):
        measure(name)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"{'peak memory of all this':42s} {megabytes:8.0f} MiB")


if __name__ == "__main__":
    main()
