"""The exact skyline, compiled: the highest edge over each azimuth."""

from typing import Any, NamedTuple

from insectnav.lanes.compiled import kernel, lane_function
from insectnav.lanes.vector import address
from insectnav.worlds.panorama_runs import SHIFT_X, SHIFT_Y, angle_between, find_azimuths, find_runs


class SkylineWork(NamedTuple):
    """Work space of one thread; the first four as in `insectnav.worlds.panorama_kernel.Work`."""

    angle: Any
    column: Any
    run: Any
    bound: Any


@lane_function
def search_columns(angle, n_corners, azimuth, n_columns, column):
    """First azimuth that is not left of each corner, by bisection; column 0 comes after the last."""
    for i in range(n_corners):
        low, high = 0, n_columns
        while low < high:
            middle = (low + high) // 2
            if azimuth[middle] < angle[i]:
                low = middle + 1
            else:
                high = middle
        column[i] = low if low < n_columns else 0


@kernel
def find_skylines(first, last, corners_array, azimuth_array, across_array, eyes, work_arrays, skyline_array):
    """Elevations over each azimuth, from ``first`` up to ``last``; no edge may span all of the azimuths."""
    angle, column, run, bound = work_arrays
    work = SkylineWork(address(angle), address(column), address(run), address(bound))
    corners, azimuth, across = address(corners_array), address(azimuth_array), address(across_array)
    skyline, n_corners, n_columns = address(skyline_array), corners_array.shape[1], azimuth_array.shape[0]
    for view in range(first, last):
        eye = eyes[view, 0] + SHIFT_X, eyes[view, 1] + SHIFT_Y, eyes[view, 2]
        find_azimuths(corners, n_corners, eye, work.angle)
        search_columns(work.angle, n_corners, azimuth, n_columns, work.column)
        n_runs = find_runs(corners, n_corners, eye, n_columns, work)
        highest = view * n_columns
        for i in range(n_columns):
            skyline[highest + i] = 0.0
        for k in range(n_runs):
            a, b, c, d, pole = bound[k, 0], bound[k, 1], bound[k, 2], bound[k, 3], bound[k, 4]
            for i in range(run[k, 0], run[k, 1]):
                x, y = across[2 * i], across[2 * i + 1]
                skyline[highest + i] = max(skyline[highest + i], max(a * x + b * y, c * x + d * y + pole))
        for i in range(n_columns):
            skyline[highest + i] = angle_between(skyline[highest + i], 1.0)
