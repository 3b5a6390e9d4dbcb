from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.vision import fisheye, panorama, parabolic_mirror
from insectnav.vision.cameras import AHEAD, UPWARDS, Camera
from insectnav.vision.lens_flare import (
    NO_FLARE,
    Ghost,
    LensFlare,
    add_lens_flare,
    halo_radiance,
    pixel_solid_angles,
)
from insectnav.vision.sphere import directions, equirectangular, great_circle_angle, rotation_matrix, to_eye

DEGREE = np.pi / 180
SKY = fisheye((240, 240), np.pi)
ALL_ROUND = panorama(2.0, (-90.0, 90.0))
TELE = Camera(model="pinhole", size=(90, 120), focal_length=(150.0, 150.0), centre=(60.0, 45.0), field=(0.0, 1.2))
SUN = directions(0.5, 0.9)
VEIL = LensFlare(veiling_glare=0.05, halo=0.0, ghosts=())
HALO = LensFlare(veiling_glare=0.0, halo=0.05, ghosts=())
SPOT = LensFlare(veiling_glare=0.0, halo=0.0, ghosts=(Ghost(share=1e-3, place=0.6, radius=6 * DEGREE),))
RNG = np.random.default_rng(0)


def scene(camera: Camera, n: int = 3) -> np.ndarray:
    return np.where(camera.pixels_seen(), RNG.uniform(0.0, 0.3, (n, *camera.size)), 0.0).astype(np.float32)


@pytest.mark.parametrize("model", ["equidistant", "equisolid", "stereographic", "orthographic", "pinhole"])
def test_solid_angles_of_a_round_field_sum_to_its_own(model: str):
    camera = fisheye((300, 300), 2.2, model=model)
    total = pixel_solid_angles(camera)[camera.pixels_seen()].sum()
    assert total == pytest.approx(2 * np.pi * (1 - np.cos(1.1)), rel=2e-3)


def test_solid_angles_are_those_of_grids_and_corners():
    grid = equirectangular(2.0, (-90.0, 90.0))
    np.testing.assert_allclose(pixel_solid_angles(ALL_ROUND).ravel(), grid.weights, rtol=1e-4)
    # Equal areas on the sphere are equal areas of an equisolid picture; a pinhole's fall by the cube of the cosine.
    equal = pixel_solid_angles(fisheye((100, 100), np.pi, model="equisolid"))
    np.testing.assert_allclose(equal[np.isfinite(equal)], equal[50, 50], rtol=1e-5)
    cosine = TELE.pixel_directions() @ TELE.rotation[:, 1]
    np.testing.assert_allclose(pixel_solid_angles(TELE), cosine**3 / 150.0**2, rtol=1e-5)


@pytest.mark.parametrize("camera", [SKY, ALL_ROUND, TELE])
def test_no_flare_is_the_input(camera: Camera):
    images = scene(camera)
    got = add_lens_flare(images, camera, SUN, 1.3, NO_FLARE)
    assert got.dtype == np.float32
    np.testing.assert_array_equal(got, images)
    assert not np.shares_memory(got, images)


@pytest.mark.parametrize("camera", [SKY, ALL_ROUND, TELE, parabolic_mirror((120, 120), 50.0)])
def test_even_scene_without_sun_stays_even(camera: Camera):
    # What the veil takes it gives back: it only moves light, of which an even scene has the same everywhere.
    images = np.where(camera.pixels_seen(), 0.3, 0.0)
    np.testing.assert_allclose(add_lens_flare(images, camera, SUN, 1.0, VEIL, visible_share=0.0), images, rtol=1e-12)


def test_veil_is_the_glare_index_of_a_black_spot():
    # ISO 9358: a small black spot in an even field is as bright as the index says.
    images = np.where(SKY.pixels_seen(), 2.0, 0.0)
    images[100:103, 60:63] = 0.0
    got = add_lens_flare(images, SKY, SUN, 0.0, VEIL)
    assert got[101, 61] == pytest.approx(0.05 * 2.0, rel=1e-3)


@pytest.mark.parametrize("camera", [SKY, ALL_ROUND, fisheye((240, 240), np.pi, model="equisolid")])
def test_veil_has_its_share_of_the_light_on_the_lens(camera: Camera):
    shown = camera.pixels_seen()
    images = np.where(shown, 0.1 + 0.3 * np.nan_to_num(camera.pixel_directions()[..., 2]) ** 4, 0.0)  # bright zenith
    elevation = 0.9  # all three look up
    veil = add_lens_flare(images, camera, SUN, 1.3, VEIL) - 0.95 * images
    assert np.ptp(veil[shown]) < 1e-12
    # Of the scene the integral of 2π (0.1 + 0.3 z⁴) z dz over the hemisphere; and the sun.
    on_lens = np.pi * (0.1 + 0.3 / 3) + 1.3 * np.sin(elevation)
    # The few pixels about the sun are counted as the mean of the rest.
    assert np.pi * veil[shown].mean() == pytest.approx(0.05 * on_lens, rel=2e-3)


