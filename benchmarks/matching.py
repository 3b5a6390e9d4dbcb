"""How fast frames are compared and sequences of them found: one line each, with the ratio to the plain way.

Images of 64 × 32 pixels are made up: a route and the same route in other light; times do not depend on what they show.
The plain way is tests/seqslam_oracle.py, one frame, place and speed at a time, run once and in parts: each fast
measurement stands beside a part of it, and what is quoted is the median of the ratios of the whole. On a machine that
others use, time by the clock holds threads that waited: seconds of processors, all threads together, are given too. Run
it by ``make bench``.
"""

import resource
import statistics
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import seqslam_oracle
from insectnav.matching import (
    OPENSEQSLAM_V1,
    Matches,
    SeqSlamParams,
    begin_stream,
    constellation_index,
    difference_matrix,
    disk_turn_matrix,
    locate_by_constellations,
    locate_next,
    seqslam,
    turn_matrix,
)
from insectnav.vision.descriptors import binary_sky, contour_amplitudes, patch_normalised

N_FRAMES, N_PLAIN, N_RUNS = 1200, 200, 5


def seconds(function: Callable[[], object]) -> float:
    return float(took(function)[0])


def took(function: Callable[[], object]) -> np.ndarray:
    """Seconds by the clock, and of processors, all threads together."""
    started = np.array([time.perf_counter(), time.process_time()])
    function()
    return np.array([time.perf_counter(), time.process_time()]) - started


