"""Catchment areas of twenty places, summarised and compared in pairs: rows that several experiments share."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from insectnav.metrics.paired_tests import paired_wilcoxon


def area_row(areas: ArrayLike) -> dict[str, Any]:
    """Mean, SD over places, standard error and the like of areas (place,) [m²]."""
    values = np.asarray(areas, float)
    sd = float(values.std(ddof=1))
    return {
        "mean_area_m2": float(values.mean()),
        "sd_m2": sd,
        "standard_error_m2": sd / values.size**0.5,
        "median_m2": float(np.median(values)),
        "least_m2": float(values.min()),
        "largest_m2": float(values.max()),
        "n": values.size,
    }


def paired_row(first: ArrayLike, second: ArrayLike, against: str) -> dict[str, Any]:
    """Areas (place,) against those of another comparison at the same places: ratio of means, and Wilcoxon's test."""
    ratio, error = ratio_of_means(first, second)
    found = paired_wilcoxon(first, second)
    return {
        f"over_{against}": ratio,
        f"over_{against}_standard_error": error,
        f"p_against_{against}": found.p,
        f"p_larger_than_{against}": found.p / 2.0 if found.rank_biserial > 0.0 else 1.0 - found.p / 2.0,
        f"rank_biserial_against_{against}": found.rank_biserial,
    }


def ratio_of_means(first: ArrayLike, second: ArrayLike) -> tuple[float, float]:
    """Ratio of two mean areas of the same places, and its standard error (delta method); NaN where the second is 0."""
    one, other = np.asarray(first, float), np.asarray(second, float)
    if not other.mean() > 0.0:
        return float("nan"), float("nan")
    ratio = one.mean() / other.mean()
    return float(ratio), float((one - ratio * other).std(ddof=1) / other.mean() / other.size**0.5)
