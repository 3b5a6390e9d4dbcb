"""The place of the time lapse, its days, and what is measured of the labels."""

from functools import lru_cache

import numpy as np

from insectnav.experiments.stone2014_sky_segmentation.scene_buildings import city_street
from insectnav.experiments.stone2014_sky_segmentation.scenes import EDINBURGH, scene_sky
from insectnav.worlds.lit_world import LitWorld, light_world
from insectnav.worlds.sky import Sky
from insectnav.worlds.sun import sun_position

DAY = "2014-01-15"  # pictures were taken in January 2014
WEATHERS = {"clear": "sunny", "scattered": "partial cloud", "broken": "broken cloud", "overcast": "overcast"}
MINUTES = 10  # between pictures
LOWEST_SUN_DEG = 2.1  # the sky's model begins at 2°
FACING_DEG = 40.0  # so that the low sun lights one side of the street
EYE_HEIGHT, PITCH = 9.0, float(np.deg2rad(6.0))  # [m] a window of the second floor, [rad]


def moments() -> list[int]:
    """Minutes of the day (UTC) at which pictures are taken: from sunrise to sunset as far as there is a model."""
    every = np.arange(0, 24 * 60, MINUTES)
    times = np.datetime64(DAY) + every.astype("timedelta64[m]")
    elevation = np.array([float(sun_position(time, *EDINBURGH)[1]) for time in times])
    return [int(minute) for minute in every[np.rad2deg(elevation) >= LOWEST_SUN_DEG]]


def lapse_sky(weather: str, minute: int) -> Sky:
    """The sky at that minute of the day; clouds drift from one to the next."""
    time = np.datetime64(DAY) + np.timedelta64(minute, "m")
    sky = scene_sky(EDINBURGH, str(time), FACING_DEG, weather, cloud_seed=5)
    return Sky(sun_azimuth=sky.sun_azimuth, sun_elevation=sky.sun_elevation, clouds=sky.clouds, time=60.0 * minute)


@lru_cache(maxsize=1)
def lapse_place() -> LitWorld:
    """A street with bare trees and a church, under some sky; `LitWorld.under` gives it another."""
    mesh = city_street(21, 16.0, 4, True, leaves=0.0)
    return light_world(mesh, lapse_sky("clear", 12 * 60), ground=mesh.materials[-1])
