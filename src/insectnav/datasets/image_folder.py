"""Photographs from files and folders: PNG, JPEG and TIFF of 8 and 16 bits, and raw files with the extra `raw`.

Values are left as they are stored. Bands come as red, green, blue. The orientation that a camera wrote into the file is
followed, since up matters.
"""

import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.datasets.picture_headers import read_header

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
RAW = (".nef", ".nrw", ".dng", ".cr2", ".cr3", ".arw", ".raf", ".orf", ".rw2", ".pef")
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".m4v", ".mpg", ".mpeg", ".webm")
MASK_ENDINGS = ("_sky", "_mask", "_truth", "_label", "_labels", "_overlay")  # of names of what belongs to a photograph
MAX_BYTES = 2_000_000_000  # of a file
MAX_PIXELS = 200_000_000  # of a picture

Picture = NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class FoundImages:
    """Files to be read, in natural order within each folder, and the names of others with the reason to skip them."""

    files: tuple[Path, ...]
    skipped: tuple[tuple[str, str], ...] = ()


def natural_order(name: str) -> list[Any]:
    """Sorting key under which frame 10 comes after frame 9."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part.lower()) for part in re.findall(r"\d+|\D+", name)]


def find_images(places: Iterable[str | os.PathLike[str]], kinds: Sequence[str] = (*PICTURES, *RAW)) -> FoundImages:
    """Photographs among files and folders.

    Parameters
    ----------
    places : files, taken as they are, and folders, of which those with a known ending are taken; not their subfolders
    kinds : endings of names, in lower case

    Raises
    ------
    InputError
        If a place does not exist, or nothing is left.
    """
    files: list[Path] = []
    skipped: list[tuple[str, str]] = []
    for place in (named(one) for one in places):
        if place.is_dir():
            found, others = _of_folder(place, kinds)
            files += found
            skipped += others
        elif place.exists():
            files.append(place)
        else:
            raise InputError(f"{quoted(place, 200)} does not exist, expected a photograph or a folder of them")
    if not files:
        raise InputError(f"no photograph is given, expected files or folders with names that end in {', '.join(kinds)}")
    return FoundImages(files=tuple(files), skipped=tuple(skipped))


def named(place: str | os.PathLike[str]) -> Path:
    """The path of a place that a user named; none is not the present folder.

    Raises
    ------
    InputError
        If the name is empty.
    """
    if not os.fspath(place):
        raise InputError("an empty name is given, expected a folder, a file or '.': a variable that is not set?")
    return Path(place)


def _of_folder(folder: Path, kinds: Sequence[str]) -> tuple[list[Path], list[tuple[str, str]]]:
    try:
        entries = sorted(folder.iterdir(), key=lambda path: natural_order(path.name))
    except OSError as error:
        raise InputError(f"folder {quoted(folder, 200)} cannot be read ({error.strerror})") from None
    stems = {path.stem for path in entries}
    files, skipped = [], []
    for path in entries:
        stem = path.stem
        owner = next((stem.removesuffix(end) for end in MASK_ENDINGS if stem.endswith(end)), None)
        if path.is_dir():
            skipped.append((path.name, "a folder"))
        elif path.suffix.lower() not in kinds or path.name.startswith("."):
            skipped.append((path.name, "no photograph by its name"))
        elif owner is not None and owner in stems:
            skipped.append((path.name, f"the mask of {quoted(owner)}, by its name"))
        else:
            files.append(path)
    return files, skipped


def find_truth(photograph: Path, folder: str | os.PathLike[str]) -> Path | None:
    """The mask of a photograph in a folder of them: of the same name, or with _sky, _mask, _truth or _label after it.

    Raises
    ------
    InputError
        If there are several.
    """
    names = [photograph.stem + end for end in ("", *MASK_ENDINGS[:-1])]
    candidates = [Path(folder) / (name + kind) for name in names for kind in (".png", ".tif", ".tiff")]
    found = [path for path in candidates if path.is_file() and not _is_same(path, photograph)]
    if len(found) > 1:
        raise InputError(f"{quoted(photograph.name)} has several masks, such as {found[0].name} and {found[1].name}")
    return found[0] if found else None


def _is_same(one: Path, other: Path) -> bool:
    return other.exists() and os.path.samefile(one, other)


def read_image(path: str | os.PathLike[str]) -> Picture:
    """One photograph, (rows, columns) or (rows, columns, 3) red, green, blue; uint8 or uint16.

    Raises
    ------
    InputError
        If it is no picture, is truncated, or is too large.
    """
    place = Path(path)
    name = quoted(place.name, 200)
    if place.suffix.lower() in RAW:
        return _read_raw(place, name)
    return decoded_image(_bytes(place, name), name)


def as_text(name: str) -> str:
    """A name of a file in characters that can be written: bytes that are no UTF-8 become a mark.

    Parameters
    ----------
    name : as the system gives it
    """
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def decoded_image(data: bytes, name: str) -> Picture:
    """A picture of the bytes of a file, as `read_image` gives it.

    Parameters
    ----------
    data : PNG, JPEG or TIFF
    name : what to call it in a sentence

    Raises
    ------
    InputError
        If it is no picture, is truncated, or is too large.
    """
    header = read_header(data)
    if header is None:
        raise InputError(f"{name} is no PNG, JPEG or TIFF picture, expected one: another kind of file under this name?")
    if not 0 < header.rows * header.columns <= MAX_PIXELS:
        raise InputError(f"{name} has {header.rows} × {header.columns} pixels, expected at most {MAX_PIXELS:.0e}")
    if not header.is_complete:
        raise InputError(f"{name} ends before its picture does, expected a whole {header.kind}: copied in part?")
    return _decoded(data, name, header.kind)


def _decoded(data: bytes, name: str, kind: str) -> Picture:
    import cv2

    picture: Any
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR)
    except cv2.error:
        picture = None
    if picture is None:
        raise InputError(f"{name} cannot be decoded, expected a sound {kind}: damaged?")
    if picture.dtype not in (np.uint8, np.uint16, np.float32):
        raise InputError(f"{name} holds {picture.dtype} values, expected 8 or 16 bits or single precision")
    return cv2.cvtColor(picture, cv2.COLOR_BGR2RGB) if picture.ndim == 3 else picture


def read_mask(path: str | os.PathLike[str]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Sky of a mask file (rows, columns), and where it is known: white is sky, black is not, 128 is unknown.

    Raises
    ------
    InputError
        If it is no picture, or holds other values, as a photograph or a mask stored as JPEG does.
    """
    picture = read_image(path)
    name = quoted(Path(path).name, 200)
    if picture.ndim == 3:
        if not (picture == picture[..., :1]).all():
            raise InputError(f"{name} is in colour, expected a mask of black and white: the photograph itself?")
        picture = picture[..., 0]
    white = int(picture.max())
    known = picture != 128
    values = np.unique(picture[known])
    if len(values) > 2 or (len(values) == 2 and values[0] != 0):
        raise InputError(
            f"{name} holds {len(values)} values, such as {values[0]} and {values[1]}, expected 0, one for sky, and 128 "
            "for unknown: a photograph, or a mask that was stored as JPEG or resized?"
        )
    return known & (picture == white) & (white > 0), known


