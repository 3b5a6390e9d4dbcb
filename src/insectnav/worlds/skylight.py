"""Light of the cloudless sky and of the sun, in four bands.

How much light comes from the sun and from the whole sky follows Bird and Riordan 1986 in each band. How the sky's share
is spread over it follows Perez et al. 1993 with the coefficients of Preetham et al. 1999, which hold for visible light;
the other bands differ from green as their scattering does (`scattered_radiance`). Radiance is in W m⁻² nm⁻¹ sr⁻¹.

Assumptions, beyond those of the sources: sea level, 0.35 cm of ozone, a dark ground, the mean distance of the sun;
light that was scattered more than once comes from all over the sky alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.checks import check_choice, check_range

Reals = npt.NDArray[np.floating[Any]]


class Band(NamedTuple):
    """Light about one wavelength."""

    wavelength_nm: float
    extraterrestrial: float  # [W m⁻² nm⁻¹] at the mean distance of the sun
    ozone: float  # [cm⁻¹] absorption


# Bird and Riordan 1984 (doi 10.2172/5986936), Table 1; red is the middle between its rows for 610 and 630 nm.
BANDS = {
    "uv": Band(350.0, 0.9755, 0.007),
    "blue": Band(450.0, 2.005, 0.003),
    "green": Band(520.0, 1.831, 0.048),
    "red": Band(620.0, 1.693, 0.105),
}
LOWEST_SUN = float(np.deg2rad(2.0))  # [rad]
LOWEST_TURBIDITY, HIGHEST_TURBIDITY = 2.0, 8.0  # below and above, Preetham's sky goes wrong (Zotti et al. 2007)
ASYMMETRY = 0.65  # mean cosine of scattering by haze: Bird and Riordan 1986, rural aerosol
RINGS, SECTORS = 24, 72  # of the quadrature over the sky


@dataclass(frozen=True, kw_only=True)
class Atmosphere:
    """What the air holds."""

    haze_500nm: float  # optical depth of the haze (aerosol) at 500 nm
    angstrom_exponent: float = 1.3  # Preetham et al. 1999, Appendix 1
    ozone_cm: float = 0.35  # [cm] Preetham et al. 1999, Appendix 1
    ground_albedo: float = 0.0  # dark, as vegetation and soil are in the ultraviolet

    def rayleigh_depth(self, band: Band) -> float:
        """Optical depth of the air itself: Bird and Riordan 1986, Eq. 4 (1.335 as in their report)."""
        square = (band.wavelength_nm / 1000.0) ** 2
        return 1.0 / (square**2 * (115.6406 - 1.335 / square))

    def haze_depth(self, band: Band) -> float:
        """Optical depth of the haze: Ångström's law."""
        return float(self.haze_500nm * (band.wavelength_nm / 500.0) ** -self.angstrom_exponent)

    def haze_albedo(self, band: Band) -> float:
        """Share of the light lost to haze that is scattered, not absorbed: Bird and Riordan 1986, Eq. 15 (rural)."""
        return float(0.945 * np.exp(-0.095 * np.log(band.wavelength_nm / 400.0) ** 2))


class ClearIrradiance(NamedTuple):
    """Light of the cloudless sky on the ground; arrays (band,) [W m⁻² nm⁻¹]."""

    direct_normal: Reals  # from the sun, on a plane that faces it
    diffuse: Reals  # from the sky without the sun, on level ground
    horizontal: Reals  # from both, on level ground


def atmosphere(turbidity: float) -> Atmosphere:
    """Atmosphere of a turbidity: 2 is very clear, 3 clear, 6 hazy.

    Notes
    -----
    Ångström's β = 0.04608 T − 0.04586 at 1 µm: Preetham et al. 1999, Appendix 1, doi 10.1145/311535.311545.
    """
    return Atmosphere(haze_500nm=(0.04608 * turbidity - 0.04586) * 0.5**-1.3)


