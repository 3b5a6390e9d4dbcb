"""Published numbers as they are read, and verdicts by hand."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.experiments.published import (
    AGREES,
    DIFFERS,
    NOT_COMPARABLE,
    Published,
    judge,
    read_published,
    read_verdicts,
    write_verdicts,
)

HEAD = "experiment,quantity,value,low,high,standard_error,unit,source,how_read\n"
NUMBER = Published(
    experiment="e", quantity="length", value=29.0, low=28.5, high=29.5, standard_error=0.0, unit="deg",
    source="Fig. 1, page 2", how_read='read off, "by eye"',
)  # fmt: skip
finite = st.floats(-1e6, 1e6)
errors = st.floats(0.0, 1e3)


def written(folder: Path, *rows: str) -> Path:
    path = folder / "published.csv"
    path.write_text(HEAD + "".join(f"{row}\n" for row in rows), encoding="utf-8")
    return path


# Reading.


def test_rows_of_one_experiment_are_read(tmp_path: Path):
    path = written(
        tmp_path,
        'e,length,29,28.5,29.5,1.1,deg,"Fig. 1, page 2","read off, ""by eye"""',
        "other,length,1,1,1,,m,x,y",
        "e,n,300,,,,trials,legend σ,printed",
        "e,success,,0,20,,steps,text,words",
    )
    rows = read_published(path, "e")
    assert list(rows) == ["length", "n", "success"]
    assert rows["length"] == replace(NUMBER, standard_error=1.1)
    n = rows["n"]
    assert (n.value, n.low, n.high, n.standard_error, n.source) == (300.0, 300.0, 300.0, 0.0, "legend σ")
    assert math.isnan(rows["success"].value)
    assert (rows["success"].low, rows["success"].high) == (0.0, 20.0)
    assert read_published(path, "unknown") == {}


def test_file_without_its_head_is_told(tmp_path: Path):
    path = tmp_path / "published.csv"
    path.write_text("e,length,29,28.5,29.5,0,deg,x,y\ne,other,29,28.5,29.5,0,deg,x,y\n")
    with pytest.raises(InputError, match=r"^published.csv line 2 has other columns"):
        read_published(path, "e")


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("e,length,29,28.5,29.5,0,deg,Fig. 1", "line 3 has other columns than a published number"),
        ("e,length,about 29,28.5,29.5,0,deg,x,y", "line 3 cannot be read"),
        ("e,length,29,30,29.5,0,deg,x,y", "line 3"),
        ("e,length,29,28.5,29.5,-1,deg,x,y", "line 3"),
        ("e,length,29,28.5,nan,0,deg,x,y", "line 3"),
        ("e,length,,,,0,deg,x,y", "line 3"),  # neither a number nor what words mean
        ("e,first,1,1,1,0,deg,x,y", "line 3 repeats 'first', expected it once"),
        ("e,length,29,28.5,29.5,0,deg,Fig. 1, page 2,y", "line 3 has .*: a comma in a text"),
        ("other,length,29,28.5,29.5,0,deg,Fig. 1, page 2,y", "line 3 has"),
    ],
)
def test_row_that_cannot_be_read_is_told(row: str, told: str, tmp_path: Path):
    path = written(tmp_path, "e,first,1,1,1,0,deg,x,y", row)
    with pytest.raises(InputError, match=f"^published.csv {told}") as caught:
        read_published(path, "e")
    assert "\n" not in str(caught.value)


# Verdicts.


