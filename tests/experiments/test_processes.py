"""Processes that are killed, ended in the middle of what they send, or asked for what they cannot do."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import psutil
import pytest

from command_line import NEEDS_POSIX, PATIENCE, until
from dask_cluster import environment
from insectnav.experiments.executors import executor
from insectnav.experiments.processes import NotStartedError, Processes

LARGE = 10_000_000  # numbers: far more than a pipe holds
UNGUARDED = """
from insectnav.experiments.executors import executor
with executor(2) as on:
    on.submit(abs, -1).result()
"""
MASKED = """
import signal
from insectnav.experiments.executors import executor
if __name__ == "__main__":
    with executor(2) as on:
        print(signal.SIGINT in on.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result())
        print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))
"""

LEFT = """
import os, signal, threading, time
from insectnav.experiments.executors import executor
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with executor(2) as on:
            futures = [on.submit(time.sleep, 3000.0) for _ in range(3)]
            threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    except KeyboardInterrupt:
        long = time.monotonic() + 100.0
        while not all(future.done() for future in futures) and time.monotonic() < long:
            time.sleep(0.01)  # until the thread whose end was waited for has told of it
        print("interrupted", [future.done() for future in futures])
"""


def identity(number: int) -> tuple[int, int]:
    return number, os.getpid()


def large(n: int) -> np.ndarray:
    return np.ones(n)


def start_and_sleep(path: Path) -> None:
    path.touch()
    time.sleep(10 * PATIENCE)


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fail(number: int) -> None:
    raise ZeroDivisionError(f"no {number}")


def leave() -> None:
    sys.exit(3)


def unsendable() -> object:
    return lambda: None


class StrangeError(Exception):
    """An error that is sent, and cannot be made anew from what was sent."""

    def __init__(self, one: int, two: int) -> None:
        super().__init__(f"{one} {two}")


class UnsendableError(Exception):
    """An error that cannot be sent."""

    def __reduce__(self) -> str:
        raise OSError("stays here")


def fail_strangely(error: str) -> None:
    raise StrangeError(1, 2) if error == "strange" else UnsendableError(3)


class Unmakable:
    """It is sent, and cannot be made anew from what was sent."""

    def __reduce__(self) -> tuple:
        return fail, (7,)


def children() -> set[psutil.Process]:
    """Processes below this one, but for the one that keeps account of semaphores for all."""
    found = set()
    for process in psutil.Process().children():
        try:
            if "resource_tracker" not in " ".join(process.cmdline()):
                found.add(process)
        except psutil.NoSuchProcess:  # it has just ended
            pass
    return found


@pytest.fixture
def n_processes():
    """Counts the processes that the test has started; none of them outlives it."""
    before = children()
    yield lambda: len(children() - before)
    assert children() <= before


def test_results_come_from_as_many_processes_as_are_needed(n_processes: Callable):
    with executor(2) as on:
        assert on.submit(identity, 0).result(PATIENCE)[1] == on.submit(identity, 1).result(PATIENCE)[1] != os.getpid()
        assert n_processes() == 1
        results = [future.result(PATIENCE) for future in [on.submit(identity, number) for number in range(40)]]
    assert [number for number, _ in results] == list(range(40))
    assert len({process for _, process in results}) <= 2


def test_error_comes_with_the_frames_of_the_other_process(n_processes: Callable):
    with executor(2) as on:
        for number in range(5):
            with pytest.raises(ZeroDivisionError, match=f"no {number}") as caught:
                on.submit(fail, number).result(PATIENCE)
            assert "in fail" in caught.value.__notes__[0]
        with pytest.raises(SystemExit, match="3"):
            on.submit(leave).result(PATIENCE)
        assert on.submit(identity, 5).result(PATIENCE)[0] == 5
        assert n_processes() == 1


def test_what_cannot_come_back_is_told_in_words(n_processes: Callable):
    with executor(2) as on:
        for error, words in (("strange", "StrangeError: 1 2"), ("unsendable", "UnsendableError: 3")):
            with pytest.raises(TypeError, match=f"^an error cannot be sent: {words}\n") as caught:
                on.submit(fail_strangely, error).result(PATIENCE)
            assert "in fail_strangely" in caught.value.__notes__[0]
        for function in (unsendable, partial(unsendable)):
            with pytest.raises(TypeError, match=r"^a result cannot be sent: .*lambda"):
                on.submit(function).result(PATIENCE)
        assert on.submit(identity, 5).result(PATIENCE)[0] == 5
        assert n_processes() == 1


def test_what_cannot_be_sent_takes_no_process(n_processes: Callable):
    with executor(2) as on:
        for _ in range(3):
            with pytest.raises((AttributeError, TypeError), match="lambda"):
                on.submit(identity, lambda: None).result(PATIENCE)
        assert n_processes() == 0
        for _ in range(3):
            with pytest.raises(ZeroDivisionError, match="no 7"):
                on.submit(identity, Unmakable()).result(PATIENCE)
        assert on.submit(identity, 5).result(PATIENCE)[0] == 5
        assert n_processes() == 1


def test_killed_process_is_told_of_and_replaced(n_processes: Callable):
    with executor(2) as on:
        futures = [on.submit(die), on.submit(identity, 1)]
        with pytest.raises(BrokenExecutor, match="a process was killed"):
            futures[0].result(PATIENCE)
        assert futures[1].result(PATIENCE)[0] == 1
        assert on.submit(identity, 2).result(PATIENCE)[0] == 2


def test_process_that_cannot_be_started_is_told_of(n_processes: Callable, monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: object) -> None:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    gc.collect()
    n_open = psutil.Process().num_fds()
    with executor(2) as on:
        with monkeypatch.context() as patch:
            patch.setattr("multiprocessing.util.spawnv_passfds", refuse)
            for _ in range(3):
                with pytest.raises(NotStartedError, match=r"temporarily unavailable$"):
                    on.submit(identity, 1).result(PATIENCE)
        gc.collect()
        assert psutil.Process().num_fds() <= n_open  # pipes are closed
        assert on.submit(identity, 2).result(PATIENCE)[0] == 2


@pytest.mark.parametrize("cancelled", [False, True])
def test_block_that_fails_ends_what_is_running_and_forgets_what_is_not(
    cancelled: bool, n_processes: Callable, tmp_path: Path
):
    started = time.monotonic()
    with pytest.raises(KeyError), executor(2) as on:
        futures = [on.submit(start_and_sleep, tmp_path / str(number)) for number in range(6)]
        until(lambda: len(list(tmp_path.iterdir())) == 2)
        if cancelled:
            for future in futures:
                future.cancel()
        raise KeyError
    assert time.monotonic() - started < 5 * PATIENCE  # half of what it takes to wait for one of them
    assert len(list(tmp_path.iterdir())) == 2
    assert all(future.done() for future in futures)


def test_process_is_ended_in_the_middle_of_what_it_sends(n_processes: Callable, monkeypatch: pytest.MonkeyPatch):
    receive, has_begun = Connection._recv, threading.Event()

    def tell(self: Connection, size: int, *more: object) -> object:
        if size > LARGE:
            has_begun.set()
        return receive(self, size, *more)

    monkeypatch.setattr(Connection, "_recv", tell)
    with pytest.raises(KeyError), executor(2) as on:
        for _ in range(4):
            on.submit(large, LARGE)
        assert has_begun.wait(PATIENCE)
        raise KeyError


def test_nothing_starts_after_the_end():
    processes = Processes(2)
    processes.end()
    with pytest.raises(RuntimeError):
        processes.submit(identity, 0)
    with pytest.raises(BrokenExecutor, match="were ended"):
        processes._take()  # what a thread does that had its task just before
    processes.close()


def run_script(tmp_path: Path, text: str) -> subprocess.CompletedProcess:
    (tmp_path / "script.py").write_text(text)
    line = [sys.executable, "script.py"]
    return subprocess.run(line, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=PATIENCE)


@NEEDS_POSIX
def test_interrupts_of_the_keyboard_do_not_reach_the_first_process_even_while_it_starts(tmp_path: Path):
    """As the first, it comes with the process that keeps account of semaphores."""
    done = run_script(tmp_path, MASKED)
    assert (done.returncode, done.stdout.split(), done.stderr) == (0, ["True", "False"], "")


@NEEDS_POSIX
def test_interrupt_while_the_end_of_what_is_running_is_waited_for_ends_it(tmp_path: Path):
    done = run_script(tmp_path, LEFT)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted [True, True, True]\n", "")


def test_program_that_would_run_itself_in_each_process_ends_and_says_why(tmp_path: Path):
    done = run_script(tmp_path, UNGUARDED)
    assert done.returncode != 0
    assert "if __name__ == '__main__'" in done.stderr
    assert "BrokenExecutor: a process was killed" in done.stderr
