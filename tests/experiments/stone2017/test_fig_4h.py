"""The circuit as a graph: its connections against the plain oracle, measures by hand; small runs to the verdicts."""

import numpy as np
import pytest

import oracle
from insectnav.experiments.stone2017_path_integration import fig_4h
from insectnav.experiments.stone2017_path_integration.fig_4h import (
    ALGORITHMS,
    Cell,
    circuit_graph,
    column_middles,
    column_shifts,
    innermost,
    is_in_order,
    stress,
    upright,
)
from small_runs import same_bits, simulated, verdicts_of

ANGLES = np.arange(8) * np.pi / 4.0


def ring(turned: float = 0.0, mirrored: bool = False, radius: float = 1.0) -> np.ndarray:
    """Places of 40 cells (node, 2), all of a column at its direction, clockwise from +y."""
    angle = np.concatenate([ANGLES] * 5) * (-1.0 if mirrored else 1.0) + turned
    return radius * np.stack([np.sin(angle), np.cos(angle)], axis=-1)


@pytest.fixture(scope="module")
def results():
    cells = [Cell(algorithm=name, has_tb1_ring=tb1, n_layouts=2) for name in ALGORITHMS for tb1 in (True, False)]
    return simulated(fig_4h, cells)


def test_small_run_gives_all_verdicts(results):
    verdicts_of(fig_4h, "stone2017-fig-4h", results)


def test_same_seed_same_bits():
    assert same_bits(fig_4h, Cell(algorithm="kamada-kawai", has_tb1_ring=False, n_layouts=1))
    assert same_bits(fig_4h, Cell(algorithm="fruchterman-reingold", has_tb1_ring=True, n_layouts=1))


def test_edges_are_the_matrices_of_the_oracle():
    graph = circuit_graph()
    matrices = {
        ("tb1", "cpu4"): oracle.WEIGHTS["W_TB1_CPU4"],
        ("cpu4", "cpu1"): 0.5 * oracle.WEIGHTS["W_CPU4_CPU1"],
        ("tb1", "cpu1"): oracle.WEIGHTS["W_TB1_CPU1"],
        ("tb1", "tb1"): 0.333 * oracle.WEIGHTS["W_TB1_TB1"],
    }
    n_edges = 0
    for (source, target), matrix in matrices.items():
        for i, j in np.argwhere(matrix > 0.0).tolist():
            assert graph.edges[(source, j), (target, i)]["weight"] == pytest.approx(matrix[i, j])
        n_edges += np.count_nonzero(matrix) // (2 if source == target else 1)
    assert graph.number_of_edges() == n_edges == 16 + 16 + 16 + 28
    assert circuit_graph(has_tb1_ring=False).number_of_edges() == 48
    assert graph.number_of_nodes() == 40


def test_without_their_inhibition_the_columns_are_a_circle_of_neighbours():
    """What the layout finds follows from the wiring: cells of columns more than one apart never touch."""
    for (_, a), (_, b) in circuit_graph(has_tb1_ring=False).edges:
        assert (a - b) % 8 in (0, 1, 7)


def test_shifts_are_those_of_the_oracle():
    memory = np.argmax(oracle.WEIGHTS["W_CPU4_CPU1"], axis=1) % 8
    heading = np.argmax(oracle.WEIGHTS["W_TB1_CPU1"], axis=1)
    np.testing.assert_array_equal((heading + column_shifts()) % 8, memory)
    assert set(column_shifts().tolist()) == {-1, 1}


# Measures by hand.


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("turned", [0.0, 1.0, -2.5])
def test_ring_is_in_order_whichever_way_it_lies(turned: float, mirrored: bool):
    middles = column_middles(ring(turned, mirrored)[None] + 5.0)
    np.testing.assert_allclose(np.linalg.norm(middles, axis=-1), 1.0, atol=1e-12)
    assert is_in_order(middles).all()
    assert innermost(middles) == pytest.approx(1.0)


def test_two_columns_exchanged_are_out_of_order():
    middles = column_middles(ring()[None])
    exchanged = middles[:, [0, 2, 1, 3, 4, 5, 6, 7]]
    assert not is_in_order(exchanged).any()
    np.testing.assert_array_equal(is_in_order(np.concatenate([middles, exchanged])), [True, False])


def test_column_in_the_middle_is_innermost():
    middles = np.stack([np.sin(ANGLES), np.cos(ANGLES)], axis=-1)[None]
    middles[0, 3] *= 0.2
    assert innermost(middles) == pytest.approx(0.2 / (7.2 / 8.0))


def test_true_distances_have_no_stress():
    line = np.arange(5.0)
    distance = np.abs(line[:, None] - line) + 0.0
    places = np.stack([3.0 * line, 0.0 * line], axis=-1)
    assert stress(places[None], distance) == pytest.approx(0.0, abs=1e-12)
    bent = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])  # √2 / 2 for the far pair, 1 for the two others
    q = np.array([1.0, 1.0, np.sqrt(0.5)])
    expected = min(np.mean((k * q - 1.0) ** 2) for k in np.linspace(0.5, 2.0, 30_001))
    assert stress(bent[None], distance[:3, :3]) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("mirrored", [False, True])
def test_upright_drawing_has_column_1_on_top_and_the_rest_clockwise(mirrored: bool):
    place = upright(ring(2.2, mirrored, radius=7.0) + np.array([3.0, -1.0]))
    np.testing.assert_allclose(place, ring(), atol=1e-9)
