"""Places where nothing can be written are found out before any frame is read, and named as the user did."""

from pathlib import Path

import pytest

from command_line import NEEDS_POSIX, assert_refused, everything, in_process
from insectnav.experiments.place_maps import build, locate
from place_scenes import two_seasons

LOCATE = ["map", "locate", "route", "winter"]


@pytest.fixture(scope="module")
def walk(tmp_path_factory) -> Path:
    """Two folders of one route in two seasons, a file."""
    folder = two_seasons(tmp_path_factory.mktemp("walk"))
    (folder / "file").write_text("mine")
    return folder


@pytest.fixture
def run(walk: Path, monkeypatch, capsys):
    """The command, for which reading frames is an error."""
    run = in_process(walk, monkeypatch, capsys)
    if not (walk / "route").exists():
        assert run("map", "build", "summer", "route").code == 0
        assert run("map", "build", "summer", "closed", "--freeze").code == 0

    def read(*_: object) -> None:
        raise AssertionError("frames were read")

    monkeypatch.setattr(build, "opened", read)
    monkeypatch.setattr(locate, "opened", read)
    return run


@NEEDS_POSIX
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([*LOCATE, "--out-dir", "file"], "--out-dir 'file' is a file, expected a folder or a new name"),
        ([*LOCATE, "--out-dir", "winter"], "--out-dir 'winter' holds other files, such as 'frame0.png', expected"),
        ([*LOCATE, "--out-dir", "file/below"], "--out-dir 'file/below' cannot be written, since "),
        ([*LOCATE, "--out-dir", "/proc/far/below"], "--out-dir '/proc/far/below' cannot be written ("),
        ([*LOCATE, "--out-dir", "a" * 300], "cannot be written (File name too long)"),
        ([*LOCATE, "--out", "file"], "--out 'file' exists, expected a new name: remove it first"),
        ([*LOCATE, "--out", "winter"], "--out 'winter' is a folder, expected the name of a file"),
        ([*LOCATE, "--out", "gone/m.csv"], "--out 'gone/m.csv' is in a folder that does not exist, expected one that"),
        ([*LOCATE, "--out", "file/m.csv"], "--out 'file/m.csv' cannot be written, since "),
        ([*LOCATE, "--out", "/proc/m.csv"], "--out '/proc/m.csv' cannot be written ("),
        ([*LOCATE, "--out", "a" * 300], "--out 'aaa"),
        ([*LOCATE, "--page", "/proc/p.html"], "--page '/proc/p.html' cannot be written ("),
        (["map", "build", "summer", "file/m"], "the map 'file/m' cannot be written, since "),
        (["map", "build", "summer", "/proc/far/m"], "the map '/proc/far/m' cannot be written ("),
        (["map", "build", "summer", "a" * 300], "cannot be written (File name too long)"),
        (["map", "build", "summer", "closed", "--add"], "the map 'closed' is frozen, expected one that can be added"),
    ],
)
def test_a_place_that_cannot_be_written_is_refused_at_once(run, walk: Path, arguments: list[str], words: str):
    before = everything(walk)
    assert_refused(run(*arguments), words)
    assert everything(walk) == before
    assert (walk / "file").read_text() == "mine"
