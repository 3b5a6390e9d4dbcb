"""FAB-MAP models on disk: what goes in comes out to the bit; what is damaged, foreign or newer is refused."""

import json
import os
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import (
    ChowLiuTree,
    MapAbout,
    PlaceMap,
    Vocabulary,
    chow_liu_tree,
    fabmap,
    fabmap_store,
    open_fabmap,
    save_fabmap,
    vocabulary_of_features,
)

RNG = np.random.default_rng(0)
VOCABULARY = vocabulary_of_features([RNG.normal(size=(40, 6))], n_words=9)
TREE = chow_liu_tree(RNG.random((20, 9)) < 0.4)
TREE_ARRAYS = ("parent", "marginal", "given_present", "given_absent", "training")


def refused(folder: Path) -> str:
    with pytest.raises(InputError) as error:
        open_fabmap(folder)
    assert "\n" not in str(error.value)
    return str(error.value)


def assert_same_tree(found: ChowLiuTree | None, expected: ChowLiuTree) -> None:
    assert found is not None
    for name in TREE_ARRAYS:
        ours, theirs = getattr(found, name), getattr(expected, name)
        assert_array_equal(ours, theirs)
        assert ours.dtype == theirs.dtype


@settings(max_examples=25, deadline=None)
@given(
    n_words=st.integers(2, 40),
    n_images=st.integers(10, 30),
    detector=st.sampled_from(["sift", "orb", "own"]),
    parts=st.sampled_from(["vocabulary", "tree", "both"]),
    seed=st.integers(0, 2**31),
)
def test_what_was_saved_is_opened_to_the_bit(n_words: int, n_images: int, detector: str, parts: str, seed: int):
    rng = np.random.default_rng(seed)
    n_numbers = {"sift": 128, "orb": 256}.get(detector, int(rng.integers(1, 20)))
    words = rng.normal(size=(n_words, n_numbers)).astype(np.float32)
    vocabulary = None if parts == "tree" else Vocabulary(words=words, detector=detector)
    tree = None if parts == "vocabulary" else chow_liu_tree(rng.random((n_images, n_words)) < rng.random(n_words))
    with tempfile.TemporaryDirectory() as folder:
        save_fabmap(Path(folder) / "model", vocabulary, tree)
        found = open_fabmap(Path(folder) / "model")
        assert os.listdir(folder) == ["model"]
    if vocabulary is None:
        assert found.vocabulary is None
    else:
        assert found.vocabulary is not None
        assert found.vocabulary.detector == detector
        assert_array_equal(found.vocabulary.words, words)
    if tree is None:
        assert found.tree is None
    else:
        assert_same_tree(found.tree, tree)


def test_a_model_that_was_opened_answers_as_the_one_that_was_saved(tmp_path: Path):
    features = [RNG.normal(size=(5, 6)) for _ in range(8)]
    save_fabmap(tmp_path / "model", VOCABULARY, TREE)
    vocabulary, tree = open_fabmap(tmp_path / "model")
    bags = vocabulary.bags_of_features(features)
    assert_array_equal(bags, VOCABULARY.bags_of_features(features))
    for ours, theirs in zip(fabmap(bags, bags[:3], tree), fabmap(bags, bags[:3], TREE), strict=True):
        assert_array_equal(ours, theirs)


def test_large_arrays_are_mapped_and_are_zarr(tmp_path: Path, monkeypatch):
    import zarr

    words = RNG.normal(size=(3000, 128)).astype(np.float32)  # 1.5 MB
    save_fabmap(tmp_path / "model", Vocabulary(words=words, detector="sift"))
    found = open_fabmap(tmp_path / "model").vocabulary
    assert isinstance(found.words.base, np.memmap)
    assert_array_equal(found.words, words)
    assert_array_equal(zarr.open_group(tmp_path / "model" / "vocabulary", mode="r")["words"][:], words)


@pytest.mark.parametrize(
    ("vocabulary", "tree", "sentence"),
    [
        (None, None, "neither a vocabulary nor a tree is given"),
        (VOCABULARY, chow_liu_tree(RNG.random((20, 8)) < 0.4), "the vocabulary has 9 words and the tree 8"),
        (replace(VOCABULARY, detector="surf"), None, "detector 'surf' is unknown"),
        (replace(VOCABULARY, detector="sift"), None, "words has shape (9, 6), expected (word, 128)"),
        (replace(VOCABULARY, words=VOCABULARY.words * np.nan), None, "words is nan"),
        (replace(VOCABULARY, words=VOCABULARY.words[:1]), None, "words have shape (1, 6), expected at least 2"),
        (None, replace(TREE, parent=np.arange(9)), "the words do not hang together in one tree"),
        (None, replace(TREE, parent=np.roll(np.arange(9), 1)), "the words do not hang together in one tree"),
        (None, replace(TREE, parent=np.array([0, 2, 1, *[0] * 6])), "the words do not hang together in one tree"),
        (None, replace(TREE, parent=np.full(9, 9)), "parent holds values that are no words, expected 0 to 8"),
        (None, replace(TREE, marginal=np.zeros(9)), "marginal holds values that are no probabilities"),
        (None, replace(TREE, given_absent=TREE.marginal[:5]), "given_absent has shape (5,), expected (9,)"),
        (None, replace(TREE, training=TREE.training[:4]), "is of 9 words and 4 images, expected at least 2 and 10"),
    ],
)
def test_what_was_never_learnt_is_not_saved(tmp_path: Path, vocabulary, tree, sentence: str):
    with pytest.raises(InputError) as error:
        save_fabmap(tmp_path / "model", vocabulary, tree)
    assert sentence in str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_word_far_from_the_root_is_in_the_tree(tmp_path: Path):
    chain = np.maximum(np.arange(9) - 1, 0)
    save_fabmap(tmp_path / "model", None, replace(TREE, parent=chain))
    assert_array_equal(open_fabmap(tmp_path / "model").tree.parent, chain)


