"""What work is divided over: threads or processes of this machine, or a Dask cluster."""

import logging
import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from insectnav.checks import InputError, check_count, quoted

CONNECT_SECONDS = 10.0


def count_workers(workers: int | None) -> int:
    """The number asked for, or one for each core that this process may use.

    Raises
    ------
    InputError
        If it is not a whole number of at least 1.
    """
    if workers is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    check_count("workers", workers)
    return workers


class Threads(ThreadPoolExecutor):
    """A pool of threads none of which is at work any more when it has been shut down, whatever has interrupted it.

    That of the standard library does not know of a thread until it has waited for its start, and takes one for ended
    when the wait for its end is interrupted, by Ctrl-C for instance: such a thread goes on writing to a folder that is
    being removed.
    """

    def __init__(self, n_threads: int) -> None:
        super().__init__(n_threads)
        self._calls = threading.Condition()
        self._n_running = 0
        self._is_over = False

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future:
        """As of any executor."""
        return super().submit(self._call, function, arguments, options)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """As of any executor."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        if wait:
            with self._calls:
                self._is_over = True
                self._calls.wait_for(lambda: self._n_running == 0)

    def _call(self, function: Callable[..., Any], arguments: tuple, options: dict[str, Any]) -> Any:
        with self._calls:
            if self._is_over:
                raise CancelledError
            self._n_running += 1
        try:
            return function(*arguments, **options)
        finally:
            with self._calls:
                self._n_running -= 1
                self._calls.notify_all()


def run_blocks(
    task: Callable[[int, int], object],
    n: int,
    size: int,
    workers: int | None = None,
    progress: Callable[[int], object] | None = None,
) -> None:
    """Run ``task(first, last)`` over 0…n in blocks of a size that does not depend on the number of threads.

    Parameters
    ----------
    task : what to do with the items from first up to last; compiled code lets other threads run
    n : number of items
    size : items in a block
    workers : threads; None for as many as there are cores
    progress : called with the number of items finished at a time, in their order
    """
    workers = count_workers(workers)
    blocks = [(first, min(first + size, n)) for first in range(0, n, size)]

    def report(first: int, last: int) -> None:
        if progress is not None:
            progress(last - first)

    if workers == 1 or len(blocks) < 2:
        for block in blocks:
            task(*block)
            report(*block)
        return
    with ThreadPoolExecutor(min(workers, len(blocks))) as pool:
        for block, _ in zip(blocks, pool.map(lambda block: task(*block), blocks), strict=True):
            report(*block)


@contextmanager
def cluster_client(address: str) -> Iterator[Any]:
    """A client of the Dask cluster at an address such as "tcp://127.0.0.1:8786".

    Raises
    ------
    InputError
        If there is no such cluster, or Dask is not installed.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("a cluster needs Dask, which is not installed: pip install insectnav[cluster]") from None
    logger = logging.getLogger("distributed.client")
    level = logger.level
    logger.setLevel(logging.CRITICAL)  # what it would tell of a lost scheduler in a traceback, an error tells as well
    try:
        client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = type(error).__name__
        raise InputError(
            f"no Dask scheduler answers at {quoted(address)} ({reason}), expected as in tcp://host:8786"
        ) from None
    else:
        with client:
            yield client
    finally:
        logger.setLevel(level)
