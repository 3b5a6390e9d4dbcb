"""Published worlds: found where INSECTNAV_DATA says, refused where they are others, never assumed to be there."""

import os
from pathlib import Path

import pytest

from insectnav.checks import InputError
from insectnav.datasets.known_worlds import DATA_VARIABLE, KNOWN_WORLDS, find_world, world_file
from insectnav.worlds import read_mesh

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")


@pytest.mark.parametrize("name", list(KNOWN_WORLDS))
def test_nowhere_where_no_folder_is_named(name, monkeypatch, tmp_path):
    monkeypatch.delenv(DATA_VARIABLE, raising=False)
    assert find_world(name) is None
    monkeypatch.setenv(DATA_VARIABLE, str(tmp_path))
    assert find_world(name) is None
    with pytest.raises(InputError, match=f"{name} is missing, expected {KNOWN_WORLDS[name].file}"):
        world_file(name)


def test_another_file_of_that_name_is_refused(monkeypatch, tmp_path):
    (tmp_path / KNOWN_WORLDS["clearing"].file).write_bytes(b"another world")
    monkeypatch.setenv(DATA_VARIABLE, str(tmp_path))
    with pytest.raises(InputError, match="another content"):
        find_world("clearing")


def test_unknown_world_is_refused():
    with pytest.raises(InputError, match="did you mean clearing"):
        find_world("clearin")


def test_each_says_where_it_is_from():
    for known in KNOWN_WORLDS.values():
        assert known.origin.startswith("github.com/")
        assert known.licence
        assert len(known.sha256) == 64
        assert 0.0 < known.grey_share <= 1.0


@pytest.mark.data
@pytest.mark.parametrize(("name", "triangles"), [("clearing", 3222), ("seville", 5000)])
def test_the_files_are_those(name, triangles, monkeypatch):
    if not (DATA / KNOWN_WORLDS[name].file).exists():
        pytest.skip("the data are missing")
    monkeypatch.setenv(DATA_VARIABLE, str(DATA))
    assert read_mesh(world_file(name)).n_triangles == triangles
