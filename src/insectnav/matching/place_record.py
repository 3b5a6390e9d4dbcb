"""The file that says what a folder is: a map of places, of which kind, in which state."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from insectnav.checks import InputError
from insectnav.matching.place_about import MapAbout, about_from_json
from insectnav.matching.place_store import DamagedError, read_json, shown, write_json

MAP_FILE = "map.json"
FORMAT, VERSION = "insectnav places", 1
FOLDER = re.compile(r"(places|index)-[0-9a-f]{8}")


@dataclass(frozen=True, kw_only=True)
class MapRecord:
    """What the file of a map says.

    Parameters
    ----------
    about : MapAbout
    places : name of the folder that holds all places; None for a map that may be added to
    index : name of the folder of the index; None without
    """

    about: MapAbout
    places: str | None = None
    index: str | None = None


def write_record(folder: Path, record: MapRecord) -> None:
    """Put the record in its place; from then on the map is what it says."""
    words: dict[str, Any] = {"format": FORMAT, "version": VERSION, "about": record.about.as_json()}
    write_json(folder / MAP_FILE, words | {"places": record.places, "index": record.index})


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
        raise InputError(f"{shown(folder)} is no map of places: it has no file {MAP_FILE}") from None
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
    names = [words.get("places"), words.get("index")]
    is_right = (
        version == VERSION
        and set(words) == {"format", "version", "about", "places", "index"}
        and all(name is None or (isinstance(name, str) and FOLDER.fullmatch(name)) for name in names)
    )
    if not is_right:
        raise DamagedError(f"the {MAP_FILE} of the map {shown(folder)} is not as it was written: damaged?")
    try:
        about = about_from_json(words["about"])
    except InputError as error:
        raise DamagedError(f"the {MAP_FILE} of the map {shown(folder)} is damaged: {error}") from None
    return MapRecord(about=about, places=names[0], index=names[1])
