"""What moves: where it is at a time, and that it leaves the route free."""

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.worlds.moving import (
    CAR_HEIGHT,
    CAR_LENGTH,
    CAR_WIDTH,
    PERSON_HEIGHT,
    cars,
    clear_of,
    moving_along,
    people,
)
from insectnav.worlds.shapes import joined

LINES = np.array([[(0.0, 0.0), (0.0, 100.0)], [(50.0, 20.0), (-50.0, 20.0)]])


def at(time_s: float, n: int = 40) -> tuple[np.ndarray, np.ndarray]:
    return moving_along(np.random.default_rng(1), LINES, n, (2.0, 4.0), time_s)


def test_things_move_along_their_lines_at_their_speeds():
    before, heading = at(10.0)
    after, _ = at(10.5)
    course = np.stack([np.sin(heading), np.cos(heading)], axis=-1)
    way = ((after - before) * course).sum(axis=-1)
    moved = way > -50.0  # the others have begun their line again
    assert moved.sum() > 30
    np.testing.assert_allclose((after - before)[moved], way[moved, None] * course[moved], atol=1e-9)
    assert ((way[moved] >= 1.0) & (way[moved] <= 2.0)).all()
    np.testing.assert_allclose(np.minimum(np.abs(before[:, 0]), np.abs(before[:, 1] - 20.0)), 0.0, atol=1e-9)


def test_no_lines_hold_nothing():
    positions, headings = moving_along(np.random.default_rng(1), np.zeros((0, 2, 2)), 5, (1.0, 2.0), 0.0)
    assert positions.shape == (0, 2)
    assert headings.shape == (0,)


def test_route_is_kept_free_by_hand():
    """A car that looks north at the origin is 4.4 m by 1.8 m, and 0.25 m are left about it."""
    places = np.array([(0.0, 2.4), (0.0, 2.5), (1.1, 0.0), (1.2, 0.0)])
    north = [clear_of(place[None], np.zeros((1, 2)), np.zeros(1), CAR_LENGTH, CAR_WIDTH)[0] for place in places]
    east = [
        clear_of(place[None], np.zeros((1, 2)), np.full(1, np.pi / 2), CAR_LENGTH, CAR_WIDTH)[0] for place in places
    ]
    assert north == [False, True, False, True]
    assert east == [True, True, False, False]


def test_sizes():
    place, heading = np.zeros((1, 3)), np.zeros(1)
    car = joined([body for _, body in cars(np.random.default_rng(0), place, heading)])
    np.testing.assert_allclose(np.ptp(car[..., :2], axis=(0, 1)), [CAR_WIDTH, CAR_LENGTH])
    assert car[..., 2].max() == pytest.approx(CAR_HEIGHT)
    assert car[..., 2].min() == 0.0  # wheels
    crowd = joined([body for _, body in people(np.random.default_rng(0), np.zeros((99, 3)), np.zeros(99))])
    assert 1.5 < crowd[..., 2].max() <= PERSON_HEIGHT
    assert crowd[..., 2].min() == 0.0


def test_bad_input():
    with pytest.raises(InputError, match="time_s"):
        at(np.nan)
    with pytest.raises(InputError, match="number of moving things"):
        at(0.0, n=-1)
