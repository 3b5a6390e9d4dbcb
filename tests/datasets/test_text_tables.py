import os
import stat
import threading
from pathlib import Path

import pytest

from insectnav.checks import InputError
from insectnav.datasets import text_tables
from insectnav.datasets.text_tables import open_table, read_columns, read_numbers
from insectnav.datasets.tracks import read_track
from track_files import assert_one_sentence, changed, refusal, rows, table


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "the file is empty"),
        ("\ufeff\n \n,,\n", "the file is empty"),
        ('"",""\n', "the file is empty"),
        ("t_s,x_m,y_m\n", "only a header"),
        ("t_s,x_m,y_m\n\n,,\n", "only a header"),
        (b"t_s,x_m,y_m\n0,1\0,2\n", "not text (a NUL byte in row 2)"),
        (b"t_s,x_m,y_m\n0,1,2\n1,\xb0,2\n", "not text in UTF-8 (byte 0xb0 in row 3)"),
        (table(rows()).encode("utf-16"), "UTF-16: save it as UTF-8"),
        (b"PK\x03\x04\x14\0", "a spreadsheet or zip archive: export it as CSV"),
        (b"\x1f\x8b\x08\x00", "compressed: unpack it first"),
        (",".join(["x"] * 1001), "the header names 1001 columns, at most 1000"),
        (changed(5, 1, "abc"), "row 5, column 'x_m': 'abc' is not a number"),
        (changed(5, 2, "z" * 100), "row 5, column 'y_m': '" + "z" * 39 + "…' is not a number"),
        (changed(5, 1, '"a\nb"'), r"row 5, column 'x_m': 'a\nb' is not a number"),
        (changed(5, 1, "inf"), "row 5, column 'x_m': 'inf' is not a number"),
        (changed(5, 1, "-Infinity"), "'-Infinity' is not a number"),
        (changed(5, 1, "1e999"), "'1e999' is larger than any length or time"),
        (changed(5, 1, "1_000"), "'1_000' is not a number"),
        (changed(5, 1, "٣"), "'٣' is not a number"),
        (changed(5, 1, "0x10"), "'0x10' is not a number"),
        (changed(5, 1, '"1,5"'), "'1,5' is not a number: a decimal comma?"),
        (changed(5, 1, "1" * 50_000 + "x"), "is not a number"),
        ("\n\n" + changed(5, 1, "abc").replace("\n", "\n\n"), "row 11, column 'x_m': 'abc'"),
        (changed(5, 1, "1,2"), "row 5 has 4 cells, expected 3 as in the header: a separator too many"),
        (table([*rows(), ["9", "9"]]), "row 14 has 2 cells, expected 3 as in the header: is a cell missing?"),
        (changed(5, 1, '"1'), "the quotes in row 5 do not pair"),
        (changed(5, 1, '"1"2'), "the quotes in row 5 do not pair"),
        (table([[*r, '"' if i == 3 else ""] for i, r in enumerate(rows())], "t_s,x_m,y_m,note"), "quotes in row 5"),
        (changed(5, 1, '"' + "1" * 200_000 + '"'), "row 5 holds a cell of more than 131072 characters"),
        ("t_s,x_m,y_m\n" + "," * 2_100_000, "a line is longer than 1000000 bytes"),
    ],
)
def test_bad_tables_are_refused_in_one_sentence(content, words):
    assert words in refusal(content)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nothing.csv", "nothing.csv': no such file"),
        ("", "this is a folder, expected a CSV or TSV file"),
        ("two\nlines.csv", r"two\nlines.csv': no such file"),
        ("nul\0.csv", r"nul\x00.csv': no such file"),
        ("long" * 200, "cannot be read (File name too long)"),
        ("a\udcff\ud800.csv", "no such file"),
    ],
)
def test_bad_paths_are_refused_in_one_sentence(tmp_path, name, words):
    with pytest.raises(InputError) as caught:
        read_track(f"{tmp_path}/{name}")
    assert_one_sentence(str(caught.value))
    assert words in str(caught.value)


def test_a_device_is_refused():
    with pytest.raises(InputError, match="this is a device"):
        read_track(os.devnull)


def test_a_file_without_permission_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "secret.csv"
    path.write_text(table(rows()))

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)  # as a superuser may read everything
    with pytest.raises(InputError, match=r"cannot be read \(Permission denied\)"):
        read_track(path)


def test_a_huge_file_is_refused_unread(tmp_path):
    path = tmp_path / "huge.csv"
    with path.open("wb") as file:
        file.truncate(text_tables.MAX_BYTES + 1)  # sparse: takes no room on disk
    with pytest.raises(InputError, match="larger than 512 MB"):
        read_track(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with a name on this system")
def test_a_pipe_is_read(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    writer = threading.Thread(target=pipe.write_text, args=(table(rows()),), daemon=True)
    writer.start()
    track = read_track(pipe)
    writer.join()
    assert track.n_samples == 12


def test_names_of_columns_stand_for_a_header(tmp_path):
    path = tmp_path / "tracking.csv"
    path.write_text("\n65.7,138.0,-44.4\n98.6,137.6,\n")
    table = open_table(path, ("time_ms", "x_cm", "y_cm"))
    assert table.header == ["time_ms", "x_cm", "y_cm"]
    numbers, values = read_numbers(table, [2, 0])
    assert numbers.tolist() == [2, 3]
    assert values[0].tolist() == [-44.4, 65.7] and values[1, 1] == 98.6
    with pytest.raises(InputError, match="row 2 has 3 cells, expected 2"):
        open_table(path, ("time_ms", "x_cm"))


@pytest.mark.parametrize("n_rows", [1, 1000, 2500])
def test_words_and_a_single_column_of_numbers(n_rows, tmp_path):
    path = tmp_path / "times.csv"
    path.write_text("file,time_s,note\n" + "".join(f" a/{k}.png ,{k},\n\n" for k in range(n_rows)))
    numbers, values, (names,) = read_columns(open_table(path), [1], [0])
    assert numbers.tolist() == list(range(2, 2 * n_rows + 2, 2))
    assert values[:, 0].tolist() == list(range(n_rows))
    assert names == [f"a/{k}.png" for k in range(n_rows)]
