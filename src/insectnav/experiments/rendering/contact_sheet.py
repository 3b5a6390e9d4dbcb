"""A sheet of some of the frames, for a person to see what was rendered."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.datasets.image_folder import read_image
from insectnav.experiments.figures import DOUBLE_COLUMN, journal_style
from insectnav.experiments.rendering.pictures import SKY_LABEL, UNSEEN_LABEL
from insectnav.experiments.rendering.plan import Plan
from insectnav.vision.cameras import EQUIRECTANGULAR
from insectnav.vision.sensor import srgb_encoded

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES = {
    "uv": "ultraviolet, 350 nm",
    "blue": "blue, 450 nm",
    "green": "green, 520 nm",
    "red": "red, 620 nm",
    "visible": "visible",
    "grey": "flat grey",
    "sky_mask": "sky mask",
    "sky_share": "share of sky",
    "material": "material",
    "depth": "nearness",
}
MARGIN_LEFT, MARGIN_RIGHT, MARGIN_TOP, MARGIN_BOTTOM = 0.42, 0.06, 0.36, 0.34  # [inch]
GAP_X, GAP_Y = 0.1, 0.07  # [inch]
MAX_HEIGHT, LEAST_WIDTH = 9.0, 4.2  # [inch]
WIDE = 0.6  # rows over columns, below which a picture fills the width of a page


def draw_sheet(file: Path, plan: Plan, path: Callable[[str, int], Path], rows: Sequence[Mapping[str, Any]]) -> None:
    """Draw the first, the middle and the last frame in columns; of a single frame of an upright camera, all in a grid.

    Parameters
    ----------
    file : Path
        To write, a PNG.
    plan : Plan
    path : from the name of a picture and the number of a frame to its file
    rows : of the table of frames
    """
    chosen = sorted({0, (len(rows) - 1) // 2, len(rows) - 1})
    is_grid = len(chosen) == 1 and plan.camera.size[0] / plan.camera.size[1] > WIDE
    n_columns = min(2, len(plan.names)) if is_grid else len(chosen)
    n_rows = -(-len(plan.names) // n_columns) if is_grid else len(plan.names)
    with journal_style():
        figure, cells = _grid(plan, n_columns, n_rows)
        for column, index in enumerate(chosen):
            for row, name in enumerate(plan.names):
                axes = cells[row // n_columns][row % n_columns] if is_grid else cells[row][column]
                _draw(axes, displayed(read_image(path(name, index)), name, plan), _extent(plan))
                _label(axes, plan, name, is_left=column == 0, is_lowest=row == n_rows - 1)
            cells[0][column].set_title(_heading_of(rows[index], len(rows)), fontsize=6.0, loc="left", pad=3.0)
        left = MARGIN_LEFT if _extent(plan) else MARGIN_RIGHT
        figure.text(left / figure.get_figwidth(), 1.0 - 0.12 / figure.get_figheight(), _title(plan),
                    fontsize=7.0, va="center")  # fmt: skip
        figure.savefig(file, dpi=200, metadata={"Software": None})


def _draw(axes: Axes, shown: Any, extent: tuple[float, float, float, float] | None) -> None:
    is_grey = shown.ndim == 2
    axes.set_visible(True)
    axes.imshow(
        shown, cmap="gray" if is_grey else None, vmin=0, vmax=1, extent=extent, aspect="auto",
        interpolation="antialiased",
    )  # fmt: skip


def displayed(picture: Any, name: str, plan: Plan) -> Any:
    """Values in 0…1 for a screen, (row, column) or (row, column, 3), of a picture as it is on disk.

    Parameters
    ----------
    picture : array
    name : of the picture
    plan : Plan
    """
    if name == "depth":
        with np.errstate(divide="ignore"):
            near = np.where(picture > 0, 1.0 / picture, 0.0)
        return np.sqrt(near / max(float(near.max()), 1e-9))
    if name == "material":
        return _label_colours()[picture]
    if picture.dtype.kind == "f":
        values = picture / max(float(np.quantile(picture, 0.98)), 1e-9) if name in plan.lit else picture
        return srgb_encoded(np.clip(values, 0.0, 1.0)) if name in plan.lit else np.clip(values, 0.0, 1.0)
    values = picture / np.float64(np.iinfo(picture.dtype).max)
    is_linear = name in plan.lit and plan.params.pictures.sensor.response == "linear"
    return srgb_encoded(values) if is_linear else values


def _label_colours() -> Any:
    """A colour for each label, (256, 3): black for the sky and for what is not seen."""
    from matplotlib import colormaps

    colours = colormaps["tab20"](np.arange(256) % 20)[:, :3]
    colours[[SKY_LABEL, UNSEEN_LABEL]] = 0.0
    return colours


def _grid(plan: Plan, n_columns: int, n_rows: int) -> tuple[Figure, list[list[Axes]]]:
    """Figure with axes of the shape of the pictures, by row and column; invisible until they are drawn on."""
    from matplotlib.figure import Figure

    shape = plan.camera.size[0] / plan.camera.size[1]
    left = MARGIN_LEFT if _extent(plan) else MARGIN_RIGHT
    bottom = MARGIN_BOTTOM if _extent(plan) else MARGIN_RIGHT
    across = (DOUBLE_COLUMN - left - MARGIN_RIGHT - GAP_X * (n_columns - 1)) / n_columns
    high = min(across * shape, (MAX_HEIGHT - MARGIN_TOP - bottom - GAP_Y * (n_rows - 1)) / n_rows)
    across = high / shape
    width = max(left + MARGIN_RIGHT + across * n_columns + GAP_X * (n_columns - 1), LEAST_WIDTH)
    height = MARGIN_TOP + bottom + high * n_rows + GAP_Y * (n_rows - 1)
    figure = Figure(figsize=(width, height))

    def add(row: int, column: int) -> Axes:
        low = height - MARGIN_TOP - (row + 1) * high - row * GAP_Y
        return figure.add_axes(
            ((left + column * (across + GAP_X)) / width, low / height, across / width, high / height), visible=False
        )

    return figure, [[add(row, column) for column in range(n_columns)] for row in range(n_rows)]


def _extent(plan: Plan) -> tuple[float, float, float, float] | None:
    """Azimuths and elevations at the edges of a panorama [°]; None of other pictures."""
    camera = plan.camera
    if camera.model != EQUIRECTANGULAR:
        return None
    rows, columns = camera.size
    pixel = 360.0 / columns
    top = camera.centre[1] * pixel
    return -180.0, 180.0, top - rows * pixel, top


def _label(axes: Axes, plan: Plan, name: str, *, is_left: bool, is_lowest: bool) -> None:
    """Ticks in degrees on panoramas, none on other pictures; the name of the picture in its corner."""
    for spine in axes.spines.values():
        spine.set(visible=True, color="0.6", linewidth=0.4)  # white skies would run into the page
    extent = _extent(plan)
    if extent is None:
        axes.set(xticks=[], yticks=[])
    else:
        axes.set(xticks=(-180, -90, 0, 90, 180), yticks=[tick for tick in (-90, -45, 0, 45, 90) if extent[2] <= tick])
        axes.tick_params(labelleft=is_left, labelbottom=is_lowest, length=2.0)
        if is_lowest:
            axes.set_xlabel("to the right of straight ahead (°)", labelpad=1.0)
            axes.get_xticklabels()[0].set_horizontalalignment("left")
            axes.get_xticklabels()[-1].set_horizontalalignment("right")
        if is_left:
            axes.set_ylabel("elevation (°)", labelpad=1.0)
    text = axes.text(0.012, 0.96, TITLES[name], transform=axes.transAxes, va="top", fontsize=6.0, color="white")
    text.set_bbox({"facecolor": "black", "alpha": 0.55, "linewidth": 0.0, "pad": 1.2})


def _heading_of(row: Mapping[str, Any], n_frames: int) -> str:
    """What stands above a column."""
    heading, pitch, roll = (round(row[f"{name}_deg"]) for name in ("heading", "pitch", "roll"))
    x, y = (round(row[f"{axis}_m"], 1) + 0.0 for axis in "xy")
    place = f"({x:.1f}, {y:.1f}) m, {heading}°"
    if row["pitch_deg"] or row["roll_deg"]:
        place += f", pitch {pitch}°, roll {roll}°"
    return place if n_frames == 1 else f"{row['frame']}: {place}"


def _title(plan: Plan) -> str:
    """World and light in one line."""
    n = len(plan.poses)
    words = [plan.place.name, f"{n} frames" if n > 1 else "one frame"]
    if plan.place.light == "sky":
        light = plan.params.light
        sky = light.sky(plan.parts[0].seconds)
        words += [light.weather, f"sun {np.rad2deg(sky.sun_elevation):.0f}° high"]
        if light.sun_deg is None:
            words.insert(2, f"{light.date} {light.time}")
    if plan.place.foliage is not None:
        words.append(f"foliage {plan.place.foliage:g}")
    return ", ".join(words)
