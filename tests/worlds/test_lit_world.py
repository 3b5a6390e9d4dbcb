"""Light on surfaces, against closed forms: open ground, tilted sheets, shadows, walls, leaves, mirrors, sky and sun."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.records import Mesh
from insectnav.vision import panorama
from insectnav.vision.sphere import directions
from insectnav.worlds import Grain, light_world, render
from insectnav.worlds.clouds import CloudField
from insectnav.worlds.lit_world import sky_parts
from insectnav.worlds.materials import MATERIALS, mirror_fraction
from insectnav.worlds.shadow_map import light_frame
from insectnav.worlds.sky import Sky
from insectnav.worlds.skylight import BANDS
from shading_oracle import shade
from solid_shapes import quad, soup, wall

NAMES = tuple(BANDS)
FLAT = Grain(contrast=0.0)
EVERYWHERE = ((-50.0, -50.0), (50.0, 50.0))
CLEAR = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(40.0))
FAR = wall(45, 45, 46, 46, 0.1)  # a world needs something
DOWN = (0.0, 0.0, -1.0)


def lit(*triangles, material="concrete", sky=CLEAR, **options):
    mesh = Mesh(vertices=np.concatenate(triangles), materials=(material,))
    return light_world(mesh, sky, grain=options.pop("grain", FLAT), extent=EVERYWHERE, **options)


def radiance(world, place, ray):
    """Radiance (band,) along one ray."""
    ray = np.asarray(ray, float) / np.linalg.norm(ray)
    seen = render(world, [place], directions=[ray], layers=NAMES)
    return np.array([seen[band][0, 0] for band in NAMES])


def reflected(material, irradiance):
    return np.array(MATERIALS[material].diffuse) * irradiance / np.pi


@pytest.mark.parametrize("shadows", [False, True])
def test_open_ground_is_as_bright_as_a_sheet_of_its_reflectance(shadows):
    got = radiance(lit(FAR, ground="sand", shadows=shadows), (0, 0, 1), DOWN)
    assert_allclose(got, reflected("sand", CLEAR.irradiance(NAMES)), rtol=1e-5)


def test_a_wall_that_faces_the_sun():
    """Sun at the cosine of its angle; sky and ground each from a half, the sky by its own quadrature."""
    facing = np.array([CLEAR.sun[0], CLEAR.sun[1], 0.0])
    facing /= np.linalg.norm(facing)
    across = np.array([-facing[1], facing[0]]) * 20
    world = lit(wall(*-across, *across, 30), shadows=False)
    rays = directions(*np.meshgrid(np.deg2rad(np.arange(0.5, 360)), np.deg2rad(np.arange(0.5, 90))))
    cosine = np.maximum(rays @ facing, 0.0) * np.sqrt(1 - rays[..., 2] ** 2) * np.deg2rad(1.0) ** 2
    sky = np.einsum("ea,eab->b", cosine, CLEAR.radiance(rays, NAMES, sun_disc=False))
    ground = np.pi / 2 * reflected("soil", CLEAR.irradiance(NAMES))
    sun = CLEAR.sun_irradiance(NAMES) * np.cos(CLEAR.sun_elevation)
    got = radiance(world, (*(3 * facing[:2]), 1.0), -facing)
    assert_allclose(got, reflected("concrete", sun + sky + ground), rtol=0.03)  # 32 parts stand for the sky


def test_a_wall_throws_a_shadow_as_long_as_the_sun_is_low():
    """A long wall, the sun at right angles to it: the shadow ends at height / tan(elevation)."""
    sky = Sky(sun_azimuth=0.0, sun_elevation=np.deg2rad(35.0))
    world, height = lit(wall(-30, 0, 30, 0, 2.0), sky=sky), 2.0
    end = -height / np.tan(sky.sun_elevation)
    sun = reflected("soil", sky.sun_irradiance(NAMES) * np.sin(sky.sun_elevation))
    pixel = world.packed.sun_map.pixel
    dark, light = (radiance(world, (0, end + side, 0.5), DOWN) for side in (0.05, -0.05))
    assert pixel < 0.02
    assert_allclose(light - dark, sun, rtol=0.02)
    assert (radiance(world, (0, -end, 0.5), DOWN) - dark > 0.9 * sun).all()  # the other side lies in the sun


def test_what_stands_lower_or_behind_throws_no_shadow():
    world = lit(quad((-3, -3, 2), (3, -3, 2), (3, 3, 2), (-3, 3, 2)))
    white = CLEAR.irradiance(NAMES)
    assert_allclose(radiance(world, (0, 0, 3), DOWN), reflected("concrete", white), rtol=1e-3)  # the roof's upper side


def test_at_the_foot_of_a_wall_half_the_sky_is_left():
    """Even clouds, no sun: at the foot of a wall without end half of the light is left, and what the wall sends."""
    even = Sky(sun_azimuth=0.0, sun_elevation=0.7, clouds=CloudField(cover=1.0, optical_depth=60.0, variation=0.0))
    world = lit(wall(-45, 0, 45, 0, 40.0), material="slate", sky=even)
    foot, away = radiance(world, (0, -0.4, 0.2), DOWN), radiance(world, (0, -44.0, 0.2), DOWN)
    walls = np.array(MATERIALS["soil"].diffuse) / np.pi * (np.pi / 2) * world.packed.light.wall_light
    assert_allclose((foot - walls) / reflected("soil", even.irradiance(NAMES)), np.full(4, 0.5), atol=0.06)
    assert (away > 1.3 * foot).all()


def test_a_leaf_lets_light_through_but_no_ultraviolet():
    toward = np.array(CLEAR.sun)
    across, up = light_frame(toward)[:2]
    middle = np.array([0.0, 0.0, 5.0])
    leaf = quad(*(middle + a * across + b * up for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))))
    world = lit(leaf, material="leaves", shadows=False)
    bare = replace(world, sky=replace(CLEAR, sun_azimuth=CLEAR.sun_azimuth + np.pi))
    behind = radiance(world, tuple(middle - 2 * toward), toward)
    sun = np.array(MATERIALS["leaves"].through) * CLEAR.sun_irradiance(NAMES) / np.pi
    assert sun[0] == 0.0
    assert (behind[1:] > sun[1:]).all()
    before = radiance(world, tuple(middle + 2 * toward), -toward)
    lit_side = np.array(MATERIALS["leaves"].diffuse) * CLEAR.sun_irradiance(NAMES) / np.pi
    assert (before > lit_side).all()
    away = radiance(bare, tuple(middle + 2 * toward), -toward)  # the sun now stands elsewhere
    assert (away < before).all()


def test_a_window_mirrors_the_sky_by_fresnel():
    world = lit(wall(-20, 10, 20, 10, 30), material="window", shadows=False)
    ray = np.array([0.0, np.cos(0.5), np.sin(0.5)])
    mirrored = CLEAR.radiance(np.array([0.0, -np.cos(0.5), np.sin(0.5)]), NAMES)
    plain = lit(wall(-20, 10, 20, 10, 30), material="slate", shadows=False)
    scattered = radiance(plain, (0, 0, 1), ray) * 0.02 / np.array(MATERIALS["slate"].diffuse)
    got = radiance(world, (0, 0, 1), ray) - scattered
    assert_allclose(got, mirror_fraction("window", np.cos(0.5)) * mirrored, rtol=0.05)


def test_sky_is_the_sky_and_the_sun_has_its_light():
    cloudy = replace(CLEAR, clouds=CloudField(cover=0.4, seed=2))
    for sky in (CLEAR, cloudy):
        world, camera = lit(FAR, sky=sky), panorama(2.0, (0.0, 90.0))
        rays = camera.pixel_directions()[:30, ::10]
        seen = render(world, [[0, 0]], directions=rays, layers=NAMES)
        expected = sky.radiance(rays, NAMES, sun_disc=False)
        error = np.abs(np.stack([seen[band][0] for band in NAMES], axis=-1) / expected - 1)
        assert np.quantile(error, 0.9) < 0.03  # between entries of the table; the edges of clouds are sharper
    wide = replace(CLEAR, sun_diameter=np.deg2rad(8.0))
    with_sun, without = (
        render(lit(FAR, sky=sky), [[0, 0]], camera=panorama(2.0, (0.0, 90.0)), layers=NAMES, supersampling=8)
        for sky in (wide, replace(wide, sun_azimuth=wide.sun_azimuth + 1e-9))
    )
    rows = np.deg2rad(90.0 - 2.0 * np.arange(46))
    solid_angle = (np.sin(rows[:-1]) - np.sin(rows[1:])) * np.deg2rad(2.0)
    plain = render(lit(FAR, sky=wide), [[0, 0]], directions=panorama(2.0, (0.0, 90.0)).pixel_directions(), layers=NAMES)
    assert_allclose(with_sun["uv"], without["uv"], rtol=1e-3)
    irradiance = wide.sun_irradiance(NAMES)
    for k, band in enumerate(NAMES):
        smooth = wide.radiance(panorama(2.0, (0.0, 90.0)).pixel_directions(), [band], sun_disc=False)[..., 0]
        extra = ((with_sun[band][0] - smooth) * solid_angle[:, None]).sum()
        assert extra == pytest.approx(irradiance[k], rel=0.05)
        assert plain[band].shape == (1, 45, 180)


@pytest.mark.parametrize("seed", range(3))
def test_it_equals_a_plain_implementation_without_shadows(seed):
    """Triangles of many materials at random, in a textured world; only the table of the sky stands between the two."""
    materials = ("leaves", "brick", "window", "metal", "straw", "dark paint")
    triangles = soup(seed)
    material = np.random.default_rng(seed).integers(0, len(materials), len(triangles))
    mesh = Mesh(vertices=triangles, material=material, materials=materials)
    sky = replace(CLEAR, clouds=CloudField(cover=1.0, variation=0.0)) if seed == 2 else CLEAR
    world = light_world(mesh, sky, shadows=False, extent=EVERYWHERE, grain=Grain(seed=seed))
    rays = panorama(5.0, (-90.0, 90.0)).pixel_directions().reshape(-1, 3)
    eye = np.array([0.5, -0.3, 0.4])
    seen = render(world, [eye], directions=rays, layers=(*NAMES, "triangle", "nearness"))
    plain = shade(world, rays, seen["triangle"][0], seen["nearness"][0], eye)
    ours = np.stack([seen[band][0] for band in NAMES], axis=-1)
    assert_allclose(ours, plain, rtol=0.03)
    assert np.median(np.abs(ours / plain - 1)) < 1e-4
    assert len(np.unique(seen["triangle"])) > 50


def test_shadows_by_maps_are_those_of_exact_rays():
    """Away from edges; 4 cm pixels of the sun's map, 20 cm of those of the sky, in a world of 10 m."""
    world = lit(soup(8), material="brick")
    rays = panorama(6.0, (-90.0, 90.0)).pixel_directions().reshape(-1, 3)
    eye = np.array([0.0, 0.0, 0.5])
    seen = render(world, [eye], directions=rays, layers=("red", "triangle", "nearness"))
    plain = shade(world, rays, seen["triangle"][0], seen["nearness"][0], eye)
    ratio = seen["red"][0] / plain[:, 3]
    assert (np.abs(ratio - 1) < 0.1).mean() > 0.9
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.02)


