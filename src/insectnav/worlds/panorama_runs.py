"""Triangles seen from a point, cut into runs of columns between two edges; compiled.

A column is all that lies in one vertical half-plane through the eye, along the horizontal unit vector u. A great circle
with normal n, such as the one on which an edge of a triangle lies, crosses it at the elevation e with

    tan e = -(n_x u_x + n_y u_y) / n_z,

and the plane of a triangle with normal N through a corner P is met along the elevation e at the horizontal distance s
with

    1 / s = (N_x u_x + N_y u_y + N_z tan e) / (N · P).

Both are linear in u, and the second in tan e. No triangle is clipped or split, and neither the seam nor the poles are
special but for the bookkeeping of columns. Columns are counted for each corner alone, in whole numbers, and an edge has
the same two coefficients in both triangles that share it, to the last bit: there are no cracks.
"""

import numpy as np

from insectnav.lanes.compiled import lane_function

SHIFT_X, SHIFT_Y = 1.03e-7, 0.61e-7  # [m] keeps corners and edges off the vertical axis through the eye
TAN_22_5 = 0.41421356237309503
UP, DOWN = 1e30, -1e30  # tangents of the zenith and the nadir
RUNS_PER_TRIANGLE = 4  # at most: one for each edge round the axis, and one that the seam cuts off
NEARLY_HALF = 3.0  # [rad] of a turn
MAX_SLOPE = 1e30  # of 1/s over tan e, beyond which a triangle is seen exactly edge on


@lane_function
def arctangent(x):
    """Arc tangent of |x| <= tan 22.5°, to 3e-13: a polynomial through the Chebyshev nodes."""
    z = x * x
    low = (0.9999999999992442 - 0.3333333327691055 * z) + (z * z) * (0.19999993052892462 - 0.14285386534532973 * z)
    high = (0.11103456608349228 - 0.08992550366845013 * z) + (z * z) * (0.06974186809067136 - 0.03765492119056891 * z)
    return x * (low + (z * z) * (z * z) * high)


@lane_function
def angle_between(opposite, adjacent):
    """Angle in 0 … π/2 with the tangent opposite / adjacent, both >= 0."""
    is_steep = opposite > adjacent
    least, most = min(opposite, adjacent), max(opposite, adjacent)
    is_wide = least > TAN_22_5 * most
    angle = arctangent((least - most if is_wide else least) / (least + most if is_wide else most))
    angle = angle + np.pi / 4 if is_wide else angle
    return np.pi / 2 - angle if is_steep else angle


@lane_function
def find_azimuths(corners, n_corners, eye, angle):
    """Azimuth of each corner, in -π … π."""
    for i in range(n_corners):
        east, north = np.float64(corners[i]) - eye[0], np.float64(corners[n_corners + i]) - eye[1]
        turn = angle_between(abs(east), abs(north))
        turn = np.pi - turn if north < 0.0 else turn
        angle[i] = -turn if east < 0.0 else turn


@lane_function
def count_columns(angle, n_corners, columns_per_radian, phase, n_columns, column):
    """First column whose centre is not left of each corner: a whole number, the same for equal corners."""
    for i in range(n_corners):
        first = np.int32(np.ceil((angle[i] + np.pi) * columns_per_radian - phase - 0.5))
        first = first + n_columns if first < 0 else first
        column[i] = first - n_columns if first >= n_columns else first


@lane_function
def edge_between(p, q):
    """Coefficients a, b of the elevations on the edge from p to q, and n_z of its great circle."""
    rise = p[0] * q[1] - p[1] * q[0]
    return -(p[1] * q[2] - p[2] * q[1]) / rise, -(p[2] * q[0] - p[0] * q[2]) / rise, rise


