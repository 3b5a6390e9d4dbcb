"""Every experiment: its grid, its words, its published numbers, and its quick run from the grid to the folder."""

import csv
import re
import time
from pathlib import Path

import pytest
import xarray

import insectnav.experiments
from insectnav.experiments import load, names
from insectnav.experiments.experiment import SCALES, Experiment, check_grid, paper_of
from insectnav.experiments.published import AGREES, DIFFERS, NOT_COMPARABLE
from insectnav.sweep import Outcome, executor, published_numbers, run_experiment

PAPERS = sorted(Path(insectnav.experiments.__file__).parent.glob("*/published.csv"))
QUICK_SECONDS = 60.0  # of all cores: 20 on a clock beside two of them, and what a busy machine lengthens them by
LARGEST_FOLDER = 50_000_000  # [byte] of a quick run


def published_rows() -> list[dict[str, str]]:
    rows = []
    for path in PAPERS:
        with path.open(newline="", encoding="utf-8") as file:
            rows += list(csv.DictReader(file))
    return rows


# Words and grids.


def test_names_are_those_of_modules_and_no_module_is_forgotten():
    modules = [load(name).__name__ for name in names()]
    assert len(set(modules)) == len(modules) > 0
    folder = Path(insectnav.experiments.__file__).parent
    with_titles = {
        "insectnav.experiments." + ".".join(path.relative_to(folder).with_suffix("").parts)
        for path in folder.glob("*/*.py")
        if re.search(r"^TITLE = ", path.read_text(encoding="utf-8"), re.MULTILINE)
    }
    assert with_titles == set(modules)


@pytest.mark.parametrize("name", names())
def test_experiment_says_what_it_is(name: str):
    experiment = load(name)
    for text in (experiment.TITLE, experiment.FIGURE, paper_of(experiment)):
        assert text == " ".join(text.split())
        assert len(text) > 3
    assert len(experiment.TITLE) < 100
    assert experiment.__doc__


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", names())
def test_grid_is_sound(name: str, scale: str):
    experiment = load(name)
    cells = experiment.grid(scale)
    check_grid(cells)
    assert type(cells[0]) is experiment.Cell
    assert list(experiment.grid(scale)) == list(cells)


@pytest.mark.parametrize("name", names())
def test_full_grid_is_no_smaller_than_the_quick_one(name: str):
    quick, full = (load(name).grid(scale) for scale in SCALES)
    assert len(full) >= len(quick)
    if hasattr(quick[0], "n_trials"):
        assert sum(cell.n_trials for cell in full) >= sum(cell.n_trials for cell in quick)


# What was published.


def test_every_published_number_is_of_an_experiment_and_says_where_it_is_from():
    rows = published_rows()
    assert {row["experiment"] for row in rows} == set(names())
    for row in rows:
        for column in ("quantity", "unit", "source", "how_read"):
            assert row[column].strip(), f"{row['experiment']}, {row['quantity']}: no {column}"
        assert not row["value"] or float(row["low"]) <= float(row["value"]) <= float(row["high"])


@pytest.mark.parametrize("name", names())
def test_published_numbers_can_be_read(name: str):
    assert len(published_numbers(load(name), name)) == sum(row["experiment"] == name for row in published_rows())


# From the grid to the folder.


def quick_run(experiment: Experiment, name: str, out: Path) -> Outcome:
    """A run that takes no longer than it may; the second at the latest, as the first compiles."""
    for attempt in ("first", "second"):
        before = time.process_time()  # other programs take none of it, but may lengthen it
        with executor(workers=1) as on:
            done = run_experiment(experiment, name, out / attempt, on=on)
        if time.process_time() - before < QUICK_SECONDS:
            return done
    raise AssertionError(f"two runs took more than {QUICK_SECONDS} s each")


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_quick_run_is_complete(name: str, tmp_path: Path):
    experiment = load(name)
    done = quick_run(experiment, name, tmp_path)
    assert sum(path.stat().st_size for path in done.folder.rglob("*") if path.is_file()) < LARGEST_FOLDER

    published = published_numbers(experiment, name)
    assert sorted(verdict.quantity for verdict in done.verdicts) == sorted(published)
    for verdict in done.verdicts:
        assert verdict.verdict in (AGREES, DIFFERS, NOT_COMPARABLE)
        assert verdict.verdict == AGREES or len(verdict.why) > 10, f"{verdict.quantity} has no reason"
        assert verdict.uncertainty >= 0.0 or verdict.verdict == NOT_COMPARABLE, verdict.quantity

    assert (done.folder / "figure.png").read_bytes().startswith(b"\x89PNG\r\n")
    assert (done.folder / "figure.pdf").read_bytes().startswith(b"%PDF-")
    caption = (done.folder / "caption.txt").read_text(encoding="utf-8").strip()
    assert len(caption) > 40
    assert caption.endswith(".")
    if hasattr(experiment.Cell, "n_trials") or any("n_trials" in vars(cell) for cell in experiment.grid("quick")):
        assert re.search(r"\bn = \d", caption), "the caption does not give n"
    with (done.folder / "table.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows
    assert all(None not in row and None not in row.values() for row in rows)
    with xarray.open_zarr(done.folder / "data.zarr") as data:
        assert data.sizes["cell"] == done.n_cells == len(experiment.grid("quick"))
        assert data.attrs["experiment"] == name
