"""A layer of clouds that drifts with the wind: how thick it is in every direction and at every time.

The layer lies at one height over a round Earth, so that clouds shrink towards the horizon and end there, 138 km away
for a base at 1500 m. Its optical depth is fractal noise, cut off at a rank: a share `cover` of the layer is cloud, and
the optical depth of the cloud is spread evenly about its mean. The layer has no vertical extent: clouds show no sides.

The pattern is the same to the last bit on all machines: it is made of whole numbers, sums and products only.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, as_numbers, check_choice, check_count, check_finite, check_range, check_shape

Reals = npt.NDArray[np.floating[Any]]
Words = npt.NDArray[np.uint32]

EARTH_RADIUS = 6.371e6  # [m]
ASYMMETRY = 0.85  # mean cosine of scattering by water clouds: Bohren 1987
OVERCAST_TRANSMITTANCE = 0.25  # Kasten and Czeplak 1980, doi 10.1016/0038-092X(80)90391-6, Eq. 4
OCTAVES = 7
GAIN = 0.637  # amplitude of each octave over that of the one before, 2^−0.65: see fractal_noise
RANKED = 16_384  # places whose noise tells the rank of any other
DIAGONAL = float(np.sqrt(0.5))
GRADIENTS = np.array(
    [(1, 0), (0, 1), (-1, 0), (0, -1)] + [(x * DIAGONAL, y * DIAGONAL) for x in (1, -1) for y in (1, -1)]
)


class CloudPath(NamedTuple):
    """What a line of sight meets; arrays (...)."""

    optical_depth: Reals  # of the layer, vertically, where the line meets it
    slant: Reals  # length of the way through the layer over its thickness


@dataclass(frozen=True, kw_only=True)
class CloudField:
    """A cloud layer.

    Parameters
    ----------
    seed : int
        Decides where the clouds are.
    cover : float
        Expected share of the layer that is cloud, 0 to 1. As every direction meets a cloud with this probability, the
        share of one sky may differ: a sky shows few of the largest clouds.
    optical_depth : float
        Mean over the clouds, vertically.
    variation : float
        Range of the optical depth about its mean: 1 is from zero to twice the mean, 0 is a sheet.
    base_height : float [m]
    size : float [m]
        Of the largest clouds and gaps.
    wind : (2,) sequence [m/s]
        Velocity of the clouds to the east and to the north.

    Raises
    ------
    InputError
        If a value cannot be.
    """

    seed: int = 0
    cover: float = 0.5
    optical_depth: float = 8.0
    variation: float = 1.0
    base_height: float = 1500.0
    size: float = 2000.0
    wind: Sequence[float] = (8.0, 3.0)

    def __post_init__(self) -> None:
        check_count("seed", self.seed, minimum=0)
        check_range("seed", self.seed, 0, 2**60)
        check_range("cover", self.cover, 0.0, 1.0, "", "a share, not a percentage or oktas")
        check_range("optical_depth", self.optical_depth, 0.0, 1e4)
        check_range("variation", self.variation, 0.0, 1.0)
        check_range("base_height", self.base_height, 50.0, 2e4, "m", "kilometres or feet?")
        check_range("size", self.size, 50.0, 1e6, "m", "kilometres?")
        wind = as_numbers("wind", self.wind)
        check_shape("wind", wind, (2,))
        check_finite("wind", wind)
        check_range("wind", wind, -200.0, 200.0, "m/s")
        object.__setattr__(self, "wind", tuple(wind.astype(float).tolist()))

    def look(self, directions: npt.ArrayLike, time: float = 0.0) -> CloudPath:
        """Clouds along lines of sight from the ground; the horizon counts for all directions below it.

        Parameters
        ----------
        directions : (..., 3) array of unit vectors: +x east, +y north, +z up
        time : float [s]
        """
        places, slant = layer_places(directions, self.base_height)
        return CloudPath(self.optical_depth_over(places, time), slant)

    def optical_depth_over(self, places: npt.ArrayLike, time: float = 0.0) -> Reals:
        """Vertical optical depth (...) of the layer over places on the ground.

        Parameters
        ----------
        places : (..., 2) array [m], east and north
        time : float [s]
        """
        check_range("time", time, -1e10, 1e10, "s", "milliseconds?")
        drifted = (np.asarray(places, dtype=float) - np.multiply(self.wind, time)) / self.size
        rank = np.searchsorted(ranked_noise(), fractal_noise(drifted, self.seed)) / RANKED
        if self.cover == 0.0:
            return np.zeros_like(rank)
        return np.where(rank >= 1.0 - self.cover, self.depth_at_rank((rank - 1.0 + self.cover) / self.cover), 0.0)

    def depth_at_rank(self, rank: npt.ArrayLike) -> Reals:
        """Optical depth of the given share of the clouds, from 0 for the thinnest to 1 for the thickest."""
        spread = 1.0 + self.variation * (2.0 * np.clip(rank, 0.0, 1.0) - 1.0)
        return np.asarray(self.optical_depth * spread)


def weather_clouds(weather: str, seed: int = 0, wind: Sequence[float] = (8.0, 3.0)) -> CloudField | None:
    """Clouds of a kind of weather: "clear" (none), "scattered" (3.5 oktas), "broken" (6 oktas) or "overcast".

    Raises
    ------
    InputError
        If the weather is none of these.

    Notes
    -----
    The words and the middles of their ranges (3 to 4 and 5 to 7 oktas) are those of aviation weather reports, WMO
    Manual on Codes (WMO-No. 306), FM 15. The overcast sky transmits a quarter of the light (Kasten and Czeplak 1980).
    Assumed are the optical depth of separate clouds, 8, and that of the overcast, within 30 % of its mean.
    """
    check_choice("weather", weather, WEATHERS)
    if weather == "clear":
        return None
    if weather == "overcast":
        depth = depth_of_transmittance(OVERCAST_TRANSMITTANCE)
        return CloudField(seed=seed, cover=1.0, optical_depth=depth, variation=0.3, base_height=1000.0, wind=wind)
    return CloudField(seed=seed, cover={"scattered": 3.5 / 8, "broken": 6 / 8}[weather], wind=wind)


WEATHERS = ("clear", "scattered", "broken", "overcast")


def transmittance(optical_depth: npt.ArrayLike) -> Reals:
    """Share of the light that a wide cloud lets through, most of it scattered.

    Notes
    -----
    2 / (2 + (1 − g) τ), two streams without absorption: Bohren 1987, doi 10.1119/1.15109. Droplets are much larger than
    the wavelength, so that it is taken to be the same in all bands; measured, clouds pass somewhat more of the
    ultraviolet than of all sunlight (Calbó, Pagès and González 2005, doi 10.1029/2004RG000155).
    """
    return np.asarray(2.0 / (2.0 + (1.0 - ASYMMETRY) * np.asarray(optical_depth)))


def depth_of_transmittance(share: float) -> float:
    """Optical depth of a cloud that lets this share through: the inverse of `transmittance`."""
    return 2.0 * (1.0 / share - 1.0) / (1.0 - ASYMMETRY)


def opacity(path: CloudPath) -> Reals:
    """Share (...) of the light from behind that does not come straight through: Lambert and Beer's law."""
    return -np.expm1(-path.optical_depth * path.slant)


