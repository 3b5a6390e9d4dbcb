"""From the best places of the coarse search to rotations, scores and their order, on maps that are hardly blurred."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from insectnav.matching.view_maps import Singles, look_up
from insectnav.vision.sphere import Reals, fibonacci

N_POINTS = 6000  # on the sphere, 2.8° apart, at which views are compared in the end
N_ROUGH_POINTS = 2000  # on the sphere, 4.5° apart, at which they are compared at first
ROUGH_SHARE = 0.25  # of the first step, down to which few points do


class Points(NamedTuple):
    """Evenly spread directions at which a query is compared with references."""

    directions: Singles  # (point, 3), those that the query saw
    values: Singles  # (point,) of the query
    n_all: int  # on the whole sphere

    @property
    def area(self) -> float:
        """Solid angle that the query saw [sr]."""
        return len(self.values) / self.n_all * 4.0 * np.pi


class Candidate(NamedTuple):
    """A reference with the rotation at which it fits best."""

    reference: int
    rotation: Reals  # (3, 3), reference ← query
    score: float
    area: float  # of the overlap [sr]


def seen_points(view: Singles, n_cells: int, n_all: int) -> Points:
    """The points at which a view (node,) was seen, of `n_all` on the sphere."""
    spread = _spread(n_all)
    values = look_up(view[None], n_cells, spread)[0]
    seen = np.isfinite(values)
    return Points(spread[seen], values[seen], n_all)


@lru_cache(maxsize=4)
def _spread(n_all: int) -> Singles:
    """Directions (point, 3) over the whole sphere, made once."""
    spread = fibonacci(n_all).directions.astype(np.float32)
    spread.setflags(write=False)
    return spread


def refined(
    candidates: list[Candidate],
    points: Points,
    maps: Singles,
    n_cells: int,
    kind: int,
    least: Reals,
    steps: tuple[float, float],
) -> list[Candidate]:
    """Candidates at the best rotation near the one given, best score first.

    Parameters
    ----------
    points : of the query
    maps : (reference, node)
    kind : of score, as kernels number them
    least : (reference,) least overlap [sr]; a candidate that starts with less may keep that
    steps : first and last step [rad]
    """
    from insectnav.matching.rotation_kernel import refine

    found = []
    for candidate in candidates:
        k, rotation = candidate.reference, candidate.rotation.copy()
        n_least = least[k] / (4.0 * np.pi) * points.n_all
        score, n = refine(
            kind, points.directions, points.values, maps[k], n_cells, rotation, n_least, steps[0], steps[1]
        )
        found.append(Candidate(k, rotation, float(score), n / points.n_all * 4.0 * np.pi))
    return sorted(found, key=lambda candidate: -candidate.score)
