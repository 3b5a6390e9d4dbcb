"""`insectnav render` as a user meets it: what it writes, what it refuses, and how it goes on after an interruption."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import Outcome, assert_refused, everything, in_process, strict
from insectnav.cli import render_options
from insectnav.cli.render_command import render_params
from insectnav.datasets.image_folder import read_image
from insectnav.experiments.rendering import job
from insectnav.experiments.rendering.frame_store import FrameStore
from insectnav.experiments.rendering.pictures import USUAL
from insectnav.vision import panorama
from insectnav.worlds import light_world, load_world, render, render_panorama
from insectnav.worlds.builders import build_world
from insectnav.worlds.sky import Sky

SMALL = ("--set", "radius=6", "--set", "clearing=2", "--set", "tree_density=0.05", "--seed", "3")
QUICK = ("--resolution", "15", "--supersampling", "2")
TINY = ("ant-world", *SMALL, *QUICK)
WALL = "usemtl brick\nv -3 5 0\nv 3 5 0\nv 3 5 4\nv -3 5 4\nf 1 2 3 4\n"
WALL += "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nusemtl sand\nf 5 6 7\n"


@pytest.fixture
def insectnav(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Outcome]:
    return in_process(tmp_path, monkeypatch, capsys)


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "frames.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def contents(folder: Path) -> dict[str, bytes]:
    """All that must be equal in equal runs."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "provenance.json"
    }


def test_one_picture(insectnav: Callable, tmp_path: Path):
    done = insectnav("render", *TINY, "--json")
    assert (done.code, done.err) == (0, "")
    told = strict(done.out)
    assert (told["frames"], told["size_px"], told["folder"]) == (1, [7, 24], "out/ant-world")
    folder = tmp_path / "out" / "ant-world"
    assert everything(folder) == ["contact_sheet.png", "frames.csv", "green", "green/000000.png", "provenance.json",
                                  "render.json", "sky_mask", "sky_mask/000000.png", "uv", "uv/000000.png", "visible",
                                  "visible/000000.png"]  # fmt: skip
    uv, visible = (read_image(folder / name / "000000.png") for name in ("uv", "visible"))
    mask = read_image(folder / "sky_mask" / "000000.png")
    assert (uv.shape, uv.dtype, visible.shape) == ((7, 24), np.uint8, (7, 24, 3))
    assert set(np.unique(mask)) == {0, 255}
    assert np.median(uv[mask == 255]) > 1.5 * np.median(uv[mask == 0])
    sky = visible[0].astype(int).mean(axis=0)
    assert sky[2] > sky[1] > sky[0]  # red, green, blue: a blue sky
    (row,) = table(folder)
    assert (row["x_m"], row["z_m"], row["weather"], row["light_utc"]) == (
        "0.0",
        "0.01",
        "clear",
        "2014-04-11T09:23:55Z",
    )
    assert float(row["sun_elevation_deg"]) == pytest.approx(39.9, abs=0.2)
    assert json.loads((folder / "render.json").read_text())["parameters"]["place"]["seed"] == 3


def test_radiance_is_that_of_the_renderer(insectnav: Callable, tmp_path: Path):
    options = ("--sun", "140,40", "--at", "0.5,-1,0.2", "--heading", "30", "--pitch", "10", "--roll", "-20")
    more = ("--bits", "32", "--format", "tiff", "--pictures", "uv,visible,sky_share,depth,sky_mask")
    assert insectnav("render", *TINY, *options, *more, "--out", "raw").code == 0
    sky = Sky(sun_azimuth=np.deg2rad(140.0), sun_elevation=np.deg2rad(40.0))
    world = light_world(build_world("ant-world", seed=3, radius=6.0, clearing=2.0, tree_density=0.05), sky)
    angles = np.deg2rad([[30.0], [10.0], [-20.0]])
    expected = render(world, [(0.5, -1.0, 0.2)], *angles, camera=panorama(15.0, (-15.0, 90.0)), supersampling=2,
                      layers=("uv", "red", "green", "blue", "sky", "depth"))  # fmt: skip
    found = {
        name: read_image(tmp_path / "raw" / name / "000000.tiff") for name in ("uv", "visible", "sky_share", "depth")
    }
    np.testing.assert_array_equal(found["uv"], expected["uv"][0])
    for band, name in enumerate(("red", "green", "blue")):
        np.testing.assert_array_equal(found["visible"][..., band], expected[name][0])
    np.testing.assert_array_equal(found["sky_share"], expected["sky"][0])
    np.testing.assert_array_equal(found["depth"], expected["depth"][0])
    mask = read_image(tmp_path / "raw" / "sky_mask" / "000000.png")
    np.testing.assert_array_equal(mask == 255, expected["sky"][0] >= 0.5)
    assert 0.0 < (mask == 255).mean() < 1.0


