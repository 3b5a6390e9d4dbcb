"""Reflectance per band, and mirrors against Fresnel's closed forms."""

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.materials import MATERIALS, Material, mirror_fraction, reflectance
from insectnav.worlds.skylight import BANDS

WAVELENGTHS = {"uv": 350.0, "blue": 450.0, "green": 520.0, "red": 620.0}
MIRRORS = {"window": 1.52, "water": 1.34, "dark paint": 1.5, "light paint": 1.5, "red paint": 1.5}


def test_bands_are_those_of_the_sky():
    assert {name: band.wavelength_nm for name, band in BANDS.items()} == WAVELENGTHS


@pytest.mark.parametrize("name", MATERIALS)
def test_each_material_names_its_source_and_gives_back_no_more_than_it_gets(name: str):
    material = MATERIALS[name]
    assert material.source
    assert material.source != "none" or material.assumed
    assert len(material.diffuse) == len(BANDS)
    assert all(0.0 < share < 1.0 for share in material.diffuse)
    assert max(material.diffuse) + material.metal_mirror < 1.0


@pytest.mark.parametrize(
    ("materials", "low", "high"),  # Feister & Grewe 1995, abstract: albedo at 315–400 nm
    [(("leaves", "grass"), 0.016, 0.03), (("soil",), 0.05, 0.08), (("sand",), 0.14, 0.24), (("concrete",), 0.07, 0.3)],
)
def test_ultraviolet_is_within_what_was_measured(materials: tuple[str, ...], low: float, high: float):
    values = reflectance(materials, "uv")
    assert ((values >= low) & (values <= high)).all()


def test_plants_are_greenest_in_green():
    for name in ("leaves", "grass", "needles"):
        uv, blue, green, red = (float(reflectance([name], band)[0]) for band in BANDS)
        assert uv < blue < green > red


def test_grey_has_the_two_values_of_the_published_figures():
    np.testing.assert_allclose(reflectance(["leaves", "brick", "straw", "sand"], "grey"), [64 / 255] * 3 + [0.1])


@pytest.mark.parametrize("name", MIRRORS)
def test_straight_on_a_pile_of_surfaces_reflects_as_stokes_says(name: str):
    single = ((MIRRORS[name] - 1) / (MIRRORS[name] + 1)) ** 2
    n = 4 if name == "window" else 1
    assert mirror_fraction(name, 1.0) == pytest.approx(n * single / (1 + (n - 1) * single))


@pytest.mark.parametrize("name", MIRRORS)
def test_at_grazing_incidence_all_is_mirrored(name: str):
    assert mirror_fraction(name, 0.0) == pytest.approx(1.0)


def test_water_at_brewsters_angle_reflects_half_of_the_light_polarised_across():
    """The other polarisation has none; across, R = ((n² − 1) / (n² + 1))²."""
    index = 1.34
    expected = 0.5 * ((index**2 - 1) / (index**2 + 1)) ** 2
    assert mirror_fraction("water", np.cos(np.arctan(index))) == pytest.approx(expected)


def test_dull_materials_mirror_nothing_and_metal_the_same_at_all_angles():
    cosine = np.linspace(0.0, 1.0, 7)
    np.testing.assert_array_equal(mirror_fraction("brick", cosine), 0.0)
    assert len(set(mirror_fraction("metal", cosine).tolist())) == 1


def test_mirrors_grow_towards_grazing():
    cosine = np.linspace(0.0, 1.0, 200)
    for name in MIRRORS:
        share = mirror_fraction(name, cosine)
        assert ((share >= 0.0) & (share <= 1.0)).all()
        assert (np.diff(share) <= 1e-12).all()


def test_bad_input():
    with pytest.raises(InputError, match="did you mean leaves"):
        reflectance(["leafs"], "uv")
    with pytest.raises(InputError, match="expected one of uv, blue, green, red, grey"):
        reflectance(["leaves"], "infrared")
    with pytest.raises(InputError, match="cos_incidence"):
        mirror_fraction("water", 1.5)
    with pytest.raises(InputError, match="unknown"):
        mirror_fraction("chrome", 0.5)
    with pytest.raises(TypeError):
        Material((0.1, 0.1, 0.1, 0.1), "positional")
