"""What a digital camera makes of radiance: exposure, the noise of light and electronics, saturation and whole numbers.

A pixel that sees the radiance L collects a Poisson number of electrons, on average L / `saturation_radiance` times
`full_well`. The electronics add read noise and a black level, and round to whole numbers.

Left out: differences between pixels (fixed pattern noise), colour mosaics, blooming, motion during the exposure, and
compression.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_count, check_finite, check_range, check_shape
from insectnav.rng import trial_streams
from insectnav.vision.picture_stacks import radiance_stack
from insectnav.workers import run_blocks

RESPONSES = ("linear", "srgb")
METER_RULES = ("mean", "percentile")
Reals = NDArray[np.floating[Any]]
Counts = NDArray[np.unsignedinteger[Any]]


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Sensor of a camera with its exposure.

    The defaults of well and noise are those of a Sony IMX249, a common sensor of machine vision: signal to noise
    45.1 dB and dynamic range 73 dB (Matrix Vision, mvBlueFOX3 technical manual, mvBlueFOX3-2024a), of which the first
    is √full well and the second full well / (read noise + 0.5), by EMVA 1288.

    Parameters
    ----------
    saturation_radiance : the exposure: radiance that fills the range of numbers [W m⁻² nm⁻¹ sr⁻¹, or as the pictures]
    full_well : electrons that fill the range, the saturation capacity of EMVA 1288
    read_noise : standard deviation of what the electronics add [electrons]
    dark_signal : mean number of electrons that come without light. The camera takes the mean off, by its covered
        pixels; the noise of that number stays
    black_level : number that stands for no light, as a share of the range; only of the linear response
    bits : 8 to 16
    response : "linear", as in raw pictures, or "srgb", as in pictures for a screen
    photon_noise : whether light comes in whole photons, at random

    Raises
    ------
    InputError
        If a value is out of range.
    """

    saturation_radiance: float
    full_well: float = 32_400.0  # [electrons] 10^(45.1 / 10)
    read_noise: float = 6.7  # [electrons] 32 400 / 10^(73 / 20) - 0.5, less a little quantisation noise
    dark_signal: float = 0.0  # [electrons] assumed: exposures of milliseconds, as by day
    black_level: float = 60 / 1023  # 60 at 10 bits and 240 at 12: the Linux driver of the Sony IMX290
    bits: int = 8  # assumed: what cameras give unless told otherwise
    response: str = "linear"
    photon_noise: bool = True

    def __post_init__(self) -> None:
        _check_positive("saturation_radiance", self.saturation_radiance)
        check_range("full_well", self.full_well, 1.0, 1e9, "electrons")
        check_range("read_noise", self.read_noise, 0.0, self.full_well, "electrons")
        check_range("dark_signal", self.dark_signal, 0.0, self.full_well, "electrons")
        check_range("black_level", self.black_level, 0.0, 0.5, "of the range", "in digital numbers?")
        check_count("bits", self.bits, minimum=8)
        check_range("bits", self.bits, 8, 16)
        check_choice("response", self.response, RESPONSES)

    @property
    def largest_number(self) -> int:
        """What a saturated pixel reads."""
        return int(2**self.bits - 1)

    @property
    def gain(self) -> float:
        """Digital numbers an electron, the K of EMVA 1288, of the linear response."""
        return self.largest_number * (1.0 - self.black_level) / self.full_well


def ideal_sensor(saturation_radiance: float, *, bits: int = 16, response: str = "linear") -> Sensor:
    """Sensor without noise and black level: it only clips and rounds."""
    return Sensor(
        saturation_radiance=saturation_radiance,
        read_noise=0.0,
        black_level=0.0,
        bits=bits,
        response=response,
        photon_noise=False,
    )


