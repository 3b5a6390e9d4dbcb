"""Results on disk: whole or not at all, and readable by others."""

import csv
import json
import math
import os
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.experiments.results import (
    ONE_CHUNK,
    PROVENANCE,
    check_destination,
    chunk_shape,
    provenance,
    replace_folder,
    results_folder,
    to_json,
    write_arrays,
    write_table,
    written_to,
)


def tree(folder: Path) -> dict[str, bytes | None]:
    """All that is below a folder, hidden things too: contents of files by path."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


def leave_results(destination: Path, text: str = "first") -> None:
    with results_folder(destination) as folder:
        (folder / PROVENANCE).write_text("{}")
        (folder / "table.csv").write_text(text)


# The folder.


@pytest.mark.parametrize("name", ["new", "deeper/and/deeper", "with space é", "dots.in.it", ".hidden"])
def test_folder_appears_when_all_is_done(name: str, tmp_path: Path):
    destination = tmp_path / name
    with results_folder(destination) as folder:
        assert folder.is_dir()
        assert folder.parent == destination.parent  # the same disk: renaming is one act
        assert folder.name.startswith(".")
        (folder / "a.txt").write_text("a")
        assert not destination.exists()
    assert tree(destination) == {"a.txt": b"a"}
    assert os.listdir(destination.parent) == [destination.name]


def test_relative_destination_is_below_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    leave_results("out/walk")
    assert (tmp_path / "out" / "walk" / "table.csv").is_file()


def test_working_folder_may_change_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    with results_folder("out") as folder:
        os.chdir("elsewhere")
        (folder / "a.txt").write_text("a")
    assert tree(tmp_path) == {"elsewhere": None, "out": None, "out/a.txt": b"a"}


@pytest.mark.parametrize("name", ["new", "deeper/and/deeper"])
@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt, SystemExit, InputError])
def test_nothing_is_left_of_what_fails(failure: type[BaseException], name: str, tmp_path: Path):
    with pytest.raises(failure, match="on the way"), results_folder(tmp_path / name) as folder:
        (folder / "half").mkdir()
        (folder / "half" / "written.txt").write_text("a")
        raise failure("on the way")
    assert tree(tmp_path) == {}


@pytest.mark.parametrize("make", [leave_results, check_destination])
def test_nothing_is_left_of_what_is_interrupted_as_soon_as_a_folder_is_made(
    make: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    usual = Path.mkdir

    def mkdir(self: Path, *arguments: Any, **options: Any) -> None:
        usual(self, *arguments, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "a" / "b")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_earlier_results_outlive_what_fails(failure: type[BaseException], tmp_path: Path):
    leave_results(tmp_path / "out")
    before = tree(tmp_path)
    with pytest.raises(failure), results_folder(tmp_path / "out") as folder:
        (folder / PROVENANCE).write_text("{}")
        raise failure
    assert tree(tmp_path) == before


def test_earlier_results_are_replaced_as_a_whole(tmp_path: Path):
    leave_results(tmp_path / "out", "first")
    with results_folder(tmp_path / "out") as folder:
        (folder / "table.csv").write_text("second")
        assert (tmp_path / "out" / "table.csv").read_text() == "first"  # until the end
    assert tree(tmp_path) == {"out": None, "out/table.csv": b"second"}


def test_results_among_other_files_are_not_replaced(tmp_path: Path):
    leave_results(tmp_path / "out")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    before = tree(tmp_path)
    with pytest.raises(InputError, match=r"holds other files, such as 'notes.txt', expected"):
        leave_results(tmp_path / "out", "second")
    assert tree(tmp_path) == before


def test_empty_folder_is_filled(tmp_path: Path):
    (tmp_path / "out").mkdir()
    leave_results(tmp_path / "out")
    assert sorted(tree(tmp_path / "out")) == [PROVENANCE, "table.csv"]


def test_earlier_results_come_back_if_they_cannot_be_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    leave_results(tmp_path / "out")
    before, rename = tree(tmp_path), Path.rename

    def fail_for_the_new(self: Path, target: Path) -> Path:
        if self.suffix == ".part" and target.name == "out":
            raise OSError(28, "No space left on device")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fail_for_the_new)
    with pytest.raises(InputError, match=r"out' cannot be written \(No space left on device\)$"):
        leave_results(tmp_path / "out", "second")
    assert tree(tmp_path) == before


def test_two_at_once_do_not_meet(tmp_path: Path):
    with results_folder(tmp_path / "out") as one, results_folder(tmp_path / "out") as two:
        assert one != two
        (one / PROVENANCE).write_text("one")
        (two / PROVENANCE).write_text("two")
    assert tree(tmp_path) == {"out": None, f"out/{PROVENANCE}": b"one"}  # the last to finish


def test_link_to_a_folder_stays_a_link(tmp_path: Path):
    (tmp_path / "real").mkdir()
    (tmp_path / "out").symlink_to("real")
    leave_results(tmp_path / "out")
    leave_results(tmp_path / "out", "second")
    assert (tmp_path / "out" / "table.csv").read_text() == "second"
    assert sorted(os.listdir(tmp_path)) == ["out", "real"]
    assert (tmp_path / "out").is_symlink()


def test_working_folder_is_filled_and_not_pulled_away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    leave_results(".")
    assert sorted(os.listdir()) == [PROVENANCE, "table.csv"]  # as a shell that stands here sees it


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("file", "is a file, expected a folder or a new name"),
        ("foreign", "holds other files, such as 'thesis.txt', expected a new name or a folder of results alone"),
        ("file/below", "cannot be written"),
        ("file/far/below", "cannot be written"),
        ("a" * 300, "cannot be written (File name too long)"),
    ],
)
def test_destination_that_cannot_be_is_refused_before_the_work(name: str, words: str, tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "thesis.txt").write_text("mine")
    before = tree(tmp_path)
    for refuse in (check_destination, results_folder):
        with pytest.raises(InputError) as caught:
            context = refuse(tmp_path / name)
            context.__enter__()
        assert words in str(caught.value)
        assert str(caught.value).startswith("--out '")
        assert "\n" not in str(caught.value)
    assert tree(tmp_path) == before


def test_an_empty_name_is_not_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="--out is an empty name, expected a folder"), results_folder(""):
        pass
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_folder_without_permission_is_refused(tmp_path: Path):
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(InputError, match="cannot be written"):
            check_destination(tmp_path / "out")
    finally:
        tmp_path.chmod(0o755)


def test_what_a_killed_process_left_between_two_renames_is_no_hindrance(tmp_path: Path):
    for is_there in (False, True):  # the old folder was already put aside
        for name in ("new.part", "new.old"):
            (tmp_path / name).mkdir()
            (tmp_path / name / name).touch()
        assert (tmp_path / "final").exists() == is_there
        replace_folder(tmp_path / "final", tmp_path / "new.part")
        assert tree(tmp_path) == {"final": None, "final/new.part": b""}


def test_refusal_of_the_system_is_one_sentence():
    told = r"^--out 'here' cannot be written \(No space left on device\)$"
    with pytest.raises(InputError, match=told), written_to("here"):
        raise OSError(28, "No space left on device")
    with pytest.raises(KeyError), written_to("here"):
        raise KeyError("another matter")


def test_check_of_a_destination_makes_nothing(tmp_path: Path):
    check_destination(tmp_path / "deeper" / "out")
    assert tree(tmp_path) == {}


# JSON.


def strict(text: str) -> object:
    """What a reader that knows no NaN makes of it."""

    def refuse(constant: str) -> None:
        raise ValueError(constant)

    return json.loads(text, parse_constant=refuse)


def test_numbers_of_any_kind_are_plain_numbers():
    value = {
        "int": np.int64(3),
        "float": np.float32(0.5),
        "bool": np.bool_(True),
        "text": np.str_("σ"),
        "array": np.arange(4, dtype=np.int16).reshape(2, 2),
        "point": np.array(1.5),
        "tuple": (1, (np.uint8(2), None)),
        7: "key",
    }
    assert strict(to_json(value)) == {
        "int": 3, "float": 0.5, "bool": True, "text": "σ", "array": [[0, 1], [2, 3]], "point": 1.5,
        "tuple": [1, [2, None]], "7": "key",
    }  # fmt: skip


@pytest.mark.parametrize("hole", [float("nan"), float("inf"), -float("inf")])
def test_what_is_not_finite_is_null(hole: float):
    value = [hole, np.float32(hole), np.array([1.0, hole]), {"a": (hole,)}]
    assert strict(to_json(value)) == [None, None, [1.0, None], {"a": [None]}]


def test_json_is_indented_and_readable():
    assert to_json({"ratio": 1, "σ": "°"}) == '{\n  "ratio": 1,\n  "σ": "°"\n}'


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
        max_leaves=10,
    )
)
def test_plain_values_come_back_exactly(value: object):
    assert strict(to_json(value)) == value


# Tables.


def test_table_can_be_read_back(tmp_path: Path):
    rows = [
        {"quantity": "closest, mean", "unit": "µm", "mean": 1.0 / 3.0, "n": 100},
        {"quantity": 'a "b"', "unit": "1", "mean": np.float32(2e-7), "n": np.int64(5)},
        {"quantity": "none", "unit": "", "mean": float("nan"), "n": 0},
        {"quantity": "endless", "unit": "", "mean": np.float64("inf"), "n": 1234567},
    ]
    write_table(tmp_path / "table.csv", rows)
    with (tmp_path / "table.csv").open(newline="", encoding="utf-8") as file:
        got = list(csv.DictReader(file))
    assert [list(row) for row in got] == [["quantity", "unit", "mean", "n"]] * 4
    assert [row["quantity"] for row in got] == ["closest, mean", 'a "b"', "none", "endless"]
    assert [row["mean"] for row in got] == ["0.333333", "2e-07", "", ""]
    assert [row["n"] for row in got] == ["100", "5", "0", "1234567"]
    assert got[0]["unit"] == "µm"


@pytest.mark.parametrize("rows", [[{"a": 1, "b": 2}, {"a": 1}], [{"a": 1}, {"a": 1, "b": 2}]])
def test_row_with_other_columns_is_refused(rows: list, tmp_path: Path):
    with pytest.raises(ValueError, match=r"^row 1 of table.csv lacks or adds b$"):
        write_table(tmp_path / "table.csv", rows)
    assert list(tmp_path.iterdir()) == []


def test_empty_table_is_refused_unless_its_columns_are_known(tmp_path: Path):
    with pytest.raises(ValueError, match=r"^table.csv would be empty, expected rows$"):
        write_table(tmp_path / "table.csv", [])
    write_table(tmp_path / "table.csv", [], ["a", "b"])
    assert (tmp_path / "table.csv").read_text() == "a,b\n"


# Arrays.


@given(st.lists(st.integers(0, 10**6), max_size=5), st.sampled_from([1, 2, 4, 8, 16]))
def test_chunks_are_whole_or_small(shape: list[int], itemsize: int):
    chunks = chunk_shape(shape, itemsize)
    assert len(chunks) == len(shape)
    assert all(1 <= chunk <= max(1, length) for chunk, length in zip(chunks, shape, strict=True))
    assert math.prod(chunks) * itemsize <= ONE_CHUNK
    if math.prod(max(1, length) for length in shape) * itemsize <= ONE_CHUNK:
        assert chunks == tuple(max(1, length) for length in shape)


def test_array_beyond_what_one_chunk_can_hold_is_divided():
    """Blosc and zstd take less than 2 GiB at a time."""
    assert chunk_shape((1000, 3000, 2), 8) == (699, 3000, 2)
    assert chunk_shape((2, 2**31), 4) == (1, 2**23)


def test_arrays_are_read_by_xarray(tmp_path: Path):
    position = np.arange(24, dtype=np.float32).reshape(2, 4, 3)
    position[1, 2, 0] = np.nan
    write_arrays(
        tmp_path / "data.zarr",
        {
            "trial": (("trial",), np.array([0, 1])),
            "position": (("trial", "step", "xyz"), position, {"units": "m"}),
            "leg": (("step",), np.array([0, 0, 1, 1], np.int8), {"flag_values": [0, 1], "flag_meanings": "out home"}),
            "zeros": (("step",), np.zeros(4)),
            "one": ((), np.float64(7.0)),
        },
        {"seed": np.int64(3), "noise": float("nan"), "scale": {"unit": "m", "per": np.float32(0.5)}},
    )
    with xarray.open_zarr(tmp_path / "data.zarr", consolidated=False) as data:
        assert data.position.dims == ("trial", "step", "xyz")
        assert data.position.dtype == np.float32
        np.testing.assert_array_equal(data.position, position)
        np.testing.assert_array_equal(data.zeros, np.zeros(4))  # a zero is no missing value
        np.testing.assert_array_equal(data.leg, [0, 0, 1, 1])
        np.testing.assert_array_equal(data.trial, [0, 1])
        assert np.issubdtype(data.leg.dtype, np.integer)
        assert "trial" in data.coords
        assert float(data.one) == 7.0
        assert data.position.attrs == {"units": "m"}
        assert data.leg.attrs == {"flag_values": [0, 1], "flag_meanings": "out home"}
        assert data.attrs == {"seed": 3, "noise": None, "scale": {"unit": "m", "per": 0.5}}


def test_xarray_opens_arrays_without_a_warning(tmp_path: Path):
    write_arrays(tmp_path / "data.zarr", {"a": (("step",), np.arange(3))}, {})
    with xarray.open_zarr(tmp_path / "data.zarr") as data:
        np.testing.assert_array_equal(data.a, [0, 1, 2])


# Provenance.


def test_provenance_says_what_made_it(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.argv", [os.path.join("some", "where", "insectnav"), "home", "walk.csv"])
    made = strict(to_json(provenance(1.23456)))
    assert made["command"] == ["insectnav", "home", "walk.csv"]
    assert made["seconds"] == 1.235
    assert made["packages"]["numpy"] == np.__version__
    assert abs(datetime.now(UTC) - datetime.fromisoformat(str(made["finished"]))) < timedelta(seconds=60)
    assert made["machine"]["cores"] == os.cpu_count()
    assert set(made["packages"]) >= {"numba", "scipy", "xarray", "zarr", "matplotlib"}
