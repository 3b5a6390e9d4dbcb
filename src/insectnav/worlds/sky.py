"""The sky over a world: radiance and polarisation in every direction, for a place of the sun and a weather.

Clouds are white: they send down what they let through of the light that sun and clear sky together shed, which is the
same share in all bands. The clear sky is blue and bluer still in the ultraviolet, where it gives most of the light
itself. So overhead clouds are about five times as bright as the sky beside them in green, and less than
twice in ultraviolet.

Assumptions: each piece of cloud is as bright as an overcast sky of its optical depth there, whichever side the sun is
on; the gaps between clouds are as bright as the clear sky; far clouds fade into the mean of their field, as much as the
air beneath the layer takes of their light.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, as_numbers, check_finite, check_radians, check_range, check_shape
from insectnav.worlds.clouds import CloudField, check_clouds, opacity, transmittance, weather_clouds
from insectnav.worlds.polarisation import e_vector_angle, maximal_degree, rayleigh_degree
from insectnav.worlds.skylight import (
    BANDS,
    LOWEST_SUN,
    Atmosphere,
    ClearIrradiance,
    air_mass,
    atmosphere,
    check_clear_sky,
    chosen_bands,
    clear_irradiance,
    clear_radiance,
    sky_quadrature,
)
from insectnav.worlds.sun import SUN_DIAMETER, Time, sun_direction, sun_position, utc

Reals = npt.NDArray[np.floating[Any]]
Floats = npt.NDArray[np.float32]

ALL_BANDS = tuple(BANDS)
AIR_SCALE, HAZE_SCALE = 8803.0, 1200.0  # [m] Preetham et al. 1999, Appendix 4: 0.1136 and 0.8333 per km
HORIZON = -1e-9  # sine of the elevation below which there is no sky; not 0, for level directions are rounded
EPOCH = np.datetime64("2000-01-01")  # where `sky_at` starts to count the drift of its clouds


class Polarisation(NamedTuple):
    """Polarisation of skylight; arrays (...)."""

    degree: Floats  # 0 to 1
    angle: Floats  # [rad] of the e-vector from the vertical, in [−π/2, π/2), clockwise for the eye


@dataclass(frozen=True, kw_only=True)
class Sky:
    """Sky with a sun, at one moment.

    Parameters
    ----------
    sun_azimuth, sun_elevation : float [rad]
        Clockwise from north (+y), and up from the horizon: at least 2°.
    turbidity : float
        Haze: 2 is very clear, 3 clear, 6 hazy.
    clouds : CloudField or None
        None is a cloudless sky.
    time : float [s]
        For how long the clouds have drifted.
    sun_diameter : float [rad]
        Of the disc. A larger disc has the same irradiance: for eyes and pictures that would miss the true one.

    Raises
    ------
    InputError
        If a value is out of the model's range.
    """

    sun_azimuth: float
    sun_elevation: float
    turbidity: float = 3.0
    clouds: CloudField | None = None
    time: float = 0.0
    sun_diameter: float = SUN_DIAMETER

    def __post_init__(self) -> None:
        for name in ("sun_azimuth", "sun_elevation", "turbidity", "time", "sun_diameter"):
            value = as_numbers(name, getattr(self, name))
            check_shape(name, value, ())
            object.__setattr__(self, name, float(value))
        check_finite("sun_azimuth", self.sun_azimuth)
        check_radians("sun_azimuth", self.sun_azimuth)
        check_clear_sky(self.sun_elevation, self.turbidity)
        check_clouds(self.clouds)
        check_range("time", self.time, -1e10, 1e10, "s", "milliseconds?")
        check_range("sun_diameter", self.sun_diameter, 1e-4, 0.5, "rad", "degrees?")

    @property
    def sun(self) -> Reals:
        """Unit vector (3,) to the sun."""
        return sun_direction(self.sun_azimuth, self.sun_elevation)

    def radiance(self, directions: npt.ArrayLike, bands: Sequence[str] = ALL_BANDS, *, sun_disc: bool = True) -> Floats:
        """Radiance (..., band) [W m⁻² nm⁻¹ sr⁻¹] of the sky in the given directions; 0 below the horizon.

        A white sheet on level ground has the radiance `irradiance(bands)` / π.

        Parameters
        ----------
        directions : (..., 3) array of unit vectors: +x east, +y north, +z up
        bands : names in `skylight.BANDS`
        sun_disc : bool
            Whether the sun itself is in the sky; its aureole is anyhow.

        Raises
        ------
        InputError
            If the directions are no unit vectors, or a band is unknown.
        """
        directions = _unit_vectors(directions)
        clear, cloud = self._clear_and_cloud(directions, bands)
        total = clear + cloud
        if sun_disc:
            within = np.linalg.norm(directions - self.sun, axis=-1) <= 2.0 * np.sin(self.sun_diameter / 4.0)
            disc = np.where(within, self._straight_through(directions), 0.0)[..., None]
            total = total + disc * self._clear_light(bands).direct_normal / self._disc_angle()
        return np.where(directions[..., 2:] >= HORIZON, total, 0.0).astype(np.float32)

    def polarisation(self, directions: npt.ArrayLike, band: str = "uv") -> Polarisation:
        """Degree and angle of the polarisation of skylight, without the sun's disc; degree 0 below the horizon.

        Light from clouds is not polarised and dilutes that of the clear sky.

        Parameters
        ----------
        directions : (..., 3) array of unit vectors
        band : name in `skylight.BANDS`

        Raises
        ------
        InputError
            If the directions are no unit vectors, or the band is unknown.
        """
        directions = _unit_vectors(directions)
        clear, cloud = (part[..., 0] for part in self._clear_and_cloud(directions, [band]))
        degree = maximal_degree(self.turbidity) * rayleigh_degree(directions, self.sun) * clear / (clear + cloud)
        degree = np.where(directions[..., 2] >= HORIZON, degree, 0.0)
        return Polarisation(degree.astype(np.float32), e_vector_angle(directions, self.sun).astype(np.float32))

    def irradiance(self, bands: Sequence[str] = ALL_BANDS) -> Floats:
        """Irradiance (band,) of level ground by sky and sun [W m⁻² nm⁻¹]; under clouds within a few per cent.

        Raises
        ------
        InputError
            If a band is unknown.
        """
        directions, weights = sky_quadrature()
        clear, cloud = self._clear_and_cloud(directions, bands)
        return (weights @ (clear + cloud) + self.sun_irradiance(bands) * np.sin(self.sun_elevation)).astype(np.float32)

    def sun_irradiance(self, bands: Sequence[str] = ALL_BANDS) -> Floats:
        """Irradiance (band,) of a plane that faces the sun, by the sun alone, through the cloud before it.

        Raises
        ------
        InputError
            If a band is unknown.
        """
        return (self._clear_light(bands).direct_normal * self._straight_through(self.sun)).astype(np.float32)

    def _clear_light(self, bands: Sequence[str]) -> ClearIrradiance:
        return clear_irradiance(self.sun_elevation, atmosphere(self.turbidity), bands)

    def _disc_angle(self) -> float:
        return float(2 * np.pi * (1.0 - np.cos(self.sun_diameter / 2.0)))

    def _straight_through(self, directions: Reals) -> Reals:
        """Share (...) of the light from beyond the clouds that comes straight through them."""
        if self.clouds is None:
            return np.ones(directions.shape[:-1])
        return 1.0 - opacity(self.clouds.look(directions, self.time))

    def _clear_and_cloud(self, directions: Reals, bands: Sequence[str]) -> tuple[Reals, Reals]:
        """Radiance (..., band) of the clear sky as far as clouds let it through, and of the clouds."""
        clear = clear_radiance(directions, self.sun, self.turbidity, bands)
        if self.clouds is None:
            return clear, np.zeros_like(clear)
        path = self.clouds.look(directions, self.time)
        sine = np.clip(directions[..., 2], 0.0, 1.0)
        here = opacity(path)
        mean, mean_transmitted = _mean_clouds(self.clouds, path.slant)
        seen = _seen_through_air(sine, self.clouds.base_height, atmosphere(self.turbidity), bands)
        opaque = _mixed(seen, here, mean)
        transmitted = _mixed(seen, here * transmittance(path.optical_depth), mean_transmitted)
        white = self._clear_light(bands).horizontal / np.pi
        return clear * (1.0 - opaque), white * transmitted * overcast_pattern(sine)[..., None]


def overcast_pattern(sine: npt.ArrayLike) -> Reals:
    """Radiance (...) of the overcast sky over the mean that gives level ground the same irradiance.

    Parameters
    ----------
    sine : (...) array
        Sine of the elevation.

    Notes
    -----
    The CIE standard overcast sky, (1 + 2 sin θ) / 3 of the zenith: Moon and Spencer 1942 (Illuminating Engineering
    37:707), ISO 15469. Its irradiance is 7π/9 times the radiance of the zenith.
    """
    return np.asarray(3.0 / 7.0 * (1.0 + 2.0 * np.asarray(sine)))


def sky_at(
    time: Time,
    latitude_deg: float,
    longitude_deg: float,
    weather: str = "clear",
    *,
    turbidity: float = 3.0,
    seed: int = 0,
    wind: Sequence[float] = (8.0, 3.0),
) -> Sky:
    """Sky over a place on Earth at a time.

    Parameters
    ----------
    time : aware datetime, or datetime64 in UTC
    latitude_deg, longitude_deg : float [°], north and east positive
    weather : "clear", "scattered", "broken" or "overcast"
    turbidity : float
    seed : int
        Decides where the clouds are; with the same seed they drift from one time to the next.
    wind : (2,) sequence [m/s], to the east and to the north

    Raises
    ------
    InputError
        If an input is out of range, or the sun is below 2°.
    """
    moment = utc(time)
    check_shape("time", moment, ())
    azimuth, elevation = sun_position(time, latitude_deg, longitude_deg)
    if elevation < LOWEST_SUN:
        raise InputError(
            f"the sun stands at {np.rad2deg(elevation):.1f}° on {moment.astype('datetime64[s]')} UTC at latitude "
            f"{latitude_deg:g}, longitude {longitude_deg:g}, expected at least 2° (twilight and night are not "
            "modelled): local time given as UTC?"
        )
    seconds = float((moment - EPOCH) / np.timedelta64(1, "s"))
    clouds = weather_clouds(weather, seed, wind)
    return Sky(
        sun_azimuth=float(azimuth), sun_elevation=float(elevation), turbidity=turbidity, clouds=clouds, time=seconds
    )


def _seen_through_air(sine: Reals, height: float, air: Atmosphere, bands: Sequence[str]) -> Reals:
    """Share (..., band) of the light of clouds at that height [m] that the air beneath them lets pass."""
    below = [
        -air.rayleigh_depth(band) * np.expm1(-height / AIR_SCALE)
        - air.haze_depth(band) * np.expm1(-height / HAZE_SCALE)
        for band in chosen_bands(bands)
    ]
    return np.asarray(np.exp(-air_mass(np.arcsin(sine))[..., None] * np.array(below)))


def _mixed(seen: Reals, here: Reals, mean: Reals) -> Reals:
    """What is seen of the clouds here, the rest being the mean of the field; (..., band)."""
    return seen * here[..., None] + (1.0 - seen) * mean[..., None]


def _mean_clouds(clouds: CloudField, slant: Reals) -> tuple[Reals, Reals]:
    """Mean over the field of the opacity (...) along that slant, and of the opacity times the transmittance."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    depth = clouds.depth_at_rank((nodes + 1.0) / 2.0)
    opaque = -np.expm1(-slant[..., None] * depth)
    share = clouds.cover / 2.0 * weights
    return opaque @ share, (opaque * transmittance(depth)) @ share


def _unit_vectors(directions: npt.ArrayLike) -> Reals:
    array = as_numbers("directions", directions).astype(float)
    check_shape("directions", array, (..., 3))
    length = np.linalg.norm(array, axis=-1)
    check_range("length of directions", length, 0.999, 1.001, "", "expected unit vectors")
    return array / length[..., None]
