"""Masks as files: for programs as black and white, for people over the photograph."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.datasets.picture_files import write_picture

Bools = NDArray[np.bool_]

LEFT_OUT_GREY = 128  # in a mask, of what was left out; white is sky, black is not
OUTLINE = (213, 94, 0)  # red, green, blue; vermillion of Okabe & Ito (2008), which no sky and no plant has
TINT, TINT_SHARE = (86, 180, 233), 0.35  # of the sky, and how much of it
DARKENED = 0.35  # brightness of what was left out
OVERLAY_SIDE = 1600  # [px] longer side of an overlay at most


def write_mask(path: Path, mask: Bools, valid: Bools) -> None:
    """PNG of a mask: 255 is sky, 0 is not, 128 was left out."""
    write_picture(path, np.where(valid, np.where(mask, 255, 0), LEFT_OUT_GREY).astype(np.uint8))


def write_overlay(path: Path, picture: NDArray[Any], mask: Bools, valid: Bools) -> None:
    """JPEG of a photograph with its sky tinted and outlined, for a person to judge the mask by."""
    write_picture(path, overlay(picture, mask, valid))


def overlay(picture: NDArray[Any], mask: Bools, valid: Bools) -> NDArray[np.uint8]:
    """A photograph with its sky tinted and outlined, (rows, columns, 3) red, green, blue; large ones are reduced."""
    import cv2

    colours = displayed(picture)
    factor = OVERLAY_SIDE / max(mask.shape)
    if factor < 1.0:
        size = (max(1, round(mask.shape[1] * factor)), max(1, round(mask.shape[0] * factor)))
        colours = cv2.resize(colours, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
        mask = cv2.resize(mask.view(np.uint8), size, interpolation=cv2.INTER_NEAREST).astype(bool)
        valid = cv2.resize(np.ascontiguousarray(valid).view(np.uint8), size, interpolation=cv2.INTER_NEAREST).astype(
            bool
        )
    shown = colours.astype(np.float32)
    shown[mask] += np.float32(TINT_SHARE) * (np.array(TINT, np.float32) - shown[mask])
    shown[~valid] *= np.float32(DARKENED)
    outline = mask & ~cv2.erode(mask.view(np.uint8), np.ones((3, 3), np.uint8), borderValue=1).astype(bool)
    shown[outline] = OUTLINE
    return np.rint(shown).astype(np.uint8)


def displayed(picture: NDArray[Any]) -> NDArray[np.uint8]:
    """A picture of any type as 8-bit colours; what has more than 8 bits is scaled to its 99.5th percentile.

    What is no finite number is black.
    """
    if picture.dtype != np.uint8:
        picture = np.where(np.isfinite(picture), picture, 0)
        white = float(np.percentile(picture, 99.5)) or float(picture.max()) or 1.0
        picture = np.rint(np.clip(picture / white, 0.0, 1.0) * 255.0).astype(np.uint8)
    return np.repeat(picture[..., None], 3, axis=2) if picture.ndim == 2 else picture
