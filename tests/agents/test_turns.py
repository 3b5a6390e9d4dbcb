"""Von Mises turns: the series against numerical integration, and the turns of whole routes against the distribution."""

from functools import partial

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy import stats
from scipy.integrate import quad

from insectnav.agents import RouteParams, random_routes
from insectnav.agents.route_kernel import von_mises_turn
from insectnav.agents.turns import LARGEST_NORMAL, MAX_TERMS, von_mises_series
from insectnav.lanes import LANES
from insectnav.lanes.compiled import kernel
from insectnav.lanes.vector import address, load, store

CONCENTRATIONS = [1e-3, 0.5, 2.5, 7.0, 10.0, 30.0, 100.0, 1e4, 1e8]
TOLERANCE = 1e-9  # [rad] as promised
LARGEST_DRAWN = np.sqrt(64 * np.log(2))  # Box and Muller's normal number from the smallest uniform one, 2^-32


@kernel
def compiled_turns(normals, series, turns):
    """Turns of normal numbers, both (n, LANES), as routes take them."""
    for row in range(normals.shape[0]):
        store(address(turns), row, von_mises_turn(load(address(normals), row), address(series), series.shape[0]))


def turn_of_normal(z: np.ndarray, concentration: float) -> np.ndarray:
    """The turn as the series gives it."""
    return z * chebyshev.chebval(2 * (z / LARGEST_NORMAL) ** 2 - 1, von_mises_series(concentration))


def density_above(turn: float, concentration: float, last: float) -> float:
    """∫ exp(κ (cos t − cos turn)) dt from ``turn`` to ``last``."""
    width = min(last - turn, 12 / np.sqrt(concentration), 60 / (concentration * max(np.sin(turn), 1e-9)))
    return quad(
        lambda t: np.exp(-2 * concentration * np.sin((t + turn) / 2) * np.sin((t - turn) / 2)),
        turn,
        turn + width,
        epsabs=0,
        epsrel=1e-11,
        limit=200,
    )[0]


def error_of_quantile(z: float, turn: float, concentration: float) -> float:
    """How far [rad] a turn is from the one with the upper-tail probability of the normal number ``z`` > 0."""
    at_turn = np.exp(-2 * concentration * np.sin(turn / 2) ** 2)
    whole = 2 * density_above(0.0, concentration, np.pi)
    excess = at_turn * density_above(turn, concentration, np.pi) - whole * stats.norm.sf(z)
    return excess / at_turn


def distribution_function(angles: np.ndarray, concentration: float) -> np.ndarray:
    grid = np.linspace(-np.pi, np.pi, 200_001)
    density = np.exp(concentration * (np.cos(grid) - 1))
    below = np.concatenate([[0], np.cumsum(density[1:] + density[:-1])])
    return np.interp(angles, grid, below / below[-1])


@pytest.mark.parametrize("concentration", CONCENTRATIONS)
def test_turn_has_the_quantile_of_the_normal_number(concentration: float) -> None:
    for z in (1e-3, 0.1, 0.5, 1.0, 1.7, 2.5, 3.3, 4.0, 5.0, 6.0, 6.6):
        turn = float(turn_of_normal(np.array(z), concentration))
        assert abs(error_of_quantile(z, turn, concentration)) < TOLERANCE, z


@pytest.mark.parametrize("concentration", CONCENTRATIONS)
def test_turn_grows_with_the_normal_number_and_stays_on_the_circle(concentration: float) -> None:
    z = np.linspace(0, LARGEST_DRAWN, 2001)
    turn = turn_of_normal(z, concentration)
    np.testing.assert_array_equal(turn_of_normal(-z, concentration), -turn)
    assert turn[0] == 0
    assert np.all(np.diff(turn) > -TOLERANCE)
    assert turn[-1] < np.pi + TOLERANCE


@pytest.mark.parametrize("concentration", CONCENTRATIONS)
def test_compiled_series_is_the_same(concentration: float) -> None:
    z = np.linspace(-LARGEST_DRAWN, LARGEST_DRAWN, 40 * LANES).reshape(-1, LANES)
    turns = np.empty_like(z)
    compiled_turns(z, von_mises_series(concentration).copy(), turns)
    np.testing.assert_allclose(turns, turn_of_normal(z, concentration), rtol=0, atol=1e-13)


@pytest.mark.parametrize("concentration", [1e6, 1e8])
def test_high_concentration_is_a_normal_distribution(concentration: float) -> None:
    z = np.linspace(0.1, 6, 50)
    # √κ t = z + (z³ + 3 z) / (24 κ) + …, since 2 κ sin²(t / 2) = κ t² / 2 − κ t⁴ / 24 + …
    expected = (z + (z**3 + 3 * z) / (24 * concentration)) / np.sqrt(concentration)
    np.testing.assert_allclose(turn_of_normal(z, concentration), expected, rtol=0, atol=1e-9)


def test_low_concentration_is_a_uniform_distribution() -> None:
    z = np.linspace(-3, 3, 61)
    expected = np.pi * (2 * stats.norm.cdf(z) - 1)
    np.testing.assert_allclose(turn_of_normal(z, 1e-3), expected, rtol=0, atol=2.1e-3)  # 2 κ sin t at most


@pytest.mark.parametrize("concentration", CONCENTRATIONS)
def test_series_is_complete_and_cannot_be_changed(concentration: float) -> None:
    series = von_mises_series(concentration)
    assert 1 <= len(series) < MAX_TERMS
    with pytest.raises(ValueError, match="read-only"):
        series[0] = 1.0


def test_published_concentration_takes_few_terms() -> None:
    assert len(von_mises_series(100.0)) <= 8  # each is two operations in every step of every route


@pytest.mark.parametrize("concentration", [0.5, 5.0, 100.0])
def test_turns_of_routes_follow_the_distribution(concentration: float) -> None:
    params = RouteParams(turn_concentration=concentration, turn_persistence=0.0)
    heading = random_routes(200, 200, params, seed=4).heading.values
    steps = np.diff(heading, axis=1)
    turns = (steps - 2 * np.pi * np.round(steps / (2 * np.pi))).ravel()
    test = stats.kstest(turns, partial(distribution_function, concentration=concentration))
    assert test.pvalue > 1e-4
    # Mean resultant length I1/I0 of the distribution, by integration; the variance of a cosine is at most 1.
    grid = np.linspace(-np.pi, np.pi, 20_001)[:-1]
    density = np.exp(concentration * (np.cos(grid) - 1))
    moments = [np.sum(density * np.cos(grid) ** power) / np.sum(density) for power in (1, 2)]
    spread = np.sqrt((moments[1] - moments[0] ** 2) / turns.size)
    assert abs(np.cos(turns).mean() - moments[0]) < 5 * spread
    assert abs(np.sin(turns).mean()) < 5 * np.sqrt((1 - moments[1]) / turns.size)
