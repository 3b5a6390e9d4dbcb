"""A grid of parameters over many processes or machines, resumable, and an experiment from its grid to its folder."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple, Protocol, cast

from insectnav.checks import InputError, check_choice, check_count, quoted
from insectnav.experiments.experiment import (
    SCALES,
    Arrays,
    Experiment,
    Results,
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
)
from insectnav.experiments.store import CellStore, locked

WINDOW = 256  # cells handed out at a time: what waits for the disk is bounded


class Executor(Protocol):
    """Anything that runs functions elsewhere: a pool of `concurrent.futures`, a client of Dask."""

    def submit(self, function: Callable, /, *arguments: Any) -> Any:
        """A future with ``result()`` and ``add_done_callback()``."""


class HereAndNow:
    """An executor that runs everything in this process, at once."""

    def submit(self, function: Callable, /, *arguments: Any) -> Any:
        """A future that is done."""
        from concurrent.futures import Future

        future: Future = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def executor(workers: int | None = None, cluster: str | None = None) -> Iterator[Executor]:
    """Processes on this machine, one for each core unless told otherwise, or a Dask cluster.

    Parameters
    ----------
    workers : int, optional
        Number of processes; 1 runs everything in the present one.
    cluster : str, optional
        Address of a Dask scheduler, such as "tcp://127.0.0.1:8786".

    Raises
    ------
    InputError
        If there is no such cluster, Dask is not installed, or both are given.
    """
    if workers is not None:
        check_count("workers", workers)
    if cluster is not None:
        if workers is not None:
            raise InputError("both workers and cluster are given, expected one: the cluster has workers of its own")
        with _cluster(cluster) as client:
            yield client
    elif (workers or _n_cores()) == 1:
        yield HereAndNow()
    else:
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        # Not forked: threads of compiled code do not survive that.
        with ProcessPoolExecutor(workers or _n_cores(), multiprocessing.get_context("spawn")) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError:
        raise InputError("a cluster needs Dask, which is not installed: pip install insectnav[cluster]") from None
    try:
        client = Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = type(error).__name__
        raise InputError(
            f"no Dask scheduler answers at {quoted(address)} ({reason}), expected as in tcp://host:8786"
        ) from None
    with client:
        yield cast(Executor, client)


def _n_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def simulate_cell(module: str, parameters: dict[str, Any], seed: int, version: str) -> Arrays:
    """Results of one cell, wherever this runs.

    Raises
    ------
    InputError
        If this machine has another version of the code than the one that asks.
    """
    if code_version() != version:
        raise InputError(
            f"a worker has insectnav {code_version()}, expected {version} as here: install the same everywhere"
        )
    experiment = cast(Any, importlib.import_module(module))
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
    """
    finished = store.finished()
    if progress is not None:
        progress(len(finished))
    waiting = iter([index for index in range(len(cells)) if index not in finished])
    done: SimpleQueue = SimpleQueue()
    running: dict[int, Any] = {}  # Dask forgets a result that nobody holds

    def hand_out() -> None:
        for index in waiting:
            future = on.submit(simulate_cell, experiment.__name__, asdict(cells[index]), seed, code_version())
            running[index] = future
            future.add_done_callback(lambda _, index=index: done.put(index))
            if len(running) >= WINDOW:
                return

    hand_out()
    while running:
        index = done.get()
        store.write(index, running.pop(index).result())
        if progress is not None:
            progress(1)
        hand_out()


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
        If the folder cannot be written, or holds an unfinished run that would be lost.
    """
    started = time.perf_counter()
    check_choice("scale", scale, SCALES)
    check_count("seed", seed, minimum=0)
    cells = experiment.grid(scale)
    check_grid(cells)
    key = results_key(experiment, cells, seed)
    final, unfinished = out / name / key, out / name / f".{key}.unfinished"
    if resume and (final / PROVENANCE).is_file():
        return Outcome(final, read_verdicts(final / "comparison.csv"), 0.0, len(cells))
    check_destination(final)
    with locked(unfinished):
        about = {
            "experiment": name,
            "paper": paper_of(experiment),
            "figure": experiment.FIGURE,
            "title": experiment.TITLE,
            "scale": scale,
            "seed": seed,
            "cells": len(cells),
            "key": key,
            "code": code_version(),
        }
        store = CellStore(unfinished, cells, about)
        n_finished = len(store.finished())
        if n_finished and not resume:
            raise InputError(
                f"{quoted(unfinished, 200)} holds {n_finished} of {len(cells)} cells of an unfinished run: "
                "add --resume to go on with it, or remove it"
            )
        run_cells(experiment, cells, seed, store, on, progress)
        verdicts = _write_findings(unfinished, experiment, name, store.read())
        seconds = time.perf_counter() - started
        made = about | {"cells_from_earlier_run": n_finished} | provenance(seconds)
        (unfinished / PROVENANCE).write_text(to_json(made) + "\n", encoding="utf-8")
        store.seal()
        replace_folder(final, unfinished)
    return Outcome(final, verdicts, seconds, len(cells))


def _write_findings(folder: Path, experiment: Experiment, name: str, results: Results) -> list[Verdict]:
    """Table, figure, caption and comparison of complete results."""
    table = experiment.summarise(results)
    write_table(folder / "table.csv", table)
    with journal_style():
        figure = experiment.draw(results)
    save_figure(figure, folder)
    (folder / "caption.txt").write_text(experiment.caption(results) + "\n", encoding="utf-8")
    verdicts = list(experiment.compare(table, published_numbers(experiment, name)))
    write_verdicts(folder / "comparison.csv", verdicts)
    return verdicts


def published_numbers(experiment: Experiment, name: str) -> dict[str, Published]:
    """What the paper says of an experiment, from the published.csv beside its module."""
    return read_published(Path(experiment.__file__).with_name("published.csv"), name)
