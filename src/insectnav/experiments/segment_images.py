"""The sky cut out of a folder of photographs or a video, measured against the truth where there is one."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
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
    read_image,
    read_mask,
)
from insectnav.datasets.video import video_facts, video_frames
from insectnav.experiments.mask_pictures import write_mask, write_overlay
from insectnav.experiments.results import PROVENANCE, provenance, results_folder, to_json, write_table
from insectnav.experiments.segmentation_scores import SCORES, compare_methods, score, summarise
from insectnav.vision.sky_channels import CHANNELS, MORE_CHANNELS
from insectnav.vision.sky_geometry import VIEWS
from insectnav.vision.sky_segmentation import CLUSTERS, METHODS, SkyMask, segment
from insectnav.vision.sky_sequences import RecentMasks, smooth
from insectnav.vision.sky_training import Counts, best_threshold, label_counts

Bools = NDArray[np.bool_]
Progress = Callable[[int], None]

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
class Source:
    """One picture to come: what to call its results, the file, and what reads it."""

    name: str
    file: Path
    read: Callable[[], NDArray[Any]]
    truth: Path | None = None


@dataclass(kw_only=True)
class Work:
    """What grows while pictures are worked through."""

    rows: list[dict[str, Any]] = field(default_factory=list)
    skipped: list[tuple[str, str]] = field(default_factory=list)
    recent: dict[str, RecentMasks] = field(default_factory=dict)


def sources(found: FoundImages, truth: str | PathLike[str] | None, step: int) -> Iterator[Source]:
    """Pictures in their order, frames of videos among them; names that occur twice are numbered."""
    total = Counter(path.stem for path in found.files)
    seen: Counter[str] = Counter()
    for path in found.files:
        seen[path.stem] += 1
        name = path.stem if total[path.stem] == 1 else f"{path.stem}-{seen[path.stem]}"
        if path.suffix.lower() not in VIDEOS:
            mask = None if truth is None else find_truth(path, truth)
            yield Source(name=name, file=path, read=lambda path=path: read_image(path), truth=mask)  # type: ignore[misc]
            continue
        for number, frame in video_frames(path, step):
            yield Source(name=f"{name}_{number:06d}", file=path, read=lambda frame=frame: frame)  # type: ignore[misc]


def count_pictures(found: FoundImages, step: int) -> int:
    """How many pictures are to come, as far as the files say."""
    videos = [path for path in found.files if path.suffix.lower() in VIDEOS]
    return len(found.files) - len(videos) + sum(-(-video_facts(path).n_frames // step) for path in videos)


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
    work = Work(skipped=list(found.skipped))
    with results_folder(destination) as folder:
        thresholds = {one: _train(found, truth, params, used, params.parts(one)[1]) for one in params.trained}
        for source in sources(found, truth, params.step):
            trained = {one: of_pictures.get(source.name) for one, of_pictures in thresholds.items()}
            _one_picture(source, params, used, trained, folder, work)
            if progress is not None:
                progress(1)
        _check_any(work, truth)
        result = _report(work, params, truth is not None, found)
        write_table(folder / "table.csv", work.rows)
        write_table(folder / "methods.csv", list(result["methods"].values()))
        if result["tests"]:
            write_table(folder / "tests.csv", result["tests"])
        (folder / "summary.json").write_text(to_json(result) + "\n", encoding="utf-8")
        (folder / PROVENANCE).write_text(to_json(provenance(time.perf_counter() - started)) + "\n", encoding="utf-8")
    return result


def _one_picture(
    source: Source,
    params: SegmentParams,
    used: Bools | None,
    trained: Mapping[str, float | None],
    folder: Path,
    work: Work,
) -> None:
    """One picture by every method; what cannot be used is written down and left out, by all methods."""
    try:
        picture = source.read()
        truth = None if source.truth is None else read_mask(source.truth)
        methods = params.methods or (("skylight",) if picture.ndim == 3 else ("watershed",))
        found = {method: _segment(picture, method, params, used, trained.get(method)) for method in methods}
        scores = {method: score(one, truth) for method, one in found.items()}
    except InputError as error:
        work.skipped.append((source.name, str(error)))
        return
    for method, one in found.items():
        if params.smooth > 1:
            work.recent[method], mask = smooth(work.recent.get(method, RecentMasks()), one.mask, params.smooth)
            one = SkyMask(**(vars(one) | {"mask": mask & one.valid}))
            scores[method] = score(one, truth)
        place = (method.replace(":", "-"),) if len(methods) > 1 else ()
        write_mask(folder.joinpath("masks", *place, f"{source.name}.png"), one.mask, one.valid)
        write_overlay(folder.joinpath("overlays", *place, f"{source.name}.jpg"), picture, one.mask, one.valid)
        work.rows.append(_row(source, method, one, scores[method]))


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
    for source in sources(found, truth, params.step):
        if source.truth is None:
            continue
        try:
            sky, known = read_mask(source.truth)
            valid = known if used is None else known & used
            counts[source.name] = label_counts(source.read(), sky, channels=channels, valid=valid)
        except (InputError, ValueError):
            continue  # is named when it is segmented
    total = sum(counts.values(), start=np.zeros_like(next(iter(counts.values()), np.zeros((2, 1), np.int64))))
    return {name: best_threshold(total - own) for name, own in counts.items() if (total - own).any(axis=1).all()}


def _check_any(work: Work, truth: str | PathLike[str] | None) -> None:
    """Refuse to end with nothing, and with a truth that belongs to no picture."""
    if not work.rows:
        names = "; ".join(f"{name}: {why}" for name, why in work.skipped[:MAX_NAMED])
        raise InputError(f"no picture could be used: {names}")
    if truth is not None and all(np.isnan(row["accuracy"]) for row in work.rows):
        example = work.rows[0]["image"]
        raise InputError(
            f"--truth {quoted(truth, 200)} holds no mask of any picture, expected {example}.png or {example}_sky.png"
        )


def _report(work: Work, params: SegmentParams, has_truth: bool, found: FoundImages) -> dict[str, Any]:
    """Everything a program may want to know of a result."""
    notes = ["the threshold of each picture was trained on all others with a mask"] if params.trained else []
    if has_truth and (missing := sorted({row["image"] for row in work.rows if np.isnan(row["accuracy"])})):
        notes.append(f"{len(missing)} pictures have no mask in --truth, such as {missing[0]}")
    if any(path.suffix.lower() in VIDEOS for path in found.files) and has_truth:
        notes.append("frames of videos are not held against --truth")
    return {
        "images": len({row["image"] for row in work.rows}),
        "settings": {name: value for name, value in vars(params).items() if value is not None},
        "methods": summarise(work.rows, has_truth),
        "tests": compare_methods(work.rows) if has_truth else [],
        "skipped": [{"name": name, "reason": why} for name, why in work.skipped],
        "notes": notes,
        "results": work.rows,
    }


__all__ = ["ALL_METHODS", "SCORES", "SegmentParams", "count_pictures", "run", "sources"]
