"""Files of a made-up walk, for the tests of whatever reads tracks."""

import re
import tempfile
from pathlib import Path

import pytest

from insectnav.checks import InputError
from insectnav.datasets.tracks import read_track
from insectnav.records import Track


def read(content: str | bytes, **options) -> Track:
    """The track in a file ``walk.csv`` of this content."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_track(path, **options)


def refusal(content: str | bytes, **options) -> str:
    """The sentence with which such a file is refused, without the name of the file."""
    with pytest.raises(InputError) as caught:
        read(content, **options)
    sentence = str(caught.value)
    assert_one_sentence(sentence)
    assert sentence.count("walk.csv") == 1
    return sentence.partition("walk.csv': ")[2]


def assert_one_sentence(sentence):
    assert sentence.isprintable()  # which leaves no line break of any kind
    unquoted = re.sub(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"", "''", sentence)
    assert unquoted.strip()
    assert not re.search(r"[.!?]( |$)(?<!\?$)", unquoted)


def rows(n=12, interval=0.1, first=0):
    """Cells of a straight walk: time, x = 2 i, y = -i for sample i."""
    return [[f"{(first + i) * interval:.4f}", f"{2 * i}", f"{-i}"] for i in range(n)]


def table(cells, header="t_s,x_m,y_m"):
    return "\n".join([header, *(",".join(row) for row in cells)]) + "\n"


def changed(row, column, text, n=12):
    """The walk with another text in one cell; rows count as in a spreadsheet, the header being row 1."""
    cells = rows(n)
    cells[row - 2][column] = text
    return table(cells)


def headed(headings, name="heading_deg"):
    cells = [[*row, heading] for row, heading in zip(rows(len(headings)), headings, strict=True)]
    return table(cells, f"t_s,x_m,y_m,{name}")