def expose(
    radiance: ArrayLike,
    sensor: Sensor,
    *,
    seed: int,
    channel: str = "",
    saturation_radiance: ArrayLike | None = None,
    has_bands: bool = False,
    first_image: int = 0,
    workers: int | None = None,
) -> Counts:
    """Pictures in whole numbers, of the shape of the radiance: uint8 at 8 bits, else uint16.

    Parameters
    ----------
    radiance : (..., rows, columns) array [as the exposure of the sensor], (..., rows, columns, band) if `has_bands`
    sensor : Sensor
    seed : int
        Picture k of the batch has a stream of random numbers of its own, by seed, channel and k alone.
    channel : str
        What is exposed, such as "uv" or "green". Two pictures exposed with one seed and one channel have the same
        random numbers, and so noise that goes up and down together.
    saturation_radiance : (...) array, (..., band) if `has_bands`
        Exposure of each picture, as `auto_exposure` gives it; None for that of the sensor.
    has_bands : bool
        Whether the last axis is that of bands.
    first_image : int
        Number of the first picture, when the parts of a long series are exposed one after the other.
    workers : threads; None for as many as there are cores. They change nothing in the results

    Raises
    ------
    InputError
        If the radiance is negative, not finite or no picture, or the exposures do not go with it.

    Notes
    -----
    The linear model of EMVA Standard 1288, release 3.1 (2016), section 2, without the spatial part: for linear pictures
    the variance in time is K² σ_d² + σ_q² + K (μ - μ_dark), with the gain K, read and dark noise σ_d in electrons and
    σ_q² = 1/12. "srgb" encodes after all noise and without black level.
    """
    stack = radiance_stack(radiance, has_bands)
    full = stack.values_of_each(
        "saturation_radiance", sensor.saturation_radiance if saturation_radiance is None else saturation_radiance,
        has_bands,
    )  # fmt: skip
    _check_positive("saturation_radiance", full)
    check_count("first_image", first_image, minimum=0)
    n = len(stack.pictures)
    streams = trial_streams(seed, np.arange(first_image, first_image + n), f"sensor {channel}")
    numbers = np.empty(stack.pictures.shape, np.uint8 if sensor.bits == 8 else np.uint16)

    def expose_image(k: int) -> None:
        generator = np.random.Generator(np.random.PCG64(np.random.SeedSequence(streams[k].tolist())))
        numbers[k] = _read_out(stack.pictures[k] / full[k], sensor, generator)

    run_blocks(lambda image, _: expose_image(image), n, 1, workers)
    return stack.restored(numbers)


def _read_out(share: Reals, sensor: Sensor, generator: np.random.Generator) -> Reals:
    """Whole numbers that a picture of light, as a share of saturation, is read as."""
    electrons = share * sensor.full_well + sensor.dark_signal
    if sensor.photon_noise:
        # Far beyond saturation the number does not matter, and Poisson numbers have a largest mean.
        electrons = generator.poisson(np.minimum(electrons, 4.0 * sensor.full_well + 1000.0)).astype(np.float64)
    if sensor.read_noise > 0.0:
        electrons += sensor.read_noise * generator.standard_normal(electrons.shape)
    level = (electrons - sensor.dark_signal) / sensor.full_well
    if sensor.response == "srgb":
        level = srgb_encoded(np.clip(level, 0.0, 1.0))
    else:
        level = sensor.black_level + (1.0 - sensor.black_level) * level
    return np.rint(np.clip(level, 0.0, 1.0) * sensor.largest_number)


def srgb_encoded(linear: ArrayLike) -> Reals:
    """Values (...) in 0…1 for a screen, of linear light (...) in 0…1.

    Raises
    ------
    InputError
        If a value is out of 0 to 1.

    Notes
    -----
    IEC 61966-2-1:1999: 12.92 x up to 0.0031308, above it 1.055 x^(1/2.4) - 0.055.
    """
    light = as_numbers("linear", linear).astype(np.float64)
    check_range("linear", light, 0.0, 1.0, "", "relative to what saturates?")
    return np.asarray(np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055))


@dataclass(frozen=True, kw_only=True)
class Meter:
    """How a camera chooses its exposure.

    Parameters
    ----------
    rule : "mean" brings the mean of the picture to the level, "percentile" that percentile of its pixels
    level : share of saturation
    percentile : [%] used by the rule of that name only
    """

    rule: str = "mean"
    level: float = 0.18  # the grey of photographers; ISO 12232 leaves half a stop more, 0.18 / √2 = 0.127
    percentile: float = 99.0  # [%] assumed

    def __post_init__(self) -> None:
        check_choice("rule", self.rule, METER_RULES)
        check_range("level", self.level, 1e-3, 1.0, "of saturation")
        check_range("percentile", self.percentile, 0.0, 100.0, "%")


