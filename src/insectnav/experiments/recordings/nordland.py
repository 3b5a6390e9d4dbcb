"""A railway in summer and winter (Nordland): SeqSLAM as published and as it is here, and FAB-MAP on single frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from insectnav.experiments.experiment import Arrays, Results, Table
from insectnav.experiments.figures import COLOURS, DOUBLE_COLUMN, name_panel
from insectnav.experiments.published import Published, Verdict, judge
from insectnav.experiments.recordings.files import MISSING, N_NORDLAND, OTHER_RECORDING, nordland
from insectnav.matching import (
    OPENSEQSLAM_V1,
    SeqSlamParams,
    build_vocabulary,
    chow_liu_tree,
    difference_matrix,
    fabmap,
    seqslam,
)
from insectnav.matching.visual_words import local_features
from insectnav.metrics.retrieval import (
    PrecisionRecall,
    area_under_curve,
    precision_at_full_recall,
    precision_recall,
    recall_at_full_precision,
)
from insectnav.vision.descriptors import patch_normalised

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURE = "recording"
TITLE = "a railway in two seasons: SeqSLAM as published and here, and FAB-MAP on single frames"
TOLERANCE = 2  # [frame of the map]
V1, NEUTRAL, DEFAULT = "OpenSeqSLAM v1", "flat patches neutral", "default"
WORDS_WINTER, WORDS_SUMMER = "FAB-MAP, winter", "FAB-MAP, same season"
COLOUR = {V1: "grey", NEUTRAL: "orange", DEFAULT: "blue", WORDS_WINTER: "red", WORDS_SUMMER: "green"}
N_TRAINING, N_WORDS, ENLARGED = 400, 200, 4  # frames that words are learnt from, words, times larger for the detector


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One way to match every so many frames.

    Parameters
    ----------
    way : what is done
    every : frames from one that is used to the next
    sequence_length : ds; 1 for single frames
    n_frames : of each season; 0 if the recording was not found
    """

    way: str
    every: int
    sequence_length: int
    n_frames: int


def grid(scale: str) -> Sequence[Cell]:
    """Every frame, third, fifth and tenth, or the last two of these; FAB-MAP on every tenth."""
    n_frames = len(nordland("summer"))
    spacings = (1, 3, 5, 10) if scale == "full" else (5, 10)
    cells = [
        Cell(way=way, every=every, sequence_length=length, n_frames=n_frames)
        for every in spacings
        for length in (10, 20)
        for way in (V1, NEUTRAL, DEFAULT)
    ]
    return cells + [
        Cell(way=way, every=10, sequence_length=1, n_frames=n_frames) for way in (WORDS_WINTER, WORDS_SUMMER)
    ]


def simulate(cell: Cell, seed: int) -> Arrays:
    """How many frames of the map each match is off, and its score; NaN where there is no query or no match."""
    off, score, n_features = np.full(N_NORDLAND, np.nan), np.full(N_NORDLAND, np.nan), np.nan
    if cell.n_frames:
        if cell.way in (WORDS_WINTER, WORDS_SUMMER):
            *found, n_features = _by_words(cell, seed)
        else:
            found = [*_by_sequences(cell)]
        off[: len(found[0])], score[: len(found[1])] = found
    return {
        "off": (("query",), off, {"units": "frame of the map"}),
        "score": (("query",), score),
        "n_features": ((), np.float64(n_features), {"long_name": "mean of the frames of the map, for words"}),
    }


def _by_sequences(cell: Cell) -> tuple[np.ndarray, np.ndarray]:
    seasons = [nordland(season)[:: cell.every] for season in ("summer", "winter")]
    if cell.way == DEFAULT:
        summer, winter = (patch_normalised(frames) for frames in seasons)
        difference = difference_matrix(summer, winter)
        params = SeqSlamParams(sequence_length=cell.sequence_length)
    else:
        flat = 0 if cell.way == V1 else 127
        summer, winter = (patch_normalised(frames, rounded=True, flat_patch=flat) for frames in seasons)
        difference = difference_matrix(summer, winter, "openseqslam-v1")
        params = replace(OPENSEQSLAM_V1, sequence_length=cell.sequence_length)
    matches = seqslam(difference, params)
    off = matches.reference - np.arange(len(matches.reference))
    return np.where(matches.reference >= 0, off, np.nan), matches.score


