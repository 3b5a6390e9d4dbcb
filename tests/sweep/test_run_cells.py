"""Cells over executors: each on disk at once, in any order, and told apart when they fail."""

import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from command_line import PATIENCE
from insectnav.checks import InputError
from insectnav.experiments.experiment import code_version
from insectnav.experiments.store import CellStore
from insectnav.sweep import WINDOW, CellError, OtherCodeError, executor, run_cells, simulate_cell
from slow_paper import fig_1, runs


def some_cells(*deeds: str, seconds: float = 0.0) -> Sequence[fig_1.Cell]:
    """Cells that do these things."""
    return [
        fig_1.Cell(purpose="some", is_even=True, level=float(i), does=does, seconds=seconds)
        for i, does in enumerate(deeds)
    ]


class ByHand:
    """An executor whose futures a test completes: `outcomes` in the order of submission, others stay pending."""

    def __init__(self, *outcomes: Callable[[Future], object]) -> None:
        self.futures: list[Future] = []
        self._outcomes = list(outcomes)

    def submit(self, function: Callable, /, *arguments: Any) -> Future:
        future: Future = Future()
        if self._outcomes:
            self._outcomes.pop(0)(future)
        self.futures.append(future)
        return future


def gives_results(future: Future) -> None:
    future.set_result(fig_1.simulate(fig_1.Cell(purpose="some", is_even=True, level=0.0), 0))


def fails(future: Future) -> None:
    future.set_exception(KeyError("by hand"))


# One after the other, and all at once.


def test_cell_is_on_disk_before_the_next_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    cells = some_cells(*5 * ["nothing"])
    store, on_disk, simulate = CellStore(tmp_path, cells, {}), [], fig_1.simulate

    def watch(cell: fig_1.Cell, seed: int) -> Any:
        on_disk.append(len(store.finished()))
        return simulate(cell, seed)

    monkeypatch.setattr(fig_1, "simulate", watch)
    progress: list[int] = []
    with executor(workers=1) as on:
        run_cells(fig_1, cells, 0, store, on, progress.append)
    assert on_disk == [0, 1, 2, 3, 4]
    assert progress == [0, 1, 1, 1, 1, 1]


def test_finished_cells_are_not_simulated_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    cells = some_cells(*4 * ["nothing"])
    store = CellStore(tmp_path, cells, {})
    for index in (2, 0):
        store.write(index, fig_1.simulate(cells[index], 0))
    simulated, simulate, progress = [], fig_1.simulate, []
    monkeypatch.setattr(fig_1, "simulate", lambda cell, seed: simulated.append(cell) or simulate(cell, seed))
    with executor(workers=1) as on:
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on, progress.append)
    assert simulated == [cells[1], cells[3]]
    assert progress == [2, 1, 1]
    assert store.finished() == {0, 1, 2, 3}


def test_order_of_completion_changes_no_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """One after the other, and the last first: each waits until its successor is on disk."""
    cells = some_cells(*6 * ["nothing"])
    simulate, is_written = fig_1.simulate, [threading.Event() for _ in cells]

    def wait_for_successor(cell: fig_1.Cell, seed: int) -> Any:
        successors = is_written[int(cell.level) + 1 :]
        assert not successors or successors[0].wait(PATIENCE)
        return simulate(cell, seed)

    order: list[int] = []
    for name, n_threads in (("one", 1), ("six", 6)):
        store = CellStore(tmp_path / name, cells, {"a": 1})
        write = store.write
        store.write = lambda index, arrays, write=write: (  # type: ignore
            write(index, arrays), order.append(index), is_written[index].set()
        )  # fmt: skip
        with ThreadPoolExecutor(n_threads) as on:
            run_cells(fig_1, cells, 3, store, on)
        store.complete()
        monkeypatch.setattr(fig_1, "simulate", wait_for_successor)
        for event in is_written:
            event.clear()
    assert order == [0, 1, 2, 3, 4, 5, 5, 4, 3, 2, 1, 0]
    assert runs.contents(tmp_path / "one") == runs.contents(tmp_path / "six")


def test_seed_changes_the_numbers():
    cell, version = {"purpose": "p", "is_even": True, "level": 0.0}, code_version()
    one, same, other = (simulate_cell("slow_paper.fig_1", cell, seed, version)["mean"][1] for seed in (1, 1, 2))
    assert one == same != other


def test_linear_algebra_of_cells_takes_one_thread_and_gives_the_others_back(tmp_path: Path, monkeypatch):
    seen, cells = [], some_cells("nothing", "nothing")
    simulate = fig_1.simulate
    monkeypatch.setattr(fig_1, "simulate", lambda cell, seed: (seen.extend(threads()), simulate(cell, seed))[1])

    def threads() -> list[int]:
        return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]

    with threadpool_limits(2):
        before = threads()
        assert set(before) == {2}
        with executor(workers=1) as on:
            run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on)
        assert threads() == before
    assert seen
    assert set(seen) == {1}


