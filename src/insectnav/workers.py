"""How many threads or processes work is divided over."""

import os

from insectnav.checks import check_count


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
