"""What directions see of images."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import eval_legendre

from insectnav.checks import InputError
from insectnav.vision.cameras import AHEAD, UPWARDS, Camera, fisheye, panorama, parabolic_mirror
from insectnav.vision.eyes import desert_ant
from insectnav.vision.resampling import HALF_MAXIMUM_IN_SIGMA, resampler
from insectnav.vision.sphere import (
    SphereGrid,
    directions,
    equirectangular,
    fibonacci,
    great_circle_angle,
    rotation_matrix,
    thesis,
    to_world,
)

DEGREE = np.pi / 180
CAMERAS = {
    "fisheye": fisheye((160, 160), 185 * DEGREE),
    "equisolid": fisheye((160, 200), 185 * DEGREE, model="equisolid", mounting=(0.5, 1.2, 0.3)),
    "mirror": parabolic_mirror((200, 200), 90.0, field=(0.0, 95 * DEGREE)),
    "panorama": panorama(2.0, (-90.0, 90.0)),
}


def sight(camera: Camera, values) -> np.ndarray:
    """Image of a function of direction; 0 where a pixel shows none."""
    vectors = camera.pixel_directions()
    shown = np.isfinite(vectors[..., 0])
    image = np.zeros(camera.size)
    image[shown] = values(vectors[shown])
    return image


def smooth(vectors: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(vectors, -1, 0)
    return 2.0 + x - 0.5 * y + 0.3 * z * x


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("dtype", [np.uint8, np.int32, np.float32, np.float64, bool])
def test_constant_image_is_seen_as_constant(name: str, dtype: type):
    see = resampler(CAMERAS[name], thesis())
    values = see(np.full(CAMERAS[name].size, 1 if dtype is bool else 7, dtype=dtype))
    assert values.dtype == np.float32
    assert see.seen.mean() > 0.3
    np.testing.assert_allclose(values[see.seen], 1 if dtype is bool else 7, rtol=1e-5)
    assert np.isnan(values[~see.seen]).all()


@pytest.mark.parametrize("name", CAMERAS)
def test_smooth_function_is_recovered(name: str):
    # A Gaussian of standard deviation σ takes l(l+1)/2 σ² of a harmonic of degree l: σ² and 3 σ² of degrees 1 and 2,
    # which are at most 1.12 and 0.15 high. Bilinear lookup errs by h²/8 of the second derivatives, h = 0.035 rad.
    width = 2 * DEGREE
    sigma = width / HALF_MAXIMUM_IN_SIGMA
    camera, points = CAMERAS[name], fibonacci(800).directions
    see = resampler(camera, points, acceptance=width, least_coverage=1.0 - 1e-9)
    inside = see.seen
    assert inside.sum() > 300
    error = np.abs(see(sight(camera, smooth)) - smooth(points))[inside]
    assert error.max() < 1.6 * sigma**2 + 5e-4


@pytest.mark.parametrize("degree", [1, 4, 10])
def test_field_is_a_gaussian_of_the_acceptance(degree: int):
    # A Gaussian of standard deviation σ on the sphere multiplies harmonics of degree l by about exp(-l(l+1)σ²/2).
    camera, axis = panorama(1.0, (-90.0, 90.0)), directions(0.3, 0.4)
    points = fibonacci(60, (-60.0, 60.0)).directions
    see = resampler(camera, points, acceptance=12 * DEGREE)
    values = see(sight(camera, lambda v: eval_legendre(degree, v @ axis)))
    sigma = 12 * DEGREE / HALF_MAXIMUM_IN_SIGMA
    factor = np.exp(-degree * (degree + 1) * sigma**2 / 2)
    np.testing.assert_allclose(values, factor * eval_legendre(degree, points @ axis), atol=0.004)


def test_response_to_a_point_halves_at_half_the_acceptance():
    camera = fisheye((400, 400), np.pi)
    image = np.zeros((400, 400))
    image[199:201, 199:201] = 1.0  # at the zenith, four pixels of 0.45°
    offset = np.array([0.0, 2.0, 4.0, 6.0]) * DEGREE
    see = resampler(camera, directions(1.0, np.pi / 2 - offset), acceptance=8 * DEGREE, n_samples=20_000)
    values = see(image)
    np.testing.assert_allclose(values / values[0], 0.5 ** (np.rad2deg(offset) / 4) ** 2, atol=0.03)


def test_field_is_round():
    camera = fisheye((200, 200), np.pi)
    turns = np.arange(12) * 30 * DEGREE
    edge = sight(camera, lambda v: 0.5 + 0.5 * np.tanh((np.arcsin(v[:, 2]) / DEGREE - 60) / 1.5))
    values = resampler(camera, directions(turns, 60 * DEGREE), acceptance=6 * DEGREE)(edge)
    # On the rim of a disk of 30° a little less than half is inside.
    np.testing.assert_allclose(values, values.mean(), atol=2e-3)
    assert 0.45 < values.mean() < 0.5


def test_no_stripe_finer_than_the_field_is_aliased():
    camera = panorama(0.5, (-90.0, 90.0))
    stripes = sight(camera, lambda v: np.sign(np.sin(120 * np.arctan2(v[:, 0], v[:, 1]))))  # 3° wide pairs
    points = directions(np.linspace(-3, 3, 300), 0.0)
    blurred = resampler(camera, points, acceptance=6 * DEGREE)(stripes)
    # exp(-k²σ²/2) of the first harmonic, 4/π high, is 2·10⁻⁶.
    assert np.abs(blurred).max() < 0.05
    assert np.abs(resampler(camera, points, acceptance=0.3 * DEGREE)(stripes)).max() > 0.9


def test_noise_is_seen_to_a_tenth_of_its_own_spread():
    camera, grid = fisheye((160, 160), 185 * DEGREE), fibonacci(250, (10.0, 90.0))
    image = np.random.default_rng(6).uniform(size=(160, 160))
    usual, fine = resampler(camera, grid)(image), resampler(camera, grid, n_samples=4096)(image)
    assert np.std(usual - fine) < 0.1 * np.std(fine)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_seeing_is_linear_and_stays_within_the_image(seed: int):
    rng = np.random.default_rng(seed)
    see = SEE
    one, other = rng.uniform(0, 255, (2, *see.size))
    np.testing.assert_allclose(see(2 * one - other), 2 * see(one) - see(other), atol=2e-3)
    values = see(one)[see.seen]
    assert one.min() - 1e-3 <= values.min() <= values.max() <= one.max() + 1e-3


SEE = resampler(CAMERAS["fisheye"], fibonacci(150))


def test_batches_and_bands_are_the_loop():
    rng = np.random.default_rng(5)
    images = rng.integers(0, 256, (2, 3, 160, 160, 4), dtype=np.uint8)
    with_bands = SEE(images)
    assert with_bands.shape == (2, 3, 150, 4)
    plain = SEE(images[..., 1])
    assert plain.shape == (2, 3, 150)
    for index in np.ndindex(2, 3):
        np.testing.assert_array_equal(plain[index], SEE(images[(*index, ..., 1)]))
        np.testing.assert_array_equal(with_bands[index], SEE(images[index]))
    np.testing.assert_allclose(with_bands[..., 1], plain, rtol=1e-5)
    assert SEE(images[:0, 0, ..., 0]).shape == (0, 150)


def test_masked_pixels_do_not_count():
    camera, image = CAMERAS["fisheye"], np.full((160, 160), 10.0)
    mask = np.ones((160, 160), dtype=bool)
    mask[:, :80] = False
    image[:, :80] = np.nan
    see = resampler(camera, thesis(), mask=mask)
    values = see(image, unseen=-1.0)
    np.testing.assert_allclose(values[see.seen], 10.0, rtol=1e-6)
    assert (values[~see.seen] == -1.0).all()
    # The left half of a picture that looks up is the animal's right.
    assert see.coverage[thesis().directions[:, 0] > 0.1].max() < 0.02
    assert see.coverage[thesis().directions[:, 0] < -0.1].min() > 0.9
    np.testing.assert_array_equal(see.seen, see.coverage >= 0.5)


def test_masked_sectors_of_the_camera_do_not_count():
    camera = parabolic_mirror((200, 200), 90.0, masked_sectors=((0.2, 0.6),))
    image = np.where(camera.pixels_seen(), 3.0, np.nan)
    see = resampler(camera, equirectangular(5.0, (10.0, 60.0)))
    np.testing.assert_allclose(see(image)[see.seen], 3.0, rtol=1e-6)
    # A mirror does not exchange the sides: its sector at 0.4 rad clockwise from the top hides azimuth 0.4 rad.
    hidden = resampler(camera, directions(0.4, 0.5)[None], acceptance=0.02)
    assert not hidden.seen[0]


def test_full_panorama_has_no_seam():
    camera = panorama(2.0, (-90.0, 90.0))
    image = sight(camera, smooth)
    azimuth = np.pi + np.linspace(-2, 2, 41) * DEGREE
    points = directions(np.remainder(azimuth + np.pi, 2 * np.pi) - np.pi, 0.1)
    see = resampler(camera, points, acceptance=4 * DEGREE)
    assert see.coverage == pytest.approx(1.0)
    np.testing.assert_allclose(see(image), smooth(points), atol=0.004)
    shifted = resampler(camera, to_world(points, rotation_matrix(np.pi)), acceptance=4 * DEGREE)
    np.testing.assert_allclose(see(image), shifted(np.roll(image, 90, axis=1)), atol=2e-3)


def test_turning_the_viewer_is_turning_its_directions():
    camera, points = CAMERAS["panorama"], fibonacci(100).directions
    rotation = rotation_matrix(0.5, 0.3, -0.2)
    turned = resampler(camera, points, acceptance=0.1, rotation=rotation)
    directly = resampler(camera, to_world(points, rotation), acceptance=0.1)
    image = np.random.default_rng(1).uniform(size=camera.size)
    np.testing.assert_allclose(turned(image), directly(image), atol=1e-6)


def test_tilted_camera_sees_what_a_level_one_sees_turned():
    heading, pitch, roll = 0.4, 1.1, -0.6
    level, tilted = (
        fisheye((160, 160), np.pi, mounting=AHEAD),
        fisheye((160, 160), np.pi, mounting=(heading, pitch, roll)),
    )
    points = fibonacci(300).directions
    image = np.random.default_rng(4).uniform(size=(160, 160))
    first = resampler(level, points, acceptance=0.1)
    second = resampler(tilted, to_world(points, rotation_matrix(heading, pitch, roll)), acceptance=0.1)
    # The samples lie otherwise about each direction: √2 of a tenth, by what the resampler says of noise.
    np.testing.assert_allclose(first.coverage, second.coverage, atol=0.05)
    both = first.seen & second.seen
    assert both.sum() > 140
    assert np.std((first(image) - second(image))[both]) < 0.15 * np.std(first(image)[both])


def test_grids_and_eyes_bring_their_own_widths():
    camera = CAMERAS["panorama"]
    grid, eye = fibonacci(200), desert_ant()
    image = np.random.default_rng(2).uniform(size=camera.size)
    same = resampler(camera, grid.directions, acceptance=grid.spacing)
    np.testing.assert_array_equal(resampler(camera, grid)(image), same(image))
    values = resampler(camera, eye)(image)
    np.testing.assert_array_equal(values, resampler(camera, eye.directions, acceptance=eye.acceptance)(image))
    assert np.isfinite(values).all()


def test_grid_of_a_panorama_is_nearly_its_pixels():
    camera = panorama(3.0, (-30.0, 60.0))
    grid = equirectangular(3.0, (-30.0, 60.0))
    image = sight(camera, smooth)
    inner = resampler(camera, grid)(image).reshape(camera.size)[2:-2]
    np.testing.assert_allclose(inner, image[2:-2], atol=2e-3)


def test_camera_that_looks_away_sees_nothing():
    see = resampler(fisheye((50, 50), 1.0, mounting=UPWARDS), directions(0.0, -1.0)[None], acceptance=0.1)
    assert see.coverage.tolist() == [0.0]
    assert np.isnan(see(np.ones((50, 50)))).all()
    assert great_circle_angle([0, 0, 1], directions(0.0, -1.0)) > 2.5


IMAGE = np.zeros((160, 160))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: SEE(IMAGE[:100]), r"images have shape \(100, 160\), expected \(..., 160, 160\)"),
        (lambda: resampler(CAMERAS["equisolid"], fibonacci(9))(np.zeros((200, 160))), "turned by 90"),
        (lambda: SEE(IMAGE.astype(str)), "images hold str"),
        (lambda: SEE(IMAGE.astype(complex)), "images hold complex128 values"),
        (lambda: resampler(CAMERAS["fisheye"], np.eye(3)), "acceptance is missing"),
        (lambda: resampler(CAMERAS["fisheye"], np.eye(3), acceptance=5.0), "acceptance is 5.*degrees"),
        (lambda: resampler(CAMERAS["fisheye"], np.eye(3), acceptance=[0.1, 0.1]), "acceptance has shape"),
        (lambda: resampler(CAMERAS["fisheye"], 3 * np.eye(3), acceptance=0.1), "directions has a vector of length 3"),
        (lambda: resampler(CAMERAS["fisheye"], np.eye(3)[0], acceptance=0.1), r"directions has shape \(3,\)"),
        (lambda: resampler(CAMERAS["fisheye"], fibonacci(9), mask=IMAGE[1:]), "mask has shape"),
        (lambda: resampler(CAMERAS["fisheye"], fibonacci(9), rotation=np.eye(2)), "rotation has shape"),
        (lambda: resampler(CAMERAS["fisheye"], fibonacci(9), n_samples=0), "n_samples is 0"),
        (lambda: resampler(CAMERAS["fisheye"], fibonacci(9), least_coverage=2.0), "least_coverage is 2"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message: str):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_large_grid_is_worked_on_in_parts():
    camera = CAMERAS["panorama"]
    grid = fibonacci(9000)  # more samples than are worked on together
    image = sight(camera, smooth)
    whole = resampler(camera, grid)
    some = SphereGrid(name="some", directions=grid.directions[::100], weights=grid.weights[::100])
    np.testing.assert_allclose(whole(image)[::100], resampler(camera, some, acceptance=grid.spacing)(image), rtol=1e-6)
