"""Rows of the table of recorded cells: one quantity of one kind of cell, across animals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import circular_mean, wrap
from insectnav.experiments.experiment import Table
from insectnav.metrics.polarisation_tuning import preference_shift, tuning_width

Reals = NDArray[np.floating[Any]]
Row = dict[str, Any]

N_DIRECTIONS = 8  # animal k has a cell recorded that is wired to direction k mod 8
_BACKGROUND, _DARK = 2.0, 2.5  # [s] lengths of the intervals that spikes are counted in
_STANDARD_ERRORS = 3.0  # by which a rate in the dark must exceed the background to count as outlasting


def find(table: Table, **conditions: Any) -> dict[tuple[str, str], Mapping[str, Any]]:
    """Rows of one condition, by kind of cell and quantity."""
    rows = [row for row in table if all(row[name] == value for name, value in conditions.items())]
    return {(row["cells"], row["quantity"]): row for row in rows}


def compass_rows(arrays: Mapping[str, NDArray[Any]], kinds: Sequence[str], *, axial: bool) -> list[Row]:
    """Width, shift, significance and spacing of the tuning of each kind of compass cell.

    Parameters
    ----------
    arrays : results of one cell of the grid
    kinds : names of the populations, as along the first axis of the arrays
    axial : whether angles half a turn apart are the same
    """
    shift = _shift(arrays, axial)
    preferred = np.radians(arrays["preferred_angle"].astype(float))
    rows = []
    for index, population in enumerate(kinds):
        kind = population.upper()
        static = np.degrees(tuning_width(arrays["static_rate"][index, : 180 if axial else 360], axial=axial))
        rows += [
            _mean_row(kind, "tuning width", arrays["tuning_width"][index].mean(axis=(0, 1)), "deg"),
            _row(kind, "tuning width without spikes", float(static), "deg"),
            _share_row(kind, "share significantly tuned", arrays["is_significant"][index]),
            _mean_row(kind, "shift", shift[index].mean(axis=0), "deg"),
            *_spacing_rows(kind, preferred[index], 2.0 if axial else 1.0),
        ]
    return rows


def lag_rows(
    arrays: Mapping[str, NDArray[Any]],
    kinds: Sequence[str],
    speeds_deg: Sequence[float],
    *,
    axial: bool,
    step_ms: float,
) -> list[Row]:
    """Lag of each kind of compass cell behind the stimulus: a lag by τ at the speed ω shifts its preference by −2ωτ.

    Parameters
    ----------
    arrays, kinds, axial
        As of `compass_rows`.
    speeds_deg : (speed,) [°/s]
    step_ms : length of a time step [ms]
    """
    rows = []
    for kind, shift in zip(kinds, _shift(arrays, axial), strict=True):
        for speed, values in zip(speeds_deg, shift, strict=True):
            lag = -values / (2.0 * speed) * 1000.0 / step_ms
            rows.append(_mean_row(kind.upper(), f"lag at {speed:g} deg/s", lag, "time steps"))
    return rows


def _shift(arrays: Mapping[str, NDArray[Any]], axial: bool) -> Reals:
    """Preferred angle in anticlockwise minus that in clockwise turns, (kind, speed, animal) [deg]."""
    preferred = np.radians(arrays["preferred_angle"].astype(float))
    return np.degrees(preference_shift(preferred[:, :, 0], preferred[:, :, 1], axial=axial))


def _spacing_rows(kind: str, preferred: Reals, fold: float) -> list[Row]:
    """Least and largest angle between the mean preferred angles of cells that are wired to neighbouring directions."""
    angles = fold * preferred.reshape(-1, preferred.shape[-1])
    centres = circular_mean(angles, axis=0)
    groups = [centres[first::N_DIRECTIONS] for first in range(N_DIRECTIONS)]
    means = np.array([circular_mean(group) for group in groups])
    rest = np.concatenate([wrap(group - mean) for group, mean in zip(groups, means, strict=True)])
    variance = np.sum(rest**2) / (rest.size - N_DIRECTIONS)  # of one cell about the mean of its direction
    error = float(np.degrees(np.sqrt(2.0 * variance * N_DIRECTIONS / rest.size)) / fold)
    spacing = np.degrees(wrap(np.diff(means, append=means[:1]))) / fold
    least, largest = float(spacing.min()), float(spacing.max())
    return [
        _row(kind, "least spacing of preferred angles", least, "deg", error, n=rest.size),
        _row(kind, "largest spacing of preferred angles", largest, "deg", error, n=rest.size),
    ]


def flow_rows(arrays: Mapping[str, NDArray[Any]], kinds: Sequence[str], velocities: Reals) -> list[Row]:
    """Responses of each kind of flow cell to translation, rotation and darkness, and its preferred expansion points.

    Parameters
    ----------
    arrays : results of one cell of the grid
    kinds : names of the populations, as along the first axis of the arrays
    velocities : (velocity,) of translational flow, −1 to 1, ascending
    """
    names = ("rate_by_velocity", "background_rate", "rate_by_rotation", "rate_in_dark", "expansion_point")
    rows = []
    for index, population in enumerate(kinds):
        rows += _rows_of_kind(
            population.upper(), {name: arrays[name][index].astype(float) for name in names}, velocities
        )
    points = np.radians(arrays["expansion_point"].astype(float))
    points = np.sort(points.reshape(-1, points.shape[-1]), axis=0)
    between = np.diff(points, axis=0, append=points[:1] + 2.0 * np.pi)
    return [*rows, _mean_row("TN", "least angle between expansion points", np.degrees(between.min(axis=0)), "deg")]


def _rows_of_kind(kind: str, arrays: Mapping[str, Reals], velocities: Reals) -> list[Row]:
    """Rows of TN1 or TN2; the two sides of an animal are averaged."""
    rate, background = arrays["rate_by_velocity"], arrays["background_rate"]
    peak = rate.max(axis=-1)
    is_forward = velocities >= 0.0
    # bouts begin with the fastest backward flow, which excites TN1, and end with the fastest forward flow
    exciting, dark = ("backward", arrays["rate_in_dark"][..., 0])
    if kind == "TN2":
        exciting, dark = ("forward", arrays["rate_in_dark"][..., 1])
    chance = _STANDARD_ERRORS * np.sqrt(dark / _DARK + background / _BACKGROUND)
    responses = {
        "forward flow": rate[..., -1],
        "backward flow": rate[..., 0],
        "rotational flow": arrays["rate_by_rotation"].mean(axis=-1),
        f"darkness after {exciting} flow": dark,
    }
    changes = {f"response to {name}": (values - background) / peak for name, values in responses.items()}
    return [
        _mean_row(kind, "peak rate", peak.mean(axis=0), "impulses/s"),
        _mean_row(kind, "background", background.mean(axis=0), "impulses/s"),
        _mean_row(kind, "R² forward", _r_squared(velocities[is_forward], rate[..., is_forward]).mean(axis=0), "1"),
        _mean_row(kind, "R² all velocities", _r_squared(velocities, rate).mean(axis=0), "1"),
        *(_mean_row(kind, name, values.mean(axis=0), "1") for name, values in changes.items()),
        _share_row(kind, "share outlasting", dark - background > chance),
        _mean_row(
            kind, "expansion point from body axis", _off_axis(kind, arrays["expansion_point"]).mean(axis=0), "deg"
        ),
    ]


def _r_squared(x: Reals, y: Reals) -> Reals:
    """Share of the variance of y (..., n) that a straight line in x (n,) takes up."""
    dx, dy = x - x.mean(), y - y.mean(axis=-1, keepdims=True)
    total = np.sum(dy**2, axis=-1)
    return np.square(dy @ dx) / np.where(total > 0.0, total * np.sum(dx**2), np.nan)


def _off_axis(kind: str, point_deg: Reals) -> Reals:
    """Angle from the nearer end of the body axis to the preferred expansion point, positive to the cell's own side.

    TN2 cells prefer the front right (0) and left (1); TN1 cells the back, right (1) and left (0).
    """
    to_own_side = np.array([[1.0], [-1.0]]) * point_deg
    return to_own_side if kind == "TN2" else np.degrees(wrap(np.radians(180.0 + to_own_side)))


def _row(
    kind: str,
    quantity: str,
    value: float,
    unit: str,
    standard_error: float = 0.0,
    sd: float = math.nan,
    n: int = 1,
) -> Row:
    return {
        "cells": kind,
        "quantity": quantity,
        "value": value,
        "standard_error": standard_error,
        "sd": sd,
        "n": n,
        "unit": unit,
    }


def _mean_row(kind: str, quantity: str, values: Reals, unit: str) -> Row:
    """Mean across animals; those without a value are left out."""
    finite = values[np.isfinite(values)]
    if finite.size < 2:
        return _row(kind, quantity, math.nan, unit, math.nan, n=finite.size)
    sd = float(finite.std(ddof=1))
    return _row(kind, quantity, float(finite.mean()), unit, sd / math.sqrt(finite.size), sd, finite.size)


def _share_row(kind: str, quantity: str, is_true: NDArray[np.bool_]) -> Row:
    """Share of the tests of all animals for which something is true, and its binomial standard error."""
    share = float(is_true.mean())
    return _row(kind, quantity, share, "1", math.sqrt(share * (1.0 - share) / is_true.size), n=is_true.size)