def test_parts_of_the_sky_add_up_to_the_whole():
    parts, light = sky_parts(CLEAR)
    diffuse = CLEAR.irradiance(NAMES) - CLEAR.sun_irradiance(NAMES) * np.sin(CLEAR.sun_elevation)
    assert_allclose(parts[:, 2] @ light, diffuse, rtol=1e-5)
    assert_allclose(np.linalg.norm(parts, axis=-1), 1.0)


def test_turning_the_world_and_the_sun_turns_the_picture():
    """A quarter turn of everything; the parts of the sky do not turn with it, so that light may differ somewhat."""
    triangles, mesh = soup(4), {}
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # clockwise seen from above
    pictures = []
    for turn in (0, 1):
        mesh = triangles @ np.linalg.matrix_power(quarter, turn).T
        sky = replace(CLEAR, sun_azimuth=CLEAR.sun_azimuth + turn * np.pi / 2)
        world = lit(mesh, sky=sky, material="brick")
        pictures.append(render(world, [[0, 0, 0.3]], turn * np.pi / 2, camera=panorama(3.0), layers=("green", "sky")))
    assert np.abs(pictures[0]["sky"] - pictures[1]["sky"]).mean() < 1e-3
    ratio = pictures[1]["green"] / pictures[0]["green"]
    assert np.median(np.abs(ratio - 1)) < 0.02