@pytest.mark.parametrize(
    ("ours", "uncertainty", "standard_error", "verdict"),
    [
        (29.0, 0.0, 0.0, AGREES),
        (28.5, 0.0, 0.0, AGREES),
        (29.5, 0.0, 0.0, AGREES),
        (29.51, 0.0, 0.0, DIFFERS),
        (28.49, 0.0, 0.0, DIFFERS),
        (32.4, 1.0, 0.0, AGREES),  # 29.5 and three standard errors
        (32.6, 1.0, 0.0, DIFFERS),
        (44.4, 3.0, 4.0, AGREES),  # of both: 3 · √(3² + 4²) = 15
        (44.6, 3.0, 4.0, DIFFERS),
        (13.6, 3.0, 4.0, AGREES),
        (13.4, 3.0, 4.0, DIFFERS),
        (math.nan, 1.0, 0.0, NOT_COMPARABLE),
        (math.inf, 1.0, 0.0, NOT_COMPARABLE),
    ],
)
def test_verdict_by_hand(ours: float, uncertainty: float, standard_error: float, verdict: str):
    got = judge(replace(NUMBER, standard_error=standard_error), ours, uncertainty, why="because")
    assert got.verdict == verdict
    reason = {AGREES: "", DIFFERS: "because", NOT_COMPARABLE: "there is no such number of ours"}[verdict]
    assert got.why == reason
    assert (got.quantity, got.unit, got.published, got.low, got.high) == ("length", "deg", 29.0, 28.5, 29.5)
    assert (got.source, got.how_read) == (NUMBER.source, NUMBER.how_read)


def test_what_cannot_be_compared_has_a_reason():
    got = judge(NUMBER, 29.0, not_comparable="other units")
    assert (got.verdict, got.why, got.ours) == (NOT_COMPARABLE, "other units", 29.0)


@given(finite, errors, errors, st.floats(0.0, 1e4))
def test_verdict_is_the_same_on_both_sides(ours: float, uncertainty: float, standard_error: float, width: float):
    published = replace(NUMBER, value=0.0, low=-width, high=width, standard_error=standard_error)
    verdict = judge(published, ours, uncertainty).verdict
    assert verdict == judge(published, -ours, uncertainty).verdict
    if verdict == AGREES:  # and a less certain number never differs where a certain one agrees
        assert judge(published, ours, 2.0 * uncertainty).verdict == AGREES


def test_chance_alone_calls_few_numbers_different():
    """Two samples of one distribution: three standard errors of their difference, 0.27 % of 20 000; 5 SD of a count."""
    rng = np.random.default_rng(3)
    n = 20_000
    theirs, ours = rng.normal(0.0, 0.3, n), rng.normal(0.0, 0.4, n)
    differ = sum(
        judge(replace(NUMBER, value=a, low=a, high=a, standard_error=0.3), b, 0.4).verdict == DIFFERS
        for a, b in zip(theirs, ours, strict=True)
    )
    expected = 0.0027 * n
    assert abs(differ - expected) < 5.0 * math.sqrt(expected)


# On disk.


def test_verdicts_come_back(tmp_path: Path):
    verdicts = [
        judge(NUMBER, 29.25, 0.125),
        judge(replace(NUMBER, quantity="σ, noise"), 40.0, 0.5, why='3 of 4, "three"\nquarters'),
        judge(NUMBER, math.nan, math.nan),
    ]
    write_verdicts(tmp_path / "comparison.csv", verdicts)
    got = read_verdicts(tmp_path / "comparison.csv")
    assert got[:2] == verdicts[:2]
    assert math.isnan(got[2].ours)
    assert math.isnan(got[2].uncertainty)
    assert replace(got[2], ours=0.0, uncertainty=0.0) == replace(verdicts[2], ours=0.0, uncertainty=0.0)


def test_no_verdicts_come_back_as_none(tmp_path: Path):
    write_verdicts(tmp_path / "comparison.csv", [])
    assert read_verdicts(tmp_path / "comparison.csv") == []


@pytest.mark.parametrize(
    "content", [b"a,b\n1,2\n", b"quantity,published\nlength,x\n", b"\xff\xfe\x00", None, b'quantity,published\n"half']
)
def test_file_that_is_no_comparison_is_told(content: bytes | None, tmp_path: Path):
    path = tmp_path / "comparison.csv"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"comparison.csv' cannot be read, expected a comparison.csv of insec"):
        read_verdicts(path)
