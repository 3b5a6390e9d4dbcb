"""Views through cameras in any pose: the buffer of depths against rays, panoramas against cameras, bad input."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.vision import fisheye, panorama
from insectnav.vision.cameras import AHEAD, Camera
from insectnav.worlds import render, render_layers
from insectnav.worlds.views import whole_panorama
from solid_shapes import box, soup, wall, world_of

LAYERS = ("grey", "sky", "alpha", "nearness", "depth", "triangle")


def some_eyes(seed: int, n: int = 3):
    rng = np.random.default_rng(seed)
    positions = np.column_stack([rng.uniform(-6, 6, (n, 2)), rng.uniform(0.05, 2.0, n)])
    return positions, *rng.uniform(-1.2, 1.2, (3, n))


def test_a_level_panorama_is_the_same_by_camera_and_by_degrees():
    world, (positions, headings, _, _) = world_of(soup(3)), some_eyes(3)
    through = render(world, positions, headings, camera=panorama(3.0, (-15.0, 90.0)), layers=LAYERS, supersampling=2)
    straight = render_layers(
        world, positions, headings, LAYERS, resolution_deg=3.0, elevation_deg=(-15.0, 90.0), supersampling=2
    )
    for layer in LAYERS:
        assert_array_equal(through[layer], straight[layer])


@pytest.mark.parametrize("seed", range(3))
def test_a_tilted_panorama_equals_rays(seed):
    """The compiled buffer with the world turned about the eye, against Embree; edges may differ by rounding."""
    world, eyes = world_of(soup(seed)), some_eyes(seed)
    camera = panorama(2.0, (-90.0, 90.0))
    drawn = render(world, *eyes, camera=camera, layers=LAYERS, supersampling=1)
    cast = render(world, *eyes, directions=camera.pixel_directions(), layers=LAYERS)
    same = drawn["triangle"] == cast["triangle"]
    assert (~same).mean() < 2e-4
    for layer in ("grey", "sky", "alpha"):
        assert_array_equal(drawn[layer][same], cast[layer][same])
    assert_allclose(drawn["nearness"][same], cast["nearness"][same], rtol=2e-4)


def test_layers_are_means_over_the_samples_of_a_pixel():
    world, (position, *pose) = world_of(soup(5)), some_eyes(5, 1)
    coarse = render(world, position, *pose, camera=panorama(6.0, (-30.0, 90.0)), layers=LAYERS, supersampling=4)
    fine = render(world, position, *pose, camera=panorama(1.5, (-30.0, 90.0)), layers=LAYERS, supersampling=1)
    for layer in ("grey", "sky", "alpha", "nearness"):
        blocks = fine[layer][0].reshape(coarse[layer].shape[1], 4, coarse[layer].shape[2], 4)
        assert_allclose(coarse[layer][0], blocks.mean(axis=(1, 3)), atol=1e-6)
    is_far = coarse["nearness"] == 0
    assert np.isinf(coarse["depth"][is_far]).all()
    assert_allclose(coarse["depth"][~is_far], 1 / coarse["nearness"][~is_far], rtol=1e-6)


def test_a_fisheye_sees_what_lies_in_its_directions():
    world, (positions, *pose) = world_of(soup(7)), some_eyes(7)
    camera = fisheye((40, 50), np.deg2rad(160.0))
    view = render(world, positions, *pose, camera=camera, layers=("grey", "sky"), supersampling=1)
    seen = camera.pixels_seen()
    along = render(world, positions, *pose, directions=camera.pixel_directions()[seen], layers=("grey", "sky"))
    assert view["grey"].shape == (3, 40, 50)
    for layer in ("grey", "sky"):
        assert_array_equal(view[layer][:, seen], along[layer])
        assert (view[layer][:, ~seen] == 0).all()


def test_a_pinhole_picture_is_flat():
    """A wall at right angles to the axis: its upper edge is a straight row, at f · height / distance."""
    camera = Camera(model="pinhole", size=(60, 80), focal_length=(50, 50), centre=(40, 30), field=(0, 1.2))
    world = world_of(wall(-40, 10, 40, 10, 3.05))
    sky = render(world, [[0.0, 0.0, 1.0]], camera=camera, layers=("sky",), supersampling=8)["sky"][0]
    assert_allclose((1 - sky).sum(axis=0), np.full(80, 50 * 2.05 / 10 + 30), atol=1 / 8)


def test_workers_and_batches_change_nothing():
    world, (positions, *pose) = world_of(soup(1)), some_eyes(1, 5)
    camera = panorama(10.0, (-30.0, 90.0))
    together = render(world, positions, *pose, camera=camera, layers=LAYERS, supersampling=2, workers=2)
    for i in range(5):
        one = (angle[i] for angle in pose)
        alone = render(world, positions[i : i + 1], *one, camera=camera, layers=LAYERS, supersampling=2, workers=1)
        for layer in LAYERS:
            assert_array_equal(together[layer][i], alone[layer][0])


def test_only_whole_panoramas_are_panoramas():
    assert whole_panorama(panorama(2.0, (-30.0, 60.0))) == (2.0, (-30.0, 60.0))
    assert whole_panorama(fisheye((40, 40), 3.0)) is None
    half = Camera(model="equirectangular", size=(45, 90), focal_length=(90 / np.pi, 90 / np.pi), centre=(45, 45))
    assert whole_panorama(half) is None
    turned = Camera(
        model="equirectangular", size=(45, 180), focal_length=(90 / np.pi, 90 / np.pi), centre=(90, 45),
        field=(0, np.pi), mounting=(0.3, *AHEAD[1:]),
    )  # fmt: skip
    assert whole_panorama(turned) is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"camera": None}, "neither a camera nor directions are given"),
        ({"directions": [(0, 0, 1)]}, "both a camera and directions are given, expected one of the two"),
        ({"supersampling": 3}, "supersampling is '3', expected one of 1, 2, 4, 8"),
        ({"layers": ("uv",)}, "layer 'uv' is unknown: expected one of grey, sky"),
        ({"pitch": 30}, "pitch is 30, expected radians within ±2π: degrees?"),
        ({"positions": [[0, 0, -1]]}, "position 0 has the eye -1 m high, expected above the ground"),
        ({"positions": [[60, 0]]}, "position 0 at (60, 0) m lies outside the world"),
        ({"positions": [[9.1, 9.2, 0.5]]}, "position 0 at (9.1, 9.2, 0.5) m is inside a solid"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(changes, words):
    arguments = {
        "positions": [[0, 0]],
        "camera": panorama(10.0, (-30.0, 90.0)),
        "layers": ("grey",),
        "supersampling": 1,
    } | changes
    with pytest.raises(InputError) as caught:
        render(world_of(box(9, 9, 2, 2)), **arguments)
    assert words in str(caught.value)
    assert str(caught.value).count(". ") == 0
