"""SeqSLAM: where on a route a sequence of frames was taken, by the best line through a matrix of differences."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_count, check_range, check_shape, counted
from insectnav.workers import run_blocks

Reals = NDArray[np.floating[Any]]
Integers = NDArray[np.int64]
BASELINES = ("bound", "observed")
QUERIES_PER_BLOCK = 64
ROUNDING = 1e-12  # [mean] standard deviation of a window of equal differences in double precision, at most


@dataclass(frozen=True, kw_only=True)
class SeqSlamParams:
    """How SeqSLAM searches; the numbers are those of OpenSeqSLAM and of Stone et al., ICRA 2016, section IV."""

    sequence_length: int = 10  # [frame] ds, steps from first to last; odd ones are rounded up; 1: frames one by one
    contrast_window: int = 10  # [frame] R_window of the contrast: neighbours on the reference axis
    unique_window: int = 10  # [frame] R_window of the score: starts that count as the same place
    slowest: float = 0.8  # [reference frame per query frame]
    fastest: float = 1.2  # [reference frame per query frame]
    baseline: str = "bound"  # contrast at which a score is 0: the least possible, or "observed" in the matrix as in v1
    place: str = "line"  # of the middle query: where the "line" runs, or "start" + ds / 2 whatever its speed, as in v1
    least_contrast: float = 1e-5  # [mean] standard deviation of a window at which its contrast is nothing; assumed

    def __post_init__(self) -> None:
        check_count("sequence_length", self.sequence_length)
        check_count("contrast_window", self.contrast_window, minimum=2)
        check_count("unique_window", self.unique_window, minimum=0)
        check_range("slowest", self.slowest, 0.0, 100.0)
        check_range("fastest", self.fastest, self.slowest, 100.0, slip="slowest and fastest interchanged?")
        check_choice("baseline", self.baseline, BASELINES)
        check_choice("place", self.place, ("line", "start"))
        check_range("least_contrast", self.least_contrast, 0.0, 1.0)

    @property
    def n_steps(self) -> int:
        """Steps from the first to the last frame of a sequence; even."""
        return 0 if self.sequence_length == 1 else self.sequence_length + self.sequence_length % 2

    @cached_property
    def offsets(self) -> Integers:
        """Reference frames from the start of a line to each of its frames, (speed, step)."""
        n = self.n_steps
        if n == 0:
            return np.zeros((1, 1), np.int64)
        # Speeds are whole multiples of 1 / ds from the slowest on; a sum of floats could miss the last of them.
        n_speeds = int(np.floor((self.fastest - self.slowest) * n + 1e-9)) + 1
        speeds = self.slowest * n + np.arange(n_speeds)
        steps = np.floor(speeds[:, None] * np.arange(n + 1) / n + 1e-9).astype(np.int64)
        return np.unique(steps, axis=0)

    def check_length(self, n_frames: int, one: str, many: str, slip: str = "?") -> None:
        """Refuse fewer frames than a sequence is long.

        Parameters
        ----------
        n_frames : int
        one, many : what they are
        slip : how the sentence ends

        Raises
        ------
        InputError
            If there are too few.
        """
        if n_frames < self.n_steps + 1:
            raise InputError(
                f"there {'is' if n_frames == 1 else 'are'} {counted(n_frames, one, many)}, expected at least "
                f"{self.n_steps + 1} for sequences of {counted(self.sequence_length, 'step')}: fewer frames than a "
                f"sequence{slip}"
            )

    @property
    def flat(self) -> float:
        """Standard deviation at which a window has no contrast, as a share of its mean; above rounding."""
        return max(self.least_contrast, ROUNDING)

    @property
    def bound(self) -> float:
        """Least contrast that a window can have: ``−(n − 1) / sqrt(n)`` of n frames, all equal but one."""
        n = 2 * (self.contrast_window // 2) + 1
        return -(n - 1) / float(np.sqrt(n))


OPENSEQSLAM_V1 = SeqSlamParams(baseline="observed", place="start", least_contrast=0.0)


class Matches(NamedTuple):
    """The best reference for each query, (query,) arrays."""

    reference: Integers  # −1 where there is none
    score: Reals  # 0 unique … 1 as good as another place; NaN where there is none
    speed: Reals  # [reference frame per query frame] of the line, NaN where there is none


def no_matches(n_queries: int) -> Matches:
    """Matches of queries none of which has one yet, to be filled in."""
    return Matches(np.full(n_queries, -1), np.full(n_queries, np.nan), np.full(n_queries, np.nan))


def enhance_contrast(
    difference: ArrayLike, params: SeqSlamParams | None = None, *, workers: int | None = None
) -> Reals:
    """Each difference less the mean of its neighbours, over their standard deviation, (reference, query) float64.

    ``E[i, j] = (D[i, j] − mean) / std`` of ``D[i − w … i + w, j]``, w half the contrast window, standard deviation over
    n − 1, fewer at the ends; then less the baseline, so that none is negative.

    Parameters
    ----------
    difference : (reference, query) array
        Of `difference_matrix`; NaN for missing frames.
    params : SeqSlamParams
    workers : threads; they change nothing in the results

    Returns
    -------
    (reference, query) array
        Where a window has no contrast, or a frame is missing, it is as if there were the mean: neither for nor against.

    Raises
    ------
    InputError
        If there are fewer references than a sequence is long, or infinite values.

    Notes
    -----
    Local contrast of Milford & Wyeth, ICRA 2012, doi 10.1109/ICRA.2012.6224623, in the form of OpenSeqSLAM v1. That
    takes the least value of the whole matrix off; the default takes the least that could be, which is known before the
    last frame has come.
    """
    params = params or SeqSlamParams()
    rows = _checked_rows(difference, params)
    out = np.empty(rows.shape)
    least = _enhance(rows, params, out, workers)
    out -= least if params.baseline == "observed" else params.bound
    return out.T


def seqslam(difference: ArrayLike, params: SeqSlamParams | None = None, *, workers: int | None = None) -> Matches:
    """The reference that each query matches best, with the frames before and after it.

    Parameters
    ----------
    difference : (reference, query) array
        Of `difference_matrix`, frames in the order in which they were taken; NaN for missing frames.
    params : SeqSlamParams
        `OPENSEQSLAM_V1` gives the answers of that program.
    workers : threads; they change nothing in the results

    Returns
    -------
    Matches
        The first and last half sequence of the queries have no match, nor have queries in whose sequence more than half
        of the frames are missing, or that no reference tells from another. Lower scores are better; keep those below a
        threshold.

    Raises
    ------
    InputError
        If there are fewer references or queries than a sequence is long, or infinite values.

    Notes
    -----
    Milford & Wyeth, ICRA 2012, doi 10.1109/ICRA.2012.6224623, in the form of OpenSeqSLAM v1 (Sünderhauf, Neubert &
    Protzel 2013): contrast enhanced; for query N lines from each start s through the differences of queries
    N − ds/2 … N + ds/2, at speeds from slowest to fastest in steps of 1/ds, row ``s + floor(v k)`` at step k; the score
    is the least sum over the least of starts outside ±R_window/2. A line that runs beyond the last reference does not
    count.
    """
    params = params or SeqSlamParams()
    rows = _checked_rows(difference, params)
    params.check_length(len(rows), "query", "queries")
    baseline = _enhance(rows, params, None, workers) if params.baseline == "observed" else params.bound
    n_sequences = len(rows) - params.n_steps
    found = (np.empty(n_sequences, np.int64), np.empty(n_sequences), np.empty(n_sequences, np.int64))
    run_blocks(lambda *block: _search(rows, params, baseline, found, *block), n_sequences, QUERIES_PER_BLOCK, workers)
    return matches_from_lines(found, params, len(rows))


def matches_from_lines(found: tuple[Integers, Reals, Integers], params: SeqSlamParams, n_queries: int) -> Matches:
    """Matches of all queries from the start, score and number of the speed of each line.

    Parameters
    ----------
    found : start, score and speed of the sequences, (sequence,) each
    params : SeqSlamParams
    n_queries : the first and last half sequence of which have no match
    """
    start, score, speed = found
    half, is_match = params.n_steps // 2, start >= 0
    offsets = params.offsets[np.maximum(speed, 0)]
    middle = offsets[:, half] if params.place == "line" else half
    inner = slice(half, n_queries - half)
    matches = no_matches(n_queries)
    matches.reference[inner] = np.where(is_match, start + middle, -1)
    matches.score[inner] = score
    matches.speed[inner] = np.where(is_match, offsets[:, -1] / max(params.n_steps, 1), np.nan)
    return matches


def _checked_rows(difference: ArrayLike, params: SeqSlamParams) -> Reals:
    """Differences as (query, reference) in one piece, in single or double precision."""
    array = as_numbers("difference", difference)
    check_shape("difference", array, ("reference", "query"))
    params.check_length(len(array), "reference", "references", ", or transposed?")
    rows = np.ascontiguousarray(array.T, array.dtype if array.dtype in (np.float32, np.float64) else np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        is_finite = bool(np.isfinite(rows.sum()))
    if not is_finite and np.isinf(rows).any():
        raise InputError("difference holds infinite values, expected finite ones, or NaN for frames that are missing")
    return rows


def _enhance(rows: Reals, params: SeqSlamParams, out: Reals | None, workers: int | None) -> float:
    """Fill contrasts (query, reference), unless they are not to be kept; the least of them."""
    from insectnav.matching.sequence_kernel import enhance_rows

    least = []

    def run(first: int, last: int) -> None:
        block = rows[first:last]
        contrast, is_seen = np.empty(block.shape) if out is None else out[first:last], np.empty(len(block), bool)
        least.append(enhance_rows(block, params.contrast_window // 2, params.flat, contrast, is_seen))

    run_blocks(run, len(rows), QUERIES_PER_BLOCK, workers)
    return min(least)


def _search(rows: Reals, params: SeqSlamParams, baseline: float, found: tuple[Any, ...], first: int, last: int) -> None:
    """Fill what was found for the sequences from first up to last; contrasts of a block at a time are kept."""
    from insectnav.matching.sequence_kernel import enhance_rows, search_sequences

    block = rows[first : last + params.n_steps]
    contrast, is_seen = np.empty(block.shape), np.empty(len(block), bool)
    enhance_rows(block, params.contrast_window // 2, params.flat, contrast, is_seen)
    start, score, speed = (array[first:last] for array in found)
    search_sequences(contrast, is_seen, params.offsets, params.unique_window // 2, baseline, start, score, speed)