@lane_function
def plane_through(p, q, r):
    """Coefficients of 1/s on the plane of three corners."""
    ux, uy, uz, vx, vy, vz = q[0] - p[0], q[1] - p[1], q[2] - p[2], r[0] - p[0], r[1] - p[1], r[2] - p[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    scale = 1.0 / (nx * p[0] + ny * p[1] + nz * p[2])
    return nx * scale, ny * scale, nz * scale


@lane_function
def columns_between(start, end, turn, rise, n_columns):
    """Columns from one corner to the next, > 0 to the right; ``turn`` is the difference of their azimuths."""
    turn = turn - 2.0 * np.pi if turn > np.pi else turn
    turn = turn + 2.0 * np.pi if turn < -np.pi else turn
    if abs(turn) > NEARLY_HALF:  # the edge itself says on which side of the axis it goes
        turn = -rise
    step = end - start
    if turn >= 0.0 and step < 0:
        step += n_columns
    elif turn < 0.0 and step > 0:
        step -= n_columns
    return step


@lane_function
def corner_at(corners, n_corners, i, eye):
    """Corner relative to the eye, in double precision."""
    return corners[i] - eye[0], corners[n_corners + i] - eye[1], corners[2 * n_corners + i] - eye[2]


@lane_function
def find_runs(corners, n_corners, eye, n_columns, work):
    """Cut each triangle into runs of columns that are bounded by two edges; return how many there are."""
    column, angle, n_runs = work.column, work.angle, 0
    for triangle in range(n_corners // 3):
        i = 3 * triangle
        c0, c1, c2 = column[i], column[i + 1], column[i + 2]
        if c0 == c1 and c1 == c2:
            continue
        p0 = corner_at(corners, n_corners, i, eye)
        p1 = corner_at(corners, n_corners, i + 1, eye)
        p2 = corner_at(corners, n_corners, i + 2, eye)
        plane = plane_through(p0, p1, p2)
        if not abs(plane[2]) < MAX_SLOPE:
            continue
        e0, e1, e2 = edge_between(p0, p1), edge_between(p1, p2), edge_between(p2, p0)
        a0, a1, a2 = angle[i], angle[i + 1], angle[i + 2]
        s0 = columns_between(c0, c1, a1 - a0, e0[2], n_columns)
        s1 = columns_between(c1, c2, a2 - a1, e1[2], n_columns)
        s2 = columns_between(c2, c0, a0 - a2, e2[2], n_columns)
        n_runs = add_triangle(work, n_runs, n_columns, triangle, (c0, c1, c2), (s0, s1, s2), (e0, e1, e2), plane)
    return n_runs


@lane_function
def pick(items, k):
    """One of three."""
    return items[0] if k == 0 else (items[1] if k == 1 else items[2])


@lane_function
def add_triangle(work, n_runs, n_columns, triangle, starts, steps, edges, plane):
    """Note the runs of one triangle, one under each of its edges but the longest; return the new number of runs."""
    if steps[0] + steps[1] + steps[2] != 0:  # once round: the vertical axis goes through it
        first, n_edges, pole = 0, 3, UP if plane[2] > 0.0 else DOWN
        other_a, other_b = 0.0, 0.0
    else:  # two edges lead on in one direction, and the third back over both
        is_first, is_second = (steps[0] >= 0) == (steps[1] >= 0), (steps[1] >= 0) == (steps[2] >= 0)
        first, n_edges, pole = 0 if is_first else (1 if is_second else 2), 2, 0.0
        longest = (first + 2) % 3
        other_a = pick((edges[0][0], edges[1][0], edges[2][0]), longest)
        other_b = pick((edges[0][1], edges[1][1], edges[2][1]), longest)
    for i in range(n_edges):
        k = (first + i) % 3
        start, step = pick(starts, k), pick(steps, k)
        a = pick((edges[0][0], edges[1][0], edges[2][0]), k)
        b = pick((edges[0][1], edges[1][1], edges[2][1]), k)
        bounds = (a, b, other_a, other_b, pole, plane[0], plane[1], plane[2])
        n_runs = add_run(work, n_runs, n_columns, triangle, start, step, bounds)
    return n_runs


@lane_function
def add_run(work, n_runs, n_columns, triangle, start, step, bounds):
    """Note the columns from ``start`` over ``step``, in two parts if the seam is among them; return the new number."""
    first = start if step > 0 else start + step
    first = first + n_columns if first < 0 else first
    n_left = abs(step)
    while n_left > 0:
        n_here = min(n_left, n_columns - first)
        run, bound = 3 * n_runs, 8 * n_runs
        work.run[run], work.run[run + 1], work.run[run + 2] = first, first + n_here, triangle
        work.bound[bound], work.bound[bound + 1] = bounds[0], bounds[1]
        work.bound[bound + 2], work.bound[bound + 3] = bounds[2], bounds[3]
        work.bound[bound + 4], work.bound[bound + 5] = bounds[4], bounds[5]
        work.bound[bound + 6], work.bound[bound + 7] = bounds[6], bounds[7]
        n_left, first, n_runs = n_left - n_here, 0, n_runs + 1
    return n_runs
