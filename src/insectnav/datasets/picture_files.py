"""Pictures on disk: whole numbers of 8 or 16 bits, or floating-point numbers, each file complete or not there."""

import secrets
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, as_numbers, check_choice, check_range, quoted

FORMATS: Mapping[str, Sequence[int]] = {"png": (8, 16), "tiff": (8, 16, 32)}  # and the bits that each can hold
_PNG_LEVEL = 4  # of 9: half of the time of the highest for a few per cent of the size

Pictures = npt.NDArray[Any]


def check_format(name: str, bits: int) -> None:
    """Refuse a file format that is unknown or cannot hold numbers of that many bits.

    Parameters
    ----------
    name : "png" or "tiff"
    bits : 8 or 16 for whole numbers, 32 for floating-point numbers

    Raises
    ------
    InputError
    """
    check_choice("format", name, tuple(FORMATS))
    if bits not in FORMATS[name]:
        held = " or ".join(map(str, FORMATS[name]))
        slip = ": --format tiff?" if bits in FORMATS["tiff"] else ""
        raise InputError(f"bits is {bits}, expected {held} in {name.upper()}{slip}")


def quantised(values: npt.ArrayLike, bits: int = 8) -> Pictures:
    """Whole numbers (...) from 0 to 2^bits − 1 of values in 0…1; what is beyond is cut off.

    Parameters
    ----------
    values : (...) array
    bits : 8 or 16

    Raises
    ------
    InputError
        If the number of bits is another, or a value is no number.
    """
    if bits not in (8, 16):
        raise InputError(f"bits is {bits}, expected 8 or 16")
    shares = np.clip(as_numbers("values", values), 0.0, 1.0)
    check_range("values", shares, 0.0, 1.0)  # NaN
    return np.rint(shares * (2**bits - 1)).astype(np.uint8 if bits == 8 else np.uint16)


def write_picture(path: Path, picture: Pictures) -> None:
    """Write a picture under a temporary name, then rename it; its folder is made where there is none.

    Parameters
    ----------
    path : Path
        Ends in .png, .tiff, or .jpg for people.
    picture : (row, column) or (row, column, 3) array
        uint8 or uint16, or float32 in a TIFF; the last axis is red, green, blue.

    Raises
    ------
    InputError
        If the place cannot be written.
    """
    import cv2

    shown = picture[..., ::-1] if picture.ndim == 3 else picture
    settings = [cv2.IMWRITE_PNG_COMPRESSION, _PNG_LEVEL] if path.suffix == ".png" else []
    done, content = cv2.imencode(path.suffix, np.ascontiguousarray(shown), settings)
    if not done:
        raise ValueError(f"{path.name}: a picture of {picture.dtype} {picture.shape} cannot be written")
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(content.tobytes())
        temporary.rename(path)
    except OSError as error:
        raise InputError(f"{quoted(path, 200)} cannot be written ({error.strerror})") from None
    finally:
        with suppress(OSError):
            temporary.unlink()
