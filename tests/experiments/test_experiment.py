"""Grids that can be told apart, results by their parameters, and keys that follow from all that decides them."""

from collections.abc import Sequence
from dataclasses import dataclass, make_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.experiments.experiment import (
    Results,
    cell_text,
    check_grid,
    code_version,
    paper_of,
    results_key,
)
from slow_paper import fig_1


@dataclass(frozen=True, kw_only=True)
class Cell:
    value: Any
    word: str = "a"


@dataclass(kw_only=True)
class Thawed:
    value: float = 1.0


def cells(*values: Any) -> list[Cell]:
    return [Cell(value=value) for value in values]


# Grids.


@pytest.mark.parametrize(
    "values",
    [(1,), (1, 2.5, float("inf")), ("a", "b"), (True, False), (0, -(2**63) + 1, 2**63 - 1), (np.float64(0.5), 1)],
)
def test_numbers_words_and_truth_values_pass(values: tuple):
    check_grid(cells(*values))


Other = make_dataclass("Other", [("value", int)], frozen=True)


@pytest.mark.parametrize(
    ("grid", "told"),
    [
        ([], "the grid is empty, expected at least one cell"),
        (cells(1, 2, 1), r"2 cells of the grid are equal \(value=1, word='a'\), expected all to differ"),
        (cells(1, 1.0), r"2 cells of the grid are equal"),
        (cells(1, 2, (3, 4)), "cell parameter value is a tuple, expected a number or a word"),
        (cells(None), "cell parameter value is a NoneType"),
        (cells(np.int64(1)), "cell parameter value is a int64"),
        (cells(np.zeros(2)), "cell parameter value is a ndarray"),
        (cells(1, float("nan")), "cell parameter value is nan"),
        (cells(2**63), "cell parameter value is 9223372036854775808"),
        (cells(1, "b"), "cell parameter value is a word in one cell and a number in another, expected one kind"),
        (cells(2, True), "cell parameter value is .*expected one kind"),
        ([{"value": 1}], "the grid holds other things than cells"),
        ([*cells(1), Other(1)], "the grid holds other things than cells"),
        ([Thawed()], "the grid holds other things than cells, expected instances of one frozen dataclass"),
        ([make_dataclass("Odd", [("cell", int)], frozen=True)(1)], "a cell parameter is called 'cell'"),
    ],
)
def test_grid_that_cannot_be_is_refused(grid: Sequence[Any], told: str):
    with pytest.raises(InputError, match=f"^{told}") as caught:
        check_grid(grid)
    assert "\n" not in str(caught.value)


def test_cell_text_names_every_parameter():
    assert cell_text(Cell(value=0.1, word="µ")) == "value=0.1, word='µ'"


# Results.


@pytest.fixture
def results() -> Results:
    grid = [Cell(value=value, word=word) for word in ("b", "a") for value in (0.0, 0.1, 0.2)]
    return Results(grid, {"index": np.arange(6), "path": np.arange(24).reshape(6, 2, 2)})


def test_cells_are_found_by_their_parameters(results: Results):
    assert results.where(word="a").tolist() == [3, 4, 5]
    assert results.where(value=0.1).tolist() == [1, 4]
    assert results.where(word="a", value=0.1).tolist() == [4]
    assert results.where().tolist() == [0, 1, 2, 3, 4, 5]
    assert results.where(word="c").tolist() == []
    assert results["path"][results.where(word="c")].shape == (0, 2, 2)


def test_only_cell_is_found_or_told(results: Results):
    assert results.only(word="b", value=0.2) == 2
    for wanted, n in (({"word": "a"}, 3), ({"value": 0.3}, 0)):
        with pytest.raises(LookupError, match=rf"^{n} cells have .*, expected one$"):
            results.only(**wanted)


def test_cells_are_grouped_in_the_order_of_the_grid(results: Results):
    assert {word: indices.tolist() for word, indices in results.by("word").items()} == {"b": [0, 1, 2], "a": [3, 4, 5]}
    assert list(results.by("word")) == ["b", "a"]
    assert [indices.tolist() for indices in results.by("value").values()] == [[0, 3], [1, 4], [2, 5]]


def test_each_cell_comes_with_its_own_arrays(results: Results):
    for i, (cell, arrays) in enumerate(results):
        assert cell is results.cells[i]
        assert arrays["index"] == i
        assert arrays["path"].tolist() == [[4 * i, 4 * i + 1], [4 * i + 2, 4 * i + 3]]


# Names of results.


def test_key_follows_from_cells_seed_and_code(monkeypatch: pytest.MonkeyPatch):
    grid = fig_1.grid("quick")
    keys = [
        results_key(fig_1, grid, 0),
        results_key(fig_1, grid, 1),
        results_key(fig_1, grid[:-1], 0),
        results_key(fig_1, grid[::-1], 0),
    ]
    assert results_key(fig_1, fig_1.grid("quick"), np.int64(0)) == keys[0]
    monkeypatch.setattr("insectnav.experiments.experiment.code_version", lambda: "other")
    keys.append(results_key(fig_1, grid, 0))
    assert len(set(keys)) == 5
    assert all(len(key) == 12 and set(key) <= set("0123456789abcdef") for key in keys)


@given(st.lists(st.floats(allow_nan=False), min_size=2, max_size=2, unique=True))
def test_key_tells_any_two_numbers_apart(values: list[float]):
    one, other = (results_key(fig_1, cells(value), 0) for value in values)
    assert one != other


def test_code_version_is_that_of_every_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def version_of(files: dict[str, str]) -> str:
        for name, text in files.items():
            (tmp_path / "package" / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / "package" / name).write_text(text)
        monkeypatch.setattr("insectnav.experiments.experiment.__file__", str(tmp_path / "package" / "x" / "y.py"))
        return code_version.__wrapped__()

    first = version_of({"a.py": "1", "x/published.csv": "2", "x/notes.txt": "3"})
    assert version_of({"x/notes.txt": "4"}) == first
    assert version_of({"a.py": "2"}) != first
    assert version_of({"a.py": "1"}) == first
    assert version_of({"x/published.csv": "3"}) != first
    (tmp_path / "package" / "x" / ".#lock.py").symlink_to("nowhere")  # as editors leave
    assert len(version_of({})) == 12


def test_paper_is_that_of_the_folder():
    assert paper_of(fig_1) == "Nobody 1900"
