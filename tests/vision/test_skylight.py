"""Sky in photographs: real ones with their floor, and made ones that brightness alone gets wrong."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.metrics.segmentation import accuracy, intersection_over_union
from insectnav.vision.sky_segmentation import segment
from insectnav.vision.skylight import AHEAD
from sky_scenes import DATA, disk, hills, photographs

SETS = {  # ending of the masks, view, and the least mean accuracy, mean IoU and worst accuracy
    "camvid_sky": ("_sky", {"view": "ahead"}, (0.98, 0.88, 0.90)),
    "fisheye_sky": ("_mask", {"view": "up", "radius": 0.92 * 160}, (0.90, 0.79, 0.77)),
}


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is missing")
@pytest.mark.parametrize("step", [pytest.param(1, marks=pytest.mark.slow), 6])
@pytest.mark.parametrize("name", SETS)
def test_real_photographs_are_segmented_as_well_as_promised(name, step):
    ending, view, (mean, overlap, worst) = SETS[name]
    rates, overlaps = [], []
    for picture, sky, known in photographs(name, ending, step):
        found = segment(picture, "skylight", **view)
        counts = known & found.valid
        rates.append(accuracy(found.mask, sky, counts))
        overlaps.append(intersection_over_union(found.mask, sky, counts))
    few = 0.01 if step > 1 else 0.0  # the mean of a dozen photographs is less certain
    assert np.mean(rates) >= mean - few
    assert np.mean(overlaps) >= overlap - 3 * few
    assert min(rates) >= worst


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is missing")
def test_watershed_of_streets_is_as_good_as_known():
    rates = []
    for picture, sky, known in photographs("camvid_sky", "_sky", 2):
        rates.append(accuracy(segment(picture, "watershed", channels="grey").mask, sky, known))
    assert np.mean(rates) > 0.945  # known from elsewhere: 0.955 over all of them


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is missing")
def test_otsu_of_grey_is_as_known():
    sets = (("camvid_sky", "_sky", {}, 0.922), ("fisheye_sky", "_mask", SETS["fisheye_sky"][1], 0.741))
    for name, ending, view, expected in sets:
        rates = []
        for picture, sky, known in photographs(name, ending, 1):
            found = segment(picture, "otsu", channels="grey", **view)
            rates.append(accuracy(found.mask, sky, known & found.valid))
        assert np.mean(rates) == pytest.approx(expected, abs=0.002)


def test_wall_in_the_sun_is_no_sky():
    scene = hills()
    wall = np.zeros(scene.sky.shape, bool)
    wall[15:60, 5:25] = True
    picture = scene.picture.copy()
    picture[wall] = np.random.default_rng(0).normal([250, 235, 200], 5, (wall.sum(), 3)).clip(0, 255).astype(np.uint8)
    sky = scene.sky & ~wall
    assert (segment(picture, "skylight").mask != sky).mean() < 0.01
    assert segment(picture, "otsu").mask[wall].mean() > 0.9


def test_bright_ground_that_does_not_reach_the_top_is_no_sky():
    scene = hills()
    picture = scene.picture.copy()
    picture[45:55, 30:60] = (150, 180, 230)  # water that mirrors the sky
    assert not segment(picture, "skylight").mask[45:55, 30:60].any()
    assert segment(picture, "otsu").mask[46:54, 31:59].all()


def test_patch_of_sky_apart_is_kept_where_the_camera_looks_up():
    scene = disk()
    picture, sky = scene.picture.copy(), scene.sky.copy()
    ring = (np.hypot(*(np.mgrid[:90, :90] + 0.5 - 45)) > 36) & (np.hypot(*(np.mgrid[:90, :90] + 0.5 - 45)) < 43)
    patch = ring & (np.mgrid[:90, :90][0] > 62) & ~sky
    picture[patch] = (150, 180, 230)
    found = segment(picture, "skylight", view="up")
    assert found.mask[patch].mean() > 0.8


def test_large_picture_is_segmented_as_a_small_one():
    scene = hills()
    large = np.repeat(np.repeat(scene.picture, 15, axis=0), 15, axis=1)  # 900 × 1200, reduced to 320 rows
    found = segment(large, "skylight").mask
    assert found.shape == large.shape[:2]
    assert (found != np.repeat(np.repeat(scene.sky, 15, axis=0), 15, axis=1)).mean() < 0.01


def test_picture_without_colour_may_be_used():
    scene = hills()
    assert (segment(scene.picture[..., 2], "skylight").mask != scene.sky).mean() < 0.01


def test_constants_out_of_range_are_refused():
    with pytest.raises(InputError, match="texture_weight"):
        replace(AHEAD, texture_weight=-1.0)
    with pytest.raises(InputError, match="working_side"):
        replace(AHEAD, working_side=3)
