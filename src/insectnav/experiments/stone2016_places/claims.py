"""What the text says in words of where and when places are recognised, as numbers of a passage of the car."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.angles import Floats
from insectnav.experiments.published import more, surplus, with_error
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
    jointly,
    thirds_by_turn,
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


def of_answer(
    answer: Recognised, of_sky: Recognised, query: Arrays, ground: Ground, turned: Floats, *, is_track: bool
) -> dict[str, float]:
    """How much less is right than by skies, and where: last third, canopy, cameras turned apart [%].

    Parameters
    ----------
    answer, of_sky : of a method, and of SeqSLAM on skies with the published length of sequences
    query : frames of the second passage
    ground : of the site
    turned : (query,) angle between the cameras [rad]
    is_track : whether it is the BMX track, a part of which is forest
    """
    right, n = shares_right(answer), len(answer.score)
    last_third = np.arange(n) >= 2 * n // 3
    in_forest = sections_of_track(query["distance"], ground) == 0 if is_track else np.zeros(n, bool)
    least, most = thirds_by_turn(answer, turned)
    return with_errors(
        precision_less_sky=jointly(PRECISION, np.subtract, answer, of_sky),
        right_in_last_third=mean_of(right, last_third),
        right_in_last_third_less_sky=mean_of(right - shares_right(of_sky), last_third),
        right_in_last_third_less_before=contrast(right, last_third),
        right_where_turned_least=mean_of(right, least),
        right_where_turned_most=mean_of(right, most),
        right_where_turned_least_less_most=contrast(np.where(least | most, right, NONE), least),
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
    less = "precision_less_sky"
    found = {
        "median precision of FAB-MAP": (float(words["median_precision"]), 0.0),
        "matches of FAB-MAP in the right section": (float(words["in_right_section"]), 0.0),
        "precision at full recall, sky less vanilla": more(vanilla, less),
        "precision at full recall, sky less FAB-MAP": more(words, less),
        "precision at full recall, sky, w = 20 less w = 10": with_error(rows[SKY, 20], less),
        "precision at full recall, sky, w = 10 less single images": more(rows[SKY_WHOLE, 1], less),
        "precision at full recall, sky, no flare less flare": with_error(rows[PLAIN, 10], less),
        "precision at full recall, sky, watershed less Otsu": with_error(rows[WATERSHED, 10], less),
        "share right where turned apart least less most, vanilla": with_error(
            vanilla, "right_where_turned_least_less_most"
        ),
        "share right in the last third, sky less vanilla": more(vanilla, "right_in_last_third_less_sky"),
        "share right in the last third less before, vanilla": with_error(vanilla, "right_in_last_third_less_before"),
        "share right under the canopy, sky": with_error(sky, "right_under_canopy"),
        "share right under the canopy less elsewhere, sky": with_error(sky, "right_under_canopy_less_elsewhere"),
        "pixels mislabelled where the sun shines in, flare less none": with_error(sky, "mislabelled_by_flare"),
    }  # fmt: skip
    for who, key in (("vanilla", (VANILLA, 10)), ("sky", (SKY, 10)), ("FAB-MAP", (FABMAP, 1))):
        there = other_rows.get(key)
        found[f"precision at full recall, {who}, less than on the BMX Track"] = (
            (NONE, NONE) if there is None else surplus(rows[key], there, PRECISION)
        )
    return found
