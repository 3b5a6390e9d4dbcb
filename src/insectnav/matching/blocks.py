"""Work on blocks of frames, on several threads; how many there are changes nothing in the results."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from insectnav.workers import count_workers


def run_blocks(task: Callable[[int, int], None], n: int, size: int, workers: int | None = None) -> None:
    """Run ``task(first, last)`` over 0…n in blocks of a size that does not depend on the number of threads.

    Parameters
    ----------
    task : what to do with the frames from first up to last; compiled code lets other threads run
    n : number of frames
    size : frames in a block
    workers : threads; None for as many as there are cores
    """
    workers = count_workers(workers)
    blocks = [(first, min(first + size, n)) for first in range(0, n, size)]
    if workers == 1 or len(blocks) < 2:
        for block in blocks:
            task(*block)
        return
    with ThreadPoolExecutor(min(workers, len(blocks))) as pool:
        for _ in pool.map(lambda block: task(*block), blocks):
            pass
