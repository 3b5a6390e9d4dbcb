"""Processes that are killed, ended in the middle of what they send, or asked for what they cannot do."""

import os
import signal
import time
from concurrent.futures import BrokenExecutor
from pathlib import Path

import numpy as np
import psutil
import pytest

from insectnav.experiments.executors import executor
from insectnav.experiments.processes import Processes

PATIENCE = 60.0  # seconds; nothing here takes a tenth of it
LARGE = 30_000_000  # numbers: far more than a pipe holds, and a while to send


def identity(number: int) -> tuple[int, int]:
    return number, os.getpid()


def large(n: int) -> np.ndarray:
    return np.ones(n)


def start_and_sleep(path: Path) -> None:
    path.touch()
    time.sleep(PATIENCE)


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fail(number: int) -> None:
    raise ZeroDivisionError(f"no {number}")


def unsendable() -> object:
    return lambda: None


class StrangeError(Exception):
    """An error that is sent, and cannot be made anew from what was sent."""

    def __init__(self, one: int, two: int) -> None:
        super().__init__(f"{one} {two}")


def fail_strangely() -> None:
    raise StrangeError(1, 2)


def children() -> list[psutil.Process]:
    """Processes below this one, but for the one that keeps account of semaphores for all."""
    return [one for one in psutil.Process().children() if "resource_tracker" not in " ".join(one.cmdline())]


@pytest.fixture
def alone():
    """No process that was not here before is left by the test."""
    before = set(children())
    yield
    assert set(children()) <= before


@pytest.mark.usefixtures("alone")
def test_results_come_from_as_many_processes_as_are_needed():
    with executor(2) as on:
        assert on.submit(identity, 0).result(PATIENCE)[1] == on.submit(identity, 1).result(PATIENCE)[1] != os.getpid()
        assert len(children()) == 1
        results = [future.result(PATIENCE) for future in [on.submit(identity, number) for number in range(40)]]
    assert [number for number, _ in results] == list(range(40))
    assert len({process for _, process in results}) <= 2


@pytest.mark.usefixtures("alone")
def test_error_comes_with_the_frames_of_the_other_process():
    with executor(2) as on:
        with pytest.raises(ZeroDivisionError, match="no 3") as caught:
            on.submit(fail, 3).result(PATIENCE)
        assert "in fail" in caught.value.__notes__[0]
        with pytest.raises(TypeError, match="two"):
            on.submit(fail_strangely).result(PATIENCE)
        with pytest.raises(TypeError, match=r"^what unsendable returned cannot be sent: "):
            on.submit(unsendable).result(PATIENCE)
        assert on.submit(identity, 5).result(PATIENCE)[0] == 5


@pytest.mark.usefixtures("alone")
def test_killed_process_is_told_of_and_replaced():
    with executor(2) as on:
        futures = [on.submit(die), on.submit(identity, 1)]
        with pytest.raises(BrokenExecutor, match="a process was killed"):
            futures[0].result(PATIENCE)
        assert futures[1].result(PATIENCE)[0] == 1
        assert on.submit(identity, 2).result(PATIENCE)[0] == 2


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("cancelled", [False, True])
def test_block_that_fails_ends_what_is_running_and_forgets_what_is_not(cancelled: bool, tmp_path: Path):
    started = time.monotonic()
    with pytest.raises(KeyError), executor(2) as on:
        futures = [on.submit(start_and_sleep, tmp_path / str(number)) for number in range(6)]
        while len(list(tmp_path.iterdir())) < 2:
            time.sleep(0.01)
        if cancelled:
            for future in futures:
                future.cancel()
        raise KeyError
    assert time.monotonic() - started < PATIENCE / 2
    assert len(list(tmp_path.iterdir())) == 2
    assert all(future.done() for future in futures)


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.2])
def test_process_is_ended_in_the_middle_of_what_it_sends(seconds: float):
    with pytest.raises(KeyError), executor(2) as on:
        assert len(on.submit(large, 1).result(PATIENCE)) == 1
        for _ in range(8):
            on.submit(large, LARGE)
        time.sleep(seconds)
        raise KeyError


def test_nothing_starts_after_the_end():
    processes = Processes(2)
    processes.end()
    with pytest.raises(RuntimeError):
        processes.submit(identity, 0)
    with pytest.raises(BrokenExecutor, match="were ended"):
        processes._take()  # what a thread does that had its task just before
    processes.close()
