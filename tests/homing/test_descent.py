import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.homing import OUTCOMES, descend, interpolate_surface

GOAL, MINIMUM, EDGE, UNFINISHED = range(4)
RNG = np.random.default_rng(0)
ROUGH = RNG.random((9, 12))  # 0.5 m apart: 5.5 m × 4 m


def grid(n_rows, n_columns, spacing):
    y, x = np.mgrid[:n_rows, :n_columns] * spacing
    return x, y


# The bicubic surface.


def test_it_goes_through_the_samples():
    x, y = grid(9, 12, 0.5)
    values, _ = interpolate_surface(ROUGH, 0.5, np.stack([x, y], axis=-1))
    assert_allclose(values, ROUGH, rtol=0, atol=1e-14)


def test_surfaces_of_second_degree_are_exact_up_to_the_edge():
    x, y = grid(6, 7, 0.4)

    def surface(x, y):
        return 1 + 2 * x - y + 0.7 * x**2 - 1.3 * x * y + 0.2 * y**2 + 0.5 * x**2 * y - 0.1 * x**2 * y**2

    places = np.vstack([RNG.uniform(0, [2.4, 2.0], (200, 2)), [[0, 0], [2.4, 2.0], [0, 2.0]]])
    px, py = places.T
    values, gradient = interpolate_surface(surface(x, y), 0.4, places)
    assert_allclose(values, surface(px, py), rtol=0, atol=1e-13)
    slope_x = 2 + 1.4 * px - 1.3 * py + px * py - 0.2 * px * py**2
    slope_y = -1 - 1.3 * px + 0.4 * py + 0.5 * px**2 - 0.2 * px**2 * py
    assert_allclose(gradient, np.stack([slope_x, slope_y], axis=-1), rtol=0, atol=1e-12)


def test_weights_between_samples_are_those_of_catmull_and_rom():
    # Halfway along a row: −1/16, 9/16, 9/16, −1/16 of the four neighbours (Keys 1981, with a = −1/2).
    values, _ = interpolate_surface(ROUGH, 0.5, [[2.25, 1.5]])
    expected = (-ROUGH[3, 3] + 9 * ROUGH[3, 4] + 9 * ROUGH[3, 5] - ROUGH[3, 6]) / 16
    assert_allclose(values, expected, rtol=1e-14)


def test_error_falls_with_the_third_power_of_the_spacing():
    def error(n):
        x, y = grid(n + 1, n + 1, 2 / n)
        places = np.random.default_rng(1).uniform(0, 2, (2000, 2))
        values, _ = interpolate_surface(np.sin(2 * x) * np.cos(3 * y), 2 / n, places)
        return np.abs(values - np.sin(2 * places[:, 0]) * np.cos(3 * places[:, 1])).max()

    assert error(20) / error(40) > 6.0


@settings(max_examples=60, deadline=None)
@given(x=st.floats(0.01, 5.49), y=st.floats(0.01, 3.99))
def test_gradient_is_that_of_finite_differences(x, y):
    small = 1e-6
    around = np.array([[x + small, y], [x - small, y], [x, y + small], [x, y - small]])
    values, _ = interpolate_surface(ROUGH, 0.5, around)
    _, gradient = interpolate_surface(ROUGH, 0.5, [x, y])
    # the second derivative jumps between cells: an error of the step times it, which is below 100 here
    assert_allclose(gradient, [values[0] - values[1], values[2] - values[3]] / np.float64(2 * small), atol=1e-4)


def test_gradient_is_continuous_from_cell_to_cell():
    y = RNG.uniform(0, 4, 50)
    for x in (0.5, 2.5, 5.0):
        sides = [interpolate_surface(ROUGH, 0.5, np.stack([np.full(50, x + d), y], axis=-1)) for d in (-1e-10, 1e-10)]
        assert_allclose(sides[0][1], sides[1][1], rtol=0, atol=1e-7)


def test_a_turned_surface_has_turned_gradients():
    places = RNG.uniform(0, [5.5, 4.0], (40, 2))
    values, gradient = interpolate_surface(ROUGH, 0.5, places)
    swapped, swapped_gradient = interpolate_surface(ROUGH.T, 0.5, places[:, ::-1])
    assert_allclose(swapped, values, rtol=0, atol=1e-14)
    assert_allclose(swapped_gradient, gradient[:, ::-1], rtol=0, atol=1e-13)


# Descent.


def test_from_everywhere_to_the_bottom_of_a_bowl():
    x, y = grid(21, 31, 0.1)
    starts = RNG.uniform(0, [3, 2], (100, 2))
    found = descend((x - 1.23) ** 2 + 2 * (y - 0.77) ** 2, 0.1, starts)
    assert_array_equal(found.outcome, MINIMUM)
    # steps of spacing / 4 / 1024 fail within a step of it, seen along the flatter axis
    assert np.linalg.norm(found.position - [1.23, 0.77], axis=-1).max() < 1e-3


def test_it_takes_the_straight_way_down_a_cone():
    # Each full step is a quarter of the spacing; the way ends at the first within the radius.
    x, y = grid(41, 41, 0.1)
    starts = np.array([[3.9, 2.0], [2.0, 0.3], [2.0, 2.15]])
    found = descend((x - 2) ** 2 + (y - 2) ** 2, 0.1, starts, [2.0, 2.0], 0.2)
    assert_array_equal(found.outcome, GOAL)
    assert_array_equal(found.n_steps, [68, 60, 0])
    assert_allclose(found.position, [[2.2, 2.0], [2.0, 1.8], [2.0, 2.15]], rtol=0, atol=1e-12)


