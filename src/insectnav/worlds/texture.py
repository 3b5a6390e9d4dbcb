"""Texture of surfaces: 1/f noise that is fixed in the world, a value for each point of space."""

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import as_numbers, check_count, check_finite, check_range, check_shape

MAX_CELLS = 1e9  # lattice cells from the origin
MAX_OCTAVES = 20
# Gradients of Perlin (2002): from the centre of a cube to the middles of its twelve edges.
_GRADIENTS = np.array([np.roll((a, b, 0.0), turn) for a in (-1, 1) for b in (-1, 1) for turn in range(3)])
_VARIANCE = 16 * (535 / 18018) * (181 / 462) ** 2  # of one octave: Notes of `texture`
_CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
_PRIMES = (0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)  # odd, so that no corner is lost


def texture(points: npt.ArrayLike, *, seed: int, coarsest: float = 1.0, n_octaves: int = 8) -> Floats:
    """Value of the texture at points of the world, mean 0 and variance 1 over all places.

    The same point has the same value from wherever it is seen, on any machine, whatever other points are asked for.

    Parameters
    ----------
    points : (..., 3) array of x, y, z [m]
    seed : int
        Not negative.
    coarsest : float
        Size of the coarsest pattern [m].
    n_octaves : int
        Each has half the size of the one before; the finest is ``coarsest`` / 2 ** (``n_octaves`` − 1).

    Returns
    -------
    array
        (...). A reflectance r becomes r · (1 + contrast · value), see `textured`.

    Raises
    ------
    InputError
        If a point is not finite or too far away, or a parameter makes no sense.

    Notes
    -----
    The amplitude of natural images falls as 1/f of the spatial frequency f (Field 1987, J. Opt. Soc. Am. A 4,
    doi 10.1364/JOSAA.4.002379): each octave then has the same variance, and along a line the power falls as 1/f.
    The octaves are gradient noise (Perlin 2002, doi 10.1145/566654.566636) with equal weights, each moved and seeded
    for itself. With gradients g of the corners c, independent, of covariance ⅔, an octave is
    Σ_c g_c · (x − c) Π w(|x − c|), w(t) = 1 − 6t⁵ + 15t⁴ − 10t³, and its variance over all x is
    16 ∫ w² t² dt (∫ w² dt)² = 16 · 535/18018 · (181/462)².
    """
    points = np.asarray(as_numbers("points", points), dtype=np.float64)
    check_shape("points", points, (..., 3))
    check_count("seed", seed, minimum=0)
    check_count("n_octaves", n_octaves)
    check_range("n_octaves", n_octaves, 1, MAX_OCTAVES)
    check_range("coarsest", coarsest, 1e-4, 1e4, "m")
    check_finite("points", points)
    finest = coarsest / 2.0 ** (n_octaves - 1)
    check_range("points", points, -MAX_CELLS * finest, MAX_CELLS * finest, "m")
    salts = np.random.SeedSequence([int(seed), 0x7E7]).generate_state(n_octaves, np.uint64)
    flat = points.reshape(-1, 3)
    total = np.zeros(len(flat))
    for octave, salt in enumerate(salts):
        shift = np.array([int(salt) >> bits & 0xFFFF for bits in (0, 16, 32)]) / 65536.0
        total += _gradient_noise(flat * (2.0**octave / coarsest) + shift, salt)
    return (total / np.sqrt(n_octaves * _VARIANCE)).reshape(points.shape[:-1])


def textured(reflectance: npt.ArrayLike, value: npt.ArrayLike, contrast: float = 0.3) -> Floats:
    """Reflectance with texture, r · (1 + contrast · value), kept within 0…1.

    Parameters
    ----------
    reflectance : array in 0…1
    value : array that broadcasts with it, of `texture`
    contrast : float
        Standard deviation over mean; 0 is flat.

    Raises
    ------
    InputError
        If the contrast is not within 0…1.
    """
    check_range("contrast", contrast, 0.0, 1.0)
    return np.clip(np.asarray(reflectance) * (1.0 + contrast * np.asarray(value)), 0.0, 1.0)


def _gradient_noise(points: Floats, salt: np.uint64) -> Floats:
    """One octave, lattice of size 1."""
    cell = np.floor(points)
    within = points - cell
    corner = cell.astype(np.int64).view(np.uint64)
    fade = within * within * within * (within * (within * 6.0 - 15.0) + 10.0)
    total = np.zeros(points.shape[:-1])
    keys = _keys(corner, salt)
    for offset in _CORNERS:
        gradient = _GRADIENTS[keys[offset] % np.uint64(12)]
        weight, slope = np.ones_like(total), np.zeros_like(total)
        for axis, step in enumerate(offset):
            weight = weight * (fade[..., axis] if step else 1.0 - fade[..., axis])
            slope = slope + gradient[..., axis] * (within[..., axis] - step)
        total += weight * slope
    return total


def _keys(corner: npt.NDArray[np.uint64], salt: np.uint64) -> dict[tuple[int, ...], npt.NDArray[np.uint64]]:
    """A number for each of the eight corners of a cell, by their offsets; all bits mixed (SplitMix64, Steele 2014)."""
    keys: dict[tuple[int, ...], npt.NDArray[np.uint64]] = {(): np.full(corner.shape[:-1], salt)}
    for axis, prime in enumerate(_PRIMES):
        steps = [(corner[..., axis] + np.uint64(step)) * np.uint64(prime) for step in (0, 1)]
        keys = {(*offset, step): _mixed(key ^ steps[step]) for offset, key in keys.items() for step in (0, 1)}
    return keys


def _mixed(key: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    key = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    key = (key ^ (key >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return key ^ (key >> np.uint64(31))
