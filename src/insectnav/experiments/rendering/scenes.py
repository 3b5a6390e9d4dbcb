"""A place under a sky at one moment, and the moments of a traverse."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import check_range
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.places import Place, PlaceParams, open_place
from insectnav.worlds.sky import Sky
from insectnav.worlds.world import World


class Moment(NamedTuple):
    """Frames that are seen in the same light, and when that is."""

    first: int
    last: int  # one after the last
    seconds: float  # since the first moment


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A place in its light.

    Parameters
    ----------
    place : Place
    world : World or LitWorld
        What the renderer takes.
    sky : Sky or None
        None in flat light.
    """

    place: Place
    world: Any
    sky: Sky | None


def moments(time: Floats, refresh_s: float) -> list[Moment]:
    """Runs of frames within the same interval of time, whose light and traffic are those of its beginning.

    Parameters
    ----------
    time : (n,) array [s], not decreasing
    refresh_s : [s], length of an interval; they are counted from time 0
    """
    check_range("refresh", refresh_s, 1e-3, 1e9, "s")
    interval = np.floor(time / refresh_s + 1e-9)
    starts = np.flatnonzero(np.diff(interval, prepend=interval[0] - 1))
    ends = [*starts[1:].tolist(), len(time)]
    return [
        Moment(int(first), last, float(interval[first] * refresh_s)) for first, last in zip(starts, ends, strict=True)
    ]


def scene_at(params: PlaceParams, light: LightParams, seconds: float, earlier: Scene | None = None) -> Scene:
    """The scene so many seconds after the first moment.

    Parameters
    ----------
    params : PlaceParams
    light : LightParams
    seconds : [s]
    earlier : Scene or None
        The same place at another moment, of which is kept what has not changed.

    Raises
    ------
    InputError
        If the sun is too low, or the place cannot be made.
    """
    is_new = earlier is None or params.moves
    place = open_place(params, seconds) if is_new or earlier is None else earlier.place
    if place.light == "flat":
        world: World = place.flat() if is_new or earlier is None else earlier.world
        return Scene(place=place, world=world, sky=None)
    from insectnav.worlds.lit_world import light_world

    sky = light.sky(seconds)
    lit = light_world(place.surfaces, sky) if is_new or earlier is None else earlier.world.under(sky)
    return Scene(place=place, world=lit, sky=sky)


def scenes(params: PlaceParams, light: LightParams, parts: Sequence[Moment]) -> Iterator[tuple[Moment, Scene]]:
    """Each moment with its scene, one at a time.

    Parameters
    ----------
    params : PlaceParams
    light : LightParams
    parts : of `moments`
    """
    scene: Scene | None = None
    for moment in parts:
        scene = scene_at(params, light, moment.seconds, scene)
        yield moment, scene
