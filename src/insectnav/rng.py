"""From one seed, an independent and reproducible stream of random numbers for every trial."""

import hashlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_count, check_range

MAX_SPAN = 100_000_000  # trials; 32 bytes each


def trial_streams(seed: int, trials: ArrayLike, purpose: str) -> NDArray[np.uint32]:
    """Random number generators of the given trials, (n, 4) words of xoshiro128++ state.

    Parameters
    ----------
    seed : int
        Not negative.
    trials : (n,) array of int
        Numbers of the trials. A trial's stream depends on the seed, the purpose and its number alone: not on how many
        trials there are, nor on how they are split over batches, threads or machines.
    purpose : str
        What the numbers are for ("routes", "circuit"), so that two uses of one seed are independent.

    Raises
    ------
    InputError
        If the seed or a trial number is negative or not whole.

    Notes
    -----
    Trial k takes the k-th block of the counter-based generator Philox4x64-10 (Salmon et al. 2011, SC '11,
    doi 10.1145/2063384.2063405), keyed by NumPy's `SeedSequence`. Different trials differ by construction.
    """
    check_count("seed", seed, minimum=0)
    trials = np.asarray(trials)
    if trials.size == 0:
        return np.empty((0, 4), np.uint32)
    if trials.dtype.kind not in "iu":
        raise InputError(f"trial numbers are {trials.dtype.name} values, expected whole numbers")
    lowest, highest = int(trials.min()), int(trials.max())
    check_count("trial number", lowest, minimum=0)
    check_range("highest minus lowest trial number", highest - lowest, 0, MAX_SPAN)
    purpose_key = int.from_bytes(hashlib.sha256(purpose.encode()).digest()[:8], "little")
    generator = np.random.Philox(np.random.SeedSequence([int(seed), purpose_key]))
    generator.advance(lowest)
    blocks = generator.random_raw(4 * (highest - lowest + 1)).reshape(-1, 4)
    return np.ascontiguousarray(blocks[trials - lowest, :2]).view(np.uint32)