def test_texture_stays_where_it_is_when_the_eye_moves():
    world = lit(wall(-20, 10, 20, 10, 10), grain=Grain(contrast=0.3, seed=4), shadows=False)
    target = np.array([2.0, 10.0, 3.0])
    places = np.array([[0.0, 0.0, 1.0], [4.0, 3.0, 2.0], [-5.0, 6.0, 0.5]])
    seen = [radiance(world, tuple(place), target - place) for place in places]
    assert_allclose(seen[1], seen[0], rtol=1e-3)
    assert_allclose(seen[2], seen[0], rtol=1e-3)
    flat = radiance(lit(wall(-20, 10, 20, 10, 10), shadows=False), tuple(places[0]), target - places[0])
    assert np.ptp(seen[0] / flat) < 1e-5  # the same factor in all bands
    assert abs(seen[0][0] / flat[0] - 1) > 1e-3


def test_a_wide_pixel_blurs_the_texture():
    world = lit(wall(-40, 10, 40, 10, 20), grain=Grain(contrast=0.3, seed=4, coarsest=2.0))
    flat = lit(wall(-40, 10, 40, 10, 20))
    spread = []
    for resolution in (0.25, 10.0):
        camera = panorama(resolution, (0.0, 40.0))
        options = {"camera": camera, "layers": ("green", "alpha"), "supersampling": 1}
        rough, even = (render(one, [[0.0, 0.0, 0.5]], **options) for one in (world, flat))
        full = rough["alpha"][0] == 1
        spread.append((rough["green"][0][full] / even["green"][0][full]).std())
    assert spread[0] > 0.15
    assert spread[1] < 0.2 * spread[0]


