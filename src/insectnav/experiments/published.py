"""Published numbers, and how ours are held against them."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from insectnav.checks import InputError, quoted
from insectnav.experiments.results import write_table

STANDARD_ERRORS = 3.0  # apart: with a hundred comparisons, two would call several different by chance
AGREES, DIFFERS, NOT_COMPARABLE = "agrees", "differs", "not comparable"


@dataclass(frozen=True, kw_only=True)
class Published:
    """A published number, a row of published.csv.

    Parameters
    ----------
    experiment : name of the experiment
    quantity : name of the quantity
    value : as printed or read; NaN where the text gives words only
    low, high : what the printed or read value stands for: its rounding, the precision of the reading, or what the words
        mean
    standard_error : of the published value, from its number of trials; 0 where none is known
    unit : unit of the numbers
    source : page or figure
    how_read : how the number was got from the source
    """

    experiment: str
    quantity: str
    value: float
    low: float
    high: float
    standard_error: float
    unit: str
    source: str
    how_read: str


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """A published number beside ours: a row of comparison.csv."""

    quantity: str
    published: float
    low: float
    high: float
    ours: float
    uncertainty: float
    unit: str
    verdict: str
    why: str
    source: str
    how_read: str


def read_published(path: Path, experiment: str) -> dict[str, Published]:
    """Published numbers of one experiment, by quantity.

    Raises
    ------
    InputError
        If a row cannot be read, or a quantity stands twice.
    """
    rows: dict[str, Published] = {}
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        for row in reader:
            where = f"{path.name} line {reader.line_num}"
            if list(row) != [field.name for field in fields(Published)] or None in row.values():
                raise InputError(f"{where} has other columns than a published number: a comma in a text?")
            if row["experiment"] != experiment:
                continue
            published = _published(row, where)
            if published.quantity in rows:
                raise InputError(f"{where} repeats {quoted(published.quantity)}, expected it once")
            rows[published.quantity] = published
    return rows


def _published(row: Mapping[str, Any], where: str) -> Published:
    try:
        value = float(row["value"]) if row["value"] else math.nan
        low = float(row["low"]) if row["low"] else value
        high = float(row["high"]) if row["high"] else value
        error = float(row["standard_error"]) if row["standard_error"] else 0.0
        words = {name: str(row[name]) for name in ("experiment", "quantity", "unit", "source", "how_read")}
    except ValueError:
        raise InputError(f"{where} cannot be read, expected numbers: a comma in a text?") from None
    if not low <= high or not error >= 0.0:
        raise InputError(f"{where} says {low:g} to {high:g} ± {error:g}, expected a low end, a high end and an error")
    return Published(value=value, low=low, high=high, standard_error=error, **words)


def with_error(row: Mapping[str, Any], name: str) -> tuple[float, float]:
    """A number in a row of a table, and its standard error, which stands in the column with `_error` at its end."""
    return float(row[name]), float(row[f"{name}_error"])


def more(row: Mapping[str, Any], name: str) -> tuple[float, float]:
    """How much more something is than in a row that says how much less it is itself, and the standard error."""
    less, error = with_error(row, name)
    return -less, error


def surplus(row: Mapping[str, Any], other: Mapping[str, Any], name: str) -> tuple[float, float]:
    """How much more a number is in one row than in another, and the standard error, as if they were drawn apart."""
    (one, error), (two, other_error) = with_error(row, name), with_error(other, name)
    return one - two, float(np.hypot(error, other_error))


def judge(
    published: Published, ours: float, uncertainty: float = 0.0, *, why: str = "", not_comparable: str = ""
) -> Verdict:
    """Verdict on one quantity: it agrees if ours lies within what was published, give or take three standard errors.

    Parameters
    ----------
    published : Published
    ours : float
        In the same unit; NaN is not comparable.
    uncertainty : float
        Standard error of ours.
    why : str
        What we measured of the cause; kept where the verdict is "differs".
    not_comparable : str
        The reason, where the two are not measures of the same thing.
    """
    margin = STANDARD_ERRORS * math.hypot(uncertainty, published.standard_error)
    if not_comparable or not math.isfinite(ours):
        verdict, why = NOT_COMPARABLE, not_comparable or "there is no such number of ours"
    elif published.low - margin <= ours <= published.high + margin:
        verdict, why = AGREES, ""
    else:
        verdict = DIFFERS
    return Verdict(
        quantity=published.quantity,
        published=published.value,
        low=published.low,
        high=published.high,
        ours=ours,
        uncertainty=uncertainty,
        unit=published.unit,
        verdict=verdict,
        why=why,
        source=published.source,
        how_read=published.how_read,
    )


def write_verdicts(path: Path, verdicts: Sequence[Verdict]) -> None:
    """Leave verdicts as comparison.csv."""
    write_table(path, [asdict(verdict) for verdict in verdicts], [field.name for field in fields(Verdict)])


def read_verdicts(path: Path) -> list[Verdict]:
    """Verdicts from a comparison.csv.

    Raises
    ------
    InputError
        If the file is not one.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [_verdict(row) for row in csv.DictReader(file)]
    except (OSError, csv.Error, LookupError, TypeError, ValueError):
        raise InputError(f"{quoted(path, 200)} cannot be read, expected a comparison.csv of insectnav run") from None


def _verdict(row: Mapping[str, Any]) -> Verdict:
    values = dict(row)
    for name in ("published", "low", "high", "ours", "uncertainty"):
        values[name] = float(row[name]) if row[name] else math.nan
    return Verdict(**values)
