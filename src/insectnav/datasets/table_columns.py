"""Columns of a table by their meaning, each with its unit in its name."""

import re
from collections.abc import Mapping, Sequence

from insectnav.checks import InputError, quoted
from insectnav.datasets.text_tables import NUMBER

LENGTHS = {"_m": 1.0, "_cm": 0.01, "_mm": 0.001}  # endings of names, and how many metres one of theirs is
_UNIT = re.compile(r"\s*[\[(]\s*(\w+)\s*[\])]$")  # "time [s]", "x (cm)"

Meanings = Mapping[str, Mapping[str, float]]  # meaning → names of columns, and how many of our unit one of theirs is


def find_columns(header: Sequence[str], meanings: Meanings) -> dict[str, tuple[int, float]]:
    """Index of the column of each meaning that there is, and the factor of its unit.

    Parameters
    ----------
    header : names as written; capitals do not matter, and "x [cm]" is x_cm
    meanings : meaning → name of a column → factor

    Raises
    ------
    InputError
        If two columns have one meaning.
    """
    plain = [plain_name(name) for name in header]
    chosen: dict[str, tuple[int, float]] = {}
    for meaning, names in meanings.items():
        found = [(index, names[name]) for index, name in enumerate(plain) if name in names]
        if len(found) > 1:
            labels = " and ".join(quoted(header[index].strip()) for index, _ in found[:2])
            raise InputError(f"both {labels} could be the {meaning} column, expected one: delete the other")
        if found:
            chosen[meaning] = found[0]
    return chosen


def plain_name(name: str) -> str:
    """The name of a column in lower case, its unit after an underscore."""
    return _UNIT.sub(r"_\1", name.strip().lower())


def listed(header: Sequence[str]) -> str:
    """Names of columns inside a sentence, the first twelve of them."""
    more = f" and {len(header) - 12} more" if len(header) > 12 else ""
    return ", ".join(quoted(name.strip()) for name in header[:12]) + more


def likely_slip(header: Sequence[str], absent: Sequence[str] = ()) -> str:
    """The end of a sentence that guesses why columns were not found."""
    if all(NUMBER.fullmatch(name.strip()) for name in header):
        return ": does the table lack its header?"
    without_unit = [name for name in absent if name in map(plain_name, header)]
    if without_unit:
        return f": which unit is {quoted(without_unit[0])} in?"
    return ": is the separator a tab, comma or semicolon?" if len(header) == 1 else ""
