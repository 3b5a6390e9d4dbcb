"""How fast views are described, compared and descended: one line each, with the ratio to a plain sum in the same run.

The plain way multiplies each view by each Zernike function, made once, and adds up. Wall time drifts on shared
machines, so each fast measurement stands between two plain ones, and the median of the ratios is what to quote. Run it
by ``make bench``; the time of ``numpy.matmul`` depends on how many threads its library takes.
"""

import resource
import statistics
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from insectnav.homing import catchment_area, cell_centres, descend, difference_by_turn, rms_difference, visual_compass
from insectnav.vision.descriptors import (
    frequency_strip,
    radial_polynomials,
    retinotopic,
    zernike_amplitudes,
    zernike_disk_amplitudes,
    zernike_pairs,
)

N_VIEWS, ROWS, COLUMNS, N_RUNS = 256, 105, 360, 7


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def plain_functions(order: int) -> np.ndarray:
    """R_nm e^(−imθ) r dr dθ at each pixel, (pair, rows, columns)."""
    radius = (np.arange(ROWS) + 0.5) / ROWS
    azimuth = (np.arange(COLUMNS) + 0.5) * 2 * np.pi / COLUMNS - np.pi
    radial = radial_polynomials(order, radius).T * radius / ROWS
    waves = np.exp(-1j * zernike_pairs(order)[1][:, None] * azimuth) * 2 * np.pi / COLUMNS
    return radial[:, :, None] * waves[:, None, :]


def compare(name: str, run: Callable[[], object], n_views: int, plain: Callable[[], object]) -> None:
    """Print the median time a view and its ratio to the plain way of one view."""
    run()  # makes the basis
    times, ratios = [], []
    before = seconds(plain)
    for _ in range(N_RUNS):
        times.append(seconds(run) / n_views)
        after = seconds(plain)
        ratios.append((before + after) / 2.0 / times[-1])
        before = after
    print(
        f"{name:48s} {1e3 * statistics.median(times):8.3f} ms a view   1/{statistics.median(ratios):5.0f} of plain "
        f"(1/{min(ratios):.0f} … 1/{max(ratios):.0f})",
        flush=True,
    )


def main() -> None:
    rng = np.random.default_rng(0)
    grey = rng.integers(0, 256, (N_VIEWS, ROWS, COLUMNS), np.uint8)
    single = (grey / 255).astype(np.float32)
    functions, view = plain_functions(16), grey[0] / 255

    def plain() -> np.ndarray:
        return np.abs([np.sum(view * function) for function in functions])

    apart = np.abs(plain() - zernike_amplitudes(view, weights="raw")).max()
    print(f"{N_VIEWS} views of {ROWS} × {COLUMNS}, medians of {N_RUNS} runs; the plain sum agrees to {apart:.0e}")
    print(f"{'plain sum over pixels, n ≤ 16':48s} {1e3 * seconds(plain):8.3f} ms a view")
    compare("Zernike n ≤ 16, bytes", lambda: zernike_amplitudes(grey), N_VIEWS, plain)
    compare("Zernike n ≤ 16, float32", lambda: zernike_amplitudes(single), N_VIEWS, plain)
    compare("Zernike n ≤ 16, one view alone", lambda: zernike_amplitudes(grey[0]), 1, plain)
    compare("Zernike n ≤ 50, bytes", lambda: zernike_amplitudes(grey, 50), N_VIEWS, plain)
    compare("Zernike n ≤ 16 by a disk of 210 pixels, bytes", lambda: zernike_disk_amplitudes(grey), N_VIEWS, plain)
    compare("frequency strip", lambda: frequency_strip(grey), N_VIEWS, plain)
    compare("retinotopic", lambda: retinotopic(grey), N_VIEWS, plain)
    compare("root mean square difference", lambda: rms_difference(grey, grey[0]), N_VIEWS, plain)

    def brute_force() -> np.ndarray:
        return np.stack([rms_difference(np.roll(grey[0], -k, axis=-1), grey[1]) for k in range(COLUMNS)])

    print(f"{'difference after 360 turns, by brute force':48s} {1e3 * seconds(brute_force):8.3f} ms a view")
    compare("difference after 360 turns", lambda: difference_by_turn(grey, grey[1]), N_VIEWS, brute_force)
    compare("visual compass", lambda: visual_compass(grey, grey[1]), N_VIEWS, brute_force)

    n, spacing = 501, 0.02  # the thesis's grid of 251 001 views
    x, y = np.meshgrid(spacing * np.arange(n), spacing * np.arange(n))
    surface = np.hypot(x - 4.0, y - 6.0) + 0.02 * np.sin(7.0 * x) * np.sin(5.0 * y)
    starts = cell_centres((n, n), spacing, 1)[::5, ::5]
    descend(surface, spacing, starts[:1, :1])  # compiles, or loads what was compiled
    n_steps = int(descend(surface, spacing, starts, [4.0, 6.0], 0.03).n_steps.sum())
    for workers in (1, 2):
        way = partial(descend, surface, spacing, starts, [4.0, 6.0], 0.03, workers=workers)
        ways = [seconds(way) for _ in range(3)]
        print(f"{f'descent, {workers} threads':48s} {1e9 * statistics.median(ways) / n_steps:8.1f} ns a step")
    whole = seconds(lambda: catchment_area(surface, spacing, [4.0, 6.0], 0.03))
    print(f"{'catchment area of 500 × 500 starts, all threads':48s} {whole:8.2f} s")
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(
        f"{'peak memory of all this':48s} {megabytes:8.0f} MiB (the views alone are {grey.nbytes / 2**20:.0f} as bytes)"
    )


if __name__ == "__main__":
    main()