def test_disc_of_the_sun_is_not_counted_twice():
    images = scene(ALL_ROUND, 1)[0].astype(float)
    with_disc = images.copy()
    near = great_circle_angle(ALL_ROUND.pixel_directions(), SUN) < 2.2 * DEGREE
    with_disc[near] = 1e3
    veils = [add_lens_flare(one, ALL_ROUND, SUN, 1.3, VEIL, sun_diameter=4.4 * DEGREE) - 0.95 * one
             for one in (images, with_disc)]  # fmt: skip
    np.testing.assert_allclose(veils[0], veils[1], atol=1e-9)


@pytest.mark.parametrize("slope", [1.0, 2.0, 3.0])
def test_halo_integrates_to_its_share(slope: float):
    flare = replace(HALO, halo_slope=slope)
    angle = np.concatenate([[0.0], np.geomspace(1e-6, np.pi, 20001)])
    ring = 2 * np.pi * np.sin(angle) * halo_radiance(angle, flare)
    assert np.trapezoid(ring, angle) == pytest.approx(0.05, rel=1e-4)
    # Well beyond the core it falls by that power of the angle, or of its double sine of the half.
    ratio = halo_radiance(0.05, flare) / halo_radiance(0.2, flare)
    assert ratio == pytest.approx((np.sin(0.1) / np.sin(0.025)) ** slope, rel=0.02)


def test_halo_and_ghost_put_their_share_into_the_picture():
    camera = fisheye((700, 700), np.deg2rad(359.0), model="equisolid")
    black, solid = np.zeros(camera.size), pixel_solid_angles(camera)
    sun = directions(0.3, 0.8)
    soft = replace(HALO, halo_core=3 * DEGREE)  # wide enough for these pixels
    for flare, share in ((soft, 0.05), (SPOT, 1e-3)):
        light = np.nansum(add_lens_flare(black, camera, sun, 1.3, flare) * solid)
        assert light == pytest.approx(share * 1.3, rel=0.01)
        half = np.nansum(add_lens_flare(black, camera, sun, 1.3, flare, visible_share=0.5) * solid)
        assert half == pytest.approx(light / 2)


@pytest.mark.parametrize("camera", [
    SKY,
    TELE,
    replace(TELE, centre=(50.0, 50.0)),
    fisheye((200, 300), np.pi, model="stereographic", mounting=(0.7, 0.3, -0.4)),
    parabolic_mirror((200, 200), 60.0, field=(0.0, 1.8)),
])  # fmt: skip
@pytest.mark.parametrize("place", [1.0, 0.5, -0.4])
def test_ghost_lies_on_the_line_through_sun_and_centre(camera: Camera, place: float):
    sun = camera.rotation @ np.array([0.15, 0.97, 0.12]) / np.linalg.norm([0.15, 0.97, 0.12])
    flare = replace(SPOT, ghosts=(Ghost(share=1e-3, place=place, radius=3 * DEGREE),))
    got = add_lens_flare(np.zeros(camera.size), camera, sun, 1.0, flare)
    rows, columns = np.nonzero(got > 0.5 * got.max())
    centre, sun_pixel = np.array(camera.centre), camera.project(sun)[0]
    expected = centre - place * (sun_pixel - centre)
    np.testing.assert_allclose([columns.mean() + 0.5, rows.mean() + 0.5], expected, atol=0.7)


def test_ghost_of_a_panorama_is_mirrored_at_the_zenith():
    flare = replace(SPOT, ghosts=(Ghost(share=1e-3, place=0.5, radius=5 * DEGREE),))
    got = add_lens_flare(np.zeros(ALL_ROUND.size), ALL_ROUND, directions(0.4, 50 * DEGREE), 1.0, flare)
    brightest = ALL_ROUND.pixel_directions()[got > 0.99 * got.max()].mean(axis=0)
    centre = directions(0.4 - np.pi, 70 * DEGREE)
    assert great_circle_angle(brightest / np.linalg.norm(brightest), centre) < 1.0 * DEGREE


