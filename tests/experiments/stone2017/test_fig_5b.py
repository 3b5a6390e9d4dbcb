"""Activity over a trip: the same trial in both of its parts, closed forms, and small runs to the verdicts."""

import numpy as np
import pytest

from insectnav.experiments.stone2017_path_integration import fig_5b
from insectnav.experiments.stone2017_path_integration.fig_5b import WINDOW, Cell, pattern_height
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS, example_trip
from small_runs import same_bits, simulated, verdicts_of

SMALL = Cell(preset="thesis", n_trials=3, n_inbound=60)


@pytest.fixture(scope="module")
def results():
    return simulated(fig_5b, [SMALL, Cell(preset="code-2017", n_trials=3, n_inbound=60)])


def test_small_run_gives_all_verdicts(results):
    verdicts_of(fig_5b, "stone2017-fig-5b", results)


def test_same_seed_same_bits():
    assert same_bits(fig_5b, SMALL)


def test_trip_shown_is_the_first_of_those_measured(results):
    rates = results["activity_cpu4"][0, :N_STEPS].astype(float)
    for window in (0, 7, N_STEPS // WINDOW - 1):
        expected = rates[window * WINDOW : (window + 1) * WINDOW].mean()
        assert results["mean_rate_cpu4"][0, 0, window] == pytest.approx(expected, rel=1e-5)


def test_gain_and_loss_make_the_memory(results):
    """From a memory of a half, N steps of gain less loss lead to the mean memory that is recorded at the turn."""
    for index, loss in ((0, 0.1), (1, 0.125)):
        memory = 0.5 + N_STEPS * 0.0025 * (results["mean_drive"][index, 0] - loss)
        assert memory == pytest.approx(results["activity_memory"][index, N_STEPS - 1].mean(), abs=1e-5)


def test_parts_are_as_the_whole(monkeypatch: pytest.MonkeyPatch):
    whole = fig_5b.simulate(SMALL, 2)
    monkeypatch.setattr(fig_5b, "PART", 2)
    parts = fig_5b.simulate(SMALL, 2)
    for name in ("mean_rate_cpu4", "pattern_pontine", "mean_drive"):
        np.testing.assert_array_equal(parts[name][1], whole[name][1])


@pytest.mark.parametrize(("mean", "height", "phase"), [(0.5, 0.2, 0.3), (0.1, 0.0, 0.0), (0.4, 0.4, -2.0)])
def test_height_of_a_sinusoid_is_its_amplitude(mean: float, height: float, phase: float):
    columns = mean + height * np.cos(np.arange(8) * np.pi / 4.0 - phase)
    other = mean + 3.0 * height * np.cos(np.arange(8) * np.pi / 4.0 + phase)
    assert pattern_height(np.tile(columns, (2, 3, 2))) == pytest.approx(np.full((2, 3), height))
    assert pattern_height(np.concatenate([columns, other])) == pytest.approx(2.0 * height)


def test_example_trip_follows_from_the_seed():
    heading, velocity = example_trip(3)
    assert heading.shape == (1, N_STEPS)
    assert velocity.shape == (1, N_STEPS, 2)
    np.testing.assert_array_equal(example_trip(3)[1], velocity)
    assert not np.array_equal(example_trip(4)[1], velocity)
