import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.datasets.tracks import read_track
from track_files import assert_one_sentence, changed, headed, read, refusal, rows, table

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
PI = np.pi


# Good input, in each spelling.


def test_a_plain_table():
    track = read(table(rows()))
    assert_allclose(track.time, np.arange(12) / 10, atol=1e-12)
    assert_array_equal(track.position, np.arange(12)[:, None] * [2.0, -1.0])
    assert track.heading is None
    assert (track.length_unit, track.time_unit, track.name) == ("m", "s", "walk")
    assert (track.n_interpolated, track.notes) == (0, ())


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_separators_line_ends_and_byte_order_mark(separator, line_end, mark):
    text = mark + table(rows()).replace(",", separator).replace("\n", line_end)
    assert_array_equal(read(text).position[:, 0], np.arange(12) * 2.0)


@pytest.mark.parametrize(
    ("header", "length_unit", "time_unit"),
    [
        ("t_s,x_m,y_m", "m", "s"),
        ("T_S, X_CM ,y_cm", "cm", "s"),
        ("time,x_mm,y_mm", "mm", "s"),
        ("frame,x,y", "unit", "frame"),
        ('"Frame","X","Y"', "unit", "frame"),
    ],
)
def test_names_of_columns(header, length_unit, time_unit):
    track = read(table(rows(), header))
    assert (track.length_unit, track.time_unit) == (length_unit, time_unit)


def test_other_columns_and_another_order():
    cells = [[y, "some, text", x, "", t] for t, x, y in rows()]
    text = "y_m;note;x_m;;t_s\n" + "\n".join(";".join(row) for row in cells)
    assert_array_equal(read(text).position, np.arange(12)[:, None] * [2.0, -1.0])


def test_quoted_cells_may_hold_separators_and_line_breaks():
    cells = [[f'"{t}"', x, y, '"a, ""b""\nc"'] for t, x, y in rows()]
    assert read(table(cells, 't_s,x_m,y_m,"what, where"')).n_samples == 12


def test_t_s_is_preferred_to_time_and_time_to_frame():
    cells = [[str(100 + i), f"{2 * i}", *row] for i, row in enumerate(rows())]
    assert read(table(cells, "frame,time,t_s,x_m,y_m")).time[1] == 0.1
    assert read(table(cells, "frame,time,other,x_m,y_m"), max_gap_s=5).time[1] == 2


@pytest.mark.parametrize("number", ["2", "+2", " 2.0", "2.", "0.2e1", "20E-1", '"2"'])
def test_spellings_of_a_number(number):
    assert read(changed(3, 1, number)).position[1, 0] == 2


def test_blank_lines_are_skipped():
    text = table(rows()).replace("\n", "\n\n,,\n  \n")
    assert read("\n \n" + text).n_samples == 12


def test_what_is_assumed_is_said():
    track = read(table(rows(), "Time,x,y"))
    assert track.notes == ("column 'Time' is taken as seconds", "columns 'x' and 'y' name no unit of length")


# Headings.


def test_headings_in_radians_and_degrees():
    radians = read(headed(["0", "1.5707963267948966", "-3.141592653589793", *["6"] * 9], "heading_rad"))
    degrees = read(headed(["0", "90", "-180", "350", "370", "-720", *["6"] * 6]))
    assert_allclose(radians.heading[:4], [0, PI / 2, -PI, 6 - 2 * PI], atol=1e-12)
    assert_allclose(degrees.heading[:6], [0, PI / 2, -PI, -PI / 18, PI / 18, 0], atol=1e-12)
    assert radians.notes == degrees.notes == ()


def test_mathematical_headings_are_converted():
    track = read(headed(["0", "90", "180", *["45"] * 9]), heading_convention="math")
    assert_allclose(track.heading[:4], [PI / 2, 0, -PI / 2, PI / 4], atol=1e-12)


def test_a_convention_without_headings_is_said_to_be_idle():
    assert read(table(rows()), heading_convention="math").notes == (
        "the heading convention math has no effect: there is no heading column",
    )


def test_missing_headings_are_filled_along_the_shorter_arc():
    track = read(headed(["170", "", "-170", *["180"] * 9]))
    assert_allclose(track.heading[:3], [np.deg2rad(170), -PI, np.deg2rad(-170)], atol=1e-12)
    assert track.n_interpolated == 1


def test_degrees_that_look_like_radians_are_doubted():
    track = read(headed(["0", "1.5", "-3.1", *["2"] * 9]))
    assert len(track.notes) == 1
    assert "'heading_deg' stays within ±2π degrees" in track.notes[0]
    assert "radians?" in track.notes[0]
    assert read(headed(["5"] * 12)).notes == ()


