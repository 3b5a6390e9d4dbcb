"""The sky cut out of a folder of photographs or a video, measured against the truth where there is one."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, check_choice, check_count, quoted
from insectnav.datasets.image_folder import (
    PICTURES,
    RAW,
    VIDEOS,
    FoundImages,
    find_images,
    find_truth,
    read_mask,
)
from insectnav.experiments.mask_pictures import write_mask, write_overlay
from insectnav.experiments.picture_sources import Source, in_order, sources
from insectnav.experiments.results import PROVENANCE, provenance, results_folder, to_json, write_table, written_to
from insectnav.experiments.segmentation_scores import check_truth, compare_methods, score, summarise
from insectnav.vision.sky_channels import CHANNELS, MORE_CHANNELS
from insectnav.vision.sky_geometry import VIEWS, checked_mask
from insectnav.vision.sky_segmentation import CLUSTERS, METHODS, SkyMask, segment
from insectnav.vision.sky_sequences import RecentMasks, smooth
from insectnav.vision.sky_training import Counts, best_threshold, label_counts
from insectnav.workers import count_workers

Bools = NDArray[np.bool_]

SKY_COLOUR = ("skylight", "rgb")  # a method that is no cluster and takes three bands
TRAINED = "trained"  # the one method that needs the truth of other pictures
ALL_METHODS = (*METHODS, TRAINED)
MAX_NAMED = 5  # skipped files that are told one by one


@dataclass(frozen=True, kw_only=True)
class SegmentParams:
    """What `insectnav segment` is run with; see `insectnav.vision.sky_segmentation.segment`.

    Raises
    ------
    InputError
        If a name is unknown, or options do not go together.
    """

    methods: tuple[
        str, ...
    ] = ()  # NAME or NAME:CHANNELS; none: skylight for pictures in colour, watershed for those of one channel
    channels: str | None = None
    view: str = "ahead"
    radius: float | None = None
    mask: str | None = None  # file: 0 where pixels are to be left out
    threshold: float | None = None
    leave_out_flare: bool = False
    smooth: int = 1  # frames that vote
    step: int = 1  # every so many frames of a video
    seed: int = 0

    def __post_init__(self) -> None:
        for method, channels in (self.parts(one) for one in self.methods or ("skylight",)):
            check_choice("method", method, ALL_METHODS)
            if channels is not None:
                check_choice("channels", channels, [name for name in CHANNELS if name != "uv-green"])
            if channels in MORE_CHANNELS and method not in CLUSTERS and (method, channels) != SKY_COLOUR:
                raise InputError(f"channels {channels} are more than one, but method {method} takes one")
        check_choice("view", self.view, VIEWS)
        if self.radius is not None and self.view != "up":
            raise InputError("--radius is given, expected it with --view up alone")
        twice = [method for method, n in Counter(self.methods).items() if n > 1]
        if twice:
            raise InputError(f"method {twice[0]} is given twice, expected each once")
        if (self.threshold is not None) != any(self.parts(one)[0] == "fixed" for one in self.methods):
            raise InputError("--threshold and --method fixed are expected together, but only one of them is given")
        check_count("smooth", self.smooth)
        check_count("step", self.step)
        check_count("seed", self.seed, minimum=0)

    def parts(self, method: str) -> tuple[str, str | None]:
        """Method and channels of what was asked for, the latter None where they follow from the method."""
        name, colon, channels = method.partition(":")
        return name, channels if colon else self.channels

    @property
    def trained(self) -> tuple[str, ...]:
        """The methods asked for that have to be trained."""
        return tuple(one for one in self.methods if self.parts(one)[0] == TRAINED)


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """One picture and its masks by method, or why there are none."""

    source: Source
    picture: NDArray[Any] = field(default_factory=lambda: np.empty((0, 0)))
    truth: tuple[Bools, Bools] | None = None
    found: Mapping[str, SkyMask] = field(default_factory=dict)
    refusal: str = ""


def run(
    places: Sequence[str | PathLike[str]],
    params: SegmentParams,
    destination: str | PathLike[str],
    truth: str | PathLike[str] | None = None,
    progress: Callable[[int], Any] | None = None,
) -> dict[str, Any]:
    """Segment, measure, and leave masks, overlays and tables in a folder: the report, also as JSON.

    Parameters
    ----------
    places : photographs, folders of them, and videos
    params : SegmentParams
    destination : a new folder, or one of earlier results, which is replaced
    truth : folder of masks of the same names
    progress : called with the number of pictures just finished

    Raises
    ------
    InputError
        If there is no picture that can be used, or the destination cannot be written.
    """
    started = time.perf_counter()
    found = find_images(places, (*PICTURES, *RAW, *VIDEOS))
    if truth is None and params.trained:
        raise InputError("--method trained is given without --truth, expected a folder of masks to train on")
    if truth is not None and not Path(truth).is_dir():
        raise InputError(f"--truth {quoted(truth, 200)} is no folder, expected one of masks")
    used = None if params.mask is None else read_mask(params.mask)[0]
    rows: list[dict[str, Any]] = []
    skipped = list(found.skipped)
    with results_folder(destination) as folder, written_to(destination):
        thresholds = {one: _train(found, truth, params, used, params.parts(one)[1]) for one in params.trained}
        attempts = in_order(
            lambda source: _attempt(source, params, used, truth, thresholds),
            sources(found, params.step),
            count_workers(None),
        )
        for attempt, own in in_order(lambda one: (one, _keep(one, folder)), _smoothed(attempts, params.smooth), 2):
            rows += own
            if attempt.refusal:
                skipped.append((attempt.source.name, attempt.refusal))
            if progress is not None:
                progress(1)
        _check_any(rows, skipped, truth)
        result = _report(rows, skipped, params, truth is not None, found)
        write_table(folder / "table.csv", rows)
        write_table(folder / "methods.csv", list(result["methods"].values()))
        if result["tests"]:
            write_table(folder / "tests.csv", result["tests"])
        (folder / "summary.json").write_text(to_json(result) + "\n", encoding="utf-8")
        (folder / PROVENANCE).write_text(to_json(provenance(time.perf_counter() - started)) + "\n", encoding="utf-8")
    return result


def _attempt(
    source: Source,
    params: SegmentParams,
    used: Bools | None,
    truth: str | PathLike[str] | None,
    thresholds: Mapping[str, Mapping[str, float]],
) -> Attempt:
    """One picture by every method; where one of them fails, none counts, so that all are measured on the same ones."""
    try:
        picture = source.read()
        mask = _truth(source, truth)
        methods = params.methods or (("skylight",) if picture.ndim == 3 else ("watershed",))
        found = {one: _segment(picture, one, params, used, thresholds.get(one, {}).get(source.name)) for one in methods}
        for one in found.values():
            check_truth(one, mask)
    except InputError as error:
        return Attempt(source=source, refusal=str(error))
    return Attempt(source=source, picture=picture, truth=mask, found=found)


def _truth(source: Source, folder: str | PathLike[str] | None) -> tuple[Bools, Bools] | None:
    if folder is None or source.is_frame:
        return None
    path = find_truth(source.file, folder)
    return None if path is None else read_mask(path)


def _smoothed(attempts: Iterable[Attempt], n_frames: int) -> Iterator[Attempt]:
    """The same with each mask voted on by it and those before it."""
    recent: dict[str, RecentMasks] = {}
    for attempt in attempts:
        if n_frames == 1 or attempt.refusal:
            yield attempt
            continue
        found = {}
        for method, one in attempt.found.items():
            recent[method], mask = smooth(recent.get(method, RecentMasks()), one.mask, n_frames)
            found[method] = replace(one, mask=mask & one.valid)
        yield replace(attempt, found=found)


def _keep(attempt: Attempt, folder: Path) -> list[dict[str, Any]]:
    """Mask and overlay of one picture on disk, and its rows of the table."""
    rows = []
    for method, one in attempt.found.items():
        place = (method.replace(":", "-"),) if len(attempt.found) > 1 else ()
        name = attempt.source.name
        write_mask(folder.joinpath("masks", *place, f"{name}.png"), one.mask, one.valid)
        write_overlay(folder.joinpath("overlays", *place, f"{name}.jpg"), attempt.picture, one.mask, one.valid)
        rows.append(_row(attempt.source, method, one, score(one, attempt.truth)))
    return rows


def _segment(
    picture: NDArray[Any], asked: str, params: SegmentParams, used: Bools | None, trained: float | None
) -> SkyMask:
    method, channels = params.parts(asked)
    if method == TRAINED:
        if trained is None:
            raise InputError("no other picture has a mask to train a threshold on, expected --truth for several")
        scale = np.iinfo(picture.dtype).max if picture.dtype.kind == "u" else 1.0
        threshold: float | None = trained * float(scale)
    else:
        threshold = params.threshold if method == "fixed" else None
    return segment(
        picture,
        "fixed" if method == TRAINED else method,
        channels=channels,
        view=params.view,
        radius=params.radius,
        valid=used,
        threshold=threshold,
        leave_out_flare=params.leave_out_flare,
        seed=params.seed,
    )


def _row(source: Source, method: str, found: SkyMask, scores: dict[str, float]) -> dict[str, Any]:
    return {
        "image": source.name,
        "file": str(source.file),
        "method": method,
        "channels": found.channels,
        "sky_fraction": found.sky_fraction,
        "threshold": found.threshold,
        "confidence": found.confidence,
        **scores,
        "notes": "; ".join(found.notes),
    }


def _train(
    found: FoundImages,
    truth: str | PathLike[str] | None,
    params: SegmentParams,
    used: Bools | None,
    channels: str | None,
) -> dict[str, float]:
    """For each picture the threshold that is best on all others, so that none is measured on what it was trained on."""
    counts: dict[str, Counts] = {}
    for source in sources(found, params.step):
        try:
            mask = _truth(source, truth)
            if mask is None:
                continue
            valid = mask[1] if used is None else mask[1] & checked_mask("mask", used, mask[1].shape)
            counts[source.name] = label_counts(source.read(), mask[0], channels=channels, valid=valid)
        except InputError:
            continue  # is named when it is segmented
    if not counts:
        return {}
    total = sum(counts.values(), start=np.zeros_like(next(iter(counts.values()))))
    return {name: best_threshold(total - own) for name, own in counts.items() if (total - own).any(axis=1).all()}


def _check_any(
    rows: Sequence[Mapping[str, Any]], skipped: Sequence[tuple[str, str]], truth: str | PathLike[str] | None
) -> None:
    """Refuse to end with nothing, and with a truth that belongs to no picture."""
    if not rows:
        if len({why for _, why in skipped}) == 1:
            raise InputError(f"no picture could be used, {skipped[0][0]} for one: {skipped[0][1]}")
        raise InputError(
            "no picture could be used: " + "; ".join(f"{name}: {why}" for name, why in skipped[:MAX_NAMED])
        )
    if truth is not None and all(np.isnan(row["accuracy"]) for row in rows):
        example = rows[0]["image"]
        raise InputError(
            f"--truth {quoted(truth, 200)} holds no mask of any picture, expected {example}.png or {example}_sky.png"
        )


def _report(
    rows: Sequence[Mapping[str, Any]],
    skipped: Sequence[tuple[str, str]],
    params: SegmentParams,
    has_truth: bool,
    found: FoundImages,
) -> dict[str, Any]:
    """Everything a program may want to know of a result."""
    notes = ["the threshold of each picture was trained on all others with a mask"] if params.trained else []
    if has_truth and (missing := sorted({row["image"] for row in rows if np.isnan(row["accuracy"])})):
        notes.append(f"{len(missing)} pictures have no mask in --truth, such as {missing[0]}")
    return {
        "images": len({row["image"] for row in rows}),
        "settings": {name: value for name, value in vars(params).items() if value is not None},
        "methods": summarise(rows, has_truth),
        "tests": compare_methods(rows) if has_truth else [],
        "skipped": [{"name": name, "reason": why} for name, why in skipped],
        "notes": notes,
        "results": rows,
    }
