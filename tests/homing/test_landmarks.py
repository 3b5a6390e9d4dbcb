import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from insectnav.angles import bearing, unit_vector, wrap
from insectnav.checks import InputError
from insectnav.homing import average_landmark_vector, landmark_home_vector, turn_views

N_COLUMNS = 3600
COLUMN = 2 * np.pi / N_COLUMNS


def ring(landmarks, place, heading=0.0):
    """Which columns point landmarks (n, 2) are seen in from a place."""
    mask = np.zeros((1, N_COLUMNS), bool)
    azimuth = wrap(bearing(np.asarray(landmarks, float) - place) - heading)
    mask[0, ((azimuth + np.pi) / COLUMN).astype(int) % N_COLUMNS] = True
    return mask


def test_one_landmark_is_its_direction():
    for azimuth in (-3.0, -0.5, 0.0, 1.2):
        found = average_landmark_vector(ring([5 * unit_vector(azimuth)], [0, 0]))
        assert_allclose(found, unit_vector(azimuth), rtol=0, atol=COLUMN)


def test_landmarks_all_round_cancel_and_none_is_nothing():
    assert_allclose(average_landmark_vector(np.ones((3, 36), bool)), 0.0, atol=1e-15)
    assert np.isnan(average_landmark_vector(np.zeros((3, 36), bool))).all()


def test_an_arc_has_the_vector_of_an_arc():
    # Mean of unit vectors over ±w about ahead: sin w / w.
    mask = np.zeros((1, N_COLUMNS), bool)
    mask[0, N_COLUMNS // 2 - 400 : N_COLUMNS // 2 + 400] = True
    width = 400 * COLUMN
    assert_allclose(average_landmark_vector(mask), [0.0, np.sin(width) / width], rtol=0, atol=COLUMN**2)


def test_every_pixel_counts_the_same():
    mask = np.zeros((3, 4), bool)  # columns at −135°, −45°, 45°, 135°
    mask[:, 1] = True
    mask[0, 2] = True
    expected = (3 * unit_vector(-np.pi / 4) + unit_vector(np.pi / 4)) / 4
    assert_allclose(average_landmark_vector(mask), expected, rtol=1e-14)


def test_heading_brings_it_into_the_frame_of_the_world():
    rng = np.random.default_rng(0)
    view = rng.random((5, 72)) < 0.2
    turns = np.arange(-30, 40, 7) * 2 * np.pi / 72
    turned = np.stack([turn_views(view, turn) > 0.5 for turn in turns])
    expected = np.broadcast_to(average_landmark_vector(view), (len(turns), 2))
    assert_allclose(average_landmark_vector(turned, turns), expected, rtol=0, atol=1e-14)


def test_batch_is_loop():
    rng = np.random.default_rng(0)
    masks, headings = rng.random((2, 3, 4, 20)) < 0.5, rng.uniform(-3, 3, (2, 3))
    together = average_landmark_vector(masks, headings)
    for index in np.ndindex(2, 3):
        assert_allclose(together[index], average_landmark_vector(masks[index], headings[index]), rtol=1e-14)
    assert average_landmark_vector(masks).shape == (2, 3, 2)


def test_between_two_landmarks_on_a_line_it_points_home():
    landmarks = [[0, 10], [10, 0], [-10, 0]]
    home = average_landmark_vector(ring(landmarks, [0, 0]))
    for place in ([0, 3], [2, 0], [-1, -1]):
        way = landmark_home_vector(average_landmark_vector(ring(landmarks, place)), home)
        assert np.abs(wrap(bearing(way) - bearing(-np.array(place)))) < np.pi / 4


coordinate = st.floats(-20, 20)


@settings(max_examples=100, deadline=None)
@given(
    landmarks=st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6),
    place=st.tuples(coordinate, coordinate),
)
def test_it_never_points_away_from_home(landmarks, place):
    # The mean distance to points is convex, and a landmark vector is minus its slope: (−slope here + slope at home) ·
    # (home − here) ≥ 0. Every landmark may be half a column off, at both ends; those that share a column are one.
    place = np.array(place)
    masks = [ring(landmarks, here) for here in (place, np.zeros(2))]
    if any(mask.sum() < len(landmarks) for mask in masks) or not place.any():
        return
    here, home = (average_landmark_vector(mask) for mask in masks)
    assert landmark_home_vector(here, home) @ -place >= -COLUMN * np.linalg.norm(place) - 1e-12


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: average_landmark_vector(np.ones((3, 8))),
            "landmarks hold float64 values, expected a mask of true and",
        ),
        (
            lambda: average_landmark_vector(np.ones(8, bool)),
            r"landmarks has shape \(8,\), expected \(\.\.\., rows, colu",
        ),
        (lambda: average_landmark_vector(np.ones((3, 8), bool), 90), "heading is 90, expected radians"),
        (lambda: average_landmark_vector(np.ones((3, 8), bool), np.inf), "heading is inf"),
        (
            lambda: average_landmark_vector(np.ones((2, 3, 8), bool), [0.0] * 3),
            r"heading has shape \(3,\), expected \(2,\)",
        ),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