MID_GREY = Meter()
HIGHLIGHTS = Meter(rule="percentile", level=1.0)  # one pixel in a hundred saturates


def auto_exposure(
    radiance: ArrayLike, meter: Meter = MID_GREY, *, per_image: bool = True, mask: ArrayLike | None = None
) -> Reals:
    """Radiance that saturates, as a camera's meter chooses it: (...) array, or () if one for all pictures.

    Parameters
    ----------
    radiance : (..., rows, columns) array, of one band
    meter : Meter
    per_image : bool
        Whether each picture has an exposure of its own; else all pixels of all pictures count together.
    mask : array of bool that goes with the radiance, as `Camera.pixels_seen` gives it
        Where pixels count; None if all do.

    Raises
    ------
    InputError
        If a picture has no pixel that counts, or is dark where the meter looks.

    Notes
    -----
    The mean is that of the numbers that the camera itself reads, in which a brighter pixel counts as saturated: the
    disc of the sun does not darken the rest. It is found exactly: of the sorted pixels the darkest i sum up to S, and
    (S + (n - i) s) / n = level · s.
    """
    stack = radiance_stack(radiance, has_bands=False)
    counts = _check_mask(mask, stack.shape).reshape(len(stack.pictures), -1)
    flat = stack.pictures.reshape(len(stack.pictures), -1)
    if not per_image:
        return np.asarray(_metered(flat[counts], meter))
    chosen = [_metered(values[count], meter) for values, count in zip(flat, counts, strict=True)]
    return np.array(chosen, dtype=np.float64).reshape(stack.batch)


def _metered(values: Reals, meter: Meter) -> float:
    if values.size == 0:
        raise InputError("mask leaves no pixel of a picture, expected some to meter: are its True and False exchanged?")
    values = values.astype(np.float64)
    if meter.rule == "percentile":
        found = float(np.percentile(values, meter.percentile)) / meter.level
    else:
        found = _mean_exposure(values, meter.level)
    if not found > 0.0:
        raise InputError(f"a picture is dark where the {meter.rule} is metered, expected some light: another band?")
    return found


def _mean_exposure(values: Reals, level: float) -> float:
    """Radiance s of saturation with which the mean of min(value, s) is level · s; 0 if so few pixels are bright."""
    ordered = np.sort(values)
    n = len(ordered)
    below = np.concatenate([[0.0], np.cumsum(ordered)])  # sum of the darkest i
    # With i pixels below saturation the mean is linear in s; the right i is that whose s lies between its neighbours.
    # The mean over s falls as s grows, so the first i is taken with which the i + 1 th pixel is no longer below s.
    scale = level * n - (n - np.arange(n + 1.0))
    solution = np.divide(below, scale, out=np.zeros(n + 1), where=scale > 0.0)
    following = np.append(ordered, np.inf)
    return float(solution[np.argmax((scale > 0.0) & (solution <= following))])


def white_balance(radiance: ArrayLike, white: ArrayLike) -> Reals:
    """Pictures relative to a white sheet: 1 in all three bands where it is as bright as the sheet.

    Exposed with a saturation of 1 or more, they are the pictures of a camera whose three kinds of pixels fill alike
    before the sheet.

    Parameters
    ----------
    radiance : (..., 3) array of red, green and blue
    white : (..., 3) array, radiance of the sheet: on level ground ``sky.irradiance(("red", "green", "blue")) / π``

    Raises
    ------
    InputError
        If the last axes are not three bands, or the sheet is dark.
    """
    array, sheet = as_numbers("radiance", radiance), as_numbers("white", white)
    check_shape("radiance", array, (..., 3))
    check_shape("white", sheet, (..., 3))
    _check_positive("white", sheet)
    return np.asarray(array / sheet)


def _check_positive(name: str, values: ArrayLike) -> None:
    check_finite(name, values)
    check_range(name, values, float(np.finfo(np.float32).tiny), np.inf)


def _check_mask(mask: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    if mask is None:
        return np.ones(shape, dtype=bool)
    array = np.asarray(mask)
    if array.dtype != bool:
        raise InputError(f"mask holds {array.dtype.name} values, expected True where a pixel counts")
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise InputError(f"mask has shape {array.shape}, expected one that goes with {shape}") from None
