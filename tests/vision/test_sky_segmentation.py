"""Masks of made scenes by every method: what must not matter, which side is sky, what is left out, what is refused."""

import warnings

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from sklearn.cluster import KMeans
from sklearn.mixture import GaussianMixture

from insectnav.checks import InputError
from insectnav.vision import fisheye
from insectnav.vision.sky_channels import features, uv_green
from insectnav.vision.sky_confidence import DOUBTFUL, confidence
from insectnav.vision.sky_geometry import LEFT_OUT, geometry
from insectnav.vision.sky_segmentation import METHODS, segment
from insectnav.vision.sky_training import best_threshold, label_counts, train_threshold
from sky_scenes import disk, hills

AUTOMATIC = [method for method in METHODS if method != "fixed"]
THRESHOLDED = ["otsu", "watershed", "watershed-islands"]
HILLS, DISK = hills(), disk()


def right(found, sky) -> float:
    return float((found.mask == sky)[found.valid].mean())


@pytest.mark.parametrize("method", AUTOMATIC)
def test_sky_above_hills_is_found(method):
    found = segment(HILLS.picture, method)
    assert right(found, HILLS.sky) > 0.995
    assert found.confidence > 0.9
    assert found.is_sky_brighter
    assert abs(found.sky_fraction - HILLS.sky.mean()) < 0.005


@pytest.mark.parametrize("dtype", [np.uint16, np.float32, np.float64, np.int32])
@pytest.mark.parametrize("method", AUTOMATIC)
def test_type_and_unit_of_the_picture_do_not_matter(method, dtype):
    factor = {np.uint16: 257, np.int32: 31}.get(dtype, 1 / 255)
    scaled = (HILLS.picture * float(factor)).astype(dtype)
    assert right(segment(scaled, method), segment(HILLS.picture, method).mask) > 0.999


@pytest.mark.parametrize("method", THRESHOLDED)
def test_threshold_is_in_the_unit_of_the_picture(method):
    grey = HILLS.picture[..., 2]
    bytes_, deep = segment(grey, method).threshold, segment(grey.astype(np.uint16) * 257, method).threshold
    assert 60 < bytes_ < 220
    assert deep / 257 == pytest.approx(bytes_, abs=1.5)
    assert_array_equal(segment(grey, method).mask, grey > bytes_)


@pytest.mark.parametrize("method", [one for one in AUTOMATIC if one != "skylight"])
def test_geometry_says_which_side_is_sky(method):
    grey = HILLS.picture[..., 2]
    found = segment(255 - grey, method)  # snow below a dark sky
    assert not found.is_sky_brighter
    assert right(found, HILLS.sky) > 0.995
    upside_down = segment(grey[::-1], method)
    assert right(upside_down, ~HILLS.sky[::-1]) > 0.995


@pytest.mark.parametrize("method", AUTOMATIC)
def test_round_picture_that_looks_up(method):
    for options in ({"view": "up"}, {"camera": fisheye((90, 90), np.pi)}):
        found = segment(DISK.picture, method, **options)
        assert right(found, DISK.sky) > 0.99
        assert not found.mask[~found.valid].any()
        assert 0.77 < found.valid.mean() < 0.80  # π / 4 of the square


@pytest.mark.parametrize("method", AUTOMATIC)
def test_what_is_left_out_does_not_matter(method):
    used = np.ones(HILLS.sky.shape, bool)
    used[15:30, 20:40] = False
    blank, garbage = HILLS.picture.copy(), HILLS.picture.copy()
    blank[~used], garbage[~used] = 0, 255
    one, other = (segment(picture, method, valid=used) for picture in (blank, garbage))
    assert_array_equal(one.mask, other.mask)
    assert one.threshold == pytest.approx(other.threshold, rel=1e-6)
    assert one.confidence == pytest.approx(other.confidence, rel=1e-6)
    assert_array_equal(one.valid, used)
    assert right(one, HILLS.sky) > 0.995


def test_masked_sector_of_a_camera_is_left_out():
    camera = fisheye((90, 90), np.pi)
    camera = type(camera)(**(vars(camera) | {"masked_sectors": ((0.0, 0.5),)}))
    found = segment(DISK.picture, "otsu", camera=camera)
    down, rightwards = np.mgrid[:90, :90] + 0.5 - 45
    inside = (np.hypot(down, rightwards) <= 45) & (np.arctan2(rightwards, -down) % (2 * np.pi) > 0.5)
    assert (found.valid != inside).mean() < 0.002


