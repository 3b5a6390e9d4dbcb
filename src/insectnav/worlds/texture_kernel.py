"""Texture, compiled: gradient noise in octaves, and what a pixel of some width leaves of it."""

from typing import Any, NamedTuple

import numpy as np

from insectnav.lanes.compiled import kernel, lane_function

# Gradients of Perlin (2002): from the centre of a cube to the middles of its twelve edges.
GRADIENTS = np.array([np.roll((a, b, 0.0), turn) for a in (-1, 1) for b in (-1, 1) for turn in range(3)])
PRIME_X, PRIME_Y, PRIME_Z = (  # odd, so that no corner is lost
    np.uint64(0x9E3779B185EBCA87),
    np.uint64(0xC2B2AE3D27D4EB4F),
    np.uint64(0x165667B19E3779F9),
)
FIRST_FACTOR, SECOND_FACTOR = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
N_GRADIENTS = np.uint64(12)


class Octaves(NamedTuple):
    """Texture of a world, as kernels read it."""

    salt: Any  # (octave,) uint64, a number of its own for each
    shift: Any  # (octave, 3) by how much each lattice is moved, in its cells
    coarsest: float  # [m] size of the first octave's cells
    scale: float  # of the sum, such that its variance is 1


@lane_function
def mix(key):
    """All bits of a key mixed (SplitMix64, Steele et al. 2014, doi 10.1145/2660193.2660195)."""
    key = (key ^ (key >> np.uint64(30))) * FIRST_FACTOR
    key = (key ^ (key >> np.uint64(27))) * SECOND_FACTOR
    return key ^ (key >> np.uint64(31))


@lane_function
def corner_value(key, x, y, z):
    """Slope of a corner of the lattice times the way from it."""
    row = key % N_GRADIENTS
    return GRADIENTS[row, 0] * x + GRADIENTS[row, 1] * y + GRADIENTS[row, 2] * z


@lane_function
def fade(t):
    """From 0 to 1, with first and second derivatives of 0 at both ends."""
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


@lane_function
def gradient_noise(x, y, z, salt):
    """One octave at a place in units of its lattice: the eight corners round it, weighted."""
    i, j, k = np.floor(x), np.floor(y), np.floor(z)
    x, y, z = x - i, y - j, z - k
    one = np.uint64(1)
    column, row, layer = np.uint64(np.int64(i)), np.uint64(np.int64(j)), np.uint64(np.int64(k))
    fx, fy, fz = fade(x), fade(y), fade(z)
    total = 0.0
    for di in range(2):
        along_x = mix(salt ^ ((column + one * np.uint64(di)) * PRIME_X))
        for dj in range(2):
            along_y = mix(along_x ^ ((row + one * np.uint64(dj)) * PRIME_Y))
            weight = (fx if di else 1.0 - fx) * (fy if dj else 1.0 - fy)
            low = corner_value(mix(along_y ^ (layer * PRIME_Z)), x - di, y - dj, z)
            high = corner_value(mix(along_y ^ ((layer + one) * PRIME_Z)), x - di, y - dj, z - 1.0)
            total += weight * (low * (1.0 - fz) + high * fz)
    return total


@lane_function
def texture_at(x, y, z, octaves, width):
    """Value at a point [m], without the octaves that a pixel of that width there [m] averages away.

    An octave counts in full where its cells are at least four widths across, not at all from two downwards.
    """
    total, size = 0.0, octaves.coarsest
    for octave in range(octaves.salt.shape[0]):
        share = 1.0 if width <= 0.0 else min(1.0, 0.5 * size / width - 1.0)
        if share <= 0.0:
            break
        a, b, c = octaves.shift[octave, 0], octaves.shift[octave, 1], octaves.shift[octave, 2]
        total += share * gradient_noise(x / size + a, y / size + b, z / size + c, octaves.salt[octave])
        size = 0.5 * size
    return total * octaves.scale


@kernel
def texture_of_points(points, octaves, values):
    """Write the texture, unblurred, of points (n, 3) [m] to values (n,)."""
    for i in range(points.shape[0]):
        values[i] = texture_at(points[i, 0], points[i, 1], points[i, 2], octaves, 0.0)
