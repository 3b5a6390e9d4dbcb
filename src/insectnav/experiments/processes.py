"""Processes of this machine that run functions, and end at once when they are told to."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from multiprocessing.connection import Connection
from typing import Any, cast


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
        self._threads = ThreadPoolExecutor(n_workers)
        self._lock = threading.Lock()
        self._all: list[Worker] = []
        self._idle: list[Worker] = []
        self._is_ended = False

    def submit(self, function: Callable, /, *arguments: Any) -> Future:
        """A future, of `BrokenExecutor` where its process is killed; function, arguments and result are pickled."""
        return self._threads.submit(self._call, function, arguments)

    def end(self) -> None:
        """End all processes at once, whatever they are doing."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._is_ended = True
            for worker in self._all:
                worker.process.terminate()

    def close(self) -> None:
        """Wait for what is running, and for the processes to end."""
        self._threads.shutdown(cancel_futures=True)
        for worker in self._all:
            worker.pipe.close()
            worker.process.join()

    def _call(self, function: Callable, arguments: tuple) -> Any:
        worker = self._take()
        result = worker.call(function, arguments)  # one that was killed is not taken again
        with self._lock:
            self._idle.append(worker)
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
    """A process that runs one function after the other, and this end of its pipe."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")  # not forked: threads of compiled code do not survive that
        self.pipe, its_pipe = context.Pipe()
        self.process = context.Process(target=_serve, args=(its_pipe,))
        _leave_interrupts_to_main_thread()
        self.process.start()
        its_pipe.close()

    def call(self, function: Callable, arguments: tuple) -> Any:
        """What the function returns there, or the `Failure` that it ends with.

        Raises
        ------
        BrokenExecutor
            If the process dies.
        """
        try:
            self.pipe.send((function, arguments))
            return self.pipe.recv()
        except (EOFError, OSError) as error:
            raise BrokenExecutor("a process was killed") from error


class Failure:
    """An error on its way from one process to another."""

    def __init__(self, error: Exception) -> None:
        self.error = error


def _leave_interrupts_to_main_thread() -> None:
    """Ctrl-C does not reach this thread, nor a process that it starts: not even before that can ignore it."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _serve(pipe: Connection) -> None:
    """Run what comes through the pipe until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it cannot be blocked
    threading.Thread(target=_follow_parent, daemon=True).start()
    while True:
        try:
            function, arguments = pipe.recv()
        except EOFError:
            return
        try:
            result = function(*arguments)
        except Exception as error:
            error.add_note(traceback.format_exc())  # the frames of another process are not sent
            result = Failure(error)
        try:
            pipe.send(result)
        except OSError:  # nobody listens any more
            return
        except Exception as error:
            pipe.send(Failure(TypeError(f"what {function.__name__} returned cannot be sent: {error}")))


def _follow_parent() -> None:
    """End with the parent however it ends."""
    cast(Any, multiprocessing.parent_process()).join()
    os._exit(1)
