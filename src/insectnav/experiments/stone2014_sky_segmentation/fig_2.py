"""Fig. 2: where pixels of sky and ground lie in the space of their colours, and how k-means divides it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.stone2014_sky_segmentation.photographs import FullSpectrum, Photograph, shown
from insectnav.experiments.stone2014_sky_segmentation.table_1 import Cell, photograph_of
from insectnav.experiments.stone2014_sky_segmentation.table_1_panels import label_picture
from insectnav.experiments.stone2014_sky_segmentation.ways import IN_TABLE, LIGHT_NAMES, sky_mask
from insectnav.metrics.segmentation import accuracy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "Fig. 2"
TITLE = "pixels of sky and ground in the space of their colours, and how k-means divides them"
SHOWN = ("Minaret with white clouds", "Building with metal wall")  # one that the text describes, one with bright ground
LIGHTS = ("visible", "uv-green", "uv")  # from top to bottom, as published
N_PIXELS = 200  # drawn, as published
N_SHOWN = 150  # [px] width of the pictures in the figure


def grid(scale: str) -> Sequence[Cell]:
    """Two scenes."""
    reduction = 1 if scale == "full" else 4
    return [Cell(scene=name, reduction=reduction, supersampling=4) for name in SHOWN]


def simulate(cell: Cell, seed: int) -> Arrays:
    """Pictures, labels, a random sample of pixels, and how far sky and ground lie apart in each band."""
    picture = photograph_of(cell, seed)
    ways = [next(way for way in IN_TABLE if (way.method, way.light) == ("kmeans", light)) for light in LIGHTS]
    masks = np.stack([sky_mask(picture, way, seed) for way in ways])
    draws = np.random.default_rng(seed).choice(picture.sky.size, N_PIXELS, replace=False)
    values = _values(picture)
    step = max(1, round(picture.uv.shape[1] / N_SHOWN))
    ground = ~picture.sky
    return {
        "accuracy": (
            ("light",),
            100.0 * np.array([accuracy(mask, picture.sky) for mask in masks]),
            {"units": "percent"},
        ),
        "sky_missed": (
            ("light",),
            100.0 * np.array([(~mask)[picture.sky].mean() for mask in masks]),
            {"units": "percent"},
        ),
        "ground_taken": (("light",), 100.0 * np.array([mask[ground].mean() for mask in masks]), {"units": "percent"}),
        "separation": (("value",), _separations(values, picture.sky), {"units": "1, d'"}),
        "pixels": (("pixel", "value"), values.reshape(-1, 5)[draws], {"units": "red, green, blue, UV, green filter"}),
        "pixel_label": (("light", "pixel"), masks.reshape(len(LIGHTS), -1)[:, draws]),
        "pixel_sky": (("pixel",), picture.sky.ravel()[draws]),
        "visible": (("row", "column", "band"), shown(picture.visible, N_SHOWN), {"units": "sRGB"}),
        "uv_green": (("row", "column", "two"), shown(picture.uv_green, N_SHOWN), {"units": "sRGB"}),
        "labels": (("light", "label_row", "label_column"), masks[:, ::step, ::step]),
        "sky": (("label_row", "label_column"), picture.sky[::step, ::step]),
    }


def _values(picture: Photograph) -> Any:
    """Red, green, blue, ultraviolet and green filter of each pixel as shares of saturation, (rows, columns, 5)."""
    bands = np.concatenate([picture.visible, picture.uv_green], axis=-1)
    return bands / np.iinfo(np.uint16).max


def _separations(values: Any, sky: Any) -> Any:
    """D' of sky and ground in each band (…, 5): difference of the means over the root of the mean variance.

    Notes
    -----
    Green & Swets 1966, Signal Detection Theory and Psychophysics, for unequal variances.
    """
    above, below = values[sky], values[~sky]
    return (above.mean(axis=0) - below.mean(axis=0)) / np.sqrt(0.5 * (above.var(axis=0) + below.var(axis=0)))


def summarise(results: Results) -> Table:
    """A row for each scene and light."""
    rows = []
    for cell, arrays in results:
        bands = dict(zip(("red", "green", "blue", "uv", "green_filter"), arrays["separation"], strict=True))
        for k, light in enumerate(LIGHTS):
            row = {"scene": cell.scene, "light": LIGHT_NAMES[light], "kind": "rendered"}
            row |= {name: float(arrays[name][k]) for name in ("accuracy", "sky_missed", "ground_taken")}
            rows.append(row | {f"separation_{band}": float(value) for band, value in bands.items()})
    return rows


def draw(results: Results) -> Figure:
    """For each scene and light the picture, the pixels, and the labels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(DOUBLE_COLUMN, 3.8), layout="constrained")
    parts: Any = figure.subfigures(1, len(results.cells))
    for letters, part, (cell, arrays) in zip(("abc", "def"), parts, results, strict=True):
        part.suptitle(cell.scene, fontsize=7.0)
        for row, light in enumerate(LIGHTS):
            is_solid = light == "visible"
            panels = [part.add_subplot(3, 3, 3 * row + 1), part.add_subplot(3, 3, 3 * row + 3)]
            space: Any = part.add_subplot(3, 3, 3 * row + 2, projection="3d" if is_solid else None)
            _draw_picture(panels[0], arrays, light)
            (_draw_solid if is_solid else _draw_plane)(space, arrays, light)
            panels[1].imshow(label_picture(arrays["labels"][row], arrays["sky"]))
            name_panel(panels[0], letters[row], LIGHT_NAMES[light])
            panels[1].set_title(f"{arrays['accuracy'][row]:.1f} %", loc="right", fontsize=6.0)
            for axes in panels:
                axes.axis("off")
    return figure


