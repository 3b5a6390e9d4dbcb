"""`insectnav map` as a person meets it: two folders in, matches and a page out; what is refused, noted, left behind."""

import base64
import os
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from command_line import NEEDS_POSIX, assert_refused, command, everything, strict, table, until
from html_outline import Outline
from insectnav.experiments.place_maps.thumbnails import find_thumbnails
from insectnav.matching.places import PlaceMap
from place_scenes import N_FRAMES, panoramas, sky_disk, skylines, spoil, views, write_pictures


def test_two_folders_give_a_map_matches_and_a_page(walk: Path):
    built = command(walk, "map", "build", "summer", "route")
    assert (built.code, built.err) == (0, "")
    assert f"route: {N_FRAMES} places on 1 route" in built.out
    done = command(walk, "map", "locate", "route", "winter", "--same-index", "--tolerance-frames", "1")
    assert (done.code, done.err) == (0, "")
    assert "precision of all matches 100.0%, recall at 100 % precision 100.0%" in done.out
    out = walk / "out" / "locate-winter"
    rows = table(out / "matches.csv")
    assert [row["name"] for row in rows] == [f"frame{k}" for k in range(N_FRAMES)]
    inner = rows[5:-5]
    assert {row["reference"] for row in rows[:5] + rows[-5:]} == {"-1"}
    assert [int(row["reference"]) for row in inner] == list(range(5, N_FRAMES - 5))
    assert [row["reference_name"] for row in inner] == [row["name"] for row in inner]
    assert {row["speed"] for row in inner} == {"1"}
    assert {row["is_right"] for row in inner} == {"1"}
    names = {path.name for path in out.iterdir()}
    assert names == {"matches.csv", "page.html", "summary.json", "provenance.json", "figures"}
    assert {path.suffix for path in (out / "figures").iterdir()} == {".png", ".pdf"}
    assert {path.stem for path in (out / "figures").iterdir()} == {"matches", "precision", "pairs"}


