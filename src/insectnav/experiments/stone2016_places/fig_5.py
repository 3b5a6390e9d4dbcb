"""Fig. 5, City: places recognised between passages whose cameras are tilted apart by 0 to 60 degrees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge, more, with_error
from insectnav.experiments.stone2016_places.claims import longest_gap, with_errors
from insectnav.experiments.stone2016_places.frames import FULL_SIZE, Section, keep, sections
from insectnav.experiments.stone2016_places.panels import draw_correspondence, draw_curve, draw_frame
from insectnav.experiments.stone2016_places.passages import (
    LEVEL,
    PASSAGES,
    SECONDS_APART,
    SITE_SEEDS,
    TILTS_DEG,
    drawn_as,
    whole_or_why_not,
)
from insectnav.experiments.stone2016_places.recognition import (
    NEUTRAL,
    POINTS,
    ROTATION,
    ROTATION_LOCAL,
    SINGLE,
    SKY,
    SKY_WHOLE,
    TRUE,
    VANILLA,
    Recognised,
    by_rotation,
    differences,
    in_sequences,
    jointly,
    passage_arrays,
    passage_pair,
    truth_between,
    varied,
)
from insectnav.experiments.stone2016_places.sites import CITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE = "Fig. 5"
TITLE = "City, rendered: places recognised between passages tilted apart by 0 to 60 degrees"
SITE = "City"
# Reference and query passage, by the difference of their tilts [°], "by pairing α1 ≈ −α2".
PAIRS = {0: (3, 4), 10: (4, 5), 20: (2, 5), 30: (2, 6), 40: (1, 6), 50: (1, 7), 60: (0, 7)}
SHOWN_DEG = (20, 40, 60)
DRAWN = (VANILLA, SKY, ROTATION)
# The level passages over the first part of the way: as they are, without clouds or sway, and one 2 m farther left.
VARIATIONS = {"as ridden": LEVEL, "no clouds": (8, 9), "no sway": (10, 11), "neither": (12, 13), "2 m aside": (3, 14)}
VARIED_FRAMES = 195  # of each
MISLABELLED = 3.0  # [% of the pixels] from which a frame counts as mislabelled; ours
UNTESTED = {
    "benefit of the sky, city less desert": "no passage through flat and open country is built",
}


@dataclass(frozen=True, kw_only=True)
class Cell(Section):
    """Frames of one passage."""


def grid(scale: str) -> Sequence[Cell]:
    """Eight passages of 520 frames; or 32 frames of each, in small pictures, with nothing that moves between them."""
    if scale == "full":
        how: dict[str, Any] = {"each": 65, "size": FULL_SIZE, "supersampling": 2}
        stretches = (1.0, VARIED_FRAMES / CITY.n_frames)
    else:
        how = {"each": 32, "size": 96, "supersampling": 1}
        stretches = (0.07, 0.07)
    found = []
    for number in range(len(PASSAGES[SITE])):
        time_s = SECONDS_APART * drawn_as(SITE, number) * (scale == "full")
        stretch = stretches[number >= len(TILTS_DEG)]
        found += sections(SITE, number, seed=SITE_SEEDS[SITE], stretch=stretch, time_s=time_s, **how)
    return [Cell(**vars(section)) for section in found]


def simulate(cell: Cell, seed: int) -> Arrays:
    """What the methods compare, of each frame."""
    return keep(cell, seed, with_pictures=False)


@lru_cache(maxsize=1)
def recognised(results: Results) -> tuple[dict[tuple[int, str], Recognised], dict[int, float]]:
    """Answers by difference of tilt and method, and the median error of the tilt found [°] by difference of tilt."""
    answers: dict[tuple[int, str], Recognised] = {}
    tilt_errors: dict[int, float] = {}
    size = results.cells[0].size
    for apart, pair in PAIRS.items():
        reference, query = passage_pair(results, pair)
        truth = truth_between(reference, query)
        matrices = {name: differences(reference, query, name) for name in (VANILLA, NEUTRAL, SKY, POINTS, TRUE)}
        answers |= {(apart, name): in_sequences(matrix, truth) for name, matrix in matrices.items()}
        answers[apart, SKY_WHOLE] = in_sequences(matrices[SKY], truth, whole_contrast=True)
        found = by_rotation(reference, query, truth, size)
        answers[apart, ROTATION] = in_sequences(found.matrix, truth, whole_contrast=True)
        answers[apart, ROTATION_LOCAL] = in_sequences(found.matrix, truth)
        answers[apart, SINGLE] = found.single
        tilt_errors[apart] = float(np.median(np.rad2deg(found.tilt[found.single.is_right]) - apart))
    return answers, tilt_errors


def summarise(results: Results) -> Table:
    """A row for each difference of tilt and method, and for each variation of the level passages."""
    answers, tilt_errors = recognised(results)
    accuracy = {number: results["accuracy"][cells] for number, cells in results.by("passage").items()}
    rows = [
        _row(apart, method, "whole way", answer, PAIRS[apart], accuracy)
        | _lost([answers[tilt, way] for way in (method, SKY) for tilt in (0, apart)])
        | {"tilt_found_less_nominal_deg": tilt_errors[apart] if method == SINGLE else float("nan")}
        for (apart, method), answer in answers.items()
    ]
    on_first_part = varied(results, VARIATIONS, VARIED_FRAMES)
    return rows + [
        _row(0, method, name, answer, VARIATIONS[name], accuracy)
        | _lost([on_first_part[part, way] for way in (method, SKY) for part in ("as ridden", name)])
        | {"tilt_found_less_nominal_deg": float("nan")}
        for (name, method), answer in on_first_part.items()
    ]


def _lost(answers: Sequence[Recognised]) -> dict[str, float]:
    """How much of the area is lost, and how much less a method has, keeps and loses than skies do [%].

    Parameters
    ----------
    answers : of the method without and with what is varied, and of skies without and with it
    """

    def kept(without: Any, there: Any) -> Any:
        return 100.0 * there / np.maximum(without, 1e-9)

    return with_errors(
        area_lost=jointly("area", np.subtract, *answers[:2]),
        area_less_sky=jointly("area", np.subtract, answers[1], answers[3]),
        area_lost_less_sky=jointly("area", lambda a, b, sky, with_it: (a - b) - (sky - with_it), *answers),
        area_kept_less_sky=jointly("area", lambda a, b, sky, with_it: kept(a, b) - kept(sky, with_it), *answers),
    )


def _row(
    apart: int, method: str, part: str, answer: Recognised, pair: tuple[int, int], accuracy: Mapping[int, NDArray[Any]]
) -> dict[str, Any]:
    return {
        "tilt_difference_deg": apart,
        "method": method,
        "passages": part,
        "kind": "rendered",
        "n_frames": len(answer.score),
        "n": int(np.isfinite(answer.score).sum()),
        **answer.findings(),
        "longest_gap": longest_gap(answer),
        "sky_labelled_right": float(np.mean([accuracy[number].mean() for number in pair])),
        "frames_mislabelled": worst_labelled(accuracy, pair),
    }


def worst_labelled(accuracy: Mapping[int, NDArray[Any]], pair: tuple[int, int]) -> float:
    """Share of the frames with more than 3 % of their pixels mislabelled, of the passage that has more [%]."""
    return max(100.0 * float((100.0 - accuracy[number] > MISLABELLED).mean()) for number in pair)


def draw(results: Results) -> Figure:
    """Pictures tilted apart, correspondences of three methods at 20°, 40° and 60°, precision and recall over tilt."""
    from matplotlib.figure import Figure

    answers, _ = recognised(results)
    figure = Figure(figsize=(DOUBLE_COLUMN, 7.4), layout="constrained")
    parts: Any = figure.subfigures(3, 1, height_ratios=(1.35, 3.9, 2.1))
    _draw_examples(parts[0], results)
    panels = parts[1].subplots(len(SHOWN_DEG), len(DRAWN), sharex=True, sharey=True)
    for row, apart in enumerate(SHOWN_DEG):
        for column, method in enumerate(DRAWN):
            axes = panels[row, column]
            draw_correspondence(axes, answers[apart, method])
            if row == 0:
                axes.set_title(method, loc="left")
            if column == 0:
                axes.set_ylabel(f"{apart}°: reference frame")
            if row == len(SHOWN_DEG) - 1:
                axes.set_xlabel("query frame")
    name_panel(panels[0, 0], "b", VANILLA)
    below = parts[2].subplots(1, len(DRAWN), sharex=True, sharey=True)
    colours = [COLOURS[name] for name in ("black", "purple", "blue", "sky", "green", "orange", "red")]
    for letter, method, axes in zip("cde", DRAWN, below, strict=True):
        for apart, colour in zip(PAIRS, colours, strict=True):
            draw_curve(axes, answers[apart, method], colour, f"{apart}°")
        name_panel(axes, letter, method)
        axes.set_xlabel("recall (%)")
    below[0].set_ylabel("precision (%)")
    below[1].legend(title="tilt apart", loc="lower left", ncols=2)
    return figure


def _draw_examples(part: Any, results: Results) -> None:
    """One place as two cameras see it that are tilted 60° apart: visible, ultraviolet, mask."""
    first, second = PAIRS[60]
    reference, query = (results.where(passage=number) for number in (first, second))
    middle = len(reference) // 3
    panels = part.subplots(1, 6)
    for k, (cells, tilt) in enumerate(((reference, TILTS_DEG[first]), (query, TILTS_DEG[second]))):
        for j, name in enumerate(("visible", "uv", "mask")):
            axes = panels[3 * k + j]
            draw_frame(axes, results[f"shown_{name}"][cells[middle]])
            axes.set_title(f"{name.replace('uv', 'UV')}, {tilt:+.0f}°", loc="left")
    name_panel(panels[0], "a", f"visible, {TILTS_DEG[first]:+.0f}°")


def caption(results: Results) -> str:
    """What the figure shows."""
    n = len(passage_arrays(results, 0)["distance"])
    length = 520.0 * n / results.cells[0].of_frames
    return (
        f"Rendered, no photographs: {length:.0f} m of a built city, eight passages of n = {n} frames at tilts of the "
        "camera from −30° to 30°, each with its own lane, sway, speed, time, clouds and traffic. (a) One place from "
        "two cameras tilted 60° apart. (b) Matches of passages tilted 20°, 40° and 60° apart; green: within 5 frames "
        "of the truth, red: farther off; line: truth. Columns: SeqSLAM on patch-normalised grey pictures, on "
        "spherical-harmonic amplitudes of the sky, and on the difference of skies at the rotation that fits best (its "
        "contrast over all references); sequences of 10 frames. (c–e) Precision over recall by difference of tilt."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Recall at full precision, and the claims of section V-A."""
    rows = {(row["tilt_difference_deg"], row["method"]): row for row in table if row["passages"] == "whole way"}
    recall = "recall_at_full_precision"

    varied_rows = [row for row in table if row["passages"] != "whole way"]
    of_sky = {row["passages"]: row for row in varied_rows if row["method"] == SKY}
    ours: dict[str, tuple[float, float]] = {
        "recall at full precision, sky, 60°": with_error(rows[60, SKY], recall),
        "recall at full precision, vanilla, 50°": with_error(rows[50, VANILLA], recall),
        "recall at full precision, vanilla, 60°": with_error(rows[60, VANILLA], recall),
        "area of sky less that of vanilla, 0°": more(rows[0, VANILLA], "area_less_sky"),
        "area lost from 0° to 60°, vanilla less sky": with_error(rows[60, VANILLA], "area_lost_less_sky"),
        "share of the area at 0° kept at 60°, sky less vanilla": more(rows[60, VANILLA], "area_kept_less_sky"),
        "area of sky, 2 m aside less as ridden": more(of_sky["2 m aside"], "area_lost"),
    } | dict.fromkeys(UNTESTED, (float("nan"), 0.0))
    for apart in SHOWN_DEG:
        sky, vanilla = rows[apart, SKY], rows[apart, VANILLA]
        ours[f"area of sky less that of vanilla, {apart}°"] = more(vanilla, "area_less_sky")
        ours[f"longest part without a right match, vanilla less sky, {apart}°"] = (
            float(vanilla["longest_gap"] - sky["longest_gap"]), 0.0,
        )  # fmt: skip
    why, part = _why(rows, varied_rows), whole_or_why_not(CITY, rows[0, SKY]["n_frames"])
    return [
        judge(value, *ours[value.quantity], why=why, not_comparable=UNTESTED.get(value.quantity, part))
        for value in published.values()
    ]


def _why(rows: Mapping[tuple[int, str], Mapping[str, Any]], varied_rows: Sequence[Mapping[str, Any]]) -> str:
    """What was measured of the causes: clouds, sway, exact masks, and matching in the overlap alone."""
    tilts = [
        f"{apart}°: "
        + ", ".join(f"{method} {rows[apart, method]['area']:.0f}" for method in (VANILLA, SKY, TRUE, SINGLE))
        for apart in (0, 20, 40, 60)
    ]
    level = [
        f"{method}: "
        + ", ".join(f"{row['passages']} {row['area']:.0f}" for row in varied_rows if row["method"] == method)
        for method in (VANILLA, SKY)
    ]
    right = np.mean([row["sky_labelled_right"] for row in rows.values()])
    return (
        f"rendered, another place; sky labelled right in {right:.1f} % of the pixels; area under precision over recall "
        f"in percent at {'; '.join(tilts)}; at 0° over the first part of the way by {'; '.join(level)}"
    )
