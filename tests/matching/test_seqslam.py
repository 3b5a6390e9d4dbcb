from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import seqslam_oracle
from insectnav.checks import InputError
from insectnav.matching import OPENSEQSLAM_V1, SeqSlamParams, difference_matrix, enhance_contrast, seqslam

RNG = np.random.default_rng(0)
NOISE = RNG.random((60, 45))


def route(speed=1.0, n=60, start=20.0, noise=0.05, seed=1, n_references=150):
    """Difference of a route and a drive along it at a speed, and the true reference of each query."""
    rng = np.random.default_rng(seed)
    references = np.cumsum(rng.normal(size=(n_references, 40)), axis=0)
    place = start + speed * np.arange(n)
    low = np.floor(place).astype(int)
    share = (place - low)[:, None]
    queries = references[low] * (1 - share) + references[low + 1] * share
    return difference_matrix(references, queries + noise * rng.normal(size=queries.shape), "euclidean"), place


@pytest.mark.parametrize("ds", [2, 7, 10, 12, 20])
@pytest.mark.parametrize("window", [4, 10])
def test_v1_agrees_with_the_plain_way(ds, window):
    params = replace(OPENSEQSLAM_V1, sequence_length=ds, contrast_window=window, unique_window=window)
    expected = seqslam_oracle.enhance(NOISE, window)
    assert_allclose(enhance_contrast(NOISE, params), expected, rtol=1e-12, atol=1e-12)
    found = seqslam(NOISE, params)
    matches = seqslam_oracle.search(expected, ds + ds % 2, window)
    assert_array_equal(np.where(found.reference < 0, np.nan, found.reference), matches[:, 0])
    assert_allclose(found.score, matches[:, 1], rtol=1e-10)


@pytest.mark.data
@pytest.mark.parametrize("ds", [10, 20])
def test_v1_agrees_with_openseqslam(ds, golden):
    stored = golden("openseqslam_v1_nordland_100_399")
    params = replace(OPENSEQSLAM_V1, sequence_length=ds)
    expected = stored[f"matches_ds{ds}"]
    found = seqslam(stored["difference"], params)
    assert_array_equal(np.where(found.reference < 0, np.nan, found.reference), expected[:, 0])
    assert_allclose(found.score, expected[:, 1], rtol=0, atol=1e-12)
    assert_allclose(enhance_contrast(stored["difference"], params), stored["enhanced"], rtol=0, atol=3e-7)


@pytest.mark.parametrize("speed", [0.8, 0.9, 1.0, 1.1, 1.2])
def test_a_drive_is_found_with_its_speed(speed):
    difference, place = route(speed)
    found = seqslam(difference)
    inner = slice(5, -5)
    assert np.abs(found.reference - place)[inner].max() <= 2
    assert abs(np.median(found.speed[inner]) - speed) <= 0.1
    assert found.score[inner].max() < 0.6


def test_where_the_line_runs_is_nearer_than_start_plus_half():
    difference, place = route(1.2)
    params = SeqSlamParams(sequence_length=40)
    on_line, as_v1 = (seqslam(difference, replace(params, place=place_)) for place_ in ("line", "start"))
    inner = slice(20, -20)
    assert_array_equal(on_line.score, as_v1.score)
    error, error_v1 = (np.abs(found.reference - place)[inner].mean() for found in (on_line, as_v1))
    assert error < 1.5
    assert error_v1 > 2.5  # 20 frames at 0.2 too slow


@settings(deadline=None, max_examples=20)
@given(st.floats(0.01, 100), st.floats(-5, 5))
def test_scale_and_offset_of_differences_change_nothing(scale, offset):
    difference, _ = route()
    still, moved = seqslam(difference), seqslam(scale * difference.astype(float) + offset)
    assert_array_equal(still.reference, moved.reference)
    assert_allclose(still.score, moved.score, atol=1e-4)


def test_contrast_is_never_negative_and_its_bound_is_reached():
    for window in (2, 5, 10):
        params = SeqSlamParams(contrast_window=window)
        assert enhance_contrast(NOISE, params).min() >= 0
        spike = np.ones((31, 12))
        spike[15] = 0
        assert_allclose(enhance_contrast(spike, params)[15], 0, atol=1e-12)


def test_single_frames():
    difference, place = route()
    found = seqslam(difference, SeqSlamParams(sequence_length=1))
    assert (np.abs(found.reference - place) <= 1).mean() > 0.7
    contrast = enhance_contrast(difference, SeqSlamParams(sequence_length=1))
    assert_array_equal(found.reference, contrast.argmin(axis=0))
    best = contrast.min(axis=0)
    far = np.abs(np.arange(150)[:, None] - found.reference) > 5
    assert_allclose(found.score, best / np.where(far, contrast, np.inf).min(axis=0), rtol=1e-12)
    assert_array_equal(found.speed, 0)


