"""Ways through a world: closed forms on straight lines and squares, and the statistics of the sway."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.records import Poses
from insectnav.worlds.traverse import Jitter, along, carried, lifted, spaced, swayed, way_length
from insectnav.worlds.ways import distance_to_way

SQUARE = np.array([(0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0), (0.0, 0.0)])  # clockwise from north
LONG = np.array([(0.0, 0.0), (0.0, 40_000.0)])
SWAY = Jitter(yaw=0.1, pitch=0.05, roll=0.02, lateral=0.3, correlation_length=5.0)


def walk(spacing: float = 1.0, n: int = 20_000) -> Poses:
    return carried(LONG, spacing * np.arange(n))


def test_places_on_a_square_are_where_the_distance_says():
    assert way_length(SQUARE) == 40.0
    position, course = along(SQUARE, [0.0, 5.0, 12.0, 25.0, 35.0, 40.0])
    np.testing.assert_allclose(position, [(0, 0), (0, 5), (2, 10), (10, 5), (5, 0), (0, 0)], atol=1e-12)
    np.testing.assert_allclose(np.rad2deg(course), [0, 0, 90, -180, -90, -90], atol=1e-9)


def test_corner_is_turned_gradually():
    position, course = along(SQUARE, [9.0, 9.5, 10.0, 10.5, 11.0], turn_length=2.0)
    np.testing.assert_allclose(position[2], (0, 10), atol=1e-12)
    halfway = np.rad2deg(np.arctan2(0.5, 1.5))
    np.testing.assert_allclose(np.rad2deg(course), [0, halfway, 45, 90 - halfway, 90], atol=1e-9)
    sharp = along(SQUARE, [9.99, 10.01], turn_length=0.0)[1]
    np.testing.assert_allclose(np.rad2deg(sharp), [0, 90], atol=1e-9)


def test_way_that_turns_back_keeps_a_course():
    there_and_back = np.array([(0.0, 0.0), (0.0, 10.0), (0.0, 0.0)])
    course = along(there_and_back, [5.0, 10.0, 15.0])[1]
    np.testing.assert_allclose(np.abs(course[[0, 2]]), [0, np.pi], atol=1e-12)
    assert abs(course[1]) == pytest.approx(np.pi)  # of the leg that begins there


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=8), st.floats(0.05, 3.0))
def test_all_places_lie_on_the_way_and_none_too_far_from_the_last(corners: list, spacing: float):
    way = np.array(corners)
    assume(np.linalg.norm(np.diff(way, axis=0), axis=1).sum() > 0.01)
    poses = carried(way, spaced(way_length(way), spacing))
    assert distance_to_way(poses.position[:, :2], way).max() < 1e-6
    steps = np.linalg.norm(np.diff(poses.position[:, :2], axis=0), axis=1)
    assert (steps <= spacing * (1 + 1e-9)).all()
    np.testing.assert_allclose(np.diff(poses.distance), spacing, rtol=1e-9)


def test_spacing_counts_both_ends_where_they_fit():
    np.testing.assert_array_equal(spaced(10.0, 2.5), [0, 2.5, 5, 7.5, 10])
    np.testing.assert_array_equal(spaced(10.0, 3.0, 1.0, 8.0), [1, 4, 7])
    np.testing.assert_array_equal(spaced(10.0, 50.0), [0])


def test_walk_has_speed_offset_and_eye_above_the_ground():
    poses = carried(SQUARE, [0.0, 2.0, 14.0], offset=0.5, speed=2.0)
    np.testing.assert_allclose(poses.position[:, :2], [(0.5, 0), (0.5, 2), (4, 9.5)], atol=1e-12)
    np.testing.assert_array_equal(poses.time, [0, 1, 7])
    raised = lifted(poses, lambda xy: 0.1 * xy[:, 1], 0.3)
    np.testing.assert_allclose(raised.position[:, 2], 0.3 + 0.1 * poses.position[:, 1])
    np.testing.assert_array_equal(raised.position[:, :2], poses.position[:, :2])


def test_walk_backwards_is_turned_round():
    there, back = carried(SQUARE, [3.0]), carried(SQUARE[::-1], [37.0])
    np.testing.assert_allclose(there.position, back.position, atol=1e-12)
    assert np.cos(there.heading - back.heading) == pytest.approx(-1.0)


@pytest.mark.parametrize("spacing", [0.5, 2.0])
def test_sway_has_its_deviation_and_its_length_at_any_spacing(spacing: float):
    still, n = walk(spacing), 20_000
    poses = swayed(still, SWAY, seed=4)
    effective = n * spacing / (2 * SWAY.correlation_length)  # independent samples of such a process
    deviations = (poses.heading, poses.pitch, poses.roll, poses.position[:, 0])
    for deviation, sigma in zip(deviations, (SWAY.yaw, SWAY.pitch, SWAY.roll, SWAY.lateral), strict=True):
        assert abs(deviation.mean()) < 5 * sigma / np.sqrt(effective)
        assert deviation.std() == pytest.approx(sigma, rel=5 / np.sqrt(2 * effective))
        lag = round(SWAY.correlation_length / spacing)
        correlation = np.corrcoef(deviation[:-lag], deviation[lag:])[0, 1]
        assert abs(correlation - np.exp(-lag * spacing / SWAY.correlation_length)) < 5 / np.sqrt(effective)
    np.testing.assert_array_equal(poses.position[:, 1], still.position[:, 1])  # to the sides only


def test_sway_without_length_is_independent_and_its_four_parts_are_too():
    poses = swayed(walk(), replace(SWAY, correlation_length=0.0), seed=1)
    bound = 5 / np.sqrt(20_000)
    assert abs(np.corrcoef(poses.pitch[:-1], poses.pitch[1:])[0, 1]) < bound
    parts = np.corrcoef([poses.heading, poses.pitch, poses.roll, poses.position[:, 0]])
    assert np.abs(parts - np.eye(4)).max() < bound


def test_sway_follows_from_the_seed_and_a_longer_walk_begins_alike():
    first, again, other = (swayed(walk(n=50), SWAY, seed=seed) for seed in (3, 3, 4))
    longer = swayed(walk(n=80), SWAY, seed=3)
    np.testing.assert_array_equal(first.position, again.position)
    np.testing.assert_array_equal(first.heading, longer.heading[:50])
    assert not np.array_equal(first.heading, other.heading)


def test_camera_that_looks_aside_still_sways_across_its_way():
    poses = walk(n=100)
    aside = replace(poses, heading=np.full(100, 1.2))
    sway = swayed(aside, Jitter(lateral=1.0), seed=2, course=poses.heading)
    np.testing.assert_array_equal(sway.position[:, 1], poses.position[:, 1])
    assert np.abs(sway.position[:, 0]).max() > 0.1
    assert swayed(poses, Jitter(), seed=1) is poses


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: spaced(10.0, 1e-9), "spacing is 1e-09"),
        (lambda: spaced(2000.0, 1e-5), "number of frames is 2e+08, expected 1 to 1e+06"),
        (lambda: spaced(10.0, 1.0, 3.0, 2.0), "starts at 3 m and stops at 2 m"),
        (lambda: spaced(10.0, 1.0, 0.0, 11.0), "the way is 10 m long"),
        (lambda: along([(0, 0), (0, 0)], [0.0]), "the way has no length"),
        (lambda: along(SQUARE, [41.0]), "beyond the end of the way"),
        (lambda: Jitter(yaw=5.0), "degrees?"),
        (lambda: carried(SQUARE, [2.0, 1.0]), "distance goes back"),
        (lambda: swayed(walk(n=2), SWAY, seed=-1), "seed"),
    ],
)
def test_bad_ways_are_refused(call, words: str):
    with pytest.raises(InputError, match=words.replace("(", r"\(").replace("+", r"\+").replace("?", r"\?")):
        call()
