"""An experiment at a tiny size, and what any must do with its results."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
from numpy.testing import assert_array_equal

from insectnav.experiments.experiment import Results
from insectnav.experiments.figures import journal_style
from insectnav.experiments.published import DIFFERS, NOT_COMPARABLE, Published
from insectnav.sweep import published_numbers


def results_of(experiment: ModuleType, cells: Sequence[Any], seed: int = 1) -> Results:
    """Results of some cells, stacked as the sweep stacks them."""
    simulated = [experiment.simulate(cell, seed) for cell in cells]
    for arrays in simulated:
        for name, (dimensions, values, *_) in arrays.items():
            assert np.ndim(values) == len(dimensions), name
    return Results(cells, {name: np.stack([arrays[name][1] for arrays in simulated]) for name in simulated[0]})


def tiny_results(experiment: ModuleType, n_trials: int, seed: int = 1) -> Results:
    """The quick grid with few trials in each cell."""
    return results_of(experiment, [replace(cell, n_trials=n_trials) for cell in experiment.grid("quick")], seed)


def assert_words_and_picture(experiment: ModuleType, results: Results) -> None:
    """A figure with panels, and a caption that gives the number of trials."""
    with journal_style():
        figure = experiment.draw(results)
    assert all(axes.has_data() for axes in figure.axes)
    assert f"n = {results.cells[0].n_trials} " in experiment.caption(results)


def assert_all_judged(experiment: ModuleType, name: str, table: Sequence[Mapping[str, Any]]) -> None:
    """Every published quantity has a verdict, which follows the published number, and a reason where it differs."""
    published = published_numbers(experiment, name)
    verdicts = experiment.compare(table, published)
    assert [verdict.quantity for verdict in verdicts] == list(published)
    assert all(np.isfinite(verdict.ours) and verdict.uncertainty >= 0.0 for verdict in verdicts)
    impossible = {key: _out_of_reach(value) for key, value in published.items()}
    for verdict in experiment.compare(table, impossible):
        assert verdict.verdict == DIFFERS != NOT_COMPARABLE
        assert any(character.isdigit() for character in verdict.why), verdict.quantity


def _out_of_reach(published: Published) -> Published:
    return replace(published, value=1e6, low=1e6, high=1e6)


def assert_same_bits(experiment: ModuleType, cell: Any) -> None:
    """The same cell and seed give the same arrays, another seed gives others."""
    first, again, other = (experiment.simulate(cell, seed) for seed in (3, 3, 4))
    for name, (_, values, *_) in first.items():
        assert_array_equal(values, again[name][1], err_msg=name)
    assert any(not np.array_equal(first[name][1], other[name][1], equal_nan=True) for name in first)
