"""Frames of two recordings that a person has matched."""

from os import PathLike
from pathlib import Path

import numpy as np

from insectnav.angles import Floats
from insectnav.checks import InputError, quoted
from insectnav.datasets.table_columns import find_columns, likely_slip, listed
from insectnav.datasets.text_tables import open_table, read_numbers

_COLUMNS = {word: dict.fromkeys((word, f"{word}_frame"), 1.0) for word in ("query", "reference")}


def read_key_frames(path: str | PathLike[str]) -> Floats:
    """Numbers (key frame, 2) of corresponding frames, for `metrics.place_truth.true_matches_by_frames`.

    Parameters
    ----------
    path : CSV or TSV file with the columns ``query`` and ``reference``; an empty reference says that the place is not
        in the map

    Raises
    ------
    InputError
        If a column is missing, or a query.
    """
    path = Path(path)
    try:
        table = open_table(path)
        chosen = find_columns(table.header, _COLUMNS)
        if len(chosen) < len(_COLUMNS):
            slip = likely_slip(table.header)
            raise InputError(f"no columns query and reference among {listed(table.header)}, expected both{slip}")
        rows, frames = read_numbers(table, [index for index, _ in chosen.values()])
        absent = np.flatnonzero(np.isnan(frames[:, 0]))
        if absent.size:
            raise InputError(f"row {rows[absent[0]]}: the query is missing, expected one in every row")
    except InputError as error:
        raise InputError(f"{quoted(path, limit=200)}: {error}") from None
    return frames
