"""Plants: how many, how large, and how they change with the season."""

import numpy as np
import pytest
from scipy.stats import kstest, poisson

from insectnav.checks import InputError
from insectnav.worlds.plants import (
    BROADLEAF,
    CONIFER,
    LASTING_BLADES,
    SPARSE,
    TOWN,
    conifers,
    hedge,
    on_ground,
    scattered,
    scattered_in_box,
    shrubs,
    trees,
    tussocks,
)
from insectnav.worlds.shapes import joined, triangle_areas

FEET = np.array([(3.0, -2.0, 0.0), (0.0, 0.0, 1.0), (-8.0, 5.0, 0.5)])
HEIGHTS = np.array([1.0, 6.0, 12.0])


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def body(
    kind: str, foliage: float = 1.0, foot: np.ndarray = FEET, height: np.ndarray = HEIGHTS
) -> dict[str, np.ndarray]:
    """Triangles by material."""
    if kind == "tussock":
        return {"straw": tussocks(rng(), foot, height, foliage=foliage)}
    if kind == "conifer":
        return dict(conifers(rng(), foot, height))
    if kind == "shrub":
        return dict(shrubs(rng(), foot, height, foliage=foliage))
    forms = {"tree": BROADLEAF, "sparse tree": SPARSE, "town tree": TOWN}
    return dict(trees(rng(), foot, height, forms[kind], foliage=foliage))


KINDS = {  # reach to the sides and least height, as shares of the height
    "tussock": 1.0,
    "shrub": 0.6,
    "tree": BROADLEAF.reach,
    "sparse tree": SPARSE.reach,
    "town tree": TOWN.reach,
    "conifer": 1.1 * CONIFER.crown_radius,
}


def test_numbers_of_plants_are_poisson():
    """Each count is within a two-sided 1e-6 interval, and so is the sum over 200 seeds."""
    mean = 0.3 * np.pi * (9.0**2 - 4.0**2)
    counts = [len(scattered(rng(seed), 0.3, 4.0, 9.0)) for seed in range(200)]
    low, high = poisson.interval(1 - 1e-6 / 200, mean)
    assert low <= min(counts)
    assert max(counts) <= high
    assert np.isin(sum(counts), np.arange(*poisson.interval(1 - 1e-6, 200 * mean)))
    assert np.var(counts, ddof=1) == pytest.approx(mean, rel=5 * np.sqrt(2 / 199))


def test_plants_stand_anywhere_in_the_ring_alike():
    place = scattered(rng(1), 20.0, 4.0, 9.0)
    radius, angle = np.hypot(*place.T), np.arctan2(*place.T)
    assert kstest((radius**2 - 16.0) / 65.0, "uniform").pvalue > 1e-4
    assert kstest((angle + np.pi) / (2 * np.pi), "uniform").pvalue > 1e-4


def test_plants_in_a_box():
    place = scattered_in_box(rng(2), 2.0, (-3.0, 10.0), (7.0, 40.0))
    assert abs(len(place) - 600) < 5 * np.sqrt(600)
    assert kstest((place[:, 0] + 3.0) / 10.0, "uniform").pvalue > 1e-4
    assert kstest((place[:, 1] - 10.0) / 30.0, "uniform").pvalue > 1e-4


@pytest.mark.parametrize("kind", KINDS)
def test_each_plant_keeps_within_its_height_and_reach(kind: str):
    for foot, height in zip(FEET, HEIGHTS, strict=True):
        triangles = joined(list(body(kind, 1.0, foot[None], np.array([height])).values()))
        assert np.isfinite(triangles).all()
        assert triangles[..., 2].min() >= foot[2] - 1e-9
        assert 0.5 * height < triangles[..., 2].max() - foot[2] <= height + 1e-9
        assert np.hypot(*(triangles[..., :2] - foot[:2]).T).max() <= KINDS[kind] * height + 1e-9
        assert triangle_areas(triangles).min() > 0.0


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "conifer"])
def test_leaf_area_grows_with_the_season_and_wood_stays(kind: str):
    foliage = np.linspace(0.0, 1.0, 6)
    bodies = [body(kind, share) for share in foliage]
    areas = [triangle_areas(parts["straw" if kind == "tussock" else "leaves"]).sum() for parts in bodies]
    assert (np.diff(areas) > 0).all()
    if kind == "tussock":
        n = len(bodies[-1]["straw"])
        assert abs(len(bodies[0]["straw"]) - LASTING_BLADES * n) < 5 * 3 * np.sqrt(n / 3) / 2
    else:
        assert areas[0] == 0.0
        for parts in bodies:
            np.testing.assert_array_equal(parts["bark"], bodies[0]["bark"])


def test_summer_leaves_include_those_of_spring():
    def leaves(foliage: float) -> set[bytes]:
        cards = dict(trees(rng(), FEET, HEIGHTS, SPARSE, foliage=foliage))["leaves"]
        return {card.tobytes() for card in cards[: -20 * SPARSE.n_clumps * len(FEET)]}  # clumps come last, and grow

    assert leaves(0.4) < leaves(1.0)


def test_hedge_is_as_long_and_high_as_said():
    parts = dict(hedge(rng(), np.array([0.0, 0.0]), np.array([6.0, 8.0]), 1.5))
    along = parts["leaves"][..., :2] @ np.array([0.6, 0.8])
    assert parts["leaves"][..., 2].max() == pytest.approx(1.5, abs=0.1)
    assert parts["leaves"][..., 2].min() >= 0.0
    assert along.min() == pytest.approx(0.0, abs=0.1)
    assert along.max() == pytest.approx(10.0, abs=0.1)


def test_heights_of_the_ground_are_added():
    np.testing.assert_array_equal(on_ground(np.array([(1.0, 2.0)]), np.array([3.0])), [(1.0, 2.0, 3.0)])


def test_bad_input():
    with pytest.raises(InputError, match="density"):
        scattered(rng(), -1.0, 0.0, 1.0)
    with pytest.raises(InputError, match="inner radius"):
        scattered(rng(), 1.0, 2.0, 1.0)
    with pytest.raises(InputError, match="foliage"):
        tussocks(rng(), FEET, HEIGHTS, foliage=50.0)
    with pytest.raises(InputError, match="n_blades"):
        tussocks(rng(), FEET, HEIGHTS, n_blades=0)
