"""Rows of buildings side by side, as along a street."""

import numpy as np

from insectnav.angles import Floats
from insectnav.worlds.buildings import STOREY, Building, building
from insectnav.worlds.shapes import Part, joined, placed
from insectnav.worlds.ways import distance_to_way

PLOT = (11.0, 22.0)  # [m] wide, least and greatest
PITCHED_WALLS = ("brick", "render", "sandstone", "limestone")
FLAT_WALLS = ("concrete", "render", "brick")


def row_of_buildings(
    rng: np.random.Generator,
    middle: Floats,
    length: float,
    heading: float,
    *,
    depth: float,
    storeys: int,
    is_flat: bool,
    base: float,
    route: Floats,
    window_range: float,
    scaffold_share: float,
    gap_share: float,
) -> list[Part]:
    """Buildings wall to wall whose fronts look along a heading, some plots left empty.

    Parameters
    ----------
    middle : (2,) array [m]
        Of the row.
    length, depth : float
        Across and along the heading [m].
    heading : float [rad]
    storeys : int
        Of most of them; one more or less for the others.
    is_flat : bool
        Whether most roofs are flat.
    base : float
        Height of the pavement [m].
    route : (n, 2) array [m]
        Windows and scaffolds are built where the front is near it.
    window_range : float
        How near [m].
    scaffold_share, gap_share : float
        Of the buildings near the route, and of the plots.
    """
    if length < PLOT[0]:
        return []
    shares = 0.7 + 0.6 * rng.random(max(1, round(length / (PLOT[0] + (PLOT[1] - PLOT[0]) * rng.random()))))
    widths = length * shares / shares.sum()
    offsets = np.cumsum(widths) - widths / 2 - length / 2
    right = np.array([np.cos(heading), -np.sin(heading)])
    centres = middle + offsets[:, None] * right
    fronts = centres + 0.5 * depth * np.array([np.sin(heading), np.cos(heading)])
    is_near = distance_to_way(fronts, route[::5]) < window_range
    plans = []
    for width, near in zip(widths, is_near, strict=True):
        chance = rng.random(6)  # all drawn for each plot, so that one choice does not move the next
        plan = _plan(chance, width, depth, storeys, is_flat, scaffold_share if near else None)
        plans.append(None if chance[5] < gap_share else plan)
    return [
        (material, joined([placed(body, [(*centre, base)], heading)]))
        for plan, centre in zip(plans, centres, strict=True)
        if plan is not None
        for material, body in building(plan)
    ]


def _plan(
    chance: Floats, width: float, depth: float, storeys: int, is_flat: bool, scaffold_share: float | None
) -> Building:
    """A building by six random numbers; without a share of scaffolds it is too far away to have windows."""
    n_storeys = max(1, storeys + int(chance[0] < 0.25) - int(chance[0] > 0.8))
    flat = is_flat != (chance[1] < 0.15)
    walls = FLAT_WALLS if flat else PITCHED_WALLS
    return Building(
        width=width,
        depth=depth * (0.9 + 0.1 * chance[3]),
        height=n_storeys * STOREY + 1.2 * chance[4],
        roof="flat" if flat else ("gable" if chance[1] < 0.8 else "hip"),
        pitch=0.55 + 0.35 * chance[3],
        walls=walls[int(chance[2] * len(walls))],
        roofing="tiles" if chance[0] < 0.6 else "slate",
        bay=0.0 if scaffold_share is None else 2.6 + 0.6 * chance[3],
        has_chimney=bool(not flat and chance[4] < 0.5),
        has_scaffold=bool(scaffold_share is not None and chance[5] > 1 - scaffold_share),
    )