@pytest.mark.parametrize("channels", ["mean", "rgb", "lab-ab"])
def test_kmeans_is_that_of_scikit_learn(channels):
    points = features(HILLS.picture, channels).reshape(-1, {"mean": 1}.get(channels, 3 if channels == "rgb" else 2))
    theirs = KMeans(2, n_init=7, random_state=0).fit_predict(points)
    ours = segment(HILLS.picture, "kmeans", channels=channels).mask.ravel()
    assert max((ours == theirs).mean(), (ours != theirs).mean()) > 0.9999


def test_mixture_is_that_of_scikit_learn():
    points = features(HILLS.picture, "rgb").reshape(-1, 3).astype(float)
    theirs = GaussianMixture(2, random_state=0).fit(points).predict(points)
    ours = segment(HILLS.picture, "gmm").mask.ravel()
    assert max((ours == theirs).mean(), (ours != theirs).mean()) > 0.9999


def test_kmeans_threshold_of_one_channel_is_midway_between_the_means():
    grey = HILLS.picture[..., 2]
    found = segment(grey, "kmeans")
    middle = (grey[found.mask].mean() + grey[~found.mask].mean()) / 2
    assert found.threshold == pytest.approx(middle, abs=0.5)


def test_uv_and_green_are_two_bands():
    found = segment(uv_green(HILLS.picture[..., 2], HILLS.picture[..., 1]), "kmeans")
    assert found.channels == "uv-green"
    assert right(found, HILLS.sky) > 0.995


@pytest.mark.parametrize("method", AUTOMATIC)
def test_noise_has_no_confidence(method):
    noise = np.random.default_rng(2).integers(100, 140, (60, 80, 3)).astype(np.uint8)
    assert segment(noise, method).confidence < (DOUBTFUL if method == "skylight" else 0.1)


@pytest.mark.parametrize("method", ["otsu", "watershed", "kmeans", "skylight"])
def test_a_sky_alone_is_doubtful(method):
    rng = np.random.default_rng(4)
    gradient = np.linspace(220, 120, 60)[:, None, None] * [0.7, 0.85, 1.0]  # darker towards the zenith or the horizon
    for way in (1, -1):
        whole = np.clip(gradient[::way] + rng.normal(0, 1.5, (60, 80, 3)), 0, 255).astype(np.uint8)
        assert segment(whole, method).confidence < DOUBTFUL


@pytest.mark.parametrize("value", [0, 90, 255])
@pytest.mark.parametrize("method", AUTOMATIC)
def test_one_grey_level_is_refused(method, value):
    for picture in (np.full((30, 40, 3), value, np.uint8), np.full((30, 40), value / 255)):
        with pytest.raises(InputError, match="expected sky and ground"):
            segment(picture, method)


def test_fixed_threshold_may_find_all_sky_or_none_without_confidence():
    for value, expected in ((250, True), (3, False)):
        found = segment(np.full((30, 40), value, np.uint8), "fixed", threshold=128)
        assert (found.mask == expected).all()
        assert found.confidence == 0.0


def test_flare_is_left_out():
    glaring = HILLS.picture.copy()
    glaring[45:52, 40:50] = 255  # the sun mirrored by a roof
    found = segment(glaring, "otsu", leave_out_flare=True)
    assert not found.valid[45:52, 39:51].any()
    assert not found.valid[44:53, 40:50].any()
    assert found.valid.mean() > 0.95
    assert right(found, HILLS.sky) > 0.995
    assert segment(glaring, "otsu").mask[45:52, 40:50].all()
    with pytest.raises(InputError, match="flare covers the whole image"):
        segment(np.where(HILLS.sky, 255, 254).astype(np.uint8), "otsu", leave_out_flare=True)


def test_histogram_without_valley_is_told():
    triangle = np.random.default_rng(0).triangular(20, 60, 100, (200, 300))
    found = segment(triangle.astype(np.float32), "watershed")
    assert found.notes
    assert found.confidence == 0.0


