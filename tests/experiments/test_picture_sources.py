"""Work on pictures by several threads, in order, and left off at any time."""

import threading
import time

import pytest

from command_line import PATIENCE
from insectnav.experiments import picture_sources
from insectnav.experiments.picture_sources import in_order
from insectnav.workers import Threads


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

    class Pool(Threads):
        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            super().shutdown(wait=False, cancel_futures=cancel_futures)
            is_ending.set()
            super().shutdown(wait)

    def work(k: int) -> int:
        begun.append(k)
        return k if k == 0 or is_ending.wait(PATIENCE) else -1

    monkeypatch.setattr(picture_sources, "Threads", Pool)
    results = in_order(work, range(9), 2)
    assert next(results) == 0
    results.close()
    assert len(begun) <= 3  # the first, and what two threads were at


@pytest.mark.parametrize("nth", [1, 2])
def test_nothing_is_at_work_after_an_interrupt_while_a_thread_starts(monkeypatch: pytest.MonkeyPatch, nth: int):
    threads, at_work, usual = [], [], threading.Thread.start
    is_begun, goes_on = threading.Event(), threading.Event()

    def start(thread: threading.Thread) -> None:
        usual(thread)
        threads.append(thread)
        if len(threads) == nth:  # as a signal comes while the start is waited for, and work is done already
            assert is_begun.wait(PATIENCE)
            monkeypatch.undo()
            threading.Timer(0.1, goes_on.set).start()
            raise KeyboardInterrupt

    def work(k: int) -> int:
        at_work.append(k)
        is_begun.set()
        assert goes_on.wait(PATIENCE)
        time.sleep(0.2 * k)  # the thread that was forgotten is the last
        at_work.remove(k)
        return k

    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(KeyboardInterrupt):
        list(in_order(work, range(9), 2))
    assert at_work == []
    for thread in threads:
        thread.join(PATIENCE)
    assert not any(thread.is_alive() for thread in threads)