def test_no_more_cells_are_handed_out_than_fit_the_window(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    n_cells = 12
    monkeypatch.setattr("insectnav.sweep.WINDOW", 5)
    cells, running, most = some_cells(*n_cells * ["nothing"]), 0, 0

    class Counting(ThreadPoolExecutor):
        def submit(self, function: Callable, /, *arguments: Any) -> Future:  # type: ignore[override]
            nonlocal running, most
            running += 1
            most = max(most, running)
            return super().submit(function, *arguments)

    def count(n_more: int) -> None:
        nonlocal running
        running -= n_more

    with Counting(2) as on:
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on, count)
    assert most == 5
    assert running == 0
    assert WINDOW > 100


# What goes wrong.


@pytest.mark.parametrize("workers", [1, 2])
def test_cell_that_raises_is_named_and_the_finished_stay(workers: int, tmp_path: Path):
    cells = some_cells("nothing", "nothing", "raises")
    store = CellStore(tmp_path, cells, {})
    told = r"^cell 3 of 3 \(purpose='some', is_even=True, level=2.0, .*does='raises'\): ZeroDivisionError: no such lev"
    with pytest.raises(CellError, match=told) as caught, executor(workers) as on:
        run_cells(fig_1, cells, 0, store, on)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert store.finished() <= {0, 1}
    assert workers == 2 or store.finished() == {0, 1}


def test_failure_keeps_what_is_done_and_cancels_the_rest(tmp_path: Path):
    cells = some_cells(*5 * ["nothing"])
    store, on = CellStore(tmp_path, cells, {}), ByHand(fails, gives_results, fails, gives_results)
    with pytest.raises(CellError, match=r"^cell 1 of 5 \(.*\): KeyError: 'by hand'$"):
        run_cells(fig_1, cells, 0, store, on)
    assert store.finished() == {1, 3}
    assert on.futures[4].cancelled()


def test_future_that_is_cancelled_is_told(tmp_path: Path):
    def cancel(future: Future) -> None:
        future.cancel()

    cells = some_cells("nothing", "nothing")
    on = ByHand(cancel)
    with pytest.raises(InputError, match=r"^the cluster gave up cell 1 of 2 \(.* go on with --resume$"):
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on)
    assert on.futures[1].cancelled()


def test_interruption_passes_and_cancels_the_rest(tmp_path: Path):
    def interrupt(n_more: int) -> None:
        if n_more:
            raise KeyboardInterrupt

    cells = some_cells("nothing", "nothing", "nothing")
    store, on = CellStore(tmp_path, cells, {}), ByHand(gives_results)
    with pytest.raises(KeyboardInterrupt):
        run_cells(fig_1, cells, 0, store, on, interrupt)
    assert store.finished() == {0}
    assert all(future.cancelled() for future in on.futures[1:])


def test_process_that_is_killed_is_told(tmp_path: Path):
    cells = some_cells("nothing", "dies", "nothing", "nothing")
    told = r"^a process that simulated cells was killed, .* --resume and fewer --workers$"
    with pytest.raises(InputError, match=told), executor(2) as on:
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on)
    assert len(CellStore(tmp_path, cells, {}).finished()) <= 3


def test_process_that_cannot_be_started_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: object) -> None:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr("multiprocessing.util.spawnv_passfds", refuse)
    cells = some_cells("nothing", "nothing")
    told = r"^no process could be started: Resource temp.*, expected room .* --resume and fewer --workers$"
    with pytest.raises(InputError, match=told), executor(2) as on:
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on)


def test_nobody_waits_for_cells_that_run_when_one_has_failed(tmp_path: Path):
    slow = fig_1.Cell(purpose="slow", is_even=True, level=0.0, seconds=10 * PATIENCE)
    cells = [slow, *some_cells("raises", seconds=0.5), *some_cells("nothing")]
    before = time.monotonic()
    with pytest.raises(CellError, match=r"^cell 2 of 3"), executor(2) as on:
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on)
    assert time.monotonic() - before < 5 * PATIENCE


def test_worker_with_other_code_is_refused(tmp_path: Path):
    class OldFashioned:
        def submit(self, function: Callable, /, *arguments: Any) -> Future:
            future: Future = Future()
            with pytest.raises(OtherCodeError) as caught:
                function(*arguments[:-1], "0123456789ab")
            future.set_exception(caught.value)
            return future

    cells = some_cells("nothing")
    told = rf"^a worker has insectnav {code_version()}, expected 0123456789ab as here: installed differently there, or"
    with pytest.raises(InputError, match=told):
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), OldFashioned())


def test_disk_that_is_full_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    cells = some_cells("nothing")
    monkeypatch.setattr("zarr.create_group", full)
    with pytest.raises(InputError, match=r"cannot be written \(No space left on device\)$"), executor(1) as on:
        run_cells(fig_1, cells, 0, CellStore(tmp_path, cells, {}), on)


# Executors.


@pytest.mark.parametrize("workers", [0, -1, True, 1.5, "two"])
def test_number_of_workers_that_cannot_be_is_refused(workers: Any):
    with pytest.raises(InputError, match=r"^workers is .*, expected a whole number of at least 1$"), executor(workers):
        pass


def test_one_worker_is_this_process():
    with executor(1) as on:
        assert on.submit(os.getpid).result() == os.getpid()


def test_several_workers_are_other_processes():
    with executor(2) as on:
        assert on.submit(os.getpid).result() != os.getpid()
