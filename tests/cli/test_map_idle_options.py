"""Options of `insectnav map` that would do nothing are refused by name, and nothing is left behind."""

from pathlib import Path

import numpy as np
import pytest

from command_line import assert_refused, everything, in_process
from insectnav.cli import map_options
from insectnav.cli.map_idle_options import with_a_table, without_what_they_need
from insectnav.cli.option_tables import field_of
from place_scenes import N_FRAMES, two_seasons

TABLE = ["map", "evaluate", "m.csv", "--same-index"]
FRAMES = ["map", "evaluate", "route", "winter", "--same-index"]
BUILD = ["map", "build", "summer", "new"]
LOCATE = ["map", "locate", "route", "winter"]
USED_WITH_A_TABLE = {  # by docs/map.md: what judges, and what is known of the queries
    *(name for name, *_ in map_options.TRUTH),
    *("--positions", "--position-columns", "--position-topic", "--max-gap", "--clock", "--first-day"),
    *("--threshold", "--json"),
}
VALUES = {int | None: "3", float | None: "2", str | None: "x"}


@pytest.fixture(scope="module")
def walk(tmp_path_factory) -> Path:
    """Two folders of one route in two seasons, the map of one, matches of the other, features and positions."""
    folder = two_seasons(tmp_path_factory.mktemp("walk"))
    np.save(folder / "a.npy", np.random.default_rng(0).normal(size=(40, 8)))
    (folder / "where.csv").write_text("\n".join(["file,x_m,y_m", *(f"frame{k}.png,{k},0" for k in range(N_FRAMES))]))
    (folder / "track.gpx").write_text('<gpx><trk><trkseg><trkpt lat="1" lon="2"/></trkseg></trk></gpx>')
    return folder


@pytest.fixture
def run(walk: Path, monkeypatch, capsys):
    run = in_process(walk, monkeypatch, capsys)
    if not (walk / "m.csv").exists():
        assert run("map", "build", "summer", "route").code == 0
        assert run("map", "build", "a.npy", "own").code == 0
        assert run("map", "locate", "route", "winter", "--out", "m.csv").code == 0
    return run


OF_FRAMES = [option for option in map_options.OF_EVALUATE if option[0] not in USED_WITH_A_TABLE]


@pytest.mark.parametrize("option", OF_FRAMES, ids=lambda option: option[0])
def test_what_says_how_frames_are_matched_is_refused_with_a_table(run, option):
    name, kind, *_ = option
    given = [name] if kind is bool else [name, VALUES[kind]]
    assert_refused(run(*TABLE, *given), f"{name} is given with a table of matches")


def test_every_option_of_frames_has_its_reason():
    assert {field_of(name) for name, *_ in OF_FRAMES} == {field_of(name) for name in with_a_table({"positions": "p"})}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([*TABLE, "--positions", "where.csv"], "--positions is given with a table of matches and --same-index"),
        ([*TABLE, "--max-gap", "3"], "--max-gap is given without --positions, expected both"),
        ([*TABLE, "--clock", "bag"], "--clock is given with a table of matches and no --positions, expected both"),
        ([*TABLE, "--first-day", "2024-02-29"], "--first-day is given without --positions, expected both"),
        ([*FRAMES, "--map", "route"], "--map is given with a map and frames, expected it with a table"),
        ([*FRAMES, "--positions", "where.csv"], "--positions is given with --same-index, expected one kind of truth"),
        ([*BUILD, "--max-gap", "3"], "--max-gap is given without --positions, expected both"),
        (
            [*BUILD, "--positions", "where.csv", "--max-gap", "9"],
            "--max-gap is given with 'where.csv', which has the",
        ),
        ([*BUILD, "--position-columns", "x_m"], "--position-columns is given without --positions, expected both"),
        (
            [*BUILD, "--positions", "track.gpx", "--position-columns", "x_m"],
            "--position-columns is given with 'track.gpx', which is no table",
        ),
        ([*BUILD, "--utc-offset", "2"], "--utc-offset is given without --times names or exif"),
        ([*BUILD, "--times", "5", "--utc-offset", "2"], "--utc-offset is given without --times names or exif"),
        ([*BUILD, "--time-offset", "2"], "--time-offset is given without --times"),
        (["map", "build", "a.npy", "new", "--camera", "ahead"], "--camera is given with features that are computed"),
        (["map", "locate", "own", "a.npy", "--camera", "panorama"], "--camera is given with features that are"),
        (["map", "locate", "own", "a.npy", "--sky", "otsu"], "--sky is given with features that are computed"),
        ([*LOCATE, "--out", "n.csv", "--title", "mine"], "--title is given without a page, expected --page or"),
        ([*LOCATE, "--sequence-length", "1", "--slowest", "1"], "--slowest is given with --sequence-length 1"),
        ([*LOCATE, "--sequence-length", "1", "--contrast-window", "9"], "--contrast-window is given with --seq"),
    ],
)
def test_what_does_nothing_is_refused_by_name(run, walk: Path, arguments: list[str], words: str):
    before = everything(walk)
    assert_refused(run(*arguments), words)
    assert everything(walk) == before


def test_what_does_something_is_taken(run, walk: Path):
    by_metres = ("--positions", "where.csv", "--tolerance-m", "2", "--threshold", "0.9")
    assert run("map", "evaluate", "m.csv", *by_metres, "--map", "route").code == 2  # whose places have no positions
    assert run("map", "build", "summer", "placed", "--positions", "where.csv").code == 0
    assert run("map", "evaluate", "m.csv", *by_metres, "--map", "placed").code == 0
    assert run(*FRAMES, "--positions", "where.csv", "--every-m", "1").code == 0
    assert run("map", "locate", "own", "a.npy", "--out", "n.csv").code == 0


def test_a_contrast_window_is_of_use_to_frames_one_by_one_where_an_index_searches():
    one_by_one = {"sequence_length": 1}
    assert "--contrast-window" in without_what_they_need(one_by_one)
    assert "--contrast-window" not in without_what_they_need(one_by_one | {"search": "index"})


def test_an_offset_from_utc_is_of_use_to_clocks_in_names_and_pictures():
    is_idle = {times: "--utc-offset" in without_what_they_need({"times": times}) for times in ("names", "exif", "25")}
    assert is_idle == {"names": False, "exif": False, "25": True}
