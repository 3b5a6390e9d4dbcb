"""The same methods on two sets of real photographs with masks made by hand; only visible light exists there."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.datasets.image_folder import find_images, read_image, read_mask
from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2014_sky_segmentation.ways import WAYS
from insectnav.metrics.segmentation import accuracy
from insectnav.vision.sky_segmentation import segment

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Table I"
TITLE = "the same methods on two sets of real photographs, in visible light"
FOLDER = "INSECTNAV_DATA"  # variable that names the folder in which the sets are
LARGEST_SET = 71
TRIED = tuple(way for way in WAYS if way.light == "visible")
NAMES = tuple(way.name for way in TRIED)


@dataclass(frozen=True, kw_only=True)
class PhotographSet:
    """A folder of photographs, each with a mask beside it.

    Parameters
    ----------
    about : what it shows and where it is from
    mask : ending of the name of a mask
    view : options of `insectnav.vision.sky_segmentation.segment`
    """

    about: str
    mask: str
    view: Mapping[str, Any]


SETS = {
    "camvid_sky": PhotographSet(
        about="streets from a car, 240 × 180 (CamVid: Brostow et al. 2009, doi 10.1016/j.patrec.2008.04.005)",
        mask="_sky",
        view={"view": "ahead"},
    ),
    # Beyond 0.92 of the radius the lens is dark.
    "fisheye_sky": PhotographSet(
        about="one walk seen upwards through a fisheye, 320 × 320", mask="_mask", view={"view": "up", "radius": 147.2}
    ),
}
OTHER_PICTURES = "other photographs: those of the paper were not published"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One set.

    Parameters
    ----------
    photographs : name of the set
    n_images : how many of its photographs are used, evenly through it; 0 if it was not found
    """

    photographs: str
    n_images: int


def grid(scale: str) -> Sequence[Cell]:
    """All photographs that are found, or six of each set."""
    most = LARGEST_SET if scale == "full" else 6
    return [Cell(photographs=name, n_images=min(len(files_of(name)), most)) for name in SETS]


def files_of(name: str) -> tuple[Path, ...]:
    """Photographs of a set, in the order of their names; none where the set is not found."""
    folder = os.environ.get(FOLDER)
    place = Path(folder or "") / name
    return find_images([place]).files[:LARGEST_SET] if folder and place.is_dir() else ()


def simulate(cell: Cell, seed: int) -> Arrays:
    """Accuracy of each way on each photograph; NaN where there is none."""
    right = np.full((LARGEST_SET, len(TRIED)), np.nan)
    files = files_of(cell.photographs)
    chosen = np.linspace(0, len(files) - 1, cell.n_images).round().astype(int)
    about = SETS[cell.photographs]
    for row, number in enumerate(chosen):
        path = files[number]
        image = read_image(path)
        truth, known = read_mask(path.with_name(f"{path.stem}{about.mask}.png"))
        for k, way in enumerate(TRIED):
            found = segment(image, way.method, channels=way.channels, seed=seed, **about.view)
            right[row, k] = 100.0 * accuracy(found.mask, truth, known & found.valid)
    return {"accuracy": (("image", "way"), right, {"units": "percent", "ways": "; ".join(NAMES)})}


def summarise(results: Results) -> Table:
    """A row for each set and way."""
    rows = []
    for cell, arrays in results:
        for k, name in enumerate(NAMES):
            right = arrays["accuracy"][: cell.n_images, k]
            rows.append(
                {
                    "set": cell.photographs,
                    "kind": "real photographs"
                    if cell.n_images
                    else f"not found: set {FOLDER} to the folder that has it",
                    "way": name,
                    "n": cell.n_images,
                    "mean": float(right.mean()) if right.size else float("nan"),
                    "sd": float(right.std(ddof=1)) if right.size > 1 else float("nan"),
                    "lowest": float(right.min()) if right.size else float("nan"),
                }
            )
    return rows


def draw(results: Results) -> Figure:
    """A dot for each photograph and way."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 2.6), layout="constrained")
    panels = figure.subplots(1, len(results.cells), sharey=True)
    for axes, letter, (cell, arrays) in zip(panels, "ab", results, strict=True):
        name_panel(axes, letter, f"{cell.photographs}, n = {cell.n_images}")
        right = arrays["accuracy"][: cell.n_images]
        jitter = np.random.default_rng(0).uniform(-0.2, 0.2, cell.n_images)
        for k in range(len(NAMES)):
            axes.plot(k + jitter, right[:, k], ".", markersize=2.0, color=COLOURS["orange"])
            if cell.n_images > 1:
                spread = right[:, k].std(ddof=1)
                axes.errorbar(k, right[:, k].mean(), spread, fmt="_", color="black", markersize=12, linewidth=0.7)
        if not cell.n_images:
            axes.text(0.5, 0.5, f"not found in {FOLDER}", transform=axes.transAxes, ha="center")
        labels = [name.replace(", visible", "").replace(" (", "\n(") for name in NAMES]
        axes.set_xticks(range(len(NAMES)), labels, rotation=45, ha="right")
    panels[0].set_ylabel("labelled right (%)")
    panels[0].set_ylim(0.0, 101.0)
    return figure


def caption(results: Results) -> str:
    """What is shown, and of which photographs."""
    parts = []
    for cell in results.cells:
        missing = f"not found (set {FOLDER} to the folder that has it)"
        used = f"{cell.n_images} photographs" if cell.n_images else missing
        parts.append(f"{cell.photographs}, {SETS[cell.photographs].about}: {used}")
    return (
        f"Real photographs, visible light alone: no such set in ultraviolet is known to us. {'; '.join(parts)}. "
        "Share of the labelled pixels that each method labels right, a dot for each photograph; bars are means, "
        "whiskers one standard deviation."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Numbers of Table I beside ours: other photographs."""
    verdicts = []
    for value in published.values():
        photographs, _, way = value.quantity.rpartition(": ")
        found = [row["mean"] for row in table if (row["set"], row["way"]) == (photographs, way)]
        ours = found[0] if found else max((float(row["mean"]) for row in table), default=float("nan"))
        verdicts.append(judge(value, ours, not_comparable=OTHER_PICTURES))
    return verdicts
