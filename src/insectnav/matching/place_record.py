"""The file that says what a folder is: a map of places, of which kind, in which state."""

import os
import re
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from itertools import islice
from pathlib import Path
from typing import Any

from insectnav.checks import InputError, did_you_mean, quoted
from insectnav.matching.place_about import MapAbout, about_from_json
from insectnav.matching.place_index import IndexSizes
from insectnav.matching.place_store import DamagedError, read_json, shown, write_json

MAP_FILE = "map.json"
FORMAT, VERSION = "insectnav places", 1
MOST_BESIDE = 10_000  # in a folder that are looked through for a map of a name alike
FOLDER, DIGEST = re.compile(r"(places|index)-[0-9a-f]{8}"), re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True, kw_only=True)
class IndexRecord:
    """What the file of a map says of its index.

    Parameters
    ----------
    folder : its name
    digest : of its arrays, by SHA-256
    sizes : IndexSizes
    """

    folder: str
    digest: str
    sizes: IndexSizes


@dataclass(frozen=True, kw_only=True)
class MapRecord:
    """What the file of a map says.

    Parameters
    ----------
    about : MapAbout
    places : name of the folder that holds all places; None for a map that may be added to
    index : IndexRecord, None without
    """

    about: MapAbout
    places: str | None = None
    index: IndexRecord | None = None


def write_record(folder: Path, record: MapRecord) -> None:
    """Put the record in its place; from then on the map is what it says."""
    words: dict[str, Any] = {"format": FORMAT, "version": VERSION, "about": record.about.as_json()}
    index = record.index
    of_index = None if index is None else {"folder": index.folder, "sha256": index.digest, **asdict(index.sizes)}
    write_json(folder / MAP_FILE, words | {"places": record.places, "index": of_index})


def read_record(folder: Path) -> MapRecord:
    """The record of a map.

    Raises
    ------
    InputError
        If there is none, it is damaged, or newer than this version of insectnav.
    """
    try:
        words = read_json(folder / MAP_FILE)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(_no_map(folder)) from None
    except OSError as error:
        raise InputError(f"the map {shown(folder)} cannot be read ({error.strerror})") from None
    if words.get("format") != FORMAT:
        raise InputError(f"{shown(folder)} is no map of places: its {MAP_FILE} does not say {FORMAT!r}")
    version = words.get("version")
    if type(version) is int and version > VERSION:
        raise InputError(
            f"the map {shown(folder)} has format {version}, expected at most {VERSION}: "
            "made by a newer version of insectnav?"
        )
    places = words.get("places")
    is_right = version == VERSION and set(words) == {"format", "version", "about", "places", "index"}
    if not is_right or not (places is None or _is_like(FOLDER, places)):
        raise DamagedError(f"the {MAP_FILE} of the map {shown(folder)} is not as it was written: damaged?")
    try:
        return MapRecord(about=about_from_json(words["about"]), places=places, index=_index(words["index"]))
    except InputError as error:
        raise DamagedError(f"the {MAP_FILE} of the map {shown(folder)} is damaged: {error}") from None


def _no_map(folder: Path) -> str:
    """Why there is no map: no such folder, and which maps beside it are called alike; a file; another folder."""
    if folder.is_dir():
        return f"{shown(folder)} is no map of places: it has no file {MAP_FILE}"
    if folder.exists():
        return f"{shown(folder)} is no map of places: it is a file, expected the folder of a map"
    hint = did_you_mean(folder.name, _maps_in(folder.parent), quoted)
    return f"{shown(folder)} does not exist, expected the folder of a map{hint}"


def _maps_in(folder: Path) -> list[str]:
    """Names of the maps in a folder, sorted; none if it cannot be read."""
    with suppress(OSError), os.scandir(folder) as found:
        return sorted(one.name for one in islice(found, MOST_BESIDE) if Path(one.path, MAP_FILE).is_file())
    return []


def _is_like(pattern: re.Pattern[str], word: object) -> bool:
    return isinstance(word, str) and pattern.fullmatch(word) is not None


def _index(words: object) -> IndexRecord | None:
    if words is None:
        return None
    names = {"folder", "sha256", *(field.name for field in fields(IndexSizes))}
    if not isinstance(words, dict) or set(words) != names:
        raise InputError(f"what it says of the index is no record of {', '.join(sorted(names))}")
    folder, digest = words.pop("folder"), words.pop("sha256")
    if not _is_like(FOLDER, folder) or not _is_like(DIGEST, digest):
        raise InputError("what it says of the index names no folder or no digest")
    return IndexRecord(folder=folder, digest=digest, sizes=IndexSizes(**words))
