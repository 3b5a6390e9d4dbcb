"""All relative rotations of views, coarsely: tilts one by one, turns about the vertical by Fourier transform.

A rotation of the query is a tilt of its upward axis towards some azimuth, then a turn about the reference's upward
axis. On rings round that axis a turn is a shift, so that the sums over the overlap for all turns are correlations along
azimuth: for each frequency one product of matrices (tilts × rings)·(rings × references), then an inverse transform.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import FULL_TURN
from insectnav.matching.view_maps import Singles, look_up
from insectnav.vision.sphere import Reals, directions, rotation_matrix

Spectra = NDArray[np.complexfloating[Any]]
KINDS = {"difference": 0, "correlation": 1}  # as kernels number the scores
_REFERENCES_AT_ONCE = 64  # whose sums over all tilts and turns stay in a processor's cache
_SLACK = 1e-6  # of the share of overlap, for rounding


@dataclass(frozen=True, kw_only=True, eq=False)
class RingSpectra:
    """References on rings, as `best_rotations` takes them; made by `ring_spectra`.

    Parameters
    ----------
    directions : (ring, turn, 3) of the rings on which a reference saw anything
    weights : (ring,) solid angle of each direction of a ring
    views : (frequency, 2 · ring, reference) transform along azimuth of r and r², 0 where not seen
    masks : (frequency, ring, mask) transform of the different masks
    mask_of : (reference,) which mask each has
    """

    directions: Reals
    weights: Reals
    views: Spectra
    masks: Spectra
    mask_of: NDArray[np.int64]

    @property
    def n_turns(self) -> int:
        """Number of turns, and of directions on a ring."""
        return int(self.directions.shape[1])

    def part(self, references: NDArray[np.integer[Any]]) -> "RingSpectra":
        """Some of the references (reference,) alone."""
        return replace(self, views=self.views[..., references], mask_of=self.mask_of[references])


def tilt_rotations(spacing: float, max_tilt: float) -> Reals:
    """Tilts (tilt, 3, 3) of an upward axis, reference ← query, first none, then in rings about ``spacing`` [rad] apart.

    Each turns the upward axis by the shortest way; in a ring the axes are evenly spread.
    """
    tilts = [np.eye(3)]
    for angle in np.arange(spacing, max_tilt + 1e-9, spacing):
        count = max(1, round(FULL_TURN * np.sin(angle) / spacing))
        for towards in np.arange(count) * FULL_TURN / count:
            turn = rotation_matrix(towards)
            tilts.append(turn @ rotation_matrix(0.0, -angle) @ turn.T)
    return np.stack(tilts)


def ring_grid(n_turns: int) -> tuple[Reals, Reals]:
    """Directions (ring, turn, 3) on rings as far apart as those along the equator, and the solid angle of each."""
    spacing = FULL_TURN / n_turns
    edges = np.pi / 2 - spacing * np.arange(n_turns // 2 + 1)
    vectors = directions(np.arange(n_turns) * spacing, (edges[:-1, None] + edges[1:, None]) / 2)
    return vectors, -np.diff(np.sin(edges)) * spacing


def ring_spectra(maps: Singles, n_cells: int, n_turns: int) -> RingSpectra:
    """References on rings, of their maps (reference, node)."""
    vectors, weights = ring_grid(n_turns)
    values = look_up(maps, n_cells, vectors)
    seen = np.isfinite(values)
    used = seen.any(axis=(0, 2))
    values, seen = np.where(seen, values, 0.0)[:, used], seen[:, used]
    masks, mask_of = np.unique(seen.reshape(len(seen), -1), axis=0, return_inverse=True)
    stacked = np.concatenate([values, values**2], axis=1)
    return RingSpectra(
        directions=vectors[used],
        weights=weights[used],
        views=_transform(stacked),
        masks=_transform(masks.reshape(-1, *seen.shape[1:])),
        mask_of=mask_of.ravel().astype(np.int64),
    )


def _transform(rows: NDArray[Any]) -> Spectra:
    """Transform along azimuth of (view, row, turn), as (frequency, row, view)."""
    spectrum = np.fft.rfft(rows.astype(np.float32), axis=-1)
    return np.ascontiguousarray(spectrum.transpose(2, 1, 0))


def best_rotations(
    query: Singles, n_cells: int, tilts: Reals, references: RingSpectra, least: Reals, score: str
) -> tuple[Reals, NDArray[np.int64]]:
    """Best score of a query with each reference, −inf where none counts, and its place: tilt · turns + turn.

    Parameters
    ----------
    query : (node,) map of the query
    tilts : (tilt, 3, 3) reference ← query
    least : (reference,) least overlap that counts [sr]
    score : "difference" or "correlation"
    """
    from insectnav.matching.rotation_kernel import best_of_turns

    # The query as it is when tilted: along the direction d of the reference it shows what it had along Tᵀ d.
    looked = np.einsum("tji,akj->taki", tilts, references.directions, optimize=True)
    values = look_up(query[None], n_cells, looked)[0]
    seen = np.isfinite(values)
    values = np.where(seen, values, np.float32(0.0))
    weights = references.weights[:, None].astype(np.float32)
    parts = np.stack([seen * weights, values * weights, values**2 * weights])
    spectra = np.fft.rfft(parts, axis=-1).conj()
    spectra = np.ascontiguousarray(spectra.transpose(0, 3, 1, 2))  # (1 q q², frequency, tilt, ring)
    n_references = len(references.mask_of)
    scores, places = np.full(n_references, -np.inf), np.full(n_references, -1)
    floor = least * (1.0 - _SLACK)
    for first in range(0, n_references, _REFERENCES_AT_ONCE):
        some = slice(first, first + _REFERENCES_AT_ONCE)
        used, mask_of = np.unique(references.mask_of[some], return_inverse=True)
        shared = np.stack([_correlate(part, references.masks[..., used], references.n_turns) for part in spectra])
        pairs = _pair_sums(spectra, references.views[..., some], references.n_turns, score)
        best_of_turns(KINDS[score], shared, pairs, mask_of.ravel(), floor[some], scores[some], places[some])
    return scores, places


def _pair_sums(spectra: Spectra, views: Spectra, n_turns: int, score: str) -> Singles:
    """Sums over the overlap that differ from reference to reference, (sum, tilt, reference, turn)."""
    ones, q, _ = spectra
    n_rings = q.shape[-1]
    if score == "difference":
        return _correlate(np.concatenate([-2.0 * q, ones], axis=-1), views, n_turns)[None]
    r, rr = views[:, :n_rings], views[:, n_rings:]
    return np.stack([_correlate(ones, r, n_turns), _correlate(ones, rr, n_turns), _correlate(q, r, n_turns)])


def _correlate(query: Spectra, references: Spectra, n_turns: int) -> Singles:
    """Correlation along azimuth (tilt, reference, turn) of (frequency, tilt, ring) and (frequency, ring, reference)."""
    product = np.matmul(query, references)
    return np.asarray(np.fft.irfft(product.transpose(1, 2, 0), n_turns, axis=-1), np.float32)


def rotation_of(place: int, tilts: Reals, n_turns: int) -> Reals:
    """Rotation (3, 3), reference ← query, of a place that `best_rotations` gives."""
    tilt, turn = divmod(place, n_turns)
    angle = turn * FULL_TURN / n_turns
    return rotation_matrix((angle + np.pi) % FULL_TURN - np.pi) @ tilts[tilt]
