"""Surveys: views all over a place, rendered and measured block by block, so that no picture is kept."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from insectnav.checks import InputError, as_numbers, check_count, check_precision, check_range, check_shape, quoted
from insectnav.homing.descent import checked_spacing
from insectnav.homing.snapshots import feature_distance
from insectnav.vision.descriptors.brightness import as_views, batches
from insectnav.workers import count_workers
from insectnav.worlds.renderer import render_panorama
from insectnav.worlds.world import World

Reals = NDArray[np.floating[Any]]
Measure = Callable[[NDArray[np.float32]], NDArray[Any]]  # views (n, rows, columns) -> (n, ...)
VIEWS_AT_ONCE = 64  # 10 MB of pixels at 1°: long enough for matrix products, short enough for a cache


def grid_positions(size: float | tuple[float, float], spacing: float, corner: ArrayLike = (0.0, 0.0)) -> Reals:
    """Places on a square grid, (rows, columns, 2) [m] of x, y; [0, 0] is the corner with the least x and y.

    Parameters
    ----------
    size : float [m], or a pair along x and y
    spacing : float [m]
        Goes into the size a whole number of times; the far edge has samples, too.
    corner : (2,) array [m]

    Raises
    ------
    InputError
        If the spacing does not divide the size.
    """
    spacing = checked_spacing(spacing)
    lengths = np.broadcast_to(as_numbers("size", size).astype(float), 2)
    check_range("size", lengths, spacing, np.inf, "m")
    origin = as_numbers("corner", corner).astype(float)
    check_shape("corner", origin, (2,))
    counts = np.rint(lengths / spacing).astype(int)
    if (np.abs(counts * spacing - lengths) > 1e-6 * lengths).any():
        shown = " x ".join(f"{length:g}" for length in lengths)
        raise InputError(f"spacing is {spacing:g} m, expected one that divides the {shown} m of the grid")
    x, y = (origin[k] + spacing * np.arange(counts[k] + 1) for k in (0, 1))
    return np.stack(np.meshgrid(x, y), axis=-1)


def survey(
    world: World,
    positions: ArrayLike,
    headings: ArrayLike,
    measures: Mapping[str, Measure],
    *,
    resolution_deg: float = 1.0,
    elevation_deg: tuple[float, float] = (-15.0, 90.0),
    supersampling: int = 4,
    band: str = "grey",
    dtype: DTypeLike = "float32",
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> dict[str, NDArray[Any]]:
    """What each measure says of the view at each position, name → (..., feature); the views themselves are not kept.

    Parameters
    ----------
    world, headings, resolution_deg, elevation_deg, supersampling, band, workers, progress
        As of `insectnav.worlds.render_panorama`; headings are (...) or one for all. A thread takes a block of views.
    positions : (..., 2 or 3) array [m], such as `grid_positions` gives
    measures : name → function
        From views (n, rows, columns) to (n, ...): a descriptor of `insectnav.vision.descriptors.DESCRIPTORS`, what
        `distance_from` gives, or one of your own. It may be called from several threads at a time.
    dtype : {"float32", "float64"}
        Of what is kept.

    Returns
    -------
    dict of arrays

    Raises
    ------
    InputError
        If there is nothing to measure, a measure does not give a row for each view, or as `render_panorama`.

    Notes
    -----
    A grid of 501 × 501 views of 1° (thesis section 4.3) would take 38 GB; a block of 64 takes 10 MB.
    """
    leading, places, turned = _checked_poses(positions, headings)
    precision = check_precision("dtype", dtype)
    if not measures:
        raise InputError("measures is empty, expected at least one function of the views")
    look: dict[str, Any] = {"resolution_deg": resolution_deg, "elevation_deg": elevation_deg, "band": band}

    def measure(first: int) -> dict[str, NDArray[Any]]:
        block = slice(first, first + VIEWS_AT_ONCE)
        views = render_panorama(world, places[block], turned[block], supersampling=supersampling, workers=1, **look)
        return {name: _checked_rows(name, of(views), len(views)) for name, of in measures.items()}

    blocks = _in_threads(measure, range(0, len(places), VIEWS_AT_ONCE), count_workers(workers))
    found = _gathered(blocks, len(places), precision, progress)
    return {name: values.reshape((*leading, *values.shape[1:])) for name, values in found.items()}


def _gathered(
    blocks: Iterator[Mapping[str, NDArray[Any]]], n: int, dtype: Any, progress: Callable[[int], None] | None
) -> dict[str, NDArray[Any]]:
    """Rows of all blocks, in their order, name → (n, ...)."""
    found: dict[str, NDArray[Any]] = {}
    first = 0
    for rows in blocks:
        last = min(first + VIEWS_AT_ONCE, n)
        for name, values in rows.items():
            if name not in found:
                found[name] = np.empty((n, *values.shape[1:]), dtype)
            found[name][first:last] = values
        if progress is not None:
            progress(last - first)
        first = last
    return found


def _in_threads(task: Callable[[int], Any], starts: Sequence[int], workers: int) -> Iterator[Any]:
    """Results in their order. The first comes alone: it compiles, makes bases, and finds what is wrong, once."""
    yield task(starts[0])
    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(task, starts[1:])


def _checked_poses(positions: ArrayLike, headings: ArrayLike) -> tuple[tuple[int, ...], Reals, Reals]:
    """Leading shape, positions (n, 2 or 3) and headings (n,)."""
    places = as_numbers("positions", positions).astype(float)
    check_shape("positions", places, (..., "x, y or x, y, z"))
    leading, places = places.shape[:-1], places.reshape(-1, places.shape[-1])
    turned = as_numbers("headings", headings).astype(float)
    if turned.ndim and turned.shape != leading:
        raise InputError(f"headings has shape {turned.shape}, expected one for all or {leading} as the positions")
    check_count("number of positions", len(places))
    return leading, places, np.broadcast_to(turned, leading).reshape(-1)


def distance_from(remembered: ArrayLike, by: str | Callable[[ArrayLike], Reals] = "aligned") -> Measure:
    """A measure for `survey`: how far views (n, rows, columns) are from each of the remembered ones, (n, remembered).

    Parameters
    ----------
    remembered : (remembered, rows, columns) array
        Bytes count as 0 to 1.
    by : str or function
        "aligned": root mean square pixel difference. "compass": the least of them over all turns by whole columns. A
        descriptor: the Euclidean distance of its vectors.

    Raises
    ------
    InputError
        If the remembered views are not a stack of panoramas, or the word is unknown.

    Notes
    -----
    The same as `rms_difference`, `visual_compass` and `feature_distance` for each remembered view in turn, as matrix
    products. A root mean square difference below 1e-6 of the brightness is rounding.
    """
    stack = as_views(remembered)
    check_shape("remembered", stack, ("remembered", "rows", "columns"))
    if callable(by):
        return _feature_distances(by, by(stack))
    if by not in ("aligned", "compass"):
        raise InputError(f"by is {quoted(by)}, expected 'aligned', 'compass' or a descriptor")
    values = np.concatenate([piece for _, piece in batches(stack)])
    return _aligned_distance(values) if by == "aligned" else _compass_distance(values)


def _feature_distances(describe: Callable[[ArrayLike], Reals], remembered: Reals) -> Measure:
    def distance(views: NDArray[np.float32]) -> Reals:
        features = describe(views)
        return np.stack([feature_distance(features, vector) for vector in remembered], axis=-1)

    return distance


def _aligned_distance(remembered: Reals) -> Measure:
    flat = remembered.reshape(len(remembered), -1)
    own = np.einsum("kp,kp->k", flat, flat)

    def distance(views: NDArray[np.float32]) -> Reals:
        array = _like(views, remembered)
        found = np.empty((len(array), len(flat)))
        for piece, values in batches(array):
            pixels = values.reshape(len(values), -1)
            squares = np.einsum("np,np->n", pixels, pixels)[:, None] + own - 2.0 * (pixels @ flat.T)
            found[piece] = np.sqrt(np.maximum(squares, 0.0) / flat.shape[1])
        return found

    return distance


def _compass_distance(remembered: Reals) -> Measure:
    """For all turns and all remembered views at once: a product of waves for each frequency, and one way back."""
    columns = remembered.shape[-1]
    waves = np.ascontiguousarray(np.fft.rfft(remembered, axis=-1).conj().transpose(2, 1, 0))  # (frequency, row, view)
    own = np.einsum("krc,krc->k", remembered, remembered)

    def distance(views: NDArray[np.float32]) -> Reals:
        array = _like(views, remembered)
        found = np.empty((len(array), len(remembered)))
        for piece, values in batches(array):
            seen = np.ascontiguousarray(np.fft.rfft(values, axis=-1).transpose(2, 0, 1))
            best = np.fft.irfft(seen @ waves, columns, axis=0).max(axis=0)
            squares = np.einsum("nrc,nrc->n", values, values)[:, None] + own - 2.0 * best
            found[piece] = np.sqrt(np.maximum(squares, 0.0) / remembered[0].size)
        return found

    return distance


def _like(views: ArrayLike, remembered: Reals) -> NDArray[Any]:
    array = as_views(views)
    if array.ndim != 3 or array.shape[1:] != remembered.shape[1:]:
        raise InputError(f"views have shape {array.shape}, expected (n, rows, columns) as the remembered ones")
    return array


def _checked_rows(name: str, values: Any, n_views: int) -> NDArray[Any]:
    rows = np.asarray(values)
    if rows.dtype.kind not in "buif" or rows.shape[:1] != (n_views,):
        raise InputError(
            f"measure {quoted(name)} gives {rows.dtype.name} of shape {rows.shape} for {n_views} views, "
            "expected real numbers with a row for each view"
        )
    return rows
