"""Panoramas, compiled: runs of columns are drawn into a buffer of depths and averaged to pixels.

A view is drawn in tiles of some columns, so that the buffer stays in the cache. Along a column the samples of a
triangle are a single piece, and 1/s, with s the horizontal distance, is linear in the tangent of the elevation; the
nearest wins. Inside, arrays are passed on by address, see `insectnav.lanes.vector.address`.
"""

from typing import Any, NamedTuple

import numpy as np

from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.vector import address
from insectnav.worlds.panorama_runs import SHIFT_X, SHIFT_Y, angle_between, count_columns, find_azimuths, find_runs

SKY, GROUND = -1, -2  # in place of the index of a triangle


class Grid(NamedTuple):
    """Samples of a panorama; columns stand in the order of their azimuth in the world."""

    across: Any  # (column, 2) horizontal unit vectors x, y, the first column just west of south
    tangent: Any  # (row,) float32, tangents of the elevations, from the zenith side down
    n_columns: int
    n_rows: int
    columns_per_radian: float
    rows_per_radian: float
    top: float  # [rad] elevation of the upper border
    supersampling: int  # samples along each side of a pixel


class Scene(NamedTuple):
    """What there is to see, and with which values."""

    corners: Any  # (3, corner) float32: x, y, z [m], three corners a triangle
    value: Any  # (channel, triangle) float32
    background: Any  # (channel, row) float32, where no triangle is
    ground_nearness: Any  # (row,) float32, nearness of the ground in units of 1 / eye height; 0 above the horizon
    cosine: Any  # (row,) float32, cosines of the elevations
    n_corners: int


class Views(NamedTuple):
    """Where views are taken, and what comes out; what is not asked for is empty."""

    eye: Any  # (view, 3) [m]
    phase: Any  # (view,) what the columns are turned by to the right, in columns
    turn: Any  # (view,) pixels that the picture is turned by
    value: Any  # (view, channel, row, column) float32
    nearness: Any  # (view, row, column) float32 [1/m]
    triangle: Any  # (view, row, column) int32
    sees_sky: Any  # (view,) uint8, 1 or 0
    n_channels: int
    has_nearness: bool
    has_triangle: bool


class Work(NamedTuple):
    """Work space of one thread."""

    across: Any  # (column, 2)
    angle: Any  # (corner,) [rad] azimuths
    column: Any  # (corner,) int32, the first column that is not left of it
    run: Any  # (run, 3) int32: first column, end, triangle
    bound: Any  # (run, 8): tan e = a u_x + b u_y of two edges, a constant, 1/s of the plane
    upper: Any  # (column,) int32, first row of a run in each of its columns
    lower: Any  # (column,) int32, the row after its last
    top: Any  # (column,) int32, first row with anything in it
    near: Any  # (tile,) float32, 1 / horizontal distance, 0 where there is nothing
    triangle: Any  # (tile,) int32, out of date where there is nothing
    total: Any  # (row,) float32
    n_tile: int


@lane_function
def row_below(tangent, grid):
    """First row whose centre lies below an elevation."""
    angle = angle_between(abs(tangent), 1.0)
    angle = -angle if tangent < 0.0 else angle
    row = np.floor((grid.top - angle) * grid.rows_per_radian + 0.5)
    return np.int32(min(max(row, 0.0), np.float64(grid.n_rows)))


@lane_function
def find_rows(work, grid, k, start, n_here, first_column):
    """Rows that run k covers in each of some columns, and the highest row with anything so far."""
    across, upper, lower, top, at = work.across, work.upper, work.lower, work.top, 8 * k
    a, b, c, d = work.bound[at], work.bound[at + 1], work.bound[at + 2], work.bound[at + 3]
    pole = work.bound[at + 4]
    for i in range(n_here):
        x, y = across[2 * (start + i)], across[2 * (start + i) + 1]
        one, other = a * x + b * y, c * x + d * y + pole
        upper[i] = row_below(max(one, other), grid)
        lower[i] = row_below(min(one, other), grid)
    for i in range(n_here):
        here = start + i - first_column
        top[here] = min(top[here], upper[i] if lower[i] > upper[i] else top[here])


