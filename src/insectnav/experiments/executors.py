"""Where cells are simulated: this process, processes of this machine, or a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol

from insectnav.checks import InputError
from insectnav.workers import cluster_client, count_workers


class Executor(Protocol):
    """Anything that runs functions elsewhere: a pool of `concurrent.futures`, a client of Dask.

    An executor may have a ``window``: how many cells it is handed at a time.
    """

    def submit(self, function: Callable, /, *arguments: Any) -> Any:
        """A future with ``result()``, ``cancel()`` and ``add_done_callback()``."""


class HereAndNow:
    """An executor that runs everything in this process, at once."""

    window = 1  # a cell is on disk before the next begins

    def submit(self, function: Callable, /, *arguments: Any) -> Any:
        """A future that is done."""
        from concurrent.futures import Future

        future: Future = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


class Cluster:
    """A Dask cluster as an executor.

    Parameters
    ----------
    client : distributed.Client
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, function: Callable, /, *arguments: Any) -> Any:
        """A future of the cluster, shared with no other run: not even its failure is."""
        return self._client.submit(function, *arguments, pure=False)


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

    Notes
    -----
    A block that ends with an error ends local processes at once; they also end with the process that started them.
    """
    n_workers = count_workers(workers)
    if cluster is not None:
        if workers is not None:
            raise InputError("both workers and cluster are given, expected one: the cluster has workers of its own")
        with cluster_client(cluster) as client:
            yield Cluster(client)
    elif n_workers == 1:
        yield HereAndNow()
    else:
        with _processes(n_workers) as pool:
            yield pool


@contextmanager
def _processes(n_workers: int) -> Iterator[Executor]:
    from insectnav.experiments.processes import Processes

    pool = Processes(n_workers)
    try:
        yield pool
        pool.close()
    except BaseException:  # also of the keyboard, while the end is waited for
        pool.end()  # cells may take long: nobody waits for them
        pool.close()
        raise
