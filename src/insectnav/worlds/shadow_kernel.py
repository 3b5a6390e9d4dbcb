"""Shadows, compiled: how near to the light the surfaces are, seen from the light in parallel rays."""

from typing import Any, NamedTuple

import numpy as np

from insectnav.lanes.compiled import kernel, lane_function

NOTHING = np.float32(-1e30)  # depth where no surface is
OFFSET, BIAS = 1.5, 0.75  # [pixel of the map] along the normal, and towards the light: a surface does not shade itself


class ShadowMap(NamedTuple):
    """Depths towards a light that is far away, or towards many: then all have a leading axis."""

    depth: Any  # (row, column) float32 [m] along the direction to the light, of the surface nearest to it
    frame: Any  # (3, 3) across, up, to the light: orthonormal
    corner: Any  # (2,) [m] across and up, of the corner of the first pixel
    pixel: Any  # [m]


@lane_function
def along(frame, row, x, y, z):
    """Coordinate of a point along one axis of the frame."""
    return frame[row, 0] * x + frame[row, 1] * y + frame[row, 2] * z


@kernel
def draw_depths(corners, shadow):
    """Draw triangles (triangle, 3, 3) [m] into the depths; a pixel belongs to a triangle if its centre does."""
    depth, frame, pixel = shadow.depth, shadow.frame, shadow.pixel
    n_rows, n_columns = depth.shape
    u, v, w = np.empty(3), np.empty(3), np.empty(3)
    for k in range(corners.shape[0]):
        for i in range(3):
            x, y, z = np.float64(corners[k, i, 0]), np.float64(corners[k, i, 1]), np.float64(corners[k, i, 2])
            u[i] = (along(frame, 0, x, y, z) - shadow.corner[0]) / pixel - 0.5
            v[i] = (along(frame, 1, x, y, z) - shadow.corner[1]) / pixel - 0.5
            w[i] = along(frame, 2, x, y, z)
        area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0])
        if area == 0.0:
            continue
        first = max(0, np.int64(np.ceil(min(v[0], v[1], v[2]))))
        last = min(n_rows - 1, np.int64(np.floor(max(v[0], v[1], v[2]))))
        left = max(0, np.int64(np.ceil(min(u[0], u[1], u[2]))))
        right = min(n_columns - 1, np.int64(np.floor(max(u[0], u[1], u[2]))))
        for row in range(first, last + 1):
            for column in range(left, right + 1):
                one = ((u[1] - column) * (v[2] - row) - (u[2] - column) * (v[1] - row)) / area
                two = ((u[2] - column) * (v[0] - row) - (u[0] - column) * (v[2] - row)) / area
                three = 1.0 - one - two
                if one >= 0.0 and two >= 0.0 and three >= 0.0:
                    here = np.float32(one * w[0] + two * w[1] + three * w[2])
                    if here > depth[row, column]:
                        depth[row, column] = here


@lane_function
def lit_share(shadow, x, y, z, nx, ny, nz):
    """Share of the light that reaches a point whose normal n is on the side of the light, 0 to 1.

    The four pixels round it are asked and mixed, so that the edge of a shadow is a pixel wide.
    """
    frame, pixel = shadow.frame, shadow.pixel
    x, y, z = x + OFFSET * pixel * nx, y + OFFSET * pixel * ny, z + OFFSET * pixel * nz
    u = (along(frame, 0, x, y, z) - shadow.corner[0]) / pixel - 0.5
    v = (along(frame, 1, x, y, z) - shadow.corner[1]) / pixel - 0.5
    n_rows, n_columns = shadow.depth.shape
    if not (u >= 0.0 and v >= 0.0 and u < n_columns - 1 and v < n_rows - 1):
        return 1.0
    column, row = np.int64(u), np.int64(v)
    a, b = u - column, v - row
    here = along(frame, 2, x, y, z) + BIAS * pixel
    lit = 0.0
    for i in range(2):
        for j in range(2):
            if shadow.depth[row + i, column + j] <= here:
                lit += (b if i else 1.0 - b) * (a if j else 1.0 - a)
    return lit


@lane_function
def is_open(shadows, k, x, y, z, nx, ny, nz):
    """Whether direction ``k`` of many coarse maps is free of surfaces at a point; the nearest pixel is asked."""
    frame, pixel = shadows.frame[k], shadows.pixel[k]
    x, y, z = x + OFFSET * pixel * nx, y + OFFSET * pixel * ny, z + OFFSET * pixel * nz
    column = np.int64(np.floor((along(frame, 0, x, y, z) - shadows.corner[k, 0]) / pixel))
    row = np.int64(np.floor((along(frame, 1, x, y, z) - shadows.corner[k, 1]) / pixel))
    n_rows, n_columns = shadows.depth.shape[1], shadows.depth.shape[2]
    if row < 0 or column < 0 or row >= n_rows or column >= n_columns:
        return True
    return shadows.depth[k, row, column] <= along(frame, 2, x, y, z) + BIAS * pixel
