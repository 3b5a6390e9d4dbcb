"""Work on several threads: every item once, progress in order, and what goes wrong comes out."""

import threading

import pytest

from command_line import PATIENCE
from insectnav.checks import InputError
from insectnav.workers import run_blocks


@pytest.mark.parametrize("workers", [1, 2, 3, None])
@pytest.mark.parametrize(("n", "size"), [(0, 4), (1, 4), (4, 4), (9, 4), (7, 1)])
def test_every_item_is_worked_on_once_in_blocks_of_the_size(n: int, size: int, workers: int | None):
    blocks: list[tuple[int, int]] = []
    finished: list[int] = []
    run_blocks(lambda first, last: blocks.append((first, last)), n, size, workers, finished.append)
    assert [k for first, last in sorted(blocks) for k in range(first, last)] == list(range(n))
    assert finished == [size] * (n // size) + [n % size] * (n % size > 0)


def test_blocks_are_worked_on_at_the_same_time():
    meeting = threading.Barrier(2, timeout=PATIENCE)  # broken unless two wait at it at once
    run_blocks(lambda first, last: meeting.wait(), 4, 1, 2)


def test_one_thread_is_that_of_the_caller():
    threads: set[int] = set()
    run_blocks(lambda first, last: threads.add(threading.get_ident()), 5, 1, 1)
    assert threads == {threading.get_ident()}


@pytest.mark.parametrize("workers", [1, 2])
def test_what_goes_wrong_in_a_block_comes_out(workers: int):
    def fail(first: int, last: int) -> None:
        if first == 2:
            raise ArithmeticError("block 2")

    with pytest.raises(ArithmeticError, match="block 2"):
        run_blocks(fail, 4, 1, workers)


@pytest.mark.parametrize("workers", [0, -1, 1.5])
def test_number_of_threads_is_checked(workers: float):
    with pytest.raises(InputError, match="workers"):
        run_blocks(lambda first, last: None, 1, 1, workers)  # type: ignore[arg-type]
