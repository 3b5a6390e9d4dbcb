"""How fast sky is segmented: one line for each method and size, with the ratio to k-means in the same run.

The scene is made: sky, ground and a jagged skyline, with the noise of a sensor. Wall time drifts on shared machines, so
k-means is timed before and after each method, and the ratio is to the mean of both. Run it by ``make bench``.
"""

import os
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from insectnav.datasets.video import video_frames
from insectnav.vision.sky_segmentation import segment

SIZE = (403, 604)  # of the published pictures
HD = (1080, 1920)
N_RUNS, N_FRAMES, FRAMES_PER_SECOND = 15, 60, 30.0


def scene(size: tuple[int, int], seed: int = 0) -> np.ndarray:
    """Red, green, blue of a sky above a jagged skyline, bytes."""
    rng = np.random.default_rng(seed)
    rows, columns = size
    walk = np.cumsum(rng.normal(0.0, rows / 150, columns))
    height = np.clip(rows / 2 + walk - walk.mean(), rows * 0.2, rows * 0.8)
    is_sky = np.arange(rows)[:, None] < height
    base = np.where(is_sky[..., None], np.array([120.0, 160.0, 220.0]), np.array([90.0, 80.0, 60.0]))
    return np.clip(base + rng.normal(0.0, 12.0, (*size, 3)), 0, 255).astype(np.uint8)


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def compare(name: str, run: Callable[[], object], plain: Callable[[], object], n_runs: int = N_RUNS) -> None:
    """Print the median time and its ratio to k-means."""
    run()  # compiles, or loads what was compiled
    before = seconds(plain)
    times = [seconds(run) for _ in range(n_runs)]
    reference = (before + seconds(plain)) / 2.0
    median = statistics.median(times)
    print(f"{name:52s} {1e3 * median:9.2f} ms   1/{reference / median:6.0f} of k-means", flush=True)


def main() -> None:
    colour = scene(SIZE)
    grey, deep = colour[..., 2].copy(), colour[..., 2].astype(np.uint16) * 200

    def kmeans() -> object:
        return segment(grey, "kmeans")

    kmeans()
    print(f"{'k-means, 7 restarts, one channel':52s} {1e3 * seconds(kmeans):9.2f} ms")
    for method in ("otsu", "watershed", "watershed-islands"):
        compare(f"{method}, 8 bits, {SIZE[1]} × {SIZE[0]}", lambda method=method: segment(grey, method), kmeans)
        compare(f"{method}, 16 bits", lambda method=method: segment(deep, method), kmeans)
        compare(f"{method}, mean of three bands", lambda method=method: segment(colour, method), kmeans)
    compare("skylight, red green blue", lambda: segment(colour, "skylight"), kmeans)
    compare("mixture of Gaussians, one channel", lambda: segment(grey, "gmm"), kmeans, 1)
    large = scene(HD)
    for method in ("otsu", "watershed", "skylight"):
        compare(f"{method}, red green blue, {HD[1]} × {HD[0]}", lambda method=method: segment(large, method), kmeans)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "video.mp4"
        writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"mp4v"), FRAMES_PER_SECOND, HD[::-1])
        for k in range(N_FRAMES):
            writer.write(np.roll(large, k, axis=1)[..., ::-1])
        writer.release()
        for method in ("otsu", "watershed", "skylight"):
            used = time.process_time()
            taken = seconds(lambda method=method: [segment(frame, method) for _, frame in video_frames(video)])
            used = time.process_time() - used
            print(
                f"{f'video {HD[1]} × {HD[0]}, read and {method}':52s} {1e3 * taken / N_FRAMES:9.2f} ms a frame, "
                f"{N_FRAMES / FRAMES_PER_SECOND / taken:.1f} × as fast as it plays on {os.cpu_count()} cores; "
                f"{1e3 * used / N_FRAMES:.1f} ms of processor time"
            )


if __name__ == "__main__":
    main()
