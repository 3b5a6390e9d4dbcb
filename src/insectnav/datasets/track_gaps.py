"""Fill the short gaps of a recorded track; refuse the long ones."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from insectnav.angles import Floats, wrap
from insectnav.checks import InputError

MAX_SAMPLES = 20_000_000  # of a filled track


@dataclass(frozen=True, kw_only=True)
class GapLimits:
    """Gaps longer than either limit are refused."""

    max_gap_s: float = 1.0  # [s] ours; ignored where time is in frames
    max_gap_samples: int = 20  # [median intervals] ours


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """A track as recorded.

    Parameters
    ----------
    row : (n,) array, the row of each sample in its file
    time : (n,) array [time_unit], strictly increasing
    position : (n, 2) array, NaN where missing
    heading : (n,) array [rad], NaN where missing; None if not recorded
    time_unit : "s" or "frame"
    """

    row: npt.NDArray[np.int64]
    time: Floats
    position: Floats
    heading: Floats | None
    time_unit: str

    @property
    def is_complete(self) -> npt.NDArray[np.bool_]:
        """Whether nothing of a sample is missing: (n,) array."""
        x, y = self.position.T
        complete = ~(np.isnan(x) | np.isnan(y))
        return complete if self.heading is None else complete & ~np.isnan(self.heading)


@dataclass(frozen=True, kw_only=True, eq=False)
class FilledTrack:
    """A track without gaps, how many samples were filled in, and how many cut off at the ends."""

    time: Floats
    position: Floats
    heading: Floats | None
    n_filled: int
    n_cut: int


def fill_gaps(samples: Samples, limits: GapLimits) -> FilledTrack:
    """The track with its missing samples interpolated, headings along the shorter arc.

    Where whole rows are absent, samples are put in at about the median interval. Incomplete
    samples at the ends are cut off.
    """
    complete = samples.is_complete
    median = float(np.median(np.diff(samples.time)))
    _refuse_long_gaps(samples, complete, median, limits)
    first, last = np.flatnonzero(complete)[[0, -1]]
    kept = samples.time[first : last + 1]
    time = np.sort(np.concatenate([kept, _absent_times(kept, median)]))
    known_time, heading = samples.time[complete], samples.heading
    if heading is not None:
        heading = wrap(_interpolate(time, known_time, np.unwrap(heading[complete])))
    return FilledTrack(
        time=time,
        position=_interpolate(time, known_time, samples.position[complete]),
        heading=heading,
        n_filled=time.size - known_time.size,
        n_cut=samples.time.size - kept.size,
    )


def _refuse_long_gaps(samples: Samples, complete: npt.NDArray[np.bool_], median: float, limits: GapLimits) -> None:
    # The first and last rows count as ends of a gap even where they hold no position.
    ends = np.concatenate([samples.time[:1], samples.time[complete], samples.time[-1:]])
    length = np.diff(ends)
    rounding = 4 * np.spacing(np.abs(ends).max())
    too_slow = length > limits.max_gap_s * (1 + 1e-9) + rounding
    too_slow &= samples.time_unit == "s"
    too_many = length > limits.max_gap_samples * median * (1 + 1e-9) + rounding
    refused = np.flatnonzero((length > 1.5 * median + rounding) & (too_slow | too_many))
    if not refused.size:
        return
    worst = int(refused[0])
    rows = samples.row[complete]
    where = f"before row {rows[worst]}" if worst < rows.size else f"after row {rows[-1]}"
    size = float(length[worst])
    if too_slow[worst]:
        gap, limit, option = f"{size:.3g} s", f"{limits.max_gap_s:g} s is", "--max-gap"
    else:
        unit = "s" if samples.time_unit == "s" else "frames"
        gap = f"{size / median:.0f} samples ({size:.6g} {unit})"
        limit, option = f"{limits.max_gap_samples} samples are", "--max-gap-samples"
    raise InputError(f"gap of {gap} {where}, at most {limit} filled: raise {option}, or cut the track there")


def _absent_times(time: Floats, median: float) -> Floats:
    """Times of the rows that the table lacks, evenly spaced in each gap."""
    interval = np.diff(time)
    gap = np.flatnonzero(interval > 1.5 * median)
    with np.errstate(over="ignore"):
        pieces = np.rint(interval[gap] / median)
    if time.size + pieces.sum() > MAX_SAMPLES:
        raise InputError(
            f"filling the gaps would make more than {MAX_SAMPLES} samples, expected a track with fewer: "
            "is one time far off?"
        )
    n_absent = np.maximum(pieces.astype(int) - 1, 0)
    which = np.repeat(np.arange(gap.size), n_absent)
    nth = np.arange(which.size) - np.repeat(np.cumsum(n_absent) - n_absent, n_absent) + 1
    absent: Floats = time[gap][which] + interval[gap][which] * (nth / pieces[which])
    return absent


def _interpolate(time: Floats, known_time: Floats, known: Floats) -> Floats:
    # numpy.interp divides by the interval first, which overflows where times are tiny.
    after = np.clip(np.searchsorted(known_time, time, side="right"), 1, known_time.size - 1)
    before = after - 1
    weight = (time - known_time[before]) / (known_time[after] - known_time[before])
    weight = weight.reshape(-1, *[1] * (known.ndim - 1))
    values: Floats = (1 - weight) * known[before] + weight * known[after]
    return values
