"""Places recognised between two passages, by each method, and how right the answers are."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import Floats
from insectnav.experiments.experiment import Results
from insectnav.experiments.stone2016_places.frames import sky_grid, sky_sampler
from insectnav.experiments.stone2016_places.passages import SITE_SEEDS, true_references
from insectnav.matching import OPENSEQSLAM_V1, build_rotation_index, difference_matrix, rotation_between, seqslam
from insectnav.matching.rotation import RotationIndex
from insectnav.metrics.retrieval import (
    PrecisionRecall,
    area_under_curve,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
    right_matches,
)
from insectnav.vision.sphere import rotation_matrix

TOLERANCE = 5  # [frame] section IV-B
SEQUENCE = 10  # [frame] ds, section IV-B
# Rows and columns of patches of 32 × 64 pixels: patch row, its rows, patch column, its columns.
FLAT_BLOCK = (4, 8, 8, 8)
BLOCK = 20  # [frame] that the bootstrap draws together: neighbours are right or wrong together
N_DRAWN = 200
MEASURES = ("recall_at_full_precision", "precision_at_full_recall", "area")
VANILLA, SKY, ROTATION, FABMAP = "SeqSLAM (vanilla)", "SeqSLAM (sky)", "rotation matching", "FAB-MAP"
POINTS, TRUE, NEUTRAL = f"{SKY}, 2000 points", f"{SKY}, exact masks", f"{VANILLA}, flat patches neutral"
PLAIN, WATERSHED = f"{SKY}, no lens flare", f"{SKY}, watershed"
SKY_WHOLE, ROTATION_LOCAL = f"{SKY}, contrast over all references", f"{ROTATION}, contrast of neighbours"
SINGLE = f"{ROTATION}, single frames"
Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Recognised:
    """Answers of one method for the queries of a passage.

    Parameters
    ----------
    reference : (query,) matched frame, −1 where there is none
    score : (query,) lower is better, NaN where there is no match
    truth : (query,) true place [reference frame]
    """

    reference: NDArray[np.int64]
    score: Floats
    truth: Floats

    @property
    def is_right(self) -> NDArray[np.bool_]:
        """Within five frames, (query,)."""
        return right_matches(self.reference, self.truth, TOLERANCE)

    @cached_property
    def curve(self) -> PrecisionRecall:
        """Precision and recall over all thresholds; recall is of the queries that have frames enough around them."""
        return precision_recall(self.is_right, self.score)

    @property
    def kept(self) -> NDArray[np.bool_]:
        """Matches kept at the lowest threshold with full precision, (query,); none if the best match is wrong."""
        curve = self.curve
        full = curve.threshold[curve.precision == 1.0]
        with np.errstate(invalid="ignore"):
            return self.score <= (full.max() if full.size else -np.inf)

    def findings(self) -> dict[str, float]:
        """Recall at full precision and the rest, in percent, with standard errors of a bootstrap over blocks."""
        error = np.nanstd(self.drawn, axis=0)
        return dict(zip(MEASURES, self.measured.tolist(), strict=True)) | {
            f"{name}_error": float(one) for name, one in zip(MEASURES, error, strict=True)
        }

    @cached_property
    def measured(self) -> Floats:
        """Each of `MEASURES` [%]."""
        return _measures(self.is_right, self.score)

    @cached_property
    def drawn(self) -> Floats:
        """The same of queries drawn in blocks, with replacement, (draw, measure) [%]; NaN if none drawn has a match."""
        is_right, score = self.is_right, self.score
        return np.array([_measures(is_right[some], score[some]) for some in drawn_blocks(len(score))])


def jointly(measure: str, function: Callable[..., Any], *answers: Recognised) -> tuple[float, float]:
    """What is made of a measure of each of several answers, and its standard error.

    The same blocks of queries are drawn for all answers: where all fail says nothing of how they differ.

    Parameters
    ----------
    measure : one of `MEASURES`
    function : of as many (...) arrays as there are answers
    answers : of passages with as many queries, the same place at the same number
    """
    if len({len(answer.score) for answer in answers}) != 1:
        raise ValueError("answers of passages of other lengths have no blocks in common")
    k = MEASURES.index(measure)
    drawn = function(*(answer.drawn[:, k] for answer in answers))
    return float(function(*(answer.measured[k] for answer in answers))), float(np.nanstd(drawn))


def drawn_blocks(n: int) -> NDArray[np.int64]:
    """Frames of a passage of `n` drawn anew in blocks of neighbours, with replacement, (draw, frame)."""
    rng = np.random.Generator(np.random.PCG64(0))
    starts = rng.integers(0, max(n - BLOCK, 0) + 1, (N_DRAWN, -(-n // BLOCK)))
    return np.asarray(np.minimum((starts[..., None] + np.arange(BLOCK)).reshape(N_DRAWN, -1)[:, :n], n - 1))


def _measures(is_right: NDArray[np.bool_], score: Floats) -> Floats:
    """Each of `MEASURES` [%]; NaN if no query has a match."""
    if not np.isfinite(score).any():
        return np.full(len(MEASURES), np.nan)
    curve = precision_recall(is_right, score)
    return 100.0 * np.array([recall_at_full_precision(curve), precision_at_full_recall(curve), area_under_curve(curve)])


@lru_cache(maxsize=16)
def passage_arrays(results: Results, passage: int, site: str = "") -> Arrays:
    """All frames of a passage through a site, that of the first cell if none is named; (frame, ...) arrays by name.

    They are kept.
    """
    site = site or results.cells[0].site
    chosen = results.where(site=site, site_seed=SITE_SEEDS[site], passage=passage)
    order = sorted(chosen.tolist(), key=lambda k: results.cells[k].first)
    return {
        name: values[order].reshape(-1, *values.shape[2:])
        for name, values in results.arrays.items()
        if not name.startswith("shown_")
    }


def passage_pair(
    results: Results, numbers: tuple[int, int], n_frames: int | None = None, site: str = ""
) -> tuple[Arrays, Arrays]:
    """Reference and query, of each the first `n_frames`."""
    reference, query = (
        {name: values[:n_frames] for name, values in passage_arrays(results, number, site).items()}
        for number in numbers
    )
    return reference, query


def varied(results: Results, pairs: Mapping[str, tuple[int, int]], n_frames: int) -> dict[tuple[str, str], Recognised]:
    """Answers over the first part of the way, by name of the pair of passages and method."""
    answers = {}
    for name, numbers in pairs.items():
        reference, query = passage_pair(results, numbers, n_frames)
        truth = truth_between(reference, query)
        for method in (VANILLA, SKY, TRUE):
            answers[name, method] = in_sequences(differences(reference, query, method), truth)
        answers[name, SINGLE] = by_rotation(reference, query, truth, results.cells[0].size).single
    return answers


def differences(reference: Arrays, query: Arrays, method: str) -> Floats:
    """Matrix (reference, query) of a method that compares frames by a distance; sums of absolute ones, as published."""
    names = {
        VANILLA: "patches", NEUTRAL: "patches", SKY: "amplitudes", POINTS: "point_amplitudes",
        TRUE: "true_amplitudes", PLAIN: "plain_amplitudes", WATERSHED: "watershed_amplitudes",
    }  # fmt: skip
    chosen = names[method]
    one, other = (arrays[chosen] for arrays in (reference, query))
    if method == NEUTRAL:
        one, other = neutral_patches(one), neutral_patches(other)
    return difference_matrix(one, other, "openseqslam-v1")


def neutral_patches(patches: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The same (frame, pixel) with 127 in patches without contrast, where OpenSeqSLAM has 0."""
    blocks = patches.reshape(-1, *FLAT_BLOCK)
    is_flat = (blocks == 0).all(axis=(2, 4), keepdims=True)
    return np.where(is_flat, np.uint8(127), blocks).reshape(patches.shape)


