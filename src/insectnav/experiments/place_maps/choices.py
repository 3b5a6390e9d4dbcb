"""What the user said of how frames are described, together with what the map says."""

from __future__ import annotations

from dataclasses import dataclass

from insectnav.checks import InputError, quoted
from insectnav.experiments.place_maps.describe import SKY_OF_VECTORS, VIEW_SIZE, DescribeParams
from insectnav.experiments.place_maps.view_cameras import view_camera
from insectnav.matching.difference import METRICS
from insectnav.matching.places import MapAbout

OWN = "own"  # descriptor of features from elsewhere that are not named


@dataclass(frozen=True, kw_only=True)
class GivenOptions:
    """Options as they were given; None where they were not."""

    descriptor: str | None = None
    camera: str | None = None
    sky: str | None = None
    metric: str | None = None


def chosen_params(given: GivenOptions, about: MapAbout | None, is_vectors: bool) -> DescribeParams:
    """How frames are described: as the user says, else as the map was, else by default.

    Parameters
    ----------
    given : GivenOptions
    about : of the map; None for a new one
    is_vectors : whether the frames are features already

    Raises
    ------
    InputError
        If an option differs from the map's; the sentence names it.
    """
    if given.metric is not None and given.metric not in METRICS:
        raise InputError(f"--metric {quoted(given.metric)} is unknown, expected one of {', '.join(METRICS)}")
    if is_vectors and given.camera is not None:
        raise InputError("--camera is given with features that are computed already, expected it with pictures")
    camera = None if given.camera is None else view_camera(given.camera)
    if about is None:
        usual = OWN if is_vectors else "patch-normalised"
        return DescribeParams(
            descriptor=given.descriptor or usual,
            camera=camera or view_camera("ahead"),
            sky=given.sky,
            metric=given.metric,
            is_vectors=is_vectors,
        )
    pairs = {
        "descriptor": (given.descriptor, about.descriptor),
        "camera": (camera.text if camera else None, about.camera),
        "sky": (given.sky, about.settings.get("sky")),
        "metric": (given.metric, about.metric),
    }
    for name, (wanted, there) in pairs.items():
        if wanted is not None and there not in (None, "") and wanted != there:
            raise InputError(
                f"--{name} is {quoted(wanted)}, expected {quoted(there)} as the map was made with, or no --{name}"
            )
    sky = about.settings.get("sky")
    if is_vectors:
        if given.sky is not None:
            raise InputError(SKY_OF_VECTORS)
        return DescribeParams(descriptor=about.descriptor, metric=about.metric, is_vectors=True)
    if "sky" not in about.settings:
        raise InputError(
            f"the map holds features that were computed elsewhere ({quoted(about.descriptor)}), expected such features "
            "here, too, as .npy or .zarr, not pictures"
        )
    return DescribeParams(
        descriptor=about.descriptor,
        camera=camera or view_camera(about.camera),
        sky=str(sky),
        view_size=_size(about.settings.get(VIEW_SIZE)),
    )


def _size(text: object) -> tuple[int, int] | None:
    """Rows and columns of a setting such as 35x120."""
    parts = str(text).split("x")
    if len(parts) != 2 or not all(part.isdigit() and len(part) < 6 for part in parts):
        return None
    return int(parts[0]), int(parts[1])
