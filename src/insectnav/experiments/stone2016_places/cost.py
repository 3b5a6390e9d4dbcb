"""Section V-E: what a frame costs, from its picture to what is compared, in processor time of one core."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, SINGLE_COLUMN
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2016_places.frames import (
    FULL_SIZE,
    N_BANDS,
    Recorded,
    Section,
    camera_of,
    record,
    sky_grid,
    sky_masks,
    sky_sampler,
)
from insectnav.experiments.stone2016_places.passages import SITE_SEEDS
from insectnav.experiments.stone2016_places.sites import CITY
from insectnav.matching import build_rotation_index
from insectnav.matching.visual_words import build_vocabulary
from insectnav.vision.descriptors import contour_amplitudes, patch_normalised, sphere_amplitudes, zernike_amplitudes
from insectnav.vision.descriptors.patch_normalised import NOTHING
from insectnav.vision.sphere import THESIS_N_POINTS, SphereGrid, fibonacci, thesis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "section V-E"
TITLE = "cost of a frame: segmentation, descriptors, words, matching over all rotations"
RINGS, POINTS = "harmonics, 120 × 240 directions", "harmonics, 2000 points"
HALF_BANDS, HALF_POINTS = "the same, half the bands", "the same, half the points"
N_WORDS = 200  # fewer than FAB-MAP has in Figs 8 and 9: finding features takes most of the time
WAYS = (
    "sky by Otsu",
    "sky onto the sphere",
    RINGS,
    POINTS,
    HALF_BANDS,
    HALF_POINTS,
    "Zernike, order 16",
    "outline of the sky",
    "patches of 32 × 64 pixels",
    "features and words",
    "all rotations, each reference",
)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One measurement of all.

    Parameters
    ----------
    repeat : number of the measurement
    n_frames : that are worked on together
    size : of the round picture [px]
    """

    repeat: int
    n_frames: int
    size: int = FULL_SIZE


