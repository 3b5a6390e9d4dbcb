import numpy as np
import pytest
from numpy.testing import assert_allclose

from insectnav.datasets import track_gaps
from track_files import read, refusal, rows, table

# Gaps. The walk moves evenly, so what is filled in lies on the line x = 20 t, y = -10 t.


@pytest.mark.parametrize("missing", ["", "nan", "NaN", "NA", "na", " "])
def test_missing_cells_are_filled_and_counted(missing):
    cells = rows(15)
    cells[3][1] = cells[4][2] = cells[8][1] = cells[8][2] = missing
    track = read(table(cells))
    assert_allclose(track.position, np.arange(15)[:, None] * [2.0, -1.0], atol=1e-9)
    assert track.n_interpolated == 3


@pytest.mark.parametrize(("header", "interval"), [("t_s,x_m,y_m", 0.1), ("frame,x_m,y_m", 5)])
def test_absent_rows_are_put_in_and_counted(header, interval):
    cells = rows(30, interval)
    track = read(table(cells[:4] + cells[8:20] + cells[21:], header))
    assert_allclose(track.time, np.arange(30) * interval, atol=1e-9)
    assert_allclose(track.position, np.arange(30)[:, None] * [2.0, -1.0], atol=1e-9)
    assert track.n_interpolated == 5


def test_missing_cells_beside_absent_rows():
    cells = rows(30)
    cells[8][1] = "NA"
    track = read(table(cells[:4] + cells[8:]))
    assert_allclose(track.position, np.arange(30)[:, None] * [2.0, -1.0], atol=1e-9)
    assert track.n_interpolated == 5


@pytest.mark.parametrize("interval", [5e-324, 1e-9, 1e90])
def test_any_scale_of_time_is_filled(interval):
    cells = [[repr(i * interval), *row[1:]] for i, row in enumerate(rows(15))]
    cells[3][1] = ""
    assert_allclose(read(table(cells, "frame,x,y")).position[3], [6, -3], atol=1e-9)


def test_irregular_intervals_below_the_threshold_are_left_alone():
    times = np.cumsum([0.1, 0.14, 0.06] * 5)
    cells = [[f"{t:.4f}", f"{i}", "0"] for i, t in enumerate(times)]
    track = read(table(cells))
    assert_allclose(track.time, times, atol=1e-12)
    assert track.n_interpolated == 0


def test_incomplete_ends_are_cut_off_and_counted():
    cells = rows(20)
    cells[0][1] = cells[1][1] = cells[19][2] = ""
    track = read(table(cells))
    assert_allclose(track.time, np.arange(2, 19) / 10, atol=1e-12)
    assert track.n_interpolated == 3
    assert track.notes == ("incomplete samples at the ends of the track were cut off: 3",)


def test_a_gap_as_long_as_the_limit_is_filled():
    cells = rows(40, 0.1, first=17_000_000_000)  # the clock of a computer, whose seconds are coarse
    assert read(table(cells[:5] + cells[14:])).n_interpolated == 9
    cells = rows(60, 1)
    assert read(table(cells[:5] + cells[24:], "frame,x,y")).n_interpolated == 19


def without(first, last, n=60, **options):
    cells = rows(n, **options)
    return cells[: first - 2] + cells[last - 1 :]


@pytest.mark.parametrize(
    ("cells", "header", "words"),
    [
        (without(10, 31), "t_s,x_m,y_m", "gap of 2.3 s before row 10, at most 1 s is filled: raise --max-gap, or cut"),
        (
            without(10, 40, interval=0.01),
            "t_s,x_m,y_m",
            "gap of 32 samples (0.32 s) before row 10, at most 20 samples are filled: raise --max-gap-samples, or cut",
        ),
        (without(10, 40, interval=1), "frame,x_m,y_m", "gap of 32 samples (32 frames) before row 10, at most 20 samp"),
        (without(10, 10, interval=2), "t_s,x_m,y_m", "gap of 4 s before row 10, at most 1 s is filled"),
    ],
)
def test_long_gaps_are_refused(cells, header, words):
    assert refusal(table(cells, header)).startswith(words)


@pytest.mark.parametrize(
    ("first", "last", "words"),
    [
        (20, 40, "gap of 2.2 s before row 41"),
        (2, 40, "gap of 3.9 s before row 41"),
        (40, 61, "gap of 2.2 s after row 39"),
    ],
)
def test_long_runs_of_missing_cells_are_refused(first, last, words):
    cells = rows(60)
    for row in range(first, last + 1):
        cells[row - 2][1] = ""
    assert refusal(table(cells)).startswith(words)


def test_limits_can_be_moved():
    text = table(without(10, 31))
    assert read(text, max_gap_s=2.4, max_gap_samples=23).n_interpolated == 22
    assert refusal(text, max_gap_s=2.2, max_gap_samples=23).startswith("gap of 2.3 s")
    assert refusal(text, max_gap_s=np.inf).startswith("gap of 23 samples")
    assert refusal(table(without(10, 10)), max_gap_samples=0).startswith("gap of 2 samples")


def test_a_filled_track_has_a_largest_size(monkeypatch):
    monkeypatch.setattr(track_gaps, "MAX_SAMPLES", 1000)
    cells = [*rows(), ["1e6", "1", "1"]]
    sentence = refusal(table(cells), max_gap_s=np.inf, max_gap_samples=10**400)
    assert "more than 1000 samples" in sentence
