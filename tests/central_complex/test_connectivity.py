"""The synapses of the circuit: the published matrices, their rules, and what changing them does."""

from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest

from insectnav.central_complex import THESIS, CircuitParams, Connectivity, Rates, Senses, initial_state, step
from insectnav.checks import InputError

SHAPES = {
    "tl_to_cl1": (16, 16),
    "cl1_to_tb1": (8, 16),
    "tb1_to_tb1": (8, 8),
    "tn_to_cpu4": (16, 2),
    "tb1_to_cpu4": (16, 8),
    "cpu4_to_pontine": (16, 16),
    "cpu4_to_cpu1": (16, 16),
    "pontine_to_cpu1": (16, 16),
    "tb1_to_cpu1": (16, 8),
    "cpu1_to_motor": (2, 16),
}
TARGET = {name: name.split("_to_")[1] for name in SHAPES} | {"tn_to_cpu4": "memory", "tb1_to_cpu4": "memory"}
# Published matrix: ours, and which of the CPU1 cells stand in its rows (or columns, for the motor).
EVERY, CPU1A, CPU1B = slice(None), slice(1, 15), [15, 0]
PUBLISHED = {
    "W_CL1_TB1": ("cl1_to_tb1", EVERY),
    "W_TB1_TB1": ("tb1_to_tb1", EVERY),
    "W_TN_CPU4": ("tn_to_cpu4", EVERY),
    "W_TB1_CPU4": ("tb1_to_cpu4", EVERY),
    "W_CPU4_pontin": ("cpu4_to_pontine", EVERY),
    "W_CPU4_CPU1a": ("cpu4_to_cpu1", CPU1A),
    "W_CPU4_CPU1b": ("cpu4_to_cpu1", CPU1B),
    "W_pontin_CPU1a": ("pontine_to_cpu1", CPU1A),
    "W_pontin_CPU1b": ("pontine_to_cpu1", CPU1B),
    "W_TB1_CPU1a": ("tb1_to_cpu1", CPU1A),
    "W_TB1_CPU1b": ("tb1_to_cpu1", CPU1B),
    "W_CPU1a_motor": ("cpu1_to_motor", CPU1A),
    "W_CPU1b_motor": ("cpu1_to_motor", CPU1B),
}
STANDARD = Connectivity()


def shift_columns(n_cells: int, n_columns: int) -> np.ndarray:
    """Index that moves the columns of a population, both hemispheres alike; two cells have no columns."""
    if n_cells == 2:
        return np.arange(2)
    return (np.arange(n_cells) % 8 + n_columns) % 8 + np.arange(n_cells) // 8 * 8


def reflect(n_cells: int) -> np.ndarray:
    """Index that swaps left and right: column j of one hemisphere with column -j of the other."""
    if n_cells == 2:
        return np.array([1, 0])
    side = 0 if n_cells == 8 else 1 - np.arange(n_cells) // 8
    return -np.arange(n_cells) % 8 + 8 * side


def rates_after(params: CircuitParams) -> Rates:
    """Rates of a circuit with uneven memory and compass, after a step in which no cell is silenced or saturated."""
    state = initial_state(params)
    uneven = 0.5 + 0.3 * np.sin(1 + np.arange(16.0))
    state = replace(state, memory=uneven, tb1=0.5 + 0.4 * np.cos(np.arange(8.0)))
    return step(state, Senses(heading=0.4, velocity=[0.3, 1.1]), params)[1]


def with_matrix(name: str, matrix: np.ndarray) -> CircuitParams:
    return replace(THESIS, connectivity=replace(STANDARD, **{name: matrix}))


@pytest.mark.data
@pytest.mark.parametrize("name", PUBLISHED)
def test_matrix_is_the_published_one(name: str, golden) -> None:
    published = golden("central_complex_weights")
    assert set(published) == set(PUBLISHED)
    ours, cpu1_cells = PUBLISHED[name]
    matrix = getattr(STANDARD, ours)
    matrix = matrix[:, cpu1_cells] if name.endswith("motor") else matrix[cpu1_cells]
    np.testing.assert_allclose(matrix, published[name], rtol=0, atol=1e-15)