def air_mass(elevation: npt.ArrayLike) -> Reals:
    """Length (...) of the path through the air, 1 for the vertical and 38 for the horizon, which counts for all below.

    Parameters
    ----------
    elevation : (...) array [rad]

    Notes
    -----
    Kasten and Young 1989, doi 10.1364/AO.28.004735.
    """
    raised = np.maximum(elevation, 0.0)
    mass: Reals = 1.0 / (np.sin(raised) + 0.50572 * (np.rad2deg(raised) + 6.07995) ** -1.6364)
    return mass


def clear_irradiance(sun_elevation: float, air: Atmosphere, bands: Sequence[str] = tuple(BANDS)) -> ClearIrradiance:
    """Irradiance of the ground by sun and cloudless sky.

    Parameters
    ----------
    sun_elevation : float [rad]
    air : Atmosphere
    bands : names in `BANDS`

    Raises
    ------
    InputError
        If a band is unknown.

    Notes
    -----
    SPCTRAL2: Bird and Riordan 1984 (doi 10.2172/5986936), 1986 (J. Climate Appl. Meteorol. 25:87). Water vapour and
    oxygen do not absorb in these bands. Where report and published code (spectrl2_2.c) differ, this follows the code:
    the correction for short waves is applied once, to the sum.
    """
    rows = [_clear_irradiance(sun_elevation, air, band) for band in chosen_bands(bands)]
    direct, diffuse = np.array(rows).T
    return ClearIrradiance(direct, diffuse, direct * np.sin(sun_elevation) + diffuse)


def chosen_bands(bands: Sequence[str]) -> list[Band]:
    """Bands of those names.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    names = [bands] if isinstance(bands, str) else bands
    for name in names:
        check_choice("band", name, tuple(BANDS))
    return [BANDS[name] for name in names]


def _clear_irradiance(sun_elevation: float, air: Atmosphere, band: Band) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance; the equations' numbers are those of the report of 1984."""
    rayleigh, haze, albedo = air.rayleigh_depth(band), air.haze_depth(band), air.haze_albedo(band)
    mass, sine = air_mass(sun_elevation), float(np.sin(sun_elevation))
    through_air, through_ozone = np.exp(-rayleigh * mass), _through_ozone(sun_elevation, air, band)
    direct = band.extraterrestrial * through_air * through_ozone * np.exp(-haze * mass)  # Eq. 2-1
    log = np.log(1.0 - ASYMMETRY)  # Eqs 3-11 to 3-15
    first = log * (1.459 + log * (0.1595 + log * 0.4129))
    second = log * (0.0783 + log * (-0.3824 - log * 0.5874))
    forward = 1.0 - 0.5 * np.exp((first + second * sine) * sine)
    forward_mean = 1.0 - 0.5 * np.exp((first + second / 1.8) / 1.8)
    common = band.extraterrestrial * sine * through_ozone * np.exp(-(1.0 - albedo) * haze * mass)
    from_air = common * (1.0 - through_air**0.95) * 0.5  # Eq. 3-5
    from_haze = common * through_air**1.5 * (1.0 - np.exp(-albedo * haze * mass)) * forward  # Eq. 3-6
    mean_air = np.exp(-rayleigh * 1.8)
    sky_albedo = np.exp(-(1.0 - albedo) * haze * 1.8) * (  # Eq. 3-8
        0.5 * (1.0 - mean_air) + (1.0 - forward_mean) * mean_air * (1.0 - np.exp(-albedo * haze * 1.8))
    )
    returned = sky_albedo * air.ground_albedo
    from_ground = (direct * sine + from_air + from_haze) * returned / (1.0 - returned)  # Eq. 3-7
    short_waves = min((band.wavelength_nm + 550.0) / 1000.0, 1.0) ** 1.8  # Eq. 3-17
    return float(direct), float((from_air + from_haze + from_ground) * short_waves)


def _through_ozone(sun_elevation: float, air: Atmosphere, band: Band) -> float:
    """Share of sunlight that the ozone lets pass: Bird and Riordan 1984, Eqs 2-9 and 2-10."""
    height = 22.0 / 6370.0  # of the ozone, in radii of the Earth
    mass = (1.0 + height) / np.sqrt(np.sin(sun_elevation) ** 2 + 2.0 * height)
    return float(np.exp(-band.ozone * air.ozone_cm * mass))