def test_trained_threshold_is_the_best_of_all_tried():
    scenes = [hills(seed=k, noise=45.0) for k in range(3)]
    threshold = train_threshold([s.picture for s in scenes], [s.sky for s in scenes], channels="blue") * 255
    blue, sky = (np.concatenate([getattr(s, name).reshape(60 * 80, -1) for s in scenes]) for name in ("picture", "sky"))
    rates = [((blue[:, 2] > t) == sky[:, 0]).mean() for t in np.arange(256)]
    assert ((blue[:, 2] > threshold) == sky[:, 0]).mean() == pytest.approx(max(rates))
    found = segment(scenes[0].picture, "fixed", channels="blue", threshold=threshold)
    assert right(found, scenes[0].sky) > 0.9


def test_training_refuses_sky_alone_and_other_sizes():
    with pytest.raises(InputError, match="only one of sky and ground"):
        best_threshold(label_counts(HILLS.picture, np.ones(HILLS.sky.shape, bool)))
    with pytest.raises(InputError, match="another picture"):
        label_counts(HILLS.picture, HILLS.sky[:-1])
    with pytest.raises(InputError, match="whole numbers"):
        label_counts(HILLS.picture.astype(float), HILLS.sky)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "otso"}, "did you mean otsu"),
        ({"method": "fixed"}, "threshold is missing"),
        ({"method": "otsu", "threshold": 3.0}, "with method fixed alone"),
        ({"method": "otsu", "view": "down"}, "view"),
        ({"method": "otsu", "radius": 3.0}, "radius"),
        ({"method": "otsu", "channels": "rgb"}, "more than one"),
        ({"method": "skylight", "channels": "lab-ab"}, "skylight takes rgb or one channel"),
        ({"method": "otsu", "camera": fisheye((10, 10), np.pi)}, "another camera"),
        ({"method": "otsu", "valid": np.ones((3, 3), bool)}, "another picture's mask"),
        ({"method": "otsu", "valid": np.zeros((60, 80), bool)}, "0 pixels"),
        ({"method": "otsu", "valid": np.arange(60 * 80).reshape(60, 80)}, "different values"),
        ({"method": "kmeans", "seed": -1}, "seed"),
    ],
)
def test_what_cannot_be_done_is_refused(options, words):
    with pytest.raises(InputError, match=words):
        segment(HILLS.picture, **options)


def test_the_same_seed_gives_the_same_bits_and_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for method in AUTOMATIC:
            assert_array_equal(segment(HILLS.picture, method).mask, segment(HILLS.picture, method).mask)


def test_picture_is_not_changed():
    picture = HILLS.picture.copy()
    for method in AUTOMATIC:
        segment(picture, method)
    assert_array_equal(picture, HILLS.picture)


def test_confidence_is_the_product_of_its_parts_in_closed_form():
    sky = np.zeros((64, 64), bool)
    sky[:16] = True
    values, levels = np.where(sky, 200.0, 100.0).astype(np.float32), geometry((64, 64)).levels
    assert confidence(values, sky, levels) == (1.0, 1.0, 1.0, 1.0, 1.0)
    gentle = values.copy()
    gentle[14:18] = np.array([170, 160, 150, 140])[:, None]  # 30 across four rows, of means that differ by about 85
    difference = gentle[sky].mean() - gentle[~sky].mean()
    assert confidence(gentle, sky, levels).edge == pytest.approx(30 / (difference / 2))
    speck = np.zeros((64, 64), bool)
    speck[:3, :3] = True
    assert confidence(values, speck, levels).balance == pytest.approx(9 / 4096 / 0.01)
    assert confidence(values, ~sky, levels).total == 0.0
    half = np.zeros((64, 64), bool)
    half[:, :32] = True  # neither above the other
    assert confidence(values, half, levels).geometry == 0.0
    assert confidence(values, np.zeros_like(sky), levels).total == 0.0


def test_levels_rise_towards_the_zenith():
    ahead = geometry((64, 4)).levels
    assert (np.diff(ahead.astype(int), axis=0) <= 0).all()
    assert (ahead[0, 0], ahead[-1, 0]) == (31, 0)
    up = geometry((65, 65), view="up", radius=30.0).levels
    assert up[32, 32] == 31
    assert up[0, 0] == LEFT_OUT
    assert (up != LEFT_OUT).sum() == pytest.approx(np.pi * 30**2, rel=0.01)
