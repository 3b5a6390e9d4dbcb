"""Angles at spikes, and time spent at angles, of stimuli whose course is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.angles import wrap
from insectnav.checks import InputError
from insectnav.metrics.stimulus_angles import angle_histogram, spike_angles
from spike_trains import poisson, regular

OMEGA = math.radians(60.0)  # [rad/s]
TIME = np.linspace(0.0, 30.0, 3001)
seeds = st.integers(0, 2**32 - 1)


def running_angle(time: np.ndarray, first: float = 0.0) -> np.ndarray:
    """Polariser that turns clockwise for 12 s, rests for 6 s, and turns back for 12 s: two turns either way."""
    return first + OMEGA * (np.clip(time, 0.0, 12.0) - np.clip(time - 18.0, 0.0, 12.0))


def folded(angle: np.ndarray, period: float = np.pi) -> np.ndarray:
    """Angle in [−period / 2, period / 2)."""
    return wrap(angle * (2 * np.pi / period)) / (2 * np.pi / period)


def apart(first: np.ndarray, second: np.ndarray, period: float = np.pi) -> float:
    """Largest distance between angles on a circle of that period."""
    return float(np.abs(folded(np.subtract(first, second), period)).max(initial=0.0))


# Spike angles.


@pytest.mark.parametrize("axial", [True, False])
@pytest.mark.parametrize("first", [0.0, 1.0, -3.0])
def test_spike_takes_the_angle_of_its_time_and_way(axial: bool, first: float):
    period = np.pi if axial else 2 * np.pi
    clockwise, rest, back = regular(7.0, 0.2, 11.8), regular(7.0, 12.2, 17.8), regular(9.0, 18.2, 29.8)
    found = spike_angles(np.concatenate([back, rest, clockwise]), TIME, wrap(running_angle(TIME, first)), axial=axial)
    assert (len(found.clockwise), len(found.anticlockwise)) == (len(clockwise), len(back))
    assert apart(found.clockwise, running_angle(clockwise, first), period) < 1e-9
    assert apart(found.anticlockwise, running_angle(back, first), period) < 1e-9
    for angles in found:
        assert (angles >= -period / 2).all()
        assert (angles < period / 2).all()


def test_spike_at_a_sample_belongs_to_the_way_that_begins_there():
    time, angle = np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 0.0])  # clockwise, then back
    for spike, ways in ((0.0, (1, 0)), (1.0, (0, 1)), (2.0, (0, 0))):
        found = spike_angles([spike], time, angle)
        assert (len(found.clockwise), len(found.anticlockwise)) == ways


def test_angle_may_be_recorded_over_half_a_turn_or_a_whole_one():
    spikes = np.random.default_rng(1).uniform(0.0, 30.0, 500)
    running = running_angle(TIME, 0.3)
    expected = spike_angles(spikes, TIME, wrap(running))
    for recorded in (folded(running), np.mod(running, np.pi), np.mod(running, 2 * np.pi)):
        found = spike_angles(spikes, TIME, recorded)
        assert apart(found.clockwise, expected.clockwise) < 1e-9
        assert apart(found.anticlockwise, expected.anticlockwise) < 1e-9


def test_spikes_outside_the_record_are_left_out():
    spikes = [-1.0, -0.001, 0.001, 29.999, 30.0, 31.0]
    found = spike_angles(spikes, TIME, wrap(running_angle(TIME)))
    assert [len(angles) for angles in found] == [1, 1]
    assert [len(angles) for angles in spike_angles([], TIME, wrap(running_angle(TIME)))] == [0, 0]


@pytest.mark.parametrize(("speed_deg", "n"), [(9.0, 0), (11.0, 100)])
def test_slow_drift_is_rest(speed_deg: float, n: int):
    found = spike_angles(regular(10.0, 0.0, 10.0), TIME, wrap(np.deg2rad(speed_deg) * TIME))
    assert [len(angles) for angles in found] == [n, 0]
    swift = spike_angles(regular(10.0, 0.0, 10.0), TIME, wrap(-np.deg2rad(speed_deg) * TIME), min_speed=0.01)
    assert [len(angles) for angles in swift] == [0, 100]


def test_jitter_of_the_record_does_not_turn_the_stimulus():
    jitter = np.deg2rad(0.2) * np.random.default_rng(2).uniform(-1.0, 1.0, TIME.size)  # up to 40°/s between samples
    clockwise, rest, back = regular(7.0, 0.2, 11.8), regular(7.0, 12.2, 17.8), regular(7.0, 18.2, 29.8)
    found = spike_angles(np.concatenate([clockwise, rest, back]), TIME, wrap(running_angle(TIME) + jitter))
    assert apart(found.clockwise, running_angle(clockwise)) <= np.deg2rad(0.2)
    assert apart(found.anticlockwise, running_angle(back)) <= np.deg2rad(0.2)


@given(seeds, st.floats(-3.0, 3.0))
def test_angles_turn_and_mirror_with_the_stimulus(seed: int, by: float):
    spikes = np.random.default_rng(seed).uniform(0.0, 30.0, 50)
    running = running_angle(TIME)
    found = spike_angles(spikes, TIME, wrap(running))
    turned = spike_angles(spikes, TIME, wrap(running + by))
    mirrored = spike_angles(spikes, TIME, wrap(-running))
    for way in range(2):
        assert apart(turned[way], found[way] + by) < 1e-9
        assert apart(mirrored[way], -found[1 - way]) < 1e-9


# Histogram.


@pytest.mark.parametrize(("axial", "width_deg"), [(True, 10.0), (False, 10.0), (True, 7.5), (True, 60.0)])
def test_whole_turns_spend_equal_time_in_all_bins(axial: bool, width_deg: float):
    n_bins = round((180 if axial else 360) / width_deg)
    spikes = np.concatenate([regular(120.0, 0.0, 12.0), regular(60.0, 18.0, 30.0)])
    histograms = angle_histogram(spikes, TIME, wrap(running_angle(TIME)), axial=axial, bin_width_deg=width_deg)
    centres = np.deg2rad(width_deg) * (np.arange(n_bins) + 0.5 - n_bins / 2)
    for histogram, rate in zip(histograms, (120.0, 60.0), strict=True):
        np.testing.assert_allclose(histogram.angle, centres, atol=1e-12)
        # At either end of the rest some 0.1 s · (1/2 − 10/60) of it passes for a turn, in one bin.
        assert np.sort(np.abs(histogram.time_spent - 12.0 / n_bins))[-2] < 1e-9
        assert abs(histogram.time_spent.sum() - 12.0) < 0.05
        assert np.abs(histogram.n_spikes - rate * 12.0 / n_bins).max() <= 2
        np.testing.assert_array_equal(histogram.rate, histogram.n_spikes / histogram.time_spent)


def test_time_spent_agrees_with_counting_fine_steps():
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.01, 0.2, 400))
    angle = np.cumsum(rng.uniform(0.02, 0.3, 400))  # clockwise all the time, at uneven speed
    histogram = angle_histogram([], time, wrap(angle), min_speed=0.0).clockwise
    fine = np.linspace(time[0], time[-1], 400_001)[:-1]
    bins = np.floor((folded(np.interp(fine, time, angle)) + np.pi / 2) / (np.pi / 18)).astype(int)
    counted = np.bincount(bins, minlength=18) * (time[-1] - time[0]) / fine.size
    # Each of some 20 rounds cuts off a part of a fine step at either end of a bin.
    np.testing.assert_allclose(histogram.time_spent, counted, atol=2 * 30 * (fine[1] - fine[0]))
    assert histogram.time_spent.sum() == pytest.approx(time[-1] - time[0])


def test_coarsely_digitised_angle_spends_its_time_on_the_digits():
    digits = np.deg2rad(np.floor(np.rad2deg(OMEGA * TIME) / 5.0) * 5.0 + 2.5)  # holds still, then jumps by 5°
    histogram = angle_histogram(regular(100.0, 0.0, 30.0), TIME, wrap(digits)).clockwise
    # Ten half turns, 10°/(60°/s) in each bin; each step between digits takes a sample of 0.01 s.
    np.testing.assert_allclose(histogram.time_spent, 30.0 / 18, atol=10 * 0.01)
    np.testing.assert_allclose(histogram.rate, 100.0, rtol=0.08)


@given(seeds)
def test_every_spike_of_a_turn_is_in_one_bin(seed: int):
    spikes = np.random.default_rng(seed).uniform(0.0, 30.0, 200)
    angle = wrap(running_angle(TIME))
    angles = spike_angles(spikes, TIME, angle)
    for histogram, found in zip(angle_histogram(spikes, TIME, angle), angles, strict=True):
        expected, _ = np.histogram(found, bins=18, range=(-np.pi / 2, np.pi / 2))
        assert histogram.n_spikes.sum() == len(found)
        np.testing.assert_array_equal(histogram.n_spikes, expected)


def test_angles_that_the_stimulus_missed_have_no_rate():
    histogram = angle_histogram(regular(50.0, 0.0, 1.0), TIME[:101], wrap(OMEGA * TIME[:101])).clockwise
    np.testing.assert_allclose(histogram.time_spent[9:15], 1 / 6)  # 0° to 60° in one second
    np.testing.assert_allclose(histogram.time_spent[15:], 0.0, atol=1e-12)
    assert np.isnan(histogram.rate[:9]).all()


def test_poisson_tuning_is_recovered():
    time = np.linspace(0.0, 600.0, 60_001)
    spikes = poisson(lambda t: 40.0 + 30.0 * np.cos(2 * (OMEGA * t - 0.7)), 70.0, 600.0, seed=4)
    histogram = angle_histogram(spikes, time, wrap(OMEGA * time)).clockwise
    # Mean of the cosine over a bin of 10° is its value at the centre, times sin(10°) / 10°.
    shrink = math.sin(np.pi / 18) / (np.pi / 18)
    expected = 40.0 + 30.0 * shrink * np.cos(2 * (histogram.angle - 0.7))
    z = (histogram.rate - expected) / np.sqrt(expected / (600.0 / 18))
    assert np.abs(z).max() < 4.5


# Bad input.


@pytest.mark.parametrize(
    ("time", "angle", "options", "message"),
    [
        (TIME, np.rad2deg(wrap(running_angle(TIME))), {}, "angle reaches.*degrees"),
        (TIME, running_angle(TIME), {}, "angle reaches.*radians within"),
        (TIME[::-1], wrap(running_angle(TIME)), {}, "time does not ascend"),
        (TIME[:-1], wrap(running_angle(TIME)), {}, "angle has shape"),
        (TIME[:1], [0.0], {}, "time holds 1 samples, expected at least 2"),
        (TIME, np.where(TIME == 3.0, np.nan, 0.0), {}, "angle is nan"),
        ([0.0, np.inf], [0.0, 1.0], {}, "time is inf"),
        ([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], {}, "angle jumps by 57.3° between two samples, expected at most 45°"),
        (TIME, wrap(running_angle(TIME)), {"min_speed": -1.0}, "min_speed is -1"),
        (TIME, wrap(running_angle(TIME)), {"bin_width_deg": 7.0}, "bin_width_deg is 7, expected a whole part of 180"),
        (TIME, wrap(running_angle(TIME)), {"bin_width_deg": 0.0}, "bin_width_deg is 0.*radians"),
        (TIME, wrap(running_angle(TIME)), {"bin_width_deg": 90.0}, "bin_width_deg is 90"),
    ],
)
def test_bad_record_is_refused_in_one_sentence(time, angle, options: dict, message: str):
    with pytest.raises(InputError, match=message) as caught:
        angle_histogram([1.0], time, angle, **options)
    assert "\n" not in str(caught.value)
