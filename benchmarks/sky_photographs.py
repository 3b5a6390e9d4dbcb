"""How well each method finds the sky in two sets of real photographs with masks, and how its constants were chosen.

    python benchmarks/sky_photographs.py              a line for each method and set, as in docs/sky-segmentation.md
    python benchmarks/sky_photographs.py --choose     weights of skylight chosen on each half, measured on the other

The photographs are found through INSECTNAV_DATA. "others" are every other photograph, on which no constant was chosen:
those of odd number, counted from 0 in the order of names. Pixels without a label do not count, but in the column "all"
they count as ground. In the fisheye pictures what lies within 0.92 of the radius counts; beyond, the lens is dark.
"""

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from insectnav.datasets.image_folder import find_images, read_image, read_mask
from insectnav.metrics.segmentation import accuracy, intersection_over_union
from insectnav.vision.sky_geometry import geometry
from insectnav.vision.sky_segmentation import segment
from insectnav.vision.sky_training import best_threshold, label_counts
from insectnav.vision.skylight import AHEAD, UP, SkylightParams, skylight

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
METHODS = (
    ("skylight", None), ("skylight", "mean"), ("otsu", "mean"), ("otsu", "grey"), ("otsu", "blue"),
    ("watershed", "mean"), ("watershed", "blue"), ("watershed-islands", "mean"), ("watershed-islands", "blue"),
    ("trained", "mean"), ("trained", "blue"), ("kmeans", "mean"), ("kmeans", "rgb"), ("kmeans", "lab-ab"),
    ("gmm", "blue"), ("gmm", "rgb"), ("gmm", "lab-ab"),
)  # fmt: skip
GRID = {
    "blue_weight": (0.0, 1.0),
    "yellow_weight": (0.0, 2.0, 4.0, 7.0, 10.0),
    "texture_weight": (3.0, 5.0, 7.0),
    "edge_texture_share": (0.0, 0.25),
}
CASTS = (-0.03, 0.0, 0.03)  # errors of the white balance: red is raised and blue lowered by this share


@dataclass(frozen=True)
class Photograph:
    picture: np.ndarray
    sky: np.ndarray
    known: np.ndarray


@dataclass(frozen=True)
class PhotographSet:
    name: str
    photographs: tuple[Photograph, ...]
    view: dict


def read_set(name: str, ending: str, view: dict) -> PhotographSet:
    photographs = []
    for path in find_images([DATA / name]).files:
        sky, known = read_mask(path.with_name(f"{path.stem}{ending}.png"))
        photographs.append(Photograph(read_image(path), sky, known))
    return PhotographSet(name, tuple(photographs), view)


def sets() -> tuple[PhotographSet, PhotographSet]:
    return (
        read_set("camvid_sky", "_sky", {"view": "ahead"}),
        read_set("fisheye_sky", "_mask", {"view": "up", "radius": 0.92 * 160}),
    )


def masks_of(one: PhotographSet, method: str, channels: str | None) -> tuple[list, float]:
    """Masks, and the median time of one [ms]; a trained threshold comes from all other photographs of the set."""
    counts = []
    if method == "trained":
        inside = geometry(one.photographs[0].sky.shape, **one.view).valid
        counts = [label_counts(p.picture, p.sky, channels=channels, valid=p.known & inside) for p in one.photographs]
    found, times = [], []
    for k, photograph in enumerate(one.photographs):
        options = {"method": method}
        if counts:
            options = {"method": "fixed", "threshold": 255 * best_threshold(sum(counts) - counts[k])}
        started = time.perf_counter()
        found.append(segment(photograph.picture, **options, channels=channels, **one.view))
        times.append(time.perf_counter() - started)
    return found, 1e3 * float(np.median(times))


def inner(sky: np.ndarray) -> np.ndarray:
    """Pixels that are not within a pixel of the edge of a mask."""
    import cv2

    square, picture = np.ones((3, 3), np.uint8), sky.astype(np.uint8)
    return cv2.dilate(picture, square) == cv2.erode(picture, square)


def report(one: PhotographSet, method: str, channels: str | None) -> str:
    found, milliseconds = masks_of(one, method, channels)
    pairs = [(f, p, p.known & f.valid) for f, p in zip(found, one.photographs, strict=True)]
    right = np.array([accuracy(f.mask, p.sky, counts) for f, p, counts in pairs])
    overlap = np.array([intersection_over_union(f.mask, p.sky, counts) for f, p, counts in pairs])
    everywhere = np.mean([accuracy(f.mask, p.sky, f.valid) for f, p, _ in pairs])
    inside = np.mean([accuracy(f.mask, p.sky, counts & inner(p.sky)) for f, p, counts in pairs])
    sure = np.array([f.confidence for f in found])
    rank = np.corrcoef(np.argsort(np.argsort(sure)), np.argsort(np.argsort(right)))[0, 1]
    return (
        f"{one.name:12s} {method:18s}{channels or '':7s} "
        f"accuracy {100 * right.mean():6.2f} ± {100 * right.std(ddof=1):5.2f} % "
        f"(others {100 * right[1::2].mean():6.2f}, all {100 * everywhere:6.2f}, off the edge {100 * inside:6.2f}, "
        f"worst {100 * right.min():5.1f})  IoU {overlap.mean():.3f} (others {overlap[1::2].mean():.3f})  "
        f"confidence {sure.mean():.2f}, rank correlation {rank:+.2f}  {milliseconds:7.2f} ms"
    )


