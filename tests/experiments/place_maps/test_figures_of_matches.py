"""What is drawn of places found again: legible, in the colours that the legend and the caption name."""

from itertools import pairwise

import numpy as np
from matplotlib.colors import to_hex

from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN
from insectnav.experiments.place_maps.figures import draw_matches, draw_pairs, draw_precision, draw_route
from insectnav.experiments.place_maps.truth import by_position, from_pairs
from place_scenes import located

REFERENCE, SCORE = np.array([0, 1, 9, 4]), np.array([0.1, 0.2, 0.3, 0.9])


def test_matches_that_are_not_judged_do_not_look_wrong_in_the_matrix():
    truth = from_pairs(REFERENCE, {0: (0,), 2: (2,), 3: (3,)}, 1.0, "by hand", np.zeros(10, np.int64))
    figure = draw_matches(located(REFERENCE, SCORE, truth), np.random.default_rng(0).random((10, 4)),
                          np.arange(10), np.arange(4))  # fmt: skip
    matrix = next(axes for axes in figure.axes if axes.images)
    colours = {line.get_marker(): to_hex(line.get_color()) for line in matrix.lines}
    assert colours == {".": to_hex("white"), "x": to_hex(COLOURS["red"]), "+": to_hex("white")}


def test_the_truth_does_not_run_from_one_route_into_another():
    truth = from_pairs(REFERENCE, {0: (0,), 1: (6,), 2: (2,), 3: (3,)}, 1.0, "by hand", np.zeros(10, np.int64))
    found = located(REFERENCE, SCORE, truth, place_routes=np.arange(10) // 5)
    figure = draw_matches(found, np.zeros((10, 4)), np.arange(10), np.arange(4))
    line = next(line for line in figure.axes[0].lines if line.get_label() == "truth")
    np.testing.assert_array_equal(line.get_ydata(), [0, np.nan, 6, np.nan, 2, 3])


def test_errors_that_are_not_drawn_do_not_make_room_for_themselves():
    places = np.stack([100.0 * np.arange(10), np.zeros(10), np.zeros(10)], axis=1)
    queries = places[[0, 1, 9, 9]] + (1.0, 0.0, 0.0)
    truth = by_position(REFERENCE, queries, places, 5.0, "by hand")
    found = located(REFERENCE, SCORE, truth, threshold=0.5, place_positions=places, query_positions=queries)
    figure = draw_route(found)
    assert figure is not None
    errors = next(axes for axes in figure.axes if axes.get_ylabel().startswith("error"))
    assert 5.0 < errors.get_ylim()[1] < 10.0  # 500 m off is the match that is not kept


def test_precision_is_drawn_over_all_of_the_recall_that_its_area_counts():
    truth = from_pairs(REFERENCE, {k: (k,) for k in range(4)}, 1.0, "by hand", np.zeros(10, np.int64))
    figure = draw_precision(located(REFERENCE, SCORE, truth))
    assert figure is not None
    curve = figure.axes[0].lines[0]
    assert curve.get_xdata()[0] == 0.0
    assert len(curve.get_xdata()) == 5


def test_where_nothing_is_found_no_legend_is_asked_for():
    nowhere = np.full(4, -1)
    truth = from_pairs(nowhere, {0: (0,)}, 1.0, "by hand", np.zeros(10, np.int64))
    figure = draw_precision(located(nowhere, None, truth))
    assert figure is not None  # and no warning, which is an error here
    assert figure.axes[1].get_legend() is None


def test_titles_of_pairs_do_not_run_into_each_other():
    picture = np.zeros((25, 120), np.uint8)
    figure = draw_pairs([("Wrong match, of the best scores", picture, picture)] * 6)
    figure.draw_without_rendering()
    boxes = [axes.title.get_window_extent() for axes in figure.axes[:6]]
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))
    assert boxes[-1].x1 < DOUBLE_COLUMN * figure.dpi
    assert all(box.y1 <= figure.get_size_inches()[1] * figure.dpi for box in boxes)
