"""A run that is killed goes on where it stopped, and ends with the same bytes."""

import json
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from math import inf
from pathlib import Path

import psutil
import pytest

from command_line import PATIENCE, is_alive
from dask_cluster import kill, wait_for
from insectnav.experiments.results import PROVENANCE
from slow_paper import fig_1, runs


@contextmanager
def started(out: Path, *options: str, hold: float = inf) -> Iterator[tuple]:
    """A run and the processes below it; none is left when the block ends."""
    process = runs.start(out, *options, hold=hold)
    family = psutil.Process(process.pid)
    below: set[psutil.Process] = set()
    try:
        yield process, lambda: below.update(family.children(recursive=True)) or below
    finally:
        kill(process)
        for child in below:
            with suppress(psutil.NoSuchProcess):
                child.kill()
        process.stderr.close()


@pytest.mark.slow
def test_killed_run_goes_on_and_ends_with_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Killed twice, with two processes and with one, then finished with two again."""
    out = tmp_path / "killed"
    last = 0
    for n_more, options, hold in ((3, ["--workers", "2"], 4), (2, ["--workers", "1", "--resume"], 7)):
        with started(out, *options, hold=hold) as (process, children):
            wait_for(lambda: runs.n_finished(out) >= last + n_more, process)  # noqa: B023
            orphans = set(children())
            kill(process)
            wait_for(lambda: not any(is_alive(child) for child in orphans))  # noqa: B023
        last = runs.n_finished(out)
        assert last < runs.N_CELLS
        assert not list(out.glob("slow/[!.]*"))  # nothing that looks like results

    with started(out, "--workers", "2", "--resume") as (process, _):
        assert process.wait(PATIENCE) == 0, process.stderr.read()
    (folder,) = (out / "slow").iterdir()
    assert sorted(path.name for path in folder.iterdir()) == runs.FILES
    made = json.loads((folder / PROVENANCE).read_text())
    assert made["cells_from_earlier_run"] == last
    assert made["command"][-3:] == ["--workers", "2", "--resume"]

    monkeypatch.setenv(fig_1.PACE, "0")
    expected = runs.contents(runs.run_here(tmp_path / "whole"))
    assert runs.contents(folder) == expected
    assert sum(name.startswith("data.zarr/") for name in expected) > 4 * runs.N_CELLS // 2


@pytest.mark.parametrize("workers", ["1", "2"])
def test_interrupted_run_ends_at_once_and_keeps_what_is_finished(workers: str, tmp_path: Path):
    with started(tmp_path, "--workers", workers, hold=4) as (process, children):
        wait_for(lambda: runs.n_finished(tmp_path) >= 2, process)
        orphans = set(children())
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) != 0
        said = process.stderr.read()
        assert said.rstrip().endswith("KeyboardInterrupt")
        assert said.count("Traceback") == 1  # of this process alone
        wait_for(lambda: not any(is_alive(child) for child in orphans))
    assert 2 <= runs.n_finished(tmp_path) < runs.N_CELLS
