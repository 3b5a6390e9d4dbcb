"""What is rendered: all that is settled and checked before the first frame."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from insectnav import __version__
from insectnav.checks import InputError, check_range
from insectnav.experiments.experiment import code_version
from insectnav.experiments.rendering.cameras import CameraParams
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.paths import PathParams, poses_in
from insectnav.experiments.rendering.pictures import LABELS, PictureParams, material_labels
from insectnav.experiments.rendering.places import Place, PlaceParams, open_place
from insectnav.experiments.rendering.scenes import Moment, moments
from insectnav.records import Poses
from insectnav.vision.cameras import Camera, panorama
from insectnav.worlds import render

MAX_SECONDS = 31 * 86400.0
PLACES_AT_ONCE = 20_000


@dataclass(frozen=True, kw_only=True)
class RenderParams:
    """What `insectnav render` is run with.

    Parameters
    ----------
    place : PlaceParams
    light : LightParams
    path : PathParams
    camera : CameraParams
    pictures : PictureParams
    refresh_s : float
        Seconds after which sun, clouds, cars and people are brought up to date.
    """

    place: PlaceParams
    light: LightParams = field(default_factory=LightParams)
    path: PathParams = field(default_factory=PathParams)
    camera: CameraParams = field(default_factory=CameraParams)
    pictures: PictureParams = field(default_factory=PictureParams)
    refresh_s: float = 30.0  # [s] assumed: clouds drift a quarter of a kilometre, and the sun an eighth of a degree


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A path through a place, frame by frame; made by `planned`.

    Parameters
    ----------
    params : RenderParams
    place : Place
        At the first moment.
    poses : Poses
        One for each frame.
    parts : sequence of Moment
        Frames in the same light, in order.
    camera : Camera
    names : of the pictures of each frame
    """

    params: RenderParams
    place: Place
    poses: Poses
    parts: Sequence[Moment]
    camera: Camera
    names: tuple[str, ...]

    @property
    def lit(self) -> tuple[str, ...]:
        """Pictures of light, rather than of labels or of flat greys."""
        return () if self.place.light == "flat" else tuple(name for name in self.names if name not in LABELS)

    def about(self) -> dict[str, Any]:
        """All that the pictures follow from, and what their labels mean."""
        settings = asdict(self.params)
        if self.place.light == "flat":
            del settings["light"]
        labels = {"material_labels": material_labels()} if "material" in self.names else {}
        return {
            "insectnav": __version__,
            "code": code_version(),
            "origin": dict(self.place.origin),
            "frames": len(self.poses),
            "pictures": list(self.names),
            "size_px": list(self.camera.size),
            **labels,
            "parameters": settings,
        }


def planned(params: RenderParams) -> Plan:
    """Places, moments and pictures, checked.

    Raises
    ------
    InputError
        If a frame would be outside of the world, inside a solid, or in the dark.
    """
    place = open_place(params.place)
    names = params.pictures.chosen(place.light)
    poses = poses_in(place, params.path)
    check_range("time", poses.time, -MAX_SECONDS, MAX_SECONDS, "s", "seconds since 1970, not since the first frame?")
    parts = moments(poses.time, params.refresh_s)
    if place.light == "sky":
        for moment in parts:
            params.light.sky(moment.seconds)  # refuses the night
    _check_places(place, poses)
    camera = params.camera.camera()
    return Plan(params=params, place=place, poses=poses, parts=parts, camera=camera, names=names)


@contextmanager
def numbered_as(indices: Sequence[int]) -> Iterator[None]:
    """Context in which the renderer's complaint about a position has the number of the frame.

    Parameters
    ----------
    indices : numbers of the frames that are rendered together
    """
    try:
        yield
    except InputError as error:
        raise InputError(
            re.sub(r"^position (\d+) ", lambda found: f"frame {indices[int(found[1])]} ", str(error))
        ) from None


def _check_places(place: Place, poses: Poses) -> None:
    """Refuse, before the first frame, places outside of the world or inside a solid."""
    world, look = place.flat(), panorama(10.0, (0.0, 90.0))
    for first in range(0, len(poses), PLACES_AT_ONCE):
        position = poses.position[first : first + PLACES_AT_ONCE]
        with numbered_as(range(first, first + len(position))):
            render(world, position, np.zeros(len(position)), camera=look, layers=("sky",), supersampling=1)
