"""How fast pictures become a map: from files to places on disk, with the ratio to one picture after the other.

Pictures of 64 × 32 pixels are made up; times do not depend on what they show. The plain way reads each with OpenCV,
takes mean and standard deviation of each patch with NumPy, and writes all of it with `numpy.save`; it keeps no small
pictures. Seconds of processors, all threads together, stand beside those by the clock, which on a machine that others
use holds threads that waited. Run it by ``make bench``.
"""

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from insectnav.experiments.place_maps.build import BuildParams, build
from insectnav.experiments.place_maps.locate import LocateParams, locate
from insectnav.matching.places import PlaceMap

N_FRAMES, N_PLAIN, N_RUNS = 1200, 200, 5


def took(function: Callable[[], object]) -> np.ndarray:
    """Seconds by the clock, and of processors, all threads together."""
    started = np.array([time.perf_counter(), time.process_time()])
    function()
    return np.array([time.perf_counter(), time.process_time()]) - started


def written(folder: Path) -> Path:
    """A folder of pictures of a strip along which a camera moves."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    strip = np.kron(rng.integers(0, 256, (32, N_FRAMES // 2 + 64), dtype=np.uint8), np.ones((1, 4), np.uint8))
    for k in range(N_FRAMES):
        cv2.imwrite(str(folder / f"{k:05d}.png"), strip[:, 2 * k : 2 * k + 64])
    return folder


def plain(folder: Path, out: Path) -> None:
    """Patch-normalised pictures, one after the other, patch by patch."""
    rows = []
    for path in sorted(folder.iterdir())[:N_PLAIN]:
        picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE).astype(float)
        normal = np.zeros_like(picture)
        for top in range(0, 32, 8):
            for left in range(0, 64, 8):
                patch = picture[top : top + 8, left : left + 8]
                normal[top : top + 8, left : left + 8] = (patch - patch.mean()) / max(patch.std(ddof=1), 1e-9)
        rows.append(normal.ravel())
    np.save(out, np.array(rows, np.float32))


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pictures = written(folder / "walk")
        build([str(pictures)], folder / "first", BuildParams())  # compiles
        runs, ratios = [], []
        for run in range(N_RUNS):
            own = took(lambda run=run: build([str(pictures)], folder / f"map{run}", BuildParams()))
            other = took(lambda: plain(pictures, folder / "plain.npy")) * N_FRAMES / N_PLAIN
            runs.append(own)
            ratios.append(other / own)
        clock, processor = N_FRAMES / np.median(runs, axis=0)
        by_clock, by_processor = (statistics.median(column) for column in zip(*ratios, strict=True))
        print(
            f"build: {clock:.0f} pictures/s by the clock, {processor:.0f} in a second of a processor; "
            f"{by_clock:.1f} and {by_processor:.1f} times the plain way"
        )
        place_map = PlaceMap.open(folder / "first")
        locate(place_map, [str(pictures)], LocateParams())
        found = min(
            (locate(place_map, [str(pictures)], LocateParams()).seconds for _ in range(3)), key=lambda s: s["matching"]
        )
        print(f"locate: {found['describing']:.2f} s to describe {N_FRAMES} queries, {found['matching']:.2f} s to match")


if __name__ == "__main__":
    main()
