"""Memories as sinusoids: against the plain oracle, closed forms and symmetry; small runs to the verdicts."""

import numpy as np
import pytest

import oracle
from insectnav.central_complex import PRESETS, circuit_params
from insectnav.experiments.stone2017_path_integration import ed_7
from insectnav.experiments.stone2017_path_integration.ed_7 import COURSES, FACINGS, FLIGHT, LEGS, SPEED, Cell, fly
from small_runs import same_bits, simulated, verdicts_of


@pytest.fixture(scope="module")
def results():
    return simulated(ed_7, [Cell(preset=preset, n_trials=40) for preset in PRESETS])


def test_small_run_gives_all_verdicts(results):
    verdicts_of(ed_7, "stone2017-ed-7", results)


def test_same_seed_same_bits():
    assert same_bits(ed_7, Cell(preset="thesis", n_trials=2))


@pytest.mark.parametrize("variant", ["partially-holonomic", "idealised"])
def test_memory_of_a_flight_is_that_of_the_oracle(variant: str):
    heading = np.concatenate([np.full(n_steps, angle) for angle, n_steps in LEGS])
    velocity = SPEED * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    expected = oracle.run_trial(heading, velocity, 0, oracle.variant_params(variant))["memory_at_turn"]
    np.testing.assert_allclose(fly(LEGS, circuit_params(variant)), expected, atol=1e-9)


def test_idealised_memory_is_a_sinusoid_of_known_size_and_phase(results):
    """A leg of length A along α adds h A cos(α − d_j ∓ 45°) / 4 to column j of the right and left half."""
    directions = np.arange(8) * np.pi / 4.0
    for (angle, n_steps), memory in zip(LEGS, results["leg_memory"][0], strict=False):
        wave = 0.0025 * SPEED * n_steps / 4.0 * np.cos(angle - directions)
        # Straight ahead both halves see cos 45° of the speed.
        np.testing.assert_allclose(memory, np.tile(wave * np.cos(np.pi / 4.0), (2, 1)), atol=1e-9)


def test_idealised_memories_add_up_exactly(results):
    first, second, both, direct = results["leg_memory"][0]
    np.testing.assert_allclose(first + second, both, atol=1e-9)
    # The direct way has other single halves only if flown sideways, which it is not: the sum is the same in each.
    np.testing.assert_allclose(both, direct, atol=1e-9)


def test_charge_is_mirror_symmetric(results):
    """Course and half change sides together: −180° has no partner."""
    charge = results["charge"][0]
    mirrored = charge[1:][::-1]
    np.testing.assert_allclose(charge[1:, 0], mirrored[:, 1], atol=1e-9)
    assert np.degrees(COURSES[np.argmax(charge[:, 0])]) == pytest.approx(45.0)
    behind = np.abs(np.degrees(COURSES)) > 140.0
    assert charge[behind].max() < 1e-6  # no rate answers to backward motion, for the charge is rectified


def test_turns_after_a_flight_along_a_column_are_antisymmetric(results):
    for turn in results["turn_along_column"]:
        np.testing.assert_allclose(turn[1:], -turn[1:][::-1], atol=1e-9)
        assert turn[0] == pytest.approx(0.0, abs=1e-9)  # straight away: a point of balance
        facing = np.degrees(FACINGS)
        assert (turn[(facing > 20.0) & (facing < 160.0)] > 0.0).all()  # home on the right: to the right


@pytest.mark.parametrize(("preset", "params"), [("thesis", oracle.THESIS), ("code-2017", oracle.CODE_2017)])
def test_turns_without_noise_are_those_of_the_oracle(results, preset: str, params: oracle.OracleParams):
    index = results.only(preset=preset)
    for rank in (0, 6, 12, 18):
        heading = oracle.wrap(FLIGHT[0] - np.pi - FACINGS[rank])
        tb1, memory = np.zeros(8), results["memory"][index].reshape(16)
        for _ in range(ed_7.SETTLING):
            tb1, memory, rates = oracle.step(tb1, memory, heading, np.zeros(2), params)
        assert results["turn_without_noise"][index, rank] == pytest.approx(rates["motor"], abs=1e-9)


def test_ring_of_a_pure_cosine_lies_in_its_first_harmonic(results):
    arrays = {**results.arrays, "ring": np.tile(0.5 + 0.3 * np.cos(np.arange(8) * np.pi / 4.0 - 0.7), (2, 1))}
    row = ed_7.summarise(type(results)(results.cells, arrays))[0]
    assert row["share_of_ring_in_first_harmonic"] == pytest.approx(1.0)
    arrays["ring"] = np.tile(np.array([1.0, 0.0] * 4), (2, 1))  # all in the fourth
    row = ed_7.summarise(type(results)(results.cells, arrays))[0]
    assert row["share_of_ring_in_first_harmonic"] == pytest.approx(0.0, abs=1e-12)
