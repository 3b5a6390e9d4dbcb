"""How fast places are found on maps of ten thousand to a million, and what an index finds of what all pairs do.

The route is made up: 120 features, each a first-order autoregression that forgets in 10 frames (correlation e^-1),
standard deviation (1 + k)^-1/2 for feature k. Second drives run over parts of it at 0.9 to 1.1 times its speed, between
its frames, with noise of so many times the standard deviation of each feature: half of its variance anew in each frame,
half with a memory of 10 frames, as light and season have. As many queries again are of a way that is not on the map.

Times are seconds of processors, all threads together, since other work on the machine then does not count; those of a
stream are of its one thread, median over frames. Maps are made in the folder for temporary files: 0.7 GB for a million.
Run it by ``make bench``, or ``PYTHONPATH=tests python benchmarks/places.py 10000 100000`` for smaller maps alone.
"""

import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from insectnav.matching import MapAbout, Matches, PlaceMap, difference_matrix, seqslam
from insectnav.metrics.retrieval import precision_recall, recall_at_full_precision

FEATURES, MEMORY = 120, 10.0  # [frame]
NOISES = (0.3, 0.6, 0.9, 1.2)
DRIVE = 60  # [frame]
ABOUT = MapAbout(descriptor="autoregression", metric="euclidean", n_features=FEATURES)
SCALE = (1.0 + np.arange(FEATURES)) ** -0.5


class Drive(NamedTuple):
    """Frames one after the other and where on the map each is; NaN where it is not."""

    descriptors: np.ndarray
    place: np.ndarray


class Cost(NamedTuple):
    """Seconds of processors for a query."""

    exact: float
    index: float
    stream: float


def remembered(rng: np.random.Generator, n: int) -> np.ndarray:
    """Features (n, FEATURES) of unit variance that forget in MEMORY frames."""
    keep = np.exp(-1.0 / MEMORY)
    out = np.empty((n, FEATURES), np.float32)
    for k in range(FEATURES):
        steps = np.sqrt(1.0 - keep**2) * rng.standard_normal(n, np.float32)
        out[:, k] = lfilter([1.0], [1.0, -keep], steps, zi=[keep * rng.standard_normal()])[0]
    return out


def second_drive(route: np.ndarray, noise: float, rng: np.random.Generator) -> Drive:
    place = rng.integers(0, len(route) - 2 * DRIVE) + rng.uniform(0.9, 1.1) * np.arange(DRIVE)
    whole, part = place.astype(int), (place % 1.0)[:, None]
    between = (1.0 - part) * route[whole] + part * route[whole + 1]
    changed = (rng.standard_normal((DRIVE, FEATURES)) + remembered(rng, DRIVE)) / np.sqrt(2.0)
    return Drive((between + noise * SCALE * changed).astype(np.float32), place)


def other_drive(noise: float, rng: np.random.Generator) -> Drive:
    elsewhere = second_drive(remembered(rng, 4 * DRIVE) * SCALE, noise, rng)
    return Drive(elsewhere.descriptors, np.full(DRIVE, np.nan))


def processors(function: Callable[[], object]) -> float:
    started = time.process_time()
    function()
    return time.process_time() - started


def peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def whole_matrix(folder: Path) -> None:
    rng = np.random.default_rng(1)
    route, queries = (rng.random((10_000, FEATURES), np.float32) for _ in range(2))
    made = PlaceMap.build(folder / "matrix", route, ABOUT)
    seqslam(difference_matrix(route[:99], queries[:99], "euclidean"))  # compiles, or loads what was compiled
    made.locate(queries[:99])
    started = time.perf_counter()
    ours = processors(lambda: made.locate(queries))
    clock, memory = time.perf_counter() - started, peak()
    matrix = processors(lambda: seqslam(difference_matrix(route, queries, "euclidean")))
    print(
        f"10 000 × 10 000, exact: {ours:.2f} s of processors ({clock:.2f} by the clock), peak {memory:.2f} GiB in all; "
        f"by the matrix of all differences {matrix / ours:.2f} times as long, {peak():.2f} GiB",
        flush=True,
    )


def streamed(made: PlaceMap, drive: Drive, search: str) -> float:
    """Seconds of this thread for a new frame, the median once a sequence is known."""
    stream, times = made.stream(search=search), []
    for frame in drive.descriptors:
        started = time.thread_time()
        stream, _ = stream.locate_next(frame)
        times.append(time.thread_time() - started)
    return float(np.median(times[11:]))


