"""Maps that are damaged, made by others or not there: each is refused in a sentence."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.matching import MapAbout, PlaceMap

ROUTE = np.cumsum(np.random.default_rng(1).normal(size=(400, 12)), axis=0)
ABOUT = MapAbout(descriptor="walk", metric="euclidean", n_features=12)


def damaged(folder: Path) -> str:
    """The sentence in which a map is refused, when it is opened or first used."""
    with pytest.raises(InputError) as caught:
        PlaceMap.open(folder).locate(ROUTE[:20])
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert len(sentence) < 600
    return sentence


ARRAYS = ["descriptors", "times", "positions", "routes", "name_ends", "name_bytes"]


@pytest.mark.parametrize("is_frozen", [False, True])
@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_that_are_missing_or_cut_off_are_told(tmp_path, name, is_frozen):
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT, names=["x"] * 400)
    if is_frozen:
        made.freeze(index=False)
    (array,) = (tmp_path / "map").rglob(name)
    (chunk,) = array.glob("c.0*")
    whole = chunk.read_bytes()
    chunk.write_bytes(whole[:-1])
    assert "expected" in damaged(tmp_path / "map")
    chunk.unlink()
    assert f"has 0 bytes, expected {len(whole)}: cut off?" in damaged(tmp_path / "map")
    (array / "zarr.json").unlink()
    assert f"/{name}' is missing" in damaged(tmp_path / "map")


@pytest.mark.parametrize(
    "change",
    [
        {"shape": [2**62, 12]},
        {"shape": [400, 12, 1]},
        {"shape": [-400, 12]},
        {"shape": [400.0, 12]},
        {"shape": "400"},
        {"data_type": "float32"},
        {"data_type": "object"},
        {"data_type": ["float64"]},
        {"codecs": [{"name": "numcodecs.pickle"}]},
        {"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1, 1]}}},
        {"dimension_names": ["place", "axis"]},
        {"node_type": "group"},
    ],
)
def test_arrays_that_are_described_otherwise_are_refused(tmp_path, change):
    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    (about,) = (tmp_path / "map").rglob("descriptors/zarr.json")
    about.write_text(json.dumps(json.loads(about.read_text()) | change))
    assert "array" in damaged(tmp_path / "map")


@pytest.mark.parametrize("text", [b"", b"{", b"[]", b"[" * 100_000, b"\xff\xfe", b'"x"', b"null", b" " * 5_000_000])
@pytest.mark.parametrize("name", ["map.json", "segments/00000000-00000000/times/zarr.json"])
def test_bad_json_is_refused(tmp_path, name, text):
    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    (tmp_path / "map" / name).write_bytes(text)
    assert str(tmp_path / "map" / name)[:60] in damaged(tmp_path / "map")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"version": 2}, "has format 2, expected at most 1: made by a newer version of insectnav?"),
        ({"version": "1"}, "is not as it was written: damaged?"),
        ({"version": 0}, "is not as it was written: damaged?"),
        ({"format": "zarr"}, "is no map of places: its map.json does not say 'insectnav places'"),
        ({"places": "../../elsewhere"}, "is not as it was written: damaged?"),
        ({"places": 3}, "is not as it was written: damaged?"),
        ({"extra": 3}, "is not as it was written: damaged?"),
        ({"about": None}, "is damaged: what the map is about is no record"),
        ({"about": {"metric": "cosine"}}, "is damaged: what the map is about is no record"),
        ({"about": ABOUT.as_json() | {"n_features": 13}}, "do not fit what the map is about: damaged?"),
        ({"about": ABOUT.as_json() | {"metric": "hamming"}}, "/bits' is missing"),
        ({"about": ABOUT.as_json() | {"metric": "??"}}, "is damaged: metric '??' is unknown"),
        ({"places": "places-00000000"}, "is missing"),
        ({"index": {"folder": "index-00000000"}}, "is damaged: what it says of the index is no record"),
    ],
)
def test_a_map_file_that_says_something_else_is_refused(tmp_path, change, sentence):
    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    file = tmp_path / "map" / "map.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    assert sentence in damaged(tmp_path / "map")


def test_a_folder_that_is_not_there_is_said_so_with_the_map_that_is_meant(tmp_path):
    assert damaged(tmp_path / "far" / "gone") == f"'{tmp_path}/far/gone' does not exist, expected the folder of a map"
    PlaceMap.build(tmp_path / "meadow", ROUTE, ABOUT)
    (tmp_path / "meadows").mkdir()  # which is no map, though nearer
    assert damaged(tmp_path / "medows").endswith("expected the folder of a map (did you mean 'meadow'?)")
    assert damaged(tmp_path / "wood").endswith("does not exist, expected the folder of a map")


@pytest.mark.parametrize("folder", ["", "."])
def test_the_present_folder_is_no_new_one(tmp_path, monkeypatch, folder):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"'\.' is named, expected the name of a new folder"):
        PlaceMap.build(folder, ROUTE, ABOUT)
    assert not list(tmp_path.iterdir())


def test_additions_whose_routes_do_not_follow_each_other_are_refused(tmp_path):
    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT).add(ROUTE)
    np.full(400, 2).tofile(tmp_path / "map" / "segments" / "00000001-00000001" / "routes" / "c.0")
    assert damaged(tmp_path / "map").endswith("do not follow each other: damaged?")


def test_an_array_with_a_byte_too_many_is_refused(tmp_path):
    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    with (tmp_path / "map" / "segments" / "00000000-00000000" / "times" / "c.0").open("ab") as file:
        file.write(b"x")
    assert "has 3201 bytes, expected 3200" in damaged(tmp_path / "map")


def test_folders_of_others_are_refused(tmp_path):
    import zarr

    assert damaged(tmp_path).endswith("is no map of places: it has no file map.json")
    (tmp_path / "file").write_text("x")
    assert damaged(tmp_path / "file").endswith("is no map of places: it is a file, expected the folder of a map")
    assert damaged(tmp_path / "file" / "below").endswith("does not exist, expected the folder of a map")
    zarr.create_group(tmp_path / "plain.zarr").create_array("descriptors", data=ROUTE)
    assert "is no map of places" in damaged(tmp_path / "plain.zarr")
    made = PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    made.add(ROUTE)
    made.add(ROUTE)
    shutil.rmtree(tmp_path / "map" / "segments" / "00000001-00000001")  # with what came before and after it there
    assert damaged(tmp_path / "map").endswith("lacks what was added as number 1")
    shutil.rmtree(tmp_path / "map" / "segments" / "00000000-00000000")
    assert damaged(tmp_path / "map").endswith("lacks what was added as number 0")
    shutil.rmtree(tmp_path / "map" / "segments")
    assert damaged(tmp_path / "map").endswith("lacks its folder 'segments'")


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("routes", [0, 2] * 200),
        ("routes", [1] * 399 + [0]),
        ("routes", [-1] * 400),
        ("name_ends", [5] * 400),
        ("name_ends", [-1] * 400),
    ],
)
def test_numbers_that_make_no_sense_are_refused(tmp_path, name, values):
    PlaceMap.build(tmp_path / "map", ROUTE, ABOUT)
    (array,) = (tmp_path / "map").rglob(name)
    np.array(values, np.int64).tofile(array / "c.0")
    assert damaged(tmp_path / "map").endswith("do not fit what the map is about: damaged?")
