"""Votes over recent frames against counting by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from insectnav.checks import InputError
from insectnav.vision.sky_sequences import RecentMasks, smooth, smoothed


@given(masks=arrays(bool, (9, 2, 3)), n=st.integers(1, 6))
def test_majority_is_that_of_the_last_frames(masks, n):
    for k, found in enumerate(smoothed(masks, n)):
        last = masks[max(0, k - n + 1) : k + 1]
        share = last.mean(axis=0)
        assert_array_equal(found, np.where(share == 0.5, last[-1], share > 0.5))


def test_what_passes_in_two_of_five_frames_is_gone():
    masks = np.ones((5, 4, 4), bool)
    masks[2:4, 1, 1] = False
    assert list(smoothed(masks, 5))[-1].all()


def test_other_sizes_and_counts_are_refused():
    recent, _ = smooth(RecentMasks(), np.ones((2, 2), bool), 3)
    with pytest.raises(InputError, match="another camera"):
        smooth(recent, np.ones((2, 3), bool), 3)
    with pytest.raises(InputError, match="n_frames"):
        smooth(recent, np.ones((2, 2), bool), 0)