def right(matches: Matches, drive: Drive) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(matches.reference - drive.place) <= 1.5)[5:-5]


def recall(found: Sequence[Matches], drives: Sequence[Drive]) -> float:
    """Without error, of the queries that are on the map."""
    is_right = np.concatenate([right(matches, drive) for matches, drive in zip(found, drives, strict=True)])
    scores = np.concatenate([matches.score[5:-5] for matches in found])
    is_known = np.concatenate([np.isfinite(drive.place[5:-5]) for drive in drives])
    return recall_at_full_precision(precision_recall(is_right, scores, is_known))


def compare(made: PlaceMap, route: np.ndarray, n_drives: int) -> Cost:
    """What is found at each noise, and what it costs."""
    costs = []
    for noise in NOISES:
        rng = np.random.default_rng(7)
        drives = [second_drive(route, noise, rng) for _ in range(n_drives)]
        strange = [other_drive(noise, rng) for _ in range(n_drives)]
        found, cost = {}, {}
        for search in ("exact", "index"):
            started = time.process_time()
            found[search] = [made.locate(drive.descriptors, search=search) for drive in drives + strange]
            cost[search] = (time.process_time() - started) / (2 * n_drives * DRIVE)
        of = {name: np.concatenate([m.reference[5:-5] for m in some[:n_drives]]) for name, some in found.items()}
        is_right = {
            name: np.concatenate([right(m, drive) for m, drive in zip(some, drives, strict=False)])
            for name, some in found.items()
        }
        is_kept = np.abs(of["index"] - of["exact"]) <= 1
        recalls = [recall(found[name], drives + strange) for name in ("exact", "index")]
        scores = [np.nanmedian(np.concatenate([m.score for m in found[name][:n_drives]])) for name in found]
        shares = [is_right["exact"].mean(), is_right["index"].mean(), is_kept.mean(), is_kept[is_right["exact"]].mean()]
        print(
            f"  noise {noise}: right {shares[0]:.3f} exact, {shares[1]:.3f} index; kept of all {shares[2]:.3f}, of the "
            f"right {shares[3]:.3f}; recall without error {recalls[0]:.2f}, {recalls[1]:.2f}; median score "
            f"{scores[0]:.2f}, {scores[1]:.2f}",
            flush=True,
        )
        costs.append(Cost(cost["exact"], cost["index"], streamed(made, drives[0], "index")))
    return Cost(*np.median(costs, axis=0))


def many_queries(made: PlaceMap, route: np.ndarray) -> None:
    rng = np.random.default_rng(9)
    frames = np.concatenate([second_drive(route, 0.6, rng).descriptors for _ in range(40)])
    counts = np.array([150, 600, 2400])
    times = [processors(lambda n=n: made.locate(frames[:n], search="index")) for n in counts]
    slope = np.polyfit(np.log(counts), np.log(times), 1)[0]
    print(f"time grows with queries to the power {slope:.2f} ({', '.join(f'{t:.2f} s' for t in times)})")


def main() -> None:
    sizes = [int(word) for word in sys.argv[1:]] or [10_000, 100_000, 1_000_000]
    costs = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole_matrix(folder)
        for n in sizes:
            route = remembered(np.random.default_rng(0), n) * SCALE.astype(np.float32)
            made = PlaceMap.build(folder / str(n), route, ABOUT)
            frozen = processors(made.freeze)
            warm = second_drive(route, 0.5, np.random.default_rng(3)).descriptors
            opened = processors(lambda made=made, warm=warm: made.locate(warm[:11], search="index"))
            print(f"{n} places: frozen in {frozen:.2f} s, index loaded in {opened:.2f} s of processors", flush=True)
            cost = compare(made, route, 10 if n < 10**6 else 4)
            costs.append(cost)
            print(
                f"  a query costs {1e3 * cost.exact:.2f} ms exact, {1e3 * cost.index:.2f} ms by the index "
                f"(1/{cost.exact / cost.index:.1f}); a new frame of a stream {1e3 * cost.stream:.2f} ms",
                flush=True,
            )
        many_queries(made, route)
    if len(sizes) > 1:
        for search, times in (("exact", [c.exact for c in costs]), ("by the index", [c.index for c in costs])):
            slope = np.polyfit(np.log(sizes), np.log(times), 1)[0]
            print(f"time of a query, {search}, grows with the map to the power {slope:.2f}")
    print(f"peak {peak():.2f} GiB")


if __name__ == "__main__":
    main()
