"""Stimuli that turn and flow as said, and spikes at the rates they are made from."""

import numpy as np
import pytest
from scipy.stats import kstest

from insectnav.angles import wrap
from insectnav.experiments.stone2017_path_integration.virtual_recordings import (
    flow_protocol,
    poisson_spikes,
    sensed_heading,
    spike_generator,
    turning_stimulus,
)


@pytest.mark.parametrize("step_ms", [10.0, 100.0])
@pytest.mark.parametrize("speed_deg", [30.0, 60.0])
def test_stimulus_turns_at_its_speed_both_ways(speed_deg: float, step_ms: float):
    stimulus = turning_stimulus(speed_deg, 2, step_ms)
    assert stimulus.time[-1] == pytest.approx(2 * 2 * 360.0 / speed_deg)
    running = np.degrees(np.unwrap(stimulus.angle))
    assert running.max() == pytest.approx(720.0)
    assert running[-1] == pytest.approx(0.0, abs=1e-9)
    half = len(stimulus.time) // 2
    np.testing.assert_allclose(np.diff(running) / np.diff(stimulus.time), np.repeat([speed_deg, -speed_deg], half))
    middle = (np.arange(stimulus.way.size) + 0.5) * step_ms / 1000.0
    np.testing.assert_allclose(np.degrees(stimulus.angle_in_step), np.interp(middle, stimulus.time, running), atol=1e-9)


def test_what_is_sensed_lies_ahead_in_the_turn_and_twice_as_far_under_a_polariser():
    stimulus = turning_stimulus(60.0, 1, 100.0)
    plain = sensed_heading(stimulus, 0.0, False)
    np.testing.assert_allclose(plain, wrap(stimulus.angle_in_step))
    ahead = wrap(sensed_heading(stimulus, 0.3, False) - plain)
    np.testing.assert_allclose(ahead, 0.3 * np.repeat([1.0, -1.0], plain.size // 2))
    np.testing.assert_allclose(wrap(sensed_heading(stimulus, 0.3, True) - 2.0 * (plain + ahead)), 0.0, atol=1e-12)


@pytest.mark.parametrize("step_ms", [10.0, 100.0])
def test_flow_bouts_have_the_published_times(step_ms: float):
    velocity = np.array([[0.0, 0.7], [0.0, 0.0], [0.6, 0.0]])
    protocol = flow_protocol(velocity, np.array([0.0, np.pi / 6.0, 0.0]), step_ms)
    np.testing.assert_allclose(protocol.stop - protocol.start, 3.0)
    np.testing.assert_allclose(np.diff(protocol.start), 6.5)
    assert protocol.start[0] - protocol.onset == pytest.approx(0.5)
    assert protocol.onset >= 2.0  # s of background
    time = (np.arange(len(protocol.heading)) + 0.5) * step_ms / 1000.0
    assert time[-1] + 0.5 * step_ms / 1000.0 == pytest.approx(protocol.stop[-1] + 3.0)
    speed = np.linalg.norm(protocol.velocity, axis=-1)
    during = [(time > start) & (time < stop) for start, stop in zip(protocol.start, protocol.stop, strict=True)]
    for bout, expected in zip(during, (0.7, 0.0, 0.6), strict=True):
        np.testing.assert_allclose(speed[bout], expected)
    assert not speed[~np.any(during, axis=0)].any()
    # a quarter turn to the right in the second bout; a step to the right of the body then leads along −y
    assert wrap(protocol.heading[-1] - np.pi / 2.0) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(protocol.velocity[during[2]], [[0.0, -0.6]] * during[2].sum(), atol=1e-9)


def test_spikes_follow_the_rate_they_are_made_from():
    """Number of spikes within five standard deviations, their times as the integral of the rate."""
    n_steps, step_ms, peak = 4000, 10.0, 150.0
    rate = 0.5 + 0.5 * np.sin(np.arange(n_steps) * 2.0 * np.pi / 1000.0)
    spikes = poisson_spikes(rate, step_ms, peak, spike_generator(1, (0,)))
    expected = np.concatenate([[0.0], np.cumsum(rate)]) * peak * step_ms / 1000.0
    assert abs(spikes.size - expected[-1]) < 5.0 * np.sqrt(expected[-1])
    assert np.all(np.diff(spikes) >= 0.0)
    edges = np.arange(n_steps + 1) * step_ms / 1000.0
    assert kstest(np.interp(spikes, edges, expected / expected[-1]), "uniform").pvalue > 0.001


def test_spikes_of_other_recordings_are_others():
    rate = np.full(500, 0.5)
    first, again, other = (poisson_spikes(rate, 10.0, 150.0, spike_generator(1, (k,))) for k in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert not np.intersect1d(first, other).size
    assert not poisson_spikes(np.zeros(10), 10.0, 150.0, spike_generator(1, (0,))).size