def made_route(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Two drives (n, 32, 64) of bytes past the same things, the second in other light and with noise."""
    rng = np.random.default_rng(0)
    strip = np.kron(rng.random((32, n // 2 + 64)), np.ones((1, 4)))
    route = np.stack([strip[:, 2 * i : 2 * i + 64] for i in range(n)])
    other = np.clip(0.6 * route + 0.2 + 0.1 * rng.normal(size=route.shape), 0, 1)
    return (255 * route).astype(np.uint8), (255 * other).astype(np.uint8)


def plain_parts(summer: np.ndarray, winter: np.ndarray) -> dict[str, np.ndarray]:
    """What each step of the plain way took on few frames, scaled to all of them."""
    few = summer[:N_PLAIN], winter[:N_PLAIN]
    patches = [np.array([seqslam_oracle.patch_normalise(image).ravel() for image in images]) for images in few]
    difference = seqslam_oracle.difference(*patches)
    enhanced = seqslam_oracle.enhance(difference)
    share = N_FRAMES / N_PLAIN
    return {
        "patches": share * took(lambda: [seqslam_oracle.patch_normalise(i) for images in few for i in images]),
        "difference": share**2 * took(lambda: seqslam_oracle.difference(*patches)),
        "contrast": share**2 * took(lambda: seqslam_oracle.enhance(difference)),
        "search": (N_FRAMES - 10) * share / (N_PLAIN - 10) * took(lambda: seqslam_oracle.search(enhanced)),
    }


def whole_route() -> None:
    summer, winter = made_route(N_FRAMES)
    few = summer[:N_PLAIN], winter[:N_PLAIN]

    def default() -> None:
        seqslam(difference_matrix(patch_normalised(summer), patch_normalised(winter)))

    def v1(frames: tuple[np.ndarray, np.ndarray] = (summer, winter)) -> Matches:
        patches = [patch_normalised(images, rounded=True, flat_patch=0) for images in frames]
        return seqslam(difference_matrix(patches[0], patches[1], "openseqslam-v1"), OPENSEQSLAM_V1)

    patches = [np.array([seqslam_oracle.patch_normalise(image).ravel() for image in images]) for images in few]
    expected = seqslam_oracle.search(seqslam_oracle.enhance(seqslam_oracle.difference(*patches)))
    n_apart = np.sum(v1(few).reference[5:-5] != expected[5:-5, 0])
    print(f"v1 and the plain way differ in {n_apart} of {N_PLAIN - 10} matches of {N_PLAIN} frames")
    plain = plain_parts(summer, winter)
    parts = ", ".join(f"{name} {both[0]:.1f}" for name, both in plain.items())
    name = f"plain, {N_FRAMES} × {N_FRAMES}, from parts of {N_PLAIN}"
    print(f"{name:44s} {sum(both[0] for both in plain.values()):8.2f} s ({parts})")
    for name, run in (("images to matches, default", default), ("images to matches, v1 exact", v1)):
        run()  # compiles, or loads what was compiled
        fast, slow = [], []
        for _ in range(N_RUNS):
            fast.append(np.median([took(run) for _ in range(5)], axis=0))
            slow.append(sum(plain_parts(summer, winter).values()))
        times, ratios = np.median(fast, axis=0), np.array(slow) / np.array(fast)
        for k, clock in enumerate(("by the clock", "of processors")):
            print(
                f"{f'{name}, {clock}':44s} {1e3 * times[k]:8.1f} ms, {np.median(ratios[:, k]):5.0f} times faster "
                f"({ratios[:, k].min():.0f} … {ratios[:, k].max():.0f})",
                flush=True,
            )


def many_places() -> None:
    rng = np.random.default_rng(1)
    references, queries = (rng.random((10_000, 120), np.float32) for _ in range(2))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    difference_matrix(references[:99], queries[:99], "euclidean")  # compiles, or loads what was compiled
    seqslam(difference_matrix(references[:99], queries[:99], "euclidean"))
    difference = np.empty(0)

    def compare() -> None:
        nonlocal difference
        difference = difference_matrix(references, queries, "euclidean")

    compared, searched = took(compare), took(lambda: seqslam(difference))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(
        f"{'10 000 × 10 000 of 120 features':44s} {compared[0] + searched[0]:8.2f} s (difference {compared[0]:.2f}, "
        f"search {searched[0]:.2f}; of processors {compared[1] + searched[1]:.2f}), peak {peak / 2**20:.2f} GiB, "
        f"{before / 2**20:.2f} before"
    )
    for metric in ("cosine", "absolute"):
        difference_matrix(references[:99], queries[:99], metric)
        run = seconds(lambda metric=metric: difference_matrix(references, queries, metric))
        print(f"{f'difference of these, {metric}':44s} {run:8.2f} s")
    bits = rng.random((2000, 8100)) > 0.5
    run = seconds(lambda: difference_matrix(bits, bits, "hamming"))
    print(f"{'2000 × 2000 binary skies of 90 × 90':44s} {run:8.2f} s")
    stream = begin_stream(references, "euclidean", replace(SeqSlamParams(), sequence_length=10))
    times = []
    for query in queries[:200]:
        started = time.perf_counter()
        stream, _ = locate_next(stream, query)
        times.append(time.perf_counter() - started)
    print(f"{'stream, a frame against 10 000':44s} {1e3 * statistics.median(times):8.2f} ms")


def headings_and_skies() -> None:
    rng = np.random.default_rng(2)
    route, views = rng.random((455, 25, 120)), rng.random((102, 25, 120))
    run = min(seconds(lambda: turn_matrix(route, views)) for _ in range(3))
    print(f"{'compass, 455 panoramas × 120 turns':44s} {1e3 * run / 102:8.2f} ms a query")
    place = np.arange(691) - 345
    disk = np.hypot(*np.meshgrid(place, place))
    skies = disk < rng.uniform(200, 300, (120, 1, 1))
    run = seconds(lambda: disk_turn_matrix(skies, skies[:4], 90))
    print(f"{'compass, 120 skies of 691 × 691 × 90 turns':44s} {1e3 * run / 4:8.2f} ms a query")
    masks = np.hypot(*np.meshgrid(place[::2], place[::2])) < rng.uniform(200, 300, (40, 1, 1))
    for name, describe in (("binary sky", binary_sky), ("contour amplitudes", contour_amplitudes)):
        print(f"{f'{name}, masks of 346 × 346':44s} {1e3 * seconds(lambda f=describe: f(masks)) / 40:8.2f} ms a sky")
    spectra = np.cumsum(rng.normal(size=(10_000, 120)), axis=0)
    index = constellation_index(spectra)
    run = seconds(lambda: locate_by_constellations(index, spectra[3000:3200]))
    print(f"{'constellations, a query against 10 000':44s} {1e3 * run / 200:8.2f} ms")


def main() -> None:
    many_places()
    headings_and_skies()
    whole_route()


if __name__ == "__main__":
    main()
