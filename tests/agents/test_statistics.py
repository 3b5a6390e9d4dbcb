"""How well a thousand bees come home: the published numbers, with bounds from the sizes of both samples."""

import numpy as np
import pytest
import xarray
from scipy import stats

from insectnav.agents import random_routes, run_trials
from insectnav.central_complex import CODE_2017, THESIS, CircuitParams

N_TRIALS, N_STEPS = 1000, 1500
N_PUBLISHED = 300  # trials behind each published distance
RISK = 1e-4  # on either side, for samples of one distribution


@pytest.fixture(scope="module")
def routes() -> xarray.Dataset:
    return random_routes(N_TRIALS, N_STEPS, seed=0, dtype="float32")


def share_left(path: np.ndarray) -> np.ndarray:
    """Smallest distance to the nest so far over that at the start, where each path (trial, step, 2) is as long."""
    distance = np.linalg.norm(path, axis=-1)
    closest = np.minimum.accumulate(distance, axis=1)
    walked = np.cumsum(np.linalg.norm(np.diff(path, axis=1), axis=-1), axis=1)
    walked = np.concatenate([np.zeros((len(path), 1)), walked], axis=1)
    straight = distance[:, 0]
    assert np.all(walked[:, -1] > straight)
    left = [np.interp(*trial) for trial in zip(straight, walked, closest, strict=True)]
    return np.array(left) / straight


def test_share_left_of_known_paths() -> None:
    detour = np.array([[0, 10], [10, 10], [10, 0], [0, 0], [-10, 0.0]])
    beeline = np.array([[0, 10], [0, 6], [0, 2], [0, -2], [0, -6.0]])
    wrong_way = np.array([[0, 10], [0, 12], [0, 20], [0, 21], [0, 22.0]])
    paths = np.stack([detour, beeline, wrong_way])
    np.testing.assert_allclose(share_left(paths), [1, 0.2, 1], rtol=0, atol=1e-15)


@pytest.mark.parametrize(("noise", "median"), [(0.0, 4.8), (0.1, 1.7), (0.2, 3.5), (0.3, 18.0), (0.4, 88.0)])
def test_median_closest_distance_is_the_published_one(noise: float, median: float, routes: xarray.Dataset) -> None:
    """Distribution-free: where a median of 300 falls in our distribution is a Beta(150.5, 150.5) number, and so how
    many of our trials come closer is a beta-binomial one."""
    closest = run_trials(routes, CODE_2017, noise=noise, seed=1).closest_distance.values
    rounding = 0.05 if median < 10 else 0.5
    n_closer = stats.betabinom(N_TRIALS, (N_PUBLISHED + 1) / 2, (N_PUBLISHED + 1) / 2)
    assert np.count_nonzero(closest < median + rounding) >= n_closer.ppf(RISK)
    assert np.count_nonzero(closest < median - rounding) <= n_closer.ppf(1 - RISK)


@pytest.mark.parametrize(("noise", "mean"), [(0.1, 2.4), (0.4, 103.0)])
def test_mean_closest_distance_is_the_published_one(noise: float, mean: float, routes: xarray.Dataset) -> None:
    closest = run_trials(routes, CODE_2017, noise=noise, seed=2).closest_distance.values.astype("float64")
    standard_error = closest.std() * np.sqrt(1 / N_TRIALS + 1 / N_PUBLISHED)
    assert closest.mean() == pytest.approx(mean, abs=3.5 * standard_error + (0.05 if mean < 10 else 0.5))


@pytest.mark.parametrize(("params", "published"), [(THESIS, 1.150), (CODE_2017, 1.168)], ids=["thesis", "code-2017"])
def test_tortuosity_is_the_published_one(params: CircuitParams, published: float) -> None:
    n_chunks = 5
    left = []
    for seed in range(n_chunks):
        made = random_routes(N_TRIALS, N_STEPS, seed=seed, dtype="float32")
        position = run_trials(made, params, noise=0.1, seed=seed, n_inbound=1200).position.values
        left.append(share_left(position[:, N_STEPS - 1 :].astype("float64")))
    left = np.concatenate(left)
    tortuosity = 1 / (1 - left.mean())
    standard_error = left.std() / np.sqrt(left.size) * tortuosity**2
    assert standard_error < 0.004
    assert tortuosity == pytest.approx(published, abs=0.01)
