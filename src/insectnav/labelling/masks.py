"""Masks of sky and ground from strokes, and how both are stored.

One code for both kinds of file: white is sky, black is ground, and the middle grey is not known: unpainted in a picture
of strokes, and out of reach of all strokes in a mask.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.datasets.image_folder import read_image
from insectnav.datasets.picture_files import write_picture
from insectnav.labelling.pictures import Bytes
from insectnav.vision.growcut import StrokeGrower

UNKNOWN, GROUND, SKY = 0, 1, 2  # labels of GrowCut, and on the wire
GREY = np.array([128, 0, 255], np.uint8)  # of each label, in files


class Shares(NamedTuple):
    """How much of a mask is what.

    Parameters
    ----------
    sky, ground : shares of all pixels
    unreached : number of pixels that no stroke reaches
    """

    sky: float
    ground: float
    unreached: int


def grown(grower: StrokeGrower, strokes: Bytes) -> Bytes:
    """Labels of all pixels, from those of the painted ones.

    Parameters
    ----------
    grower : of the picture
    strokes : (rows, columns) array of labels
    """
    return grower.grow(strokes).labels


def load_kernel() -> None:
    """Have compiled what grows strokes before the first of them is painted."""
    for shape in ((1, 1), (1, 1, 3)):
        grown(StrokeGrower(np.zeros(shape, np.uint8)), np.full((1, 1), SKY, np.uint8))


def shares(labels: Bytes) -> Shares:
    """What a mask consists of."""
    counts = np.bincount(labels.ravel(), minlength=3)
    return Shares(float(counts[SKY] / labels.size), float(counts[GROUND] / labels.size), int(counts[UNKNOWN]))


def read_strokes(path: Path, shape: tuple[int, int]) -> Bytes:
    """Labels (rows, columns) from a picture of strokes.

    Parameters
    ----------
    path : Path
    shape : of the picture that they belong to

    Raises
    ------
    InputError
        If the file is no such picture or of another size.
    """
    pixels = read_image(path)
    shown = quoted(path, 200)
    if pixels.ndim == 3 and (pixels == pixels[..., :1]).all():
        pixels = pixels[..., 0]
    if pixels.ndim == 3 or pixels.dtype != np.uint8:
        raise InputError(f"{shown} is not an 8-bit grey image, expected 255 for sky, 0 for ground, 128 elsewhere")
    if pixels.shape != shape:
        raise InputError(
            f"{shown} has {pixels.shape[1]} × {pixels.shape[0]} pixels, the picture {shape[1]} × {shape[0]}: "
            "strokes of another picture?"
        )
    label = np.full(256, 255, np.uint8)
    label[GREY] = (UNKNOWN, GROUND, SKY)
    strokes = label[pixels]
    if (strokes == 255).any():
        value = int(pixels[strokes == 255][0])
        raise InputError(
            f"{shown} holds the grey {value}, expected 255 for sky, 0 for ground, 128 elsewhere: soft edges or a JPEG?"
        )
    return strokes


def write_labels(path: Path, labels: NDArray[Any]) -> None:
    """Labels as a PNG: of a mask, or of strokes."""
    write_picture(path, GREY[labels])


def mask_from_strokes(picture: Path, strokes: Path, mask: Path) -> Shares:
    """Shares of the mask that strokes grow to on a picture; the mask is left as a PNG.

    Raises
    ------
    InputError
        If a file cannot be used or written.
    """
    pixels = read_image(picture)
    painted = read_strokes(strokes, (pixels.shape[0], pixels.shape[1]))
    if not painted.any():
        raise InputError(f"{quoted(strokes, 200)} is 128 everywhere, expected strokes of 255 (sky) and 0 (ground)")
    labels = grown(StrokeGrower(pixels), painted)
    write_labels(mask, labels)
    return shares(labels)
