"""A railway in summer and in winter: the figures that the documentation gives, and the plain way beside them."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import seqslam_oracle
from insectnav.matching import OPENSEQSLAM_V1, SeqSlamParams, difference_matrix, seqslam
from insectnav.metrics.retrieval import (
    area_under_curve,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
    right_matches,
)
from insectnav.vision.descriptors import patch_normalised
from real_routes import nordland

pytestmark = pytest.mark.data


@pytest.fixture(scope="module")
def seasons():
    return nordland("summer"), nordland("winter")


def measure(matches, tolerance=2):
    """Precision keeping all, recall at full precision, and area, of queries at their own number."""
    right = right_matches(matches.reference, np.arange(len(matches.reference)), tolerance)
    curve = precision_recall(right, matches.score)
    return precision_at_full_recall(curve), recall_at_full_precision(curve), area_under_curve(curve)


def describe(images, kind):
    if kind == "unrounded":
        return patch_normalised(images)
    return patch_normalised(images, rounded=True, flat_patch=127 if kind == "neutral" else 0)


@pytest.mark.parametrize("ds", [10, 20])
def test_v1_and_the_plain_way_give_the_same_matches(seasons, ds):
    summer, winter = (images[::10] for images in seasons)
    patches = [
        np.array([seqslam_oracle.patch_normalise(image).ravel() for image in images]) for images in (summer, winter)
    ]
    difference = seqslam_oracle.difference(*patches)
    expected = seqslam_oracle.search(seqslam_oracle.enhance(difference), ds)
    found_difference = difference_matrix(describe(summer, "v1"), describe(winter, "v1"), "openseqslam-v1")
    assert_allclose(found_difference, difference, rtol=1e-7)
    found = seqslam(difference, replace(OPENSEQSLAM_V1, sequence_length=ds))
    assert_array_equal(np.where(found.reference < 0, np.nan, found.reference), expected[:, 0])
    assert_allclose(found.score, expected[:, 1], rtol=0, atol=1e-12)
    assert_array_equal(
        seqslam(found_difference, replace(OPENSEQSLAM_V1, sequence_length=ds)).reference, found.reference
    )


@pytest.mark.parametrize("ds", [10, 20])
def test_images_to_matches_are_those_of_openseqslam(seasons, golden, ds):
    stored = golden("openseqslam_v1_nordland_100_399")
    patches = [describe(images[stored["frame"]], "v1") for images in seasons]
    difference = difference_matrix(*patches, "openseqslam-v1")
    assert_array_equal(difference, stored["difference"])
    found, expected = seqslam(difference, replace(OPENSEQSLAM_V1, sequence_length=ds)), stored[f"matches_ds{ds}"]
    assert_array_equal(np.where(found.reference < 0, np.nan, found.reference), expected[:, 0])
    assert_allclose(found.score, expected[:, 1], rtol=0, atol=1e-12)


@pytest.mark.parametrize(("every", "ds"), [(1, 10), (1, 20), (3, 10), (5, 10), (10, 10), (10, 20)])
def test_the_default_is_better_than_v1(seasons, every, ds):
    summer, winter = (images[::every] for images in seasons)
    v1 = difference_matrix(describe(summer, "v1"), describe(winter, "v1"), "openseqslam-v1")
    ours = difference_matrix(describe(summer, "unrounded"), describe(winter, "unrounded"))
    before = measure(seqslam(v1, replace(OPENSEQSLAM_V1, sequence_length=ds)))
    after = measure(seqslam(ours, SeqSlamParams(sequence_length=ds)))
    assert all(np.greater(after, before))


def test_flat_patches_are_what_costs_v1_most(seasons):
    summer, winter = (images[::10] for images in seasons)
    v1, neutral = (
        measure(seqslam(difference_matrix(describe(summer, k), describe(winter, k), "openseqslam-v1"), OPENSEQSLAM_V1))
        for k in ("v1", "neutral")
    )
    assert neutral == (1, 1, 1)
    assert_allclose(v1, (0.791, 0.736, 0.788), atol=5e-4)


def test_duplicate_frames_at_the_start_leave_no_nan(seasons):
    summer, winter = (describe(images[:120], "unrounded") for images in seasons)  # seventeen equal frames of each
    for params in (SeqSlamParams(), OPENSEQSLAM_V1):
        found = seqslam(difference_matrix(summer, winter), params)
        assert np.isfinite(found.score[5:-5]).all()
        assert (found.reference[5:-5] >= 0).all()