# Bad input: each gives one sentence.


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (
            "a,b,c\n1,2,3\n",
            "no column for time and x and y among 'a', 'b', 'c', expected a time (t_s, time_s, time or frame)",
        ),
        ("t_s,x_m\n1,2\n", "no column for y among 't_s', 'x_m'"),
        ("0.1,2,3\n0.2,3,4\n", "does the table lack its header?"),
        ("t_s x_m y_m\n1 2 3\n", "is the separator a tab, comma or semicolon?"),
        (",".join(f"c{i}" for i in range(20)), "'c10', 'c11' and 8 more, expected"),
        ('a,"' + "b" * 60 + '\nx",c', "'" + "b" * 39 + "…'"),
        ('a,"b\nc",d\n', r"among 'a', 'b\nc', 'd'"),
        (table(rows(), "t_s,x_m,y_cm"), "x and y differ in unit (columns 'x_m' and 'y_cm')"),
        (table(rows(), "t_s,x_m,y"), "x and y differ in unit"),
        (table([[*r, "1"] for r in rows()], "t_s,x_m,y_m,X_cm"), "both 'x_m' and 'X_cm' could be the x column"),
        (table([[*r, "1"] for r in rows()], "t_s,x_m,y_m,y_m"), "both 'y_m' and 'y_m' could be the y column"),
        (table([[*r, "1"] for r in rows()], "t_s,x_m,y_m,t_s"), "both 't_s' and 't_s' could be the time column"),
        (
            table([[*r, "1", "1"] for r in rows()], "t_s,x_m,y_m,heading_deg,heading_rad"),
            "both 'heading_deg' and 'heading_rad' could be the heading column",
        ),
        (changed(5, 0, ""), "row 5, column 't_s': the time is missing"),
        (changed(5, 0, "nan"), "row 5, column 't_s': the time is missing"),
        (changed(5, 0, "0.2"), "row 5, column 't_s': the time goes from 0.2 to 0.2, expected it to increase: a row tw"),
        (changed(5, 0, "0.1"), "row 5, column 't_s': the time goes from 0.2 to 0.1, expected it to increase: rows out"),
        (table(rows(9)), "9 of 9 rows hold a position, expected at least 10"),
        (table([[t, "", y] for t, _, y in rows()]), "0 of 12 rows hold a position, expected at least 10"),
        (headed([""] * 12), "0 of 12 rows hold a position and a heading, expected at least 10"),
        (table([[t, "3", "-4"] for t, _, _ in rows()]), "the animal does not move: all positions are at (3, -4)"),
        (table([[t, "5000000000.00" + x[-1], "1"] for t, x, _ in rows()]), "does not move"),
        (headed(["0", "357", *["1"] * 10], "heading_rad"), "column 'heading_rad' reaches 357, expected radians within"),
        (headed(["0", "-900", *["1"] * 10]), "column 'heading_deg' reaches -900, expected -720 to 720 degrees"),
    ],
)
def test_what_is_no_track_is_refused_in_one_sentence(content, words):
    assert words in refusal(content)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            {"heading_convention": "maths"},
            "heading convention 'maths' is unknown: expected one of compass, math (did you mean math?)",
        ),
        ({"max_gap_s": -1}, "longest gap to fill is -1, expected at least 0 s"),
        ({"max_gap_s": np.nan}, "longest gap to fill is nan"),
        ({"max_gap_samples": 1.5}, "longest gap to fill in samples is 1.5, expected a whole number of at least 0"),
    ],
)
def test_bad_options_are_refused(tmp_path, options, words):
    with pytest.raises(InputError) as caught:
        read_track(tmp_path / "walk.csv", **options)
    assert words in str(caught.value)


def test_an_odd_file_name_becomes_a_printable_one(tmp_path):
    path = tmp_path / "odd\n\t.csv"
    path.write_text(table(rows()))
    assert read_track(path).name == "odd??"


# Whatever comes, a track or one sentence.


def assert_track_or_sentence(content: bytes, **options):
    try:
        track = read(content, **options)
    except InputError as error:
        assert_one_sentence(str(error))
    else:
        assert track.n_samples >= 10
        assert all(note.isprintable() for note in track.notes)


