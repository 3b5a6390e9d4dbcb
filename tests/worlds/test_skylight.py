"""Light of the clear sky against the published code of its model, standard daylight, and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate

from insectnav.checks import InputError
from insectnav.worlds.skylight import (
    ASYMMETRY,
    BANDS,
    LOWEST_SUN,
    Atmosphere,
    air_mass,
    atmosphere,
    clear_irradiance,
    clear_radiance,
    perez_pattern,
    scattered_radiance,
    sky_quadrature,
)
from insectnav.worlds.sun import sun_direction

turbidities, sun_elevations = st.floats(2.0, 8.0), st.floats(LOWEST_SUN, np.pi / 2)


def sky_points(n_rings: int = 200, n_sectors: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints of even cells of elevation and azimuth, and their solid angles."""
    elevation = (np.arange(n_rings) + 0.5) * np.pi / 2 / n_rings
    azimuth = (np.arange(n_sectors) + 0.5) * 2 * np.pi / n_sectors
    directions = sun_direction(*np.meshgrid(azimuth, elevation))
    area = np.cos(elevation) * np.pi / 2 / n_rings * 2 * np.pi / n_sectors
    return directions, np.broadcast_to(area[:, None], directions.shape[:-1])


def test_published_spectrum():
    # NREL's spectrl2_2.c as run by the solar_utils package: pvlib's spectrl2_example_spectra.csv (MIT licence) for
    # zenith 47.912°, AOD 0.1, exponent 1.14, ozone 0.344 cm, albedo 0.2, day 75; W m⁻² µm⁻¹. Its column for the light
    # outside the atmosphere tells the distance of the sun on that day. There is no row for 620 nm.
    outside = np.array([986.02985, 2026.64258, 1850.76428])
    direct, diffuse = [304.39011, 1225.82324, 1302.77954], [206.68697, 325.49948, 218.66916]
    air = Atmosphere(haze_500nm=0.1, angstrom_exponent=1.14, ozone_cm=0.344, ground_albedo=0.2)
    light = clear_irradiance(np.deg2rad(90.0 - 47.91208648681641), air, ["uv", "blue", "green"])
    scale = outside / [BANDS[band].extraterrestrial for band in ("uv", "blue", "green")]
    assert light.direct_normal * scale == pytest.approx(direct, rel=3e-4)
    assert light.diffuse * scale == pytest.approx(diffuse, rel=3e-4)
    assert light.horizontal == pytest.approx(
        light.direct_normal * np.cos(np.deg2rad(47.91208648681641)) + light.diffuse, rel=1e-12
    )


def test_daylight_has_the_colour_of_standard_daylight():
    # CIE D65 at 350, 450, 520 and 620 nm (ISO 11664-2); daylight varies, above all in ultraviolet.
    standard = np.array([44.9117, 117.008, 104.790, 87.6987])
    light = clear_irradiance(np.deg2rad(45.0), atmosphere(3.0)).horizontal
    ratio = light / light[2] / (standard / standard[2])
    assert ratio == pytest.approx(1.0, abs=0.2)


def test_optical_depth_of_the_air():
    # Hansen and Travis 1974 (doi 10.1007/BF00168069), Eq. 2.30, for the standard pressure.
    wavelength = np.array([band.wavelength_nm for band in BANDS.values()]) / 1000.0
    expected = 0.008569 * wavelength**-4 * (1.0 + 0.0113 * wavelength**-2 + 0.00013 * wavelength**-4)
    air = atmosphere(2.0)
    assert [air.rayleigh_depth(band) for band in BANDS.values()] == pytest.approx(expected, rel=0.02)


def test_turbidity_is_the_ratio_of_optical_depths():
    # Its definition, (air + haze) / air: Preetham et al. 1999, section 2, for the middle of the visible range.
    for turbidity in (2.0, 3.0, 6.0):
        air = atmosphere(turbidity)
        depths = [(air.rayleigh_depth(band), air.haze_depth(band)) for band in (BANDS["green"], BANDS["red"])]
        low, high = sorted(1.0 + haze / rayleigh for rayleigh, haze in depths)
        assert low * 0.9 <= turbidity <= high * 1.1


