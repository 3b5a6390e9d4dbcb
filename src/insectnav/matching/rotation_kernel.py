"""Maps of views made, looked up and turned against each other, compiled."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.lanes.compiled import kernel, lane_function

Array = NDArray[Any]
DIFFERENCE, CORRELATION = 0, 1
FLATTEST = 1e-6  # variance over the overlap, of values of order 1, under which nothing can be correlated
WORST = -np.inf


@kernel
def blur_views(
    starts: Array, columns: Array, weights: Array, values: Array, seen: Array, least_coverage: float, maps: Array
) -> None:
    """Fill ``maps`` (view, node) by weighted means of ``values`` (view, direction) where ``seen``; else NaN."""
    for view in range(len(values)):
        row_values, row_seen = values[view], seen[view]
        for node in range(len(starts) - 1):
            total, coverage = 0.0, 0.0
            for entry in range(starts[node], starts[node + 1]):
                if row_seen[columns[entry]]:
                    total += weights[entry] * row_values[columns[entry]]
                    coverage += weights[entry]
            maps[view, node] = total / coverage if coverage >= least_coverage else np.nan


@lane_function
def on_face(x: float, y: float, z: float) -> tuple[int, float, float]:
    """Face of a cube that a direction meets, and the two places on it, each in −1…1."""
    a, b, c = abs(x), abs(y), abs(z)
    if c >= a and c >= b:
        return 4 if z > 0.0 else 5, x / c, y / c
    if a >= b:
        return 0 if x > 0.0 else 1, y / a, z / a
    return 2 if y > 0.0 else 3, z / b, x / b


@lane_function
def look_up(view: Array, n_cells: int, x: float, y: float, z: float) -> float:
    """Value of one map along a direction, between its four neighbours; NaN if one of them is."""
    face, u, v = on_face(x, y, z)
    across, down = (u + 1.0) * (0.5 * n_cells) + 0.5, (v + 1.0) * (0.5 * n_cells) + 0.5
    i, j = min(int(across), n_cells), min(int(down), n_cells)
    p, q = across - i, down - j
    width = n_cells + 2
    node = (face * width + i) * width + j
    first = view[node] + q * (view[node + 1] - view[node])
    second = view[node + width] + q * (view[node + width + 1] - view[node + width])
    return first + p * (second - first)


@kernel
def look_up_all(maps: Array, n_cells: int, directions: Array, values: Array) -> None:
    """Fill ``values`` (map, direction)."""
    for m in range(len(maps)):
        for k in range(len(directions)):
            values[m, k] = look_up(maps[m], n_cells, directions[k, 0], directions[k, 1], directions[k, 2])


@lane_function
def score_of_sums(kind: int, n: float, q: float, r: float, qq: float, rr: float, qr: float) -> float:
    """Score of two views from the sums over their overlap of 1, q, r, q², r², q r."""
    if kind == DIFFERENCE:
        return 1.0 - (qq - 2.0 * qr + rr) / n
    spread_q, spread_r = qq / n - (q / n) ** 2, rr / n - (r / n) ** 2
    if spread_q < FLATTEST or spread_r < FLATTEST:
        return WORST
    return (qr / n - (q / n) * (r / n)) / math.sqrt(spread_q * spread_r)


@kernel
def best_of_turns(
    kind: int, shared: Array, pairs: Array, mask_of: Array, least: Array, scores: Array, places: Array
) -> None:
    """Best score of each reference over tilts and turns, and where it is: tilt · turns + turn; −1 for nowhere.

    ``shared`` (sum, tilt, mask, turn) holds the sums of 1, q, q² over the overlap with each mask of references, and
    ``pairs`` (sum, tilt, reference, turn) for the difference r² − 2 q r, for the correlation r, r², q r. ``least``
    (reference,) is the least sum of 1 that counts.
    """
    n_tilts, n_references, n_turns = pairs.shape[1:]
    for tilt in range(n_tilts):
        for k in range(n_references):
            mask = mask_of[k]
            for turn in range(n_turns):
                n = shared[0, tilt, mask, turn]
                if n < least[k]:
                    continue
                q, qq = shared[1, tilt, mask, turn], shared[2, tilt, mask, turn]
                if kind == DIFFERENCE:
                    score = 1.0 - (qq + pairs[0, tilt, k, turn]) / n
                else:
                    r, rr, qr = pairs[0, tilt, k, turn], pairs[1, tilt, k, turn], pairs[2, tilt, k, turn]
                    score = score_of_sums(kind, n, q, r, qq, rr, qr)
                if score > scores[k]:
                    scores[k] = score
                    places[k] = tilt * n_turns + turn


@kernel
def score_of_rotation(
    kind: int, points: Array, values: Array, view: Array, n_cells: int, rotation: Array, least: float
) -> tuple[float, int]:
    """Score and number of points in the overlap of a query's points with a reference's map, turned by a rotation."""
    n, q, r, qq, rr, qr = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    a, b, c = rotation[0, 0], rotation[0, 1], rotation[0, 2]
    d, e, f = rotation[1, 0], rotation[1, 1], rotation[1, 2]
    g, h, i = rotation[2, 0], rotation[2, 1], rotation[2, 2]
    for k in range(len(points)):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        there = look_up(view, n_cells, a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)
        if there == there:  # is seen
            here = values[k]
            n += 1
            q += here
            r += there
            qq += here * here
            rr += there * there
            qr += here * there
    if n < least or n == 0:
        return WORST, n
    return score_of_sums(kind, n, q, r, qq, rr, qr), n


@lane_function
def turned(rotation: Array, axis: int, angle: float, out: Array) -> None:
    """Fill ``out`` with a rotation that is followed by one about an axis of the reference's frame."""
    cosine, sine = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    for column in range(3):
        out[axis, column] = rotation[axis, column]
        out[i, column] = cosine * rotation[i, column] - sine * rotation[j, column]
        out[j, column] = sine * rotation[i, column] + cosine * rotation[j, column]


@kernel
def refine(
    kind: int,
    points: Array,
    values: Array,
    view: Array,
    n_cells: int,
    rotation: Array,
    least: float,
    first_step: float,
    last_step: float,
) -> tuple[float, int]:
    """Improve a rotation in place by pattern search; gives its score and the number of points in the overlap.

    Steps about the three axes of the reference are taken whenever they raise the score, and halved when none does. The
    overlap stays at ``least`` points or more, or at those that it starts with if these are fewer.
    """
    score, n = score_of_rotation(kind, points, values, view, n_cells, rotation, 1.0)
    least = min(least, float(n))
    trial = np.empty((3, 3))
    step = first_step
    while step >= last_step:
        has_moved = False
        for axis in range(3):
            for sign in (1.0, -1.0):
                turned(rotation, axis, sign * step, trial)
                new, n_new = score_of_rotation(kind, points, values, view, n_cells, trial, least)
                if new > score:
                    score, n = new, n_new
                    rotation[:] = trial
                    has_moved = True
                    break
        if not has_moved:
            step *= 0.5
    return score, n
