"""A Dask scheduler and its workers, as processes of this machine that a test may kill."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from command_line import PATIENCE

TESTS = Path(__file__).resolve().parent
LOCAL = ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0", "--no-dashboard"]


def environment() -> dict[str, str]:
    """That of this process, with the tests' own modules and any path that this process imports from."""
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *filter(None, sys.path)])}


def wait_for(what: Callable[[], object], process: subprocess.Popen | None = None) -> None:
    """Until it is true; fails when the time is up or the process, which must not end before, has ended."""
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end, "this takes too long"
        assert process is None or process.poll() is None, f"the process ended early ({process.returncode})"
        time.sleep(0.02)


def kill(process: subprocess.Popen) -> None:
    """End it without warning, and wait until it is gone; nothing if it has ended."""
    process.send_signal(signal.SIGKILL)
    process.wait(PATIENCE)


class DaskCluster:
    """A scheduler on the loopback interface and its workers.

    Parameters
    ----------
    folder : Path
        For what they write.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.processes: list[subprocess.Popen] = []  # the scheduler, then the workers
        file = folder / "scheduler.json"
        self._start("scheduler", "--port", "0", "--scheduler-file", str(file))
        wait_for(lambda: file.is_file() and file.read_text().endswith("}"), self.processes[0])
        self.address = str(json.loads(file.read_text())["address"])

    def add_worker(self) -> None:
        """One more worker of one thread, without a nanny that would replace it when it is killed."""
        name = f"worker-{len(self.processes)}"
        options = ["--nthreads", "1", "--no-nanny", "--name", name, "--local-directory", str(self._folder / name)]
        self._start("worker", self.address, *options, "--death-timeout", str(PATIENCE))

    def wait_for_workers(self) -> None:
        """Until each has been heard of by the scheduler."""
        for number, process in list(enumerate(self.processes))[1:]:
            wait_for(lambda: "Registered to" in self.log(number), process)  # noqa: B023

    def _start(self, kind: str, *options: str) -> None:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *options, *LOCAL]
        with (self._folder / f"{kind}-{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self._folder, env=environment())
        self.processes.append(process)

    def log(self, number: int) -> str:
        """What a process has said: 0 is the scheduler, then come the workers."""
        (path,) = self._folder.glob(f"*-{number}.log")
        return path.read_text(errors="replace")


@contextmanager
def dask_cluster(folder: Path, n_workers: int) -> Iterator[DaskCluster]:
    """A cluster that is complete when the block begins, and gone when it ends."""
    folder.mkdir()
    cluster = DaskCluster(folder)
    try:
        for _ in range(n_workers):
            cluster.add_worker()
        cluster.wait_for_workers()
        yield cluster
    finally:
        for process in reversed(cluster.processes):
            kill(process)
