"""Render a world from all the poses of a path, frame by frame, into a folder of labelled pictures."""

import time
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from insectnav.experiments.rendering.contact_sheet import draw_sheet
from insectnav.experiments.rendering.frame_store import SHEET, FrameStore, prepared
from insectnav.experiments.rendering.frame_table import frame_rows, write_frame_table
from insectnav.experiments.rendering.frames import Frames, whites_of
from insectnav.experiments.rendering.pictures import layers_of
from insectnav.experiments.rendering.plan import Plan
from insectnav.experiments.rendering.scenes import scene_at
from insectnav.experiments.results import provenance
from insectnav.workers import Threads, count_workers

VALUES_AT_ONCE = 16_000_000  # of all layers of the frames that are in memory: 64 MB


def run(
    plan: Plan,
    destination: str | PathLike[str],
    *,
    resume: bool = False,
    replaces: bool = False,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> dict[str, Any]:
    """Render all frames into a folder, which appears when it is complete; what a program may want to know of it.

    Parameters
    ----------
    plan : Plan
    destination : path
        A new folder.
    resume : bool
        Go on with what an earlier run left.
    replaces : bool
        Do without earlier frames in the same place.
    workers : int or None
        Threads; None for as many as there are cores. They change nothing in the pictures.
    progress : callable, optional
        Called with the number of frames just finished.

    Raises
    ------
    InputError
        If the destination holds other things or cannot be written, or a frame cannot be rendered.
    """
    started = time.perf_counter()
    count_workers(workers)
    final = Path(destination).resolve()
    about = plan.about()
    report = about | {"folder": str(destination), "frames_from_earlier_run": 0}
    with prepared(final, about, resume=resume, replaces=replaces) as is_there:
        if is_there:
            return report | {"frames_from_earlier_run": len(plan.poses), "seconds": 0.0}
        store = FrameStore(final, about, {name: plan.params.pictures.suffix(name) for name in plan.names})
        found = store.open()
        try:
            rendered = _render_missing(plan, store, found, workers, progress)
        except BaseException:
            store.remove_if_empty()
            raise
        rows = frame_rows(plan.params.light, plan.place, plan.poses, plan.parts, found | rendered)
        write_frame_table(store.folder, rows)
        draw_sheet(store.folder / SHEET, plan, store.path, rows)
        made = {"frames_from_earlier_run": len(found)} | provenance(time.perf_counter() - started)
        store.complete(made)
    return report | {"frames_from_earlier_run": len(found), "seconds": made["seconds"]}


def _render_missing(
    plan: Plan,
    store: FrameStore,
    found: Mapping[int, Any],
    workers: int | None,
    progress: Callable[[int], None] | None,
) -> dict[int, dict[str, Any]]:
    """Render and write the frames that are not there yet; what is known of each."""
    if progress is not None and found:
        progress(len(found))
    missing = [part for part in plan.parts if any(index not in found for index in range(part.first, part.last))]
    rows: dict[int, dict[str, Any]] = {}
    if not missing:
        return rows
    scene = scene_at(plan.params.place, plan.params.light, plan.parts[0].seconds)
    whites = whites_of(plan, scene, workers)
    size = max(1, VALUES_AT_ONCE // (plan.camera.size[0] * plan.camera.size[1] * len(layers_of(plan.names))))
    with Threads(count_workers(workers)) as writers:

        def write(frames: Frames) -> dict[int, dict[str, Any]]:
            def finish(row: int) -> dict[str, Any]:
                pictures, known = frames.pictures(row, whites)
                store.write(frames.indices[row], pictures)
                return known

            return dict(zip(frames.indices, writers.map(finish, range(len(frames.indices))), strict=True))

        for moment in missing:
            scene = scene_at(plan.params.place, plan.params.light, moment.seconds, scene)
            indices = [index for index in range(moment.first, moment.last) if index not in found]
            for chosen in _pieces(indices, size):
                finished = write(Frames(plan, scene, chosen, plan.params.camera.supersampling, workers))
                store.note(finished)
                rows |= finished
                if progress is not None:
                    progress(len(chosen))
    return rows


def _pieces(indices: Sequence[int], size: int) -> list[Sequence[int]]:
    return [indices[first : first + size] for first in range(0, len(indices), size)]
