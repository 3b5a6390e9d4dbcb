"""Maps built from frames: described, thinned, and put on disk a batch at a time, so that what is there stays."""

from __future__ import annotations

import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.experiments.place_maps.describe import DescribeParams
from insectnav.experiments.place_maps.describing import Described, Remarks, described, settled, stacked
from insectnav.experiments.place_maps.frames import Frame
from insectnav.experiments.place_maps.opening import FrameParams, opened
from insectnav.experiments.place_maps.thumbnails import keep_thumbnails
from insectnav.experiments.results import check_room
from insectnav.experiments.store import locked
from insectnav.matching.place_store import check_named, written
from insectnav.matching.places import MapAbout, PlaceMap

UNFINISHED = "unfinished.json"  # in a map while frames are being added to it
ADDING = "adding"  # in a map, held by the one process that adds frames
BATCH, BATCH_S = 512, 10.0  # frames, and seconds, after which they are put on disk
MAX_BYTES = 1_000_000  # of the record of what is unfinished


@dataclass(frozen=True, kw_only=True)
class BuildParams:
    """How a map is built.

    Parameters
    ----------
    frames : which frames are taken
    adds : whether frames are added to a map that is there
    freezes : whether the map is closed and indexed at the end
    """

    frames: FrameParams = field(default_factory=FrameParams)
    adds: bool = False
    freezes: bool = False


def build(
    places: Sequence[str],
    folder: str | os.PathLike[str],
    params: BuildParams,
    progress: Callable[[int], Any] | None = None,
) -> dict[str, Any]:
    """Build a map, or add to it: the report.

    Parameters
    ----------
    places : folders, patterns, films, an array, a recording
    folder : of the map
    params : BuildParams
    progress : called with the number of frames just put on disk

    Raises
    ------
    InputError
        If no frame can be used, the map is there and `adds` is false, or it was made with other settings.
    """
    started = time.perf_counter()
    path, remarks = Path(folder), Remarks()
    place_map = _existing(path, params.adds)
    with ExitStack() as held:
        if place_map is not None:
            held.enter_context(locked(path / ADDING))
        given = opened(places, params.frames, place_map.about if place_map else None)
        record = _record(places, params.frames)
        n_before, n_done = _progress_before(path, place_map, record)
        describe, frames, more = _settled(given.frames, given.describe, n_done)
        run = _Run(
            path=path,
            pictures=params.frames.pictures,
            describe=describe,
            origin_deg=given.origin_deg,
            record=record,
            first=n_before,
            held=held,
        )
        ready = _told(described(frames, describe, params.frames.pictures, params.frames.workers), remarks)
        try:
            run.add_all(place_map, ready, n_done, progress)
            if not n_done:
                remarks.check_any()
        except InputError:
            run.take_back()
            raise
        result = PlaceMap.open(path)
        if params.freezes and not result.is_frozen:
            result.freeze()
        (path / UNFINISHED).unlink(missing_ok=True)
    notes = [*given.notes, *more, *remarks.sentences(describe.used_metric)]
    seconds = time.perf_counter() - started
    done = {"map": str(folder), "frames_from_earlier_run": n_done, "seconds": seconds}
    return done | remarks.counts | {"frames_per_second": remarks.n_frames / seconds} | facts(result) | {
        "taken": params.frames.thinning.in_words,
        "skipped": [{"name": name, "reason": why} for name, why in given.source.skipped],
        "notes": notes,
    }  # fmt: skip


def facts(place_map: PlaceMap) -> dict[str, Any]:
    """What a map holds, for a program.

    Parameters
    ----------
    place_map : PlaceMap
    """
    about, known = place_map.about, np.isfinite(place_map.positions[:, :2]).all(axis=1)
    routes = place_map.routes
    way = place_map.positions[known, :2]
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)[np.diff(routes[known]) == 0]
    times = place_map.times
    return {
        "places": place_map.n_places,
        "routes": int(routes.max()) + 1 if len(routes) else 0,
        "descriptor": about.descriptor,
        "metric": about.metric,
        "features": about.n_features,
        "camera": about.camera,
        "settings": dict(about.settings),
        "origin_deg": about.origin_deg,
        "is_frozen": place_map.is_frozen,
        "with_position": int(known.sum()),
        "with_time": int(np.isfinite(times).sum()),
        "length_m": float(steps.sum()) if len(steps) else None,
        "spacing_m": float(np.median(steps)) if len(steps) else None,
        "bytes": sum(path.stat().st_size for path in place_map.path.rglob("*") if path.is_file()),
    }


