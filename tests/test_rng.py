"""Streams of random numbers: one for each seed, purpose and trial, whatever else is asked for."""

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from insectnav.checks import InputError
from insectnav.rng import trial_streams

FULL = trial_streams(7, np.arange(200), "circuit")


def test_streams_are_four_words_a_trial() -> None:
    assert FULL.shape == (200, 4)
    assert FULL.dtype == np.uint32
    assert FULL.flags.c_contiguous


def test_same_seed_gives_the_same_streams() -> None:
    np.testing.assert_array_equal(trial_streams(7, np.arange(200), "circuit"), FULL)


def test_streams_are_the_same_in_every_version_and_on_every_machine() -> None:
    # Philox4x64-10 of NumPy, asked for one block at a time: the promise that results can be repeated years later.
    purpose_key = int.from_bytes(hashlib.sha256(b"circuit").digest()[:8], "little")
    key = np.random.SeedSequence([7, purpose_key]).generate_state(2, np.uint64)
    for trial in (0, 1, 63, 199):
        block = np.random.Philox(key=key, counter=trial).random_raw(4)
        assert FULL[trial].tolist() == block[:2].view(np.uint32).tolist()


@given(n_trials=st.integers(0, 200))
def test_more_trials_leave_the_first_ones_as_they_are(n_trials: int) -> None:
    np.testing.assert_array_equal(trial_streams(7, np.arange(n_trials), "circuit"), FULL[:n_trials])


@given(trials=st.lists(st.integers(0, 199), max_size=20))
def test_any_trials_in_any_order_get_their_own_streams(trials: list[int]) -> None:
    np.testing.assert_array_equal(trial_streams(7, np.array(trials, int), "circuit"), FULL[trials])


def test_trials_far_out_have_streams_too() -> None:
    far = trial_streams(7, [10**15, 10**15 + 1], "circuit")
    np.testing.assert_array_equal(trial_streams(7, [10**15 + 1], "circuit"), far[1:])
    assert len(np.unique(np.concatenate([far, FULL[:10]]), axis=0)) == 12


@pytest.mark.parametrize("dtype", [np.int16, np.uint8, np.int64, np.uint64])
def test_kind_of_whole_number_does_not_matter(dtype: type) -> None:
    np.testing.assert_array_equal(trial_streams(7, np.array([3, 1, 4], dtype), "circuit"), FULL[[3, 1, 4]])
    np.testing.assert_array_equal(trial_streams(np.int32(7), [3, 1, 4], "circuit"), FULL[[3, 1, 4]])


def test_trials_seeds_and_purposes_differ() -> None:
    streams = [
        trial_streams(seed, np.arange(500), purpose)
        for seed in (0, 1, 2**40, 2**80)
        for purpose in ("circuit", "routes")
    ]
    assert len(np.unique(np.concatenate(streams), axis=0)) == 4 * 2 * 500


def test_no_trials_have_no_streams() -> None:
    assert trial_streams(0, [], "circuit").shape == (0, 4)


def test_words_look_random() -> None:
    words = trial_streams(3, np.arange(20_000), "routes")
    assert stats.kstest(words.ravel() / 2.0**32, "uniform").pvalue > 1e-4
    bits = np.unpackbits(words.view(np.uint8), axis=1).astype(float)  # (trial, 128)
    assert np.abs(bits.mean(axis=0) - 0.5).max() < 5 / np.sqrt(4 * len(words))
    between = np.corrcoef(bits, rowvar=False) - np.eye(128)
    assert np.abs(between).max() < 5.5 / np.sqrt(len(words))
    from_trial_to_trial = np.corrcoef(words[1:, 0], words[:-1, 0])[0, 1]
    assert abs(from_trial_to_trial) < 5 / np.sqrt(len(words))


@pytest.mark.parametrize("seed", [-1, 1.5, "seven", None, True])
def test_seed_that_is_no_whole_number_is_refused(seed: object) -> None:
    with pytest.raises(InputError, match=r"^seed is .*, expected a whole number of at least 0$"):
        trial_streams(seed, [0], "circuit")


@pytest.mark.parametrize("trials", [[-1], [3, -2, 5], [0.5], [np.nan]])
def test_trial_number_that_is_no_whole_number_is_refused(trials: list) -> None:
    with pytest.raises(InputError, match=r"trial number.*whole number"):
        trial_streams(0, trials, "circuit")
