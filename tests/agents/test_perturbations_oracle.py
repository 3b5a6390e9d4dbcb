"""Perturbed trials against a second, plain NumPy implementation, noise-free, to rounding."""

import numpy as np
import pytest
import xarray

import oracle
import perturbation_oracle
from insectnav.agents import (
    Circle,
    CompassShift,
    Displace,
    FilterSpeed,
    FreezeMemory,
    ScaleSpeed,
    SetMemory,
    TurnBody,
    Wall,
    random_routes,
    run_trials,
)
from insectnav.central_complex import VARIANTS, circuit_params

N_OUT, N_HOME, N_TRIALS = 90, 110, 5
N_STEPS = N_OUT + N_HOME
MEMORY = np.random.default_rng(4).uniform(0.3, 0.7, 16)
OFFSETS = np.zeros(N_STEPS)
CIRCLE = (np.array([4.0, 6.0]), np.array([4.0, 6.0]), 5.0)
WALL = (np.array([-40.0, 6.0]), np.array([25.0, 14.0]), 0.0)

CASES = {  # name: (perturbations, what the oracle is told)
    "none": ([], {}),
    "faster": ([ScaleSpeed(factor=1.5), ScaleSpeed(factor=1.2)], {"speed": 1.8}),
    "filter": ([FilterSpeed(n_steps=7)], {"filter_steps": 7}),
    "filter of 2017": ([FilterSpeed(n_steps=7, form="code-2017")], {"filter_steps": 7}),
    "compass ahead": ([CompassShift(shift=0.4)], {"shift": 0.4, "shift_legs": ("home",)}),
    "compass behind, out": ([CompassShift(shift=-0.6, leg="out")], {"shift": -0.6, "shift_legs": ("out",)}),
    "compass, both": ([CompassShift(shift=0.3, leg="both")], {"shift": 0.3, "shift_legs": ("out", "home")}),
    "body": ([TurnBody(offset=0.7)], {"body": OFFSETS + 0.7}),
    "body, both": ([TurnBody(offset=-0.5, leg="both")], {"body": OFFSETS - 0.5, "is_body_turned_home": True}),
    "body, home": (
        [TurnBody(offset=0.4, leg="home")],
        {"body": np.where(np.arange(N_STEPS) < N_OUT, 0.0, 0.4), "is_body_turned_home": True},
    ),
    "carried": (
        [Displace(step=30, by=(3, -4)), Displace(step=95, to=(10, 20)), Displace(step=140, by=(-5, 1))],
        {"carried": {30: (1, np.array([3, -4])), 95: (0, np.array([10, 20])), 140: (1, np.array([-5, 1]))}},
    ),
    "memory replaced": ([SetMemory(memory=MEMORY, step=N_OUT)], {"memories": {N_OUT: ("replace", MEMORY)}}),
    "memory added": (
        [SetMemory(memory=MEMORY, step=50, mode="add"), SetMemory(memory=MEMORY, step=130, mode="subtract")],
        {"memories": {50: ("add", MEMORY), 130: ("subtract", MEMORY)}},
    ),
    "memory frozen": ([FreezeMemory(first_step=60, end_step=120)], {"frozen": range(60, 120)}),
    "circle": ([Circle(centre=(4, 6), radius=5)], {"obstacles": [CIRCLE]}),
    "wall": ([Wall(start=(-40, 6), end=(25, 14))], {"obstacles": [WALL]}),
    "all": (
        [
            Wall(start=(-40, 6), end=(25, 14)),
            Circle(centre=(4, 6), radius=5),
            FilterSpeed(n_steps=3),
            CompassShift(shift=0.2, leg="both"),
            ScaleSpeed(factor=1.1),
            TurnBody(offset=0.2, leg="both"),
            Displace(step=100, by=(2, 3)),
            SetMemory(memory=MEMORY, step=70, mode="add"),
            FreezeMemory(first_step=150, end_step=160),
        ],
        {
            "obstacles": [WALL, CIRCLE],
            "filter_steps": 3,
            "shift": 0.2,
            "shift_legs": ("out", "home"),
            "speed": 1.1,
            "body": OFFSETS + 0.2,
            "is_body_turned_home": True,
            "carried": {100: (1, np.array([2, 3]))},
            "memories": {70: ("add", MEMORY)},
            "frozen": range(150, 160),
        },
    ),
}


