"""Visual words: local features of images, grouped into a vocabulary, and which of its words an image holds."""

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_count, check_finite, check_shape

Reals = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]
DETECTORS = ("sift", "orb")  # SURF, which the papers took, is in no wheel of OpenCV; AKAZE in none from version 5 on
NUMBERS = {"sift": 128, "orb": 256}  # that describe a feature
OWN = "own"  # features that the user found
MAX_STEPS = 30  # of k-means; words then move little
FEATURES_AT_ONCE = 2**14  # whose distances to all words are in memory together


@dataclass(frozen=True, kw_only=True, eq=False)
class Vocabulary:
    """The words that images are made of; by `build_vocabulary` or `vocabulary_of_features`.

    Parameters
    ----------
    words : (word, number) centres of the groups of features
    detector : one of `DETECTORS`, or "own" for features found elsewhere
    """

    words: Reals
    detector: str

    @property
    def n_words(self) -> int:
        """How many words there are."""
        return len(self.words)

    def bags(self, images: Iterable[ArrayLike]) -> Bools:
        """Which words are in each image, (frame, word) bool: its features' nearest words, however many of each.

        Parameters
        ----------
        images : one after the other, (rows, columns) or (rows, columns, 3) red, green, blue; bytes, or reals in 0 … 1

        Returns
        -------
        (frame, word) array of bool
            A row without any True is an image in which nothing was detected.

        Raises
        ------
        InputError
            If an image is none, or the vocabulary is of features that were found elsewhere.
        """
        if self.detector == OWN:
            raise InputError(
                "the vocabulary is of features found elsewhere, expected one of a detector: bags_of_features?"
            )
        return self.bags_of_features([local_features(image, self.detector) for image in images])

    def bags_of_features(self, features: Sequence[ArrayLike]) -> Bools:
        """Which words are among the features of each frame, (frame, word) bool.

        Parameters
        ----------
        features : for each frame an array (feature, number) of the kind that the vocabulary was built from

        Raises
        ------
        InputError
            If features have another length than the words.
        """
        found = np.zeros((len(features), self.n_words), bool)
        for frame, given in enumerate(features):
            vectors = _checked_features(frame, given, self.words.shape[1])
            found[frame, _nearest_words(vectors, self.words)] = True
        return found


def build_vocabulary(
    images: Iterable[ArrayLike], n_words: int = 1000, seed: int = 0, detector: str = "sift"
) -> Vocabulary:
    """A vocabulary of the features of training images.

    Parameters
    ----------
    images : one after the other, (rows, columns) or (rows, columns, 3) red, green, blue; bytes, or reals in 0 … 1
        Of places like those of the map, but not of the map itself.
    n_words : int
        The default is assumed: the papers' vocabularies are of some 10⁴ and 10⁵ words from far more images.
    seed : of the first centres
    detector : str
        "sift": OpenCV's, as many features as pass its threshold of contrast; "orb": at most 500 strings of 256 bits,
        taken as numbers 0 and 1.

    Raises
    ------
    InputError
        If an image is none, or the features are fewer than the words.

    Notes
    -----
    Cummins & Newman 2008, IJRR 27, doi 10.1177/0278364908090961, after Sivic & Zisserman 2003: words are groups of
    features. They and OpenFABMAP group SURF features by their distance to the first of a group; here it is k-means of
    scikit-learn, which takes the number of words, of at most 30 steps from one choice of first centres. SIFT: Lowe
    2004, doi 10.1023/B:VISI.0000029664.99615.94.
    """
    check_choice("detector", detector, DETECTORS)
    features = [local_features(image, detector) for image in images]
    return Vocabulary(words=_group(features, n_words, seed, "images in which nothing is detected?"), detector=detector)


def vocabulary_of_features(features: Sequence[ArrayLike], n_words: int = 1000, seed: int = 0) -> Vocabulary:
    """A vocabulary of features that were found elsewhere, by SURF or a network.

    Parameters
    ----------
    features : for each training image an array (feature, number)
    n_words : int
    seed : of the first centres

    Raises
    ------
    InputError
        If features differ in length or are fewer than the words.
    """
    first = next((np.shape(one)[-1] for one in features if np.size(one)), 0)
    vectors = [_checked_features(frame, given, first) for frame, given in enumerate(features)]
    return Vocabulary(words=_group(vectors, n_words, seed, "too few training images?"), detector=OWN)


