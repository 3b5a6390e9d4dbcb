"""Passages: speed, tilt, zig-zag, and where on the way each frame is."""

import numpy as np
import pytest

from insectnav.experiments.stone2016_places.passages import (
    PASSAGES,
    SPEED_WAVES,
    TILTS_DEG,
    ZIGZAG_LENGTH,
    ZIGZAG_YAW,
    _zigzagging,
    distances,
    drawn_as,
    ground_of,
    poses_of,
    true_references,
)
from insectnav.experiments.stone2016_places.sites import CITY, YARD
from insectnav.worlds.traverse import carried

N = 520


def test_a_passage_runs_from_start_to_end_at_a_speed_near_the_mean():
    for number in range(8):
        along = distances(CITY, number, N, seed=3)
        assert along[0] == 0.0
        assert along[-1] == pytest.approx(CITY.length)
        steps = np.diff(along) / (CITY.length / (N - 1))
        most = sum(strength for _, strength in SPEED_WAVES)
        assert np.abs(steps - 1.0).max() < 1.1 * most
        assert steps.std() > 0.03
    assert not np.allclose(distances(CITY, 0, N, seed=3), distances(CITY, 1, N, seed=3))


def test_true_references_are_where_the_reference_was_at_the_same_place():
    reference, query = distances(YARD, 0, 300, 1), distances(YARD, 1, 300, 1)
    np.testing.assert_allclose(true_references(reference, reference), np.arange(300))
    truth = true_references(reference, query)
    low = np.floor(truth).astype(int)
    high = np.minimum(low + 1, 299)
    between = reference[low] + (truth - low) * (reference[high] - reference[low])
    np.testing.assert_allclose(between, query, atol=1e-9)


def test_pitch_is_the_tilt_of_the_passage_and_its_sway():
    ground = ground_of("City", 3, 0.0)
    for number, tilt in enumerate(TILTS_DEG):
        pitch = np.rad2deg(poses_of(CITY, ground, number, N, 0).pitch)
        # A sway of 3° is forgotten over 4 m: about 65 independent values in 520 m.
        assert abs(pitch.mean() - tilt) < 4 * 3.0 / np.sqrt(65)
        assert 2.0 < pitch.std() < 4.0


def test_zigzag_heads_where_it_goes():
    along = np.linspace(0.0, 100.0, 4001)
    straight = carried([(0.0, 0.0), (0.0, 101.0)], along)
    share = np.where(along > 50.0, 1.0, 0.0)
    poses = _zigzagging(straight, share, np.asarray(straight.heading))
    np.testing.assert_array_equal(poses.position[along <= 50.0], straight.position[along <= 50.0])
    late = slice(2100, 4000)
    step = np.diff(poses.position[late], axis=0)
    goes = np.arctan2(step[:, 0], step[:, 1])
    np.testing.assert_allclose(goes, poses.heading[late][:-1], atol=0.02)
    assert np.abs(poses.heading[late]).max() == pytest.approx(ZIGZAG_YAW, rel=1e-3)
    turns = np.count_nonzero(np.diff(np.sign(poses.heading[late])))
    assert turns == pytest.approx(2 * 47.5 / ZIGZAG_LENGTH, abs=1)


def test_only_the_last_passage_of_the_yard_zigzags():
    found = [(name, k) for name, passages in PASSAGES.items() for k, one in enumerate(passages) if one.has_zigzag]
    assert found == [("Disposal Site", 1)]


def test_the_sun_of_the_city_is_that_of_an_afternoon():
    skies = [passage.sky for passage in PASSAGES["City"][:8]]
    azimuth = np.rad2deg([sky.sun_azimuth for sky in skies]) % 360.0
    assert (np.diff(azimuth) > 0).all()
    assert azimuth.min() > 180.0  # after noon
    assert azimuth.max() < 250.0


def test_variations_of_the_level_passages_differ_in_clouds_and_sway_alone():
    ground = ground_of("City", 3, 0.0)
    poses = [poses_of(CITY, ground, number, N, 0) for number in range(14)]
    for number in range(8, 14):
        like = drawn_as("City", number)
        assert like == 3 + number % 2
        np.testing.assert_array_equal(poses[number].position, poses[like].position)
        assert PASSAGES["City"][number].clock == PASSAGES["City"][like].clock
    np.testing.assert_array_equal(poses[8].pitch, poses[3].pitch)
    np.testing.assert_array_equal(poses[10].pitch, np.zeros(N))
    assert PASSAGES["City"][8].sky.clouds is None
    assert PASSAGES["City"][10].sky.clouds == PASSAGES["City"][3].sky.clouds
