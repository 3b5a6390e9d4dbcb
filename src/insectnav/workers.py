"""What work is divided over: threads or processes of this machine, or a Dask cluster."""

import logging
import os
from collections.abc import Iterator
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