def local_features(image: ArrayLike, detector: str = "sift") -> Reals:
    """What describes the surroundings of each point that stands out, (feature, number) float32.

    Parameters
    ----------
    image : (rows, columns) or (rows, columns, 3) array, bytes, or reals in 0 … 1
    detector : one of `DETECTORS`

    Returns
    -------
    (feature, 128) array of "sift", (feature, 256) of 0 and 1 of "orb"; without rows where nothing stands out.

    Raises
    ------
    InputError
        If the image is none, or the detector unknown.
    """
    import cv2

    check_choice("detector", detector, DETECTORS)
    grey = _grey_bytes(image)
    finder: Any = cv2.SIFT_create() if detector == "sift" else cv2.ORB_create()  # type: ignore[attr-defined]
    found = finder.detectAndCompute(grey, None)[1]
    if found is None:
        return np.empty((0, NUMBERS[detector]), np.float32)
    return np.asarray(np.unpackbits(found, axis=1) if detector == "orb" else found, np.float32)


def _grey_bytes(image: ArrayLike) -> NDArray[np.uint8]:
    import cv2

    picture = as_numbers("image", image)
    check_shape("image", picture, ("rows", "columns", 3) if picture.ndim == 3 else ("rows", "columns"))
    if not picture.size:
        raise InputError(f"image has shape {picture.shape}, expected some pixels")
    if picture.dtype != np.uint8:
        check_finite("image", picture)
        low, high = float(picture.min()), float(picture.max())
        if picture.dtype.kind != "f" or low < 0.0 or high > 1.0:
            raise InputError(
                f"image holds {picture.dtype.name} values from {low:g} to {high:g}, expected bytes or reals in 0 to 1: "
                "divide by the largest value?"
            )
        picture = np.rint(255.0 * picture).astype(np.uint8)
    picture = np.ascontiguousarray(picture)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) if picture.ndim == 3 else picture, np.uint8)


def _checked_features(frame: int, features: ArrayLike, n_numbers: int) -> Reals:
    vectors = as_numbers("features", features)
    if not vectors.size:
        return np.empty((0, n_numbers), np.float32)
    check_shape("features", vectors, ("feature", "number"))
    if vectors.shape[1] != n_numbers:
        raise InputError(
            f"features of frame {frame} have {vectors.shape[1]} numbers, expected {n_numbers}: by another detector?"
        )
    check_finite("features", vectors)
    return vectors.astype(np.float32)


def _group(features: Sequence[Reals], n_words: int, seed: int, slip: str) -> Reals:
    """Centres of k-means, (word, number) float32; on one thread, as sums of several would depend on their order."""
    check_count("n_words", n_words, minimum=2)
    check_count("seed", seed, minimum=0)
    n_features = sum(len(one) for one in features)
    if n_features < n_words:
        raise InputError(
            f"{len(features)} training images have {n_features} features in all, expected at least {n_words}, as many "
            f"as words: {slip}"
        )
    from sklearn.cluster import KMeans
    from sklearn.exceptions import ConvergenceWarning
    from threadpoolctl import threadpool_limits

    grouping = KMeans(n_clusters=n_words, n_init=1, max_iter=MAX_STEPS, random_state=seed)
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("error", ConvergenceWarning)  # of groups that nothing is nearest to
        try:
            grouping.fit(np.concatenate(features))
        except ConvergenceWarning:
            raise InputError(
                f"{len(features)} training images have {n_features} features in all but fewer than {n_words} different "
                f"ones, expected at least as many as words: {slip}"
            ) from None
    return np.asarray(grouping.cluster_centers_, np.float32)


def _nearest_words(vectors: Reals, words: Reals) -> NDArray[np.int64]:
    """Number of the word next to each feature, (feature,)."""
    half_square = 0.5 * np.einsum("wn,wn->w", words, words)
    nearest = np.empty(len(vectors), np.int64)
    for first in range(0, len(vectors), FEATURES_AT_ONCE):
        block = slice(first, first + FEATURES_AT_ONCE)
        nearest[block] = np.argmax(vectors[block] @ words.T - half_square, axis=1)
    return nearest
