"""Text table with a header -> columns of numbers, each row known by its number in a spreadsheet."""

import csv
import io
import re
from collections.abc import Iterator, Sequence
from itertools import chain, compress, islice
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, quoted

MAX_BYTES = 512 * 2**20
MAX_COLUMNS = 1000
MAX_LINE = 1_000_000  # bytes
MAX_NUMBER = 1e100  # beyond any length or time; squares stay finite
ROWS_AT_ONCE = 1000  # few enough for the processor's cache

SEPARATORS = "\t,;"
MISSING = ("", "nan", "na")
NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
NUMBER_CHARACTERS = frozenset("0123456789+-.eE ")

# What people save under the name of a table, by its first bytes.
SLIPS = {
    b"PK\x03\x04": "a spreadsheet or zip archive: export it as CSV",
    b"\xd0\xcf\x11\xe0": "an old spreadsheet: export it as CSV",
    b"\x1f\x8b": "compressed: unpack it first",
    b"\xff\xfe": "UTF-16: save it as UTF-8",
    b"\xfe\xff": "UTF-16: save it as UTF-8",
}


class Table(NamedTuple):
    """An opened table: column names as written, the rows below, and the number of the first of them."""

    header: list[str]
    rows: Iterator[list[str]]
    first_row: int


def open_table(path: Path, columns: Sequence[str] | None = None) -> Table:
    """Header and rows of a CSV or TSV file; the first line decides on the separator.

    Names of `columns` stand for the header of a file that has none.
    """
    data = read_bytes(path)
    _check_text(data)
    _check_line_lengths(data)
    lines = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline="")
    n_blank, first = next(((n, line) for n, line in enumerate(lines) if line.strip().strip(SEPARATORS)), (0, ""))
    unquoted = re.sub(r'"[^"]*"', "", first)
    separator = max(SEPARATORS, key=unquoted.count)
    rows = csv.reader(chain([first], lines), delimiter=separator, strict=True)
    header = next(iter(_take(rows, 1, n_blank + 1)), [])
    if not "".join(header).strip():
        raise InputError("the file is empty, expected a header and rows of numbers")
    if len(header) > MAX_COLUMNS:
        raise InputError(f"the header names {len(header)} columns, at most {MAX_COLUMNS} are read")
    if columns is None:
        return Table(header, rows, n_blank + 2)
    if len(columns) != len(header):
        raise InputError(f"row {n_blank + 1} has {len(header)} cells, expected {len(columns)}, one for each name given")
    return Table(list(columns), chain([header], rows), n_blank + 1)


