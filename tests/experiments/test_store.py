"""Cells on disk: exactly what was given, refused where it could not be, and one writer at a time."""

import fcntl
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
import zarr

from insectnav.checks import InputError
from insectnav.experiments.store import DATA, FINISHED, CellStore, locked


@dataclass(frozen=True, kw_only=True)
class Cell:
    level: float
    word: str = "σ"
    is_on: bool = True
    count: int = 3


CELLS = [Cell(level=float(i)) for i in range(4)]


def arrays(seed: int, **changes: Any) -> dict[str, tuple]:
    """What a cell returns; zeros of both signs, NaN and nothing included."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(3, 2)).astype(np.float32)
    values[0] = np.nan, -np.inf
    return {
        "path": (("trial", "xy"), values, {"units": "step"}),
        "zeros": (("trial",), np.full(3, -0.0)),
        "share": ((), rng.random()),
        "is_home": (("trial",), rng.random(3) < 0.5),
        "index": (("trial",), rng.integers(0, 255, 3, np.uint8)),
        "wave": (("trial",), np.exp(1j * rng.random(3))),
        "none": (("trial", "never"), np.empty((3, 0))),
    } | changes


def bits(values: Any) -> bytes:
    return np.ascontiguousarray(values).tobytes()


# What is read is what was written.


def test_every_bit_comes_back(tmp_path: Path):
    store = CellStore(tmp_path, CELLS, {"title": "σ"})
    for index in (2, 0, 3, 1):
        store.write(index, arrays(index))
    results = store.read()
    assert list(results.cells) == CELLS
    assert list(results.arrays) == sorted(arrays(0))
    for index, (_, own) in enumerate(results):
        for name, (_, values, *_) in arrays(index).items():
            assert bits(own[name]) == bits(values), name
            assert own[name].dtype == np.asarray(values).dtype
            assert own[name].shape == np.shape(values)


def test_xarray_finds_parameters_dimensions_and_attributes(tmp_path: Path):
    store = CellStore(tmp_path, CELLS, {"title": "σ", "noise": float("nan")})
    for index in range(4):
        store.write(index, arrays(index))
    store.complete()
    with xarray.open_zarr(tmp_path / DATA) as data:
        assert data.attrs == {"title": "σ", "noise": None}
        assert data.path.dims == ("cell", "trial", "xy")
        assert data.path.attrs == {"units": "step"}
        assert data.share.dims == data.word.dims == ("cell",)
        assert data.level.values.tolist() == [0.0, 1.0, 2.0, 3.0]
        assert data.word.values.tolist() == 4 * ["σ"]
        assert data.is_on.values.tolist() == 4 * [True]
        assert data["count"].values.tolist() == 4 * [3]
        np.testing.assert_array_equal(data.path[2], arrays(2)["path"][1])


def test_values_along_a_dimension_may_have_its_name(tmp_path: Path):
    store = CellStore(tmp_path, CELLS[:2], {})
    for index in range(2):
        store.write(index, {"x": (("x",), np.arange(3.0)), "a": (("x",), np.ones(3))})
    store.complete()
    with xarray.open_zarr(tmp_path / DATA) as data:
        assert data.a.isel(cell=1).x.values.tolist() == [0.0, 1.0, 2.0]
        assert "x" in data.coords


def test_large_arrays_are_divided_and_come_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("insectnav.experiments.results.ONE_CHUNK", 1000)
    large = np.arange(7 * 30 * 11, dtype=np.int32).reshape(7, 30, 11)
    store = CellStore(tmp_path, CELLS[:2], {})
    for index in range(2):
        store.write(index, {"large": (("a", "b", "c"), large + index)})
    array: Any = zarr.open_group(tmp_path / DATA, mode="r")["large"]
    assert array.chunks == (1, 1, 22, 11)
    np.testing.assert_array_equal(store.read()["large"], [large, large + 1])


def test_parameters_of_whole_numbers_and_fractions_are_one_array(tmp_path: Path):
    cells = [Cell(level=1, count=2**62), Cell(level=float("inf"), count=-(2**62))]
    store = CellStore(tmp_path, cells, {})
    store.write(0, {"a": ((), 1.0)})
    group: Any = zarr.open_group(tmp_path / DATA, mode="r")
    assert group["level"][...].tolist() == [1.0, float("inf")]
    assert group["count"][...].tolist() == [2**62, -(2**62)]


# Going on.


def test_finished_cells_stay_when_another_process_goes_on(tmp_path: Path):
    CellStore(tmp_path, CELLS, {}).write(1, arrays(1))
    again = CellStore(tmp_path, CELLS, {})
    assert again.finished() == {1}
    again.write(3, arrays(3))
    assert CellStore(tmp_path, CELLS, {}).finished() == {1, 3}
    assert bits(again.read()["path"][1]) == bits(arrays(1)["path"][1])
    assert bits(again.read()["zeros"][3]) == bits(arrays(3)["zeros"][1])


def test_what_was_begun_before_the_first_cell_was_finished_is_begun_anew(tmp_path: Path):
    CellStore(tmp_path, CELLS, {}).write(1, {"other": (("a",), np.zeros(5))})
    (tmp_path / FINISHED / "1").unlink()  # killed before the note
    store = CellStore(tmp_path, CELLS, {})
    store.write(0, arrays(0))
    assert list(store.read().arrays) == sorted(arrays(0))


def test_parts_of_a_killed_process_are_swept_away(tmp_path: Path):
    store = CellStore(tmp_path, CELLS[:1], {})
    store.write(0, arrays(0))
    before = {path for path in (tmp_path / DATA).rglob("*") if path.is_file()}
    for folder in ("", "path", "path/c/0"):
        (tmp_path / DATA / folder / "0.89abcdef.partial").write_bytes(b"half")
    store.complete()
    assert {path for path in (tmp_path / DATA).rglob("*") if path.is_file()} == before


def test_every_finished_cell_has_its_chunks_even_where_all_is_zero(tmp_path: Path):
    for _ in range(2):  # the second opens what the first made
        store = CellStore(tmp_path, CELLS[:2], {})
        store.write(len(store.finished()), {"zeros": (("a",), np.zeros(5)), "false": ((), False)})
    for index in range(2):
        assert (tmp_path / DATA / "zeros" / "c" / str(index) / "0").is_file()
        assert (tmp_path / DATA / "false" / "c" / str(index)).is_file()


def test_empty_store_is_removed_and_another_is_not(tmp_path: Path):
    store = CellStore(tmp_path / "a", CELLS, {})
    (tmp_path / "a").mkdir()
    store.remove_if_empty()
    assert not (tmp_path / "a").exists()
    store.write(0, arrays(0))
    store.remove_if_empty()
    assert store.finished() == {0}
    store.forget_progress()
    assert sorted(os.listdir(tmp_path / "a")) == [DATA]


# What cannot be.


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"path": (("trial", "xy"), np.zeros((4, 2), np.float32), {"units": "step"})}, "path of cell 2 of 4 .* is flo"),
        ({"path": (("trial", "xy"), np.zeros((3, 2)), {"units": "step"})}, r"path of .* is float64 .*expected float32"),
        ({"path": (("xy", "trial"), np.zeros((3, 2), np.float32), {"units": "step"})}, "path of cell 2 of 4"),
        ({"path": (("trial", "xy"), np.zeros((3, 2), np.float32), {"units": "m"})}, r"'m'.* expected .*'step'"),
        ({"share": ((), 1)}, "share of .* is int64 .* expected float64"),
        ({"extra": ((), 1.0)}, r"cell 2 of 4 \(level=1.0, word='σ'.*\) returned \['extra', .* expected \['index'"),
    ],
)
def test_cell_unlike_the_first_is_refused(change: dict, told: str, tmp_path: Path):
    store = CellStore(tmp_path, CELLS, {})
    store.write(0, arrays(0))
    for store_ in (store, CellStore(tmp_path, CELLS, {})):  # as well after going on
        with pytest.raises(ValueError, match=told):
            store_.write(1, arrays(1, **change))
        assert store_.finished() == {0}


def test_missing_array_is_refused(tmp_path: Path):
    store = CellStore(tmp_path, CELLS, {})
    store.write(0, arrays(0))
    with pytest.raises(ValueError, match=r"returned \['path'\], expected \['index', 'is_home', "):
        store.write(1, {"path": arrays(1)["path"]})


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            {"a": (("x",), np.array(["text"]))},
            r"a of cell 1 of 4 \(.*\) holds str\d+ values, expected numbers",
        ),
        ({"a": (("x",), np.array([None]))}, "holds object values"),
        ({"a": (("x",), np.array(["2001-01-01"], "M8[D]"))}, "holds datetime64"),
        ({"a": (("x",), np.zeros((2, 2)))}, r"dimensions \('x',\) and shape \(2, 2\), expected a name for each axis"),
        ({"a": ("xy", np.zeros(2))}, r"dimensions \('x', 'y'\) and shape \(2,\)"),
        ({"a": (("x", "x"), np.zeros((2, 2)))}, r"dimensions \('x', 'x'\)"),
        ({"a": (("x",), np.zeros(2)), "b": (("x",), np.zeros(3))}, "b of cell .* has 3 along 'x', which is 2"),
        ({"a": (("cell",), np.zeros(2))}, "a of cell .* has 2 along 'cell', which is 4"),
        ({"level": ((), 1.0)}, r"expected other names than \['level'\]"),
        ({"a": (("word",), np.zeros(2))}, r"expected other names than \['word'\]"),
        ({"a": (("x",), np.zeros(2)), "x": ((), 1.0)}, r"expected other names than \['x'\]"),
    ],
)
def test_arrays_that_nobody_could_read_are_refused(given: dict, told: str, tmp_path: Path):
    with pytest.raises(ValueError, match=told):
        CellStore(tmp_path, CELLS, {}).write(0, given)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_folder_without_permission_is_told(tmp_path: Path):
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(InputError, match="cannot be written"):
            CellStore(tmp_path, CELLS, {}).write(0, arrays(0))
    finally:
        tmp_path.chmod(0o755)


# One at a time.


def test_file_is_held_by_one_and_then_free(tmp_path: Path):
    file = tmp_path / "lock"
    with locked(file):
        with pytest.raises(InputError, match="is being written by another run"), locked(file):
            pass
        assert file.is_file()  # the refused one has not taken it away
    assert not file.exists()
    with pytest.raises(RuntimeError, match="inside"), locked(file):
        raise RuntimeError("inside")
    with locked(file):
        pass


def test_lock_that_a_killed_process_left_holds_nobody_up(tmp_path: Path):
    (tmp_path / "lock").touch()
    with locked(tmp_path / "lock"):
        pass


def test_lock_whose_name_is_gone_is_taken_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Another run ends, and takes its file away, between our opening and our locking of it."""
    file, flock, n_calls = tmp_path / "lock", fcntl.flock, 0

    def take_away_first(descriptor: int, operation: int) -> None:
        nonlocal n_calls
        n_calls += 1
        if n_calls == 1:
            file.unlink()
        flock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", take_away_first)
    with locked(file):
        assert n_calls == 2
        with pytest.raises(InputError), locked(file):
            pass
