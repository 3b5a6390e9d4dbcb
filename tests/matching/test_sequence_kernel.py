"""Ends of windows and ties in the search for lines, by hand."""

import numpy as np

from insectnav.matching.sequence_kernel import best_and_next, best_speed


def test_a_rival_lies_outside_the_window_on_either_side():
    """About the best start 5 the starts 3 … 7 are the same place, so that the best of the others is 1.4 at 8."""
    score = np.array([9.0, 9.0, 1.5, 1.1, 9.0, 1.0, 9.0, 1.2, 1.4, 9.0])
    assert best_and_next(score, 2) == (5, 1.0, 1.4)
    assert best_and_next(score[::-1].copy(), 2) == (4, 1.0, 1.4)


def test_of_equal_starts_and_speeds_the_first_is_taken():
    assert best_and_next(np.array([3.0, 1.0, 2.0, 1.0]), 1)[0] == 1
    offsets = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 4]])
    assert best_speed(np.zeros((3, 10)), 0, offsets, 0) == 0
    contrast = np.zeros((3, 10))
    contrast[2, 2] = 1.0  # what the first line runs through
    assert best_speed(contrast, 0, offsets, 0) == 1
