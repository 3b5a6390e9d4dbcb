"""Columns of tables: a statistic of the trials of a condition and its standard error."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from insectnav.angles import circular_mean, circular_std
from insectnav.metrics.statistics import bootstrap_error


def mean_columns(name: str, values: ArrayLike) -> dict[str, float]:
    """Mean ``name`` and its standard error ``name_error`` of the finite values of a sample; NaN where there are none.

    Parameters
    ----------
    name : str
    values : (n,) array
    """
    finite = _finite(values)
    if finite.size < 2:
        return {name: math.nan, f"{name}_error": math.nan}
    return {name: float(finite.mean()), f"{name}_error": float(finite.std(ddof=1) / math.sqrt(finite.size))}


def median_columns(name: str, values: ArrayLike) -> dict[str, float]:
    """Median ``name`` and its bootstrapped standard error ``name_error`` of the finite values of a sample.

    Parameters
    ----------
    name : str
    values : (n,) array
    """
    finite = _finite(values)
    middle = float(np.median(finite)) if finite.size else math.nan
    return {name: middle, f"{name}_error": bootstrap_error(finite, np.median)}


def circular_columns(name: str, angles_deg: ArrayLike) -> dict[str, float]:
    """Circular mean ``name_deg``, its standard error ``name_error_deg`` and circular SD ``name_sd_deg``.

    Parameters
    ----------
    name : str
    angles_deg : (n,) array [deg]
        NaN are left out.

    Notes
    -----
    The standard error, SD/√n, is that of a mean on a line; it holds where the angles cluster.
    """
    angles = np.radians(_finite(angles_deg))
    if angles.size < 2:
        return dict.fromkeys((f"{name}_deg", f"{name}_error_deg", f"{name}_sd_deg"), math.nan)
    spread = float(np.degrees(circular_std(angles)))
    return {
        f"{name}_deg": float(np.degrees(circular_mean(angles))),
        f"{name}_error_deg": spread / math.sqrt(angles.size),
        f"{name}_sd_deg": spread,
    }


def share_columns(name: str, is_true: ArrayLike) -> dict[str, float]:
    """Share ``name`` of the trials for which something is true, and its binomial standard error ``name_error``.

    Parameters
    ----------
    name : str
    is_true : (n,) array of bool
    """
    array = np.asarray(is_true, bool)
    share = float(array.mean())
    return {name: share, f"{name}_error": math.sqrt(share * (1.0 - share) / array.size)}


def _finite(values: ArrayLike) -> np.ndarray:
    array = np.asarray(values, float)
    return array[np.isfinite(array)]
