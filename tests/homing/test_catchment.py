import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.homing import catchment_area, cell_centres, descend


def grid(n_rows, n_columns, spacing):
    y, x = np.mgrid[:n_rows, :n_columns] * spacing
    return x, y


def smooth_noise(n_rows, n_columns, seed):
    """Waves of several lengths and all directions."""
    rng = np.random.default_rng(seed)
    x, y = grid(n_rows, n_columns, 1.0)
    waves = np.zeros(x.shape)
    for _ in range(40):
        kx, ky = rng.normal(0, 0.25, 2)
        waves += np.cos(kx * x + ky * y + rng.uniform(0, 2 * np.pi))
    return waves


def test_a_bowl_leads_home_from_everywhere():
    x, y = grid(41, 61, 0.1)
    area, is_inside = catchment_area((x - 2) ** 2 + (y - 3) ** 2, 0.1, [2, 3], 0.15)
    assert_allclose(area, 6.0 * 4.0, rtol=1e-12)
    assert is_inside.shape == (40, 60)
    assert is_inside.all()


def test_a_bowl_elsewhere_leads_home_only_through_the_goal():
    # Ways to the middle pass a goal that lies aside from it only from within the shadow of its radius.
    x, y = grid(101, 101, 0.1)
    surface, radius, distance = (x - 5) ** 2 + (y - 5) ** 2, 0.5, 2.0
    area, _ = catchment_area(surface, 0.1, [5 + distance, 5], radius, starts_per_cell=2)
    # Beyond the goal: the sector between the tangents, clipped by the box, less what lies before the points of contact;
    # by fine sampling of the straight ways.
    fine = cell_centres((2001, 2001), 0.005) - 5
    ahead = np.linalg.norm(fine - [distance, 0], axis=-1) <= radius
    along, aside = fine[..., 0], np.abs(fine[..., 1])
    half_angle = np.arcsin(radius / distance)
    contact = np.sqrt(distance**2 - radius**2)
    behind = (np.arctan2(aside, along) <= half_angle) & (np.hypot(along, aside) >= contact)
    expected = (ahead | behind).sum() * 0.005**2
    border = 2 * np.hypot(5, 5 * np.tan(half_angle)) + 2 * np.pi * radius
    assert abs(area - expected) < border * 0.05  # one start across the border


@pytest.mark.parametrize("spacing", [0.2, 0.1])
def test_two_wells_share_the_box_along_the_ridge(spacing):
    # Bottoms at (2, 3) and (7, 6), the second higher by 2. The ridge, where both paraboloids are equal, is the straight
    # line 2 p · (b − a) = |b|² − |a|² + 2; ways to either bottom are straight.
    n = round(10 / spacing) + 1
    x, y = grid(n, n, spacing)
    a, b = np.array([2.0, 3.0]), np.array([7.0, 6.0])
    surface = np.minimum((x - a[0]) ** 2 + (y - a[1]) ** 2, (x - b[0]) ** 2 + (y - b[1]) ** 2 + 2)
    areas = [catchment_area(surface, spacing, bottom, 1.5 * spacing) for bottom in (a, b)]
    is_first = 2 * cell_centres((n, n), spacing) @ (b - a) < b @ b - a @ a + 2
    # 10 x + 6 y = 74 crosses y = 0 at x = 7.4 and y = 10 at x = 1.4: a trapezium on its left
    exact = (7.4 + 1.4) / 2 * 10
    ridge = np.hypot(6, 10)
    assert abs(areas[0].area - exact) < 2 * spacing * ridge
    assert abs(areas[1].area - (100 - exact)) < 2 * spacing * ridge
    assert not (areas[0].is_inside & areas[1].is_inside).any()
    n_wrong = np.count_nonzero(areas[0].is_inside != is_first)
    assert n_wrong * spacing**2 < 2 * spacing * ridge


def test_a_symmetric_double_well_is_halved_exactly():
    x, y = grid(51, 51, 0.1)
    surface = ((x - 2.5) ** 2 - 1) ** 2 + (y - 2.5) ** 2
    area, is_inside = catchment_area(surface, 0.1, [1.5, 2.5], 0.15)
    assert_allclose(area, 12.5, rtol=1e-12)
    assert is_inside[:, :25].all()
    assert not is_inside[:, 25:].any()


def test_refining_the_grid_converges():
    # Wells along a line, with the ridge at x = 1 between bottoms at 0.3 and 2.4: slope (x − 0.3)(x − 1)(x − 2.4).
    def error(spacing):
        n = round(3 / spacing) + 1
        x, y = grid(n, n, spacing)
        surface = x**4 / 4 - 3.7 * x**3 / 3 + 3.42 * x**2 / 2 - 0.72 * x + (y - 1.5) ** 2
        found = catchment_area(surface, spacing, [0.3, 1.5], 0.1, step=0.02)
        return abs(found.area - 3.0)

    for spacing in (0.1, 0.05, 0.025):
        assert error(spacing) <= 3 * spacing  # a column of starts