def test_it_follows_the_flow_lines_of_an_elliptic_bowl():
    # dy/dx = 3 y / x down x² + 3 y²: y = c x³. Steps of h leave the line by about h times its curvature.
    x, y = grid(101, 101, 0.04)
    surface = (x - 2) ** 2 + 3 * (y - 2) ** 2
    for n_steps in (20, 45):
        found = descend(surface, 0.04, [[3.8, 3.5]], step=0.004, max_steps=n_steps * 10)
        across, up = found.position[0] - 2
        assert found.outcome[0] == UNFINISHED
        assert found.n_steps[0] == n_steps * 10
        assert_allclose(up, 1.5 * (across / 1.8) ** 3, rtol=0, atol=0.02)


def test_it_ends_at_the_edge_of_a_slope():
    x, y = grid(11, 11, 0.1)
    found = descend(x + 0.5 * y, 0.1, [[0.8, 0.9]])
    assert found.outcome == EDGE
    assert_allclose(found.position, [[0.0, 0.5]], rtol=0, atol=1e-4)  # down the gradient (1, 0.5)
    assert OUTCOMES[EDGE] == "edge"


def test_it_stays_on_a_plain():
    found = descend(np.ones((5, 6)), 0.1, [[0.2, 0.3]], [0.0, 0.0], 0.1)
    assert (found.outcome, found.n_steps) == (MINIMUM, 0)
    assert_array_equal(found.position, [[0.2, 0.3]])


def test_no_step_goes_up():
    x, y = np.moveaxis(RNG.uniform(0, [5.5, 4.0], (200, 2)), -1, 0)
    starts = np.stack([x, y], axis=-1)
    found = descend(ROUGH, 0.5, starts)
    before, after = interpolate_surface(ROUGH, 0.5, starts)[0], interpolate_surface(ROUGH, 0.5, found.position)[0]
    assert np.all(after <= before)
    assert set(found.outcome) == {MINIMUM, EDGE}
    _, slope = interpolate_surface(ROUGH, 0.5, found.position[found.outcome == MINIMUM])
    # A minimum to a thousandth of a step: what slope is left is at most that times the second derivative.
    assert np.linalg.norm(slope, axis=-1).max() < 100 * 0.125 / 1024


def test_batch_is_loop_and_threads_change_no_bit():
    starts = RNG.uniform(0, [5.5, 4.0], (50, 60, 2))
    one, two = (descend(ROUGH, 0.5, starts, [2.0, 2.0], 0.3, workers=n) for n in (1, 2))
    for a, b in zip(one, two, strict=True):
        assert_array_equal(a, b)
    alone = descend(ROUGH, 0.5, starts[31, 7], [2.0, 2.0], 0.3)
    assert_array_equal(alone.position, one.position[31, 7])
    assert (alone.outcome, alone.n_steps) == (one.outcome[31, 7], one.n_steps[31, 7])


def test_units_do_not_matter():
    starts = RNG.uniform(0, [5.5, 4.0], (100, 2))
    metres = descend(ROUGH, 0.5, starts, [2.0, 2.0], 0.3)
    feet = descend(ROUGH * 7, 0.25, starts / 2, [1.0, 1.0], 0.15)
    assert_array_equal(feet.outcome, metres.outcome)
    assert_allclose(2 * feet.position, metres.position, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: descend(ROUGH[:2], 0.5, [[0, 0]]), r"surface has shape \(2, 12\), expected at least 3 × 3 samples"),
        (lambda: descend(ROUGH[0], 0.5, [[0, 0]]), r"surface has shape \(12,\), expected \(rows, columns\)"),
        (lambda: descend(np.where(ROUGH > 0.9, np.nan, ROUGH), 0.5, [[0, 0]]), "surface is nan at index"),
        (lambda: descend(ROUGH, 0.0, [[0, 0]]), "spacing is 0, expected 1e-09 to 1e.09 m"),
        (lambda: descend(ROUGH, [0.5, 0.5], [[0, 0]]), r"spacing has shape \(2,\)"),
        (lambda: descend(ROUGH, 0.5, [[5.6, 0]]), r"x of starts reaches 5\.6, expected 0 to 5\.5 m: outside the grid"),
        (lambda: descend(ROUGH, 0.5, [[0, -1]]), r"y of starts reaches -1, expected 0 to 4 m: outside the grid"),
        (lambda: descend(ROUGH, 0.5, [[0, 0]], [9, 0], 1), "x of goal is 9, expected"),
        (lambda: descend(ROUGH, 0.5, [[0, 0]], [[1, 0]], 1), r"goal has shape \(1, 2\), expected \(2,\)"),
        (lambda: descend(ROUGH, 0.5, [[0, 0]], [1, 0], -1), "success_radius is -1, expected at least 0 m"),
        (lambda: descend(ROUGH, 0.5, [[0, 0]], step=9), "step is 9, expected 0.0005 to 5 m: steps are of the order of"),
        (lambda: descend(ROUGH, 0.5, [[0, 0]], max_steps=0), "max_steps is 0, expected a whole number of at least 1"),
        (lambda: descend(ROUGH, 0.5, [[0, 0]], workers=0), "workers is 0, expected a whole number of at least 1"),
        (lambda: interpolate_surface(ROUGH, 0.5, [0, 0, 0]), r"positions has shape \(3,\), expected \(\.\.\., 2\)"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