HEADERS = [["t_s", "x_m", "y_m"], ["frame", "x", "y"], ["time", "x_cm", "y_cm", "heading_deg"]]
NAMES = [*HEADERS[0], *HEADERS[1], *HEADERS[2], "heading_rad", "x_mm", "y_mm", "note", ""]
ODD_CELLS = ["inf", "1e100", "-1e100", "1e-320", "9e99", "abc", '"', '"1"', "1,5", "-0", "\u2028", "_"]
CLOCKS = [(0, 1), (0, 0.1), (1e9, 0.04), (-1e99, 1e97), (0, 5e-324), (5, 1e-9)]  # start, interval

some_header = st.one_of(*[st.sampled_from(HEADERS)] * 5, st.lists(st.sampled_from(NAMES), min_size=1, max_size=6))
number = st.one_of(st.integers(-99, 99), st.floats(-9, 9), st.floats()).map(str)
cell = st.one_of(st.sampled_from(["", "nan", "NA"]), number, st.sampled_from(ODD_CELLS), st.text(max_size=4))
fault = st.tuples(st.integers(0, 30), st.sampled_from(["cell", "cell", "cell", "blank", "absent", "longer"]))
options = st.fixed_dictionaries(
    {},
    optional={
        "heading_convention": st.sampled_from(["compass", "math"]),
        "max_gap_s": st.sampled_from([0.0, 1.0, 1e9, np.inf]),
        "max_gap_samples": st.sampled_from([0, 20, 10**6]),
    },
)


@st.composite
def nearly_tables(draw):
    """A table of the right form with a few faults."""
    header = draw(some_header)
    start, interval = draw(st.sampled_from(CLOCKS))
    scale = draw(st.sampled_from([1.0, 1.0, 1e6, 1e98, 1e-300]))
    cells = [
        [repr(start + i * interval), *(repr(scale * (i * k % 7)) for k in range(1, len(header)))]
        for i in range(draw(st.integers(9, 30)))
    ]
    for row, kind in draw(st.lists(fault, max_size=3)):
        row %= len(cells)
        if kind == "cell" and cells[row]:
            column = draw(st.integers(0, len(cells[row]) - 1))
            cells[row][column] = draw(cell)
        elif kind == "longer":
            cells[row].append("1")
        elif kind == "blank":
            cells[row] = []
        elif kind == "absent":
            del cells[row]
    separator = draw(st.sampled_from([",", ",", ";", "\t"]))
    line_end = draw(st.sampled_from(["\n", "\r\n", "\r"]))
    return line_end.join(separator.join(row) for row in [header, *cells]).encode("utf-8", "surrogatepass")


@settings(max_examples=150, deadline=None)
@given(st.one_of(st.binary(max_size=300), st.binary(max_size=100).map(lambda tail: b"t_s,x_m,y_m\n0,1,2\n" + tail)))
def test_arbitrary_bytes(content):
    assert_track_or_sentence(content)


@settings(max_examples=150, deadline=None)
@given(st.text(max_size=100), st.sampled_from(["", "t_s,x_m,y_m\n", "t_s;x;y;"]))
def test_arbitrary_text(text, start):
    assert_track_or_sentence((start + text).encode("utf-8", "surrogatepass"))


@settings(max_examples=400, deadline=None)
@given(nearly_tables(), options)
def test_tables_with_faults(content, chosen):
    assert_track_or_sentence(content, **chosen)


# Tracks of real animals.


@pytest.mark.data
@pytest.mark.skipif(not (DATA / "tracks").is_dir(), reason=f"no folder {DATA / 'tracks'}")
@pytest.mark.parametrize(
    ("name", "n_samples", "unit", "first", "second"),
    [  # counted with wc -l; the first two positions as the files show them
        ("trackball_00", 1889, "s", (0.0, 0.0), (0.0, 0.0176)),
        ("trackball_07", 1893, "s", (0.0, 0.0), (-0.0007, 0.0047)),
        ("trackball_21", 1895, "s", (0.0, 0.0), (0.0022, -0.0020)),
        ("velox_ant01_route01", 812, "frame", (6.3, 8.45), (6.2936, 8.4423)),
        ("velox_ant04_route14", 838, "frame", (6.3, 8.45), (6.2950, 8.4414)),
        ("velox_ant12_route04", 845, "frame", (6.3, 8.45), (6.2924, 8.4435)),
    ],
)
def test_recorded_ants(name, n_samples, unit, first, second):
    track = read_track(DATA / "tracks" / f"{name}.csv")
    assert (track.name, track.n_samples, track.time_unit, track.length_unit) == (name, n_samples, unit, "m")
    assert (track.n_interpolated, track.notes, track.heading) == (0, (), None)
    assert_array_equal(track.position[:2], [first, second])