def _by_words(cell: Cell, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Words of every second frame of the first third; winter, or summer half way between the frames of the map."""
    summer, winter = nordland("summer"), nordland("winter")
    training = _enlarged(np.concatenate([summer[:N_TRAINING:2], winter[:N_TRAINING:2]]))
    vocabulary = build_vocabulary(training, N_WORDS, seed)
    tree = chow_liu_tree(vocabulary.bags(training))
    if cell.way == WORDS_WINTER:
        queries, shift = winter[N_TRAINING :: cell.every], 0.0
    else:
        queries, shift = summer[N_TRAINING + cell.every // 2 :: cell.every], 0.5
    features = [local_features(frame) for frame in _enlarged(summer[N_TRAINING :: cell.every])]
    matches = fabmap(vocabulary.bags_of_features(features), vocabulary.bags(_enlarged(queries)), tree)
    off = matches.reference - (np.arange(len(queries)) + shift)
    n_features = float(np.mean([len(one) for one in features]))
    return np.where(matches.reference >= 0, off, np.nan), matches.score, n_features


def _enlarged(frames: np.ndarray) -> list[np.ndarray]:
    import cv2

    return [cv2.resize(frame, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC) for frame in frames]


def curve_of(arrays: Mapping[str, np.ndarray]) -> PrecisionRecall | None:
    """Precision and recall of one cell, None without matches."""
    is_matched = np.isfinite(arrays["score"])
    if not is_matched.any():
        return None
    return precision_recall(np.abs(arrays["off"][is_matched]) <= TOLERANCE, arrays["score"][is_matched])


def summarise(results: Results) -> Table:
    """A row for each cell."""
    rows = []
    for cell, arrays in results:
        curve = curve_of(arrays)
        row: dict[str, Any] = {
            "way": cell.way,
            "every": cell.every,
            "length": cell.sequence_length,
            "kind": "real recording" if cell.n_frames else MISSING,
            "queries": int(np.isfinite(arrays["score"]).sum()),
            "features_a_frame": float(arrays["n_features"]),
        }
        nothing = float("nan")
        row["precision_of_all"] = nothing if curve is None else precision_at_full_recall(curve)
        row["recall_without_error"] = nothing if curve is None else recall_at_full_precision(curve)
        row["area"] = nothing if curve is None else area_under_curve(curve)
        rows.append(row)
    return rows


def draw(results: Results) -> Figure:
    """Precision over recall, a panel for each spacing: dashed for sequences of 10, solid of 20."""
    from matplotlib.figure import Figure

    spacings = list(dict.fromkeys(cell.every for cell in results.cells))
    figure = Figure(figsize=(DOUBLE_COLUMN, 2.3), layout="constrained")
    panels = figure.subplots(1, len(spacings), sharey=True, squeeze=False)[0]
    for axes, letter, every in zip(panels, "abcd", spacings, strict=False):
        for cell, arrays in results:
            if cell.every == every:
                _draw_curve(axes, cell, curve_of(arrays))
        axes.set(xlabel="recall", xlim=(0, 1.03), ylim=(0, 1.03))
        name_panel(axes, letter, "all frames" if every == 1 else f"every {every}{'rd' if every == 3 else 'th'} frame")
    panels[0].set_ylabel("precision")
    handles = [panels[-1].plot([], [], color=COLOURS[colour], label=way)[0] for way, colour in COLOUR.items()]
    for style, label in (("--", "10 steps"), ("-", "20 steps")):
        handles += panels[-1].plot([], [], style, color=COLOURS["black"], linewidth=0.9, label=label)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), columnspacing=1.2, handlelength=1.6)
    return figure


def _draw_curve(axes: Axes, cell: Cell, curve: PrecisionRecall | None) -> None:
    if curve is None:
        axes.text(0.5, 0.5, "not found", transform=axes.transAxes, ha="center")
        return
    style = "--" if cell.sequence_length == 10 else "-"
    # A point is drawn where a single one would be no line.
    recall, precision = np.append(0.0, curve.recall), np.append(curve.precision[:1], curve.precision)
    axes.plot(recall, precision, style, drawstyle="steps-pre", color=COLOURS[COLOUR[cell.way]], linewidth=0.9)


def caption(results: Results) -> str:
    """What is shown, and of which frames."""
    n_frames = results.cells[0].n_frames
    used = f"n = {n_frames} frames of each season" if n_frames else MISSING
    return (
        f"Nordland, a railway in summer (the map) and winter, frames of 64 × 32 pixels ({used}). Precision over recall "
        f"of matches within {TOLERANCE} frames, frames taken ever farther apart; dashed: sequences of 10 steps, solid: "
        f"of 20, or single frames. FAB-MAP: {N_WORDS} words of SIFT features in frames enlarged {ENLARGED} times, "
        f"learnt from every second of the first {N_TRAINING} frames of both seasons and tried on every tenth of the "
        "others; so small a frame has few features."
    )


def compare(table: Table, published: Mapping[str, Published]) -> Sequence[Verdict]:
    """Numbers of the ICRA 2016 paper beside ours: other recordings."""
    quantities = {V1: "precision of all, vanilla SeqSLAM, BMX track", WORDS_WINTER: "precision, FAB-MAP, BMX track"}
    ours = {}
    for way, name in quantities.items():
        precisions = [100.0 * float(row["precision_of_all"]) for row in table if row["way"] == way]
        ours[name] = max(precisions, default=float("nan"))
    return [judge(value, ours[value.quantity], not_comparable=OTHER_RECORDING) for value in published.values()]