def _draw_picture(axes: Axes, arrays: Mapping[str, Any], light: str) -> None:
    uv, green = arrays["uv_green"][..., 0], arrays["uv_green"][..., 1]
    if light == "visible":
        axes.imshow(arrays["visible"])
    elif light == "uv":
        axes.imshow(uv, cmap="gray", vmin=0, vmax=255)
    else:
        axes.imshow(np.stack([np.zeros_like(uv), green, uv], axis=-1))


def _point_style(arrays: Mapping[str, Any], light: str) -> list[tuple[Any, dict[str, Any]]]:
    """Pixels by label and truth: blue are labelled sky, red ground, as published; crosses are labelled wrong."""
    label, sky = arrays["pixel_label"][LIGHTS.index(light)], arrays["pixel_sky"]
    found = []
    for is_sky, colour in ((True, "blue"), (False, "red")):
        for is_right, marker in ((True, "."), (False, "x")):
            chosen = (label == is_sky) & ((label == sky) == is_right)
            style = {"marker": marker, "color": COLOURS[colour], "linestyle": "", "markersize": 3.0, "alpha": 0.8}
            found.append((chosen, style | {"markeredgewidth": 0.5}))
    return found


def _draw_solid(axes: Any, arrays: Mapping[str, Any], light: str) -> None:
    for chosen, style in _point_style(arrays, light):
        axes.plot(*arrays["pixels"][chosen, :3].T, **style)
    axes.view_init(elev=22.0, azim=-55.0)
    axes.set_xlabel("red", labelpad=-14)
    axes.set_ylabel("green", labelpad=-14)
    axes.set_zlabel("blue", labelpad=-17)
    axes.set_box_aspect(None, zoom=0.85)
    axes.tick_params(labelleft=False, labelbottom=False, labelright=False, labeltop=False, length=0)


def _draw_plane(axes: Axes, arrays: Mapping[str, Any], light: str) -> None:
    across = np.random.default_rng(0).random(N_PIXELS) if light == "uv" else arrays["pixels"][:, 4]
    for chosen, style in _point_style(arrays, light):
        axes.plot(across[chosen], arrays["pixels"][chosen, 3], **style)
    axes.set_ylabel("UV", labelpad=1)
    axes.set_xlabel("at random" if light == "uv" else "green", labelpad=1)
    axes.tick_params(labelsize=5.0, pad=1)


def caption(results: Results) -> str:
    """What is shown."""
    size = FullSpectrum(reduction=results.cells[0].reduction).camera.size
    return (
        f"Rendered scenes ({size[1]} × {size[0]} pixels), no photographs. Left: visible light (a, d), ultraviolet "
        f"shown blue with green (b, e), ultraviolet (c, f). Middle: {N_PIXELS} pixels drawn at random in their space "
        "of colours, as shares of saturation; blue were labelled sky by k-means, red ground, crosses are wrong. "
        "Ultraviolet alone is spread sideways at random. Right: labels; white and black are right, blue is ground "
        "taken for sky, red is sky taken for ground, with the share labelled right."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """What the text says of the picture with white clouds."""
    rows = {row["light"]: row for row in table if row["scene"] == SHOWN[0]}
    first = rows["UV"]
    ours = {
        "UV between sky and ground over its spread": first["separation_uv"],
        "d' of UV less d' of green": first["separation_uv"] - first["separation_green_filter"],
        **{f"sky taken for ground, {light}": row["sky_missed"] for light, row in rows.items()},
    }
    why = "; ".join(
        f"{light}: {row['accuracy']:.1f} % right, {row['sky_missed']:.1f} % of the sky taken for ground, "
        f"{row['ground_taken']:.1f} % of the ground for sky"
        for light, row in rows.items()
    )
    return [judge(value, ours[value.quantity.rpartition(", ")[0]], why=why) for value in published.values()]