def test_flat_light_is_the_published_view(insectnav: Callable, tmp_path: Path):
    assert insectnav("render", *TINY, "--light", "flat", "--out", "flat").code == 0
    world = load_world("ant-world", seed=3, radius=6.0, clearing=2.0, tree_density=0.05)
    expected = render_panorama(world, [(0.0, -0.9)], [0.0], resolution_deg=15.0, supersampling=2)[0]
    np.testing.assert_array_equal(read_image(tmp_path / "flat" / "grey" / "000000.png"), np.rint(255 * expected))
    assert table(tmp_path / "flat")[0]["weather"] == ""


def test_table_of_a_traverse_gives_the_same_traverse_again(insectnav: Callable, tmp_path: Path):
    walk = (
        "--spacing",
        "0.4",
        "--yaw-jitter",
        "8",
        "--pitch-jitter",
        "5",
        "--roll-jitter",
        "5",
        "--lateral-jitter",
        "0.1",
    )
    light = ("--weather", "broken", "--refresh", "0.5", "--noise", "--flare")
    told = strict(insectnav("render", *TINY, *walk, *light, "--out", "first", "--json").out)
    assert told["frames"] == 5
    again = ("--positions", "first/frames.csv", *light)
    assert insectnav("render", *TINY, *again, "--out", "again").code == 0
    other = insectnav("render", *TINY, *walk, *light, "--jitter-seed", "1", "--workers", "1", "--out", "other")
    assert other.code == 0
    first, second, third = (contents(tmp_path / name) for name in ("first", "again", "other"))
    pictures = [name for name in first if name.endswith("0.png") or name.endswith(("1.png", "2.png", "3.png", "4.png"))]
    assert len(pictures) == 20
    assert all(first[name] == second[name] for name in pictures)
    assert first["frames.csv"] == second["frames.csv"]
    assert all(first[name] != third[name] for name in pictures if name.startswith("uv"))
    rows = table(tmp_path / "first")
    assert [row["frame"] for row in rows] == list("01234")
    assert len({row["roll_deg"] for row in rows}) == 5
    assert [row["light_utc"] for row in rows] == [f"2014-04-11T09:23:{s}Z" for s in (55, 55, 55, 55, 56)]
    assert len({row["white_uv"] for row in rows}) == 1


def test_each_frame_may_have_its_own_exposure(insectnav: Callable, tmp_path: Path):
    line = (
        "render",
        *TINY,
        "--frames",
        "3",
        "--exposure",
        "frame",
        "--bits",
        "16",
        "--response",
        "linear",
        "--out",
        "own",
    )
    assert insectnav(*line).code == 0
    rows = table(tmp_path / "own")
    assert len({row["white_uv"] for row in rows}) == 3
    picture = read_image(tmp_path / "own" / "uv" / "000001.png")
    assert picture.dtype == np.uint16
    assert picture.mean() / 65535 == pytest.approx(0.25, abs=0.001)  # which is what the meter is said to do
    assert insectnav("render", *TINY, "--exposure", "0.5", "--out", "set").code == 0
    assert table(tmp_path / "set")[0]["white_green"] == "0.5"


