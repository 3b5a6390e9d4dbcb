"""Work on pictures by several threads, in order, and left off at any time."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from command_line import PATIENCE
from insectnav.experiments import picture_sources
from insectnav.experiments.picture_sources import in_order


@pytest.mark.parametrize("n_threads", [1, 3])
def test_results_come_in_the_order_of_the_items_and_few_are_held(n_threads: int):
    taken: list[int] = []
    results = in_order(lambda k: -k, (taken.append(k) or k for k in range(50)), n_threads)
    for k, result in enumerate(results):
        assert result == -k
        assert len(taken) <= k + 2 * n_threads + 1
    assert len(taken) == 50


def test_what_goes_wrong_comes_out_in_its_place():
    results = in_order(lambda k: 1 // (3 - k), range(9), 2)
    assert [next(results) for _ in range(3)] == [0, 0, 1]
    with pytest.raises(ZeroDivisionError):
        next(results)


def test_nothing_is_begun_after_the_end(monkeypatch: pytest.MonkeyPatch):
    begun, is_ending = [], threading.Event()

    class Pool(ThreadPoolExecutor):
        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            super().shutdown(wait=False, cancel_futures=cancel_futures)
            is_ending.set()
            super().shutdown(wait)

    def work(k: int) -> int:
        begun.append(k)
        return k if k == 0 or is_ending.wait(PATIENCE) else -1

    monkeypatch.setattr(picture_sources, "ThreadPoolExecutor", Pool)
    results = in_order(work, range(9), 2)
    assert next(results) == 0
    results.close()
    assert len(begun) <= 3  # the first, and what two threads were at
