"""The picture of activity: its rows, columns and colours by hand."""

import numpy as np
from matplotlib.figure import Figure

from insectnav.experiments.activity_picture import GAP, LABELS, draw_activity, shorten


def test_shorter_rates_are_means_of_neighbours():
    rates = np.arange(20.0).reshape(2, 10)
    np.testing.assert_array_equal(shorten(rates, 4), [[1, 4, 7, 9], [11, 14, 17, 19]])
    np.testing.assert_array_equal(shorten(rates, 10), rates)


def test_picture_has_a_row_for_each_cell_and_its_highest_rate_is_one():
    n_cells = {name: {"tn2": 2, "tb1": 8}.get(name, 16) for name in LABELS}
    activity = {name: np.full((30, n), 0.2) * np.arange(1, n + 1) / n for name, n in n_cells.items()}
    image = draw_activity(Figure().subplots(), activity, n_outbound=20)
    picture = image.get_array()
    heights = {name: 8 if name == "tn2" else 16 for name in LABELS}
    assert picture.shape == (sum(heights.values()) + GAP * (len(LABELS) - 1), 30)
    first = 0
    for name, height in heights.items():
        block = picture[first : first + height]
        expected = np.repeat(np.arange(1, n_cells[name] + 1) / n_cells[name], height // n_cells[name])
        np.testing.assert_allclose(block, np.tile(expected[:, None], 30), rtol=1e-12)
        first += height + GAP
