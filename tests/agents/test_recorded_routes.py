"""Tracks as routes: scale, time step and heading against closed forms; units, turns and bad input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.agents.recorded_routes import route_from_track
from insectnav.checks import InputError
from insectnav.records import Track

seeds = st.integers(0, 2**32 - 1)
COURSE = np.deg2rad(30.0)
LENGTHS = {"m": 1.0, "cm": 100.0, "mm": 1000.0}


def made(time: object, position: object, heading: object = None, **options) -> Track:
    return Track(
        **{"time": time, "position": position, "heading": heading, "length_unit": "m", "time_unit": "s", "name": "walk"}
        | options
    )


def unit(heading: object) -> np.ndarray:
    """Vectors (sin θ, cos θ)."""
    return np.stack([np.sin(heading), np.cos(heading)], axis=-1)


def straight(
    n_intervals: int, speed: float = 0.3, interval: float = 0.1, start: tuple = (0.0, 0.0), **options
) -> Track:
    """Constant speed along 30°."""
    time = np.arange(n_intervals + 1) * interval
    return made(time, np.array(start) + speed * time[:, None] * unit(COURSE), **options)


def circle(n_turns: float, n_per_turn: int = 100, radius: float = 2.0) -> Track:
    """Clockwise round the centre, at heading 0 first: the heading at sample k is 2π k / n_per_turn."""
    k = np.arange(round(n_turns * n_per_turn) + 1)
    angle = 2.0 * np.pi * k / n_per_turn
    return made(0.04 * k, radius * np.stack([-np.cos(angle), np.sin(angle)], axis=-1))


def wandering(seed: int, n_samples: int = 150, **options) -> Track:
    """A smooth track of varying speed that drifts away from the nest; no two samples alike."""
    rng = np.random.default_rng(seed)
    heading = np.cumsum(rng.normal(0.0, 0.15, n_samples)) + rng.uniform(-np.pi, np.pi)
    moves = rng.uniform(0.2, 1.0, n_samples)[:, None] * unit(heading)
    return made(np.arange(n_samples) * 0.5, np.cumsum(moves, axis=0) + rng.normal(0.0, 50.0, 2), **options)


def turned(vectors: np.ndarray, by: float) -> np.ndarray:
    """Vectors (..., 2) turned clockwise, as headings grow."""
    return vectors @ np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])


def angle_between(a: object, b: object) -> np.ndarray:
    """Angle from b to a in (−π, π]."""
    return np.angle(np.exp(1j * (np.asarray(a) - np.asarray(b))))


# A straight track at constant speed: all in closed form.


def test_straight_track_in_closed_form():
    route = route_from_track(straight(100, start=(5.0, -7.0)))
    assert route.n_steps == 101
    assert route.time_per_step == pytest.approx(0.1)
    assert route.steps_per_unit == pytest.approx(0.85 / (0.3 * 0.1))
    assert_array_equal(route.nest, [5.0, -7.0])
    assert_array_equal(route.velocity[0], [0.0, 0.0])
    assert_allclose(route.velocity[1:], np.tile(0.85 * unit(COURSE), (100, 1)), atol=1e-9)
    assert_allclose(route.heading, np.full(101, COURSE), atol=1e-9)
    assert route.heading_source == "direction of motion"
    assert len(route.notes) == 1
    assert "no heading column" in route.notes[0]
    assert "2 steps" in route.notes[0]


def test_track_that_leads_too_far_is_scaled_to_300_steps():
    # Each sample would be 0.85 steps: 1000 of them lead 850 steps away, and a time step has to be 850 / 300 as long.
    route = route_from_track(straight(1000))
    assert route.n_steps == round(1000 * 300 / 850) + 1
    assert np.linalg.norm(route.velocity.sum(axis=0)) == pytest.approx(300.0, rel=2e-3)
    assert route.time_per_step == pytest.approx(0.1 * 850 / 300, rel=2e-3)
    assert any(note.startswith("a time step is 2.83 samples long") for note in route.notes)


def test_farthest_point_counts_even_where_the_track_comes_back():
    out = straight(1000).position
    track = made(np.arange(2001) * 0.1, np.concatenate([out, out[-2::-1]]))
    position = np.cumsum(route_from_track(track).velocity, axis=0)
    assert np.linalg.norm(position, axis=1).max() == pytest.approx(300.0, rel=5e-3)
    assert np.linalg.norm(position[-1]) < 1e-9


def test_long_track_becomes_5000_time_steps():
    # A step is the chord of four hundredths of a turn.
    route = route_from_track(circle(200.0))
    assert route.n_steps == 5001
    assert route.time_per_step == pytest.approx(0.16)
    assert route.steps_per_unit == pytest.approx(0.85 / (2.0 * 2.0 * np.sin(4.0 * np.pi / 100.0)))
    assert_allclose(np.linalg.norm(route.velocity[1:], axis=1), 0.85, rtol=1e-9)
    assert any(note.startswith("a time step is 4 samples long") for note in route.notes)


@pytest.mark.parametrize("factor", [0.5, 2.0, 3.0])
def test_steps_per_unit_changes_the_time_step_and_keeps_the_speed(factor: float):
    asked = factor * 0.85 / (0.3 * 0.1)
    route = route_from_track(straight(120), steps_per_unit=asked)
    assert route.steps_per_unit == asked
    assert route.n_steps == round(120 * factor) + 1
    assert route.time_per_step == pytest.approx(0.1 / factor)
    assert_allclose(np.linalg.norm(route.velocity[1:], axis=1), 0.85, rtol=1e-9)
    assert np.linalg.norm(route.velocity.sum(axis=0)) == pytest.approx(0.3 * 12.0 * asked)


def test_steps_per_unit_may_lead_beyond_300_steps():
    route = route_from_track(straight(1000), steps_per_unit=0.85 / (0.3 * 0.1))
    assert np.linalg.norm(route.velocity.sum(axis=0)) == pytest.approx(850.0)


def test_steps_that_are_too_fast_are_said_to_be():
    # Ten samples are asked to become 1.4 steps, which rounds to a single one of 1.4 × 0.85 in 10 samples.
    route = route_from_track(straight(10), steps_per_unit=0.14 * 0.85 / (0.3 * 0.1))
    assert_allclose(np.linalg.norm(route.velocity, axis=1), [0.0, 1.4 * 0.85], rtol=1e-9)
    assert any(note.startswith("50 % of the steps are faster than the speed cells can signal") for note in route.notes)


# Any track.


@given(seeds)
def test_95th_percentile_of_speed_is_085(seed: int):
    route = route_from_track(wandering(seed))
    speed = np.linalg.norm(route.velocity[1:], axis=1)
    assert np.percentile(speed, 95.0) == pytest.approx(0.85)
    assert speed.max() < 1.1
    assert not any("faster" in note for note in route.notes)


@given(seeds)
def test_velocities_lead_back_along_the_track(seed: int):
    track = wandering(seed)
    route = route_from_track(track)
    assert route.n_steps == track.n_samples
    position = np.cumsum(route.velocity, axis=0) / route.steps_per_unit + route.nest
    assert_allclose(position, track.position, atol=1e-9)


def test_velocities_of_a_resampled_track_lead_along_it():
    track = circle(5.3)
    route = route_from_track(track, steps_per_unit=1.7)
    assert route.n_steps != track.n_samples
    position = np.cumsum(route.velocity, axis=0) / route.steps_per_unit + route.nest
    assert_array_equal(position[0], track.position[0])
    assert_allclose(position[-1], track.position[-1], atol=1e-9)
    # On chords of a circle of radius 2: no nearer to the centre than their middles.
    distance = np.linalg.norm(position, axis=1)
    assert distance.min() > 2.0 * np.cos(np.pi / 100.0) - 1e-9
    assert distance.max() < 2.0 + 1e-9


def test_irregular_samples_become_even_steps():
    rng = np.random.default_rng(2)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 2.0, 200))])
    track = made(time, 0.3 * time[:, None] * unit(COURSE))
    route = route_from_track(track)
    assert route.n_steps == round(time[-1] / np.median(np.diff(time))) + 1
    assert route.time_per_step == pytest.approx(time[-1] / (route.n_steps - 1))
    assert_allclose(route.velocity[1:], np.tile(0.85 * unit(COURSE), (route.n_steps - 1, 1)), atol=1e-9)


@pytest.mark.parametrize("asked", [None, 2.0])
@pytest.mark.parametrize("length_unit", ["cm", "mm"])
def test_unit_of_length_changes_the_scale_alone(length_unit: str, asked: float | None):
    per_metre, metres = LENGTHS[length_unit], wandering(3)
    other = made(metres.time, metres.position * per_metre, length_unit=length_unit)
    one = route_from_track(metres, steps_per_unit=asked)
    two = route_from_track(other, steps_per_unit=None if asked is None else asked / per_metre)
    assert one.n_steps == two.n_steps
    assert two.steps_per_unit == pytest.approx(one.steps_per_unit / per_metre)
    assert_allclose(two.velocity, one.velocity, atol=1e-9)
    assert_allclose(two.heading, one.heading, atol=1e-9)
    assert_allclose(two.nest, one.nest * per_metre)
    assert two.notes == one.notes


def test_unit_and_origin_of_time_change_the_time_step_alone():
    seconds = wandering(5)
    frames = made(1000.0 + seconds.time * 50.0, seconds.position, time_unit="frame")
    one, two = route_from_track(seconds), route_from_track(frames)
    assert two.time_per_step == pytest.approx(50.0 * one.time_per_step)
    assert_allclose(two.velocity, one.velocity, atol=1e-9)
    assert two.steps_per_unit == pytest.approx(one.steps_per_unit)


@settings(max_examples=50)
@given(seeds, st.floats(-10.0, 10.0), st.sampled_from([0.0, 2.0]))
def test_turned_track_turns_headings_and_velocities(seed: int, by: float, smoothing: float):
    track = wandering(seed)
    one = route_from_track(track, heading_smoothing=smoothing)
    two = route_from_track(made(track.time, turned(track.position, by)), heading_smoothing=smoothing)
    assert two.steps_per_unit == pytest.approx(one.steps_per_unit)
    assert_allclose(two.velocity, turned(one.velocity, by), atol=1e-9)
    assert np.abs(angle_between(two.heading, one.heading + by)).max() < 1e-6


def test_track_is_left_as_it_is_and_the_route_is_repeatable():
    track = wandering(7)
    before = track.position.copy()
    one, two = route_from_track(track), route_from_track(track)
    assert_array_equal(track.position, before)
    assert_array_equal(one.velocity, two.velocity)
    assert_array_equal(one.heading, two.heading)


# Headings.


def test_heading_on_a_circle_lags_by_half_a_step():
    # A velocity is the chord to this sample from the one before: its direction is the tangent half a sample ago.
    route = route_from_track(circle(3.0))
    tangent = 2.0 * np.pi * np.arange(route.n_steps) / 100.0
    lag = angle_between(tangent, route.heading)
    assert_allclose(lag[10:-10], np.pi / 100.0, atol=1e-9)  # a symmetric average adds nothing to it
    assert np.abs(lag).max() < np.deg2rad(8.0)  # nor much at the ends, where half of it is missing


def test_heading_without_smoothing_is_that_of_each_step():
    track = wandering(11)
    route = route_from_track(track, heading_smoothing=0.0)
    moves = np.diff(track.position, axis=0)
    assert_allclose(angle_between(route.heading[1:], np.arctan2(moves[:, 0], moves[:, 1])), 0.0, atol=1e-9)
    assert route.heading[0] == route.heading[1]  # nothing moved yet


def test_smoothing_removes_jitter():
    rng = np.random.default_rng(1)
    y = np.arange(200.0)
    track = made(y, np.stack([rng.normal(0.0, 0.5, 200), y], axis=-1))
    spread = [np.std(route_from_track(track, heading_smoothing=s).heading) for s in (0.0, 1.0, 2.0, 5.0)]
    assert spread == sorted(spread, reverse=True)
    assert spread[2] < 0.2 * spread[0]


def test_standing_animal_keeps_its_heading():
    x = np.concatenate([np.arange(41.0), np.full(40, 40.0), np.full(40, 40.0)])
    y = np.concatenate([np.zeros(41), np.zeros(40), np.arange(1.0, 41.0)])
    route = route_from_track(made(np.arange(121.0), np.stack([x, y], axis=-1)))
    assert_allclose(route.velocity[45:78], 0.0, atol=1e-9)
    assert_allclose(np.rad2deg(route.heading[:70]), 90.0, atol=1e-6)  # east, and on while it stands
    assert_allclose(np.rad2deg(route.heading[92:]), 0.0, atol=1e-6)  # then north
    assert (np.diff(route.heading) <= 1e-9).all()


def test_animal_that_stands_at_first_looks_where_it_will_go():
    x = np.concatenate([np.zeros(40), -np.arange(60.0)])
    route = route_from_track(made(np.arange(100.0), np.stack([x, np.zeros(100)], axis=-1)))
    assert_allclose(np.rad2deg(route.heading), -90.0, atol=1e-6)


def test_recorded_heading_is_taken_as_it_is():
    track = wandering(2)
    heading = np.linspace(-3.0, 3.0, track.n_samples)
    route = route_from_track(made(track.time, track.position, heading))
    assert_allclose(route.heading, heading, atol=1e-9)
    assert route.heading_source == "recorded"
    assert route.notes == ()


def test_recorded_heading_is_interpolated_the_short_way_round():
    n = 60
    heading = np.deg2rad(np.where(np.arange(n + 1) % 2, -170.0, 170.0))
    track = straight(n, heading=heading)
    route = route_from_track(track, steps_per_unit=2.0 * 0.85 / (0.3 * 0.1))  # twice as many steps
    assert route.n_steps == 2 * n + 1
    assert_allclose(angle_between(route.heading[::2], heading), 0.0, atol=1e-9)
    assert_allclose(angle_between(route.heading[1::2], np.pi), 0.0, atol=1e-9)  # 180°, not 0°
    assert (route.heading >= -np.pi).all()
    assert (route.heading < np.pi).all()


# Bad input.


def rests(n_moving: int) -> Track:
    """Of 200 samples, so many moves, then nothing."""
    return made(np.arange(201.0), np.stack([np.minimum(np.arange(201.0), n_moving), np.zeros(201)], axis=-1))


def test_animal_that_stands_nearly_always_is_refused():
    with pytest.raises(InputError, match=r"^track 'walk' stands still in more than 95 % of its samples"):
        route_from_track(rests(5))


def test_animal_that_stands_for_most_of_the_time_is_not():
    route = route_from_track(rests(20))
    assert_allclose(np.linalg.norm(route.velocity[1:21], axis=1), 0.85, rtol=1e-9)
    assert_allclose(route.velocity[21:], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("steps_per_unit", "words"),
    [
        (0.0, "is 0, expected 1e-12 to 1e"),
        (-3.0, "is -3, expected"),
        (np.nan, "is nan, expected"),
        (np.inf, "is inf, expected"),
        (1e7, "would become more than 1000000 steps, expected fewer: lower"),
        (1e12, "would become more than 1000000 steps, expected fewer: lower"),
        (1e-3, "would become a single step, expected more: raise"),
    ],
)
def test_scale_that_cannot_be_is_refused(steps_per_unit: float, words: str):
    with pytest.raises(InputError) as caught:
        route_from_track(straight(100), steps_per_unit=steps_per_unit)
    assert words in str(caught.value)
    assert "steps" in str(caught.value)


@pytest.mark.parametrize("n_samples", [1, 2])
def test_track_of_next_to_no_samples_is_a_step_or_refused(n_samples: int):
    track = made(np.arange(n_samples), np.arange(2 * n_samples).reshape(-1, 2))
    if n_samples == 2:
        assert route_from_track(track).n_steps == 2
    else:
        with pytest.raises(InputError, match="track 'walk'"):
            route_from_track(track)


@pytest.mark.parametrize("smoothing", [-1.0, np.nan, np.inf])
def test_smoothing_that_cannot_be_is_refused(smoothing: float):
    with pytest.raises(InputError, match=r"^heading_smoothing is "):
        route_from_track(straight(100), heading_smoothing=smoothing)


def test_sudden_jump_is_not_blamed_on_an_option_that_was_not_given():
    # Trembles by a micrometre, but for one leap of a metre: there is no scale for both.
    position = np.random.default_rng(0).normal(0.0, 1e-6, (100, 2))
    position[50:] += 1.0
    try:
        route = route_from_track(made(np.arange(100.0), position))
    except InputError as error:
        assert "--steps-per-unit" not in str(error)
    else:
        assert any("faster" in note for note in route.notes)
