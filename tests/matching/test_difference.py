import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import METRICS, difference_matrix
from insectnav.matching.difference import prepare_references

RNG = np.random.default_rng(0)
REAL = RNG.normal(size=(70, 37)), RNG.normal(size=(90, 37))
BYTES = RNG.integers(0, 256, (70, 200), np.uint8), RNG.integers(0, 256, (90, 200), np.uint8)
BITS = RNG.random((70, 130)) > 0.5, RNG.random((90, 130)) > 0.5


def plain(references, queries, metric):
    """As the docstring says, pair by pair."""
    a, b = references.astype(float)[:, None], queries.astype(float)[None]
    if metric == "cosine":
        return 1 - np.sum(a * b, axis=-1) / np.sqrt(np.sum(a * a, axis=-1) * np.sum(b * b, axis=-1))
    if metric == "euclidean":
        return np.sqrt(np.sum((a - b) ** 2, axis=-1))
    if metric == "hamming":
        return np.mean(a != b, axis=-1)
    return np.abs(a - b).sum(axis=-1) / (len(references) if metric == "openseqslam-v1" else references.shape[1])


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("kind", ["double", "single", "bytes", "bits"])
def test_agrees_with_the_plain_formula(metric, kind):
    references, queries = {
        "double": REAL, "single": [x.astype(np.float32) for x in REAL], "bytes": BYTES, "bits": BITS,
    }[kind]  # fmt: skip
    if metric == "hamming" and kind != "bits":
        with pytest.raises(InputError, match=r"^references hold values other than 0 and 1, expected bits"):
            difference_matrix(references, queries, metric)
        return
    found = difference_matrix(references, queries, metric)
    assert found.shape == (70, 90)
    assert found.dtype == np.float32
    assert_allclose(found, plain(references, queries, metric), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("metric", ["cosine", "euclidean"])
@pytest.mark.parametrize("n_features", [50, 700])
def test_near_vectors_keep_their_digits(metric, n_features):
    middle = RNG.random(n_features) + 3
    references, queries = (middle + 1e-4 * RNG.normal(size=(20, n_features)) for _ in range(2))
    queries[3] = references[5]
    found = difference_matrix(references, queries, metric)
    assert found[5, 3] == 0
    expected = plain(references, queries, "euclidean")
    if metric == "cosine":  # |a − b|² / 2 of unit vectors, which subtraction of 1 − cos would lose
        unit = [x / np.linalg.norm(x, axis=1, keepdims=True) for x in (references, queries)]
        expected = plain(*unit, "euclidean") ** 2 / 2
    # single precision: vectors of length 80 that differ by 3e-3 leave 4 digits of each
    assert_allclose(found, expected, rtol=1e-6 if n_features == 50 else 2e-2 if metric == "cosine" else 1e-5)


@pytest.mark.parametrize("n_references", [3, 16, 33])
@pytest.mark.parametrize("n_features", [50, 600, 2048])
@pytest.mark.parametrize("sign", ["both", "positive"])
def test_cosine_keeps_its_digits_at_every_distance(sign, n_features, n_references):
    """Near and far, on both sides of where the way of summing changes, and in any place of a tile."""
    rng = np.random.default_rng(2)
    references = rng.normal(size=(n_references, n_features))
    noise = rng.normal(size=(41, n_features)) * np.logspace(-4, 1, 41)[:, None]
    queries = references[np.arange(41) % n_references] + noise
    if sign == "positive":  # sums grow the most
        references, queries = np.abs(references), np.abs(queries)
    found, expected = difference_matrix(references, queries), plain(references, queries, "cosine")
    # the formula in double precision is 1e-15 off itself; in single, each part of a vector is 3e-8 of it off
    tolerance = 2e-15 + 1e-7 * expected
    if n_features > 512:
        tolerance += np.where(expected < 2.0**-6, 1e-7 * np.sqrt(expected), 5e-7)
    np.testing.assert_array_less(np.abs(found - expected), tolerance)


@pytest.mark.parametrize("metric", ["cosine", "euclidean", "absolute"])
@pytest.mark.parametrize("kind", [bool, np.uint8, np.float32])
def test_sums_over_whole_pictures_keep_their_digits(metric, kind):
    """Sums of 400 000 like terms in single precision, one after the other, are a thousandth off."""
    rng = np.random.default_rng(1)
    references, queries = (rng.integers(0, 2 if kind is bool else 256, (2, 400_000)).astype(kind) for _ in range(2))
    assert_allclose(difference_matrix(references, queries, metric), plain(references, queries, metric), rtol=3e-6)


@pytest.mark.parametrize("n_features", [3, 600])
@pytest.mark.parametrize("magnitude", [1e-160, 1e-40, 1e150, 1e300])
def test_cosine_does_not_see_the_unit(magnitude, n_features):
    frames = np.random.default_rng(1).normal(size=(2, 5, n_features))
    assert_allclose(difference_matrix(*magnitude * frames), difference_matrix(*frames), rtol=1e-5)


@pytest.mark.parametrize("n_features", [512, 513, 1500])
@pytest.mark.parametrize("magnitude", [1e-36, 1e-25, 1e-10, 1e14, 1e16, 1e18, 1e19, 1e30, 1e36])
def test_euclidean_distances_do_not_see_the_unit(magnitude, n_features):
    """A power of 2 as the unit changes no bit where single precision has room for the distances."""
    rng = np.random.default_rng(n_features)
    frames, unit = rng.normal(size=(2, 9, n_features)) + 3.0, 2.0 ** round(np.log2(magnitude))
    usual = difference_matrix(*frames, "euclidean")
    found = difference_matrix(*(unit * frames), "euclidean")
    assert_array_equal(found, (unit * usual.astype(float)).astype(np.float32))
    assert_allclose(usual, plain(*frames, "euclidean"), rtol=1e-6)


@pytest.mark.parametrize("n_features", [37, 600])
@pytest.mark.parametrize("metric", ["euclidean", "absolute", "openseqslam-v1"])
def test_differences_beyond_single_precision_are_refused(metric, n_features):
    frames = np.random.default_rng(0).normal(size=(2, 9, n_features))
    with pytest.raises(InputError, match=f"^a difference by {metric} is beyond 3e38, or 1e18 times"):
        difference_matrix(1e150 * frames[0], 1e150 * frames[1], metric)
    with pytest.raises(InputError, match=f"^a difference by {metric} is beyond 3e38, or 1e18 times"):
        difference_matrix(frames[0], 1e150 * frames[1], metric)


@pytest.mark.parametrize("magnitude", [1e-25, 1e25])
def test_distances_need_no_room_for_their_squares(magnitude):
    references, queries = (x * magnitude for x in REAL)
    expected = plain(references, queries, "euclidean")
    assert_allclose(difference_matrix(references, queries, "euclidean"), expected, rtol=1e-6)


@pytest.mark.parametrize("metric", METRICS)
def test_equal_frames_do_not_differ(metric):
    frames = BITS[0] if metric == "hamming" else REAL[0]
    found = difference_matrix(frames, frames, metric)
    assert_array_equal(np.diag(found), 0)
    twice = difference_matrix(np.repeat(frames, 3, axis=0), frames, metric)
    if metric != "openseqslam-v1":  # which divides by the number of references
        assert_allclose(twice[::3], found, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("metric", METRICS)
def test_threads_and_batches_change_nothing(metric):
    references, queries = BITS if metric == "hamming" else BYTES
    many = np.concatenate([queries] * 4)
    whole = difference_matrix(references, many, metric, workers=1)
    assert_array_equal(difference_matrix(references, many, metric, workers=3), whole)
    prepared = prepare_references(references, metric)
    one_by_one = np.concatenate([prepared.differences(query[None]) for query in queries], axis=1)
    assert_array_equal(one_by_one, whole[:, : len(queries)])


def test_bits_may_come_as_numbers():
    references, queries = BITS
    for kind in (np.uint8, np.float32, np.float64):
        found = difference_matrix(references.astype(kind), queries.astype(kind), "hamming")
        assert_array_equal(found, difference_matrix(references, queries, "hamming"))


@pytest.mark.parametrize("metric", METRICS)
def test_missing_frames_are_nan_and_alone(metric):
    references, queries = [x.astype(np.float32) for x in BITS] if metric == "hamming" else [x.copy() for x in REAL]
    expected = difference_matrix(references, queries, metric)
    references[4], queries[7] = np.nan, np.nan
    found = difference_matrix(references, queries, metric)
    is_nan = np.zeros(found.shape, bool)
    is_nan[4] = is_nan[:, 7] = True
    assert_array_equal(np.isnan(found), is_nan)
    assert_allclose(found[~is_nan], expected[~is_nan], rtol=1e-5, atol=1e-6)


@settings(deadline=None, max_examples=30)
@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_cosine_does_not_see_length(a, b):
    assert_allclose(difference_matrix(a * REAL[0], b * REAL[1]), difference_matrix(*REAL), rtol=1e-6, atol=1e-7)


def test_a_vector_without_length_is_like_none():
    frames = REAL[0].copy()
    frames[2] = 0
    found = difference_matrix(frames, frames)
    assert_array_equal(found[2], 1)
    assert_array_equal(found[:, 2], 1)


def test_input_is_left_alone():
    frames = REAL[0].copy()
    frames[1] = np.nan
    before = frames.copy()
    difference_matrix(frames, frames, "euclidean")
    assert_array_equal(frames, before)


@pytest.mark.parametrize(
    ("references", "queries", "metric", "sentence"),
    [
        (*REAL, "cosin", r"metric 'cosin' is unknown: .* \(did you mean cosine\?\)"),
        (REAL[0], REAL[1][:, :5], "cosine", "references have 37 features and queries 5, expected as many"),
        (REAL[0][0], REAL[1], "cosine", r"references have shape \(37,\) and type float64, expected real numbers"),
        (REAL[0], np.empty((0, 37)), "cosine", r"queries have shape \(0, 37\)"),
        (REAL[0], np.array([["a"]]), "cosine", "queries have shape .1, 1. and type str"),
        (BYTES[0], BYTES[1] / 255, "absolute", "queries hold float64 values, expected bytes as the references"),
        (BITS[0], BYTES[1][:, :130], "hamming", "queries hold values other than 0 and 1"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(references, queries, metric, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        difference_matrix(references, queries, metric)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_descriptor_that_is_bad_in_part_is_named(value):
    queries = REAL[1].copy()
    queries[8, 3] = value
    with pytest.raises(InputError, match=r"^the descriptor of frame 8 of the queries is NaN or infinite in part"):
        difference_matrix(REAL[0], queries)
