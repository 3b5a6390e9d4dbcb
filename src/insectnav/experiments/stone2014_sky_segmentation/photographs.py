"""Photographs of a lit world by a full-spectrum camera: visible, ultraviolet and green, with the exact mask of the sky.

The camera is like that of the paper: 604 × 403 pixels, each the mean of 10 × 10 of a 14-bit sensor of 35.9 × 24 mm,
behind a lens of 35 mm. Filters are taken to pass one wavelength each, those of the bands of `insectnav.worlds.sky`; the
visible picture has red, green and blue of one exposure, balanced for daylight; each picture is metered for itself.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import Floats
from insectnav.vision.cameras import Camera
from insectnav.vision.lens_flare import LensFlare, add_lens_flare
from insectnav.vision.sensor import MID_GREY, Meter, Sensor, auto_exposure, expose, srgb_encoded, white_balance
from insectnav.vision.sphere import great_circle_angle, rotation_matrix, to_eye, to_world
from insectnav.worlds.lit_world import LitWorld
from insectnav.worlds.sky import Sky
from insectnav.worlds.views import render

ROWS, COLUMNS = 403, 604
FOCAL_LENGTH = COLUMNS * 35.0 / 35.9  # [px] lens over the width of the sensor
VISIBLE = ("red", "green", "blue")
# Raw pixels of one colour in 10 × 10 of a mosaic: 25. Their mean has 25 times the electrons; the well of one is that
# of `Sensor`, about what a full-frame camera has left at ISO 200 (assumed).
N_RAW = 25
WELL, READ_NOISE = Sensor(saturation_radiance=1.0).full_well, Sensor(saturation_radiance=1.0).read_noise
DAYLIGHT = Sky(sun_azimuth=0.0, sun_elevation=float(np.deg2rad(45.0)))  # that whites are balanced for
CLEAN_LENS = LensFlare()
NEAR_SUN = float(np.deg2rad(1.0))  # [rad] within which the disc is drawn as the renderer draws it


@dataclass(frozen=True, kw_only=True)
class FullSpectrum:
    """How the pictures are taken.

    Parameters
    ----------
    reduction : whole number by which 604 × 403 pixels are reduced, rounded down
    supersampling : rays along each side of a pixel
    meter : of every exposure
    exposure : factor on what the meter says; 2 is a stop more light
    n_raw : raw pixels averaged in each pixel; 0 is no noise at all
    flare : of the lens
    is_encoded : whether numbers are encoded for a screen (sRGB) and not linear, as raw ones are
    balances_each : whether whites are balanced for the light of the scene, and not for daylight
    """

    reduction: int = 1
    supersampling: int = 4
    meter: Meter = MID_GREY
    exposure: float = 1.0
    n_raw: int = N_RAW
    flare: LensFlare = CLEAN_LENS
    is_encoded: bool = False
    balances_each: bool = False

    @property
    def camera(self) -> Camera:
        """A pinhole camera that looks ahead."""
        rows, columns = ROWS // self.reduction, COLUMNS // self.reduction
        focal = FOCAL_LENGTH / self.reduction
        return Camera(
            model="pinhole",
            size=(rows, columns),
            focal_length=(focal, focal),
            centre=(columns / 2, rows / 2),
            field=(0.0, 1.3),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Photograph:
    """Three pictures of one scene, (rows, columns) uint16, and where the sky is."""

    visible: NDArray[np.uint16]  # (rows, columns, 3) red, green, blue
    uv: NDArray[np.uint16]
    green: NDArray[np.uint16]
    sky: NDArray[np.bool_]  # (rows, columns) half of the pixel or more

    @property
    def uv_green(self) -> NDArray[np.uint16]:
        """Ultraviolet and green as two bands, (rows, columns, 2)."""
        return np.stack([self.uv, self.green], axis=-1)


def view(world: LitWorld, eye_height: float, pitch: float, how: FullSpectrum) -> dict[str, Any]:
    """Radiance of each band as it comes to the lens, (rows, columns), and "sky", the share of sky in each pixel.

    The camera is at the origin of x and y, `eye_height` [m] above level ground, looks along +y and is tilted up by
    `pitch` [rad]. Where a pixel is all sky it has the radiance of the sky in its middle; the table from which the
    renderer reads the sky is coarser than these pixels.
    """
    bands = world.bands
    place = [[0.0, 0.0, eye_height]]
    found = render(
        world, place, 0.0, pitch, camera=how.camera, layers=(*bands, "sky"), supersampling=how.supersampling, workers=1
    )
    layers = {name: values[0].astype(np.float64) for name, values in found.items()}
    looks = to_world(how.camera.pixel_directions(), rotation_matrix(0.0, pitch, 0.0))
    clear = (layers["sky"] == 1.0) & (great_circle_angle(looks, world.sky.sun) > NEAR_SUN)
    exact = world.sky.radiance(looks[clear], bands, sun_disc=False)
    for k, band in enumerate(bands):
        layers[band][clear] = exact[:, k]
    return layers


def seen_share_of_sun(world: LitWorld, eye_height: float) -> float:
    """1 where the sun shines on the lens, 0 where something stands before it; clouds are not counted."""
    towards = np.asarray(world.sky.sun, dtype=np.float64)
    found = render(world, [[0.0, 0.0, eye_height]], directions=towards[None], layers=("sky",), workers=1)
    return float(found["sky"][0, 0])


def photograph(
    layers: dict[str, Any], sky: Sky, pitch: float, sun_share: float, how: FullSpectrum, seed: int
) -> Photograph:
    """What the camera makes of a view: flare, exposure, noise and numbers.

    Parameters
    ----------
    layers : as of `view`
    sky : Sky
    pitch : of the camera [rad]
    sun_share : as of `seen_share_of_sun`
    how : FullSpectrum
    seed : of the noise
    """
    light = {band: _at_sensor(layers[band], band, sky, pitch, sun_share, how) for band in ("uv", *VISIBLE)}
    white = (sky if how.balances_each else DAYLIGHT).irradiance(VISIBLE) / np.pi
    visible = white_balance(np.stack([light[band] for band in VISIBLE], axis=-1), white)
    return Photograph(
        visible=_taken(visible, auto_exposure(visible.mean(axis=-1), how.meter), how, seed, "visible"),
        uv=_taken(light["uv"], auto_exposure(light["uv"], how.meter), how, seed, "uv"),
        green=_taken(light["green"], auto_exposure(light["green"], how.meter), how, seed, "green"),
        sky=layers["sky"] >= 0.5,
    )


def _at_sensor(radiance: Floats, band: str, sky: Sky, pitch: float, sun_share: float, how: FullSpectrum) -> Any:
    sun = to_eye(np.asarray(sky.sun, dtype=np.float64), rotation_matrix(0.0, pitch, 0.0))
    irradiance = float(sky.sun_irradiance((band,))[0])
    return add_lens_flare(radiance, how.camera, sun, irradiance, how.flare, visible_share=sun_share)


def _taken(light: Any, saturation: Any, how: FullSpectrum, seed: int, channel: str) -> NDArray[np.uint16]:
    """Whole numbers of 16 bits, the black level taken off, as of a TIFF from a raw file of 14 bits."""
    n = max(how.n_raw, 1)
    sensor = Sensor(
        saturation_radiance=1.0,
        full_well=WELL * n,
        read_noise=READ_NOISE * np.sqrt(n) if how.n_raw else 0.0,
        black_level=0.0,
        bits=16,
        photon_noise=how.n_raw > 0,
    )
    numbers = expose(light / (saturation / how.exposure), sensor, seed=seed, channel=channel, has_bands=light.ndim == 3)
    if how.is_encoded:
        numbers = np.rint(srgb_encoded(numbers / sensor.largest_number) * sensor.largest_number)
    return numbers.astype(np.uint16)


def take(world: LitWorld, eye_height: float, pitch: float, how: FullSpectrum, seed: int) -> Photograph:
    """View and photograph in one: what `photograph` makes of what `view` sees."""
    layers, sun_share = view(world, eye_height, pitch, how), seen_share_of_sun(world, eye_height)
    return photograph(layers, world.sky, pitch, sun_share, how, seed)


def shown(picture: NDArray[np.uint16], n_columns: int) -> NDArray[np.uint8]:
    """A picture for the eye, (rows, n_columns or a little less, …): reduced by a whole number, encoded for a screen."""
    step = max(1, round(picture.shape[1] / n_columns))
    rows, columns = (length // step for length in picture.shape[:2])
    blocks = picture[: rows * step, : columns * step].astype(np.float64)
    mean = blocks.reshape(rows, step, columns, step, *picture.shape[2:]).mean(axis=(1, 3))
    return np.rint(255.0 * srgb_encoded(mean / np.iinfo(np.uint16).max)).astype(np.uint8)