def read_numbers(table: Table, wanted: list[int]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Row numbers (n,), and values (n, len(wanted)) of the wanted columns with NaN where missing."""
    rows, values, _ = read_columns(table, wanted, [])
    return rows, values


def read_columns(
    table: Table, wanted: list[int], words: list[int]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64], list[list[str]]]:
    """Row numbers (n,), values (n, len(wanted)) with NaN where missing, and the cells of each column of words."""
    numbers, values, first_row = [], [], table.first_row
    texts: list[list[str]] = [[] for _ in words]
    while rows := _take(table.rows, ROWS_AT_ONCE, first_row):
        is_filled = [bool(text.strip()) for text in map("".join, rows)]
        number = first_row + np.flatnonzero(is_filled)
        first_row += len(rows)
        rows = list(compress(rows, is_filled))
        _check_widths(rows, number, len(table.header))
        if not rows:
            continue
        block = np.empty((len(rows), len(wanted)))
        for k, index in enumerate(wanted):
            block[:, k] = _to_numbers(list(map(itemgetter(index), rows)), number, table.header[index])
        for column, index in zip(texts, words, strict=True):
            column.extend(row[index].strip() for row in rows)
        numbers.append(number)
        values.append(block)
    if not numbers:
        raise InputError("the file holds only a header, expected rows of numbers below it")
    return np.concatenate(numbers), np.concatenate(values), texts


def read_bytes(path: Path, expected: str = "a CSV or TSV file", most: int = MAX_BYTES) -> bytes:
    """All of a file of bounded size; refuses folders and devices."""
    try:
        if path.is_dir():
            raise InputError(f"this is a folder, expected {expected}")
        if not path.exists():
            raise InputError("no such file")
        if not (path.is_file() or path.is_fifo()):
            raise InputError(f"this is a device, expected {expected}")
        _check_size(path.stat().st_size, most)
        with path.open("rb") as file:
            data = file.read(most + 1)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or "not a possible file name"
        raise InputError(f"the file cannot be read ({reason})") from None
    _check_size(len(data), most)
    return data


def _check_size(n_bytes: int, most: int) -> None:
    if n_bytes > most:
        raise InputError(f"the file is larger than {most // 2**20} MB, expected a single recording")


def _check_text(data: bytes) -> None:
    slip = next((f": {words}" for start, words in SLIPS.items() if data.startswith(start)), "")
    if (nul := data.find(b"\0")) >= 0:
        line = data.count(b"\n", 0, nul) + 1
        raise InputError(f"not text (a NUL byte in row {line}), expected CSV or TSV in UTF-8{slip}")
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line, byte = data.count(b"\n", 0, error.start) + 1, data[error.start]
        slip = slip or ": saved in another encoding?"
        raise InputError(f"not text in UTF-8 (byte 0x{byte:02x} in row {line}), expected CSV or TSV{slip}") from None


def _check_line_lengths(data: bytes) -> None:
    for start in range(0, len(data) - MAX_LINE, MAX_LINE):
        stop = start + MAX_LINE
        if data.find(b"\n", start, stop) < 0 and data.find(b"\r", start, stop) < 0:
            raise InputError(f"a line is longer than {MAX_LINE} bytes, expected a table of short rows")


def _take(reader: Iterator[list[str]], n: int, first_row: int) -> list[list[str]]:
    """The next rows, n at most."""
    rows: list[list[str]] = []
    try:
        rows.extend(islice(reader, n))
    except csv.Error as error:
        row = first_row + len(rows)
        if "limit" in str(error):
            n_most = csv.field_size_limit()
            raise InputError(f"row {row} holds a cell of more than {n_most} characters: a quote not closed?") from None
        raise InputError(f"the quotes in row {row} do not pair, expected one before and after a quoted cell") from None
    return rows


def _check_widths(rows: list[list[str]], numbers: npt.NDArray[np.int64], n_columns: int) -> None:
    if set(map(len, rows)) <= {n_columns}:
        return
    n_cells, number = next((len(row), n) for row, n in zip(rows, numbers, strict=True) if len(row) != n_columns)
    slip = "is a cell missing?" if n_cells < n_columns else "a separator too many, or a decimal comma?"
    raise InputError(f"row {number} has {n_cells} cells, expected {n_columns} as in the header: {slip}")


def _to_numbers(cells: Sequence[str], rows: npt.NDArray[np.int64], name: str) -> npt.NDArray[np.float64]:
    if NUMBER_CHARACTERS.issuperset("".join(cells)):
        try:
            values = np.array(list(map(float, cells)))
        except ValueError:
            pass
        else:
            if np.all(np.abs(values) <= MAX_NUMBER):
                return values
    return np.array([_to_number(cell, row, name) for cell, row in zip(cells, rows, strict=True)])


def _to_number(cell: str, row: np.int64, name: str) -> float:
    text = cell.strip()
    if text.lower() in MISSING:
        return np.nan
    if NUMBER.fullmatch(text):
        value = float(text)
        if abs(value) <= MAX_NUMBER:
            return value
        raise InputError(f"row {row}, column {quoted(name)}: {quoted(text)} is larger than any length or time")
    slip = ": a decimal comma?" if NUMBER.fullmatch(text.replace(",", ".", 1)) else ""
    raise InputError(f"row {row}, column {quoted(name)}: {quoted(text)} is not a number{slip}")
