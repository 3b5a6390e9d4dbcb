"""A map put side by side for good, and its index: what is new is on disk before the file of the map names it."""

import secrets
import shutil
from dataclasses import replace
from pathlib import Path

from insectnav.matching.place_arrays import PlaceArrays
from insectnav.matching.place_index import DIMENSIONS, METRICS_WITH_INDEX, build_index
from insectnav.matching.place_record import FOLDER, IndexRecord, MapRecord, write_record
from insectnav.matching.place_segments import SEGMENTS
from insectnav.matching.place_store import arrays_digest, remove_partial, whole_folder, write_arrays, written


def frozen(path: Path, record: MapRecord, places: PlaceArrays, with_index: bool) -> MapRecord:
    """The record of the map after it was frozen, or its index was made anew. For the one writer.

    Raises
    ------
    InputError
        If the disk is full or the folder may not be written, FAISS is not installed, or all places are missing.
    """
    index = None
    with written(path):
        remove_partial(path)
        if with_index and record.about.metric in METRICS_WITH_INDEX:
            index = _put_index(path, record, places)
        name = record.places
        if name is None:
            name = f"places-{secrets.token_hex(4)}"
            with whole_folder(path / name) as temporary:
                write_arrays(temporary, places.as_arrays())
        record = replace(record, places=name, index=index)
        write_record(path, record)
        _remove_others(path, {name} if index is None else {name, index.folder})
    return record


def _put_index(path: Path, record: MapRecord, places: PlaceArrays) -> IndexRecord:
    name = f"index-{secrets.token_hex(4)}"
    sizes, arrays = build_index(places, record.about.metric)
    with whole_folder(path / name) as temporary:
        write_arrays(temporary, arrays)
        digest = arrays_digest(temporary, DIMENSIONS)
    return IndexRecord(folder=name, digest=digest, sizes=sizes)


def _remove_others(path: Path, names: set[str]) -> None:
    """Drop what the file of the map names no more, or never did."""
    for folder in path.iterdir():
        if folder.name == SEGMENTS or (FOLDER.fullmatch(folder.name) and folder.name not in names):
            shutil.rmtree(folder, ignore_errors=True)
