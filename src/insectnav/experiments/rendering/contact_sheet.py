"""A sheet of some of the frames, for a person to see what was rendered."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.datasets.picture_files import read_picture
from insectnav.experiments.figures import DOUBLE_COLUMN, SINGLE_COLUMN, journal_style
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
MAX_HEIGHT = 9.0  # [inch]


def draw_sheet(file: Path, plan: Plan, path: Callable[[str, int], Path], rows: Sequence[Mapping[str, Any]]) -> None:
    """Draw the first, the middle and the last frame, one in each column, all their pictures below each other.

    Parameters
    ----------
    file : Path
        To write, a PNG.
    plan : Plan
    path : from the name of a picture and the number of a frame to its file
    rows : of the table of frames
    """
    chosen = sorted({0, (len(rows) - 1) // 2, len(rows) - 1})
    with journal_style():
        figure, cells = _grid(plan, len(chosen))
        for column, index in enumerate(chosen):
            for name, axes in zip(plan.names, cells[column], strict=True):
                shown = displayed(read_picture(path(name, index)), name, plan)
                is_grey = shown.ndim == 2
                axes.imshow(
                    shown, cmap="gray" if is_grey else None, vmin=0, vmax=1, extent=_extent(plan), aspect="auto",
                    interpolation="antialiased",
                )  # fmt: skip
                _label(axes, plan, name, is_left=column == 0, is_lowest=name == plan.names[-1])
            cells[column][0].set_title(_heading_of(rows[index], len(rows)), fontsize=6.5, loc="left", pad=3.0)
        figure.text(MARGIN_LEFT / figure.get_figwidth(), 1.0 - 0.12 / figure.get_figheight(), _title(plan),
                    fontsize=7.5, va="center")  # fmt: skip
        figure.savefig(file, dpi=200, metadata={"Software": None})


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
        return (picture.astype(np.float64) * 0.381966) % 1.0  # neighbours in the table differ in brightness
    if picture.dtype.kind == "f":
        values = picture / max(float(np.quantile(picture, 0.98)), 1e-9) if name in plan.lit else picture
        return srgb_encoded(np.clip(values, 0.0, 1.0)) if name in plan.lit else np.clip(values, 0.0, 1.0)
    values = picture / np.float64(np.iinfo(picture.dtype).max)
    is_linear = name in plan.lit and plan.params.pictures.sensor.response == "linear"
    return srgb_encoded(values) if is_linear else values


def _grid(plan: Plan, n_columns: int) -> tuple[Figure, list[list[Axes]]]:
    """Figure with axes of the shape of the pictures, by column and picture."""
    from matplotlib.figure import Figure

    rows, columns = plan.camera.size
    shape = rows / columns
    width = DOUBLE_COLUMN if n_columns > 1 or shape < 0.6 else SINGLE_COLUMN
    across = (width - MARGIN_LEFT - MARGIN_RIGHT - GAP_X * (n_columns - 1)) / n_columns
    n = len(plan.names)
    high = min(across * shape, (MAX_HEIGHT - MARGIN_TOP - MARGIN_BOTTOM - GAP_Y * (n - 1)) / n)
    across = high / shape
    width = MARGIN_LEFT + MARGIN_RIGHT + across * n_columns + GAP_X * (n_columns - 1)
    height = MARGIN_TOP + MARGIN_BOTTOM + high * n + GAP_Y * (n - 1)
    figure = Figure(figsize=(max(width, SINGLE_COLUMN), height))
    width = figure.get_figwidth()
    cells = [
        [
            figure.add_axes(
                (
                    (MARGIN_LEFT + column * (across + GAP_X)) / width,
                    (height - MARGIN_TOP - (row + 1) * high - row * GAP_Y) / height,
                    across / width,
                    high / height,
                )
            )
            for row in range(n)
        ]
        for column in range(n_columns)
    ]
    return figure, cells


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
        spine.set_visible(False)
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
    place = f"x {row['x_m']:.4g} m, y {row['y_m']:.4g} m, heading {row['heading_deg']:.0f}°"
    if row["pitch_deg"] or row["roll_deg"]:
        place += f", pitch {row['pitch_deg']:.0f}°, roll {row['roll_deg']:.0f}°"
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
