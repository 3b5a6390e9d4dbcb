import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.angles import wrap
from insectnav.checks import InputError
from insectnav.homing import (
    COMPARISONS,
    difference_by_turn,
    difference_surface,
    feature_distance,
    random_headings,
    rms_difference,
    turn_views,
    visual_compass,
)
from insectnav.vision.descriptors import retinotopic, zernike_amplitudes, zernike_coefficients, zernike_pairs

RNG = np.random.default_rng(0)
COLUMN = 2 * np.pi / 72
VIEWS = RNG.random((2, 3, 9, 72))
REMEMBERED = RNG.random((9, 72))
AZIMUTH = (np.arange(72) + 0.5) * COLUMN - np.pi


def wave(cycles, phase=0.0):
    """A view of one row whose brightness is a cosine of the azimuth."""
    return 0.5 + 0.5 * np.cos(cycles * (AZIMUTH - phase))[None]


# Turning.


def test_after_a_turn_to_the_right_what_was_there_is_ahead():
    view = np.zeros((3, 72))
    view[:, 36 + 18] = 1.0  # 90° to the right
    assert_array_equal(np.flatnonzero(turn_views(view, np.pi / 2)[0]), [36])
    assert_array_equal(np.flatnonzero(turn_views(view, -np.pi / 2)[0]), [0])  # behind


@settings(max_examples=40, deadline=None)
@given(columns=st.integers(-72, 72))
def test_turns_by_whole_columns_are_exact(columns):
    assert_array_equal(turn_views(VIEWS, columns * COLUMN), np.roll(VIEWS, -columns, axis=-1))


@settings(max_examples=40, deadline=None)
@given(first=st.floats(-3, 3), columns=st.integers(-30, 30))
def test_turns_add_up(first, columns):
    once = turn_views(VIEWS[0], first + columns * COLUMN)
    assert_allclose(turn_views(turn_views(VIEWS[0], first), columns * COLUMN), once, rtol=0, atol=1e-9)


def test_between_columns_amplitudes_fall_by_the_cosine_of_half_a_column():
    # The mean of neighbours multiplies the m-th harmonic by (1 + e^(im Δ)) / 2.
    half = turn_views(VIEWS, COLUMN / 2)
    m = zernike_pairs(16)[1]
    expected = zernike_coefficients(VIEWS) * (1 + np.exp(1j * m * COLUMN)) / 2
    assert_allclose(zernike_coefficients(half), expected, rtol=0, atol=1e-13)


def test_a_turn_for_each_view():
    turns = RNG.uniform(-np.pi, np.pi, (2, 3))
    together = turn_views(VIEWS, turns)
    for index in np.ndindex(2, 3):
        assert_array_equal(together[index], turn_views(VIEWS[index], turns[index]))


# Differences.


def test_rms_difference_of_waves():
    # cos − cos shifted by α is a wave of amplitude 2 sin(k α / 2); half of it, as brightness runs from 0 to 1.
    views = np.stack([wave(3, phase) for phase in (0.0, 0.2, 0.9)])
    expected = np.abs(np.sin(3 * np.array([0.0, 0.2, 0.9]) / 2)) / np.sqrt(2)
    assert_allclose(rms_difference(views, wave(3)), expected, rtol=0, atol=1e-15)
    assert rms_difference(wave(3), wave(3)) == 0.0
    assert rms_difference(np.ones((2, 5)), np.zeros((2, 5))) == 1.0


def test_rms_difference_is_the_distance_of_retinotopic_vectors():
    expected = feature_distance(retinotopic(VIEWS), retinotopic(REMEMBERED))
    assert_allclose(rms_difference(VIEWS, REMEMBERED), expected, rtol=1e-13)


def test_bytes_and_their_brightness_give_the_same():
    grey = RNG.integers(0, 256, (3, 9, 72), np.uint8)
    assert_allclose(rms_difference(grey, grey[0]), rms_difference(grey / 255, grey[0] / 255), rtol=1e-13)


def test_difference_after_each_turn_is_that_by_brute_force():
    brute = np.stack([rms_difference(np.roll(VIEWS, -k, axis=-1), REMEMBERED) for k in range(72)], axis=-1)
    assert_allclose(difference_by_turn(VIEWS, REMEMBERED), brute, rtol=0, atol=1e-14)


def test_odd_numbers_of_columns_work_too():
    views, remembered = RNG.random((4, 5, 33)), RNG.random((5, 33))
    brute = np.stack([rms_difference(np.roll(views, -k, axis=-1), remembered) for k in range(33)], axis=-1)
    assert_allclose(difference_by_turn(views, remembered), brute, rtol=0, atol=1e-14)


def test_rotational_function_of_a_wave():
    turn = np.arange(72) * COLUMN
    expected = np.abs(np.sin(2 * turn / 2)) / np.sqrt(2)
    assert_allclose(difference_by_turn(wave(2), wave(2)), expected, rtol=0, atol=2e-8)


