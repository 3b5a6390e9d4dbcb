"""Files of one scene through different filters, laid over the first of them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.datasets.image_folder import read_image
from insectnav.datasets.picture_files import write_picture
from insectnav.experiments.results import write_table, written_to
from insectnav.vision.registration import Alignment, RegistrationParams, align

TABLE = "alignment.csv"


def align_files(
    fixed: Path,
    moving: Sequence[Path],
    folder: Path,
    params: RegistrationParams,
    fixed_band: str = "mean",
    moving_band: str = "mean",
) -> list[dict[str, Any]]:
    """A row for each moving picture: how it lies to the fixed one, and the files that were written.

    ``NAME_aligned`` is on the pixels of the fixed picture, of the same type and kind of file as NAME (PNG for what
    would lose); ``NAME_valid.png`` is 255 where it shows something.

    Parameters
    ----------
    fixed, moving : paths of images
    folder : for the results
    params, fixed_band, moving_band
        As of `insectnav.vision.registration.align`.

    Raises
    ------
    InputError
        If a file cannot be used or written, two share a name, or a picture cannot be aligned; nothing is written then.
    """
    stems = [path.stem for path in moving]
    for stem in stems:
        if stems.count(stem) > 1:
            raise InputError(f"two moving pictures are called {quoted(stem)}, their results would share a name")
    pixels = read_image(fixed)
    found = [_aligned(pixels, path, params, fixed_band, moving_band) for path in moving]
    rows = []
    for path, alignment in zip(moving, found, strict=True):
        suffix = path.suffix.lower() if path.suffix.lower() in (".tif", ".tiff", ".png") else ".png"
        aligned, valid = folder / f"{path.stem}_aligned{suffix}", folder / f"{path.stem}_valid.png"
        write_picture(aligned, alignment.aligned)
        write_picture(valid, np.where(alignment.valid, 255, 0).astype(np.uint8))
        rows.append(_row(path, alignment) | {"aligned": str(aligned), "valid": str(valid)})
    with written_to(folder):
        write_table(folder / TABLE, rows)
    return rows


def _aligned(fixed: Any, path: Path, params: RegistrationParams, fixed_band: str, moving_band: str) -> Alignment:
    moving = read_image(path)
    try:
        return align(fixed, moving, params, fixed_band=fixed_band, moving_band=moving_band)
    except InputError as error:
        raise InputError(f"{quoted(path, 200)}: {error}") from None


def _row(path: Path, alignment: Alignment) -> dict[str, Any]:
    matrix = {f"m{i}{j}": float(alignment.matrix[i, j]) for i in range(2) for j in range(3)}
    return {
        "image": str(path),
        "columns_px": float(alignment.shift_px[0]),
        "rows_px": float(alignment.shift_px[1]),
        "rotation_deg": float(np.rad2deg(alignment.rotation)),
        "scale": alignment.scale,
        "valid_share": float(alignment.valid.mean()),
        "mutual_information_nat": alignment.mutual_information,
        "mutual_information_before_nat": alignment.mutual_information_before,
        "fall": alignment.fall,
        "lead": alignment.lead,
        **matrix,
    }
