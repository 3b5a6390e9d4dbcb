"""The rendered walk: its days and poses, the mirror, and what is kept of its frames."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.angles import wrap
from insectnav.experiments.stone2014_places import fig_4ab
from insectnav.experiments.stone2014_places.mirror import LARGEST_ANGLE, in_mirror, mirror_pixels, unwrapped
from insectnav.experiments.stone2014_places.street_trees import CROWNS, ROW
from insectnav.experiments.stone2014_places.walk import DAYS, VARIATIONS, city_of, walked
from insectnav.experiments.stone2014_places.walk_frames import (
    SKY_SIZE,
    Section,
    above_horizon,
    grey_of,
    section_arrays,
    sections,
)
from insectnav.worlds.lit_world import light_world
from insectnav.worlds.rays import cast_rays
from insectnav.worlds.sky import sky_at
from insectnav.worlds.traverse import way_length

SMALL = {"every": 40, "resolution_deg": 3.0, "supersampling": 1, "mirror_size": 91}


# Days and poses.


def test_days_have_the_published_frames_and_times():
    assert {name: day.n_frames for name, day in DAYS.items()} == {"january": 1337, "april": 1452}
    assert DAYS["january"].start.endswith("T11:40")
    assert DAYS["april"].start.endswith("T15:47")  # 16:47 in British summer time
    assert DAYS["january"].weather == "overcast"
    assert DAYS["january"].foliage < DAYS["april"].foliage


@pytest.mark.parametrize("name", DAYS)
def test_the_walk_goes_from_end_to_end_at_one_frame_a_second(name: str):
    held, straight = walked(name, 0)
    length = way_length(city_of(DAYS[name], 0.0, 0).route)
    assert 1900.0 < length < 2100.0  # "a 2 km route"
    assert_allclose(held.distance[[0, -1]], [0.0, length])
    assert_allclose(held.time, np.arange(DAYS[name].n_frames), atol=1e-6)
    assert_allclose(held.position[:, 2], 2.0)  # on level ground, 2 m up
    assert len(held) == len(straight) == DAYS[name].n_frames


def test_the_rig_sways_as_much_as_is_said():
    held, straight = walked("april", 3)
    turned = np.rad2deg(wrap(held.heading - straight.heading))
    for values, expected in ((turned, 6.0), (np.rad2deg(held.pitch), 4.0), (np.rad2deg(held.roll), 4.0)):
        # Correlated over 2 m, some 700 independent values: 15 % is five standard errors of a deviation.
        assert values.std() == pytest.approx(expected, rel=0.15)
    aside = np.linalg.norm(held.position[:, :2] - straight.position[:, :2], axis=1)
    assert np.sqrt((aside**2).mean()) == pytest.approx(0.5, rel=0.3)  # over 20 m: some 50 values
    other = walked("april", 4)[0]
    assert not np.allclose(wrap(other.heading - walked("april", 4)[1].heading), wrap(held.heading - straight.heading))


def test_lines_of_the_two_days_are_a_metre_apart():
    still = VARIATIONS["no sway at all"]
    january, april = (walked(name, 0, still)[0] for name in DAYS)
    middle = [np.abs(january.position[:, None, :2] - april.position[None, ::50, :2])[..., k] for k in (0, 1)]
    nearest = np.hypot(*middle).min(axis=0)
    assert np.median(nearest) == pytest.approx(1.0, abs=0.25)  # frames are 1.5 m apart
    assert_array_equal(january.pitch, 0.0)


def test_variations_have_names_of_their_own_and_change_what_they_say():
    assert list(VARIATIONS) == [variation.name for variation in VARIATIONS.values()]
    assert VARIATIONS["as set"].day("april") == DAYS["april"]
    assert VARIATIONS["bare trees on both days"].day("april").foliage == DAYS["january"].foliage
    assert VARIATIONS["one line"].day("april").offset == 0.0
    same = VARIATIONS["one weather and sun"].day("april")
    assert (same.weather, same.start) == (DAYS["january"].weather, DAYS["january"].start)
    level = walked("april", 0, VARIATIONS["no tilt"])[0]
    assert_array_equal(level.roll, 0.0)
    assert level.heading.std() > 0.0
    with pytest.raises(Exception, match="day"):
        VARIATIONS["as set"].day("may")


def test_street_trees_stand_beside_the_way_on_their_stretches():
    day = DAYS["april"]
    without, city = city_of(replace(day, trees="none"), 0.0, 0), city_of(day, 0.0, 0)
    n = without.mesh.n_triangles
    assert_array_equal(city.mesh.vertices[:n], without.mesh.vertices)
    names = np.asarray(city.mesh.materials)[city.mesh.material]
    assert_array_equal(names[:n], np.asarray(without.mesh.materials)[without.mesh.material])
    assert set(names[n:]) == {"leaves", "bark"}
    feet = city.mesh.vertices[n:][names[n:] == "bark"]
    feet = feet[feet[..., 2].max(axis=1) < 12.0].reshape(-1, 3)
    low = feet[feet[:, 2] < 0.01, :2]
    away = np.hypot(*(low[:, None] - city.route[None]).transpose(2, 0, 1)).min(axis=1)
    assert 1.0 < away.min() < away.max() < 3.0  # 2 m aside, trunks of 0.2 m, a way point every metre
    bare = city_of(DAYS["january"], 0.0, 0)
    assert bare.mesh.n_triangles < city.mesh.n_triangles


def test_crowns_reach_over_the_walk_on_their_stretches_alone():
    names = {}
    for variation in ("as set", "crowns over the way"):
        day = VARIATIONS[variation].day("april")
        position = walked("april", 0, VARIATIONS[variation])[0].position[::12]
        world = light_world(city_of(day, 0.0, 0), sky_at(np.datetime64("2014-04-15T15:47"), 55.94, -3.19, "clear"))
        up = np.broadcast_to([0.0, 0.0, 1.0], (len(position), 1, 3))
        names[variation] = cast_rays(world.shape, position, up)[0][:, 0] >= 0
    is_there = CROWNS.covers(np.arange(0, 1452, 12) / 1451)
    assert names["crowns over the way"][is_there].mean() > 0.15  # leaves of April, 0.4 of those of summer
    assert not names["crowns over the way"][~is_there].any()
    assert names["as set"].mean() < 0.01  # a row of trees 2 m beside the way does not cover it


def test_places_are_covered_by_the_share_of_the_way():
    assert ROW.covers([0.11, 0.12, 0.17, 0.18, 0.47, 0.8]).tolist() == [False, True, True, False, True, True]


# The mirror.


def test_the_mirror_shows_ahead_at_the_top_and_the_right_on_the_right():
    pixels = mirror_pixels(91, 5.0)
    azimuth = np.broadcast_to(np.arange(72.0), (21, 72))  # columns, of which 36 is ahead
    seen = in_mirror(azimuth, pixels)
    assert seen[10, 45] in (35.0, 36.0)
    assert seen[45, 80] in (53.0, 54.0)  # 90° to the right
    assert seen[45, 10] in (17.0, 18.0)
    assert not pixels.seen[0, 0]


def test_the_horizon_lies_where_a_paraboloid_has_it():
    # r = tan(angle / 2): the horizon at tan 45° of tan 52.5°, the rim at 15° below it.
    pixels = mirror_pixels(691, 1.0)
    elevation = np.broadcast_to((89.5 - np.arange(105.0))[:, None], (105, 360))
    column = in_mirror(elevation, pixels)[345]
    radius = (np.flatnonzero(column[346:] < 0.0)[0] + 0.5) / 345.5
    assert radius == pytest.approx(1.0 / np.tan(LARGEST_ANGLE / 2.0), abs=0.006)


def test_a_mirror_picture_unwrapped_is_the_panorama():
    pixels = mirror_pixels(691, 3.0)
    picture = np.random.default_rng(0).random((35, 120))
    back = unwrapped(in_mirror(picture, pixels), pixels)
    assert_array_equal(back[5:], picture[5:])  # nearer to the zenith columns are narrower than pixels of the mirror


# Frames.


def test_sections_hold_every_frame_of_both_days_once():
    numbers: dict[str, list[int]] = {name: [] for name in DAYS}
    for cell in fig_4ab.grid("full"):
        last = min(cell.first + cell.n_frames * cell.every, DAYS[cell.day].n_frames)
        numbers[cell.day] += range(cell.first, last, cell.every)
    assert {name: len(found) for name, found in numbers.items()} == {"january": 1337, "april": 1452}
    assert all(found == list(range(len(found))) for found in numbers.values())
    assert all(setting["first"] < 420 for setting in sections(20, every=5, stop=420))


def test_a_section_is_the_same_each_time_and_padded_at_its_end():
    section = Section(day="april", first=1440, n_frames=3, **SMALL)
    arrays = section_arrays.__wrapped__(section, 0)
    again = section_arrays.__wrapped__(section, 0)
    for name, (dimensions, values) in arrays.items():
        assert len(dimensions) == values.ndim
        assert len(values) == 3
        assert_array_equal(values, again[name][1])
    assert arrays["number"][1].tolist() == [1440, -1, -1]
    sky = np.unpackbits(arrays["binary_sky"][1][0], count=SKY_SIZE**2)
    assert 0.02 < sky.mean() < 0.8
    assert arrays["right_pixels"][1][0] > 0.9
    other = section_arrays.__wrapped__(section, 1)  # another city, another noise
    assert not np.array_equal(other["colours"][1][0], arrays["colours"][1][0])


def test_share_above_the_horizon_is_that_of_the_solid_angle():
    layer = np.zeros((105, 360))
    layer[:90] = 1.0
    assert above_horizon(layer) == pytest.approx(1.0)
    layer[:60] = 0.0  # the sphere between 0 and 30° of elevation is sin 30° of the hemisphere
    assert above_horizon(layer) == pytest.approx(0.5, abs=1e-3)


def test_grey_weighs_colours_as_for_a_screen():
    colours = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]], np.uint8)
    assert grey_of(colours).tolist() == [76, 150, 29, 255]