def test_air_mass():
    # Kasten and Young 1989 tabulate 38.0868 for the horizon; their formula is 0.4 % less.
    assert air_mass(np.pi / 2) == pytest.approx(1.0, abs=1e-3)
    assert air_mass(np.deg2rad(30.0)) == pytest.approx(2.0, rel=4e-3)
    assert air_mass([0.0, -0.2]) == pytest.approx(38.0868, rel=6e-3)


@given(sun_elevations, turbidities)
@settings(max_examples=20, deadline=None)
def test_radiance_adds_up_to_the_diffuse_irradiance(sun_elevation, turbidity):
    directions, area = sky_points()
    radiance = clear_radiance(directions, sun_direction(0.7, sun_elevation), turbidity)
    irradiance = np.einsum("ijb,ij,ij->b", radiance, directions[..., 2], area)
    diffuse = clear_irradiance(sun_elevation, atmosphere(turbidity)).diffuse
    assert irradiance == pytest.approx(diffuse, rel=0.01)


def test_quadrature_integrates_polynomials():
    directions, weights = sky_quadrature()
    sine = directions[:, 2]
    assert weights.sum() == pytest.approx(np.pi, rel=1e-12)
    for power in (1, 2, 7):
        assert weights @ sine**power == pytest.approx(2 * np.pi / (power + 2), rel=1e-12)
    assert weights @ directions[:, :2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert weights @ directions[:, 0] ** 2 == pytest.approx(np.pi / 4, rel=1e-12)


def test_perez_pattern_is_that_of_its_formula():
    # Coefficients for T = 3 by hand from Preetham et al. 1999, Appendix 2.
    a, b, c, d, e = -0.9269, -0.6387, 5.2570, -2.2153, 0.1693
    gamma = np.deg2rad([10.0, 50.0, 120.0])
    expected = (1 + a * np.exp(b / 0.6)) * (1 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)
    assert perez_pattern(0.6, gamma, 3.0) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("sun_elevation_deg", [15.0, 30.0, 45.0, 60.0])
@pytest.mark.parametrize("turbidity", [2.5, 4.0, 6.0])
def test_zenith_luminance_is_near_the_published_fit(sun_elevation_deg, turbidity):
    # Preetham et al. 1999, Appendix 2, kcd/m², a fit of its own, said to be too bright (Zotti et al. 2007). Luminance
    # is 683 lm/W times the radiance times the 107 nm of the eye's sensitivity, if the spectrum is flat across it.
    chi = (4.0 / 9.0 - turbidity / 120.0) * 2.0 * np.deg2rad(sun_elevation_deg)
    published = 1000.0 * ((4.0453 * turbidity - 4.9710) * np.tan(chi) - 0.2155 * turbidity + 2.4192)
    green = clear_radiance([0.0, 0.0, 1.0], sun_direction(0.0, np.deg2rad(sun_elevation_deg)), turbidity, ["green"])
    assert 0.45 < green[0] * 683.0 * 107.0 / published < 1.1


@pytest.mark.parametrize("band", BANDS)
@pytest.mark.parametrize("elevation", [0.02, 0.6, 0.600001, 1.5])
def test_single_scattering_is_its_integral(band, elevation):
    # Light scattered at each depth t, weakened on its way to there and from there to the ground.
    air, of, sun_elevation, cosine = atmosphere(3.0), BANDS[band], 0.6, 0.3
    rayleigh, haze = air.rayleigh_depth(of), air.haze_depth(of)
    total, sun_mass, mass = rayleigh + haze, air_mass(sun_elevation), air_mass(elevation)
    integral, _ = integrate.quad(lambda t: np.exp(-t * sun_mass - (total - t) * mass) * mass, 0.0, total, epsabs=0)
    g = ASYMMETRY
    by_haze = (1 - g**2) / (1 + g**2 - 2 * g * cosine) ** 1.5
    source = (rayleigh * 0.75 * (1 + cosine**2) + haze * air.haze_albedo(of) * by_haze) / total
    expected = of.extraterrestrial / (4 * np.pi) * source * integral
    found = scattered_radiance(np.sin(elevation), cosine, sun_elevation, air, of)
    ozone = found / expected
    assert 0.9 < ozone <= 1.0
    other = scattered_radiance(np.sin(1.0), 0.9, sun_elevation, air, of)
    assert ozone == pytest.approx(other / single_scattering(1.0, 0.9, sun_elevation, air, of), rel=1e-9)


def single_scattering(elevation: float, cosine: float, sun_elevation: float, air: Atmosphere, of) -> float:
    """The closed form of the textbook, without ozone: μ0 / (μ0 − μ) (exp(−τ/μ0) − exp(−τ/μ))."""
    rayleigh, haze = air.rayleigh_depth(of), air.haze_depth(of)
    total, mu, mu_sun = rayleigh + haze, 1 / air_mass(elevation), 1 / air_mass(sun_elevation)
    g = ASYMMETRY
    by_haze = (1 - g**2) / (1 + g**2 - 2 * g * cosine) ** 1.5
    source = (rayleigh * 0.75 * (1 + cosine**2) + haze * air.haze_albedo(of) * by_haze) / total
    depth = mu_sun / (mu_sun - mu) * (np.exp(-total / mu_sun) - np.exp(-total / mu))
    return of.extraterrestrial / (4 * np.pi) * source * depth


@given(sun_elevations, turbidities, st.floats(-np.pi, np.pi), st.floats(0.0, np.pi / 2), st.floats(0.0, np.pi))
@settings(deadline=None)
def test_sky_is_symmetric_and_turns_with_the_sun(sun_elevation, turbidity, azimuth, elevation, aside):
    right = clear_radiance(sun_direction(azimuth + aside, elevation), sun_direction(azimuth, sun_elevation), turbidity)
    left = clear_radiance(sun_direction(-aside, elevation), sun_direction(0.0, sun_elevation), turbidity)
    assert left == pytest.approx(right, rel=1e-5)
    assert (right > 0.0).all()


def test_colours_of_the_sky():
    sun = sun_direction(0.0, np.deg2rad(40.0))
    zenith, opposite = [0.0, 0.0, 1.0], sun_direction(np.pi, np.deg2rad(50.0))
    near_sun, horizon = sun_direction(0.0, np.deg2rad(43.0)), [1.0, 0.0, 0.0]
    light = clear_radiance(np.array([zenith, opposite, near_sun, horizon]), sun, 2.5)
    uv_to_red, blue_to_red = light[:, 0] / light[:, 3], light[:, 1] / light[:, 3]
    assert (blue_to_red > 1.0).all()
    for colour in (uv_to_red, blue_to_red):  # haze near the sun and the thick air of the horizon are whiter
        assert colour[2] < 0.8 * min(colour[0], colour[1])
        assert colour[3] < 0.95 * colour[0]
    contrast = light[2] / light[1]  # the sky is more even in ultraviolet
    assert (np.diff(contrast) > 0.0).all()
    assert (light[2] == light.max(axis=0)).all()


def test_share_of_the_sky_in_daylight_rises_towards_short_waves_and_with_haze():
    shares = []
    for turbidity in (2.0, 3.0, 6.0):
        light = clear_irradiance(np.deg2rad(40.0), atmosphere(turbidity))
        shares.append(light.diffuse / light.horizontal)
    assert (np.diff(shares, axis=1) < 0.0).all()
    assert (np.diff(shares, axis=0) > 0.0).all()
    assert shares[0][0] > 0.45  # in clear air half of the light at 350 nm comes from the sky


def test_batch_is_loop():
    directions, sun = sky_points(4, 5)[0], sun_direction(1.0, 0.5)
    batch = clear_radiance(directions, sun, 3.0, ["red", "uv"])
    assert batch.shape == (4, 5, 2)
    for i, j in np.ndindex(4, 5):
        assert clear_radiance(directions[i, j], sun, 3.0, ["red", "uv"]) == pytest.approx(batch[i, j], rel=1e-12)


@pytest.mark.parametrize(
    ("elevation", "turbidity", "bands", "words"),
    [
        (-0.1, 3.0, ["uv"], "twilight"),
        (0.5, 1.0, ["uv"], "turbidity is 1, expected 2 to 8"),
        (0.5, 3.0, ["infrared"], "infrared"),
    ],
)
def test_bad_input(elevation, turbidity, bands, words):
    with pytest.raises(InputError, match=words):
        clear_radiance([0.0, 0.0, 1.0], sun_direction(0.0, elevation), turbidity, bands)