def test_another_sky_over_the_same_surfaces_is_a_new_world():
    world, overcast = lit(soup(2)), replace(CLEAR, clouds=CloudField(cover=1.0))
    again = lit(soup(2), sky=overcast)
    options = {"camera": panorama(5.0), "layers": ("uv", "red"), "supersampling": 1}
    moved = world.under(overcast)
    for band in ("uv", "red"):
        render(world, [[0, 0]], **options)
        assert_array_equal(render(moved, [[0, 0]], **options)[band], render(again, [[0, 0]], **options)[band])


def test_a_world_that_was_changed_is_lit_as_one_made_anew():
    """What worlds share that were made of each other is that of their own surfaces, sun and sky."""
    first, overcast = lit(soup(2)), replace(CLEAR, clouds=CloudField(cover=1.0))
    low, dark = replace(CLEAR, sun_elevation=0.2), MATERIALS | {"concrete": MATERIALS["soil"]}
    changed = [first, first.under(low)]
    changed += [changed[-1].under(overcast), replace(first, materials=dark), replace(first, shape=lit(soup(3)).shape)]
    anew = [lit(soup(2)), lit(soup(2), sky=low), lit(soup(2), sky=overcast), lit(soup(2), materials=dark), lit(soup(3))]
    options = {"camera": panorama(5.0), "layers": ("uv", "red"), "supersampling": 1}
    for world, other in zip(changed, anew, strict=True):
        seen, expected = (render(each, [[0, 0]], **options) for each in (world, other))
        for band in ("uv", "red"):
            assert_array_equal(seen[band], expected[band])


def test_in_ultraviolet_the_sky_stands_out():
    """The claim of chapter 3: above plants, sky over surroundings is brighter in ultraviolet than in green."""
    world = lit(soup(6), material="leaves")
    seen = render(world, [[0, 0]], camera=panorama(3.0), layers=("uv", "green", "sky"), supersampling=2)
    is_sky, is_not = seen["sky"] == 1, seen["sky"] == 0
    contrast = {band: np.median(seen[band][is_sky]) / np.median(seen[band][is_not]) for band in ("uv", "green")}
    assert contrast["uv"] > 2 * contrast["green"]


def test_unknown_materials_are_refused_in_one_sentence():
    mesh = Mesh(vertices=FAR, materials=("plant",))
    with pytest.raises(InputError, match=r"material 'plant' of which no reflectance is known.*give one .* material="):
        light_world(mesh, CLEAR)
    assert light_world(mesh, CLEAR, material="leaves").mesh.materials == ("leaves",)
    with pytest.raises(InputError, match="ground 'lawn' is unknown: expected one of leaves"):
        light_world(mesh, CLEAR, material="leaves", ground="lawn")
    with pytest.raises(InputError, match="contrast is 2, expected 0 to 1"):
        Grain(contrast=2)