def in_sequences(
    matrix: Floats, truth: Floats, sequence_length: int = SEQUENCE, *, whole_contrast: bool = False
) -> Recognised:
    """Answers of SeqSLAM as of OpenSeqSLAM v1, from a matrix (reference, query).

    With `whole_contrast` each difference is measured against those to all references instead of the ten next to it.
    """
    params = replace(OPENSEQSLAM_V1, sequence_length=sequence_length)
    if whole_contrast:
        params = replace(params, contrast_window=2 * len(matrix))
    found = seqslam(matrix, params, workers=1)
    return Recognised(reference=found.reference, score=found.score, truth=truth)


def skies(arrays: Arrays) -> NDArray[np.bool_]:
    """Masks of the sky on the directions of `sky_grid`, (frame, direction)."""
    return np.unpackbits(arrays["sky"], axis=-1, count=sky_grid().n_directions).astype(bool)


@dataclass(frozen=True, kw_only=True, eq=False)
class ByRotation:
    """What the matching over all rotations gives: answers of single frames, and a matrix for sequences.

    Sequences are found with `in_sequences`, contrast over all references: that of neighbours takes the difference
    between one part of the way and another away, which a mask of the sky, unlike grey pictures, tells in any light.
    """

    single: Recognised
    matrix: Floats
    tilt: Floats  # (query,) [rad] between the cameras' axes


def by_rotation(reference: Arrays, query: Arrays, truth: Floats, size: int) -> ByRotation:
    """Skies compared at every relative rotation, where both cameras saw."""
    index, seen = rotation_index(reference, size), sky_sampler(size, "rings").seen
    views = skies(query)
    found, compared = index.match_and_compare(views, seen)
    return ByRotation(
        single=Recognised(reference=found.reference, score=found.ratio, truth=truth),
        matrix=compared.T,
        tilt=found.tilt,
    )


def rotation_index(arrays: Arrays, size: int) -> RotationIndex:
    """Skies of a passage to be found by those of another."""
    return build_rotation_index(skies(arrays), sky_sampler(size, "rings").seen, sky_grid())


def truth_between(reference: Arrays, query: Arrays) -> Floats:
    """True place of each query [reference frame]; frames count from the first that was rendered."""
    return true_references(reference["distance"], query["distance"])


def turned_apart(reference: Arrays, query: Arrays, truth: Floats) -> Floats:
    """Angle between the camera of each query and that of its true place, mean over a sequence about it, (query,) [rad].

    Sequences have eleven frames; at the ends of the passage there are fewer.
    """
    nearest = np.clip(np.rint(truth), 0, len(reference["distance"]) - 1).astype(int)
    here, there = (rotation_matrix(*angles.T) for angles in (query["orientation"], reference["orientation"][nearest]))
    angle = rotation_between(here, there)
    length = np.ones(SEQUENCE + 1)
    return np.asarray(np.convolve(angle, length, "same") / np.convolve(np.ones(len(angle)), length, "same"))


def thirds_by_turn(answer: Recognised, turned: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """The third of the matched queries whose cameras are turned apart least, and most, (query,) each."""
    known = np.isfinite(answer.score)
    low, high = np.quantile(turned[known], [1 / 3, 2 / 3])
    return known & (turned <= low), known & (turned >= high)