def grid(scale: str) -> Sequence[Cell]:
    """Nine measurements of 64 frames, or three of 16."""
    n, n_frames = (9, 64) if scale == "full" else (3, 16)
    return [Cell(repeat=k, n_frames=n_frames) for k in range(n)]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Processor time of each way, which is not the same from one run to the next.

    Every way is called once before it is timed, so that nothing is compiled or tabulated meanwhile.
    """
    ways = _ways(cell.n_frames, cell.size, seed)
    found = []
    for name in WAYS:
        call, n = ways[name]
        call()
        before = time.process_time()
        call()
        found.append(1e3 * (time.process_time() - before) / n)
    return {
        "milliseconds": (("way",), np.array(found), {"units": "ms of one core for a frame", "ways": ", ".join(WAYS)})
    }


@lru_cache(maxsize=1)
def half_the_points() -> SphereGrid:
    """Half as many directions as the paper's, spread over the upper hemisphere in the same way."""
    return fibonacci(THESIS_N_POINTS // 2, (0.0, 90.0))


@lru_cache(maxsize=1)
def _recorded(n_frames: int, size: int, seed: int) -> Recorded:
    of_frames = CITY.n_frames
    section = Section(
        site=CITY.name, site_seed=SITE_SEEDS[CITY.name], time_s=0.0, passage=3, first=0, n_frames=n_frames,
        of_frames=of_frames, size=size, supersampling=1,
    )  # fmt: skip
    return record(section, seed)


@lru_cache(maxsize=1)
def _ways(n_frames: int, size: int, seed: int) -> dict[str, tuple[Callable[[], Any], int]]:
    """What is timed, and for how many frames, or pairs of them, it stands."""
    recorded, grey = _recorded(n_frames, size, seed), _recorded(n_frames, size, seed).grey
    masks, sampler = sky_masks(recorded.uv, camera_of(size)), sky_sampler(size, "rings")
    rings, points = sampler(masks, unseen=0.0), sky_sampler(size, "points")(masks, unseen=0.0)
    upper = rings.reshape(-1, *(sky_grid().shape or ()))[:, : N_BANDS // 2]
    vocabulary = build_vocabulary(grey, N_WORDS, seed)
    skies = rings >= 0.5
    index = build_rotation_index(skies, sampler.seen, sky_grid())
    few = slice(0, n_frames, max(n_frames // 4, 1))
    calls: list[tuple[Callable[[], Any], int]] = [
        (lambda: sky_masks(recorded.uv, camera_of(size)), n_frames),
        (lambda: sampler(masks, unseen=0.0), n_frames),
        (lambda: sphere_amplitudes(rings, sky_grid(), N_BANDS), n_frames),
        (lambda: sphere_amplitudes(points, thesis(), N_BANDS), n_frames),
        (lambda: sphere_amplitudes(points, thesis(), N_BANDS // 2), n_frames),
        (lambda: sphere_amplitudes(points[..., ::2], half_the_points(), N_BANDS), n_frames),
        (lambda: zernike_amplitudes(upper), n_frames),
        (lambda: contour_amplitudes(masks), n_frames),
        (lambda: patch_normalised(grey, rounded=True, flat_patch=NOTHING), n_frames),
        (lambda: vocabulary.bags(grey), n_frames),
        (lambda: index.match(skies[few], sampler.seen), len(skies[few]) * n_frames),
    ]
    return dict(zip(WAYS, calls, strict=True))


def summarise(results: Results) -> Table:
    """A row for each way."""
    return [
        {
            "way": name,
            "kind": "rendered",
            "n": len(results.cells),
            "n_frames": results.cells[0].n_frames,
            "median_ms": float(np.median(measured)),
            "least_ms": float(measured.min()),
            "most_ms": float(measured.max()),
        }
        for name, measured in zip(WAYS, results["milliseconds"].T, strict=True)
    ]


def draw(results: Results) -> Figure:
    """Processor time of each way, and the published time of the transform."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(SINGLE_COLUMN, 2.6), layout="constrained")
    axes = figure.subplots()
    measured = results["milliseconds"]
    middle, place = np.median(measured, axis=0), np.arange(len(WAYS))
    spread = np.abs(np.stack([measured.min(axis=0), measured.max(axis=0)]) - middle)
    for chosen, colour in ((True, "blue"), (False, "grey")):
        some = np.array([(name in (RINGS, POINTS)) == chosen for name in WAYS])
        axes.errorbar(middle[some], place[some], xerr=spread[:, some], fmt="o", color=COLOURS[colour], markersize=4)
    axes.plot([40.0], [WAYS.index(POINTS)], "D", color=COLOURS["orange"], markersize=4)
    axes.annotate("published", (40.0, WAYS.index(POINTS) - 0.3), ha="center", fontsize=6.0)
    axes.set_xlim(0.01, 100.0)
    axes.grid(axis="x", linewidth=0.3)
    axes.set_yticks(place, list(WAYS))
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("time of one core for a frame (ms)")
    return figure


def caption(results: Results) -> str:
    """What the figure shows."""
    cell = results.cells[0]
    return (
        f"Processor time of one core for a frame, in batches of {cell.n_frames} rendered frames of {cell.size} × "
        f"{cell.size} pixels: median, least and most of {len(results.cells)} measurements on one machine. The "
        "transform and the amplitudes of 120 bands are in blue, the published time of the same on 2000 points is the "
        "diamond. Matching over all rotations is for a query and one reference; the rest for a frame."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """The published time of the transform, which ours should not exceed; machines differ."""
    rows = {row["way"]: row for row in table}
    all_of_it = rows[POINTS]["median_ms"]
    ours = {
        "transform and amplitudes, 2000 points": all_of_it,
        "transform and amplitudes, 120 × 240 directions": rows[RINGS]["median_ms"],
        "time with half the bands over that with all": rows[HALF_BANDS]["median_ms"] / all_of_it,
        "time with half the points over that with all": rows[HALF_POINTS]["median_ms"] / all_of_it,
    }
    why = "processor time of one core of another machine, under whatever load it had"
    return [judge(value, ours[value.quantity], why=why) for value in published.values()]