def test_interrupted_run_goes_on_to_the_same_bytes(
    insectnav: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    line = (
        "render",
        "suburban-street",
        "--set",
        "length=30",
        "--frames",
        "5",
        "--refresh",
        "6",
        "--time",
        "10:00",
        *QUICK,
    )
    assert insectnav(*line, "--out", "whole").code == 0
    monkeypatch.setattr(job, "VALUES_AT_ONCE", 1)  # a frame at a time
    write = FrameStore.write

    def stop_at_3(store: FrameStore, index: int, pictures: dict) -> None:
        if index == 3:
            raise KeyboardInterrupt
        write(store, index, pictures)

    monkeypatch.setattr(FrameStore, "write", stop_at_3)
    stopped = insectnav(*line, "--out", "parts")
    assert (stopped.code, stopped.out) == (130, "")
    assert stopped.err == "insectnav: interrupted, finished frames are kept: add --resume to go on\n"
    assert not (tmp_path / "parts").exists()
    monkeypatch.setattr(FrameStore, "write", write)
    with (tmp_path / ".parts.unfinished" / ".finished.jsonl").open("a") as journal:
        journal.write('{"frame": 3, "sky_sh')  # as a process that is killed leaves it
    (tmp_path / ".parts.unfinished" / "uv" / "000001.png").unlink()
    assert_refused(insectnav(*line, "--out", "parts"), "holds 3 frames of an unfinished run: add --resume")
    assert_refused(insectnav(*line, "--out", "parts", "--resume", "--weather", "overcast"),
                   "was rendered with parameters.light.weather 'clear', now 'overcast'")  # fmt: skip
    told = strict(insectnav(*line, "--out", "parts", "--resume", "--json").out)
    assert told["frames_from_earlier_run"] == 2
    assert contents(tmp_path / "parts") == contents(tmp_path / "whole")
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []
    before = contents(tmp_path / "parts")
    again = strict(insectnav(*line, "--out", "parts", "--resume", "--json").out)
    assert (again["frames_from_earlier_run"], again["seconds"]) == (5, 0.0)
    assert contents(tmp_path / "parts") == before


def test_interrupt_before_the_first_frame_leaves_nothing(
    insectnav: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(FrameStore, "write", stop)
    stopped = insectnav("render", *TINY)
    assert (stopped.code, stopped.err) == (130, "insectnav: interrupted, nothing written\n")
    assert everything(tmp_path / "out") == []


def test_finished_frames_are_replaced_only_when_asked(insectnav: Callable, tmp_path: Path):
    assert insectnav("render", *TINY).code == 0
    before = contents(tmp_path / "out" / "ant-world")
    assert_refused(
        insectnav("render", *TINY, "--time", "15:00"), "holds finished frames, expected another name, or --replace"
    )
    assert contents(tmp_path / "out" / "ant-world") == before
    assert insectnav("render", *TINY, "--time", "15:00", "--replace").code == 0
    assert contents(tmp_path / "out" / "ant-world") != before
    (tmp_path / "out" / "ant-world" / "mine.txt").touch()
    assert_refused(insectnav("render", *TINY, "--replace"), "holds other files, such as 'mine.txt'")


def test_mesh_file_in_daylight(insectnav: Callable, tmp_path: Path):
    (tmp_path / "wall.obj").write_text(WALL)
    line = (
        "render",
        "wall.obj",
        "--at",
        "0,0",
        "--camera",
        "pinhole",
        "--size",
        "8x6",
        "--pictures",
        "visible,material",
    )
    assert insectnav(*line, "--out", "wall", "--sun", "180,40").code == 0
    labels = json.loads((tmp_path / "wall" / "render.json").read_text())["material_labels"]
    material = read_image(tmp_path / "wall" / "material" / "000000.png")
    assert material[0, 4] == labels["brick"]  # straight ahead, to the north
    assert material.shape == (6, 8)
    red, _, blue = read_image(tmp_path / "wall" / "visible" / "000000.png")[0, 4]
    assert red > 1.1 * blue
    assert insectnav(*line, "--out", "leaf", "--material", "leaves").code == 0
    assert labels["leaves"] in read_image(tmp_path / "leaf" / "material" / "000000.png")
    assert_refused(insectnav("render", "wall.obj", "--spacing", "1"), "has no route to walk along")


def test_words_say_what_was_made_and_what_may_be_a_slip(insectnav: Callable):
    done = insectnav("render", *TINY, "--date", "2014-01-15", "--time", "12:00", "--out", "winter")
    assert done.out.startswith("ant-world: 1 frame of 24 × 7 pixels in ")
    assert "winter/frames.csv" in done.out
    assert "note: trees have all their leaves on 2014-01-15: --foliage 0 makes it winter" in done.out
    assert "leaves" not in insectnav("render", *TINY, "--time", "12:00", "--out", "spring").out


def test_help_tells_the_defaults_that_are(insectnav: Callable):
    """Each default that the help gives as a value changes nothing when it is given."""
    kinds = {render_options.NUMBER: float, render_options.COUNT: int, render_options.TEXT: str}
    nothing = dict.fromkeys(name[2:].replace("-", "_") for name, *_ in render_options.OPTIONS) | {"world": "city"}
    usual = render_params(nothing)
    told = 0
    for name, kind, _, shown, _ in render_options.OPTIONS:
        word = shown.split(",")[0] if name == "--latitude" else shown
        if (
            kind not in kinds
            or name == "--metres-per-unit"
            or not word
            or " " in word
            or name in ("--pictures", "--out", "--size", "--foliage")
        ):
            continue
        given = render_params(nothing | {name[2:].replace("-", "_"): kinds[kind](word)})
        assert given.camera.camera() == usual.camera.camera()
        assert given.camera.supersampling == usual.camera.supersampling
        if name not in ("--resolution", "--elevation"):
            assert given == usual, name
        told += 1
    assert told > 25
    assert ",".join(USUAL["sky"]) in insectnav("render", "--help").out.replace("\n", "").replace(" ", "")


BAD = {
    "render": "Missing argument",
    "render antworld": "did you mean ant-world?",
    "render nowhere.obj": "there is no such file",
    "render ant-world --camera fishey": "did you mean fisheye?",
    "render ant-world --size 4": "expected 2 numbers as in 640x480",
    "render ant-world --camera pinhole --size 4.5x3": "expected 2 numbers as in 640x480",
    "render ant-world --resolution 0.7": "expected to divide",
    "render ant-world --at 500,3": "frame 0 at (500, 3) m lies outside the world",
    "render ant-world --at 3": "expected 2 or 3 numbers as in 1,2",
    "render ant-world --at 0,0 --eye-height -1": "eye height is -1",
    "render suburban-street --at 16,108,1.3": "frame 0 at (16, 108, 1.3) m is inside a solid",
    "render ant-world --positions nowhere.csv": "no such file",
    "render ant-world --positions far.csv": "frame 1 at (900, 2) m lies outside the world",
    "render ant-world --positions epoch.csv": "seconds since 1970",
    "render ant-world --frames 1000000000": "expected 1 to 1e+06",
    "render ant-world --spacing 1e-6": "number of frames",
    "render ant-world --time 22:00": "the sun stands at",
    "render ant-world --set radius": "expected NAME=VALUE",
    "render ant-world --set radius=wide": "expected something like 40.0",
    "render ant-world --foliage 50": "in percent?",
    "render ant-world --pictures uv,ir": "picture 'ir' is unknown",
    "render ant-world --exposure much": "expected traverse, frame or a number",
    "render ant-world --workers 0": "workers is 0",
    "render ant-world --out=": "--out is an empty name",
    "render ant-world --out far.csv": "is a file",
    "render ant-world --sun 30,140": "azimuth comes first",
    "render ant-world --weather": "requires an argument",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_refused_in_one_sentence(line: str, insectnav: Callable, tmp_path: Path):
    (tmp_path / "far.csv").write_text("x_m,y_m\n1,2\n900,2\n")
    (tmp_path / "epoch.csv").write_text("x_m,y_m,time_s\n1,2,1400000000\n1,3,1400000001\n")
    before = everything(tmp_path)
    line = line.replace("render", "render --json", 1)
    assert_refused(insectnav(*line.split()), BAD[line.replace(" --json", "", 1)])
    assert everything(tmp_path) == before
