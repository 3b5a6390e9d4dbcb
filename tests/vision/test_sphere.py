"""Directions, rotations and grids on the sphere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

from insectnav.checks import InputError
from insectnav.vision.sphere import (
    GRIDS,
    SphereGrid,
    azimuth_elevation,
    check_directions,
    directions,
    equirectangular,
    fibonacci,
    gauss_legendre,
    great_circle_angle,
    rotation_matrix,
    thesis,
    to_eye,
    to_world,
)

RIGHT, AHEAD, UP = np.eye(3)
angles = st.floats(-np.pi, np.pi, exclude_max=True)
elevations = st.floats(-np.pi / 2 + 1e-6, np.pi / 2 - 1e-6)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "vector"),
    [(0, 0, AHEAD), (90, 0, RIGHT), (-90, 0, -RIGHT), (-180, 0, -AHEAD), (0, 90, UP), (0, -90, -UP)],
)
def test_axes(azimuth: float, elevation: float, vector: np.ndarray):
    np.testing.assert_allclose(directions(np.deg2rad(azimuth), np.deg2rad(elevation)), vector, atol=1e-15)
    np.testing.assert_allclose(np.rad2deg(azimuth_elevation(vector)), [azimuth, elevation], atol=1e-12)


@given(angles, elevations)
def test_angles_come_back(azimuth: float, elevation: float):
    vector = directions(azimuth, elevation)
    np.testing.assert_allclose(np.linalg.norm(vector), 1.0, rtol=1e-15)
    back = azimuth_elevation(vector)
    assert abs(np.remainder(back[0] - azimuth + np.pi, 2 * np.pi) - np.pi) < 1e-9
    assert abs(back[1] - elevation) < 1e-9


@given(angles, angles, angles)
def test_rotation_agrees_with_scipy(heading: float, pitch: float, roll: float):
    expected = Rotation.from_euler("ZXY", [-heading, pitch, roll]).as_matrix()
    np.testing.assert_allclose(rotation_matrix(heading, pitch, roll), expected, atol=1e-14)


@pytest.mark.parametrize(
    ("turn", "eye", "world"),
    [
        ((90, 0, 0), AHEAD, RIGHT),  # a heading of 90° looks east
        ((90, 0, 0), RIGHT, -AHEAD),
        ((0, 90, 0), AHEAD, UP),  # nose up
        ((0, 90, 0), UP, -AHEAD),
        ((0, 0, 90), RIGHT, -UP),  # right side down
        ((0, 0, 90), UP, RIGHT),
        ((90, 90, 0), AHEAD, UP),
        ((90, 90, 0), RIGHT, -AHEAD),
        ((90, 0, 90), RIGHT, -UP),
    ],
)
def test_sense_and_order_of_turns(turn: tuple[float, float, float], eye: np.ndarray, world: np.ndarray):
    rotation = rotation_matrix(*np.deg2rad(turn))
    np.testing.assert_allclose(to_world(eye, rotation), world, atol=1e-15)
    np.testing.assert_allclose(to_eye(world, rotation), eye, atol=1e-15)


def test_batches_of_rotations_and_vectors_are_the_loop():
    rng = np.random.default_rng(3)
    turns = rng.uniform(-np.pi, np.pi, (4, 3))
    vectors = fibonacci(7).directions
    rotations = rotation_matrix(*turns.T)
    together = to_world(vectors, rotations[:, None])
    assert together.shape == (4, 7, 3)
    for one, turn in zip(together, turns, strict=True):
        np.testing.assert_array_equal(one, to_world(vectors, rotation_matrix(*turn)))
    np.testing.assert_allclose(to_eye(together, rotations[:, None]), np.broadcast_to(vectors, (4, 7, 3)), atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 1.0, np.pi / 2, 3.0, np.pi - 1e-12, np.pi])
def test_great_circle_angle_is_exact_near_zero_and_half_a_turn(angle: float):
    first, second = directions(0.4, 0.0), directions(0.4 + angle - (2 * np.pi if angle > 2.7 else 0.0), 0.0)
    assert abs(great_circle_angle(first, second) - angle) < 2e-15


def harmonics(grid: SphereGrid, degree: int) -> np.ndarray:
    """Spherical harmonics by SciPy, (harmonic, n), of order 0 and more."""
    azimuth, elevation = azimuth_elevation(grid.directions)
    return np.stack([sph_harm_y(n, m, np.pi / 2 - elevation, azimuth) for n in range(degree + 1) for m in range(n + 1)])


@pytest.mark.parametrize("name", GRIDS)
def test_weights_add_up_to_the_solid_angle(name: str):
    grid = GRIDS[name]()
    assert grid.n_directions == len(grid.directions) == len(grid.weights)
    expected = 2 * np.pi if name == "thesis" else 4 * np.pi
    assert grid.solid_angle == pytest.approx(expected, rel=1e-13)
    np.testing.assert_allclose(np.linalg.norm(grid.directions, axis=-1), 1.0, rtol=1e-14)
    with pytest.raises(ValueError, match="read-only"):
        grid.weights[0] = 0.0


def test_gauss_legendre_integrates_harmonics_below_twice_its_rings_exactly():
    grid = gauss_legendre(12)
    integrals = grid.integral(harmonics(grid, 23))
    np.testing.assert_allclose(integrals[0], np.sqrt(4 * np.pi), rtol=1e-14)
    assert np.abs(integrals[1:]).max() < 1e-13
    # Degree 24 is one too many: the rings are at the zeros of its Legendre polynomial's lower half.
    assert np.abs(grid.integral(harmonics(grid, 24))[1:]).max() > 0.1


def test_harmonics_are_orthonormal_on_gauss_legendre():
    grid = gauss_legendre(8)
    basis = harmonics(grid, 7)
    product = (basis * grid.weights) @ basis.conj().T
    np.testing.assert_allclose(product, np.eye(len(basis)), atol=1e-13)


@pytest.mark.parametrize(("degree", "bound"), [(20, 0.001), (40, 0.003)])
def test_fibonacci_mean_of_a_harmonic_is_as_good_as_said(degree: int, bound: float):
    grid = fibonacci(2000)
    mean = np.abs(grid.integral(harmonics(grid, degree)))[1:] / (4 * np.pi)
    root_mean_square = 1 / np.sqrt(4 * np.pi)  # of an orthonormal harmonic
    assert bound / 3 < mean.max() / root_mean_square < bound


@pytest.mark.parametrize("grid", [fibonacci(2000), thesis("sphere")])
def test_fibonacci_neighbours_are_as_far_apart_as_published(grid: SphereGrid):
    nearest = cKDTree(grid.directions).query(grid.directions, 2)[0][:, 1]
    assert nearest.min() * np.sqrt(2000) == pytest.approx(3.09, abs=0.01)
    assert nearest.max() < 1.35 * nearest.min()


def test_thesis_grid_integrates_polynomials_over_the_hemisphere():
    grid = thesis()
    assert grid.n_directions == 2000
    assert grid.directions[:, 2].min() > 0
    x, y, z = grid.directions.T
    third = 2 * np.pi / 3  # of x², y², z² over half the sphere
    for values, expected in ((x, 0.0), (y, 0.0), (z, np.pi), (x * x, third), (y * y, third), (z * z, third)):
        assert grid.integral(values) == pytest.approx(expected, abs=2e-3)
    for values in (x * y, y * z, x * z):
        assert abs(grid.integral(values)) < 2e-3


def test_equirectangular_lies_as_a_rendered_panorama():
    grid = equirectangular(1.0, (-15.0, 90.0))
    assert grid.shape == (105, 360)
    azimuth, elevation = (np.rad2deg(angle).reshape(grid.shape) for angle in azimuth_elevation(grid.directions))
    np.testing.assert_allclose(azimuth, np.broadcast_to(np.arange(360) - 179.5, grid.shape), atol=1e-10)
    np.testing.assert_allclose(elevation, np.broadcast_to(89.5 - np.arange(105)[:, None], grid.shape), atol=1e-12)
    assert (grid.directions.reshape(105, 360, 3)[:, :180, 0] < 0).all()  # the left half is left of the heading
    assert grid.solid_angle == pytest.approx(2 * np.pi * (1 + np.sin(np.deg2rad(15))), rel=1e-13)
    assert grid.spacing == pytest.approx(np.deg2rad(1.0))


def test_equirectangular_weights_are_the_solid_angles_of_the_pixels():
    grid = equirectangular(30.0)
    edges = np.sin(np.deg2rad(np.arange(90, -91, -30)))
    expected = -np.diff(edges) * np.pi / 6
    np.testing.assert_allclose(grid.weights.reshape(6, 12), np.broadcast_to(expected[:, None], (6, 12)), rtol=1e-14)


def test_equirectangular_integrates_better_when_finer():
    errors = [abs(equirectangular(step).integral(equirectangular(step).directions[:, 2] ** 2) * 3 / 4 / np.pi - 1)
              for step in (6.0, 3.0, 1.5)]  # fmt: skip
    np.testing.assert_allclose(errors[:2], 4 * np.array(errors[1:]), rtol=0.01)  # of second order


def test_spacing_of_an_even_grid_is_that_of_hexagons():
    # A hexagonal lattice of spacing d has cells of √3/2 d².
    grid = fibonacci(5000)
    assert np.sqrt(3) / 2 * grid.spacing**2 == pytest.approx(4 * np.pi / 5000)
    np.testing.assert_array_equal(grid.acceptance, np.full(5000, grid.spacing))


def test_integral_of_a_batch():
    grid = gauss_legendre(4)
    values = np.random.default_rng(0).normal(size=(2, 3, grid.n_directions))
    together = grid.integral(values)
    assert together.shape == (2, 3)
    np.testing.assert_allclose(together[1, 2], (values[1, 2] * grid.weights).sum())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: check_directions("view", [1.0, 2.0, 2.0]), "view has a vector of length 3, expected unit vectors"),
        (lambda: check_directions("view", np.eye(2)), r"view has shape \(2, 2\), expected \(..., 3\)"),
        (lambda: check_directions("view", [np.nan, 0, 1]), "view is nan at index 0"),
        (lambda: directions(90.0, 0.0), "azimuth is 90, expected radians"),
        (lambda: directions(0.0, 45.0), "elevation is 45.*degrees"),
        (lambda: azimuth_elevation([[1.0, 2.0]]), r"directions has shape \(1, 2\)"),
        (lambda: rotation_matrix(0.0, 30.0), "pitch is 30, expected radians"),
        (lambda: equirectangular(0.7), "resolution_deg is 0.7, expected to divide 180° of elevation"),
        (lambda: equirectangular(7.5, (-90, 0)), None),
        (lambda: equirectangular(1.0, (30, -30)), "elevation_deg goes from 30 to -30, expected the lower limit first"),
        (lambda: equirectangular(1.0, (-90, 100)), "elevation_deg reaches 100, expected -90 to 90 degrees"),
        (lambda: equirectangular(0.0), "resolution_deg is 0"),
        (lambda: gauss_legendre(0), "n_rings is 0"),
        (lambda: fibonacci(2.5), "n_points is 2.5, expected a whole number"),
        (lambda: thesis("hemispere"), "points_on 'hemispere' is unknown.*did you mean hemisphere"),
        (lambda: fibonacci(10).integral(np.ones(9)), r"values has shape \(9,\)"),
        (lambda: SphereGrid(name="a", directions=np.eye(3), weights=np.ones(2)), "weights has shape"),
        (lambda: SphereGrid(name="a", directions=np.eye(3), weights=np.ones(3), shape=(2, 2)), "shape is"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message: str | None):
    if message is None:
        assert call().shape == (12, 48)
        return
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
