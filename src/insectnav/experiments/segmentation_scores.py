"""Scores of masks over pictures and methods, and the tests of one method against another."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError
from insectnav.metrics.paired_tests import paired_wilcoxon, variance_ratio
from insectnav.metrics.segmentation import accuracy, intersection_over_union, skyline_error
from insectnav.vision.sky_confidence import DOUBTFUL
from insectnav.vision.sky_segmentation import SkyMask

Bools = NDArray[np.bool_]
Row = Mapping[str, Any]

SCORES = ("accuracy", "iou", "skyline_error_px")
TESTED = ("accuracy", "iou")


def check_truth(found: SkyMask, truth: tuple[Bools, Bools] | None) -> None:
    """Refuse a truth of another size, or one that knows of no pixel that counts.

    Raises
    ------
    InputError
        If it is so.
    """
    if truth is None:
        return
    sky, known = truth
    if sky.shape != found.mask.shape:
        raise InputError(
            f"the picture has {found.mask.shape[0]} × {found.mask.shape[1]} pixels and its truth {sky.shape[0]} × "
            f"{sky.shape[1]}, expected the same: resized, or the truth of another picture?"
        )
    if not (known & found.valid).any():
        raise InputError("the truth is unknown wherever the picture counts, expected it to be known somewhere")


def score(found: SkyMask, truth: tuple[Bools, Bools] | None) -> dict[str, float]:
    """Accuracy, intersection over union and skyline error among the pixels that count and are known; NaN without truth.

    Parameters
    ----------
    found : SkyMask
    truth : sky, and where it is known, each (rows, columns); see `check_truth`
    """
    if truth is None:
        return dict.fromkeys(SCORES, float("nan"))
    sky, known = truth
    counts = known & found.valid
    return {
        "accuracy": accuracy(found.mask, sky, counts),
        "iou": intersection_over_union(found.mask, sky, counts),
        "skyline_error_px": skyline_error(found.mask, sky, counts),
    }


def summarise(rows: Sequence[Row], has_truth: bool) -> dict[str, dict[str, Any]]:
    """For each method the number of pictures, means, and for scores SD and the worst picture."""
    summary = {}
    for method in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == method]
        entry: dict[str, Any] = {"method": method, "images": len(own)}
        for quantity in ("sky_fraction", "confidence"):
            entry[f"{quantity}_mean"] = float(np.mean([row[quantity] for row in own]))
        doubtful = [row for row in own if row["confidence"] < DOUBTFUL]
        entry["doubtful"] = len(doubtful)
        entry["least_confident_image"] = min(own, key=lambda row: row["confidence"])["image"]
        if has_truth:
            entry |= _of_scores([row for row in own if not np.isnan(row["accuracy"])])
        summary[method] = entry
    return summary


def _of_scores(rows: Sequence[Row]) -> dict[str, Any]:
    entry: dict[str, Any] = {"images_with_truth": len(rows)}
    for name in SCORES:
        values = np.array([row[name] for row in rows], float)
        finite = values[np.isfinite(values)]
        entry[f"{name}_mean"] = float(finite.mean()) if finite.size else float("nan")
        entry[f"{name}_sd"] = float(finite.std(ddof=1)) if finite.size > 1 else float("nan")
        if name == "skyline_error_px":
            entry["skyline_missing"] = int(len(values) - finite.size)  # where only truth or mask has a skyline
    worst = min(rows, key=lambda row: row["accuracy"], default=None)
    entry["accuracy_worst"] = float("nan") if worst is None else worst["accuracy"]
    entry["worst_image"] = "" if worst is None else worst["image"]
    return entry


def compare_methods(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Paired Wilcoxon and F-ratio tests of each pair of methods on the pictures that both have scores of."""
    by_method: dict[str, dict[str, Row]] = {}
    for row in rows:
        if not np.isnan(row["accuracy"]):
            by_method.setdefault(row["method"], {})[row["image"]] = row
    tests = []
    for one, other in combinations(by_method, 2):
        shared = [image for image in by_method[one] if image in by_method[other]]
        for quantity in TESTED if len(shared) > 1 else ():
            first, second = ([by_method[method][image][quantity] for image in shared] for method in (one, other))
            rank, spread = paired_wilcoxon(first, second), variance_ratio(first, second)
            tests.append(
                {"quantity": quantity, "method": one, "other": other, "images": len(shared)}
                | {"mean_difference": float(np.mean(np.subtract(first, second)))}
                | {"wilcoxon_statistic": rank.statistic, "wilcoxon_p": rank.p}
                | {"variance_ratio": spread.ratio, "variance_p": spread.p}
            )
    return tests
