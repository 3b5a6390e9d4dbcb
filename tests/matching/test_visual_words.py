import os
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import build_vocabulary, vocabulary_of_features
from insectnav.matching.visual_words import _grey_bytes, local_features


def pictures(n, seed=0, side=96):
    """Blobs and boxes of all sizes, (n, side, side) bytes."""
    rng = np.random.default_rng(seed)
    out = np.full((n, side, side), 120, np.uint8)
    for picture in out:
        for _ in range(25):
            row, column = rng.integers(side, size=2)
            height, width = rng.integers(4, 24, 2)
            picture[row : row + height, column : column + width] = rng.integers(256)
    return out


TRAINING = pictures(12)


@pytest.mark.parametrize(("detector", "length"), [("sift", 128), ("orb", 256)])
def test_features_of_a_detector_become_words(detector, length):
    vocabulary = build_vocabulary(TRAINING, n_words=20, detector=detector)
    assert vocabulary.words.shape == (20, length)
    assert vocabulary.n_words == 20
    bags = vocabulary.bags(TRAINING)
    assert bags.shape == (12, 20)
    assert bags.dtype == bool
    assert bags.any(axis=0).all()  # no word without a feature
    for image, bag in zip(TRAINING, bags, strict=True):
        found = local_features(image, detector)
        apart = np.linalg.norm(found[:, None].astype(float) - vocabulary.words, axis=-1)
        assert_array_equal(np.unique(apart.argmin(axis=1)), np.flatnonzero(bag))


def test_centres_are_means_of_the_features_next_to_them():
    vocabulary = build_vocabulary(TRAINING[:4], n_words=5)
    features = np.concatenate([local_features(image) for image in TRAINING[:4]]).astype(float)
    nearest = np.linalg.norm(features[:, None] - vocabulary.words, axis=-1).argmin(axis=1)
    for word in range(5):
        np.testing.assert_allclose(vocabulary.words[word], features[nearest == word].mean(axis=0), atol=0.5)


def test_sift_features_turn_with_the_image():
    """The same words, whichever way up: most features are found again after a quarter turn."""
    vocabulary = build_vocabulary(TRAINING, n_words=30)
    there, turned = vocabulary.bags(TRAINING), vocabulary.bags([np.rot90(image) for image in TRAINING])
    elsewhere = vocabulary.bags(pictures(12, seed=7))
    assert (there == turned).mean() > 0.85
    assert (there == turned).mean() > (there == elsewhere).mean() + 0.1


def test_grey_colour_and_reals_give_the_same():
    vocabulary = build_vocabulary(TRAINING, n_words=20)
    expected = vocabulary.bags(TRAINING)
    assert_array_equal(vocabulary.bags(np.repeat(TRAINING[..., None], 3, axis=-1)), expected)
    assert_array_equal(vocabulary.bags(TRAINING / 255.0), expected)
    assert_array_equal(vocabulary.bags(image for image in TRAINING), expected)


def test_same_seed_same_bits_another_seed_other_words():
    one, same, other = (build_vocabulary(TRAINING, n_words=20, seed=s).words for s in (0, 0, 1))
    assert one.tobytes() == same.tobytes()
    assert not np.array_equal(one, other)


@pytest.mark.slow
def test_the_number_of_threads_changes_nothing():
    code = (
        "import numpy as np; from insectnav.matching import vocabulary_of_features as v;"
        "f = np.random.default_rng(0).normal(size=(4000, 32)); print(hash(v([f], 50).words.tobytes()))"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "OMP_NUM_THREADS": threads, "PYTHONHASHSEED": "0"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    }
    assert len(found) == 1


def test_features_of_ones_own_make_a_vocabulary():
    """Four heaps far apart: a word each."""
    rng = np.random.default_rng(0)
    heaps = 10.0 * np.eye(4, 64)
    features = [heaps[kinds] + 0.1 * rng.normal(size=(len(kinds), 64)) for kinds in ([0, 0, 1], [1, 2], [2, 3, 3], [0])]
    vocabulary = vocabulary_of_features(features, n_words=4)
    word = {kind: int(np.linalg.norm(vocabulary.words - heaps[kind], axis=1).argmin()) for kind in range(4)}
    assert len(set(word.values())) == 4
    bags = vocabulary.bags_of_features([*features, np.empty((0, 64)), []])
    expected = np.zeros((6, 4), bool)
    for frame, kinds in enumerate(([0, 1], [1, 2], [2, 3], [0], [], [])):
        expected[frame, [word[kind] for kind in kinds]] = True
    assert_array_equal(bags, expected)


def test_an_image_without_features_has_no_words():
    vocabulary = build_vocabulary(TRAINING, n_words=20)
    bags = vocabulary.bags([np.full((64, 64), 50, np.uint8), TRAINING[0]])
    assert_array_equal(bags.any(axis=1), [False, True])


@pytest.mark.parametrize(
    ("run", "message"),
    [
        (lambda: build_vocabulary(np.zeros((5, 40, 40), np.uint8), 10), "5 training images have 0 features in all"),
        (lambda: build_vocabulary(TRAINING[:1], 1000), "expected at least 1000, as many as words"),
        (lambda: vocabulary_of_features([np.eye(4), np.eye(4)], 5), "in all but fewer than 5 different ones"),
        (lambda: build_vocabulary(TRAINING, 10, detector="surf"), "detector 'surf' is unknown"),
        (lambda: build_vocabulary(TRAINING, 1), "n_words is 1"),
        (lambda: build_vocabulary(TRAINING, 10, seed=-1), "seed is -1"),
        (
            lambda: build_vocabulary([TRAINING.astype(float)[0]], 10),
            "float64 values from 2 to 248, expected bytes or reals",
        ),
        (lambda: build_vocabulary([TRAINING.astype(np.int64)[0]], 10), "int64 values"),
        (lambda: build_vocabulary([np.full((9, 9), np.nan)], 10), "nan"),
        (lambda: build_vocabulary([TRAINING[0, 0]], 10), "shape"),
        (lambda: build_vocabulary([np.empty((0, 9), np.uint8)], 10), "expected some pixels"),
        (lambda: vocabulary_of_features([np.ones((3, 64)), np.ones((3, 32))], 2), "have 32 numbers, expected 64"),
        (lambda: vocabulary_of_features([], 2), "0 training images have 0 features"),
    ],
)
def test_bad_training_is_refused(run, message):
    with pytest.raises(InputError, match=message):
        run()


def test_features_of_another_detector_are_refused():
    sift, own = build_vocabulary(TRAINING, 20), vocabulary_of_features([np.random.default_rng(0).random((9, 64))], 4)
    with pytest.raises(InputError, match="features of frame 1 have 64 numbers, expected 128: by another detector"):
        sift.bags_of_features([np.ones((2, 128)), np.ones((2, 64))])
    with pytest.raises(InputError, match="bags_of_features"):
        own.bags(TRAINING)


def test_reals_become_the_nearest_bytes():
    assert _grey_bytes(np.array([[0.0, 1.6, 2.4, 255.0]]) / 255.0).tolist() == [[0, 2, 2, 255]]
    picture = np.random.default_rng(0).integers(0, 256, (12, 16), dtype=np.uint8).repeat(10, axis=0).repeat(10, axis=1)
    assert len(local_features(picture)) > 10
    assert_array_equal(local_features(picture / 255.0), local_features(picture))
