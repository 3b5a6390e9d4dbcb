"""Eighteen scenes like those of Table I: what stands there, the sky, and how the camera is held.

Twelve follow the names that the table gives to its pictures, six are of the same kinds; the paper names no more. They
are stand-ins: nothing is known of the places but the names. Places of plants and clouds were chosen by looking at the
pictures, before any of them was segmented.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from insectnav.angles import wrap
from insectnav.experiments.stone2014_sky_segmentation import scene_buildings as built
from insectnav.experiments.stone2014_sky_segmentation import scene_landscapes as land
from insectnav.records import Mesh
from insectnav.worlds.clouds import CloudField, weather_clouds
from insectnav.worlds.lit_world import LitWorld, light_world
from insectnav.worlds.sky import Sky
from insectnav.worlds.sun import sun_position

SEVILLE, SUSSEX, EDINBURGH = (37.39, -5.99), (50.87, -0.10), (55.94, -3.19)  # [°] latitude, longitude
DAY = "2013-07-15"  # pictures were taken in July 2013
DARK_CLOUDS = CloudField(cover=0.85, optical_depth=100.0, variation=0.9, base_height=900.0, size=2500.0)  # assumed


@dataclass(frozen=True, kw_only=True)
class Scene:
    """One picture to be taken.

    Parameters
    ----------
    name : as in Table I, or in its manner
    is_named : whether Table I names it
    build : what stands there; the camera is at the origin of x and y and looks along +y
    place : latitude and longitude [°]
    clock : time of DAY, UTC
    facing_deg : compass direction in which the camera looks
    weather : of `insectnav.worlds.clouds.weather_clouds`, or "dark"
    cloud_seed : where clouds are
    eye_height : of the camera [m]
    pitch_deg : upwards
    """

    name: str
    is_named: bool
    build: Callable[[], Mesh]
    place: tuple[float, float]
    clock: str
    facing_deg: float
    weather: str
    cloud_seed: int = 0
    eye_height: float = 1.6
    pitch_deg: float = 8.0

    @property
    def sky(self) -> Sky:
        """The sky with the direction of the camera as its north."""
        return scene_sky(self.place, f"{DAY}T{self.clock}", self.facing_deg, self.weather, self.cloud_seed)


def scene_sky(place: tuple[float, float], time: str, facing_deg: float, weather: str, cloud_seed: int) -> Sky:
    """Sky over a place [°] at a time (UTC), with the direction in which a camera looks [°] as its north."""
    azimuth, elevation = sun_position(np.datetime64(time), *place)
    clouds = replace(DARK_CLOUDS, seed=cloud_seed) if weather == "dark" else weather_clouds(weather, cloud_seed)
    turned = float(wrap(azimuth - np.deg2rad(facing_deg)))
    return Sky(sun_azimuth=turned, sun_elevation=float(elevation), clouds=clouds)


@lru_cache(maxsize=2)
def lit_scene(number: int) -> LitWorld:
    """The world of a scene under its sky; two are kept for those who ask again."""
    scene = SCENES[number]
    mesh = scene.build()
    return light_world(mesh, scene.sky, ground=mesh.materials[-1])


SCENES = (
    Scene(
        name="Desert scrub, Seville", is_named=True, build=partial(land.desert_scrub, 1), place=SEVILLE,
        clock="10:00", facing_deg=300.0, weather="clear", eye_height=0.25, pitch_deg=9.0,
    ),
    Scene(
        name="Forest floor, Sussex", is_named=True, build=partial(land.forest_floor, 2), place=SUSSEX,
        clock="12:00", facing_deg=20.0, weather="scattered", cloud_seed=2, eye_height=0.3, pitch_deg=30.0,
    ),
    Scene(
        name="Pond reflecting sky", is_named=True, build=partial(land.pond, 3), place=SUSSEX,
        clock="14:30", facing_deg=340.0, weather="scattered", cloud_seed=3, pitch_deg=-2.0,
    ),
    Scene(
        name="Landscape with dark clouds", is_named=True, build=partial(land.open_country, 4), place=SUSSEX,
        clock="15:30", facing_deg=60.0, weather="dark", cloud_seed=4, pitch_deg=5.0,
    ),
    Scene(
        name="Building hidden by trees", is_named=True, build=partial(built.hidden_building, 5), place=SUSSEX,
        clock="13:00", facing_deg=30.0, weather="clear", pitch_deg=9.0,
    ),
    Scene(
        name="Minaret with dark clouds", is_named=True, build=partial(built.minaret, 6), place=EDINBURGH,
        clock="16:00", facing_deg=70.0, weather="dark", cloud_seed=6, pitch_deg=20.0,
    ),
    Scene(
        name="Minaret with white clouds", is_named=True, build=partial(built.minaret, 6), place=EDINBURGH,
        clock="14:00", facing_deg=70.0, weather="scattered", cloud_seed=7, pitch_deg=20.0,
    ),
    Scene(
        name="White building on overcast day", is_named=True, build=partial(built.white_building, 8), place=EDINBURGH,
        clock="12:30", facing_deg=0.0, weather="overcast", cloud_seed=8, pitch_deg=9.0,
    ),
    Scene(
        name="City street with grey sky", is_named=True, build=partial(built.city_street, 9), place=EDINBURGH,
        clock="12:00", facing_deg=300.0, weather="overcast", cloud_seed=9, pitch_deg=10.0,
    ),
    Scene(
        name="Building with metallic roof", is_named=True, build=partial(built.metallic_roof, 10), place=SUSSEX,
        clock="13:30", facing_deg=10.0, weather="scattered", cloud_seed=10, pitch_deg=6.0,
    ),
    Scene(
        name="Building with metal wall", is_named=True, build=partial(built.metal_wall, 11), place=EDINBURGH,
        clock="15:00", facing_deg=60.0, weather="scattered", cloud_seed=11, pitch_deg=8.0,
    ),
    Scene(
        name="Buildings with reflective windows", is_named=True, build=partial(built.glass_fronts, 12),
        place=EDINBURGH, clock="13:00", facing_deg=20.0, weather="scattered", cloud_seed=12, pitch_deg=14.0,
    ),
    Scene(
        name="Scrub under scattered clouds", is_named=False, build=partial(land.desert_scrub, 13, 12), place=SEVILLE,
        clock="16:00", facing_deg=20.0, weather="scattered", cloud_seed=13, eye_height=0.25, pitch_deg=9.0,
    ),
    Scene(
        name="Edge of a wood under broken clouds", is_named=False, build=partial(land.forest_edge, 14), place=SUSSEX,
        clock="11:00", facing_deg=330.0, weather="broken", cloud_seed=14, eye_height=0.4, pitch_deg=14.0,
    ),
    Scene(
        name="Pond towards the evening sun", is_named=False, build=partial(land.pond, 15, 24.0, 8.0), place=SUSSEX,
        clock="18:30", facing_deg=250.0, weather="clear", pitch_deg=-1.0,
    ),
    Scene(
        name="Suburban street under a blue sky", is_named=False, build=partial(built.suburban_houses, 16),
        place=EDINBURGH, clock="10:30", facing_deg=340.0, weather="clear", pitch_deg=7.0,
    ),
    Scene(
        name="Church at the end of a street", is_named=False, build=partial(built.city_street, 17, 17.0, 3, True),
        place=EDINBURGH, clock="13:00", facing_deg=10.0, weather="broken", cloud_seed=17, pitch_deg=10.0,
    ),
    Scene(
        name="City street towards a low sun", is_named=False, build=partial(built.city_street, 18), place=EDINBURGH,
        clock="18:30", facing_deg=270.0, weather="clear", pitch_deg=10.0,
    ),
)  # fmt: skip
NUMBERS = {scene.name: number for number, scene in enumerate(SCENES)}
