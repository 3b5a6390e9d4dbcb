"""Place and relative orientation of views at any tilt: all rotations, and only the directions that both views saw.

A view is values on directions of the sphere and a mask of what was seen. A query is compared with each reference over
all their relative rotations; what counts is the mean over the overlap of the two masks alone, so that a camera that
sees half the sphere may tilt without the rest of it being taken for ground.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_count, check_finite, check_range
from insectnav.matching.rotation_matches import RotationMatches
from insectnav.matching.rotation_refinement import (
    N_POINTS,
    N_ROUGH_POINTS,
    ROUGH_SHARE,
    Candidate,
    Points,
    refined,
    seen_points,
)
from insectnav.matching.view_maps import Blur, Bools, Singles, blur_to_cube
from insectnav.vision.sphere import Reals, SphereGrid

if TYPE_CHECKING:
    from insectnav.matching.rotation_search import RingSpectra

SCORES = ("difference", "correlation")
_ROUNDING = 1e-4  # by which resampled values may leave 0 to 1
_FLATTEST = 1e-6  # range of values of order 1, under which a view is constant


@dataclass(frozen=True, kw_only=True)
class RotationParams:
    """How views are compared, and how finely rotations are searched.

    ``score`` "difference" is 1 − mean (q − r)² over the overlap, of values from 0 to 1: for masks of the sky.
    "correlation" is the normalised correlation over the overlap: for grey views, of which brightness and contrast may
    differ.

    Notes
    -----
    The numbers are ours and follow from geometry, none was fitted to views: two views of half the sphere at a tilt of
    90° still share half of what each saw; the coarse Gaussian is about half as wide as rings, turns and tilts are
    apart, so that nothing falls between them; the first step of the refinement is half the spacing of tilts.
    """

    score: str = "difference"
    max_tilt: float = float(np.deg2rad(90.0))  # [rad] between the upward axes of query and reference
    least_overlap: float = 0.25  # of what the one saw that saw less
    n_turns: int = 48  # about the upward axis, 7.5° apart, as rings are
    tilt_spacing: float = float(np.deg2rad(10.0))  # [rad]
    coarse_blur: float = float(np.deg2rad(4.0))  # [rad], standard deviation
    fine_blur: float = float(np.deg2rad(1.0))  # [rad], standard deviation
    n_refined: int = 10  # references, the best of the coarse search
    n_finished: int = 3  # of these, refined to the last step
    last_step: float = float(np.deg2rad(0.1))  # [rad] of the refinement

    def __post_init__(self) -> None:
        check_choice("score", self.score, SCORES)
        check_range("max_tilt", self.max_tilt, 0.0, np.pi + 1e-9, "rad", "degrees?")
        check_range("least_overlap", self.least_overlap, 0.01, 1.0)
        check_count("n_turns", self.n_turns, minimum=8)
        if self.n_turns % 2:
            raise InputError(f"n_turns is {self.n_turns}, expected an even number")
        for name in ("tilt_spacing", "coarse_blur", "fine_blur", "last_step"):
            check_range(name, getattr(self, name), 1e-3, 0.6, "rad", "degrees?")
        check_count("n_refined", self.n_refined)
        check_count("n_finished", self.n_finished)


class _Query(NamedTuple):
    """A view that is searched for: blurred twice, and what it can share with each reference."""

    number: int
    coarse: Singles  # (node,)
    fine: Singles  # (node,)
    points: Points
    smaller: Reals  # (reference,) solid angle of the one of both that saw less [sr]


@dataclass(frozen=True, kw_only=True, eq=False)
class RotationIndex:
    """References to match queries with; made by `build_rotation_index`, and changed by no query.

    Parameters
    ----------
    grid : on whose directions views come
    params : how they are compared
    coarse, fine : blurs of a view, for the search and for its refinement
    maps : (reference, node) fine maps of the references
    areas : (reference,) solid angle that each saw [sr]
    rings : references on rings, for the search
    tilts : (tilt, 3, 3) that are searched, reference ← query
    """

    grid: SphereGrid
    params: RotationParams
    coarse: Blur
    fine: Blur
    maps: Singles
    areas: Reals
    rings: "RingSpectra"
    tilts: Reals

    @property
    def n_references(self) -> int:
        """Number of references."""
        return len(self.maps)

    @property
    def n_bytes(self) -> int:
        """Memory that the references take."""
        return int(self.maps.nbytes + self.rings.views.nbytes + self.rings.masks.nbytes)

    def part(self, references: ArrayLike) -> "RotationIndex":
        """Index of some of the references alone, in the order given: those near a place that is known, or one of them.

        Parameters
        ----------
        references : (reference,) array of int, numbers in this index

        Raises
        ------
        InputError
            If there are none, or a number is not that of a reference.
        """
        chosen = np.asarray(references)
        if chosen.ndim != 1 or not chosen.size or chosen.dtype.kind not in "iu":
            raise InputError(
                f"references have shape {chosen.shape} and type {chosen.dtype.name}, expected some whole numbers"
            )
        check_range("references", chosen, 0, self.n_references - 1)
        return replace(self, maps=self.maps[chosen], areas=self.areas[chosen], rings=self.rings.part(chosen))

    def match(self, views: ArrayLike, seen: ArrayLike) -> RotationMatches:
        """Best reference and relative rotation of each query.

        Parameters
        ----------
        views : (..., direction) array, or (..., rows, columns) of a grid of rows
            As of `build_rotation_index`.
        seen : array of bool that broadcasts to the views
            True where the query saw. Values elsewhere, NaN too, do not matter.

        Returns
        -------
        RotationMatches
            In the leading axes of the views; the same whether queries come one by one or together.

        Raises
        ------
        InputError
            If views do not fit the grid, are not finite where seen, are constant, or overlap with no reference.
        """
        return self.match_and_compare(views, seen)[0]

    def match_and_compare(self, views: ArrayLike, seen: ArrayLike) -> tuple[RotationMatches, Reals]:
        """Matches as of `match`, and differences as of `compare`, by one search.

        Parameters
        ----------
        views, seen
            As of `match`.
        """
        queries, masks, lead = _as_views(views, seen, self.grid)
        differences = np.empty((len(queries), self.n_references), np.float32)
        found = [
            self._match_one(self._query(k, query, mask), differences[k])
            for k, (query, mask) in enumerate(zip(queries, masks, strict=True))
        ]
        columns = {name: np.array([one[name] for one in found]) for name in found[0]}
        matches = RotationMatches(**{name: c.reshape((*lead, *c.shape[1:])) for name, c in columns.items()})
        return matches, differences.reshape(*lead, self.n_references)

    def compare(self, views: ArrayLike, seen: ArrayLike) -> Reals:
        """Difference of each query and each reference, (..., reference) float32.

        A difference is one less the score of the coarse search at the rotation that fits best. It is not refined: it is
        for `seqslam`, which needs all pairs, as (reference, query). From 0, the same, to 1, or to 2 for the score
        "correlation"; the most also stands for too little overlap.

        Parameters
        ----------
        views, seen
            As of `match`.

        Raises
        ------
        InputError
            As of `match`.
        """
        queries, masks, lead = _as_views(views, seen, self.grid)
        differences = np.empty((len(queries), self.n_references), np.float32)
        for k, (query, mask) in enumerate(zip(queries, masks, strict=True)):
            self._starts(self._query(k, query, mask), differences[k])
        return differences.reshape(*lead, self.n_references)

    def _query(self, number: int, view: NDArray[Any], mask: Bools) -> _Query:
        """One view (direction,) as it is searched for."""
        prepared = _prepared(view, mask, self.params.score, f"query {number}")
        fine = self.fine(*prepared)[0]
        points = seen_points(fine, self.fine.n_cells, N_POINTS)
        return _Query(number, self.coarse(*prepared)[0], fine, points, np.minimum(points.area, self.areas))

    def _match_one(self, query: _Query, differences: Singles) -> dict[str, Any]:
        """Fields of the match of one view; fills its differences (reference,)."""
        best = self._finished(query, self._starts(query, differences))
        first, second = best[0], best[1] if len(best) > 1 else None
        return {
            "reference": first.reference,
            "rotation": first.rotation,
            "score": first.score,
            "runner_up": second.reference if second else -1,
            "ratio": _ratio(first.score, second.score) if second else np.nan,
            "overlap": first.area / query.smaller[first.reference],
        }

    def _starts(self, query: _Query, differences: Singles) -> list[Candidate]:
        """The best references of the coarse search, each at its best rotation; fills the differences (reference,)."""
        from insectnav.matching.rotation_search import best_rotations, rotation_of

        params, least = self.params, self.params.least_overlap * query.smaller
        scores, places = best_rotations(query.coarse, self.coarse.n_cells, self.tilts, self.rings, least, params.score)
        differences[:] = np.clip(1.0 - scores, 0.0, 1.0 if params.score == "difference" else 2.0)
        order = np.argsort(-scores, kind="stable")
        order = order[np.isfinite(scores[order])][: params.n_refined]
        if not order.size:
            raise InputError(
                f"query {query.number} shares less than {params.least_overlap:g} of what was seen with every reference "
                f"at all tilts up to {np.rad2deg(params.max_tilt):.3g}°: another mounting, or a larger max_tilt?"
            )
        return [
            Candidate(int(k), rotation_of(int(places[k]), self.tilts, self.rings.n_turns), float(scores[k]), 0.0)
            for k in order
        ]

    def _finished(self, query: _Query, starts: list[Candidate]) -> list[Candidate]:
        """The best candidates, refined: all of them at few points, then the best of these at all."""
        from insectnav.matching.rotation_search import KINDS

        params, kind, n_cells = self.params, KINDS[self.params.score], self.fine.n_cells
        least = params.least_overlap * query.smaller
        first = max(params.tilt_spacing / 2.0, params.last_step)
        middle = max(ROUGH_SHARE * first, params.last_step)
        rough = seen_points(query.fine, n_cells, N_ROUGH_POINTS)
        some = refined(starts, rough, self.maps, n_cells, kind, least, (first, middle))[: params.n_finished]
        return refined(some, query.points, self.maps, n_cells, kind, least, (middle, params.last_step))


def build_rotation_index(
    views: ArrayLike, seen: ArrayLike, grid: SphereGrid, params: RotationParams | None = None
) -> RotationIndex:
    """Index of references, built once, to find the place and orientation of queries.

    Parameters
    ----------
    views : (reference, direction) array, or (reference, rows, columns) of a grid of rows
        Values on the directions of the grid, from a camera by `vision.resampler` or rendered. Bool, or from 0 to 1, for
        the score "difference", where integers count as shares of the largest of their type; of any unit for
        "correlation".
    seen : array of bool that broadcasts to the views
        True where the reference saw. Values elsewhere, NaN too, do not matter.
    grid : SphereGrid
        Directions of the views, no farther apart than 1.6 times the fine blur; all of the sphere or a part of it.
    params : RotationParams
        None for the defaults.

    Raises
    ------
    InputError
        If views do not fit the grid, are not finite where seen, are constant, or the grid is too coarse.

    Notes
    -----
    The mean over the overlap for all rotations: for each tilt of the query correlations along azimuth, by Fourier
    transform. Sums that depend on the reference's mask alone are made once for all references that share it, so that
    one correlation is left for each pair of views for the score "difference", three for "correlation". Matches are
    refined at 2000 points of the sphere, 4.5° apart, and in the end at 6000, 2.8° apart. A blurred view is seen where
    at least half of the Gaussian about it is.
    """
    from insectnav.matching.rotation_search import ring_spectra, tilt_rotations

    params = RotationParams() if params is None else params
    stack, masks, lead = _as_views(views, seen, grid)
    if len(lead) != 1:
        raise InputError(f"views have shape {np.shape(views)}, expected one axis of references before the directions")
    coarse = blur_to_cube(grid, params.coarse_blur, "coarse_blur")
    fine = blur_to_cube(grid, params.fine_blur, "fine_blur")
    maps = np.empty((len(stack), fine.n_nodes), np.float32)
    coarse_maps = np.empty((len(stack), coarse.n_nodes), np.float32)
    for k, (view, mask) in enumerate(zip(stack, masks, strict=True)):
        prepared = _prepared(view, mask, params.score, f"reference {k}")
        maps[k], coarse_maps[k] = fine(*prepared)[0], coarse(*prepared)[0]
    maps.setflags(write=False)
    return RotationIndex(
        grid=grid,
        params=params,
        coarse=coarse,
        fine=fine,
        maps=maps,
        areas=np.array([seen_points(view, fine.n_cells, N_POINTS).area for view in maps]),
        rings=ring_spectra(coarse_maps, coarse.n_cells, params.n_turns),
        tilts=tilt_rotations(params.tilt_spacing, params.max_tilt),
    )


def _ratio(best: float, second: float) -> float:
    """Distance from a perfect score, best over second; 1 where both are perfect."""
    return (1.0 - best) / (1.0 - second) if second < 1.0 else 1.0


def _as_views(views: ArrayLike, seen: ArrayLike, grid: SphereGrid) -> tuple[NDArray[Any], Bools, tuple[int, ...]]:
    """Views and masks (view, direction), and the leading axes; refuses other shapes and types."""
    array, mask = np.asarray(views), np.asarray(seen)
    if array.dtype.kind != "b":
        array = as_numbers("views", views)
    is_flat = array.shape[-1:] == (grid.n_directions,)
    if not is_flat and (grid.shape is None or array.shape[-2:] != grid.shape):
        rows = f" or (..., {grid.shape[0]}, {grid.shape[1]})" if grid.shape else ""
        raise InputError(
            f"views have shape {array.shape}, expected (..., {grid.n_directions}){rows}, as the grid {grid.name}"
        )
    if mask.dtype.kind != "b":
        raise InputError(f"seen holds {mask.dtype.name} values, expected True and False")
    try:
        mask = np.broadcast_to(mask, array.shape)
    except ValueError:
        raise InputError(f"seen has shape {mask.shape}, expected to broadcast to the views, {array.shape}") from None
    lead = array.shape[: -1 if is_flat else -2]
    if 0 in lead:
        raise InputError(f"views have shape {array.shape}, expected at least one view")
    return array.reshape(-1, grid.n_directions), mask.reshape(-1, grid.n_directions), lead


def _prepared(view: NDArray[Any], mask: Bools, score: str, name: str) -> tuple[Singles, Bools]:
    """One view (direction,) as values of order 1, 0 where not seen, and its mask, (1, direction) each."""
    if not mask.any():
        raise InputError(f"{name} has no direction that was seen, expected some: is the mask upside down?")
    values = view[mask].astype(np.float64)
    check_finite(f"{name}, where seen,", values)
    if score == "difference":
        if view.dtype.kind in "iu":
            values /= np.iinfo(view.dtype).max
        slip = "bytes as floats, or meant for the score 'correlation'?"
        if values.min() < -_ROUNDING or values.max() > 1.0 + _ROUNDING:
            check_range(name, values, 0.0, 1.0, slip=slip)
    else:
        values = values - values.mean()
        values /= max(float(values.std()), np.finfo(float).tiny)
    if np.ptp(values) < _FLATTEST:
        raise InputError(f"{name} has one value, {view[mask][0]:g}, in all that was seen, which fits at every rotation")
    filled = np.zeros((1, len(view)), np.float32)
    filled[0, mask] = values
    return filled, np.ascontiguousarray(mask[None])