def layer_places(directions: npt.ArrayLike, base_height: float) -> tuple[Reals, Reals]:
    """Where lines of sight meet a layer, (..., 2) [m] east and north, and the slant (...) at which they do.

    The layer is a sphere about the centre of the Earth; the slant is 1 / cos of the angle to its own vertical. The
    horizon counts for all directions below it.

    Parameters
    ----------
    directions : (..., 3) array of unit vectors
    base_height : float [m]
    """
    directions = np.asarray(directions, dtype=float)
    sine = np.clip(directions[..., 2], 0.0, 1.0)
    rise, excess = EARTH_RADIUS * sine, base_height * (2.0 * EARTH_RADIUS + base_height)
    far = np.sqrt(rise**2 + excess)
    distance = excess / (far + rise)
    level = np.sqrt(np.square(directions[..., 0]) + np.square(directions[..., 1]))
    cosine = np.sqrt(1.0 - sine**2)
    scale = distance * np.divide(cosine, level, out=np.zeros_like(level), where=level > 0.0)
    return directions[..., :2] * scale[..., None], (EARTH_RADIUS + base_height) / far


def fractal_noise(places: npt.ArrayLike, seed: int) -> Reals:
    """Noise (...) whose largest features have the size 1, of mean 0.

    Parameters
    ----------
    places : (..., 2) array
    seed : int

    Notes
    -----
    Seven octaves of the gradient noise of Perlin 2002 (doi 10.1145/566654.566636) with eight gradients, each octave
    turned by the angle whose tangent is 4/3, so that no lattice shows. Amplitudes fall as 2^(−0.65 octave): the outline
    of a level of such noise has the dimension 2 − 0.65 = 1.35 that Lovejoy 1982 (doi 10.1126/science.216.4542.185)
    measured on clouds.
    """
    places = np.asarray(places, dtype=float)
    x, y = places.reshape(-1, 2).T
    total, amplitude = np.zeros(x.shape), 1.0
    for octave in range(OCTAVES):
        total += amplitude * gradient_noise(x, y, seed * OCTAVES + octave)
        x, y, amplitude = 2.0 * (0.6 * x - 0.8 * y), 2.0 * (0.8 * x + 0.6 * y), amplitude * GAIN
    return total.reshape(places.shape[:-1])