@pytest.fixture(scope="module")
def routes() -> xarray.Dataset:
    return random_routes(N_TRIALS, N_OUT, seed=11)


def compare(ours: xarray.Dataset, theirs: dict[str, np.ndarray], trial: int) -> None:
    """All steps of a trial in both implementations."""
    turned = np.exp(1j * (ours.heading.values[trial] - theirs["heading"]))
    np.testing.assert_allclose(turned, 1.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.position[trial], theirs["position"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.memory[trial], theirs["memory"], rtol=0, atol=1e-9)
    closest = np.linalg.norm(theirs["position"][N_OUT - 1 :], axis=-1).min()
    assert float(ours.closest_distance[trial]) == pytest.approx(closest, abs=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_plain_oracle_is_disturbed_alike(name: str, routes: xarray.Dataset) -> None:
    perturbations, told = CASES[name]
    ours = run_trials(
        routes, n_inbound=N_HOME, noise=0.0, dtype="float64", record=["memory"], perturbations=perturbations
    )
    plain = run_trials(routes, n_inbound=N_HOME, noise=0.0, dtype="float64", record=["memory"])
    assert (name == "none") == plain.equals(ours.assign_attrs(plain.attrs))
    for trial in range(N_TRIALS):
        heading, velocity = routes.heading.values[trial], routes.velocity.values[trial]
        compare(ours, perturbation_oracle.run_trial(heading, velocity, N_HOME, oracle.THESIS, **told), trial)


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_variant_is_disturbed_alike(variant: str, routes: xarray.Dataset) -> None:
    perturbations, told = CASES["all"]
    few = routes.isel(trial=[1, 3])
    ours = run_trials(
        few,
        circuit_params(variant),
        n_inbound=N_HOME,
        noise=0.0,
        dtype="float64",
        record=["memory"],
        perturbations=perturbations,
    )
    for trial in range(2):
        heading, velocity = few.heading.values[trial], few.velocity.values[trial]
        params = oracle.variant_params(variant)
        compare(ours, perturbation_oracle.run_trial(heading, velocity, N_HOME, params, **told), trial)


def test_random_body_offsets_are_felt_as_given(routes: xarray.Dataset) -> None:
    body = [TurnBody(redraw_every=12)]
    ours = run_trials(routes, n_inbound=N_HOME, noise=0.0, dtype="float64", record=["memory"], perturbations=body)
    for trial in range(N_TRIALS):
        heading, velocity = routes.heading.values[trial], routes.velocity.values[trial]
        drawn = np.append(ours.heading.values[trial, :N_OUT] - heading, np.zeros(N_HOME))
        theirs = perturbation_oracle.run_trial(heading, velocity, N_HOME, oracle.THESIS, body=drawn)
        compare(ours, theirs, trial)


@pytest.mark.parametrize("seed", range(4))
def test_maze_is_walked_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    routes = random_routes(6, 60, seed=seed)
    obstacles, told = [], []
    for _ in range(3):
        start, end = rng.uniform(-8, 8, (2, 2))
        obstacles.append(Wall(start=start, end=end))
        told.append((start, end, 0.0))
    for _ in range(2):
        centre, radius = rng.uniform(-8, 8, 2), rng.uniform(0.5, 3)
        obstacles.append(Circle(centre=centre, radius=radius))
        told.append((centre, centre, radius))
    ours = run_trials(routes, n_inbound=N_HOME, noise=0.0, dtype="float64", record=["memory"], perturbations=obstacles)
    for trial in range(6):
        heading, velocity = routes.heading.values[trial], routes.velocity.values[trial]
        theirs = perturbation_oracle.run_trial(heading, velocity, N_HOME, oracle.THESIS, obstacles=told)
        np.testing.assert_allclose(ours.position[trial], theirs["position"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(ours.memory[trial], theirs["memory"], rtol=0, atol=1e-9)
