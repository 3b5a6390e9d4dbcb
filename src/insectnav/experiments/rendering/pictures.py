"""From the layers of a view to the pictures of a frame: exposure, noise, encoding, labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, check_choice, check_count, check_range, quoted
from insectnav.datasets.picture_files import check_format, quantised
from insectnav.vision.sensor import HIGHLIGHTS, RESPONSES, Meter, Sensor, auto_exposure, expose, ideal_sensor
from insectnav.worlds.materials import MATERIALS
from insectnav.worlds.sky import Sky

Values = npt.NDArray[Any]
Layers = Mapping[str, Values]

PICTURES: Mapping[str, tuple[str, ...]] = {  # name → layers of the renderer; the three of colour are red, green, blue
    "uv": ("uv",),
    "blue": ("blue",),
    "green": ("green",),
    "red": ("red",),
    "visible": ("red", "green", "blue"),
    "grey": ("grey",),
    "sky_mask": ("sky",),
    "sky_share": ("sky",),
    "material": ("triangle",),
    "depth": ("depth",),
}
LABELS = ("sky_mask", "sky_share", "material", "depth")  # the same in any light
USUAL = {"sky": ("uv", "green", "visible", "sky_mask"), "flat": ("grey", "sky_mask")}
METERS = {"mean": Meter(rule="mean", level=0.25), "highlights": HIGHLIGHTS}  # assumed: half a stop above mid-grey
# Labels of the picture "material"; those between are places in the table of materials, counted from 1.
SKY_LABEL, GROUND_LABEL, OTHER_LABEL, UNSEEN_LABEL = 0, 253, 254, 255
BALANCES = ("scene", "daylight")
_DAYLIGHT = Sky(sun_azimuth=0.0, sun_elevation=float(np.deg2rad(40.0)))  # clear, turbidity 3


@dataclass(frozen=True, kw_only=True)
class PictureParams:
    """Which pictures of a frame are written, and how.

    Parameters
    ----------
    pictures : names in `PICTURES`, or none for the usual ones of the light
    format : "png" or "tiff"
    bits : 8 or 16, or 32 for the radiance itself [W m⁻² nm⁻¹ sr⁻¹], of which no camera makes a number
    response : "linear", "srgb" or None
        Of the numbers to light; None is "srgb" for 8 bits, as for a screen, and "linear" for more.
    exposure : "traverse", "frame" or a number
        One automatic exposure for all frames, one for each, or the radiance of green light that is white.
    meter : "mean" or "highlights"
        Of automatic exposures: that of the mean brings the mean of the pixels to 0.25 of white, that of the highlights
        99 % of the pixels below white.
    balance : "scene" or "daylight"
        What colours are relative to: a white sheet on level ground at the first moment, or one under a clear sky with
        the sun at 40°.
    noise : bool
        Whether the sensor adds the noise of photons and electronics.
    noise_seed : int
    flare : bool
        Whether the lens spreads light, as `insectnav.vision.lens_flare.LensFlare` has it.

    Raises
    ------
    InputError
        If a name is unknown, or the format cannot hold so many bits.
    """

    pictures: tuple[str, ...] = ()
    format: str = "png"
    bits: int = 8
    response: str | None = None
    exposure: str | float = "traverse"
    meter: str = "mean"
    balance: str = "scene"
    noise: bool = False
    noise_seed: int = 0
    flare: bool = False

    def __post_init__(self) -> None:
        for name in self.pictures:
            check_choice("picture", name, tuple(PICTURES))
        check_format(self.format, self.bits)
        if self.response is not None:
            check_choice("response", self.response, RESPONSES)
        if self.bits == 32 and (self.response is not None or self.noise or self.exposure != "traverse"):
            raise InputError(
                "32 bits hold the radiance itself, expected no --response, --exposure or --noise with them"
            )
        if isinstance(self.exposure, str):
            if self.exposure not in ("traverse", "frame"):
                raise InputError(f"exposure is {quoted(self.exposure)}, expected traverse, frame or a number")
        else:
            check_range("exposure", self.exposure, 1e-9, 1e9, "W/(m² nm sr)")
        check_choice("meter", self.meter, tuple(METERS))
        check_choice("white balance", self.balance, BALANCES)
        check_count("noise seed", self.noise_seed, minimum=0)

    @property
    def sensor(self) -> Sensor:
        """The sensor, of which the exposure is given picture by picture."""
        response = self.response or ("srgb" if self.bits == 8 else "linear")
        if not self.noise:
            return ideal_sensor(1.0, bits=self.bits, response=response)
        return Sensor(saturation_radiance=1.0, bits=self.bits, response=response)

    def chosen(self, light: str) -> tuple[str, ...]:
        """Names of the pictures in that kind of light, "sky" or "flat".

        Raises
        ------
        InputError
            If there is no such picture in that light.
        """
        names = tuple(dict.fromkeys(self.pictures)) or USUAL[light]
        possible = [name for name in PICTURES if name in LABELS or (name == "grey") == (light == "flat")]
        for name in names:
            if name not in possible:
                raise InputError(
                    f"there is no picture {name} in the light {light}, expected some of {', '.join(possible)}"
                )
        if light == "flat" and (self.noise or self.flare):
            raise InputError("flat light has no noise and no flare, expected --light sky")
        return names

    def suffix(self, name: str) -> str:
        """Ending of the file of a picture."""
        if name == "depth":
            return ".tiff"
        return ".png" if name in ("sky_mask", "material") else f".{self.format}"


def layers_of(names: Sequence[str]) -> tuple[str, ...]:
    """Layers that the renderer must give for these pictures, and the sky."""
    return tuple(dict.fromkeys([layer for name in names for layer in PICTURES[name]] + ["sky"]))


def white_sheet(name: str, sky: Sky, balance: str) -> Values:
    """Radiance (band,) of a white sheet over that in green, in the bands of a picture.

    Parameters
    ----------
    name : of the picture
    sky : Sky
        At the first moment.
    balance : name in `BALANCES`
    """
    light = (sky if balance == "scene" else _DAYLIGHT).irradiance((*PICTURES[name], "green")).astype(np.float64)
    return np.asarray(light[:-1] / light[-1])


def radiance_of(layers: Layers, name: str) -> Values:
    """Radiance (..., row, column, band) of a picture."""
    return np.stack([layers[band] for band in PICTURES[name]], axis=-1)


def metered(radiance: Values, sheet: Values, seen: npt.NDArray[np.bool_], meter: str) -> float:
    """Radiance of green light that is white, as the camera's meter chooses it for frames (n, row, column, band).

    A picture of several bands is metered by their mean, each over that of a white sheet.

    Parameters
    ----------
    radiance : of `radiance_of`
    sheet : of `white_sheet`
    seen : (row, column) array of bool
    meter : name in `METERS`
    """
    brightness = (radiance / sheet.astype(np.float32)).mean(axis=-1)
    chosen: Meter = METERS[meter]
    return float(f"{float(auto_exposure(brightness, chosen, per_image=False, mask=seen)):.6g}")


def light_picture(radiance: Values, name: str, white: Values | None, index: int, params: PictureParams) -> Values:
    """A picture of light as it is written, (row, column) or (row, column, 3).

    Parameters
    ----------
    radiance : (row, column, band) array
    name : of the picture
    white : (band,) array, radiance that is white; None for the radiance itself
    index : number of the frame
    params : PictureParams
    """
    values: Values = np.asarray(radiance, np.float32)
    if white is not None:
        values = expose(
            radiance,
            params.sensor,
            seed=params.noise_seed,
            channel=name,
            saturation_radiance=white,
            has_bands=True,
            first_image=index,
            workers=1,
        )
    return values[..., 0] if values.shape[-1] == 1 else values


def label_picture(layers: Layers, name: str, seen: npt.NDArray[np.bool_], labels: Values, bits: int) -> Values:
    """A picture of labels, or of flat light, as it is written, (row, column).

    Parameters
    ----------
    layers : of one frame, (row, column) each
    name : of the picture
    seen : (row, column) array of bool
    labels : of `triangle_labels`
    bits : of "sky_share" and "grey"
    """
    if name == "sky_mask":
        return np.where(layers["sky"] >= 0.5, np.uint8(255), np.uint8(0))
    if name == "depth":
        return np.asarray(layers["depth"], np.float32)
    if name == "material":
        return np.where(seen, labels[layers["triangle"]], np.uint8(UNSEEN_LABEL))
    values = layers[PICTURES[name][0]]
    return np.asarray(values, np.float32) if bits == 32 else quantised(values, bits)


def triangle_labels(materials: Sequence[str], of_triangle: Any) -> npt.NDArray[np.uint8]:
    """Label of the material of each triangle, and at the indices −2 and −1 those of ground and sky, (n + 2,).

    Parameters
    ----------
    materials : names, as of a mesh
    of_triangle : (n,) array, which of them a triangle is of
    """
    numbers = material_labels()
    own = np.array([numbers.get(name, OTHER_LABEL) for name in materials], np.uint8)
    return np.concatenate([own[of_triangle], np.array([GROUND_LABEL, SKY_LABEL], np.uint8)])


def material_labels() -> dict[str, int]:
    """Numbers in the picture "material" by name."""
    numbers = {name: number for number, name in enumerate(MATERIALS, 1)}
    return {"sky": SKY_LABEL, **numbers, "bare ground": GROUND_LABEL, "other": OTHER_LABEL, "not seen": UNSEEN_LABEL}
