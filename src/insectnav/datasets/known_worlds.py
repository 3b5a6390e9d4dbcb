"""Worlds that others have published, none of them part of insectnav: their origin, and where to find their files."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from insectnav.checks import InputError, check_choice, quoted

DATA_VARIABLE = "INSECTNAV_DATA"  # the folder of real data


@dataclass(frozen=True, kw_only=True)
class KnownWorld:
    """A mesh of a published world.

    Parameters
    ----------
    file : str
        Its name in the folder of data.
    sha256 : str
        Of the file that our numbers are from.
    origin : str
        Where the mesh was published.
    licence : str
        As seen there.
    about : str
        What it is, in one line.
    grey_share : float
        By which the greys of the file are multiplied in published views; 1 where it has none.
    """

    file: str
    sha256: str
    origin: str
    licence: str
    about: str
    grey_share: float = 1.0


KNOWN_WORLDS: Mapping[str, KnownWorld] = {
    "clearing": KnownWorld(
        file="antworld_clearing_stone2018.npz",
        sha256="3f0637fcf966b3eb08cbf56ef596449bda2eb919040ed643efd321fbfb1f7d7f",
        origin="github.com/XuelongSun/InsectNavigationToolkitModelling, data/World.mat",
        licence="MIT",
        about="trees and tussocks round a clearing, 84 × 79 m, nothing within 12.1 m of the origin",
    ),
    "seville": KnownWorld(
        file="antworld_seville2009.npz",
        sha256="8772973e821999cf2b27eb6a05e35b63f1224e09611bfdb8c7c9e0610bafca11",
        origin="github.com/InsectRobotics/InvertSy, data/Seville2009_world",
        licence="GPL-3",
        about="low vegetation everywhere, 10 × 10 m, after a site near Seville (Baddeley et al. 2012)",
        grey_share=0.6,
    ),
}


def find_world(name: str) -> Path | None:
    """The file of a known world in the folder that the variable INSECTNAV_DATA names; None where it is missing.

    Raises
    ------
    InputError
        If the world is unknown, or a file of that name has other content.
    """
    check_choice("world", name, tuple(KNOWN_WORLDS))
    known, folder = KNOWN_WORLDS[name], os.environ.get(DATA_VARIABLE)
    path = Path(folder or ".") / known.file
    if not folder or not path.is_file():
        return None
    if hashlib.sha256(path.read_bytes()).hexdigest() != known.sha256:
        raise InputError(
            f"{quoted(path, 200)} has another content than the world {name}, expected SHA-256 {known.sha256[:12]}…"
        )
    return path


def world_file(name: str) -> Path:
    """The file of a known world.

    Raises
    ------
    InputError
        If it is not there.
    """
    path = find_world(name)
    if path is None:
        known = KNOWN_WORLDS[name]
        raise InputError(
            f"the world {name} is missing, expected {known.file} in the folder that {DATA_VARIABLE} names: "
            f"its mesh is from {known.origin}"
        )
    return path