def test_a_figure_on_the_page_is_that_in_the_folder(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    assert run("map", "locate", "route", "winter", "--out-dir", "found").code == 0
    assert run("map", "locate", "route", "winter", "--page", "alone.html").code == 0
    shown = base64.b64encode((walk / "found" / "figures" / "matches.png").read_bytes()).decode()
    assert shown in (walk / "found" / "page.html").read_text(encoding="utf-8")
    assert shown in (walk / "alone.html").read_text(encoding="utf-8")


def test_the_page_is_one_file_that_loads_nothing(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    title = "<script>alert(1)</script>"
    done = run("map", "locate", "route", "winter", "--same-index", "--page", "page.html", "--title", title)
    assert done.code == 0
    assert not (walk / "out").exists()  # a file was named: nothing else is left
    text = (walk / "page.html").read_text(encoding="utf-8")
    assert len(text) < 5_000_000
    page = Outline(text)
    assert not page.open
    names = [name for name, _ in page.elements]
    assert "script" not in names
    sources = [attributes["src"] for name, attributes in page.elements if name == "img"]
    assert all(source.startswith(("data:image/png;base64,", "data:image/jpeg;base64,")) for source in sources)
    assert sum(source.startswith("data:image/jpeg") for source in sources) >= 6  # three pairs at least
    assert not [attributes for _, attributes in page.elements if attributes.get("href", "data:").startswith("http")]
    assert "prefers-color-scheme: dark" in text
    for words in (
        "patch-normalised",
        "sequences of 11 frames",
        "0.8 to 1.2 places per query",
        "--same-index",
        "cosine",
    ):
        assert words in text


def test_json_is_one_object_with_all_that_is_known(run, walk: Path):
    built = strict(run("map", "build", "summer", "route", "--step", "2", "--json").out)
    assert (built["frames"], built["places"], built["routes"], built["missing"]) == (N_FRAMES // 2, N_FRAMES // 2, 1, 0)
    assert built["settings"] == {"sky": "none", "size": "32x64"}
    found = strict(
        run("map", "locate", "route", "winter", "--step", "2", "--same-index", "--out", "m.csv", "--json").out
    )
    assert found["numbers"]["precision_of_all"] == 1.0
    assert found["files"] == {"matches": "m.csv"}
    assert len(found["matches"]) == N_FRAMES // 2
    told = strict(run("map", "info", "route", "--json").out)
    assert {key: told[key] for key in ("places", "descriptor", "features", "camera", "is_frozen", "is_unfinished")} == {
        "places": 20, "descriptor": "patch-normalised", "features": 2048, "camera": "ahead", "is_frozen": False,
        "is_unfinished": False,
    }  # fmt: skip
    judged = strict(run("map", "evaluate", "m.csv", "--same-index", "--json").out)
    again = strict(run("map", "evaluate", "route", "winter", "--step", "2", "--same-index", "--json").out)
    for name in ("precision_of_all", "recall_of_all", "recall_at_full_precision", "area", "right", "error_median"):
        assert judged["numbers"][name] == again["numbers"][name] == found["numbers"][name]
    assert len(judged["curve"]["precision"]) == len(judged["curve"]["threshold"])


def test_a_corrupt_picture_is_a_missing_frame_with_its_name(run, walk: Path):
    spoil(walk / "summer" / "frame20.png")
    spoil(walk / "winter" / "frame12.png")
    built = run("map", "build", "summer", "route")
    assert built.code == 0
    assert "1 of them missing" in built.out
    assert "missing frame frame20: 'frame20.png' ends before its picture does" in built.out
    done = run("map", "locate", "route", "winter", "--same-index", "--out", "m.csv")
    assert "missing frame frame12" in done.out
    assert "precision of all matches 100.0%" in done.out
    assert len(table(walk / "m.csv")) == N_FRAMES


def test_only_corrupt_pictures_are_refused_and_nothing_is_left(run, walk: Path):
    for path in (walk / "summer").iterdir():
        spoil(path)
    before = everything(walk)
    words = (
        "no frame can be used, frame0: 'frame0.png' ends before its picture does, expected a whole PNG: copied in part?"
    )
    assert_refused(run("map", "build", "summer", "route"), f"{words} (and {N_FRAMES - 1} more)")
    assert everything(walk) == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["map", "build", "nowhere", "m"], "'nowhere' does not exist"),
        (["map", "build", "empty", "m"], "no photograph is given"),
        (["map", "build", "summer", "route"], "'route' exists, expected a new name, or --add"),
        (["map", "build", "summer", "m", "--add"], "'m' does not exist, expected a map to add to"),
        (["map", "build", "summer", "m", "--descriptor", "zernik"], "did you mean zernike?"),
        (["map", "build", "summer", "m", "--descriptor", "zernike"], "wants the sky all round and --camera is ahead"),
        (["map", "build", "summer", "m", "--camera", "fish"], "did you mean fisheye?"),
        (["map", "build", "summer", "m", "--camera", "mirror"], "expected mirror with its radius"),
        (["map", "build", "summer", "m", "--step", "2", "--every-m", "1"], "--step and --every-m are given"),
        (["map", "build", "summer", "m", "--step", "0"], "step is 0, expected a whole number of at least 1"),
        (["map", "build", "summer", "m", "--every-m", "1"], "--every-m is given without --positions"),
        (["map", "build", "summer", "m", "--every-s", "1"], "--every-s is given without --times"),
        (["map", "build", "summer", "m", "--position-topic", "x"], "--position-topic is given without --positions"),
        (["map", "build", "summer", "m", "--time-offset", "nan"], "time-offset is nan, expected"),
        (["map", "build", "summer", "m", "--metric", "hamming"], "expected cosine with patch-normalised"),
        (["map", "build", "summer", "route", "--add", "--descriptor", "retinotopic"], "--descriptor is 'retinotopic'"),
        (["map", "locate", "nowhere", "winter"], "'nowhere' does not exist, expected the folder of a map"),
        (["map", "locate", "summer", "winter"], "summer"),
        (["map", "locate", "route", "winter", "--camera", "panorama"], "--camera is 'panorama', expected 'ahead' as"),
        (["map", "locate", "route", "winter", "--sky", "otsu"], "--sky is 'otsu', expected 'none' as the map"),
        (["map", "locate", "route", "winter", "--descriptor", "zernike"], "--descriptor is 'zernike', expected"),
        (["map", "locate", "route", "winter", "--out", "there.csv"], "--out 'there.csv' exists"),
        (["map", "locate", "route", "winter", "--page", "no/page.html"], "folder that does not exist"),
        (["map", "locate", "route", "winter", "--out-dir", "winter"], "holds other files"),
        (["map", "locate", "route", "few"], "fewer frames than a sequence?"),
        (["map", "locate", "route", "winter", "--slowest", "2"], "slowest and fastest interchanged?"),
        (["map", "locate", "route", "winter", "--tolerance-frames", "2"], "without a truth in frames"),
        (["map", "locate", "route", "winter", "--tolerance-m", "2"], "--tolerance-m is given without --positions"),
        (["map", "locate", "route", "winter", "--same-index", "--truth", "t.csv"], "--truth and --same-index are"),
        (["map", "locate", "route", "winter", "--truth", "t.csv"], "has the columns a, b, expected"),
        (["map", "locate", "route", "winter", "--truth", "twice.csv"], "line 4 of --truth 'twice.csv' gives query 1"),
        (["map", "locate", "route", "winter", "--threshold", "nan"], "threshold is nan, expected 0 to"),
        (["map", "locate", "route", "winter", "--threshold", "-0.1"], "threshold is -0.1, expected 0 to"),
        (["map", "locate", "route", "winter", "--threshold", "inf"], "threshold is inf, expected 0 to"),
        (["map", "locate", "route", "winter", "--out", "x", "--page", "./x"], "--out and --page are both 'x'"),
        (["map", "locate", "route", "winter", "--search", "fast"], "fast"),
        (["map", "evaluate", "route", "winter"], "nothing is known of the truth"),
        (["map", "evaluate", "route"], "is a map, expected frames after it"),
        (["map", "evaluate", "t.csv", "--same-index"], "lacks the columns query, reference, score"),
        (["map", "evaluate", "gone.csv", "--same-index"], "'gone.csv' does not exist"),
        (["map", "info", "winter"], "'winter' is no map of places: it has no file map.json"),
        (["map", "info", "rout"], "'rout' does not exist, expected the folder of a map (did you mean 'route'?)"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_said_in_one_sentence(run, walk: Path, arguments: list[str], words: str):
    assert run("map", "build", "summer", "route").code == 0
    (walk / "empty").mkdir()
    write_pictures(walk / "few", views(8))
    (walk / "there.csv").write_text("mine")
    (walk / "t.csv").write_text("a,b\n1,2\n")
    (walk / "twice.csv").write_text("query,reference\n0,0\n1,1\n1,5\n")
    before = everything(walk)
    assert_refused(run(*arguments), words)
    assert everything(walk) == before
    assert (walk / "there.csv").read_text() == "mine"


def test_truth_of_a_table_by_name_and_number(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    lines = ["query,reference", *(f"frame{k},{k}" for k in range(30)), "30,", "frame31,frame0"]
    (walk / "truth.csv").write_text("\n".join(lines))
    done = strict(run("map", "locate", "route", "winter", "--truth", "truth.csv", "--out", "m.csv", "--json").out)
    numbers = done["numbers"]
    # 25 queries with a whole sequence are right; query 30 is in no place, 31 elsewhere; 32 on are not judged.
    assert (numbers["right"], numbers["judged"], numbers["can_be_matched"]) == (25, 27, 26)
    assert numbers["precision_of_all"] == pytest.approx(25 / 27)
    assert numbers["recall_of_all"] == pytest.approx(25 / 26)
    rows = table(walk / "m.csv")
    assert (rows[30]["is_right"], rows[31]["is_right"], rows[32]["is_right"]) == ("0", "0", "")
    assert rows[31]["error"] == "31"


def test_positions_and_thinning_by_metres(run, walk: Path):
    lines = ["file,x_m,y_m", *(f"frame{k}.png,{3.0 * k},{0.5}" for k in range(N_FRAMES))]
    (walk / "where.csv").write_text("\n".join(lines))
    built = run("map", "build", "summer", "route", "--positions", "where.csv", "--every-m", "6")
    assert f"route: {N_FRAMES // 2} places" in built.out
    assert f"positions of {N_FRAMES // 2} places, {3 * N_FRAMES - 6} m in steps of 6 m" in built.out
    options = ("--positions", "where.csv", "--tolerance-m", "4", "--every-m", "6")
    found = run("map", "locate", "route", "winter", *options, "--out-dir", "r")
    assert found.code == 0
    assert "precision of all matches 100.0%" in found.out
    rows = table(walk / "r" / "matches.csv")
    inner = [row for row in rows if row["reference"] != "-1"]
    assert len(inner) == N_FRAMES // 2 - 10
    assert [float(row["x"]) for row in inner] == [6.0 * int(row["query"]) for row in inner]
    assert {(row["y"], row["error"], row["error_unit"]) for row in inner} == {("0.5", "0", "m")}
    assert (walk / "r" / "figures" / "route.png").exists()
    judged = ("map", "evaluate", "r/matches.csv", "--positions", "where.csv", "--tolerance-m", "4", "--json")
    with_map = strict(run(*judged, "--map", "route").out)
    assert with_map["numbers"]["recall_of_all"] == 1.0
    assert strict(run(*judged).out)["numbers"]["right"] == with_map["numbers"]["right"]


def test_adding_makes_a_second_route_and_freezing_ends_it(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    added = strict(run("map", "build", "winter", "route", "--add", "--freeze", "--json").out)
    assert (added["places"], added["routes"], added["is_frozen"]) == (2 * N_FRAMES, 2, True)
    assert_refused(run("map", "build", "winter", "route", "--add"), "frozen")
    write_pictures(walk / "spring", views(season=2))
    found = strict(run("map", "locate", "route", "spring", "--same-index", "--out", "m.csv", "--json").out)
    assert found["numbers"]["precision_of_all"] == 1.0
    assert {row["route"] for row in found["matches"] if row["reference"] >= 0} <= {0, 1}


def test_features_of_your_own(run, walk: Path):
    rng = np.random.default_rng(0)
    route = np.cumsum(rng.normal(size=(60, 32)), axis=0).astype(np.float32)
    np.save(walk / "a.npy", route)
    np.save(walk / "b.npy", route[10:50] + 0.1 * rng.normal(size=(40, 32)))
    built = run("map", "build", "a.npy", "m", "--descriptor", "netvlad", "--metric", "euclidean")
    assert "described by netvlad (32 features, euclidean)" in built.out
    found = strict(run("map", "locate", "m", "b.npy", "--out", "m.csv", "--json").out)
    references = [row["reference"] for row in found["matches"]]
    assert references[5:-5] == list(range(15, 45))
    assert_refused(run("map", "locate", "m", "winter"), "features that were computed elsewhere ('netvlad')")
    np.save(walk / "c.npy", route[:, :8])
    assert_refused(run("map", "locate", "m", "c.npy"), "n_features of the queries")
    np.save(walk / "objects.npy", np.array([{}, {}], object), allow_pickle=True)
    assert_refused(run("map", "build", "objects.npy", "x"), "objects.npy")
    assert_refused(run("map", "build", "a.npy", "x", "--sky", "otsu"), "--sky is given with features")


def test_skies_and_turned_views_through_cameras(run, walk: Path):
    skies = skylines()
    write_pictures(walk / "up", np.stack([sky_disk(one) for one in skies]))
    write_pictures(walk / "turned", np.stack([sky_disk(one, turn_deg=40.0) for one in skies]))
    options = ("--camera", "fisheye:180", "--sky", "mask")
    for descriptor in ("spherical-harmonics", "zernike", "turned-views"):
        assert run("map", "build", "up", descriptor, "--descriptor", descriptor, *options).code == 0
        found = strict(
            run("map", "locate", descriptor, "turned", "--same-index", "--out", f"{descriptor}.csv", "--json").out
        )
        assert found["numbers"]["precision_of_all"] == 1.0, descriptor
    headings = [row["heading_deg"] for row in found["matches"] if row["reference"] >= 0]
    assert np.abs(np.array(headings) - 40.0).max() <= 3.0  # a column of the view


@pytest.mark.slow
def test_skies_after_any_rotation(run, walk: Path):
    skies = skylines()[::4]
    write_pictures(walk / "up", np.stack([sky_disk(one) for one in skies]))
    write_pictures(walk / "turned", np.stack([sky_disk(one, turn_deg=40.0) for one in skies]))
    (walk / "turned" / "frame3.png").write_bytes(b"no picture")
    options = ("--camera", "fisheye:180", "--sky", "mask", "--descriptor", "rotations")
    assert run("map", "build", "up", "rot", *options).code == 0
    for length, matched in (("1", [0, 1, 2, 4, 5, 6, 7, 8, 9]), ("4", [2, 3, 4, 5, 6, 7])):
        of_length = ("--sequence-length", length, "--unique-window", "2", "--out", f"{length}.csv")
        rows = strict(run("map", "locate", "rot", "turned", *of_length, "--json").out)["matches"]
        assert {row["query"]: row["reference"] for row in rows if row["reference"] >= 0} == {k: k for k in matched}
        seen = [row for row in rows if row["reference"] >= 0 and row["query"] != 3]  # the missing one in a sequence
        angles = np.array([[row["heading_deg"], row["pitch_deg"], row["roll_deg"]] for row in seen])
        assert np.abs(angles - [40.0, 0.0, 0.0]).max() < 2.0
        assert all(row["heading_deg"] is None for row in rows if row not in seen)


def test_single_panoramas_after_any_turn(run, walk: Path):
    known = panoramas()
    write_pictures(walk / "known", known)
    turns = (7 * np.arange(N_FRAMES)) % 120
    # A turn to the right moves what is seen to the left.
    write_pictures(
        walk / "seen", np.stack([np.roll(one, -turn, axis=1) for one, turn in zip(known, turns, strict=True)])
    )
    assert run("map", "build", "known", "m", "--camera", "panorama", "--descriptor", "turned-views").code == 0
    found = strict(run("map", "locate", "m", "seen", "--sequence-length", "1", "--out", "m.csv", "--json").out)
    assert [row["reference"] for row in found["matches"]] == list(range(N_FRAMES))
    headings = np.array([row["heading_deg"] for row in found["matches"]])
    off = np.mod(headings - 3.0 * turns + 180.0, 360.0) - 180.0
    assert np.abs(off).max() < 1e-9


def test_a_film_knows_its_times(run, walk: Path):
    writer = cv2.VideoWriter(str(walk / "film.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (96, 48))
    for frame in views():
        writer.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    writer.release()
    built = strict(run("map", "build", "film.avi", "m", "--step", "2", "--json").out)
    assert (built["places"], built["with_time"]) == (N_FRAMES // 2, N_FRAMES // 2)
    found = strict(
        run("map", "locate", "m", "film.avi", "--every-s", "0.2", "--same-index", "--out", "m.csv", "--json").out
    )
    assert found["numbers"]["precision_of_all"] == 1.0
    assert [row["time_s"] for row in found["matches"]][:3] == [0.0, 0.2, 0.4]


def test_blank_pictures_and_a_camera_that_stands_still_are_noted(run, walk: Path):
    still = np.concatenate([np.repeat(views(1), 6, axis=0), views(20)])
    write_pictures(walk / "still", still)
    assert "6 of 26 frames look just like the one before" in run("map", "build", "still", "a").out
    write_pictures(walk / "blank", np.full((20, 48, 96), 77, np.uint8))
    assert "20 of 20 frames have nothing to describe" in run("map", "build", "blank", "b").out
    done = run("map", "locate", "b", "winter", "--out", "m.csv")
    assert done.code == 0
    assert "more queries have no match" in done.out
    assert {row["reference"] for row in table(walk / "m.csv")} == {"-1"}


def test_other_thinning_with_same_index_is_noted(run, walk: Path):
    assert run("map", "build", "summer", "route").code == 0
    speeds = ("--slowest", "1.6", "--fastest", "2.4")
    done = run("map", "locate", "route", "winter", "--step", "2", *speeds, "--same-index", "--out", "m.csv")
    assert "thinned otherwise than the map?" in done.out


@NEEDS_POSIX
def test_a_killed_build_goes_on_where_it_was(walk: Path):
    slow = "\n".join([
        "import time, sys",
        "from pathlib import Path",
        "from insectnav.experiments.place_maps import build, describing",
        "build.BATCH = 4",
        "usual, n_described = describing.describe, 0",
        "def describe(*given):",
        "    global n_described",
        "    n_described += 1",
        "    if n_described == 20:",
        "        Path('held').touch()",
        "        time.sleep(600.0)",
        "    return usual(*given)",
        "describing.describe = describe",
        "sys.argv = ['insectnav', 'map', 'build', 'summer', 'route', '--workers', '1']",
        "from insectnav.cli import main",
        "main()",
    ])  # fmt: skip
    running = subprocess.Popen([sys.executable, "-c", slow], cwd=walk, start_new_session=True)
    until((walk / "held").exists)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    held = command(walk, "map", "info", "route", "--json")
    assert strict(held.out)["is_unfinished"]
    n_held = strict(held.out)["places"]
    assert 0 < n_held < 20
    assert_refused(command(walk, "map", "build", "summer", "route"), "interrupted, expected --add to go on")
    assert_refused(command(walk, "map", "build", "winter", "route", "--add"), "expected the same to go on with it")
    done = strict(command(walk, "map", "build", "summer", "route", "--add", "--json").out)
    assert (done["places"], done["routes"], done["frames_from_earlier_run"]) == (N_FRAMES, 1, n_held)
    command(walk, "map", "build", "summer", "whole")
    one, other = (PlaceMap.open(walk / name) for name in ("route", "whole"))
    assert_array_equal(one.descriptors, other.descriptors)
    assert one.names == other.names
    pictures = [find_thumbnails(walk / name, range(N_FRAMES)) for name in ("route", "whole")]
    assert pictures[0] == pictures[1]
    found = strict(command(walk, "map", "locate", "route", "winter", "--same-index", "--out", "m.csv", "--json").out)
    assert found["numbers"]["precision_of_all"] == 1.0


def test_positions_on_earth_have_one_origin(run, walk: Path):
    north = 1.0 / 111_132.0  # [°] of a metre near 45° north, to a part in a thousand

    def track(name: str, start: int) -> None:
        lines = [f"frame{k}.png,{45.0 + 5.0 * k * north:.9f},{7.0}" for k in range(start, N_FRAMES)]
        (walk / name).write_text("\n".join(["file,latitude,longitude", *lines]))

    track("summer.csv", 0)
    track("winter.csv", 10)  # its first position is 50 m north of the map's
    (walk / "metres.csv").write_text("file,x_m,y_m\nframe12.png,1,2\n")
    built = strict(run("map", "build", "summer", "m", "--positions", "summer.csv", "--json").out)
    assert built["origin_deg"] == [45.0, 7.0]
    options = ("--positions", "winter.csv", "--tolerance-m", "1")
    found = strict(run("map", "locate", "m", "winter", *options, "--out", "m.csv", "--json").out)
    assert (found["numbers"]["judged"], found["numbers"]["right"]) == (25, 25)
    assert found["matches"][20]["y"] == pytest.approx(100.0, abs=0.1)
    judged = strict(run("map", "evaluate", "m.csv", *options, "--map", "m", "--json").out)
    assert judged["numbers"]["right"] == 25
    assert_refused(run("map", "evaluate", "m.csv", *options), "expected --map for the origin")
    metres = ("--positions", "metres.csv", "--tolerance-m", "1")
    words = "--positions are x and y from an origin that is not known, but those of the map are latitudes"
    adding = ["build", "winter", "m", "--add", "--positions", "metres.csv"]
    for arguments in (["locate", "m", "winter", *metres], adding, ["evaluate", "m.csv", *metres, "--map", "m"]):
        assert_refused(run("map", *arguments), words)
    assert strict(run("map", "info", "m", "--json").out)["places"] == N_FRAMES
