"""Texture of surfaces: 1/f noise that is fixed in the world, a value for each point of space."""

from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats
from insectnav.checks import as_numbers, check_count, check_finite, check_range, check_shape

MAX_CELLS = 1e9  # lattice cells from the origin
MAX_OCTAVES = 20
_VARIANCE = 16 * (535 / 18018) * (181 / 462) ** 2  # of one octave: Notes of `texture`


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
    from insectnav.worlds.texture_kernel import texture_of_points

    points = np.asarray(as_numbers("points", points), dtype=np.float64)
    check_shape("points", points, (..., 3))
    check_finite("points", points)
    octaves = pack_octaves(seed, coarsest, n_octaves)
    finest = coarsest / 2.0 ** (n_octaves - 1)
    check_range("points", points, -MAX_CELLS * finest, MAX_CELLS * finest, "m")
    flat = np.ascontiguousarray(points.reshape(-1, 3))
    values = np.empty(len(flat))
    texture_of_points(flat, octaves, values)
    return values.reshape(points.shape[:-1])


def pack_octaves(seed: int, coarsest: float, n_octaves: int) -> Any:
    """Texture in the form that kernels read.

    Parameters
    ----------
    seed, coarsest, n_octaves
        As of `texture`.

    Raises
    ------
    InputError
        If a parameter makes no sense.
    """
    from insectnav.worlds.texture_kernel import Octaves

    check_count("seed", seed, minimum=0)
    check_count("n_octaves", n_octaves)
    check_range("n_octaves", n_octaves, 1, MAX_OCTAVES)
    check_range("coarsest", coarsest, 1e-4, 1e4, "m")
    salts = np.random.SeedSequence([int(seed), 0x7E7]).generate_state(n_octaves, np.uint64)
    shift = [[(int(salt) >> bits & 0xFFFF) / 65536.0 for bits in (0, 16, 32)] for salt in salts]
    return Octaves(
        salt=salts, shift=np.array(shift), coarsest=float(coarsest), scale=float(1.0 / np.sqrt(n_octaves * _VARIANCE))
    )


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