def test_sun_outside_the_picture_still_flares_until_it_is_behind_the_lens():
    black = np.zeros(TELE.size)
    beside = directions(40 * DEGREE, 0.0)
    assert not TELE.project(beside)[1]
    got = add_lens_flare(black, TELE, beside, 1.0, HALO)
    assert got[45, -1] > got[45, 0] > 0.0  # brighter on the side of the sun
    # Its ghost may be in the picture: here at 0.3 of the distance of the sun, which is 126 pixels from the centre.
    ghost = replace(SPOT, ghosts=(Ghost(share=1e-3, place=0.3, radius=0.05),))
    columns = np.flatnonzero(add_lens_flare(black, TELE, beside, 1.0, ghost)[45])
    assert columns.mean() + 0.5 == pytest.approx(60 - 0.3 * 150 * np.tan(40 * DEGREE), abs=1.0)
    behind = directions(100 * DEGREE, 0.0)
    for flare in (VEIL, HALO, SPOT):
        assert not add_lens_flare(black, TELE, behind, 1.0, flare).any()


def test_flare_turns_with_the_camera():
    level, tilted = fisheye((120, 120), 3.0, mounting=AHEAD), fisheye((120, 120), 3.0, mounting=(0.4, 0.8, -0.3))
    images, flare = scene(level), LensFlare()
    sun = directions(0.3, 0.2)
    turned = rotation_matrix(0.4, 0.8, -0.3) @ sun
    np.testing.assert_allclose(
        add_lens_flare(images, level, sun, 1.0, flare), add_lens_flare(images, tilted, turned, 1.0, flare), rtol=1e-5
    )


def test_batches_and_bands_are_the_loop():
    images = np.stack([scene(SKY), scene(SKY)], axis=-1)
    headings, shares, light = np.array([0.0, 1.0, 2.0]), np.array([1.0, 0.3, 0.0]), np.array([1.3, 0.4])
    suns = to_eye(SUN, rotation_matrix(headings))
    got = add_lens_flare(images, SKY, suns, light, LensFlare(), visible_share=shares, has_bands=True)
    assert got.shape == images.shape
    for k in range(3):
        for band in range(2):
            one = add_lens_flare(images[k, ..., band], SKY, suns[k], light[band], LensFlare(), visible_share=shares[k])
            np.testing.assert_allclose(got[k, ..., band], one, rtol=1e-6)
    assert add_lens_flare(images[:0, ..., 0], SKY, SUN, 1.0, LensFlare()).shape == (0, 240, 240)


def test_pixels_outside_the_picture_stay():
    images = np.full(SKY.size, 0.2)
    images[~SKY.pixels_seen()] = 7.0
    got = add_lens_flare(images, SKY, SUN, 1.0, LensFlare())
    assert (got[~SKY.pixels_seen()] == 7.0).all()
    assert (got[SKY.pixels_seen()] > 0.2).all()


@given(st.floats(0.0, 4.0), st.floats(0.0, 1.0))
def test_flare_is_linear_in_light(light: float, share: float):
    camera = fisheye((24, 24), np.pi, mounting=UPWARDS)
    image = np.where(camera.pixels_seen(), 0.1, 0.0)
    unit = add_lens_flare(0.0 * image, camera, SUN, 1.0, LensFlare())
    scene_only = add_lens_flare(image, camera, SUN, 0.0, LensFlare())
    got = add_lens_flare(image, camera, SUN, light, LensFlare(), visible_share=share)
    np.testing.assert_allclose(got, scene_only + light * share * unit, rtol=1e-9, atol=1e-12)


IMAGE = np.zeros(SKY.size)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: LensFlare(veiling_glare=2.0), "veiling_glare is 2.*per cent"),
        (lambda: LensFlare(veiling_glare=0.6, halo=0.6), "together is 1.2"),
        (lambda: LensFlare(halo_core=5.0), "halo_core is 5.*degrees"),
        (lambda: Ghost(share=0.1, place=1.0, radius=5.0), "radius of a ghost is 5.*degrees"),
        (lambda: add_lens_flare(IMAGE[:100], SKY, SUN, 1.0, VEIL), r"pictures of \(100, 240\) pixels"),
        (lambda: add_lens_flare(IMAGE - 1, SKY, SUN, 1.0, VEIL), "radiance reaches -1"),
        (lambda: add_lens_flare(IMAGE, SKY, 2 * SUN, 1.0, VEIL), "sun has a vector of length 2"),
        (lambda: add_lens_flare(IMAGE, SKY, np.tile(SUN, (2, 1)), 1.0, VEIL), "sun has shape"),
        (lambda: add_lens_flare(IMAGE, SKY, SUN, -1.0, VEIL), "sun_irradiance reaches -1"),
        (lambda: add_lens_flare(IMAGE, SKY, SUN, [1.0, 2.0], VEIL), "sun_irradiance has shape"),
        (lambda: add_lens_flare(IMAGE, SKY, SUN, 1.0, VEIL, visible_share=100), "visible_share reaches 100"),
        (lambda: add_lens_flare(IMAGE, SKY, SUN, 1.0, VEIL, sun_diameter=5.0), "sun_diameter is 5.*degrees"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message: str):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
