"""How far the accuracies of Table I depend on reflectances, air, clouds, exposure, noise and lens flare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2014_sky_segmentation.photographs import (
    FullSpectrum,
    photograph,
    seen_share_of_sun,
    view,
)
from insectnav.experiments.stone2014_sky_segmentation.scenes import NUMBERS, SCENES, lit_scene
from insectnav.experiments.stone2014_sky_segmentation.table_1 import Cell
from insectnav.experiments.stone2014_sky_segmentation.variations import AS_SET, VARIATIONS, varied_camera
from insectnav.experiments.stone2014_sky_segmentation.ways import WAYS, sky_mask
from insectnav.metrics.segmentation import accuracy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Table I"
TITLE = "how the accuracies of Table I move with reflectances, air, clouds, exposure, noise and flare"
SHOWN = {"k-means, visible": "orange", "k-means, UV-G": "green", "k-means, UV": "purple", "watershed, UV": "black"}
TRIED = tuple(way for way in WAYS if way.name in SHOWN)
NAMES = tuple(way.name for way in TRIED)
QUICK = (6, 8)  # numbers of the scenes of the quick grid


def grid(scale: str) -> Sequence[Cell]:
    """All scenes at 151 × 100 pixels, or two of them at 75 × 50."""
    if scale == "full":
        return [Cell(scene=scene.name, reduction=4, supersampling=4) for scene in SCENES]
    return [Cell(scene=SCENES[number].name, reduction=8, supersampling=2) for number in QUICK]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Accuracy of each way under each variation."""
    number = NUMBERS[cell.scene]
    scene, lit = SCENES[number], lit_scene(number)
    pitch = float(np.deg2rad(scene.pitch_deg))
    how = FullSpectrum(reduction=cell.reduction, supersampling=cell.supersampling)
    unchanged = view(lit, scene.eye_height, pitch, how)
    sun_share = seen_share_of_sun(lit, scene.eye_height)
    right = np.empty((len(VARIATIONS), len(TRIED)))
    for k, variation in enumerate(VARIATIONS):
        world = variation.world(lit) if variation.is_of_the_light else lit
        layers = view(world, scene.eye_height, pitch, how) if variation.is_of_the_light else unchanged
        picture = photograph(layers, world.sky, pitch, sun_share, varied_camera(how, variation), seed)
        right[k] = [100.0 * accuracy(sky_mask(picture, way, seed), picture.sky) for way in TRIED]
    names = ", ".join(variation.name for variation in VARIATIONS)
    return {
        "accuracy": (("variation", "way"), right, {"units": "percent", "variations": names, "ways": "; ".join(NAMES)})
    }


def summarise(results: Results) -> Table:
    """A row for each variation and way."""
    rows = []
    for k, variation in enumerate(VARIATIONS):
        for i, name in enumerate(NAMES):
            right = results["accuracy"][:, k, i]
            rows.append(
                {
                    "variation": variation.name,
                    "way": name,
                    "kind": "rendered",
                    "n": len(right),
                    "mean": float(right.mean()),
                    "sd": float(right.std(ddof=1)),
                    "lowest": float(right.min()),
                }
            )
    return rows


def draw(results: Results) -> Figure:
    """Mean and standard deviation over scenes, a row for each variation."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 3.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    places = np.arange(len(VARIATIONS))
    for i, name in enumerate(NAMES):
        right = results["accuracy"][:, :, i]
        style: dict[str, Any] = {"color": COLOURS[SHOWN[name]], "marker": "o", "markersize": 3.5, "linestyle": ""}
        for axes, values in zip(panels, (right.mean(axis=0), right.std(axis=0, ddof=1)), strict=True):
            axes.axvline(values[0], color=style["color"], linewidth=0.5, linestyle=":")
            axes.plot(values, places, label=name, **style)
    panels[0].set_yticks(places, [variation.name for variation in VARIATIONS])
    panels[0].invert_yaxis()
    for axes in panels:
        axes.grid(axis="y", color="0.9", linewidth=0.5)
        axes.set_axisbelow(True)
    panels[0].set_xlabel("mean over scenes (%)")
    panels[1].set_xlabel("standard deviation over scenes (%)")
    name_panel(panels[0], "a", "labelled right")
    name_panel(panels[1], "b", "from scene to scene")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(NAMES))
    return figure


def caption(results: Results) -> str:
    """What is shown."""
    cell = results.cells[0]
    size = FullSpectrum(reduction=cell.reduction).camera.size
    return (
        f"Rendered scenes of Table I, {len(results.cells)} of them ({size[1]} × {size[0]} pixels), no photographs. One "
        "thing at a time is changed: the diffuse reflectance of all materials by as much as soils and sand differ in "
        "the source, the mirrored share of metal, which is assumed, the haze of the air, the optical depth of clouds, "
        "the texture, and what the camera does. Mean (a) and standard deviation (b) of the share "
        "labelled right; dotted: as set."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Whether UV is better and more even whatever is varied."""
    rows = {(str(row["variation"]), str(row["way"])): row for row in table}
    gains = {v.name: rows[v.name, "k-means, UV"]["mean"] - rows[v.name, "k-means, visible"]["mean"] for v in VARIATIONS}
    ratios = {v.name: rows[v.name, "k-means, visible"]["sd"] / rows[v.name, "k-means, UV"]["sd"] for v in VARIATIONS}
    n = int(table[0]["n"])
    too_few = "" if n == len(SCENES) else f"needs all {len(SCENES)} scenes, this run has {n}"
    ours = {
        "UV less visible, k-means, as set": (gains, AS_SET),
        "UV less visible, k-means, worst case": (gains, min(gains, key=lambda name: gains[name])),
        "deviation of visible light over that of UV, k-means, worst case": (
            ratios,
            min(ratios, key=lambda name: ratios[name]),
        ),
    }
    verdicts = []
    for value in published.values():
        values, name = ours[value.quantity]
        pair = ", ".join(f"{way} {rows[name, way]['mean']:.1f} ± {rows[name, way]['sd']:.1f} %" for way in NAMES)
        verdicts.append(judge(value, values[name], why=f"with {name}: {pair}", not_comparable=too_few))
    return verdicts
