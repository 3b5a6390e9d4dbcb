"""A rendered walk of two kilometres through a city on two days: where the rig is, and what stands in which light.

From the paper (section II-D): 2 km, January at 11:40 under overcast sky and April at 16:47 under blue sky with clouds,
1337 and 1452 pictures at one a second, another state of the foliage, 2 m above the ground on a pole carried by hand.
Everything else is assumed, and said so where it stands.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from insectnav.checks import check_choice
from insectnav.experiments.stone2014_places.street_trees import PLANTINGS, with_street_trees
from insectnav.records import Poses
from insectnav.worlds.builders import build_world
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.lit_world import LitWorld, light_world
from insectnav.worlds.sky import sky_at
from insectnav.worlds.traverse import Jitter, carried, lifted, swayed, way_length

EDINBURGH = 55.94, -3.19  # [°] latitude and longitude
EYE_HEIGHT = 2.0  # [m] section II-D
FRAMES_PER_SECOND = 1.0  # section II-D
# How a person holds a pole and keeps to a line: standard deviations, all assumed. The hold is forgotten within some
# steps, the line within some tens of metres.
HOLD = Jitter(yaw=np.deg2rad(6.0), pitch=np.deg2rad(4.0), roll=np.deg2rad(4.0), correlation_length=2.0)
LINE = Jitter(lateral=0.5, correlation_length=20.0)

# Section II-E ends with "the intensity value midway between the closest points of the two histogram segments": segments
# that lie apart, as islands do and merged neighbours do not. Settled on every 25th frame by the exact masks, before any
# matching: of islands no frame had less than 90 % of its pixels right, of merging a fifth in April, a third in January.
SEGMENTATION = "watershed-islands"


@dataclass(frozen=True, kw_only=True)
class Day:
    """One day's walk.

    Parameters
    ----------
    n_frames : pictures, one a second, evenly along the way
    start : date and time of the first (UTC)
    weather : of `insectnav.worlds.clouds.weather_clouds`
    cloud_seed : of the clouds
    foliage : 0 bare trees, 1 summer
    offset : of the line walked, to the right of the way [m]
    world_time : at which cars and people are seen first [s]
    trees : along stretches of the way, of `street_trees.PLANTINGS`
    number : of the day, for seeds
    """

    n_frames: int
    start: str
    weather: str
    cloud_seed: int
    foliage: float
    offset: float
    world_time: float
    number: int
    trees: str = "row"


DAYS = {
    "january": Day(
        n_frames=1337,
        start="2014-01-15T11:40",  # day of the month and year assumed
        weather="overcast",
        cloud_seed=1,
        foliage=0.0,
        offset=0.0,
        world_time=0.0,
        number=1,
    ),
    "april": Day(
        n_frames=1452,
        start="2014-04-15T15:47",  # 16:47 in summer time; day and year assumed
        weather="scattered",
        cloud_seed=2,
        foliage=0.4,  # assumed: buds open in Edinburgh in the middle of April
        offset=-1.0,  # [m] assumed
        world_time=5000.0,
        number=2,
    ),
}


@dataclass(frozen=True, kw_only=True)
class Variation:
    """What is set otherwise than above.

    Parameters
    ----------
    name : as tables have it
    trees : along stretches of the way, of `street_trees.PLANTINGS`
    has_leaves : whether April has leaves that January has not
    sway : factor on what the rig turns, tilts and strays
    tilt : factor on what it tilts alone
    offset : factor on the distance between the two lines
    has_weather : whether April has another weather than January, and another sun
    segmentation : of the ultraviolet picture, of `insectnav.vision.sky_segmentation.METHODS`
    """

    name: str
    trees: str = "row"
    has_leaves: bool = True
    sway: float = 1.0
    tilt: float = 1.0
    offset: float = 1.0
    has_weather: bool = True
    segmentation: str = SEGMENTATION

    def day(self, name: str) -> Day:
        """The day of that name under this variation."""
        check_choice("day", name, tuple(DAYS))
        day, other = DAYS[name], DAYS["january"]
        if not self.has_leaves:
            day = replace(day, foliage=other.foliage)
        if not self.has_weather:
            day = replace(day, start=other.start, weather=other.weather, cloud_seed=other.cloud_seed)
        return replace(day, offset=self.offset * day.offset, trees=self.trees)


AS_SET = Variation(name="as set")
VARIATIONS = {
    variation.name: variation
    for variation in (
        AS_SET,
        Variation(name="no trees over the way", trees="none"),
        Variation(name="crowns over the way", trees="crowns"),
        Variation(name="bare trees on both days", has_leaves=False),
        Variation(name="one weather and sun", has_weather=False),
        Variation(name="one line", offset=0.0),
        Variation(name="no tilt", tilt=0.0),
        Variation(name="no sway at all", sway=0.0),
        Variation(name="valleys merged", segmentation="watershed"),
    )
}


@lru_cache(maxsize=2)
def city_of(day: Day, seconds: float, seed: int) -> BuiltWorld:
    """The city with the foliage of that day, cars and people as they are so many seconds after the first picture."""
    city = build_world("city", seed=seed, foliage=day.foliage, time_s=day.world_time + seconds)
    planting = PLANTINGS[day.trees]
    return city if planting is None else with_street_trees(city, day.foliage, planting)


def lit_city(day: Day, seconds: float, seed: int) -> LitWorld:
    """The city in the light of that moment; clouds drift and the sun moves."""
    moment = np.datetime64(day.start) + np.timedelta64(round(seconds * 1000.0), "ms")
    sky = sky_at(moment, *EDINBURGH, day.weather, seed=day.cloud_seed)
    return light_world(city_of(day, seconds, seed), sky)


def walked(name: str, seed: int, variation: Variation = AS_SET) -> tuple[Poses, Poses]:
    """Poses of the rig at every picture of that day, and the same without sway, as the way goes."""
    day, city = variation.day(name), city_of(variation.day(name), 0.0, seed)
    length = way_length(city.route)
    distances = np.linspace(0.0, length, day.n_frames)
    speed = length / (day.n_frames - 1) * FRAMES_PER_SECOND
    straight = carried(city.route, distances, offset=day.offset, speed=speed)
    own = 1000 * seed + day.number
    hold = replace(
        HOLD,
        yaw=HOLD.yaw * variation.sway,
        pitch=HOLD.pitch * variation.sway * variation.tilt,
        roll=HOLD.roll * variation.sway * variation.tilt,
    )
    line = replace(LINE, lateral=LINE.lateral * variation.sway)
    held = swayed(swayed(straight, line, own), hold, own + 500, course=straight.heading)
    return lifted(held, city.ground_height, EYE_HEIGHT), straight
