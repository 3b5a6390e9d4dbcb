"""A few cells of an experiment, from simulation to verdicts, in this process."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from insectnav.experiments.experiment import Results, check_grid
from insectnav.experiments.figures import journal_style
from insectnav.experiments.published import AGREES, DIFFERS, Verdict
from insectnav.sweep import published_numbers


def simulated(experiment: Any, cells: Sequence[Any], seed: int = 0) -> Results:
    """Cells as the store gives them back."""
    check_grid(cells)
    found = [experiment.simulate(cell, seed) for cell in cells]
    kinds = [
        {name: (array[0], np.shape(array[1]), np.asarray(array[1]).dtype) for name, array in arrays.items()}
        for arrays in found
    ]
    assert all(kind == kinds[0] for kind in kinds)
    assert all(len(dimensions) == len(shape) for dimensions, shape, _ in kinds[0].values())
    return Results(cells, {name: np.stack([arrays[name][1] for arrays in found]) for name in found[0]})


def simulated_grid(experiment: Any, n_trials: int, seed: int = 1) -> Results:
    """The quick grid with few trials in each cell."""
    return simulated(experiment, [replace(cell, n_trials=n_trials) for cell in experiment.grid("quick")], seed)


def same_bits(experiment: Any, cell: Any, seed: int = 5) -> bool:
    """Whether a cell gives the same twice, to the last bit, and something else with another seed."""
    first, again, other = (experiment.simulate(cell, s) for s in (seed, seed, seed + 1))
    is_same = all(np.array_equal(first[name][1], again[name][1], equal_nan=True) for name in first)
    return is_same and any(not np.array_equal(first[name][1], other[name][1], equal_nan=True) for name in first)


def verdicts_of(experiment: Any, name: str, results: Results) -> list[Verdict]:
    """Draws the figure, checks its words and gives all verdicts, those that differ with a reason."""
    table = experiment.summarise(results)
    assert all(list(row) == list(table[0]) for row in table)
    with warnings.catch_warnings(), journal_style():
        warnings.simplefilter("error")
        figure = experiment.draw(results)
        figure.draw_without_rendering()
    assert all(axes.has_data() for axes in figure.axes)
    assert experiment.caption(results).endswith(".")
    published = published_numbers(experiment, name)
    verdicts = list(experiment.compare(table, published))
    assert [v.quantity for v in verdicts] == list(published)
    assert all(v.verdict == AGREES or len(v.why) > 20 for v in verdicts)
    assert all(v.uncertainty >= 0.0 for v in verdicts if np.isfinite(v.ours))
    return verdicts


def explains_in_numbers(experiment: Any, name: str, results: Results) -> bool:
    """Whether each verdict would differ from a published number out of reach, and give a number as its reason."""
    impossible = {
        key: replace(value, value=1e6, low=1e6, high=1e6) for key, value in published_numbers(experiment, name).items()
    }
    verdicts = experiment.compare(experiment.summarise(results), impossible)
    return all(v.verdict == DIFFERS and any(character.isdigit() for character in v.why) for v in verdicts)
