"""The texture a second time, in plain NumPy: one octave of gradient noise after the other."""

import numpy as np

GRADIENTS = np.array([np.roll((a, b, 0.0), turn) for a in (-1, 1) for b in (-1, 1) for turn in range(3)])
CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
PRIMES = (0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)


def octave(points: np.ndarray, salt: np.uint64) -> np.ndarray:
    """One octave on a lattice of size 1, (...) of points (..., 3)."""
    cell = np.floor(points)
    within = points - cell
    corner = cell.astype(np.int64).view(np.uint64)
    fade = within * within * within * (within * (within * 6.0 - 15.0) + 10.0)
    total = np.zeros(points.shape[:-1])
    keys = keys_of(corner, salt)
    for offset in CORNERS:
        gradient = GRADIENTS[keys[offset] % np.uint64(12)]
        weight, slope = np.ones_like(total), np.zeros_like(total)
        for axis, step in enumerate(offset):
            weight = weight * (fade[..., axis] if step else 1.0 - fade[..., axis])
            slope = slope + gradient[..., axis] * (within[..., axis] - step)
        total += weight * slope
    return total


def keys_of(corner: np.ndarray, salt: np.uint64) -> dict[tuple[int, ...], np.ndarray]:
    """A number for each of the eight corners of a cell, by their offsets; all bits mixed (SplitMix64, Steele 2014)."""
    keys: dict[tuple[int, ...], np.ndarray] = {(): np.full(corner.shape[:-1], salt)}
    for axis, prime in enumerate(PRIMES):
        steps = [(corner[..., axis] + np.uint64(step)) * np.uint64(prime) for step in (0, 1)]
        keys = {(*offset, step): mixed(key ^ steps[step]) for offset, key in keys.items() for step in (0, 1)}
    return keys


def mixed(key: np.ndarray) -> np.ndarray:
    key = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    key = (key ^ (key >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return key ^ (key >> np.uint64(31))
