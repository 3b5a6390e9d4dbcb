"""From the grid to a folder of results: whole, under its final name, or not there."""

import csv
import json
import os
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from insectnav.checks import InputError
from insectnav.experiments.experiment import code_version
from insectnav.experiments.results import PROVENANCE
from insectnav.experiments.store import locked
from insectnav.rng import trial_streams
from insectnav.sweep import CellError, Outcome, executor, run_experiment
from slow_paper import fig_1, runs


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No cell takes time."""
    monkeypatch.setenv(fig_1.PACE, "0")


def run(out: Path, **options: Any) -> Outcome:
    with executor(workers=1) as on:
        return run_experiment(fig_1, "slow", out, on=on, **options)


def stop_after(n_cells: int) -> Callable[[int], None]:
    """Progress that is interrupted when so many cells are finished."""
    total = 0

    def count(n_more: int) -> None:
        nonlocal total
        total += n_more
        if total >= n_cells:
            raise KeyboardInterrupt

    return count


def unfinished_run(out: Path, n_cells: int) -> None:
    with pytest.raises(KeyboardInterrupt):
        run(out, progress=stop_after(n_cells))
    assert runs.n_finished(out) == n_cells


def refuse_to_simulate(cell: fig_1.Cell, seed: int) -> Any:
    raise AssertionError("simulated again")


# What is left.


def test_folder_has_what_was_promised_and_nothing_else_is_left(tmp_path: Path):
    done = run(tmp_path / "out")
    assert done.folder.parent == tmp_path / "out" / "slow"
    assert os.listdir(done.folder.parent) == [done.folder.name]
    assert sorted(os.listdir(done.folder)) == runs.FILES
    assert done.n_cells == runs.N_CELLS
    assert done.seconds > 0.0
    assert [(verdict.quantity, verdict.verdict) for verdict in done.verdicts] == [
        ("mean of even cells", "agrees"), ("mean of odd cells", "agrees"),
    ]  # fmt: skip
    assert (done.folder / "caption.txt").read_text() == "Means of uniform numbers (n = 2000).\n"


def test_provenance_tells_command_machine_and_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.argv", ["/usr/bin/insectnav", "run", "slow"])
    before = datetime.now(UTC).replace(microsecond=0)
    done = run(tmp_path, seed=np.int64(7))
    made = json.loads((done.folder / PROVENANCE).read_text())
    told = {name: made[name] for name in ("experiment", "paper", "figure", "title", "scale", "seed", "cells", "key")}
    assert told == {
        "experiment": "slow", "paper": "Nobody 1900", "figure": "Fig. 1", "title": "means of uniform numbers",
        "scale": "quick", "seed": 7, "cells": 16, "key": done.folder.name,
    }  # fmt: skip
    assert made["code"] == code_version()
    assert made["cells_from_earlier_run"] == 0
    assert made["command"] == ["insectnav", "run", "slow"]
    assert set(made["machine"]) == {"system", "processor", "cores"}
    assert before <= datetime.fromisoformat(made["finished"]) <= datetime.now(UTC) + timedelta(seconds=1)
    assert 0.0 < made["seconds"] <= done.seconds + 0.001


def test_xarray_reads_all_cells_and_their_parameters(tmp_path: Path):
    folder = run(tmp_path, seed=5).folder
    cells = fig_1.grid("quick")
    with xarray.open_zarr(folder / "data.zarr") as data:
        assert dict(data.sizes) == {"cell": 16, "trial": 2000, "word": 4, "never": 0}
        for name in ("purpose", "is_even", "level", "n_trials", "seconds", "does"):
            assert data[name].dims == ("cell",)
            assert data[name].values.tolist() == [getattr(cell, name) for cell in cells]
        assert data.is_even.dtype == bool
        for index in (0, 15):
            words = trial_streams(5, np.arange(2000), f"{cells[index].purpose} {cells[index].level}")
            np.testing.assert_array_equal(data.numbers[index], words.astype(np.float32) / 2.0**32)
        assert data.numbers.dtype == np.float32
        assert data.numbers.attrs == {"units": "1", "range": [0.0, 1.0]}
        np.testing.assert_array_equal(data["mean"], data.numbers.astype(float).mean(("trial", "word")))
        assert data.attrs["seed"] == 5
        assert data.attrs["experiment"] == "slow"


def test_table_is_that_of_the_cells(tmp_path: Path):
    with (run(tmp_path).folder / "table.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["purpose"] for row in rows] == 8 * ["süß"] + 8 * ["sour"]
    standard_error = (1 / 12 / 8000) ** 0.5
    assert all(abs(float(row["mean"]) - 0.5) < 5 * standard_error for row in rows)


def test_number_of_processes_changes_no_byte(tmp_path: Path):
    with executor(3) as on:
        three = run_experiment(fig_1, "slow", tmp_path / "three", on=on).folder
    assert runs.contents(three) == runs.contents(run(tmp_path / "one").folder)


def test_seed_and_scale_decide_the_folder(tmp_path: Path):
    folders = [run(tmp_path, **options).folder for options in ({}, {"seed": 1}, {"scale": "full"})]
    assert len({folder.name for folder in folders}) == 3
    tables = {(folder / "table.csv").read_bytes() for folder in folders}
    assert len(tables) == 3


# Again.


def test_finished_run_is_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    first = run(tmp_path)
    before = (first.folder / PROVENANCE).read_bytes()
    monkeypatch.setattr(fig_1, "simulate", refuse_to_simulate)
    again = run(tmp_path, resume=True)
    assert again == first._replace(seconds=0.0, verdicts=again.verdicts)
    assert repr(again.verdicts) == repr(first.verdicts)  # one published value is NaN
    assert (first.folder / PROVENANCE).read_bytes() == before
    with pytest.raises(CellError, match=r"simulated again"):
        run(tmp_path)
    assert (first.folder / PROVENANCE).read_bytes() == before


def test_finished_run_is_replaced_where_it_is_run_again(tmp_path: Path):
    first = run(tmp_path)
    before = runs.contents(first.folder)
    (first.folder / "table.csv").write_text("spoilt")
    assert run(tmp_path).folder == first.folder
    assert runs.contents(first.folder) == before
    assert os.listdir(first.folder.parent) == [first.folder.name]


def test_folder_with_other_files_is_left_alone(tmp_path: Path):
    folder = run(tmp_path).folder
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds other files, such as 'notes.txt'"):
        run(tmp_path)
    assert run(tmp_path, resume=True).folder == folder


def test_run_where_the_user_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = run(tmp_path).folder
    monkeypatch.chdir(folder)
    run(Path("..") / "..")
    assert sorted(os.listdir()) == runs.FILES
    assert os.listdir("..") == [folder.name]


# Unfinished.


def test_unfinished_run_is_not_lost_without_a_word(tmp_path: Path):
    unfinished_run(tmp_path, 6)
    with pytest.raises(InputError, match=r"unfinished' holds 6 of 16 cells of an unfinished run: add --resume"):
        run(tmp_path)
    assert runs.n_finished(tmp_path) == 6
    (hidden,) = (tmp_path / "slow").iterdir()
    assert hidden.name.startswith(".")
    assert hidden.name.endswith(".unfinished")


def test_unfinished_run_goes_on_to_the_same_bytes(tmp_path: Path):
    unfinished_run(tmp_path / "a", 6)
    (hidden,) = (tmp_path / "a" / "slow").iterdir()
    (hidden / "data.zarr" / "numbers" / "c" / "9.0123.partial").write_bytes(b"half a ch")  # as a killed zarr leaves it
    done = run(tmp_path / "a", resume=True)
    assert runs.contents(done.folder) == runs.contents(run(tmp_path / "b").folder)
    assert os.listdir(done.folder.parent) == [done.folder.name]
    assert json.loads((done.folder / PROVENANCE).read_text())["cells_from_earlier_run"] == 6


def test_figure_that_fails_loses_no_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with monkeypatch.context() as patch:
        patch.setattr(fig_1, "caption", lambda results: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            run(tmp_path)
    assert runs.n_finished(tmp_path) == runs.N_CELLS
    monkeypatch.setattr(fig_1, "simulate", refuse_to_simulate)
    assert sorted(os.listdir(run(tmp_path, resume=True).folder)) == runs.FILES


@pytest.mark.parametrize("resume", [False, True])
def test_folder_that_only_lacks_its_name_gets_it(resume: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def interrupt(*_: Path) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("insectnav.sweep.replace_folder", interrupt)
        with pytest.raises(KeyboardInterrupt):
            run(tmp_path)
    monkeypatch.setattr(fig_1, "simulate", refuse_to_simulate)
    done = run(tmp_path, resume=resume)
    assert sorted(os.listdir(done.folder)) == runs.FILES
    assert os.listdir(done.folder.parent) == [done.folder.name]


def test_first_cell_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fig_1, "simulate", refuse_to_simulate)
    with pytest.raises(CellError, match=r"^cell 1 of 16 \(purpose='süß', .*AssertionError: simulated again$"):
        run(tmp_path)
    assert list((tmp_path / "slow").iterdir()) == []


def test_run_is_not_written_by_two_at_once(tmp_path: Path):
    key = run(tmp_path / "a").folder.name
    (tmp_path / "b" / "slow").mkdir(parents=True)
    with locked(tmp_path / "b" / "slow" / f".{key}.lock"):
        with pytest.raises(InputError, match=r"is being written by another run: wait for it to end$"):
            run(tmp_path / "b")
        run(tmp_path / "b", seed=1)  # that is another folder
    assert run(tmp_path / "b").folder.name == key


# Bad input.


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"seed": -1}, "seed is -1, expected a whole number of at least 0"),
        ({"seed": True}, "seed is True, expected a whole"),
        ({"seed": 1.5}, "seed is 1.5, expected a whole"),
        ({"scale": "ful"}, r"scale 'ful' is unknown: expected one of quick, full \(did you mean full\?\)"),
    ],
)
def test_settings_that_cannot_be_are_refused(options: dict, told: str, tmp_path: Path):
    with pytest.raises(InputError, match=f"^{told}"):
        run(tmp_path, **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["file", "file/below"])
def test_place_that_cannot_be_written_is_refused(name: str, tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match=r"^--out .* cannot be written \("):
        run(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_equal_cells_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fig_1, "grid", lambda scale: 2 * [fig_1.Cell(purpose="p", is_even=True, level=1.0)])
    with pytest.raises(InputError, match=r"^2 cells of the grid are equal \(purpose='p', .*, expected all to differ$"):
        run(tmp_path)
