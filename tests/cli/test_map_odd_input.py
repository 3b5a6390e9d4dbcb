"""`insectnav map` with tables from spreadsheets, patterns, steps and frames that tell nothing."""

import os
import sqlite3
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from functools import reduce
from operator import xor
from pathlib import Path

import cv2
import numpy as np
import pytest

from command_line import NEEDS_POSIX, Outcome, assert_refused, command, strict, table
from insectnav.matching.places import PlaceMap
from place_scenes import N_FRAMES, robot_recording, views, write_pictures
from uneven_films import uneven_film

MATCHES = "query,name,reference,reference_name,route,score,has_sequence\n"


def test_a_table_that_went_through_a_spreadsheet_is_read(run, walk: Path):
    (walk / "m.csv").write_text(MATCHES + "0,a,0.0,p,0.0,0.1,1\n1,b,-1.0,,,,1\n2,c,2.0,q,0.0,0.2,1\n", newline="\r\n")
    numbers = strict(run("map", "evaluate", "m.csv", "--same-index", "--json").out)["numbers"]
    assert (numbers["matched"], numbers["right"], numbers["can_be_matched"]) == (2, 2, 3)


def test_a_table_without_any_match_has_no_recall(run, walk: Path):
    (walk / "m.csv").write_text(MATCHES + "0,a,-1,,,,1\n1,b,-1,,,,1\n")
    numbers = strict(run("map", "evaluate", "m.csv", "--same-index", "--json").out)["numbers"]
    assert (numbers["matched"], numbers["right"], numbers["recall_of_all"]) == (0, 0, 0.0)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0,a,1.5,p,0,0.1,1", "line 2 of 'm.csv' has the reference 1.5, expected a whole number from -1"),
        ("0,a,1e12,p,0,0.1,1", "line 2 of 'm.csv' has the reference 1e+12, expected a whole number from -1"),
        ("0,a,inf,p,0,0.1,1", "line 2 of 'm.csv' has the reference inf, expected a whole number from -1"),
        ("0,a,1,p,-3,0.1,1", "line 2 of 'm.csv' has the route -3, expected a whole number from 0"),
        ("0,a,1,p,x,0.1,1", "line 2 of 'm.csv' has the route 'x', expected a number"),
        ("0,a,1,p,0,,1", "line 2 of 'm.csv' has a match without a score"),
    ],
)
def test_a_table_with_odd_places_or_routes_is_refused(run, walk: Path, line: str, words: str):
    (walk / "m.csv").write_text(MATCHES + line + "\n")
    assert_refused(run("map", "evaluate", "m.csv", "--same-index"), words)


def test_features_too_large_for_half_of_double_precision_are_missing(run, walk: Path):
    route = np.random.default_rng(0).normal(size=(20, 8))
    route[3, 2] = 1e300
    np.save(walk / "a.npy", route)
    built = strict(run("map", "build", "a.npy", "m", "--descriptor", "own", "--json").out)
    assert built["missing"] == 1
    assert built["notes"] == [
        "missing frame a_000003: its features are NaN, infinite or beyond 3e38, expected finite numbers"
    ]


