"""The three built sites: long enough, free where the camera goes, the same from the same seed."""

import numpy as np
import pytest

from insectnav.experiments.stone2016_places.passages import PASSAGES, SITE_SEEDS, ground_of, poses_of
from insectnav.experiments.stone2016_places.sites import BMX, CITY, SITES, YARD
from insectnav.worlds.traverse import way_length

NEAR = 0.25  # [m] about the camera, where no middle of a triangle may be


@pytest.fixture(scope="module", params=list(SITES))
def site(request: pytest.FixtureRequest):
    return SITES[request.param]


def test_ways_are_as_long_as_published():
    assert {site.name: site.length for site in SITES.values()} == {
        "City": 520.0,
        "BMX Track": 600.0,
        "Disposal Site": 510.0,
    }
    for site in SITES.values():
        assert way_length(site.build(1, 0.0).way) >= site.length


def test_ten_frames_are_two_seconds_of_travel(site):
    seconds = site.length / site.speed
    assert 10 * seconds / site.n_frames == pytest.approx(2.0, rel=2e-3)


def test_nothing_stands_where_the_camera_passes(site):
    ground = ground_of(site.name, SITE_SEEDS[site.name], 0.0)
    corners = np.asarray(ground.mesh.vertices, np.float64)
    low, high = corners.min(axis=1), corners.max(axis=1)
    for number in range(len(PASSAGES[site.name])):
        places = poses_of(site, ground, number, site.n_frames, 0).position
        for start in range(0, len(places), 100):
            some = places[start : start + 100]
            near = (low < some.max(axis=0) + 1.0).all(axis=1) & (high > some.min(axis=0) - 1.0).all(axis=1)
            middle = corners[near].mean(axis=1)
            if len(middle):
                away = np.linalg.norm(middle[None] - some[:, None], axis=-1).min()
                assert away > NEAR


def test_same_seed_gives_the_same_site_and_time_moves_no_house():
    first, second, later = BMX.build(5, 0.0), BMX.build(5, 0.0), BMX.build(5, 60.0)
    np.testing.assert_array_equal(first.mesh.vertices, second.mesh.vertices)
    assert not np.array_equal(first.mesh.vertices, later.mesh.vertices)
    bricks = [
        ground.mesh.vertices[ground.mesh.material == ground.mesh.materials.index("tiles")] for ground in (first, later)
    ]
    np.testing.assert_array_equal(*bricks)
    other = BMX.build(6, 0.0)
    assert first.mesh.n_triangles != other.mesh.n_triangles


def test_the_yard_and_the_side_road_are_free_of_trees():
    ground = YARD.build(2, 0.0)
    names = [ground.mesh.materials.index(name) for name in ("bark", "needles")]
    trees = ground.mesh.vertices[np.isin(ground.mesh.material, names)].reshape(-1, 3)
    low = trees[trees[:, 2] < 1.5]
    in_yard = (low[:, 0] < -4.5) & (low[:, 1] > 327.0) & (low[:, 1] < 383.0)
    on_road = (low[:, 0] > 8.0) & (low[:, 0] < 38.0) & (np.abs(low[:, 1] - 172.0) < 1.0)
    assert not in_yard.any()
    assert not on_road.any()


def test_city_is_ridden_above_what_moves():
    assert CITY.eye_height > 1.8  # [m] of the tallest person