def perez_pattern(sine: npt.ArrayLike, angle_to_sun: npt.ArrayLike, turbidity: float) -> Reals:
    """Luminance (...) of the cloudless sky in arbitrary units.

    Parameters
    ----------
    sine : (...) array
        Sine of the elevation of the sky point.
    angle_to_sun : (...) array [rad]
    turbidity : float

    Notes
    -----
    (1 + A exp(B / cos θ)) (1 + C exp(D γ) + E cos² γ): Perez, Seals and Michalsky 1993, Eq. 1, doi
    10.1016/0038-092X(93)90017-I, with A to E for luminance of Preetham, Shirley and Smits 1999, Appendix 2, doi
    10.1145/311535.311545. The term with C is the aureole of the sun.
    """
    a, b = 0.1787 * turbidity - 1.4630, -0.3554 * turbidity + 0.4275
    c, d, e = -0.0227 * turbidity + 5.3251, 0.1206 * turbidity - 2.5771, -0.0670 * turbidity + 0.3703
    gradation = 1.0 + a * np.exp(b / np.maximum(sine, 1e-3))
    indicatrix = 1.0 + c * np.exp(d * np.asarray(angle_to_sun)) + e * np.square(np.cos(angle_to_sun))
    pattern: Reals = gradation * indicatrix
    return pattern


def scattered_radiance(
    sine: npt.ArrayLike, cosine_to_sun: npt.ArrayLike, sun_elevation: float, air: Atmosphere, band: Band
) -> Reals:
    """Radiance (...) of light that air and haze scattered once [W m⁻² nm⁻¹ sr⁻¹].

    Parameters
    ----------
    sine : (...) array
        Sine of the elevation of the sky point.
    cosine_to_sun : (...) array
        Cosine of its angle to the sun.
    sun_elevation : float [rad]

    Notes
    -----
    Single scattering in a layer of well-mixed air and haze, Chandrasekhar, Radiative Transfer (1950), Eq. III.172; the
    slant paths are the air masses of Kasten and Young. Phase functions: Rayleigh, 3/4 (1 + cos² γ); haze, Henyey and
    Greenstein 1941 (doi 10.1086/144246) with the asymmetry of Bird and Riordan. One mixed layer is an assumption.
    """
    cosine = np.asarray(cosine_to_sun)
    rayleigh, haze = air.rayleigh_depth(band), air.haze_depth(band)
    by_air = rayleigh * 0.75 * (1.0 + np.square(cosine))
    by_haze = (1.0 - ASYMMETRY**2) / (1.0 + ASYMMETRY**2 - 2.0 * ASYMMETRY * cosine) ** 1.5
    mass = air_mass(np.arcsin(np.clip(sine, 0.0, 1.0)))
    sun_mass = air_mass(sun_elevation)
    difference = (rayleigh + haze) * (mass - sun_mass)
    near = np.abs(difference) < 1e-9
    share = np.where(near, 1.0, -np.expm1(-difference) / np.where(near, 1.0, difference))
    sun = band.extraterrestrial * np.exp(-(rayleigh + haze) * sun_mass) * _through_ozone(sun_elevation, air, band)
    return sun / (4 * np.pi) * (by_air + air.haze_albedo(band) * haze * by_haze) * mass * share


def clear_radiance(
    directions: npt.ArrayLike, sun: npt.ArrayLike, turbidity: float, bands: Sequence[str] = tuple(BANDS)
) -> Reals:
    """Radiance (..., band) of the cloudless sky without the sun's disc [W m⁻² nm⁻¹ sr⁻¹].

    The horizon counts for all directions below it.

    Parameters
    ----------
    directions : (..., 3) array of unit vectors: +x east, +y north, +z up
    sun : (3,) unit vector
    turbidity : float
    bands : names in `BANDS`

    Raises
    ------
    InputError
        If a band is unknown, or the sun or the turbidity is out of range.
    """
    directions, sun = np.asarray(directions, dtype=float), np.asarray(sun, dtype=float)
    elevation = float(np.arcsin(np.clip(sun[2], -1.0, 1.0)))
    check_clear_sky(elevation, turbidity)
    sine, cosine = np.clip(directions[..., 2], 0.0, 1.0), np.clip(directions @ sun, -1.0, 1.0)
    shapes = [_shape(sine, cosine, elevation, turbidity, band) for band in chosen_bands(bands)]
    return np.stack(shapes, axis=-1) * [_scale(elevation, turbidity, band) for band in chosen_bands(bands)]


