"""A grid of parameters over many processes or machines, resumable, and an experiment from its grid to its folder."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple, NoReturn, cast

from insectnav.checks import InputError, check_choice, check_count, quoted
from insectnav.experiments.executors import Executor, executor
from insectnav.experiments.experiment import (
    SCALES,
    Arrays,
    Experiment,
    Results,
    cell_text,
    check_grid,
    code_version,
    paper_of,
    results_key,
)
from insectnav.experiments.figures import journal_style, save_figure
from insectnav.experiments.published import Published, Verdict, read_published, read_verdicts, write_verdicts
from insectnav.experiments.results import (
    PROVENANCE,
    check_destination,
    provenance,
    replace_folder,
    to_json,
    write_table,
    written_to,
)
from insectnav.experiments.store import CellStore, locked

__all__ = ["CellError", "OtherCodeError", "Outcome", "executor", "published_numbers", "run_cells", "run_experiment"]

WINDOW = 1024  # cells handed out at a time: enough for a large cluster, and what waits for the disk is bounded


class CellError(RuntimeError):
    """A cell could not be simulated; its cause is the error that it raised."""


class OtherCodeError(InputError):
    """A worker has another version of the code."""


def simulate_cell(module: str, parameters: dict[str, Any], seed: int, version: str) -> Arrays:
    """Results of one cell, wherever this runs.

    Raises
    ------
    OtherCodeError
        If this machine has another version of the code than the one that asks.

    Notes
    -----
    From then on linear algebra takes one thread in this process: products that are shared out to a number of threads
    have other last digits with each number.
    """
    from threadpoolctl import threadpool_limits

    if code_version() != version:
        raise OtherCodeError(
            f"a worker has insectnav {code_version()}, expected {version} as here: "
            "installed differently there, or edited after it was started?"
        )
    experiment = cast(Any, importlib.import_module(module))
    threadpool_limits(1)
    return experiment.simulate(experiment.Cell(**parameters), seed)


def run_cells(
    experiment: Experiment,
    cells: Sequence[Any],
    seed: int,
    store: CellStore,
    on: Executor,
    progress: Callable[[int], None] | None = None,
) -> None:
    """Simulate all cells that are not finished yet; each is on disk as soon as it is done.

    Parameters
    ----------
    experiment : Experiment
    cells : sequence of cells
    seed : int
    store : CellStore
    on : Executor
    progress : callable, optional
        Called with the number of cells just finished.

    Raises
    ------
    CellError
        If a cell raises; cells that are done by then are kept, and the others are cancelled.
    InputError
        If a worker has other code, or the workers are lost.
    """
    from threadpoolctl import threadpool_limits

    finished = store.finished()
    if progress is not None:
        progress(len(finished))
    waiting = iter([index for index in range(len(cells)) if index not in finished])
    done: SimpleQueue[int] = SimpleQueue()
    running: dict[int, Any] = {}  # Dask forgets a result that nobody holds

    def hand_out() -> None:
        while len(running) < getattr(on, "window", WINDOW):
            if (index := next(waiting, None)) is None:
                return
            future = on.submit(simulate_cell, experiment.__name__, asdict(cells[index]), seed, code_version())
            running[index] = future
            future.add_done_callback(lambda _, index=index: done.put(index))

    try:
        with threadpool_limits(1):  # where cells are simulated in this process, its threads are given back
            hand_out()
            while running:
                _keep(done.get(), running, cells, store)
                if progress is not None:
                    progress(1)
                hand_out()
    except Exception:
        _keep_rest(done, running, store)
        raise
    finally:
        for future in running.values():
            future.cancel()


def _keep(index: int, running: dict[int, Any], cells: Sequence[Any], store: CellStore) -> None:
    """Write a cell that is done, or tell why it has no results."""
    from asyncio import CancelledError

    try:
        arrays = running.pop(index).result()
    except (Exception, CancelledError) as error:
        _raise_for_cell(f"cell {index + 1} of {len(cells)} ({cell_text(cells[index])})", error)
    store.write(index, arrays)


def _keep_rest(done: SimpleQueue[int], running: dict[int, Any], store: CellStore) -> None:
    """Write what else is done when one cell has failed."""
    while not done.empty():
        index = done.get()
        future = running.pop(index)
        if not future.cancelled() and future.exception() is None:
            store.write(index, future.result())


def _raise_for_cell(cell: str, error: BaseException) -> NoReturn:
    """Raise what is to be told of the failure of a cell."""
    from asyncio import CancelledError as AsyncCancelledError
    from concurrent.futures import BrokenExecutor, CancelledError

    from insectnav.experiments.processes import NotStartedError

    if isinstance(error, OtherCodeError):
        raise error
    if isinstance(error, BrokenExecutor):
        what = "a process that simulated cells was killed, expected it to live (out of memory?)"
        if isinstance(error, NotStartedError):
            what = f"{error}, expected room for one more"
        raise InputError(f"{what}: what is finished is kept, go on with --resume and fewer --workers") from error
    if isinstance(error, CancelledError | AsyncCancelledError):
        raise InputError(
            f"the cluster gave up {cell}, expected its scheduler to live: what is finished is kept, go on with --resume"
        ) from error
    raise CellError(f"{cell}: {type(error).__name__}: {error}") from error


class Outcome(NamedTuple):
    """What `run_experiment` left behind."""

    folder: Path
    verdicts: Sequence[Verdict]
    seconds: float  # 0 where it was there already
    n_cells: int


def run_experiment(
    experiment: Experiment,
    name: str,
    out: Path,
    *,
    scale: str = "quick",
    seed: int = 0,
    on: Executor,
    resume: bool = False,
    progress: Callable[[int], None] | None = None,
) -> Outcome:
    """An experiment from its grid to its folder of results, ``out/name/key``.

    Parameters
    ----------
    experiment : Experiment
    name : str
    out : Path
    scale : {"quick", "full"}
    seed : int
    on : Executor
    resume : bool
        Keep what an unfinished run left; a finished one is not run again.
    progress : callable, optional
        Called with the number of cells just finished.

    Raises
    ------
    InputError
        If the folder cannot be written, is being written by another run, or holds an unfinished run that would be lost.
    CellError
        If a cell raises.
    """
    started = time.perf_counter()
    check_choice("scale", scale, SCALES)
    check_count("seed", seed, minimum=0)
    cells = list(experiment.grid(scale))
    check_grid(cells)
    key = results_key(experiment, cells, seed)
    final = Path(os.path.realpath(out)) / name / key
    with written_to(final):
        final.parent.mkdir(parents=True, exist_ok=True)
    with locked(final.with_name(f".{key}.lock")):
        is_there = resume and (final / PROVENANCE).is_file()
        if not is_there:
            check_destination(final)
            about = _about(experiment, name, scale=scale, seed=int(seed), cells=len(cells), key=key)
            store = CellStore(final.with_name(f".{key}.unfinished"), cells, about)
            _check_unfinished(store, resume)
            _finish(experiment, store, on, progress, started)
            with written_to(final):
                replace_folder(final, store.folder)
    seconds = 0.0 if is_there else time.perf_counter() - started
    return Outcome(out / name / key, read_verdicts(final / "comparison.csv"), seconds, len(cells))


def _about(experiment: Experiment, name: str, **settings: Any) -> dict[str, Any]:
    """What the results are of: attributes of the data, and the head of provenance.json."""
    about = {"experiment": name, "paper": paper_of(experiment), "figure": experiment.FIGURE, "title": experiment.TITLE}
    return about | settings | {"code": code_version()}


def _check_unfinished(store: CellStore, resume: bool) -> None:
    n_finished = len(store.finished())
    if n_finished and not resume and not (store.folder / PROVENANCE).is_file():
        raise InputError(
            f"{quoted(store.folder, 200)} holds {n_finished} of {len(store.cells)} cells of an unfinished run: "
            "add --resume to go on with it, or remove it"
        )


def _finish(
    experiment: Experiment,
    store: CellStore,
    on: Executor,
    progress: Callable[[int], None] | None,
    started: float,
) -> None:
    """All that belongs in the folder, provenance last: with it the folder is complete and only lacks its name."""
    if (store.folder / PROVENANCE).is_file():
        store.forget_progress()
        return
    n_earlier = len(store.finished())
    try:
        run_cells(experiment, store.cells, store.about["seed"], store, on, progress)
    except BaseException:
        store.remove_if_empty()
        raise
    _write_findings(store.folder, experiment, store.about["experiment"], store.read())
    store.complete()
    made = store.about | {"cells_from_earlier_run": n_earlier} | provenance(time.perf_counter() - started)
    with written_to(store.folder):
        part = store.folder / f"{PROVENANCE}.part"
        part.write_text(to_json(made) + "\n", encoding="utf-8")
        part.rename(store.folder / PROVENANCE)
    store.forget_progress()


def _write_findings(folder: Path, experiment: Experiment, name: str, results: Results) -> None:
    """Table, figure, caption and comparison of complete results."""
    table = experiment.summarise(results)
    with journal_style():
        figure = experiment.draw(results)
    caption = experiment.caption(results)
    verdicts = list(experiment.compare(table, published_numbers(experiment, name)))
    with written_to(folder):
        write_table(folder / "table.csv", table)
        save_figure(figure, folder)
        (folder / "caption.txt").write_text(caption + "\n", encoding="utf-8")
        write_verdicts(folder / "comparison.csv", verdicts)


def published_numbers(experiment: Experiment, name: str) -> dict[str, Published]:
    """What the paper says of an experiment, from the published.csv beside its module; nothing where there is none."""
    path = Path(experiment.__file__).with_name("published.csv")
    return read_published(path, name) if path.exists() else {}