def test_more_starts_find_the_same_area_more_finely():
    x, y = grid(31, 31, 0.1)
    surface = np.minimum((x - 1) ** 2 + (y - 1) ** 2, (x - 2.2) ** 2 + (y - 2) ** 2)
    # equidistant from both bottoms: 2.4 x + 2 y = 6.84 in a box of 3 m
    exact = np.trapezoid(np.clip((6.84 - 2 * np.linspace(0, 3, 3001)) / 2.4, 0, 3), dx=0.001)
    for starts_per_cell in (1, 4):
        found = catchment_area(surface, 0.1, [1, 1], 0.15, starts_per_cell=starts_per_cell)
        assert found.is_inside.shape == (30 * starts_per_cell, 30 * starts_per_cell)
        assert abs(found.area - exact) < 2 * 0.1 * np.hypot(3, 3)
    assert_allclose(found.area, found.is_inside.sum() * 0.025**2)


@pytest.mark.parametrize("quarters", [1, 2, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_turned_world_has_a_turned_catchment(quarters, seed):
    surface = smooth_noise(41, 41, seed)
    i, j = np.unravel_index(surface[8:33, 8:33].argmin(), (25, 25))
    mark = np.zeros(surface.shape, bool)
    mark[i + 8, j + 8] = True
    area, is_inside = catchment_area(surface, 1.0, [j + 8, i + 8], 1.5)
    assert 5 < area < 1600
    for change in (lambda a: np.rot90(a, quarters), lambda a: np.rot90(a, quarters)[:, ::-1]):
        (turned_i,), (turned_j,) = np.nonzero(change(mark))
        turned = catchment_area(change(surface), 1.0, [turned_j, turned_i], 1.5)
        # rounding may send a start on the very ridge to the other side: at most one in a thousand
        assert np.count_nonzero(turned.is_inside != change(is_inside)) <= 1


def test_a_well_in_a_rough_plain_reaches_as_far_as_its_rim():
    # A bowl of radius 2 in a plain of noise whose waves are 0.3 m long: ways on the plain end in its own hollows.
    x, y = grid(101, 101, 0.05)
    distance = np.hypot(x - 2.5, y - 2.5)
    noise = 0.05 * np.sin(21 * x) * np.sin(21 * y)
    surface = np.minimum((distance / 1.5) ** 2, 1.0) + np.where(distance > 1.5, noise, 0.0)
    area, is_inside = catchment_area(surface, 0.05, [2.5, 2.5], 0.075)
    start = cell_centres((101, 101), 0.05)
    from_middle = np.hypot(start[..., 0] - 2.5, start[..., 1] - 2.5)
    assert is_inside[from_middle < 1.4].all()
    assert not is_inside[from_middle > 1.5 + 0.35].any()  # a hollow and a cell beyond the rim
    assert np.pi * 1.4**2 < area < np.pi * 1.85**2


def test_white_noise_leads_nowhere():
    surface = np.random.default_rng(0).random((101, 101))
    surface[50, 50] = -1.0
    area, _ = catchment_area(surface, 0.1, [5.0, 5.0], 0.15)
    # a hollow of white noise is a few cells across: 0.1 m² are ten
    assert 0.01 <= area < 0.3


def test_batch_is_loop():
    surface = smooth_noise(21, 31, 3)
    goal = [12.0, 9.0]
    _, is_inside = catchment_area(surface, 1.0, goal, 2.0, workers=1)
    starts = cell_centres((21, 31), 1.0)
    for index in np.ndindex(20, 30):
        assert (descend(surface, 1.0, starts[index], goal, 2.0).outcome == 0) == is_inside[index]


def test_starts_lie_in_the_middle_of_equal_squares():
    assert_array_equal(cell_centres((2, 3), 2.0), [[[1, 1], [3, 1]]])
    fine = cell_centres((3, 4), 1.0, 2)
    assert fine.shape == (4, 6, 2)
    assert_allclose(fine[0, :3, 0], [0.25, 0.75, 1.25])
    assert_allclose(fine.mean(axis=(0, 1)), [1.5, 1.0])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"surface": np.zeros(5)}, r"surface has shape \(5,\), expected \(rows, columns\)"),
        ({"surface": np.full((5, 5), np.nan)}, "surface is nan at index 0, 0"),
        ({"spacing": -0.1}, "spacing is -0.1, expected"),
        ({"goal": [0.9, 0.1]}, "x of goal is 0.9, expected"),
        (
            {"success_radius": 0.01},
            "success_radius is 0.01, expected at least 0.025 m: shorter than a step, which could",
        ),
        ({"starts_per_cell": 0}, "starts_per_cell is 0, expected a whole number of at least 1"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(change, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        catchment_area(
            **({"surface": np.zeros((5, 5)), "spacing": 0.1, "goal": [0.2, 0.2], "success_radius": 0.1} | change)
        )
