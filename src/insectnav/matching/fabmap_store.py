"""Vocabularies and trees of words on disk: a folder that appears whole or not at all, in the format of zarr."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_choice, check_finite, check_shape
from insectnav.matching.chow_liu import LEAST_IMAGES, ChowLiuTree, checked_bags
from insectnav.matching.place_store import (
    Arrays,
    DamagedError,
    arrays_digest,
    read_arrays,
    read_json,
    shown,
    whole_folder,
    write_arrays,
    write_json,
    written,
)
from insectnav.matching.visual_words import DETECTORS, NUMBERS, OWN, Vocabulary

RECORD = "fabmap.json"
FORMAT, VERSION = "insectnav fabmap", 1
PARTS: Mapping[str, Mapping[str, tuple[str, ...]]] = {  # folder of each part, and the dimensions of its arrays
    "vocabulary": {"words": ("word", "number")},
    "tree": {
        "parent": ("word",),
        "marginal": ("word",),
        "given_present": ("word",),
        "given_absent": ("word",),
        "training": ("image", "word_byte"),  # in bits
    },
}
KINDS = {"words": "float32", "parent": "int64", "training": "uint8"}  # all others are float64
MOST_BITS = 2**34  # of training, which takes eight times as much memory as on disk


class FabMapModel(NamedTuple):
    """What FAB-MAP has learnt from training images; None for what was not saved."""

    vocabulary: Vocabulary | None
    tree: ChowLiuTree | None


def save_fabmap(
    folder: str | os.PathLike[str], vocabulary: Vocabulary | None = None, tree: ChowLiuTree | None = None
) -> None:
    """Put what was learnt into a new folder, for `open_fabmap`; together, so that neither meets another's words.

    Parameters
    ----------
    folder : that is not there, or empty
    vocabulary : of `build_vocabulary` or `vocabulary_of_features`; None to save a tree alone
    tree : of `chow_liu_tree`; None to save a vocabulary alone

    Raises
    ------
    InputError
        If there is nothing to save, the two are not of as many words or not as they were made, something is in the
        folder, or it cannot be written.
    """
    if vocabulary is None and tree is None:
        raise InputError("neither a vocabulary nor a tree is given, expected one of them to save")
    _check(FabMapModel(vocabulary, tree))
    place = Path(folder)
    parts: dict[str, Arrays] = {}
    if vocabulary is not None:
        parts["vocabulary"] = _with_dimensions("vocabulary", {"words": np.asarray(vocabulary.words, np.float32)})
    if tree is not None:
        values = {name: getattr(tree, name) for name in PARTS["tree"]}
        parts["tree"] = _with_dimensions("tree", values | {"training": np.packbits(tree.training, axis=1)})
    with written(place, "FAB-MAP model"):
        if place.exists() and (not place.is_dir() or any(place.iterdir())):
            raise InputError(f"{shown(place)} exists, expected a new or empty folder for the FAB-MAP model")
        with whole_folder(place) as temporary:
            digests = {}
            for name, arrays in parts.items():
                write_arrays(temporary / name, arrays)
                digests[name] = arrays_digest(temporary / name, PARTS[name])
            words = {"format": FORMAT, "version": VERSION, "sha256": digests}
            write_json(temporary / RECORD, words | {"detector": None if vocabulary is None else vocabulary.detector})


def open_fabmap(folder: str | os.PathLike[str]) -> FabMapModel:
    """What `save_fabmap` has put into a folder, to the bit; large arrays are mapped from disk.

    Raises
    ------
    InputError
        If there is no such folder, it is damaged, or it was made by a newer version of insectnav.
    """
    place = Path(folder)
    digests, detector = _read_record(place)
    try:
        found: dict[str, dict[str, NDArray[Any]]] = {}
        for name, digest in digests.items():
            found[name] = {key: np.asarray(one) for key, one in read_arrays(place / name, PARTS[name]).items()}
            if arrays_digest(place / name, PARTS[name]) != digest:
                raise DamagedError(f"the arrays of its {name} are not as they were written")
            for array, values in found[name].items():
                if values.dtype.name != KINDS.get(array, "float64"):
                    raise DamagedError(f"{array} holds {values.dtype.name} values")
        vocabulary = Vocabulary(words=found["vocabulary"]["words"], detector=detector) if detector else None
        model = FabMapModel(vocabulary, _tree(found["tree"]) if "tree" in found else None)
        _check(model)
    except (InputError, OSError) as error:
        raise DamagedError(f"the FAB-MAP model {shown(place)} is damaged: {error}") from None
    return model


def _read_record(folder: Path) -> tuple[dict[str, str], str]:
    """Digests by the names of the parts that there are, and the detector of the vocabulary, "" without one."""
    try:
        words = read_json(folder / RECORD)
    except (FileNotFoundError, NotADirectoryError):
        if not folder.exists():
            raise InputError(f"{shown(folder)} does not exist, expected the folder of a FAB-MAP model") from None
        raise InputError(f"{shown(folder)} is no FAB-MAP model: it has no file {RECORD}") from None
    except OSError as error:
        raise InputError(f"the FAB-MAP model {shown(folder)} cannot be read ({error.strerror})") from None
    if words.get("format") != FORMAT:
        raise InputError(f"{shown(folder)} is no FAB-MAP model: its {RECORD} does not say {FORMAT!r}")
    version: Any = words.get("version")
    digests: Any = words.get("sha256")
    detector: Any = words.get("detector")
    if type(version) is int and version > VERSION:
        raise InputError(
            f"the FAB-MAP model {shown(folder)} has format {version}, expected at most {VERSION}: "
            "made by a newer version of insectnav?"
        )
    is_right = (
        version == VERSION
        and set(words) == {"format", "version", "sha256", "detector"}
        and isinstance(digests, dict)
        and 0 < len(digests.keys() & PARTS.keys()) == len(digests)
        and all(isinstance(digest, str) for digest in digests.values())
        and (detector in (*DETECTORS, OWN) if "vocabulary" in digests else detector is None)
    )
    if not is_right:
        raise DamagedError(f"the {RECORD} of the FAB-MAP model {shown(folder)} is not as it was written: damaged?")
    return digests, detector or ""


def _with_dimensions(part: str, values: Mapping[str, NDArray[Any]]) -> Arrays:
    return {
        name: (dimensions, np.asarray(values[name], KINDS.get(name, "float64")))
        for name, dimensions in PARTS[part].items()
    }


def _tree(arrays: dict[str, NDArray[Any]]) -> ChowLiuTree:
    """A tree of its arrays, the training images no longer in bits."""
    bits, n_words = arrays.pop("training"), len(arrays["parent"])
    if bits.shape[1] != -(-n_words // 8) or bits.size > MOST_BITS // 8:
        raise DamagedError(f"training has {bits.shape} bytes, expected bits of {n_words} words, {MOST_BITS} at most")
    return ChowLiuTree(training=np.unpackbits(bits, axis=1, count=n_words).view(bool), **arrays)


def _check(model: FabMapModel) -> None:
    """Refuse what `build_vocabulary` and `chow_liu_tree` do not make."""
    vocabulary, tree = model
    if vocabulary is not None:
        _check_vocabulary(vocabulary)
    if tree is not None:
        _check_tree(tree)
    if vocabulary is not None and tree is not None and vocabulary.n_words != tree.n_words:
        raise InputError(
            f"the vocabulary has {vocabulary.n_words} words and the tree {tree.n_words}, expected as many: of another "
            "vocabulary?"
        )


def _check_vocabulary(vocabulary: Vocabulary) -> None:
    words, detector = np.asarray(vocabulary.words), vocabulary.detector
    check_choice("detector", detector, (*DETECTORS, OWN))
    check_shape("words", words, ("word", NUMBERS.get(detector, "number")))
    check_finite("words", words)
    if len(words) < 2 or not words.shape[1]:
        raise InputError(f"words have shape {words.shape}, expected at least 2 of some numbers")


def _check_tree(tree: ChowLiuTree) -> None:
    n_words = len(tree.parent)
    for name in ("parent", "marginal", "given_present", "given_absent"):
        check_shape(name, getattr(tree, name), (n_words,))
    training = checked_bags("training", tree.training, n_words)
    if n_words < 2 or len(training) < LEAST_IMAGES:
        raise InputError(
            f"the tree is of {n_words} words and {len(training)} images, expected at least 2 and {LEAST_IMAGES}"
        )
    for name in ("marginal", "given_present", "given_absent"):
        values = getattr(tree, name)
        if not ((values > 0.0) & (values < 1.0)).all():
            raise InputError(f"{name} holds values that are no probabilities between 0 and 1")
    above, word = np.asarray(tree.parent), np.arange(n_words)
    if above.dtype.kind not in "iu" or not ((above >= 0) & (above < n_words)).all():
        raise InputError(f"parent holds values that are no words, expected 0 to {n_words - 1}")
    root = np.flatnonzero(above == word)
    for _ in range(n_words.bit_length()):  # after which each word is at its end, however long the way there
        above = above[above]
    if len(root) != 1 or (above != root[0]).any():
        raise InputError("the words do not hang together in one tree, expected a single root and no circle")
