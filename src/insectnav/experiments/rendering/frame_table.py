"""The table of all frames: where each was taken, how the camera was turned, and in what light."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.datasets.pose_table import pose_columns
from insectnav.experiments.rendering.frame_store import TABLE, file_name
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.places import Place
from insectnav.experiments.rendering.scenes import Moment
from insectnav.records import Poses


def frame_rows(
    light: LightParams, place: Place, poses: Poses, parts: Sequence[Moment], found: Mapping[int, Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """A row for each frame.

    Parameters
    ----------
    light : LightParams
    place : Place
    poses : Poses
    parts : of `moments`
    found : number of the frame → what is known of it after rendering
    """
    columns = {name: values.tolist() for name, values in pose_columns(poses).items()}
    rows = []
    for part in parts:
        conditions = _conditions(light, place, part.seconds)
        for index in range(part.first, part.last):
            pose = {name: values[index] for name, values in columns.items()}
            rows.append({"frame": index, "file": file_name(index, ""), **pose, **conditions, **found[index]})
    return rows


def write_frame_table(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the rows as CSV, numbers in full.

    Parameters
    ----------
    folder : Path
    rows : of `frame_rows`
    """
    with (folder / TABLE).open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows({key: "" if value is None else value for key, value in row.items()} for row in rows)


def _conditions(light: LightParams, place: Place, seconds: float) -> dict[str, Any]:
    """Season and light of a moment; empty in flat light."""
    names = ("light_utc", "weather", "sun_azimuth_deg", "sun_elevation_deg")
    if place.light == "flat":
        return {"foliage": place.foliage, **dict.fromkeys(names)}
    sky = light.sky(seconds)
    azimuth, elevation = np.rad2deg([sky.sun_azimuth, sky.sun_elevation]).round(4).tolist()
    moment = str(light.moment(seconds).astype("datetime64[s]")) + "Z"
    return {"foliage": place.foliage, **dict(zip(names, (moment, light.weather, azimuth, elevation), strict=True))}
