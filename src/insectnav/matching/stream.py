"""SeqSLAM on the move: one frame in, the best match so far out."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, check_finite
from insectnav.matching.difference import References, prepare_references
from insectnav.matching.seqslam import Matches, SeqSlamParams, matches_from_lines

Reals = NDArray[np.floating[Any]]


class StreamMatch(NamedTuple):
    """What is known after a frame: the match of an earlier frame, and where its line has led to by now."""

    query: int  # number of the frame that is matched, from 0; −1 as long as there is none
    reference: int  # its match, −1 where there is none
    score: float  # as of `Matches`
    speed: float  # [reference frame per query frame] as of `Matches`
    reference_now: int  # where the line ends: the match of the newest frame; −1 where there is none
    latency_frames: int  # [frame] from the frame that is matched to the newest, half a sequence
    latency: float  # [s] the same in time; NaN if frames come without times


@dataclass(frozen=True, kw_only=True, eq=False)
class Stream:
    """What a robot keeps between frames; made by `begin_stream`, carried on by `locate_next`.

    Parameters
    ----------
    references : descriptors of the route
    params : SeqSlamParams
    contrast : (frame, reference) array, of the newest frames
    is_seen : (frame,) which of them were not missing
    times : (frame,) array [s] of these, NaN if they come without
    n_frames : that have come so far
    """

    references: References
    params: SeqSlamParams
    contrast: Reals
    is_seen: NDArray[np.bool_]
    times: Reals
    n_frames: int = 0


def begin_stream(references: ArrayLike, metric: str = "cosine", params: SeqSlamParams | None = None) -> Stream:
    """A stream before its first frame.

    Parameters
    ----------
    references : (reference, feature) array
        Descriptors of the route; a row of NaN for a frame that is missing.
    metric : str
        As of `difference_matrix`.
    params : SeqSlamParams
        With the baseline "bound": the least contrast "observed" is known only when all frames have come.

    Raises
    ------
    InputError
        If there are fewer references than a sequence is long, or the baseline is not known beforehand.
    """
    params = params or SeqSlamParams()
    if params.baseline != "bound":
        raise InputError(
            f"baseline is {params.baseline!r}, expected 'bound': a stream knows its least contrast at its end alone"
        )
    prepared, n = prepare_references(references, metric), params.n_steps + 1
    n_references = len(prepared.is_missing)
    params.check_length(n_references, "reference", "references")
    return Stream(
        references=prepared,
        params=params,
        contrast=np.zeros((n, n_references)),
        is_seen=np.zeros(n, bool),
        times=np.full(n, np.nan),
    )


def locate_next(stream: Stream, descriptor: ArrayLike | None, time: float | None = None) -> tuple[Stream, StreamMatch]:
    """The stream after one more frame, and what is known by then.

    Parameters
    ----------
    stream : Stream
        Stays as it is.
    descriptor : (feature,) array
        Of the frame; None if it is missing, as a corrupt image is.
    time : float [s]
        When it was taken; later than the frame before, whether or not that is missing.

    Returns
    -------
    Stream, StreamMatch
        The match is that of `seqslam` on all frames together.

    Raises
    ------
    InputError
        If the descriptor is not of the references' kind, or the frame is not later than the one before.
    """
    from insectnav.matching.sequence_kernel import enhance_rows, search_sequences

    params = stream.params
    column = _column(stream.references, descriptor)
    contrast, is_seen = np.empty(column.shape), np.empty(1, bool)
    enhance_rows(column, params.contrast_window // 2, params.flat, contrast, is_seen)
    after = replace(
        stream,
        contrast=np.concatenate([stream.contrast[1:], contrast]),
        is_seen=np.append(stream.is_seen[1:], is_seen),
        times=np.append(stream.times[1:], later(stream.n_frames, float(stream.times[-1]), time)),
        n_frames=stream.n_frames + 1,
    )

    def newest() -> tuple[int, int, Matches]:
        found = (np.empty(1, np.int64), np.empty(1), np.empty(1, np.int64))
        search_sequences(after.contrast, after.is_seen, params.offsets, params.unique_window // 2, params.bound, *found)
        return int(found[0][0]), int(found[2][0]), matches_from_lines(found, params, params.n_steps + 1)

    return after, match_so_far(after.n_frames, after.times, params, newest)


def match_so_far(
    n_frames: int, times: Reals, params: SeqSlamParams, newest: Callable[[], tuple[int, int, Matches]]
) -> StreamMatch:
    """What is known after so many frames.

    Parameters
    ----------
    n_frames : that have come
    times : (frame,) array [s] of the newest sequence
    params : SeqSlamParams
    newest : gives start and number of the speed of the line through the newest sequence, and the matches of its frames;
        asked once the sequence is whole
    """
    half = params.n_steps // 2
    query, latency = n_frames - 1 - half, float(times[-1] - times[half])
    if n_frames <= params.n_steps:
        return StreamMatch(max(query, -1), -1, np.nan, np.nan, -1, half, latency)
    start, speed, matches = newest()
    match = (int(matches.reference[half]), float(matches.score[half]), float(matches.speed[half]))
    end = start + int(params.offsets[speed, -1]) if match[0] >= 0 else -1
    return StreamMatch(query, *match, end, half, latency)


def _column(references: References, descriptor: ArrayLike | None) -> Reals:
    """Differences of one frame from all references, (1, reference); NaN if it is missing."""
    if descriptor is None:
        return np.full((1, len(references.is_missing)), np.nan, np.float32)
    vector = np.asarray(descriptor)
    if vector.ndim != 1:
        raise InputError(f"descriptor has shape {vector.shape}, expected (feature,): one frame at a time")
    return np.ascontiguousarray(references.differences(vector[None], workers=1).T)


def later(frame: int, before: float, time: float | None) -> float:
    """The time of a frame [s], NaN if frames come without; refused if it does not follow that of the frame before.

    Parameters
    ----------
    frame : its number
    before : when the frame before it was taken [s], NaN without times
    time : when it was taken [s]

    Raises
    ------
    InputError
        If it is not later, or only one of the two has a time.
    """
    if time is None:
        if np.isfinite(before):
            raise InputError(f"frame {frame} has no time, expected one as the frame before has")
        return np.nan
    check_finite("time", time)
    if frame and not np.isfinite(before):
        raise InputError(f"frame {frame} has a time, expected none as the frame before has none")
    if frame and time <= before:
        raise InputError(
            f"frame {frame} was taken at {time:g} s, expected later than the one before at {before:g} s: "
            "out of order, or twice the same?"
        )
    return float(time)
