"""Obstacles on the way home: never entered nor crossed, followed to their end, and felt by nobody who is elsewhere."""

import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.agents import Circle, Displace, ScaleSpeed, Wall, random_routes, run_trials

N_OUT, N_HOME = 60, 140
DTYPES = ("float32", "float64")
coordinates = st.tuples(st.floats(-12.0, 12.0), st.floats(-12.0, 12.0))


def fly(routes: object, *perturbations, **options) -> np.ndarray:
    """Positions from the turning point on."""
    options = {"n_inbound": N_HOME, "noise": 0.1, "seed": 2} | options
    n_outbound = routes.sizes["step"] if isinstance(routes, xarray.Dataset) else np.shape(routes[0])[1]
    return run_trials(routes, perturbations=perturbations, **options).position.values[:, n_outbound - 1 :].astype(float)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def n_crossings(path: np.ndarray, start: np.ndarray, end: np.ndarray) -> int:
    """How many moves have the wall's ends on different sides of them, and their own on different sides of the wall."""
    before, move, along = path[:, :-1], np.diff(path, axis=1), end - start
    sides = cross(along, before - start) * cross(along, before + move - start)
    ends = cross(move, start - before) * cross(move, end - before)
    return int(np.sum((sides < 0.0) & (ends < 0.0)))


