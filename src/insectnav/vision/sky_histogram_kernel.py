"""Histograms of pixels by brightness and by how far up they look, compiled: one pass over the picture."""

import numpy as np

from insectnav.lanes.compiled import kernel
from insectnav.vision.sky_levels import LEFT_OUT


@kernel
def weigh_bands(bands, weights, out):
    """Weighted sum of the bands of each pixel, (pixel, band) to (pixel,)."""
    n_bands = bands.shape[1]
    if n_bands == 3:  # unrolled, which is four times as fast
        first, second, third = weights[0], weights[1], weights[2]
        for i in range(bands.shape[0]):
            out[i] = first * bands[i, 0] + second * bands[i, 1] + third * bands[i, 2]
        return
    for i in range(bands.shape[0]):
        total = np.float32(0.0)
        for k in range(n_bands):
            total += weights[k] * bands[i, k]
        out[i] = total


@kernel
def extremes(values, levels):
    """Least and greatest value among the pixels that count."""
    least, greatest = np.inf, -np.inf
    for i in range(values.shape[0]):
        if levels[i] != LEFT_OUT:
            least, greatest = min(least, values[i]), max(greatest, values[i])
    return least, greatest


@kernel
def sum_classes(values, levels, mask, counts):
    """Pixels of ground and sky by elevation level, added to ``counts`` (2, level), and the sums of their values."""
    ground, sky = 0.0, 0.0
    for i in range(values.shape[0]):
        level = levels[i]
        if level == LEFT_OUT:
            continue
        if mask[i]:
            counts[1, level] += 1
            sky += values[i]
        else:
            counts[0, level] += 1
            ground += values[i]
    return ground, sky


@kernel
def count(values, levels, low, scale, counts):
    """Pixels by elevation level and bin, added to ``counts`` (level, bin); values beyond the bins go into the last.

    Bin k holds values from ``low + k / scale`` up to ``low + (k + 1) / scale``.
    """
    last = counts.shape[1] - 1
    for i in range(values.shape[0]):
        level = levels[i]
        if level != LEFT_OUT:
            place = (values[i] - low) * scale
            counts[level, min(max(int(place), 0), last)] += 1


@kernel
def count_whole_numbers(values, levels, counts):
    """The same for whole numbers, each a bin of its own."""
    for i in range(values.shape[0]):
        level = levels[i]
        if level != LEFT_OUT:
            counts[level, values[i]] += 1


@kernel
def split(values, levels, threshold, is_sky_brighter, mask):
    """Whether each pixel counts and lies on the sky's side of the threshold."""
    for i in range(values.shape[0]):
        mask[i] = (levels[i] != LEFT_OUT) & ((values[i] > threshold) == is_sky_brighter)


@kernel
def persistent_valley(heights, order, parent, peak):
    """The bin of the valley that divides the two most persistent peaks of a histogram, or -1 where there is one peak.

    Bins are flooded from the highest down. Where two lakes meet, the one with the lower peak ends; what it rose above
    their meeting point is the depth of the valley. The deepest valley is the one that is merged last.
    """
    n = heights.shape[0]
    deepest, valley = 0.0, -1
    parent[:] = -1
    for bin_ in order:
        parent[bin_] = bin_
        peak[bin_] = heights[bin_]
        for neighbour in (bin_ - 1, bin_ + 1):
            if neighbour < 0 or neighbour >= n or parent[neighbour] < 0:
                continue
            one, other = bin_, neighbour
            while parent[one] != one:
                one = parent[one]
            while parent[other] != other:
                other = parent[other]
            if one == other:
                continue
            lower, higher = (one, other) if peak[one] <= peak[other] else (other, one)
            if peak[lower] - heights[bin_] > deepest:
                deepest, valley = peak[lower] - heights[bin_], bin_
            parent[lower] = higher
    return valley


@kernel
def sky_cues(bands, scale, blue_weight, yellow_weight, tolerance, brightness, raw):
    """Mean of red, green, blue, and blue with a bonus for blueness and a penalty for yellowness; white becomes 1.

    Yellowness up to the tolerance has no penalty.
    """
    third = np.float32(1.0 / 3.0)
    for i in range(bands.shape[0]):
        red, green, blue = scale * bands[i, 0], scale * bands[i, 1], scale * bands[i, 2]
        blueness = blue - red
        brightness[i] = third * (red + green + blue)
        if blueness > 0.0:
            raw[i] = blue + blue_weight * blueness
        else:
            raw[i] = blue + yellow_weight * min(blueness + tolerance, np.float32(0.0))


@kernel
def steps_across(values, levels, mask, whole_step):
    """Mean change of value across the outline of a mask, as a share of ``whole_step`` and at most 1; pairs counted.

    Across each border between two pixels in a row or a column, the change is taken over four pixels, two on either
    side, so that an outline blurred over a pixel still counts as a full step.
    """
    rows, columns = mask.shape
    total, n = 0.0, 0
    for i in range(rows):
        for j in range(columns):
            for down, right in ((0, 1), (1, 0)):
                k, m = i + down, j + right
                if k >= rows or m >= columns or mask[i, j] == mask[k, m]:
                    continue
                if levels[i, j] == LEFT_OUT or levels[k, m] == LEFT_OUT:
                    continue
                before, after = (
                    (max(i - down, 0), max(j - right, 0)),
                    (min(k + down, rows - 1), min(m + right, columns - 1)),
                )
                if levels[before] == LEFT_OUT:
                    before = i, j
                if levels[after] == LEFT_OUT:
                    after = k, m
                step = abs(np.float64(values[after]) - np.float64(values[before]))
                total += min(step / whole_step, 1.0)
                n += 1
    return (total / n if n else 0.0), n