def test_matrices_follow_the_written_rules() -> None:
    inputs = {name: [np.flatnonzero(row).tolist() for row in getattr(STANDARD, name)] for name in SHAPES}
    assert inputs["tl_to_cl1"] == [[i] for i in range(16)]
    assert inputs["cl1_to_tb1"] == [[i, i + 8] for i in range(8)]
    assert inputs["tn_to_cpu4"] == [[i // 8] for i in range(16)]
    assert inputs["tb1_to_cpu4"] == inputs["tb1_to_cpu1"] == [[i % 8] for i in range(16)]
    assert inputs["cpu4_to_pontine"] == [[i] for i in range(16)]
    assert inputs["cpu4_to_cpu1"] == [[8 + (k - 1) % 8] for k in range(8)] + [[(j + 1) % 8] for j in range(8)]
    assert inputs["pontine_to_cpu1"] == [[8 + (k + 3) % 8] for k in range(8)] + [[(j + 5) % 8] for j in range(8)]
    assert inputs["cpu1_to_motor"] == [list(range(8)), list(range(8, 16))]
    for name in set(SHAPES) - {"tb1_to_tb1"}:
        assert set(getattr(STANDARD, name).ravel()) <= {0.0, 1.0}, name


def test_compass_cells_inhibit_each_other_by_the_cosine_rule() -> None:
    steps_apart = np.abs(np.arange(8)[:, None] - np.arange(8))
    by_steps = np.array([0, (1 - np.sqrt(0.5)) / 2, 0.5, (1 + np.sqrt(0.5)) / 2, 1])
    expected = by_steps[np.minimum(steps_apart, 8 - steps_apart)]
    np.testing.assert_allclose(STANDARD.tb1_to_tb1, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", SHAPES)
def test_no_direction_is_special(name: str) -> None:
    matrix = getattr(STANDARD, name)
    n_targets, n_sources = matrix.shape
    for n_columns in range(1, 8):
        shifted = matrix[np.ix_(shift_columns(n_targets, n_columns), shift_columns(n_sources, n_columns))]
        np.testing.assert_allclose(shifted, matrix, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", SHAPES)
def test_left_and_right_are_mirror_images(name: str) -> None:
    matrix = getattr(STANDARD, name)
    n_targets, n_sources = matrix.shape
    mirrored = matrix[np.ix_(reflect(n_targets), reflect(n_sources))]
    np.testing.assert_allclose(mirrored, matrix, rtol=0, atol=1e-15)


def test_pontine_cells_bring_the_opposite_column() -> None:
    excited = np.argmax(STANDARD.cpu4_to_cpu1, axis=1)
    inhibited = np.argmax(STANDARD.pontine_to_cpu1, axis=1)
    assert np.all(excited // 8 == inhibited // 8)
    assert np.all((excited - inhibited) % 8 == 4)
    assert np.all(excited // 8 != np.arange(16) // 8)


def test_all_projections_have_a_matrix_of_the_right_shape() -> None:
    assert {field.name: getattr(STANDARD, field.name).shape for field in fields(Connectivity)} == SHAPES


@pytest.mark.parametrize("name", SHAPES)
def test_changed_matrix_changes_the_cell_that_it_feeds(name: str) -> None:
    matrix = getattr(STANDARD, name).copy()
    cell = 1 if name == "cpu1_to_motor" else 5
    matrix[cell] *= 1.5
    before, after = rates_after(THESIS), rates_after(with_matrix(name, matrix))
    changed = np.atleast_1d(getattr(after, TARGET[name]) != getattr(before, TARGET[name]))
    assert np.flatnonzero(changed).tolist() == ([0] if name == "cpu1_to_motor" else [cell])


def test_several_synapses_of_any_weight_add_up() -> None:
    weights = np.random.default_rng(0).normal(0, 1, (2, 16))
    rates = rates_after(with_matrix("cpu1_to_motor", weights))
    right, left = weights @ rates.cpu1
    np.testing.assert_allclose(rates.motor, THESIS.motor_gain * (right - left), rtol=0, atol=1e-13)
    weights = np.random.default_rng(1).normal(0, 0.2, (16, 16))
    rates = rates_after(with_matrix("tl_to_cl1", weights))
    expected = 1 / (1 + np.exp(THESIS.cl1_slope * (weights @ rates.tl) + THESIS.cl1_bias))
    np.testing.assert_allclose(rates.cl1, expected, rtol=0, atol=1e-13)


def test_cell_without_synapses_has_no_input() -> None:
    rates = rates_after(with_matrix("tl_to_cl1", np.zeros((16, 16))))
    np.testing.assert_allclose(rates.cl1, 1 / (1 + np.exp(THESIS.cl1_bias)), rtol=0, atol=1e-14)
    assert rates_after(with_matrix("cpu1_to_motor", np.zeros((2, 16)))).motor == 0


@pytest.mark.parametrize("name", SHAPES)
def test_matrix_of_another_shape_is_refused(name: str) -> None:
    n_targets, n_sources = SHAPES[name]
    for shape in [(n_targets + 1, n_sources), (n_targets, n_sources - 1), (n_targets,), (1, n_targets, n_sources)]:
        with pytest.raises(
            InputError, match=rf"^connectivity {name} has shape .*expected \({n_targets}, {n_sources}\)"
        ):
            Connectivity(**{name: np.zeros(shape)})


def test_transposed_matrix_is_guessed() -> None:
    with pytest.raises(InputError, match=r"transposed\?$"):
        Connectivity(tn_to_cpu4=np.ones((2, 16)))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_matrix_with_a_hole_is_refused(bad: float) -> None:
    matrix = np.eye(16)
    matrix[3, 4] = bad
    with pytest.raises(InputError, match=r"^connectivity cpu4_to_pontine is (nan|inf) at index 3, 4"):
        Connectivity(cpu4_to_pontine=matrix)


def test_matrices_cannot_change_afterwards() -> None:
    given = np.eye(16)
    connectivity = Connectivity(cpu4_to_pontine=given)
    given[0, 0] = 7
    assert connectivity.cpu4_to_pontine[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        connectivity.cpu4_to_pontine[0, 0] = 7
    with pytest.raises(FrozenInstanceError):
        connectivity.cpu4_to_pontine = given