def _bytes(place: Path, name: str) -> bytes:
    _check_size(place, name)
    try:
        return place.read_bytes()
    except OSError as error:
        raise InputError(f"{name} cannot be read ({error.strerror})") from None


def _check_size(place: Path, name: str) -> None:
    """Refuse a file that is not there, empty or too large."""
    try:
        size = place.stat().st_size
    except OSError as error:
        raise InputError(f"{name} cannot be read ({error.strerror})") from None
    if not 0 < size <= MAX_BYTES:
        raise InputError(f"{name} has {size} bytes, expected 1 to {MAX_BYTES:.0e}")


def _read_raw(place: Path, name: str) -> Picture:
    """A raw file demosaiced to 16 bits, linear, white of the sensor at the full scale, and nothing else done to it.

    Neither is the black level taken off nor are the bands weighed, since either would move the sky against the ground;
    the bands stay those of the sensor.
    """
    try:
        import rawpy
    except ImportError:
        raise InputError(f"{name} is a raw file, expected the extra raw for it: pip install insectnav[raw]") from None
    _check_size(place, name)
    try:
        with rawpy.imread(str(place)) as raw:
            if raw.sizes.height * raw.sizes.width > MAX_PIXELS:
                raise InputError(f"{name} has {raw.sizes.height} × {raw.sizes.width} pixels, expected fewer")
            picture = raw.postprocess(
                gamma=(1, 1),
                no_auto_bright=True,
                user_wb=[1.0, 1.0, 1.0, 1.0],
                user_black=0,
                output_color=rawpy.ColorSpace.raw,
                output_bps=16,
                adjust_maximum_thr=0.0,
            )
    except rawpy.LibRawError as error:
        why = error.args[0].decode() if error.args and isinstance(error.args[0], bytes) else str(error)
        raise InputError(
            f"{name} cannot be decoded as a raw file ({why}): truncated, or another kind of file?"
        ) from None
    return np.ascontiguousarray(picture)