@lane_function
def draw_tile(first_column, end_column, n_runs, grid, work):
    """Nearest triangle of each sample of some columns, into the buffer of depths, which is empty before."""
    near, triangle, tangent, across, n_rows = work.near, work.triangle, grid.tangent, work.across, grid.n_rows
    for i in range(end_column - first_column):
        work.top[i] = n_rows
    for k in range(n_runs):
        start, end = max(work.run[3 * k], first_column), min(work.run[3 * k + 1], end_column)
        if start >= end:
            continue
        find_rows(work, grid, k, start, end - start, first_column)
        px, py, slope = work.bound[8 * k + 5], work.bound[8 * k + 6], np.float32(work.bound[8 * k + 7])
        index = work.run[3 * k + 2]
        for i in range(end - start):
            level = np.float32(px * across[2 * (start + i)] + py * across[2 * (start + i) + 1])
            at = (start + i - first_column) * n_rows
            for row in range(work.upper[i], work.lower[i]):
                value = level + slope * tangent[row]
                if value > near[at + row]:
                    near[at + row] = value
                    triangle[at + row] = index


@lane_function
def average_values(scene, channel, grid, work, first, top, picture, at):
    """Mean of the values of the samples in each pixel of a column; nothing is above pixel row ``top``."""
    s, n_rows, width = grid.supersampling, grid.n_rows, grid.n_columns // grid.supersampling
    total, values, background = work.total, channel * (scene.n_corners // 3), channel * n_rows
    for i in range(s):
        column = (first + i) * n_rows
        for row in range(top * s, n_rows):
            is_free, shown = (
                work.near[column + row] == np.float32(0.0),
                scene.value[values + work.triangle[column + row]],
            )
            seen = scene.background[background + row] if is_free else shown
            total[row] = seen if i == 0 else total[row] + seen
    for row in range(min(top, n_rows // s)):
        mean = scene.background[background + row * s]
        for j in range(1, s):
            mean += scene.background[background + row * s + j]
        picture[at + row * width] = mean * np.float32(1.0 / s)
    for row in range(top, n_rows // s):
        mean = total[row * s]
        for j in range(1, s):
            mean += total[row * s + j]
        picture[at + row * width] = mean * np.float32(1.0 / (s * s))


@lane_function
def average_nearness(scene, grid, work, height, first, picture, at):
    """Mean of the nearness of the samples in each pixel of a column; 0 for the sky."""
    s, n_rows, width = grid.supersampling, grid.n_rows, grid.n_columns // grid.supersampling
    for row in range(n_rows // s):
        total = np.float32(0.0)
        for i in range(s):
            for j in range(row * s, row * s + s):
                hit = work.near[(first + i) * n_rows + j]
                total += hit * scene.cosine[j] if hit > 0.0 else scene.ground_nearness[j] / height
        picture[at + row * width] = total * np.float32(1.0 / (s * s))


@lane_function
def find_nearest(scene, grid, work, first, picture, at):
    """The nearest triangle in each pixel of a column; SKY or GROUND where there is none."""
    s, n_rows, width = grid.supersampling, grid.n_rows, grid.n_columns // grid.supersampling
    for row in range(n_rows // s):
        nearest, index = np.float32(0.0), GROUND if grid.tangent[row * s + s // 2] < 0.0 else SKY
        for i in range(s):
            for j in range(row * s, row * s + s):
                sample = (first + i) * n_rows + j
                nearness = work.near[sample] * scene.cosine[j]
                if nearness > nearest:
                    nearest, index = nearness, work.triangle[sample]
        picture[at + row * width] = index


@lane_function
def any_sky(grid, work, first):
    """Whether a sample of a pixel column above the horizon is free."""
    for i in range(first, first + grid.supersampling):
        for row in range(grid.n_rows):
            if work.near[i * grid.n_rows + row] == 0.0 and grid.tangent[row] >= 0.0:
                return True
    return False


@lane_function
def write_columns(first, end, view, turn, height, grid, scene, work, views):
    """Bring the samples of a tile into the pictures, and empty the buffer of depths again."""
    s, n_rows = grid.supersampling, grid.n_rows
    width = grid.n_columns // s
    size = width * (n_rows // s)
    for pixel in range(first // s, end // s):
        start, column = pixel * s - first, (pixel - turn) % width
        top = work.top[start]
        for i in range(1, s):
            top = min(top, work.top[start + i])
        for channel in range(views.n_channels):
            at = (view * views.n_channels + channel) * size + column
            average_values(scene, channel, grid, work, start, top // s, views.value, at)
        if views.has_nearness:
            average_nearness(scene, grid, work, height, start, views.nearness, view * size + column)
        if views.has_triangle:
            find_nearest(scene, grid, work, start, views.triangle, view * size + column)
        if views.sees_sky[view] == 0:
            views.sees_sky[view] = 1 if any_sky(grid, work, start) else 0
    for i in range(end - first):
        for row in range(work.top[i], n_rows):
            work.near[i * n_rows + row] = np.float32(0.0)


@lane_function
def turn_columns(grid, phase, work):
    """Directions of the columns when they are turned to the right by a part of a column."""
    angle = phase / grid.columns_per_radian
    sine, cosine = np.sin(angle), np.cos(angle)
    for i in range(grid.n_columns):
        x, y = grid.across[2 * i], grid.across[2 * i + 1]
        work.across[2 * i], work.across[2 * i + 1] = x * cosine + y * sine, y * cosine - x * sine


@lane_function
def locate_grid(grid):
    """Grid with addresses in place of its arrays."""
    across, tangent, n_columns, n_rows, columns_per_radian, rows_per_radian, top, s = grid
    return Grid(address(across), address(tangent), n_columns, n_rows, columns_per_radian, rows_per_radian, top, s)


@lane_function
def locate_scene(scene):
    """Scene with addresses in place of its arrays."""
    corners, value, background, ground_nearness, cosine, n_corners = scene
    at = address(corners), address(value), address(background), address(ground_nearness), address(cosine)
    return Scene(at[0], at[1], at[2], at[3], at[4], n_corners)


@lane_function
def locate_views(views):
    """Views with addresses in place of their arrays."""
    eye, phase, turn, value, nearness, triangle, sees_sky, n_channels, has_nearness, has_triangle = views
    poses, pictures = (
        (address(eye), address(phase), address(turn)),
        (address(value), address(nearness), address(triangle)),
    )
    return Views(
        poses[0], poses[1], poses[2], pictures[0], pictures[1], pictures[2], address(sees_sky),
        n_channels, has_nearness, has_triangle,
    )  # fmt: skip


@lane_function
def locate_work(work):
    """Work space with addresses in place of its arrays."""
    across, angle, column, run, bound, upper, lower, top, near, triangle, total, n_tile = work
    return Work(
        address(across), address(angle), address(column), address(run), address(bound), address(upper), address(lower),
        address(top), address(near), address(triangle), address(total), n_tile,
    )  # fmt: skip


@kernel
def render_views(first, last, grid_arrays, scene_arrays, work_arrays, view_arrays):
    """Render the views from ``first`` up to ``last``; the buffer of depths is empty before and after."""
    grid, scene = locate_grid(grid_arrays), locate_scene(scene_arrays)
    work, views = locate_work(work_arrays), locate_views(view_arrays)
    n_columns, n_corners = np.int32(grid.n_columns), scene.n_corners
    width = work.n_tile // (grid.n_rows * grid.supersampling) * grid.supersampling
    for view in range(first, last):
        x, y, height, phase = views.eye[3 * view], views.eye[3 * view + 1], views.eye[3 * view + 2], views.phase[view]
        eye = x + SHIFT_X, y + SHIFT_Y, height
        turn_columns(grid, phase, work)
        find_azimuths(scene.corners, n_corners, eye, work.angle)
        count_columns(work.angle, n_corners, grid.columns_per_radian, phase, n_columns, work.column)
        n_runs = find_runs(scene.corners, n_corners, eye, n_columns, work)
        views.sees_sky[view] = 0
        for start in range(0, grid.n_columns, width):
            end = min(start + width, grid.n_columns)
            draw_tile(start, end, n_runs, grid, work)
            write_columns(start, end, view, views.turn[view], np.float32(height), grid, scene, work, views)
