"""Thresholds between sky and ground from a histogram of one channel: Otsu, and two readings of the watershed.

All of them take a `Histogram` and know nothing of pictures. Otsu (1979), IEEE Trans. Syst. Man Cybern. 9:62, doi
10.1109/TSMC.1979.4310076. The histogram watershed is described in words by Stone, Mangan, Ardin & Webb (2014), RSS, doi
10.15607/RSS.2014.X.047, section II.E.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.vision.sky_levels import LEFT_OUT

Reals = NDArray[np.float64]

N_LEVELS = 32  # of elevation; enough for a sign and for a confidence
N_BINS = 1024  # of values that are no bytes
LEFT_OUT_SHARE = 0.02  # at each end; Stone et al. (2014), section II.E
CROWDED = 8  # a histogram whose middle 96 % fill less than one part in so many is counted again, more finely
WATERSHED_BINS = 128  # assumed, with the next; accuracy on photographs hardly changes from 32 to 256 bins of this blur
WATERSHED_SIGMA = 2.0  # [bin] of the Gaussian that takes away the teeth of a histogram
TOOTH = 0.02  # of the highest peak; a valley less deep is the rest of a tooth and no valley; assumed


@dataclass(frozen=True, kw_only=True, eq=False)
class Histogram:
    """Pixels of one channel by elevation and value.

    Parameters
    ----------
    counts : (level, bin) array of int, level 0 the lowest elevation
    low : lower end of the first bin, in the unit of the channel
    width : of a bin
    """

    counts: NDArray[np.int64]
    low: float
    width: float

    @property
    def by_value(self) -> Reals:
        """Pixels in each bin, (bin,)."""
        return self.counts.sum(axis=0).astype(np.float64)

    def edge(self, place: float) -> float:
        """Value at a place counted in bins: 0 the lower end of the first, 1 its upper end."""
        return self.low + place * self.width


def histogram(values: NDArray[Any], levels: NDArray[np.uint8], *, zoom: bool = False) -> Histogram | None:
    """Histogram of the pixels that count; None where they all have one value.

    Parameters
    ----------
    values : (rows, columns) array of uint8, each value a bin of its own, or float32
    levels : (rows, columns) elevation levels, `LEFT_OUT` where a pixel does not count
    zoom : where the middle 96 % fill but few bins, divide their range alone; what lies beyond goes into the end bins
    """
    from insectnav.vision.sky_histogram_kernel import count_whole_numbers, extremes

    flat, flat_levels = np.ravel(values), np.ravel(levels)
    if flat.dtype == np.uint8:
        counts = np.zeros((N_LEVELS, 256), np.uint32)
        count_whole_numbers(flat, flat_levels, counts)
        found = Histogram(counts=counts.astype(np.int64), low=-0.5, width=1.0)
        return found if np.count_nonzero(found.by_value) > 1 else None
    if flat_levels.max() < LEFT_OUT:  # NumPy's own are faster
        low, high = float(flat.min()), float(flat.max())
    else:
        low, high = extremes(flat, flat_levels)
    if not low < high:
        return None
    found = _count(flat, flat_levels, low, high)
    middle = np.flatnonzero(_middle(found.by_value))
    if zoom and CROWDED * len(middle) < N_BINS:  # the sun, say, is a hundred times as bright as all the rest
        margin = 1 + len(middle)
        low = max(low, found.edge(float(middle[0] - margin)))
        high = min(high, found.edge(float(middle[-1] + 1 + margin)))
        found = _count(flat, flat_levels, low, high)
    return found


def _count(values: NDArray[Any], levels: NDArray[np.uint8], low: float, high: float) -> Histogram:
    from insectnav.vision.sky_histogram_kernel import count

    counts = np.zeros((N_LEVELS, N_BINS), np.uint32)
    count(values, levels, np.float32(low), np.float32(N_BINS / (high - low)), counts)
    return Histogram(counts=counts.astype(np.int64), low=low, width=(high - low) / N_BINS)


def _middle(by_value: Reals) -> NDArray[np.bool_]:
    """Bins that hold a pixel which is neither among the darkest nor among the brightest 2 %."""
    cumulated = np.cumsum(by_value)
    total = cumulated[-1]
    return (cumulated > LEFT_OUT_SHARE * total) & (cumulated - by_value < (1.0 - LEFT_OUT_SHARE) * total)


def otsu(found: Histogram) -> float:
    """Threshold that maximises the variance between two classes; midway where several are as good.

    Notes
    -----
    σ_B²(k) = (μ_T ω(k) − μ(k))² / (ω(k) (1 − ω(k))), Otsu (1979), Eq. 18.
    """
    share = found.by_value / found.by_value.sum()
    omega = np.cumsum(share)[:-1]
    mu = np.cumsum(share * np.arange(len(share)))
    with np.errstate(invalid="ignore", divide="ignore"):
        between = (mu[-1] * omega - mu[:-1]) ** 2 / (omega * (1.0 - omega))
    between[(omega <= 0.0) | (omega >= 1.0 - 1e-12)] = -1.0
    best = np.flatnonzero(between >= between.max() * (1.0 - 1e-12))
    return found.edge((best[0] + best[-1]) / 2.0 + 1.0)


def upper_of_three_classes(found: Histogram, n_bins: int = 128) -> float:
    """The upper of the two thresholds that maximise the variance between three classes.

    Notes
    -----
    Otsu (1979), section III. In pictures of streets and trees the three are shade, lit surfaces and sky.
    """
    by_value, edges = _rebinned(found, np.ones(len(found.by_value), bool), n_bins)
    share = by_value / by_value.sum()
    omega = np.cumsum(share)
    mu = np.cumsum(share * np.arange(n_bins))
    first, second = np.triu_indices(n_bins - 1, k=1)
    weights = np.stack([omega[first], omega[second] - omega[first], 1.0 - omega[second]])
    sums = np.stack([mu[first], mu[second] - mu[first], mu[-1] - mu[second]])
    between = np.where(weights > 1e-12, sums**2 / np.maximum(weights, 1e-12), 0.0).sum(axis=0)
    best = second[between >= between.max() * (1.0 - 1e-12)]  # across an empty gap all are as good
    return float((edges[best.min() + 1] + edges[best.max() + 1]) / 2.0)


def watershed_merge(found: Histogram) -> float | None:
    """Threshold in the valley between the two most persistent peaks: the shallowest valley is merged until two remain.

    None where there is one peak only.
    """
    from insectnav.vision.sky_histogram_kernel import persistent_valley

    heights, edges = _smooth(found)
    order = np.argsort(-heights, kind="stable")
    valley = persistent_valley(heights, order, np.empty(len(heights), np.int64), np.empty(len(heights)))
    if valley < 0 or min(heights[:valley].max(), heights[valley:].max()) - heights[valley] < TOOTH * heights.max():
        return None
    lowest = heights[valley]
    start, end = valley, valley  # a flat bottom is divided in its middle
    while start > 0 and heights[start - 1] == lowest:
        start -= 1
    while end < len(heights) - 1 and heights[end + 1] == lowest:
        end += 1
    return float((edges[start] + edges[end + 1]) / 2.0)


def watershed_islands(found: Histogram) -> float | None:
    """Threshold midway between two islands that remain as the water rises over the histogram.

    None where the water never leaves two.
    """
    heights, edges = _smooth(found)
    for water in np.unique(heights):
        above = np.concatenate([[0], (heights > water).astype(np.int8), [0]])
        steps = np.diff(above)
        starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
        if len(starts) == 2:
            return float((edges[ends[0]] + edges[starts[1]]) / 2.0)
    return None


def _smooth(found: Histogram) -> tuple[Reals, Reals]:
    """Smoothed heights of the middle 96 % of the pixels and the edges of their bins."""
    from scipy.ndimage import gaussian_filter1d

    heights, edges = _rebinned(found, _middle(found.by_value), WATERSHED_BINS)
    return gaussian_filter1d(heights, WATERSHED_SIGMA, mode="nearest"), edges


def _rebinned(found: Histogram, keep: NDArray[np.bool_], n_bins: int) -> tuple[Reals, Reals]:
    """Heights of fewer or more bins over the range of those kept, as if pixels lay evenly within a bin, and edges."""
    kept = np.flatnonzero(keep & (found.by_value > 0))
    first, last = kept[0], kept[-1] + 1
    places = np.linspace(first, last, n_bins + 1)
    cumulated = np.concatenate([[0.0], np.cumsum(found.by_value)])
    heights = np.diff(np.interp(places, np.arange(len(cumulated)), cumulated))
    return heights, found.low + places * found.width


__all__ = [
    "LEFT_OUT",
    "N_LEVELS",
    "Histogram",
    "histogram",
    "otsu",
    "upper_of_three_classes",
    "watershed_islands",
    "watershed_merge",
]
