"""How fast views are matched over all rotations: one line each, with the ratio to plain ways in the same run.

The plain search looks the query up along the rings of the reference at every tilt and turn and sums, in NumPy, without
Fourier transforms; the brute search scores references at the same rotations on the fine map, compiled. Both are
measured on a few rotations and scaled, as the whole would take minutes. Products of matrices run on one thread where
threadpoolctl is installed. Times are those of the processor, which a shared
machine disturbs less. Views are made up; run it by ``make bench``.
"""

import contextlib
import importlib.util
import resource
import statistics
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from insectnav.matching import RotationIndex, RotationParams, build_rotation_index
from insectnav.matching.rotation_kernel import score_of_rotation
from insectnav.matching.rotation_refinement import N_POINTS, seen_points
from insectnav.matching.rotation_search import ring_grid, rotation_of
from insectnav.matching.view_maps import look_up
from insectnav.vision import rotation_matrix, to_eye, to_world
from insectnav.vision.sphere import equirectangular

N_RUNS, N_PLAIN = 7, 12


def seconds(function: Callable[[], object]) -> float:
    started = time.process_time()
    function()
    return time.process_time() - started


def skies(numbers: range, directions: np.ndarray) -> np.ndarray:
    """Made-up skies, True where a few smooth waves add up to more than 0."""
    found = []
    for number in numbers:
        rng = np.random.default_rng(number)
        waves = rng.standard_normal((6, 3)) * 4.0
        found.append(np.cos(directions @ waves.T + rng.uniform(0, 6.3, 6)).sum(axis=-1) > 0.0)
    return np.array(found)


def plain_search(index: RotationIndex, coarse: np.ndarray, places: range) -> Callable[[], object]:
    """Scores of all references at some of the rotations, by lookups and sums."""
    rings, weights = ring_grid(index.rings.n_turns)
    references = np.nan_to_num(look_up(index.maps, index.fine.n_cells, rings))
    solid = np.broadcast_to(weights[:, None], rings.shape[:2])

    def scores() -> list[np.ndarray]:
        found = []
        for place in places:
            rotation = rotation_of(place, index.tilts, index.rings.n_turns)
            here = look_up(coarse[None], index.coarse.n_cells, to_eye(rings, rotation))[0]
            both = np.isfinite(here) & (rings[..., 2] > 0.0)
            apart = (references[:, both] - here[both]) ** 2
            found.append(1.0 - apart @ solid[both] / solid[both].sum())
        return found

    return scores


def brute_search(index: RotationIndex, fine: np.ndarray, places: range) -> Callable[[], object]:
    """Scores of one reference at some of the rotations on the fine map, compiled."""
    points = seen_points(fine, index.fine.n_cells, N_POINTS)
    rotations = [rotation_of(place, index.tilts, index.rings.n_turns) for place in places]
    arguments = points.directions, points.values, index.maps[0], index.fine.n_cells
    return lambda: [score_of_rotation(0, *arguments, rotation, 1.0) for rotation in rotations]


def compare(name: str, run: Callable[[], object], plain: Callable[[], object], scale: float, what: str) -> None:
    """Print the median time and its ratio to a plain way, of which a part times ``scale`` is the whole."""
    run()
    plain()
    times, ratios = [], []
    before = seconds(plain)
    for _ in range(N_RUNS):
        times.append(seconds(run))
        after = seconds(plain)
        ratios.append((before + after) / 2.0 * scale / times[-1])
        before = after
    print(
        f"{name:44s} {1e3 * statistics.median(times):8.1f} ms (best {1e3 * min(times):.1f})   "
        f"1/{statistics.median(ratios):.0f} of {what}",
        flush=True,
    )


def main() -> None:
    grid = equirectangular(1.0)
    seen = grid.directions[:, 2] > 0.0
    started = time.perf_counter()
    index = build_rotation_index(skies(range(65), grid.directions), seen, grid)
    print(f"{'index of 65 views of 1°, built':44s} {time.perf_counter() - started:8.2f} s")
    started = time.perf_counter()
    large = build_rotation_index(skies(range(1000), grid.directions), seen, grid)
    print(f"{'index of 1000 views of 1°, built':44s} {time.perf_counter() - started:8.2f} s")
    turned = to_world(grid.directions, rotation_matrix(1.0, 0.6, -0.3))
    view = skies(range(30, 31), turned)[0]
    prepared = view[None].astype(np.float32), seen[None]
    coarse, fine = index.coarse(*prepared)[0], index.fine(*prepared)[0]
    n_places = len(index.tilts) * index.rings.n_turns
    some = range(0, n_places, n_places // N_PLAIN)
    scale = n_places / len(some)
    for each in (index, large):
        name = f"a query against {each.n_references}"
        whole = "plain NumPy at the same rotations"
        compare(name, lambda each=each: each.match(view, seen), plain_search(each, coarse, some), scale, whole)
        brute = brute_search(each, fine, some)
        compare(
            name, lambda each=each: each.match(view, seen), brute, scale * each.n_references, "a compiled brute search"
        )
    grey = build_rotation_index(
        skies(range(65), grid.directions), seen, grid, replace(RotationParams(), score="correlation")
    )
    compare(
        "the same by correlation, 65", lambda: grey.match(view, seen), plain_search(index, coarse, some), scale, whole
    )
    print(f"{'memory of a reference':44s} {large.n_bytes / 1000 / 1024:8.0f} KiB")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{'peak memory of all this':44s} {peak:8.0f} MiB")


if __name__ == "__main__":
    limit: contextlib.AbstractContextManager[object] = contextlib.nullcontext()
    if importlib.util.find_spec("threadpoolctl"):
        from threadpoolctl import threadpool_limits

        limit = threadpool_limits(1)
    with limit:
        main()
