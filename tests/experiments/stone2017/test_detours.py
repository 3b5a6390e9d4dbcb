"""Obstacles and carrying, in Fig. 5a and in the detours: geometry, laws of displacement, verdicts."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.agents.obstacles import Circle
from insectnav.central_complex import THESIS
from insectnav.experiments.stone2017_path_integration import detours, fig_5a
from insectnav.experiments.stone2017_path_integration.obstructed_trips import (
    FARTHEST_SOUTH,
    OBSTACLES,
    trips_from_south,
    turned,
    way_walked,
)
from insectnav.experiments.stone2017_path_integration.trips import N_STEPS, example_trip
from small_runs import same_bits, simulated, verdicts_of

N = 12


@pytest.fixture(scope="module")
def carried():
    cells = [replace(cell, n_trials=N) for cell in detours.grid("quick")]
    return simulated(detours, cells)


@pytest.fixture(scope="module")
def example():
    return simulated(fig_5a, [replace(cell, n_trials=N) for cell in fig_5a.grid("quick")])


def test_small_runs_give_all_verdicts(carried, example):
    verdicts_of(detours, "stone2017-detours", carried)
    verdicts_of(fig_5a, "stone2017-fig-5a", example)


def test_same_seed_same_bits():
    assert same_bits(detours, detours.Cell(condition="ring", preset="thesis", noise=0.1, n_trials=3))
    assert same_bits(fig_5a, fig_5a.Cell(obstacles="both", preset="thesis", n_trials=3))


# Routes turned about the nest.


def test_all_trips_end_due_south():
    arrays, by = trips_from_south(N, THESIS, noise=0.0, seed=3, n_inbound=0)
    last = arrays.position[:, -1]
    np.testing.assert_allclose(last[:, 0], 0.0, atol=2e-3)
    assert (last[:, 1] < 0.0).all()
    np.testing.assert_allclose(arrays.heading[:, 0], by, atol=1e-6)  # a route starts with heading 0


def test_turning_goes_clockwise():
    north, east = np.array([[[0.0, 2.0]]]), [[[2.0, 0.0]]]
    np.testing.assert_allclose(turned(north, np.array([np.pi / 2])), east, atol=1e-15)


def test_way_walked_is_the_sum_of_the_steps():
    path = np.array([[[0.0, 0.0], [3.0, 4.0], [3.0, 0.0], [9.0, 0.0]]] * 2)
    np.testing.assert_array_equal(way_walked(path, np.array([2, -1])), [9.0, np.nan])


# Obstacles.


def test_obstacles_lie_between_the_nest_and_the_farthest_south():
    for obstacles in OBSTACLES.values():
        for obstacle in obstacles:
            if isinstance(obstacle, Circle):
                assert np.hypot(*obstacle.centre) - obstacle.radius > 20.0
                assert obstacle.centre[1] - obstacle.radius >= -FARTHEST_SOUTH
            else:
                assert -FARTHEST_SOUTH <= obstacle.start[1] == obstacle.end[1] < -20.0


def test_drawn_paths_go_round(carried, example):
    for results, name in ((carried, "circle"), (carried, "ring")):
        for index in results.where(condition=name):
            for obstacle in OBSTACLES[name]:
                distance = np.linalg.norm(results["path"][index] - np.array(obstacle.centre), axis=-1)
                assert np.nanmin(distance) >= obstacle.radius - 1e-3
    for index in carried.where(condition="wall"):
        (wall,) = OBSTACLES["wall"]
        for path in carried["path"][index]:
            x, y = path[~np.isnan(path[:, 0])].T
            crosses = np.flatnonzero(np.diff(np.sign(y - wall.start[1])) != 0)
            assert all(not wall.start[0] <= x[step] <= wall.end[0] for step in crosses)


def test_obstacles_of_the_example_stand_in_its_way(example):
    """The straight way home of the trip that is drawn meets the disc, whichever way the trip went."""
    heading, velocity = example_trip(0)
    circle, _ = fig_5a.around(OBSTACLES["both"], velocity)
    turning_point = velocity.astype(float).sum(axis=1)[0]
    home = -turning_point / np.linalg.norm(turning_point)
    to_centre = np.array(circle.centre) - turning_point
    assert 0.0 < to_centre @ home < np.linalg.norm(turning_point)
    assert abs(to_centre[0] * home[1] - to_centre[1] * home[0]) < circle.radius
    for index in example.where():
        np.testing.assert_allclose(example["path"][index][N_STEPS - 1], turning_point, rtol=1e-4)
    assert heading.shape == (1, N_STEPS)


def test_obstacles_cost_way_but_not_the_nest(example):
    free, obstructed = (example.only(preset="thesis", obstacles=name) for name in ("none", "both"))
    beyond = example["is_beyond"][free]
    np.testing.assert_array_equal(beyond, example["is_beyond"][obstructed])
    assert beyond.sum() >= 3
    walked = example["walked"]
    assert (walked[free][beyond] >= example["start_distance"][free][beyond] - 20.0).all()  # no way is shorter
    assert np.median(walked[obstructed][beyond]) > np.median(walked[free][beyond])


# Carried.


@pytest.mark.parametrize("condition", ["carried at the start", "carried underway"])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_carrying_displaces_the_rest_of_the_path_and_nothing_else(carried, condition: str, noise: float):
    """The memory knows nothing of it: the path goes on as if not carried, so many steps to the east."""
    free, moved = (carried.only(condition=c, preset="thesis", noise=noise) for c in ("none", condition))
    np.testing.assert_allclose(
        carried["closest_to_fictive"][moved], carried["closest_distance"][free], atol=0.05
    )  # the turning point itself is not carried
    np.testing.assert_allclose(carried["centre"][moved] - carried["centre"][free], [detours.CARRIED] * N, atol=0.05)
    first = 0 if condition == "carried at the start" else detours.UNDERWAY
    apart = carried["path"][moved] - carried["path"][free]
    np.testing.assert_allclose(apart[:, : first + 1], 0.0, atol=1e-3)
    np.testing.assert_allclose(
        apart[:, first + 1 :], np.broadcast_to(detours.CARRIED, apart[:, first + 1 :].shape), atol=0.05
    )