@dataclass(kw_only=True)
class _Run:
    """Places on their way to disk."""

    path: Path
    pictures: bool
    describe: DescribeParams
    origin_deg: tuple[float, float] | None
    record: dict[str, Any]
    first: int  # place of the first frame of this route
    held: ExitStack  # lets go of the map at the end
    is_new: bool = False
    has_record: bool = False  # whether this run, not another, said what is unfinished

    def add_all(
        self,
        place_map: PlaceMap | None,
        frames: Iterator[Described],
        n_done: int,
        progress: Callable[[int], Any] | None,
    ) -> None:
        """Add all frames in batches; the map is made when the first frame has features."""
        batch: list[Described] = []
        last = time.monotonic()
        for one in frames:
            batch.append(one)
            is_due = len(batch) >= BATCH or time.monotonic() - last > BATCH_S
            if is_due and any(item.features is not None for item in batch):
                place_map = self._add(place_map, batch, n_done)
                n_done += len(batch)
                if progress is not None:
                    progress(len(batch))
                batch, last = [], time.monotonic()
        if batch and (place_map is not None or any(item.features is not None for item in batch)):
            self._add(place_map, batch, n_done)
            if progress is not None:
                progress(len(batch))

    def _add(self, place_map: PlaceMap | None, batch: list[Described], n_done: int) -> PlaceMap:
        if place_map is None:
            place_map = PlaceMap.create(self.path, self._about(batch))
            self.held.enter_context(locked(self.path / ADDING))
            self.is_new = True
        if n_done == 0:
            _write_record(self.path, self.record | {"first_place": self.first})
            self.has_record = True
        about, n_before = place_map.about, place_map.n_places
        if n_done == 0 or any(one.features is not None for one in batch):  # the last ones may all be missing
            about.check_same(self._about(batch), "the frames")
        if self.pictures:  # first, or places whose run is killed here would never have any
            keep_thumbnails(self.path, n_before, [one.picture for one in batch])
        place_map.add(
            stacked([one.features for one in batch], about.n_features, about.metric),
            times=[one.frame.time for one in batch],
            positions=np.stack([one.frame.position for one in batch]),
            names=[one.frame.name for one in batch],
            new_route=n_done == 0 and n_before > 0,
        )
        return place_map

    def take_back(self) -> None:
        """Leave nothing half-written behind, nor a record of a route of which there is nothing to go on with."""
        if self.is_new:
            shutil.rmtree(self.path, ignore_errors=True)
        elif self.has_record and PlaceMap.open(self.path).n_places == self.first:
            (self.path / UNFINISHED).unlink(missing_ok=True)

    def _about(self, batch: list[Described]) -> MapAbout:
        sizes = [len(one.features) for one in batch if one.features is not None]
        if not sizes:
            raise InputError("no frame of these can be described, expected some")
        return MapAbout(
            descriptor=self.describe.descriptor,
            metric=self.describe.used_metric,
            n_features=sizes[0],
            camera="" if self.describe.is_vectors else self.describe.camera.text,
            settings=self.describe.settings(),
            origin_deg=self.origin_deg,
        )


def _existing(path: Path, adds: bool) -> PlaceMap | None:
    """The map that is there; none where a new one is to be built, for which there is room."""
    with written(path):
        return _there(path, adds)


def _there(path: Path, adds: bool) -> PlaceMap | None:
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        if adds:
            raise InputError(f"{quoted(path, 200)} does not exist, expected a map to add to: without --add it is built")
        check_named(path)
        check_room(path.absolute(), f"the map {quoted(path, 200)}")
        return None
    if not adds:
        if (path / UNFINISHED).exists():
            raise InputError(
                f"{quoted(path, 200)} is a map whose building was interrupted, expected --add to go on with it"
            )
        raise InputError(f"{quoted(path, 200)} exists, expected a new name, or --add to add another route to a map")
    place_map = PlaceMap.open(path)
    if place_map.is_frozen and not (path / UNFINISHED).exists():
        raise InputError(f"the map {quoted(path, 200)} is frozen, expected one that can be added to")
    check_room(path / UNFINISHED, f"the map {quoted(path, 200)}")
    return place_map


def _record(places: Sequence[str], params: FrameParams) -> dict[str, Any]:
    """What makes two builds the same, so that one may go on with the other."""
    where = asdict(params.where)
    for name in ("times", "positions"):
        if where[name] and Path(where[name]).exists():
            where[name] = str(Path(where[name]).resolve())
    own = {"places": [str(Path(place).absolute()) for place in places], "topic": params.topic}
    return json.loads(json.dumps(own | {"thinning": asdict(params.thinning), "where": where}))


def _progress_before(path: Path, place_map: PlaceMap | None, record: Mapping[str, Any]) -> tuple[int, int]:
    """Place of the first frame of this route, and how many of its frames are in the map already."""
    if place_map is None:
        return 0, 0
    unfinished = path / UNFINISHED
    if not unfinished.exists():
        return place_map.n_places, 0
    found: Any = None
    with suppress(OSError, ValueError):
        if unfinished.stat().st_size <= MAX_BYTES:
            found = json.loads(unfinished.read_text(encoding="utf-8"))
    first = found.pop("first_place", None) if isinstance(found, dict) else None
    if not isinstance(first, int) or not 0 <= first <= place_map.n_places:
        raise InputError(f"{quoted(unfinished, 200)} is damaged, expected what an interrupted build left: remove it")
    if found != record:
        raise InputError(
            f"an interrupted build of {quoted(path, 200)} took {', '.join(map(str, found.get('places', [])))[:200]} "
            f"with other options, expected the same to go on with it: or remove {UNFINISHED} to leave that route as "
            "it is"
        )
    return first, place_map.n_places - first


def _write_record(path: Path, record: Mapping[str, Any]) -> None:
    temporary = path / f".{UNFINISHED}.partial"
    temporary.write_text(json.dumps(record, indent=2), encoding="utf-8")
    temporary.replace(path / UNFINISHED)


def _settled(
    frames: Iterator[Frame], describe: DescribeParams, n_done: int
) -> tuple[DescribeParams, Iterator[Frame], list[str]]:
    """As `settled` of the frames that are left, of which there may be none where some are done."""
    next(islice(frames, n_done, n_done), None)
    try:
        return settled(frames, describe)
    except InputError:
        if not n_done:
            raise
        return describe, iter(()), []


def _told(frames: Iterator[Described], remarks: Remarks) -> Iterator[Described]:
    for one in frames:
        remarks.add(one)
        yield one