# How the constants of skylight were chosen.


def candidates(base: SkylightParams) -> list[SkylightParams]:
    return [
        replace(base, blue_weight=blue, yellow_weight=yellow, texture_weight=texture,
                edge_texture_weight=share * texture)
        for blue, yellow, texture, share in product(*GRID.values())
    ]  # fmt: skip


def cast(picture: np.ndarray, error: float) -> np.ndarray:
    """A photograph with an error of the white balance."""
    gains = np.array([1.0 + error, 1.0, 1.0 - error])
    return np.clip(np.rint(picture * gains), 0, 255).astype(np.uint8)


def scores_of(number: int, params: SkylightParams) -> np.ndarray:
    """Accuracy and intersection over union of each photograph of a set under each cast, (cast, photograph, 2)."""
    one = _loaded()[number]
    where = geometry(one.photographs[0].sky.shape, **one.view)
    rows = []
    for photograph in one.photographs:
        counts = photograph.known & where.valid
        masks = [skylight(cast(photograph.picture, error), where, params).mask for error in CASTS]
        rows.append([(accuracy(mask, photograph.sky, counts),
                      intersection_over_union(mask, photograph.sky, counts)) for mask in masks])  # fmt: skip
    return np.array(rows).transpose(1, 0, 2)


_SETS: list[PhotographSet] = []


def _loaded() -> list[PhotographSet]:
    if not _SETS:
        import cv2

        cv2.setNumThreads(1)
        _SETS.extend(sets())
    return _SETS


def merit(scores: np.ndarray) -> float:
    """What is maximised: mean accuracy over photographs and casts, with a tenth of the worst."""
    return float(scores[..., 0].mean() + 0.1 * scores[..., 0].min())


def choose() -> None:
    bases = AHEAD, UP
    for number, (one, base) in enumerate(zip(_loaded(), bases, strict=True)):
        tried = candidates(base)
        with ProcessPoolExecutor(2) as pool:
            results = np.array(list(pool.map(scores_of, [number] * len(tried), tried, chunksize=4)))
        ours = tried.index(base)
        halves = {"even": (slice(0, None, 2), slice(1, None, 2)), "odd": (slice(1, None, 2), slice(0, None, 2))}
        for name, (seen, others) in halves.items():
            merits = np.array([merit(scores[:, seen]) for scores in results])
            best, rank = int(np.argmax(merits)), int((merits > merits[ours]).sum()) + 1
            for label, k in (("best", best), (f"ours, rank {rank} of {len(tried)}", ours)):
                print(f"{one.name}, chosen on {name}: {label}, {weights(tried[k])}")
                print(f"    {name}: {told(results[k], seen)}; others: {told(results[k], others)}", flush=True)
        best = tried[int(np.argmax([merit(scores) for scores in results]))]
        moved = replace(bases[1 - number], **weights(best))
        print(f"{one.name}, chosen on all of it: {weights(best)}")
        print(f"    the other set: {told(scores_of(1 - number, moved), slice(None))}", flush=True)


def weights(params: SkylightParams) -> dict[str, float]:
    names = ("blue_weight", "yellow_weight", "texture_weight", "edge_texture_weight")
    return {name: getattr(params, name) for name in names}


def told(scores: np.ndarray, part: slice) -> str:
    """Accuracies of some photographs without and with casts."""
    plain, every = scores[CASTS.index(0.0), part], scores[:, part]
    return (
        f"{100 * plain[:, 0].mean():.2f} %, IoU {plain[:, 1].mean():.3f}, worst {100 * plain[:, 0].min():.1f} "
        f"(casts {100 * every[..., 0].mean():.2f} %, worst {100 * every[..., 0].min():.1f})"
    )


def main() -> None:
    if not DATA.is_dir():
        sys.exit(f"{DATA} is missing: set INSECTNAV_DATA")
    if "--choose" in sys.argv:
        choose()
        return
    for one in sets():
        segment(one.photographs[0].picture, "skylight", **one.view)  # compiles, or loads what was compiled
        for method, channels in METHODS:
            print(report(one, method, channels), flush=True)


if __name__ == "__main__":
    main()