def test_nothing_is_overwritten(tmp_path: Path):
    save_fabmap(tmp_path / "model", VOCABULARY)
    for place in ("model", "model/fabmap.json"):
        with pytest.raises(InputError, match="exists, expected a new or empty folder for the FAB-MAP model"):
            save_fabmap(tmp_path / place, None, TREE)
    (tmp_path / "empty").mkdir()
    save_fabmap(tmp_path / "empty", None, TREE)
    with pytest.raises(InputError, match=r"^the FAB-MAP model .*below' cannot be written"):
        save_fabmap(tmp_path / "model" / "fabmap.json" / "below", VOCABULARY)


def test_a_failure_while_writing_leaves_nothing(tmp_path: Path, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(fabmap_store, "write_json", full)
    with pytest.raises(InputError, match=r"^the FAB-MAP model .* cannot be written \(No space left on device\)$"):
        save_fabmap(tmp_path / "model", VOCABULARY, TREE)
    assert not list(tmp_path.iterdir())


def test_folders_of_others_are_refused(tmp_path: Path):
    assert refused(tmp_path / "gone").endswith("does not exist, expected the folder of a FAB-MAP model")
    assert refused(tmp_path).endswith("is no FAB-MAP model: it has no file fabmap.json")
    PlaceMap.build(tmp_path / "map", RNG.normal(size=(5, 3)), MapAbout(descriptor="x", metric="cosine", n_features=3))
    assert refused(tmp_path / "map").endswith("is no FAB-MAP model: it has no file fabmap.json")
    (tmp_path / "file").write_text("x")
    assert refused(tmp_path / "file").endswith("is no FAB-MAP model: it has no file fabmap.json")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"version": 2}, "has format 2, expected at most 1: made by a newer version of insectnav?"),
        ({"version": 0}, "is not as it was written: damaged?"),
        ({"format": "insectnav places"}, "its fabmap.json does not say 'insectnav fabmap'"),
        ({"detector": "surf"}, "is not as it was written: damaged?"),
        ({"detector": None}, "is not as it was written: damaged?"),
        ({"detector": ["own"]}, "is not as it was written: damaged?"),
        ({"sha256": {}}, "is not as it was written: damaged?"),
        ({"sha256": {"../elsewhere": "0"}}, "is not as it was written: damaged?"),
        ({"sha256": {"vocabulary": "0"}}, "the arrays of its vocabulary are not as they were written"),
        ({"detector": "sift"}, "words has shape (9, 6), expected (word, 128)"),
        ({"more": 1}, "is not as it was written: damaged?"),
    ],
)
def test_a_record_that_says_something_else_is_refused(tmp_path: Path, change: dict, sentence: str):
    save_fabmap(tmp_path / "model", VOCABULARY, TREE)
    record = tmp_path / "model" / "fabmap.json"
    record.write_text(json.dumps(json.loads(record.read_text()) | change))
    assert sentence in refused(tmp_path / "model")


@pytest.fixture(scope="module")
def saved(tmp_path_factory) -> dict[Path, bytes]:
    """The files of a model, and what is in them."""
    folder = tmp_path_factory.mktemp("saved") / "model"
    save_fabmap(folder, VOCABULARY, TREE)
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@settings(max_examples=150, deadline=None)
@given(which=st.integers(0, 100), share=st.floats(0, 1), length=st.integers(0, 40), other=st.binary(max_size=8))
def test_a_damaged_model_is_refused_or_the_same(saved: dict, which: int, share: float, length: int, other: bytes):
    path = sorted(saved)[which % len(saved)]
    whole = saved[path]
    start = int(share * (len(whole) - 1))
    path.write_bytes(whole[:start] + other + whole[start + length :])
    folder = next(one.parent for one in saved if one.name == "fabmap.json")
    try:
        found = open_fabmap(folder)
        assert_array_equal(found.vocabulary.words, VOCABULARY.words)
        assert found.vocabulary.detector == "own"
        assert_same_tree(found.tree, TREE)
    except InputError as error:
        assert "\n" not in str(error)
    finally:
        path.write_bytes(whole)


def test_a_missing_array_is_refused(tmp_path: Path):
    save_fabmap(tmp_path / "model", VOCABULARY, TREE)
    (tmp_path / "model" / "tree" / "marginal" / "zarr.json").unlink()
    assert "is damaged: the array" in refused(tmp_path / "model")


def test_training_that_would_not_fit_into_memory_is_refused(tmp_path: Path, monkeypatch):
    save_fabmap(tmp_path / "model", None, TREE)
    monkeypatch.setattr(fabmap_store, "MOST_BITS", 8)
    assert "training has (20, 2) bytes, expected bits of 9 words, 8 at most" in refused(tmp_path / "model")
