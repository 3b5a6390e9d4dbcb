"""Passages of a camera through a site: each of its own time, light, clouds, traffic, lane, speed and sway."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from insectnav.angles import Floats
from insectnav.experiments.stone2016_places.sites import SITES, Ground, Site
from insectnav.records import Poses
from insectnav.worlds.clouds import weather_clouds
from insectnav.worlds.lit_world import LitWorld, light_world
from insectnav.worlds.shapes import generator
from insectnav.worlds.sky import Sky
from insectnav.worlds.sun import sun_position
from insectnav.worlds.traverse import Jitter, carried, swayed

BIELEFELD = 52.03, 8.53  # [°] latitude, longitude; Borgholzhausen is 20 km away
# How much a camera sways; assumed, and larger on the car, which drives over bumpy trails.
ON_HELMET = Jitter(
    yaw=float(np.deg2rad(5.0)), pitch=float(np.deg2rad(3.0)), roll=float(np.deg2rad(3.0)),
    lateral=0.25, correlation_length=4.0,
)  # fmt: skip
ON_CAR = Jitter(
    yaw=float(np.deg2rad(6.0)), pitch=float(np.deg2rad(5.0)), roll=float(np.deg2rad(5.0)),
    lateral=0.2, correlation_length=1.5,
)  # fmt: skip
SPEED_WAVES = ((4.0, 0.08), (9.0, 0.05))  # periods along the way, share of the mean speed; assumed
# Share of the way where the zig-zag begins, length of a swing [m], largest turn off the course [rad]; assumed
ZIGZAG_FROM, ZIGZAG_LENGTH, ZIGZAG_YAW = 0.7, 9.0, float(np.deg2rad(35.0))
SECONDS_APART = 397.0  # between passages, for what moves


@dataclass(frozen=True, kw_only=True)
class Passage:
    """One passage through a site.

    Parameters
    ----------
    clock : date and time (UTC) of its middle; the light stays as it is then
    weather : of `insectnav.worlds.clouds.weather_clouds`
    cloud_seed : where clouds are; they drift with the time of day
    tilt_deg : of the camera, about the lateral axis of the bicycle, nose up
    jitter : how it sways
    lane : half the range of the passages' distance to the middle of the way, to its right or left [m]
    has_zigzag : whether the end is driven in a zig-zag
    aside : to the right of that lane [m]
    as_passage : number of the passage whose lane, speed, sway and traffic it has; -1 for its own
    """

    clock: str
    weather: str
    cloud_seed: int
    jitter: Jitter
    lane: float
    tilt_deg: float = 0.0
    has_zigzag: bool = False
    aside: float = 0.0
    as_passage: int = -1

    @property
    def sky(self) -> Sky:
        """Sun and clouds at that time; north is +y."""
        time = np.datetime64(self.clock)
        azimuth, elevation = sun_position(time, *BIELEFELD)
        seconds = (time - time.astype("datetime64[D]")) / np.timedelta64(1, "s")
        clouds = weather_clouds(self.weather, self.cloud_seed)
        return Sky(sun_azimuth=float(azimuth), sun_elevation=float(elevation), clouds=clouds, time=float(seconds))


TILTS_DEG = (-30.0, -20.0, -10.0, 0.0, 0.0, 10.0, 20.0, 30.0)  # section IV-B
# "around 3pm" in summer time: one after the other, seven minutes each; date, weather and order are assumed.
IN_CITY = tuple(
    Passage(
        clock=f"2015-07-15T{12 + (36 + 7 * k) // 60}:{(36 + 7 * k) % 60:02d}", weather="scattered", cloud_seed=4,
        jitter=ON_HELMET, lane=0.5, tilt_deg=tilt,
    )
    for k, tilt in enumerate(TILTS_DEG)
)  # fmt: skip
# The level passages again, to tell what spoils the matching: without clouds, sway, or both; and the second on another
# lane of the road.
STEADY = Jitter(lateral=ON_HELMET.lateral, correlation_length=ON_HELMET.correlation_length)
LEVEL = 3, 4
VARIED = (
    *(
        replace(IN_CITY[number], weather=weather, jitter=jitter, as_passage=number)
        for weather, jitter in (("clear", ON_HELMET), ("scattered", STEADY), ("clear", STEADY))
        for number in LEVEL
    ),
    replace(IN_CITY[LEVEL[1]], as_passage=LEVEL[1], aside=-2.0),
)
# "on two different days, at different times of day"; which days, times and weathers is assumed.
ON_TRACK: tuple[Passage, ...] = (
    Passage(clock="2015-07-20T09:30", weather="scattered", cloud_seed=5, jitter=ON_CAR, lane=0.3),
    Passage(clock="2015-07-23T14:30", weather="clear", cloud_seed=6, jitter=ON_CAR, lane=0.3),
)
AT_YARD: tuple[Passage, ...] = (
    Passage(clock="2015-07-27T09:00", weather="broken", cloud_seed=7, jitter=ON_CAR, lane=0.3),
    Passage(clock="2015-07-30T13:00", weather="scattered", cloud_seed=8, jitter=ON_CAR, lane=0.3, has_zigzag=True),
)
# The second passages of the car again, on another lane.
ON_TRACK = (*ON_TRACK, replace(ON_TRACK[1], as_passage=1, aside=1.0))
AT_YARD = (*AT_YARD, replace(AT_YARD[1], as_passage=1, aside=1.0))
PASSAGES = {"City": IN_CITY + VARIED, "BMX Track": ON_TRACK, "Disposal Site": AT_YARD}
SITE_SEEDS = {"City": 3, "BMX Track": 11, "Disposal Site": 21}


def drawn_as(site: str, number: int) -> int:
    """Number of the passage whose lane, speed, sway and traffic a passage has: its own, as a rule."""
    other = PASSAGES[site][number].as_passage
    return number if other < 0 else other


@lru_cache(maxsize=1)
def ground_of(site: str, seed: int, time_s: float) -> Ground:
    """A site at a time; the last one is kept."""
    return SITES[site].build(seed, time_s)


@lru_cache(maxsize=1)
def lit_ground(site: str, seed: int, time_s: float) -> LitWorld:
    """The same under some sky; `LitWorld.under` gives it that of a passage."""
    ground = ground_of(site, seed, time_s)
    return light_world(ground.mesh, PASSAGES[site][0].sky, ground=ground.ground)


@lru_cache(maxsize=1)
def lit_passage(site: str, seed: int, time_s: float, number: int) -> LitWorld:
    """A site in the light of a passage; the last one is kept, for sections of a passage follow each other."""
    return lit_ground(site, seed, time_s).under(PASSAGES[site][number].sky)


def distances(site: Site, number: int, n_frames: int, seed: int) -> Floats:
    """How far each frame of a passage is along the way, (frame,) [m]: from start to end, at a speed that varies.

    The speed is 1 + Σ a sin(2π (f s + φ)) of the mean, s the share of the way, f and a of `SPEED_WAVES`, φ at random.
    """
    phase = generator(seed, f"speed {site.name} {drawn_as(site.name, number)}").random(len(SPEED_WAVES))
    share = np.arange(n_frames) / max(n_frames - 1, 1)
    way = share.copy()
    for (count, strength), start in zip(SPEED_WAVES, phase, strict=True):
        angle = 2.0 * np.pi * (count * share + start)
        way -= strength * (np.cos(angle) - np.cos(angle[0])) / (2.0 * np.pi * count)
    return np.clip(site.length * way / way[-1], 0.0, site.length)


def whole_or_why_not(site: Site, n_frames: int) -> str:
    """Why numbers of so many frames of a passage are not held against published ones; nothing if all are there."""
    if n_frames == site.n_frames:
        return ""
    return f"{n_frames} frames of a part of the way, expected all {site.n_frames}: run it at full scale"


def true_references(reference: Floats, query: Floats) -> Floats:
    """Reference frame [frame] at which each query is on the way, between frames by interpolation, (query,)."""
    return np.interp(query, reference, np.arange(len(reference)))


def poses_of(site: Site, ground: Ground, number: int, n_frames: int, seed: int) -> Poses:
    """Where the camera of a passage is in each frame, and how it is held.

    Parameters
    ----------
    site : Site
    ground : the same, built
    number : of the passage
    n_frames : over the whole way
    seed : of lane, speed and sway
    """
    passage = PASSAGES[site.name][number]
    along = distances(site, number, n_frames, seed)
    drawn = drawn_as(site.name, number)
    lane = passage.lane * (2.0 * generator(seed, f"lane {site.name} {drawn}").random() - 1.0)
    poses = carried(ground.way, along, offset=lane + passage.aside, speed=site.speed)
    course = np.asarray(poses.heading)
    poses = swayed(poses, passage.jitter, seed=seed + 100 * drawn + 1, course=course)
    if passage.has_zigzag:
        poses = _zigzagging(poses, along / site.length, course)
    position = np.array(poses.position)
    position[:, 2] = site.eye_height
    return replace(poses, position=position, pitch=poses.pitch + np.deg2rad(passage.tilt_deg))


def _zigzagging(poses: Poses, share: Floats, course: Floats) -> Poses:
    """The same on a way that swings to both sides towards the end, with the heading that follows from it."""
    angle = 2.0 * np.pi * poses.distance / ZIGZAG_LENGTH
    slope = np.clip((share - ZIGZAG_FROM) / 0.02, 0.0, 1.0) * np.tan(ZIGZAG_YAW)
    aside = -slope * ZIGZAG_LENGTH / (2.0 * np.pi) * np.cos(angle)
    right = np.stack([np.cos(course), -np.sin(course)], axis=-1)
    position = np.array(poses.position)
    position[:, :2] += aside[:, None] * right
    return replace(poses, position=position, heading=poses.heading + np.arctan(slope * np.sin(angle)))
