"""Processes of this machine that run functions, and end at once when they are told to."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future
from contextlib import suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any, cast

from insectnav.workers import Threads

BROKEN_PIPE = (EOFError, OSError)  # what a pipe raises whose other end is gone


class NotStartedError(BrokenExecutor):
    """The system has no room for another process."""


class Processes:
    """An executor of processes, started as they are needed.

    Each has a pipe of its own, which breaks when it dies, and a thread here that listens. Those of the standard
    library share one pipe, of which this process holds an end: when one is ended while it sends its results, the rest
    of them is waited for forever.

    Parameters
    ----------
    n_workers : int
        Calls that run at the same time.
    """

    def __init__(self, n_workers: int) -> None:
        self._threads = Threads(n_workers)
        self._lock = threading.Lock()
        self._all: list[Worker] = []
        self._idle: list[Worker] = []
        self._is_ended = False

    def submit(self, function: Callable, /, *arguments: Any) -> Future:
        """A future, of `BrokenExecutor` where its process is killed; function, arguments and result are pickled."""
        return self._threads.submit(self._call, function, arguments)

    def end(self) -> None:
        """End all processes at once, whatever they are doing; what was asked of them is then over, too."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._is_ended = True
            for worker in self._all:
                worker.process.kill()
        self._threads.shutdown()

    def close(self) -> None:
        """Wait for what is running, and for the processes to end."""
        self._threads.shutdown(cancel_futures=True)
        for worker in self._all:
            worker.pipe.close()
        for worker in self._all:
            worker.process.join()

    def _call(self, function: Callable, arguments: tuple) -> Any:
        task = ForkingPickler.dumps((function, arguments))
        worker = self._take()
        answer = worker.call(task)  # one that was killed is not taken again
        with self._lock:
            self._idle.append(worker)
        result = ForkingPickler.loads(answer)
        if isinstance(result, Failure):
            raise result.error
        return result

    def _take(self) -> Worker:
        with self._lock:
            if self._is_ended:
                raise BrokenExecutor("the processes were ended")
            if not self._idle:
                self._all.append(Worker())
                return self._all[-1]
            return self._idle.pop()


class Worker:
    """A process that runs one function after the other, and this end of its pipe.

    Raises
    ------
    NotStartedError
        If the system refuses to start one.
    """

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")  # not forked: threads of compiled code do not survive that
        try:
            _leave_interrupts_to_main_thread()
            self.pipe, its_pipe = context.Pipe()
            with its_pipe:
                self.process = context.Process(target=_serve, args=(its_pipe,))
                self.process.start()
        except OSError as error:
            raise NotStartedError(f"no process could be started: {error.strerror}") from error

    def call(self, task: memoryview) -> bytes:
        """What comes of a pickled task, pickled: what its function returns, or the `Failure` that it ends with.

        Raises
        ------
        BrokenExecutor
            If the process dies.
        """
        try:
            self.pipe.send_bytes(task)
            return self.pipe.recv_bytes()
        except BROKEN_PIPE as error:
            raise BrokenExecutor("a process was killed") from error


class Failure:
    """An error on its way from one process to another."""

    def __init__(self, error: BaseException) -> None:
        self.error = error


def _leave_interrupts_to_main_thread() -> None:
    """Ctrl-C does not reach this thread, nor a process that it starts: not even before that can ignore it."""
    resource_tracker.ensure_running()  # else it is started with the process, and lets interrupts through again
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _serve(pipe: Connection) -> None:
    """Do what comes through the pipe until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it cannot be blocked
    threading.Thread(target=_follow_parent, daemon=True).start()
    with suppress(*BROKEN_PIPE):  # nobody asks, or listens, any more
        while True:
            pipe.send_bytes(_answer(pipe.recv_bytes()))


def _answer(task: bytes) -> memoryview:
    """What comes of a task; errors have a note of their frames, which are not sent to another process."""
    try:
        function, arguments = ForkingPickler.loads(task)
        result = function(*arguments)
    except (Exception, SystemExit) as error:
        error.add_note(traceback.format_exc())
        return _pickled_failure(error)
    try:
        return ForkingPickler.dumps(result)
    except Exception as error:
        return _pickled_failure(TypeError(f"a result cannot be sent: {error}"))


def _pickled_failure(error: BaseException) -> memoryview:
    """The error as it can be made anew there, or one that tells of it."""
    try:
        pickled = ForkingPickler.dumps(Failure(error))
        ForkingPickler.loads(pickled)
        return pickled
    except Exception:
        told = TypeError(f"an error cannot be sent: {type(error).__name__}: {error}")
        told.__notes__ = [str(note) for note in error.__notes__]
        return ForkingPickler.dumps(Failure(told))


def _follow_parent() -> None:
    """End with the parent however it ends."""
    cast(Any, multiprocessing.parent_process()).join()
    os._exit(1)
