"""How fast views are expanded in spherical harmonics: one line each, with the ratio to a plain product in the same run.

The plain way sums each row times each wave, and then those sums times each Legendre function, functions made once. In
the last line it is one product with a matrix of all harmonics at all directions, which for 120 degrees would take 3 GB.
Wall time drifts on shared machines, so each fast measurement stands between two plain ones, and the median of the
ratios is what to quote. Run it by ``make bench``.
"""

import importlib.util
import resource
import statistics
import time
from collections.abc import Callable

import numpy as np

from insectnav.vision.descriptors import harmonic_amplitudes, real_harmonics, sphere_amplitudes, sphere_coefficients
from insectnav.vision.descriptors.harmonic_basis import legendre_functions
from insectnav.vision.sphere import gauss_legendre, thesis

N_VIEWS, N_RUNS = 64, 7


def seconds(function: Callable[[], object]) -> float:
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


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
        f"{name:52s} {1e3 * statistics.median(times):8.3f} ms a view   1/{statistics.median(ratios):6.2f} of plain "
        f"(1/{min(ratios):.2f} … 1/{max(ratios):.2f})",
        flush=True,
    )


def plain_amplitudes(n_degrees: int) -> Callable[[np.ndarray], np.ndarray]:
    """Amplitudes of one view on rings, by sums over azimuth and over rings, one harmonic after the other."""
    grid = gauss_legendre(n_degrees)
    azimuth = (np.arange(2 * n_degrees) + 0.5) * np.pi / n_degrees - np.pi
    height, weights = grid.directions[:: 2 * n_degrees, 2], grid.weights[:: 2 * n_degrees]
    tables = [table * weights for table in legendre_functions(n_degrees, height)]
    waves = [(np.cos(m * azimuth), np.sin(m * azimuth)) for m in range(n_degrees)]

    def amplitudes(view: np.ndarray) -> np.ndarray:
        power = np.zeros(n_degrees)
        for m, (table, pair) in enumerate(zip(tables, waves, strict=True)):
            for wave in pair:
                along = np.sum(view * wave, axis=1)
                power[m:] += [np.sum(row * along) ** 2 for row in table]
        return np.sqrt(power)

    return amplitudes


def ducc_amplitudes(views: np.ndarray) -> np.ndarray:
    """The same by ducc0, an outside library."""
    import ducc0

    n_degrees = views.shape[1]
    degree = np.concatenate([np.arange(m, n_degrees) for m in range(n_degrees)])
    counts = np.where(np.arange(len(degree)) < n_degrees, 1.0, 2.0)  # m = 0, then m and −m
    amplitudes = np.empty((len(views), n_degrees))
    for view, out in zip(views, amplitudes, strict=True):
        found = ducc0.sht.analysis_2d(map=view[None], spin=0, lmax=n_degrees - 1, geometry="GL", nthreads=1)[0]
        out[:] = np.sqrt(np.bincount(degree, counts * (found.real**2 + found.imag**2)))
    return amplitudes


def main() -> None:
    rng = np.random.default_rng(0)
    grid, fine = gauss_legendre(120), gauss_legendre(240)
    rings, views = rng.random((N_VIEWS, 120, 240)), rng.integers(0, 256, (N_VIEWS, 105, 360), np.uint8)
    amplitudes = plain_amplitudes(120)

    def plain() -> np.ndarray:
        return amplitudes(rings[0])

    apart = np.abs(plain() - sphere_amplitudes(rings[0], grid)).max()
    print(f"batches of {N_VIEWS} views, medians of {N_RUNS} runs; the plain sum agrees to {apart:.0e}")
    print(f"{'plain sums, 120 degrees on 120 × 240':52s} {1e3 * seconds(plain):8.3f} ms a view")
    compare("120 degrees on 120 × 240", lambda: sphere_amplitudes(rings, grid), N_VIEWS, plain)
    compare("the same, one view alone", lambda: sphere_amplitudes(rings[0], grid), 1, plain)
    compare("coefficients", lambda: sphere_coefficients(rings, grid), N_VIEWS, plain)
    if importlib.util.find_spec("ducc0"):
        compare("by ducc0, one thread", lambda: ducc_amplitudes(rings), N_VIEWS, plain)
    doubled = rng.random((16, 240, 480))
    compare("120 degrees on 240 × 480", lambda: sphere_amplitudes(doubled, fine), len(doubled), plain)
    compare("120 degrees, panorama of 105 × 360 bytes", lambda: harmonic_amplitudes(views), N_VIEWS, plain)
    compare("60 degrees, the same", lambda: harmonic_amplitudes(views, 60), N_VIEWS, plain)
    points = rng.random((N_VIEWS, 2000))
    compare("120 degrees, 2000 points in batches of 64", lambda: sphere_amplitudes(points, thesis()), N_VIEWS, plain)
    compare("120 degrees, 2000 points, one view alone", lambda: sphere_amplitudes(points[0], thesis()), 1, plain)

    small = gauss_legendre(40)
    basis = real_harmonics(40, small.directions) * small.weights[:, None]
    coarse = rng.random((N_VIEWS, 40, 80))
    compare(
        "40 degrees on 40 × 80, against a product of matrices",
        lambda: sphere_coefficients(coarse, small, 40),
        N_VIEWS,
        lambda: coarse[0].ravel() @ basis,
    )
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(f"{'peak memory of all this':52s} {megabytes:8.0f} MiB, of which the basis of 105 × 360 takes 6")


if __name__ == "__main__":
    main()