# The visual compass.


@settings(max_examples=40, deadline=None)
@given(columns=st.integers(-36, 35))
def test_compass_turns_back(columns):
    turned = turn_views(REMEMBERED, columns * COLUMN)
    found = visual_compass(turned, REMEMBERED)
    assert found.difference == 0.0
    assert_allclose(wrap(found.turn + columns * COLUMN), 0.0, rtol=0, atol=1e-12)
    assert_array_equal(turn_views(turned, found.turn), REMEMBERED)


def test_compass_is_the_best_by_brute_force():
    brute = difference_by_turn(VIEWS, REMEMBERED)
    found = visual_compass(VIEWS, REMEMBERED)
    assert_allclose(found.difference, brute.min(axis=-1), rtol=0, atol=1e-14)
    assert_allclose(found.turn, wrap(brute.argmin(axis=-1) * COLUMN), rtol=0, atol=1e-14)
    assert np.all(found.difference <= rms_difference(VIEWS, REMEMBERED))


def test_compass_does_not_mind_how_the_views_are_turned():
    turned = turn_views(VIEWS, RNG.integers(-36, 36, (2, 3)) * COLUMN)
    still = visual_compass(VIEWS, REMEMBERED).difference
    assert_allclose(visual_compass(turned, REMEMBERED).difference, still, rtol=1e-13)


# Surfaces.


def test_surfaces_are_what_their_names_say():
    aligned, compass = (difference_surface(VIEWS, REMEMBERED, name) for name in ("aligned", "compass"))
    assert_array_equal(aligned, rms_difference(VIEWS, REMEMBERED))
    assert_array_equal(compass, visual_compass(VIEWS, REMEMBERED).difference)
    turned = turn_views(VIEWS, random_headings(6, 5).reshape(2, 3))
    assert_allclose(difference_surface(VIEWS, REMEMBERED, "random", seed=5), rms_difference(turned, REMEMBERED))
    assert COMPARISONS == ("aligned", "random", "compass")


@pytest.mark.parametrize("comparison", COMPARISONS)
def test_batch_is_loop(comparison):
    many = RNG.random((150, 105, 360)).astype(np.float32)  # more than are worked on at once
    together = difference_surface(many, many[7], comparison, seed=1)
    if comparison == "random":
        alone = [rms_difference(turn_views(many[k], random_headings(150, 1)[k]), many[7]) for k in (0, 66, 149)]
    else:
        alone = [difference_surface(many[k], many[7], comparison) for k in (0, 66, 149)]
    assert_allclose(together[[0, 66, 149]], alone, rtol=1e-6)
    assert comparison == "random" or together[7] == 0.0


def test_headings_are_uniform_and_fixed_by_the_seed():
    n = 20_000
    headings = random_headings(n, 3)
    assert_array_equal(headings, random_headings(n, 3))
    assert not np.array_equal(headings, random_headings(n, 4))
    assert headings.min() >= -np.pi
    assert headings.max() < np.pi
    for k in (1, 2, 5):  # each part of a mean unit vector has the standard deviation 1 / sqrt(2 n)
        assert np.abs(np.mean(np.exp(1j * k * headings))) < 4.5 / np.sqrt(n)
    assert random_headings((2, 5), 0).shape == (2, 5)


def test_random_headings_leave_zernike_distances():
    turned = turn_views(VIEWS, RNG.integers(-36, 36, (2, 3)) * COLUMN)
    distances = [feature_distance(zernike_amplitudes(v), zernike_amplitudes(REMEMBERED)) for v in (VIEWS, turned)]
    assert_allclose(distances[1], distances[0], rtol=1e-12)
    assert not np.allclose(rms_difference(turned, REMEMBERED), rms_difference(VIEWS, REMEMBERED), rtol=1e-3)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: rms_difference(VIEWS, REMEMBERED[:5]),
            r"views have shape \(2, 3, 9, 72\) and the remembered one \(5, 7",
        ),
        (lambda: rms_difference(VIEWS, VIEWS), "views have shape"),
        (lambda: turn_views(VIEWS, 90), "turn is 90, expected radians within ±2π: degrees"),
        (lambda: turn_views(VIEWS, np.nan), "turn is nan, expected finite"),
        (lambda: random_headings(5, -1), "seed is -1, expected a whole number of at least 0"),
        (
            lambda: difference_surface(VIEWS, REMEMBERED, "allined"),
            "comparison 'allined' is unknown.*did you mean align",
        ),
        (lambda: difference_surface(VIEWS, REMEMBERED, "random"), "comparison is 'random' without a seed"),
        (
            lambda: feature_distance(np.zeros((3, 4)), np.zeros(5)),
            r"features have shape \(3, 4\) and the remembered ones",
        ),
        (lambda: feature_distance(np.full((3, 4), np.inf), np.zeros(4)), "features is inf"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