def check_clear_sky(sun_elevation: float, turbidity: float) -> None:
    """Refuse a sun or a turbidity for which there is no model.

    Raises
    ------
    InputError
        If the sun stands lower than 2°, where twilight begins to matter, or the turbidity is not within 2 to 8.
    """
    slip = "twilight and night are not modelled" if np.less(sun_elevation, LOWEST_SUN) else "degrees?"
    check_range("sun_elevation", sun_elevation, LOWEST_SUN - 1e-9, np.pi / 2 + 1e-9, "rad", slip)
    check_range("turbidity", turbidity, LOWEST_TURBIDITY, HIGHEST_TURBIDITY, "", "2 is very clear, 6 hazy")


def _shape(sine: Reals, cosine: Reals, sun_elevation: float, turbidity: float, band: Band) -> Reals:
    """Perez pattern times the band's scattering relative to that of green."""
    air = atmosphere(turbidity)

    def scattered(of: Band) -> Reals:
        once = scattered_radiance(sine, cosine, sun_elevation, air, of)
        return once + _scattered_again(sun_elevation, turbidity, of)

    pattern = perez_pattern(sine, np.arccos(cosine), turbidity)
    return pattern if band is BANDS["green"] else pattern * scattered(band) / scattered(BANDS["green"])


@lru_cache(maxsize=1024)
def _scattered_again(sun_elevation: float, turbidity: float, band: Band) -> float:
    """Radiance of the light scattered more than once: what the first scattering leaves of the diffuse irradiance."""
    sine, cosine, weights = _sky_grid(sun_elevation)
    air = atmosphere(turbidity)
    once = float(weights @ scattered_radiance(sine, cosine, sun_elevation, air, band))
    return max(_clear_irradiance(sun_elevation, air, band)[1] - once, 0.0) / np.pi


@lru_cache(maxsize=1024)
def _scale(sun_elevation: float, turbidity: float, band: Band) -> float:
    """Factor that gives the pattern the diffuse irradiance of Bird and Riordan."""
    sine, cosine, weights = _sky_grid(sun_elevation)
    irradiance = float(weights @ _shape(sine, cosine, sun_elevation, turbidity, band))
    return _clear_irradiance(sun_elevation, atmosphere(turbidity), band)[1] / irradiance


def _sky_grid(sun_elevation: float) -> tuple[Reals, Reals, Reals]:
    """Sine of elevation, cosine of the angle to a sun in the north, and weight for irradiance of level ground."""
    directions, weights = sky_quadrature()
    cosine = directions[:, 1] * np.cos(sun_elevation) + directions[:, 2] * np.sin(sun_elevation)
    return directions[:, 2], np.clip(cosine, -1.0, 1.0), weights


def sky_quadrature() -> tuple[Reals, Reals]:
    """Directions (n, 3) over the sky and weights (n,) [sr] that add radiance up to the irradiance of level ground.

    Gauss and Legendre's rule in the sine of elevation times even azimuths; the weights hold the sine and add up to π.
    """
    nodes, gauss = np.polynomial.legendre.leggauss(RINGS)
    sine = (nodes + 1.0) / 2.0
    azimuth = (np.arange(SECTORS) + 0.5) * (2 * np.pi / SECTORS)
    level = np.sqrt(1.0 - sine**2)[:, None]
    up = np.broadcast_to(sine[:, None], (RINGS, SECTORS))
    directions = np.stack([level * np.sin(azimuth), level * np.cos(azimuth), up], axis=-1)
    weights = np.repeat(sine * gauss / 2.0 * (2 * np.pi / SECTORS), SECTORS)
    return directions.reshape(-1, 3), weights
