"""What is counted of the frames of a walk: skies that change, and grey below the skyline."""

import numpy as np
from numpy.testing import assert_allclose

from insectnav.experiments.stone2014_places import fig_4ab
from insectnav.experiments.stone2014_places.mirror import mirror_pixels
from insectnav.experiments.stone2014_places.sequence_ways import MASKED
from insectnav.experiments.stone2014_places.walks import Walk


def test_bits_that_change_are_counted_from_the_frame_before_and_to_the_one_after():
    skies = np.zeros((4, 8100), bool)
    skies[1, :810] = True  # a tenth of the bits
    skies[3, :1620] = True
    walk = Walk(
        day="april", every=10, mirror_size=9,
        arrays={"number": np.arange(4), "binary_sky": np.packbits(skies, axis=1)},
    )  # fmt: skip
    assert_allclose(fig_4ab.change_of_sky(walk, np.arange(4)), [0.1, 0.1, 0.15, 0.2])
    assert_allclose(fig_4ab.change_of_sky(walk, np.array([0, 2])), 0.0)


def test_grey_with_the_sky_masked_out_is_white_there_and_grey_below():
    size, rows = 91, 28
    pixels = mirror_pixels(size, 1.0)
    up = np.zeros((105, 360), bool)
    up[:60] = True  # from 90° down to 30°
    sky = np.zeros((size, size), bool)
    sky[pixels.seen] = up.ravel()[pixels.of_mirror][pixels.seen]
    colours = np.full((1, rows, 180, 3), 80, np.uint8)
    walk = Walk(
        day="april", every=1, mirror_size=size,
        arrays={"number": np.arange(1), "mirror_sky": np.packbits(sky)[None], "colours": colours},
    )  # fmt: skip
    below = MASKED[1].features(walk).reshape(16, 16)
    assert (below[:8] == 255).all()  # rows of 6.6°: eight are above 37°
    assert (below[10:] == 80).all()
