"""Steepest descent on a bicubic surface, compiled. Lengths are in units of the grid."""

import math

from insectnav.lanes.compiled import kernel, lane_function

GOAL, MINIMUM, LEFT, UNFINISHED = 0, 1, 2, 3
SMALLEST_STEP = 2.0**-10  # of the full step


@lane_function
def catmull_rom(t):
    """Weights of the four samples around a place at the share ``t`` of its cell."""
    return (
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    )


@lane_function
def catmull_rom_slope(t):
    """Derivatives of these weights."""
    return (-1.5 * t + 2.0) * t - 0.5, (4.5 * t - 5.0) * t, (-4.5 * t + 4.0) * t + 0.5, (1.5 * t - 1.0) * t


@lane_function
def weigh(a, b, c, d, weights):
    """Weighted sum of four."""
    return weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d


@lane_function
def along_row(padded, row, column, weights):
    """Weighted sum of four neighbours in a row."""
    return weigh(
        padded[row, column], padded[row, column + 1], padded[row, column + 2], padded[row, column + 3], weights
    )


@lane_function
def surface_at(padded, x, y):
    """Value and its slopes along x and y; ``padded`` (rows + 2, columns + 2) has one more sample on each side."""
    column, row = min(int(x), padded.shape[1] - 4), min(int(y), padded.shape[0] - 4)
    across, across_slope = catmull_rom(x - column), catmull_rom_slope(x - column)
    down, down_slope = catmull_rom(y - row), catmull_rom_slope(y - row)
    a, b = along_row(padded, row, column, across), along_row(padded, row + 1, column, across)
    c, d = along_row(padded, row + 2, column, across), along_row(padded, row + 3, column, across)
    slope_x = weigh(
        along_row(padded, row, column, across_slope),
        along_row(padded, row + 1, column, across_slope),
        along_row(padded, row + 2, column, across_slope),
        along_row(padded, row + 3, column, across_slope),
        down,
    )
    return weigh(a, b, c, d, down), slope_x, weigh(a, b, c, d, down_slope)


@kernel
def interpolate_all(padded, places, values, slopes):
    """Write values (n,) and slopes (n, 2) at places (n, 2) of x, y."""
    for k in range(places.shape[0]):
        values[k], slopes[k, 0], slopes[k, 1] = surface_at(padded, places[k, 0], places[k, 1])


@kernel
def descend_all(first, last, padded, starts, goal_x, goal_y, radius, step, max_steps, ends, outcomes, n_steps):
    """Write where the ways from the starts ``first`` up to ``last`` end, why, and after how many steps.

    A step goes straight down the slope. One that would not lower the value, or would leave the grid, is halved and
    tried again; after one that succeeds it may double, up to ``step``. Where a thousandth of it still fails the way
    ends: at a minimum, or at the edge. A goal of NaN is never reached.
    """
    width, height = padded.shape[1] - 3.0, padded.shape[0] - 3.0
    for k in range(first, last):
        x, y = starts[k, 0], starts[k, 1]
        value, slope_x, slope_y = surface_at(padded, x, y)
        length, taken, outcome = step, 0, UNFINISHED
        while taken < max_steps:
            if (x - goal_x) ** 2 + (y - goal_y) ** 2 <= radius * radius:
                outcome = GOAL
                break
            steepness = math.sqrt(slope_x * slope_x + slope_y * slope_y)
            if steepness == 0.0:
                outcome = MINIMUM
                break
            share = length / steepness
            next_x, next_y = x - share * slope_x, y - share * slope_y
            is_inside = 0.0 <= next_x <= width and 0.0 <= next_y <= height
            if is_inside:
                next_value, next_slope_x, next_slope_y = surface_at(padded, next_x, next_y)
                if next_value < value:
                    x, y, value, slope_x, slope_y = next_x, next_y, next_value, next_slope_x, next_slope_y
                    length = min(2.0 * length, step)
                    taken += 1
                    continue
            length *= 0.5
            if length < SMALLEST_STEP * step:
                outcome = MINIMUM if is_inside else LEFT
                break
        ends[k, 0], ends[k, 1] = x, y
        outcomes[k] = outcome
        n_steps[k] = taken