def test_threads_and_memory_order_change_nothing():
    difference, _ = route(n=100)
    for params in (SeqSlamParams(), OPENSEQSLAM_V1):
        one = seqslam(difference, params, workers=1)
        for other in (seqslam(difference, params, workers=3), seqslam(np.ascontiguousarray(difference), params)):
            for a, b in zip(one, other, strict=True):
                assert_array_equal(a, b)


def test_queries_without_a_whole_sequence_have_no_match():
    found = seqslam(NOISE)
    is_none = np.ones(45, bool)
    is_none[5:-5] = False
    assert_array_equal(found.reference == -1, is_none)
    assert_array_equal(np.isnan(found.score), is_none)
    assert_array_equal(np.isnan(found.speed), is_none)


def test_a_sequence_as_long_as_the_queries_has_one_match():
    assert_array_equal(np.flatnonzero(seqslam(NOISE[:, :11]).reference >= 0), [5])


def test_missing_frames_are_bridged():
    difference, place = route(noise=0.01)
    whole = seqslam(difference)
    broken = difference.copy()
    broken[:, [12, 30, 31]] = np.nan  # corrupt images of the drive
    broken[[35, 60]] = np.nan  # and of the map
    found = seqslam(broken)
    assert_array_equal(found.reference >= 0, whole.reference >= 0)
    inner = slice(5, -5)
    assert np.abs(found.reference - place)[inner].max() <= 2
    assert np.isfinite(enhance_contrast(broken)).all()


def test_missing_frames_touch_no_match_that_does_not_see_them():
    whole = seqslam(NOISE)
    broken = NOISE.copy()
    broken[:, 20] = np.nan
    found = seqslam(broken)
    sees = np.abs(np.arange(45) - 20) <= 5
    assert_array_equal(found.reference[~sees], whole.reference[~sees])
    assert_array_equal(found.score[~sees], whole.score[~sees])
    assert np.isfinite(found.score[5:-5]).all()


def test_too_many_missing_frames_leave_no_match():
    broken = NOISE.copy()
    broken[:, 15:30] = np.nan
    found = seqslam(broken)
    seen = np.convolve(~np.isnan(broken).all(axis=0), np.ones(11), "valid")
    assert_array_equal(found.reference[5:-5] >= 0, seen >= 5.5)
    assert (seqslam(np.full((30, 30), np.nan)).reference == -1).all()


def test_what_has_no_contrast_has_no_match():
    for constant in (np.zeros((40, 30)), np.full((40, 30), 0.1), np.full((40, 30), 0.3, np.float32)):
        for params in (SeqSlamParams(), OPENSEQSLAM_V1):
            found = seqslam(constant, params)
            assert np.isfinite(enhance_contrast(constant, params)).all()
            assert (found.reference == -1).all()
            assert np.isnan(found.score).all()


def test_differences_that_are_rounding_are_no_contrast():
    rounding = np.float32(0.25) * (1 + 1e-7 * RNG.choice([-1, 0, 1], size=(40, 30)))
    assert (seqslam(rounding.astype(np.float32)).reference == -1).all()


def test_a_standing_train_leaves_other_places_as_they_are():
    difference, place = route()
    standing = np.concatenate([np.repeat(difference[:1], 15, axis=0), difference])  # a map with fifteen equal frames
    found = seqslam(standing)
    assert np.abs(found.reference - 15 - place)[5:-5].max() <= 2
    assert np.isfinite(found.score[5:-5]).all()


def test_frames_out_of_order_are_not_matched_surely():
    difference, place = route()
    order = np.random.default_rng(2).permutation(60)
    found = seqslam(difference[:, order])
    right = np.abs(found.reference - place[order])[5:-5] <= 2
    assert right.mean() < 0.5
    assert np.median(found.score[5:-5]) > 1.5 * np.median(seqslam(difference).score[5:-5])


def test_too_short_a_map_leaves_no_rival_and_no_match():
    found = seqslam(NOISE[:11])
    assert (found.reference == -1).all()


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: seqslam(NOISE[:10]), "there are 10 references, expected at least 11 for sequences of 10 steps"),
        (lambda: seqslam(NOISE[:, :10]), "there are 10 queries, expected at least 11 for sequences of 10 steps"),
        (lambda: seqslam(NOISE[0]), r"difference has shape \(45,\), expected \(reference, query\)"),
        (lambda: seqslam(np.where(NOISE > 0.99, np.inf, NOISE)), "difference holds infinite values"),
        (lambda: seqslam(NOISE > 0.5), "difference holds bool values, expected real numbers"),
        (lambda: SeqSlamParams(sequence_length=0), "sequence_length is 0, expected a whole number of at least 1"),
        (lambda: SeqSlamParams(slowest=1.3), "fastest is 1.2, expected 1.3 to 100: slowest and fastest interchanged"),
        (lambda: SeqSlamParams(baseline="observd"), "baseline 'observd' is unknown: .* observed"),
        (lambda: SeqSlamParams(contrast_window=1), "contrast_window is 1"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
