"""A place under a sky at one moment, and the moments of a traverse."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import check_range
from insectnav.experiments.rendering.light import LightParams
from insectnav.experiments.rendering.places import Place, PlaceParams, open_place
from insectnav.worlds.lit_world import light_world
from insectnav.worlds.sky import Sky


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
    seconds : float
        When that is [s].
    """

    place: Place
    world: Any  # World or LitWorld
    sky: Sky | None
    seconds: float


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


def scene_at(
    params: PlaceParams,
    light: LightParams,
    seconds: float,
    earlier: Scene | None = None,
    *,
    keeps_traffic: bool = False,
) -> Scene:
    """The scene so many seconds after the first moment.

    Parameters
    ----------
    params : PlaceParams
    light : LightParams
    seconds : [s]
    earlier : Scene or None
        The same place at another moment, of which is kept what has not changed.
    keeps_traffic : bool
        Leave cars and people where they were earlier, which saves making the world anew.

    Raises
    ------
    InputError
        If the sun is too low, or the place cannot be made.
    """
    if earlier is None or (params.moves and seconds != earlier.seconds and not keeps_traffic):
        place = open_place(params, seconds)
        if place.light == "flat":
            return Scene(place=place, world=place.flat(), sky=None, seconds=seconds)
        sky = light.sky(seconds)
        return Scene(place=place, world=light_world(place.surfaces, sky), sky=sky, seconds=seconds)
    if earlier.sky is None or (sky := light.sky(seconds)) == earlier.sky:
        return earlier
    return Scene(place=earlier.place, world=earlier.world.under(sky), sky=sky, seconds=seconds)
