"""What a page says of matches: no number that is none, and thresholds that do what is said of them."""

from types import SimpleNamespace

import numpy as np

from insectnav.cli.map_words import evaluated_in_words
from insectnav.experiments.place_maps.describe import ROTATED, DescribeParams
from insectnav.experiments.place_maps.located import numbers
from insectnav.experiments.place_maps.truth import from_pairs
from insectnav.experiments.place_maps.view_cameras import view_camera
from insectnav.experiments.place_maps.words import numbers_in_words, search_in_words, tiles
from insectnav.matching.seqslam import SeqSlamParams
from place_scenes import located

NOWHERE = np.full(4, -1)


def test_matches_that_are_not_there_have_no_precision_and_no_score():
    pairs = {0: (0,), 1: (1,)}
    judged = numbers(located(NOWHERE, None, from_pairs(NOWHERE, pairs, 1.0, "by hand", np.zeros(10, np.int64))))
    said = evaluated_in_words({"lead": "", "truth": "", "numbers": judged, "notes": []})
    for words in (said, *tiles(judged), *tiles(numbers(located(NOWHERE))), *numbers_in_words(judged)):
        assert "nan" not in "".join(words)
    assert ("0.0%", "recall before the first wrong match") in tiles(judged)


def test_the_threshold_up_to_which_all_is_right_keeps_just_that():
    reference, score = np.array([0, 1, 7, 3]), np.array([0.1, 0.84069901, 0.84069902, 0.9])
    truth = from_pairs(reference, {k: (k,) for k in range(4)}, 0.0, "by hand", np.zeros(10, np.int64))
    all_of_them = numbers(located(reference, score, truth))
    threshold = next(float(value) for name, value, _ in numbers_in_words(all_of_them) if name == "Score of the same")
    kept = numbers(located(reference, score, truth, threshold=threshold))
    assert (kept["precision_kept"], kept["recall_kept"]) == (1.0, all_of_them["recall_at_full_precision"])


def test_matches_that_are_dropped_are_not_said_to_be_none_where_nothing_is_known_either():
    found = numbers(located([0, 1, 2], [0.1, 0.5, 0.9], threshold=0.5))
    assert tiles(found)[0] == ("2 / 3", "queries with a match that is kept")
    assert ("Threshold", "0.5", "given") in numbers_in_words(found)


def test_single_frames_have_a_window_also_after_all_rotations():
    describe = DescribeParams(descriptor=ROTATED, camera=view_camera("fisheye:180"), sky="mask")
    search = SimpleNamespace(seqslam=SeqSlamParams(sequence_length=1), found=located([0]), describe=describe)
    assert search_in_words(search, "auto") == (
        "frames one by one, after all rotations the place with the least mean squared difference over what both saw; "
        "the score is its difference in the coarse search over the least of all places farther than 5 places from it"
    )
    assert ("Compared by", "mean squared difference") in describe.in_words()