def gradient_noise(x: Reals, y: Reals, seed: int) -> Reals:
    """Smooth noise (n,) over x and y (n,) that is 0 where both are whole: Perlin 2002."""
    column, row = np.floor(x), np.floor(y)
    u, v = x - column, y - row
    corners = []
    for dy in (0, 1):
        along_row = [_pull(column + dx, row + dy, u - dx, v - dy, seed) for dx in (0, 1)]
        corners.append(along_row[0] + _fade(u) * (along_row[1] - along_row[0]))
    return corners[0] + _fade(v) * (corners[1] - corners[0])


def _pull(column: Reals, row: Reals, x: Reals, y: Reals, seed: int) -> Reals:
    """Product of a lattice point's gradient with the way from it."""
    key = mix_bits(np.array([seed >> 32, seed & 0xFFFFFFFF], dtype=np.uint32))
    word = mix_bits(row.astype(np.int64).astype(np.uint32) ^ key[0])
    word = mix_bits(column.astype(np.int64).astype(np.uint32) + word + key[1])
    gradient = GRADIENTS[word & 7]
    return gradient[..., 0] * x + gradient[..., 1] * y


def _fade(t: Reals) -> Reals:
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


def mix_bits(words: Words) -> Words:
    """Words (n,) in which every bit depends on every bit of the given ones: the end of MurmurHash3 (Appleby, 2011)."""
    words = words ^ (words >> np.uint32(16))
    words = words * np.uint32(0x85EBCA6B)
    words = words ^ (words >> np.uint32(13))
    words = words * np.uint32(0xC2B2AE35)
    return words ^ (words >> np.uint32(16))


@lru_cache(maxsize=1)
def ranked_noise() -> Reals:
    """Sorted noise (n,) at places so far apart that they are independent; the same for every seed."""
    index = np.arange(RANKED, dtype=float)
    # Steps of more than a hundred sizes; their fractions (Roberts 2018, R2) spread the places evenly over the lattice.
    places = np.stack([index * (128.0 + 0.7548776662466927), index * (128.0 + 0.5698402909980532)], axis=-1)
    ranked = np.sort(fractal_noise(places, 0))
    ranked.flags.writeable = False
    return ranked


def check_clouds(clouds: object) -> None:
    """Refuse anything but a cloud field or None."""
    if clouds is not None and not isinstance(clouds, CloudField):
        raise InputError(f"clouds is {type(clouds).__name__}, expected a CloudField or None: weather_clouds(name)?")
