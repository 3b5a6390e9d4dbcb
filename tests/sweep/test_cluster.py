"""A Dask cluster gives the same results as this process, and tells when it cannot."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from command_line import PATIENCE
from dask_cluster import dask_cluster, kill, wait_for
from insectnav.checks import InputError
from insectnav.experiments.store import CellStore
from insectnav.sweep import CellError, executor, run_cells, run_experiment
from slow_paper import fig_1, runs


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("insectnav.workers.CONNECT_SECONDS", PATIENCE)


@pytest.mark.slow
@pytest.mark.usefixtures("patient")
def test_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    finished = 0
    monkeypatch.setenv(fig_1.PACE, "0.3")
    with dask_cluster(tmp_path / "cluster", n_workers=2) as cluster:

        def count(n_more: int) -> None:
            nonlocal finished
            finished += n_more
            if finished == 5:
                kill(cluster.processes[-1])

        with executor(cluster=cluster.address) as on:
            done = run_experiment(fig_1, "slow", tmp_path / "cluster-run", on=on, progress=count)
        wait_for(lambda: "Remove worker" in cluster.log(0))
    assert finished == done.n_cells == runs.N_CELLS
    monkeypatch.setenv(fig_1.PACE, "0")
    assert runs.contents(done.folder) == runs.contents(runs.run_here(tmp_path / "local"))


@pytest.mark.slow
@pytest.mark.usefixtures("patient")
def test_cluster_tells_what_went_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A cell that raises, one that takes its worker with it, a scheduler that dies: all end the run with a message."""
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")

    def run(*cells: fig_1.Cell, progress: Callable[[int], object] | None = None) -> CellStore:
        store = CellStore(tmp_path / str(time.monotonic_ns()), cells, {})
        with executor(cluster=cluster.address) as on:
            run_cells(fig_1, cells, 0, store, on, progress)
        return store

    with dask_cluster(tmp_path / "cluster", n_workers=1) as cluster:
        with pytest.raises(CellError, match=r"^cell 2 of 2 \(.*does='raises'\): ZeroDivisionError: no such level$"):
            run(*some_cells("nothing", "raises"))
        assert len(run(*some_cells("nothing", "nothing")).finished()) == 2
        with pytest.raises(CellError, match=r"^cell 1 of 1 \(.*does='dies'\): KilledWorker: "):
            run(*some_cells("dies"))
        cluster.add_worker()
        cluster.wait_for_workers()

        def lose_scheduler(n_more: int) -> None:
            if n_more:
                kill(cluster.processes[0])

        slow = [fig_1.Cell(purpose="slow", is_even=True, level=float(i), seconds=i * fig_1.FOREVER) for i in range(9)]
        with pytest.raises(InputError, match=r"^the cluster gave up cell . of 9 \(.*expected its scheduler to live"):
            run(*slow, progress=lose_scheduler)


def some_cells(*deeds: str) -> Sequence[fig_1.Cell]:
    """Cells that do these things."""
    return [fig_1.Cell(purpose="some", is_even=True, level=float(i), does=does) for i, does in enumerate(deeds)]


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "127.0.0.1:1", "carrier-pigeon://home", "tcp://127.0.0.1:x"])
def test_cluster_that_is_not_there_is_told(address: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("insectnav.workers.CONNECT_SECONDS", 0.5)
    with pytest.raises(InputError, match=r"^no Dask scheduler answers at '") as caught, executor(cluster=address):
        pass
    assert "\n" not in str(caught.value)


def test_dask_that_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    told = r"^a cluster needs Dask, which is not installed: pip install insectnav\[cluster\]$"
    with pytest.raises(InputError, match=told), executor(cluster="tcp://127.0.0.1:8786"):
        pass


def test_workers_of_a_cluster_are_its_own():
    with pytest.raises(InputError, match=r"both workers and cluster are given"), executor(2, "tcp://127.0.0.1:8786"):
        pass