def nearest_to(path: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Smallest distance of each move, ends and all between, to a point."""
    before, move = path[:, :-1], np.diff(path, axis=1)
    share = np.sum((centre - before) * move, axis=-1) / np.maximum(np.sum(move**2, axis=-1), 1e-300)
    return np.linalg.norm(before + np.clip(share, 0.0, 1.0)[..., None] * move - centre, axis=-1)


ROUTES = random_routes(16, N_OUT, seed=4)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    walls=st.lists(st.tuples(coordinates, coordinates).filter(lambda ends: ends[0] != ends[1]), max_size=4),
    circles=st.lists(st.tuples(coordinates, st.floats(0.1, 5.0)), max_size=3),
    factor=st.sampled_from([0.5, 1.0, 3.0]),
    dtype=st.sampled_from(DTYPES),
    seed=st.integers(0, 1000),
)
def test_no_wall_is_crossed_and_no_circle_entered(walls: list, circles: list, factor: float, dtype: str, seed: int):
    obstacles = [Wall(start=start, end=end) for start, end in walls]
    obstacles += [Circle(centre=centre, radius=radius) for centre, radius in circles]
    path = fly(ROUTES, ScaleSpeed(factor=factor), *obstacles, dtype=dtype, seed=seed)
    assert np.isfinite(path).all()
    is_outside = np.ones(16, bool)  # who starts inside is put on the surface, through whatever is there
    for centre, radius in circles:
        is_outside &= np.linalg.norm(path[:, 0] - centre, axis=-1) > radius + 0.02
    path = path[is_outside]
    for start, end in np.reshape(walls, (-1, 2, 2)):
        assert n_crossings(path, start, end) == 0
    for centre, radius in circles:
        assert (nearest_to(path, np.array(centre)) > radius).all()


@pytest.mark.parametrize("dtype", DTYPES)
def test_thin_wall_stops_the_fastest(dtype: str) -> None:
    heading = np.zeros((40, 50)) + np.linspace(-0.3, 0.3, 40)[:, None]
    velocity = 8.0 * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    ahead = velocity[:, :25].sum(axis=1)[:, 1].max() * 2.0 + 3.0  # a few steps beyond where the farthest turns round
    wall = np.array([-400.0, ahead]), np.array([400.0, ahead])
    free, path = (
        fly((heading, velocity), dtype=dtype),
        fly((heading, velocity), Wall(start=wall[0], end=wall[1]), dtype=dtype),
    )
    assert n_crossings(free, *wall) > 30  # at nearly seven steps a move
    assert n_crossings(path, *wall) == 0
    assert path[..., 1].max() < ahead


@pytest.mark.parametrize("dtype", DTYPES)
def test_agent_within_a_circle_is_put_on_its_surface(dtype: str) -> None:
    turning_points = fly(ROUTES, n_inbound=0)[:, 0]
    middle = turning_points.mean(axis=0)
    radius = np.linalg.norm(turning_points - middle, axis=-1).max() + 1.0
    path = fly(ROUTES, Circle(centre=middle, radius=radius), dtype=dtype)
    assert (np.linalg.norm(path[:, 0] - middle, axis=-1) < radius).all()
    assert (nearest_to(path[:, 1:], middle) > radius).all()
    onto = Displace(step=N_OUT + 20, to=(50.0, 50.0)), Circle(centre=(50.0, 50.0), radius=3.0)  # the very middle
    path = fly(ROUTES, *onto, dtype=dtype)
    distance = np.linalg.norm(path[:, 21:] - 50.0, axis=-1)
    assert (distance > 3.0).all()
    assert (distance[:, 0] < 4.0).all()


def test_agent_on_a_wall_leaves_it_the_way_it_looks() -> None:
    wall = Wall(start=(-20.0, 50.0), end=(20.0, 50.0))
    onto = Displace(step=N_OUT, to=(0.0, 50.0))
    out = run_trials(ROUTES, n_inbound=40, seed=2, record=["motor"], perturbations=[wall, onto])
    above = out.position.values[:, N_OUT:, 1] > 50.0
    looks_up = np.cos(out.heading.values[:, N_OUT - 1] + out.motor.values[:, N_OUT]) > 0.0  # after its first turn
    assert 0 < looks_up.sum() < 16
    np.testing.assert_array_equal(above[:, 0], looks_up)


@pytest.mark.parametrize("dtype", DTYPES)
def test_deflected_agent_goes_along_the_surface_and_looks_there(dtype: str) -> None:
    out = run_trials(
        random_routes(200, 300, seed=8),
        n_inbound=300,
        seed=1,
        dtype=dtype,
        record=["motor"],
        perturbations=[Circle(centre=(0.0, 0.0), radius=12.0)],  # home is within
    )
    out = out.isel(trial=np.linalg.norm(out.position.values[:, 299], axis=-1) > 12.1)  # the others are put out first
    position, heading = out.position.values[:, 299:].astype(float), out.heading.values[:, 299:].astype(float)
    steered = heading[:, :-1] + out.motor.values[:, 300:]
    is_deflected = np.abs(np.exp(1j * steered) - np.exp(1j * heading[:, 1:])) > 1e-3
    move = np.diff(position, axis=1)
    speed = np.linalg.norm(move, axis=-1)
    ahead = np.stack([np.sin(heading[:, 1:]), np.cos(heading[:, 1:])], axis=-1)
    tolerance = 1e-4 if dtype == "float32" else 1e-9
    assert is_deflected.sum() > 400
    along = np.sum(move * ahead, axis=-1)
    np.testing.assert_allclose(along[is_deflected], speed[is_deflected], rtol=0, atol=tolerance)
    radial = np.sum(move * position[:, :-1], axis=-1)
    np.testing.assert_allclose(radial[is_deflected], 0.0, atol=100.0 * tolerance)
    # The speed it had: 0.85 (v + 0.1 u), u where it steered, on the side nearer to that motion where it comes anew.
    thrust = np.stack([np.sin(steered), np.cos(steered)], axis=-1)
    wanted = 0.85 * (move[:, :-1] + 0.1 * thrust[:, 1:])
    again = is_deflected[:, 1:]
    np.testing.assert_allclose(speed[:, 1:][again], np.linalg.norm(wanted, axis=-1)[again], rtol=0, atol=tolerance)
    is_new = again & (np.linalg.norm(position[:, 1:-1], axis=-1) > 12.0 + 0.01 + 0.1) & ~is_deflected[:, :-1]
    sides = np.sum(move[:, 1:] * wanted, axis=-1)[is_new]
    assert np.mean(sides > 0.0) > 0.9


def test_edge_is_followed_to_its_end_on_one_side() -> None:
    # Straight out to the north, a long wall between it and home: unbroken passage along the wall, all to one side.
    heading = np.full((64, 100), 0.05)
    velocity = 0.5 * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    for noise in (0.0, 0.02):
        path = fly((heading, velocity), Wall(start=(-40.0, 25.0), end=(40.0, 25.0)), n_inbound=400, noise=noise)
        is_at_wall = (np.abs(path[:, :-1, 1] - 25.0) < 0.6) & (np.abs(path[:, :-1, 0]) < 40.0)
        sideways = np.diff(path[..., 0], axis=1)
        for trial in range(64):
            along = sideways[trial, is_at_wall[trial]][1:41]
            assert len(along) == 40
            assert (along > 0.0).all() or (along < 0.0).all()
        assert (np.abs(path[..., 0]).max(axis=1) > 40.0).all()
        assert (path[:, -1, 1] < 25.0).all()


def test_home_is_reached_round_obstacles() -> None:
    routes = random_routes(200, 500, seed=1)
    plain = run_trials(routes, n_inbound=1500, seed=1, workers=2)
    for obstacles in (
        [Circle(centre=(0.0, 25.0), radius=15.0), Circle(centre=(25.0, 0.0), radius=8.0)],
        [Wall(start=(-20.0, 12.0), end=(20.0, 12.0)), Wall(start=(-20.0, 12.0), end=(-20.0, -20.0))],
    ):
        path = run_trials(routes, n_inbound=1500, seed=1, perturbations=obstacles, workers=2)
        n_detours = int((path.position != plain.position).any(["step", "xy"]).sum())
        assert n_detours > 100
        assert float(path.closest_distance.median()) < 5.0
        assert float(path.closest_distance.quantile(0.75)) < 10.0


def test_order_of_obstacles_does_not_matter() -> None:
    obstacles = [
        Wall(start=(-15.0, 3.0), end=(5.0, 6.0)),
        Circle(centre=(6.0, -2.0), radius=3.0),
        Wall(start=(2.0, -9.0), end=(9.0, 4.0)),
    ]
    np.testing.assert_array_equal(fly(ROUTES, *obstacles), fly(ROUTES, *obstacles[::-1]))
    ends_swapped = [Wall(start=obstacles[0].end, end=obstacles[0].start), *obstacles[1:]]
    np.testing.assert_allclose(
        fly(ROUTES, *ends_swapped, noise=0.0, dtype="float64"),
        fly(ROUTES, *obstacles, noise=0.0, dtype="float64"),
        rtol=0,
        atol=1e-7,
    )


def test_way_out_knows_no_obstacles() -> None:
    obstacles = [Wall(start=(-30.0, 2.0), end=(30.0, 2.0)), Circle(centre=(0.0, 0.0), radius=4.0)]
    plain, out = (run_trials(ROUTES, n_inbound=5, perturbations=p) for p in ([], obstacles))
    np.testing.assert_array_equal(out.position[:, :N_OUT], plain.position[:, :N_OUT])
    np.testing.assert_array_equal(out.memory_at_turn, plain.memory_at_turn)


def test_agent_shut_in_stays_in() -> None:
    # A triangle around the turning point, walls ending in each other: nowhere to go, and no corner lets it slip.
    turning_point = fly(ROUTES, n_inbound=0)[3, 0]
    corners = turning_point + np.array([[0.0, 6.0], [5.5, -3.0], [-5.0, -3.5]])
    walls = [Wall(start=corners[i], end=corners[(i + 1) % 3]) for i in range(3)]
    path = fly(ROUTES.isel(trial=[3] * 8), *walls, n_inbound=3000, noise=0.2, dtype="float32")[:8]
    for i in range(3):
        side = cross(corners[(i + 1) % 3] - corners[i], path - corners[i])
        assert (side < 0.0).all()
    assert np.linalg.norm(np.ptp(path, axis=1), axis=-1).min() > 3.0  # it does walk about