def test_truth_by_names_of_files_and_what_is_said_of_places_that_nothing_was_matched_with(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    pairs = "".join(f"winter/frame{k}.png,frame{k}.PNG\n" for k in range(N_FRAMES))
    (walk / "pairs.csv").write_text("query,reference\n" + pairs)
    found = strict(run("map", "locate", "route", "winter", "--truth", "pairs.csv", "--out", "m.csv", "--json").out)
    assert (found["numbers"]["right"], found["numbers"]["can_be_matched"]) == (N_FRAMES - 10, N_FRAMES - 10)
    words = "names the place 'frame0.PNG', expected a number from 0 or the name of one frame: one that nothing was matc"
    assert_refused(run("map", "evaluate", "m.csv", "--truth", "pairs.csv"), words)
    judged = strict(run("map", "evaluate", "m.csv", "--truth", "pairs.csv", "--map", "route", "--json").out)
    assert judged["numbers"] == found["numbers"]


@pytest.mark.parametrize("option", ["--truth", "--key-frames"])
@pytest.mark.parametrize("place", ["10000001", "1000000000000000", "1" + 30 * "0"])
def test_a_truth_far_beyond_any_map_is_refused(run, walk: Path, option: str, place: str):
    (walk / "m.csv").write_text(MATCHES + "0,a,0,p,0,0.1,1\n1,b,1,q,0,0.2,1\n")
    (walk / "true.csv").write_text(f"query,reference\n0,0\n1,{place}\n")
    words = "the truth names a place beyond 10000000, expected numbers of places of a map"
    assert_refused(run("map", "evaluate", "m.csv", option, "true.csv"), words)


def test_matches_without_a_true_place_are_not_left_out_of_errors_unsaid(run, walk: Path):
    write_pictures(walk / "one", views()[:1])
    assert run("map", "build", "one", "m").code == 0
    done = run("map", "locate", "m", "summer", "--sequence-length", "1", "--same-index")
    assert f"frames at most: of 1, as {N_FRAMES - 1} more have no true place on their route" in done.out


def test_settings_that_are_told_are_those_that_may_be_given(run, walk: Path):
    """However the map is searched: what a search keeps for itself is none of them."""
    assert run("map", "build", "summer", "route", "--camera", "panorama", "--descriptor", "turned-views").code == 0
    told = strict(run("map", "locate", "route", "winter", "--out", "m.csv", "--json").out)["settings"]
    assert set(told) >= {"sequence_length", "slowest", "fastest", "contrast_window", "unique_window"}
    assert "offsets" not in told


@NEEDS_POSIX
def test_pictures_whose_names_are_no_utf_8_are_frames_like_others(run, walk: Path):
    folder = walk / os.fsdecode(b"Stra\xdfe")  # as older cameras and computers wrote it
    folder.mkdir()
    for k, picture in enumerate(views()[:15]):
        (folder / os.fsdecode(b"\xfc%02d.png" % k)).write_bytes(cv2.imencode(".png", picture)[1].tobytes())
    assert run("map", "build", str(folder), "m").code == 0
    assert PlaceMap.open(walk / "m").names[:2] == ("\ufffd00", "\ufffd01")
    found = strict(run("map", "locate", "m", str(folder), "--same-index", "--sequence-length", "4", "--json").out)
    assert (found["numbers"]["right"], found["matches"][7]["reference_name"]) == (11, "\ufffd07")
    assert (walk / found["files"]["page to look at"]).exists()


def test_a_log_of_times_of_day_alone_needs_a_date(run, walk: Path):
    start = datetime(2024, 2, 29, 23, 59, 50, tzinfo=UTC)

    def sentence(k: int, kind: str, ending: str) -> str:
        body = f"GP{kind},{start + timedelta(seconds=k):%H%M%S}.00,{ending}"
        return f"${body}*{reduce(xor, body.encode()):02X}\n"

    log = "".join(sentence(k, "GGA", f"51{k / 1000:010.7f},N,00000.0,E,1,08,1,12.0,M,0,M,,") for k in range(N_FRAMES))
    (walk / "log.nmea").write_text(log)
    (walk / "times.csv").write_text(
        "file,time_s\n" + "".join(f"frame{k},{start.timestamp() + k}\n" for k in range(N_FRAMES))
    )
    build = ("map", "build", "summer", "m", "--times", "times.csv", "--positions", "log.nmea")
    assert_refused(
        run(*build), "'log.nmea' tells of no position when it was, expected times: a log of times of day alo"
    )
    assert_refused(run(*build, "--first-day", "29.2.2024"), "--first-day is '29.2.2024', expected a date as 2014-05-06")
    assert_refused(run(*build[:-1], "times.csv", "--first-day", "2024-02-29"), "expected it with the log of a receiver")
    assert_refused(run(*build[:4], "--first-day", "2024-02-29"), "--first-day is given without --positions")
    done = strict(run(*build, "--first-day", "2024-02-29", "--json").out)
    assert (done["with_position"], done["spacing_m"]) == (N_FRAMES, pytest.approx(1.854, abs=1e-3))  # 0.001' of 51° N
    dated = sentence(0, "RMC", "A,5100.0,N,00000.0,E,1,0,290224,,") + log
    (walk / "log.nmea").write_text(dated)
    assert_refused(
        run(*build[:3], "n", *build[4:], "--first-day", "2024-02-29"), "which tells its dates, expected none"
    )


def test_a_film_of_uneven_rate_is_where_it_was_at_its_own_times(run, walk: Path):
    """A telephone that slows down: by the mean rate, frame 10 would be 1.2 s and 12 m late."""
    seconds = np.repeat([0.1, 0.5, 0.1], 10)
    uneven_film(walk / "walk.mp4", views()[:30], seconds)
    (walk / "track.csv").write_text("time_s,x_m,y_m\n100,0,0\n110,100,0\n")
    where = ("--positions", "track.csv", "--max-gap", "20")
    done = strict(run("map", "build", "walk.mp4", "m", *where, "--time-offset", "100", "--json").out)
    assert (done["with_time"], done["with_position"], done["notes"]) == (30, 30, [])
    place_map = PlaceMap.open(walk / "m")
    times = np.cumsum([0.0, *seconds[:-1]])
    np.testing.assert_allclose(place_map.times - 100, times, atol=1e-3)
    np.testing.assert_allclose(place_map.positions[:, 0], 10 * times, atol=1e-2)
    assert_refused(run("map", "build", "walk.mp4", "other", *where), "the times of the frames run from 0 to 6.")
    (walk / "numbers.csv").write_text("frame,x_m,y_m\n" + "".join(f"{k},{k},0\n" for k in range(30)))
    assert run("map", "build", "walk.mp4", "n", "--positions", "numbers.csv", "--every-s", "0.4").code == 0
    spread = PlaceMap.open(walk / "n")
    np.testing.assert_allclose(spread.times, times[spread.positions[:, 0].astype(int)], atol=1e-3)
    assert np.diff(spread.times).min() > 0.39


def test_a_film_that_breaks_off_is_told_to_be_shorter_than_it_says(run, walk: Path):
    writer = cv2.VideoWriter(str(walk / "whole.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (96, 48))
    for picture in views()[:30]:
        writer.write(np.dstack([picture] * 3))
    writer.release()
    whole = (walk / "whole.avi").read_bytes()
    (walk / "half.avi").write_bytes(whole[: len(whole) // 2])
    assert strict(run("map", "build", "whole.avi", "w", "--json").out)["notes"] == []
    for more, said in (((), 30), (("--step", "2"), 15)):
        done = strict(run("map", "build", "half.avi", f"m{said}", *more, "--json").out)
        assert 1 < done["places"] < said
        words = f"'half.avi' should give {said} frames, {done['places']} could be read: cut short, or damaged?"
        assert done["notes"] == [words]
    assert words in strict(run("map", "locate", "w", "half.avi", "--step", "2", "--sequence-length", "2",
                               "--out", "m.csv", "--json").out)["notes"]  # fmt: skip


def test_a_damaged_film_is_told_in_one_sentence_alone(walk: Path):
    (walk / "bad.mp4").write_bytes(b"no film" * 100)  # of which OpenCV's libraries have much to say
    done = command(walk, "map", "build", "bad.mp4", "m")
    assert_refused(done, "no frame can be used, bad: 'bad.mp4' cannot be opened as a video")


@NEEDS_POSIX
def test_what_the_system_says_against_a_large_file_is_told(walk: Path):
    line = f"ulimit -f 40; {sys.executable} -m insectnav.cli map build features.npy m --descriptor own --no-pictures"
    np.save(walk / "features.npy", np.random.default_rng(0).normal(size=(400, 64)))
    done = subprocess.run(["sh", "-c", line], cwd=walk, capture_output=True, encoding="utf-8", timeout=120, check=False)
    assert_refused(Outcome(done.returncode, done.stdout, done.stderr), "the map 'm' cannot be written (File too large)")


def test_positions_by_number_are_those_of_all_frames_whatever_the_step(run, walk: Path):
    lines = ["frame,x_m,y_m", *(f"{k},{3.0 * k},0" for k in range(N_FRAMES))]
    (walk / "where.csv").write_text("\n".join(lines))
    where = ("--positions", "where.csv", "--tolerance-m", "4")
    assert run("map", "build", "summer", "route", "--positions", "where.csv", "--step", "2").code == 0
    located = ("map", "locate", "route", "winter", *where, "--step", "2", "--out", "m.csv", "--json")
    found = strict(run(*located).out)["numbers"]
    judged = strict(run("map", "evaluate", "m.csv", *where, "--map", "route", "--json").out)["numbers"]
    assert [row["frame"] for row in table(walk / "m.csv")] == [str(2 * k) for k in range(N_FRAMES // 2)]
    for name in ("right", "judged", "recall_of_all", "error_largest"):
        assert judged[name] == found[name]
    assert judged["right"] == N_FRAMES // 2 - 10


@pytest.mark.parametrize(
    ("frames", "folder"),
    [("winter/frame*.png", "frame"), ("winter/*.png", "winter"), ("winter/frame?*", "frame"), ("winter", "winter")],
)
def test_frames_by_a_pattern_leave_a_folder_without_stars(run, walk: Path, frames: str, folder: str):
    assert run("map", "build", "summer", "route").code == 0
    assert run("map", "locate", "route", frames).code == 0
    assert [path.name for path in (walk / "out").iterdir()] == [f"locate-{folder}"]


def test_no_name_is_not_the_folder_one_is_in(run, walk: Path, monkeypatch):
    monkeypatch.chdir(walk / "winter")
    assert_refused(run("map", "build", "", "../route"), "an empty name is given, expected a folder, a file or '.'")


def test_the_folder_one_is_in_has_its_name_in_the_title(run, walk: Path, monkeypatch):
    assert run("map", "build", "summer", "route").code == 0
    monkeypatch.chdir(walk / "winter")
    assert run("map", "locate", "../route", ".", "--page", "../page.html").code == 0
    assert "<title>insectnav: winter located in route</title>" in (walk / "page.html").read_text(encoding="utf-8")


def test_positions_that_say_nothing_of_the_frames_are_told(run, walk: Path):
    names = [f"frame{k}.png" for k in range(N_FRAMES)]
    (walk / "where.csv").write_text("\n".join(["file,x_m,y_m", *(f"{name},," for name in names)]))
    built = strict(run("map", "build", "summer", "route", "--positions", "where.csv", "--json").out)
    assert built["notes"] == ["no frame has a position, since 'where.csv' has none of x and y for them"]
    np.save(walk / "a.npy", np.random.default_rng(0).normal(size=(20, 8)))
    words = "'where.csv' has names of files, expected times or numbers of frames for those of a film or an array"
    done = run("map", "build", "a.npy", "m", "--descriptor", "own", "--positions", "where.csv")
    assert_refused(done, words)


def test_a_blank_picture_has_no_match_of_single_frames_either(run, walk: Path):
    cv2.imwrite(str(walk / "winter" / "frame7.png"), np.full((48, 96), 90, np.uint8))
    assert run("map", "build", "summer", "route").code == 0
    located = ("map", "locate", "route", "winter", "--sequence-length", "1", "--same-index", "--out", "m.csv", "--json")
    found = strict(run(*located).out)
    assert [row["query"] for row in found["matches"] if row["reference"] < 0] == [7]
    assert found["numbers"]["precision_of_all"] == 1.0
    assert "1 more query has no match: too many frames missing, or nothing tells places apart" in found["notes"]


def test_a_match_is_not_unique_where_every_place_counts_as_the_same(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    located = ("map", "locate", "route", "winter", "--sequence-length", "1", "--unique-window", "1000")
    found = strict(run(*located, "--out", "m.csv", "--json").out)
    assert {row["score"] for row in found["matches"]} == {1.0}


def test_a_table_is_not_judged_by_another_map(run, walk: Path):
    for folder, step in (("one", "1"), ("other", "2")):
        assert run("map", "build", "summer", folder, "--step", step).code == 0
    assert run("map", "locate", "other", "winter", "--step", "2", "--out", "m.csv").code == 0
    assert run("map", "evaluate", "m.csv", "--same-index", "--map", "other").code == 0
    words = "is called 'frame10' in the table and 'frame5' in the map"
    assert_refused(run("map", "evaluate", "m.csv", "--same-index", "--map", "one"), words)


def test_a_spreadsheet_may_drop_zeros_of_names(run, walk: Path):
    write_pictures(walk / "numbered", views(), "{:05d}.png")
    assert run("map", "build", "numbered", "m").code == 0
    rows = "".join(f"{k},x,{k},{k},0,0.5,1\n" for k in range(20))
    (walk / "m.csv").write_text(MATCHES + rows)
    assert run("map", "evaluate", "m.csv", "--same-index", "--map", "m").code == 0
    (walk / "m.csv").write_text(MATCHES + rows.replace(",7,7,", ",7,8,"))
    assert_refused(run("map", "evaluate", "m.csv", "--same-index", "--map", "m"), "place 7 is called '8'")


@pytest.mark.parametrize(
    "arguments",
    [
        ["build", "LONG", "m"],
        ["build", "summer", "LONG"],
        ["build", "summer", "m", "--positions", "LONG"],
        ["build", "summer", "m", "--times", "LONG"],
        ["locate", "LONG", "summer"],
        ["evaluate", "LONG", "--same-index"],
        ["info", "LONG"],
    ],
)
def test_names_that_no_disk_takes_are_refused(run, walk: Path, arguments: list[str]):
    done = run("map", *(word.replace("LONG", "a" * 300) for word in arguments))
    assert_refused(done, "File name too long")
    assert not (walk / "m").exists()


def test_a_camera_that_stamps_nothing_has_the_times_of_arrival(run, walk: Path):
    robot_recording(walk, views()[:20], is_stamped=False)
    built = ("map", "build", "robot", "route", "--positions", "robot")
    assert_refused(run(*built), "message 0 of '/camera' in 'robot' has no time stamp, expected one: --clock bag")
    assert_refused(run(*built, "--clock", "stamp"), "has no time stamp")
    assert_refused(run(*built, "--clock", "ros"), "clock 'ros' is unknown: expected one of stamp, bag")
    assert_refused(run("map", "build", "summer", "m", "--clock", "bag"), "--clock is given, expected it with the rec")
    assert not (walk / "route").exists()
    done = strict(run(*built, "--clock", "bag", "--json").out)
    assert (done["with_time"], done["with_position"], done["spacing_m"]) == (20, 20, pytest.approx(3.0))
    found = run("map", "locate", "route", "robot", "--clock", "bag", "--same-index", "--out", "m.csv")
    assert found.code == 0
    assert [row["time_s"] for row in table(walk / "m.csv")] == [str(10 + k) for k in range(20)]


def test_a_damaged_picture_of_a_robot_is_a_missing_frame_with_its_name(run, walk: Path):
    path = robot_recording(walk, views())
    with sqlite3.connect(next(path.glob("*.db3"))) as store:
        pictures = "WHERE topic_id = (SELECT id FROM topics WHERE name = '/camera') ORDER BY timestamp"
        ids = [row[0] for row in store.execute(f"SELECT id FROM messages {pictures}")]
        store.execute("UPDATE messages SET data = substr(data, 1, 30) WHERE id = ?", (ids[20],))
    built = run("map", "build", "robot", "route", "--positions", "robot")
    assert built.code == 0
    assert f"{N_FRAMES} frames in" in built.out
    assert "1 of them missing" in built.out
    assert "note: missing frame robot_000020: message 20 of '/camera' in 'robot' cannot be decoded" in built.out
    assert f"positions of {N_FRAMES - 1} places" in built.out
    found = strict(run("map", "locate", "route", "robot", "--same-index", "--out", "m.csv", "--json").out)
    assert found["numbers"]["precision_of_all"] == 1.0
    assert len(found["matches"]) == N_FRAMES
    for one in ids:
        with sqlite3.connect(next(path.glob("*.db3"))) as store:
            store.execute("UPDATE messages SET data = substr(data, 1, 30) WHERE id = ?", (one,))
    words = "no frame can be used, robot_000000: message 0 of '/camera' in 'robot' cannot be decoded"
    assert_refused(run("map", "build", "robot", "new"), words)
