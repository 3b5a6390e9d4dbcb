"""What the text says in words of where and when places are recognised, as numbers of a passage of the car."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.published import surplus, with_error
from insectnav.experiments.stone2016_places.recognition import (
    FABMAP,
    PLAIN,
    SKY,
    SKY_WHOLE,
    VANILLA,
    WATERSHED,
    Arrays,
    Recognised,
    drawn_blocks,
)
from insectnav.experiments.stone2016_places.sites import FOREST_END, GARDENS_END, Ground
from insectnav.worlds.traverse import way_length

PRECISION = "precision_at_full_recall"
WHOLE, OTHER_SITE = "whole way", "whole way of the BMX Track"  # what a row of the table is of
NONE = float("nan")
Bools = NDArray[np.bool_]
Rows = Mapping[tuple[str, int], Mapping[str, Any]]  # by method and length of sequences


def contrast(values: NDArray[Any], chosen: Bools) -> tuple[float, float]:
    """Mean of the chosen values less that of the others, and its standard error by blocks of neighbouring frames.

    NaN values are left out; NaN if there are none on either side.
    """
    known = np.isfinite(values)
    sides = known & chosen, known & ~chosen
    if not all(side.any() for side in sides):
        return NONE, NONE
    drawn = []
    for frames in drawn_blocks(len(values)):
        one, other = (values[frames][side[frames]] for side in sides)
        if len(one) and len(other):
            drawn.append(one.mean() - other.mean())
    return float(values[sides[0]].mean() - values[sides[1]].mean()), float(np.std(drawn))


def mean_of(values: NDArray[Any], chosen: Bools) -> tuple[float, float]:
    """Mean of the chosen values that are not NaN, and its standard error by blocks of neighbouring frames."""
    some = chosen & np.isfinite(values)
    if not some.any():
        return NONE, NONE
    drawn = [values[frames][some[frames]] for frames in drawn_blocks(len(values))]
    return float(values[some].mean()), float(np.std([part.mean() for part in drawn if len(part)]))


def shares_right(answer: Recognised) -> NDArray[np.float64]:
    """100 where the match is right, 0 where it is wrong, NaN where there is none, (query,) [%]."""
    return np.where(np.isfinite(answer.score), 100.0 * answer.is_right, NONE)


def longest_gap(answer: Recognised) -> int:
    """Most frames in a row without a right match, among those that have frames enough around them."""
    right = answer.is_right[np.isfinite(answer.score)]
    ends = np.flatnonzero(np.concatenate([[True], right, [True]]))
    return int(np.diff(ends).max() - 1)


def sections_of_track(distance: NDArray[Any], ground: Ground) -> NDArray[np.int64]:
    """Section of the BMX track at each distance along it [m]: 0 the forest, 1 its border, 2 the street."""
    ends = [way_length(ground.way[ground.way[:, 1] <= end]) for end in (FOREST_END, GARDENS_END)]
    return np.searchsorted(ends, distance)


def with_errors(**found: tuple[float, float]) -> dict[str, float]:
    """Columns of a table: each number, and its standard error in a column with `_error` at its end."""
    return {name: value for name, (value, _) in found.items()} | {f"{name}_error": e for name, (_, e) in found.items()}


def of_answer(answer: Recognised, query: Arrays, ground: Ground, *, is_track: bool) -> dict[str, float]:
    """How much is right under the canopy of the forest, and in the last third of the way less before it [%]."""
    right, n = shares_right(answer), len(answer.score)
    in_forest = sections_of_track(query["distance"], ground) == 0 if is_track else np.zeros(n, bool)
    return with_errors(
        right_in_last_third_less_before=contrast(right, np.arange(n) >= 2 * n // 3),
        right_under_canopy=mean_of(right, in_forest),
        right_under_canopy_less_elsewhere=contrast(right, in_forest),
    )


def of_frames(query: Arrays, ground: Ground, *, is_track: bool) -> dict[str, float]:
    """What the second passage saw of the sky under the canopy, and what flare did where the sun shone in [%]."""
    sky, is_sunlit = 100.0 * query["sky_share"].astype(np.float64), query["is_sunlit"]
    in_forest = sections_of_track(query["distance"], ground) == 0 if is_track else np.zeros(len(sky), bool)
    by_flare = (query["plain_accuracy"] - query["accuracy"]).astype(np.float64)
    return {
        "sky_under_canopy": mean_of(sky, in_forest)[0],
        "sky_elsewhere": mean_of(sky, ~in_forest)[0],
        "sunlit": 100.0 * float(is_sunlit.mean()),
        "mislabelled_where_sunlit": 100.0 - mean_of(query["accuracy"], is_sunlit)[0],
        "mislabelled_in_shade": 100.0 - mean_of(query["accuracy"], ~is_sunlit)[0],
    } | with_errors(
        mislabelled_by_flare=mean_of(by_flare, is_sunlit),
        mislabelled_by_flare_under_canopy=mean_of(by_flare, is_sunlit & in_forest),
    )


def claimed(rows: Rows, other_rows: Rows) -> dict[str, tuple[float, float]]:
    """Numbers of ours for what the text says in words, by quantity: value and standard error.

    Parameters
    ----------
    rows : of the whole way
    other_rows : of the whole way of the BMX track, where a site is compared with it
    """
    sky, vanilla, words = rows[SKY, 10], rows[VANILLA, 10], rows[FABMAP, 1]
    found = {
        "median precision of FAB-MAP": (float(words["median_precision"]), 0.0),
        "matches of FAB-MAP in the right section": (float(words["in_right_section"]), 0.0),
        "precision at full recall, sky less vanilla": surplus(sky, vanilla, PRECISION),
        "precision at full recall, sky less FAB-MAP": surplus(sky, words, PRECISION),
        "precision at full recall, sky, w = 20 less w = 10": surplus(rows[SKY, 20], sky, PRECISION),
        "precision at full recall, sky, w = 10 less single images": surplus(sky, rows[SKY_WHOLE, 1], PRECISION),
        "precision at full recall, sky, no flare less flare": surplus(rows[PLAIN, 10], sky, PRECISION),
        "precision at full recall, sky, watershed less Otsu": surplus(rows[WATERSHED, 10], sky, PRECISION),
        "share right where turned apart least less most, vanilla": (
            float(vanilla["right_where_turned_least"] - vanilla["right_where_turned_most"]), 0.0,
        ),
        "share right in the last third, sky less vanilla": (
            float(sky["right_in_last_third"] - vanilla["right_in_last_third"]), 0.0,
        ),
        "share right in the last third less before, vanilla": with_error(vanilla, "right_in_last_third_less_before"),
        "share right under the canopy, sky": with_error(sky, "right_under_canopy"),
        "share right under the canopy less elsewhere, sky": with_error(sky, "right_under_canopy_less_elsewhere"),
        "pixels mislabelled where the sun shines in, flare less none": with_error(sky, "mislabelled_by_flare"),
    }  # fmt: skip
    for who, key in (("vanilla", (VANILLA, 10)), ("sky", (SKY, 10)), ("FAB-MAP", (FABMAP, 1))):
        there = other_rows.get(key)
        less = (NONE, NONE) if there is None else surplus(rows[key], there, PRECISION)
        found[f"precision at full recall, {who}, less than on the BMX Track"] = less
    return found
