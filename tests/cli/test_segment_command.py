"""`insectnav segment` as a person meets it: a folder in, masks out; scores; what is skipped, refused, left behind."""

import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from command_line import (
    NEEDS_POSIX,
    PATIENCE,
    Outcome,
    assert_refused,
    command,
    everything,
    heed_interrupts,
    in_process,
    strict,
    table,
    until,
)
from insectnav.metrics.segmentation import accuracy, intersection_over_union, skyline_error
from sky_scenes import hills

SCENES = [hills(seed=k, noise=6.0 + 3.0 * k) for k in range(4)]


def write(path: Path, picture: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture[..., ::-1] if picture.ndim == 3 else picture)


def mask_picture(sky: np.ndarray) -> np.ndarray:
    return np.where(sky, 255, 0).astype(np.uint8)


def read(path: Path) -> np.ndarray:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    """A folder of four photographs, one of them grey, with their masks in another folder."""
    for k, scene in enumerate(SCENES):
        write(tmp_path / "walk" / f"view{k + 8}.png", scene.picture if k else scene.picture[..., 2].copy())
        drawn = np.roll(scene.sky, k, axis=0)  # by a person, a little too low
        write(tmp_path / "truth" / f"view{k + 8}_sky.png", mask_picture(drawn))
    return tmp_path


@pytest.fixture
def run(walk: Path, monkeypatch, capsys):
    return in_process(walk, monkeypatch, capsys)


def test_a_folder_in_masks_out_in_one_command(walk: Path):
    done = command(walk, "segment", "walk")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("4 pictures\n")
    out = walk / "out" / "segment-walk"
    rows = table(out / "table.csv")
    assert [row["image"] for row in rows] == ["view8", "view9", "view10", "view11"]
    assert [row["method"] for row in rows] == ["watershed", "skylight", "skylight", "skylight"]
    for row, scene in zip(rows, SCENES, strict=True):
        mask = read(out / "masks" / f"{row['image']}.png")
        assert set(np.unique(mask)) == {0, 255}
        assert ((mask == 255) == scene.sky).mean() > 0.97
        assert float(row["sky_fraction"]) == pytest.approx((mask == 255).mean(), abs=1e-5)
        assert 0.0 <= float(row["confidence"]) <= 1.0
        assert read(out / "overlays" / f"{row['image']}.jpg").shape == (*mask.shape, 3)


def test_scores_and_tests_are_those_of_the_masks_on_disk(run, walk: Path):
    done = run("segment", "walk", "--truth", "truth", "--method", "otsu", "--method", "trained", "--out", "r", "--json")
    assert (done.code, done.err) == (0, "")
    result = strict(done.out)
    assert result["images"] == 4
    for row in result["results"]:
        mask = read(walk / "r" / "masks" / row["method"] / f"{row['image']}.png") == 255
        truth = read(walk / "truth" / f"{row['image']}_sky.png") == 255
        assert row["accuracy"] == pytest.approx(accuracy(mask, truth))
        assert row["iou"] == pytest.approx(intersection_over_union(mask, truth))
        assert row["skyline_error_px"] == pytest.approx(skyline_error(mask, truth))
    own = [row["accuracy"] for row in result["results"] if row["method"] == "otsu"]
    assert result["methods"]["otsu"]["accuracy_mean"] == pytest.approx(np.mean(own))
    assert result["methods"]["otsu"]["accuracy_sd"] == pytest.approx(np.std(own, ddof=1))
    assert result["methods"]["otsu"]["accuracy_worst"] == min(own)
    assert {test["quantity"] for test in result["tests"]} == {"accuracy", "iou"}
    assert {path.name for path in (walk / "r").iterdir()} == {
        "masks", "overlays", "table.csv", "methods.csv", "tests.csv", "summary.json", "provenance.json"
    }  # fmt: skip
    assert run("segment", "walk", "--out", "r").code == 0  # results may be replaced
    assert not (walk / "r" / "tests.csv").exists()


def test_trained_threshold_of_a_picture_does_not_know_that_picture(run, walk: Path):
    before = strict(run("segment", "walk", "--truth", "truth", "--method", "trained:blue", "--json", "--out", "a").out)
    write(walk / "truth" / "view9_sky.png", mask_picture(~SCENES[1].sky))
    after = strict(run("segment", "walk", "--truth", "truth", "--method", "trained:blue", "--json", "--out", "b").out)
    first, second = ({row["image"]: row["threshold"] for row in one["results"]} for one in (before, after))
    assert first["view9"] == second["view9"]
    assert first["view10"] != second["view10"]


def test_what_cannot_be_used_is_named_and_the_rest_goes_on(run, walk: Path):
    data = (walk / "walk" / "view9.png").read_bytes()
    (walk / "walk" / "broken.png").write_bytes(data[: len(data) // 2])
    write(walk / "walk" / "dark.png", np.zeros((60, 80, 3), np.uint8))
    (walk / "walk" / "notes.txt").write_text("rain")
    write(walk / "walk" / "view9_sky.png", mask_picture(SCENES[1].sky))
    (walk / "walk" / "film.mp4").write_text("no film")
    done = run("segment", "walk")
    assert done.code == 0
    assert done.out.startswith("4 pictures\n")
    for words in (
        "broken: 'broken.png' ends before",
        "dark: all pixels",
        "notes.txt: no photograph",
        "film: 'film.mp4'",
    ):
        assert f"skipped {words}" in done.out
    assert "1 files that are masks" in done.out


def test_truth_of_another_size_is_named(run, walk: Path):
    write(walk / "truth" / "view10_sky.png", mask_picture(SCENES[2].sky[::2, ::2]))
    done = run("segment", "walk", "--truth", "truth")
    assert done.code == 0
    assert "skipped view10: the picture has 60 × 80 pixels and its truth 30 × 40" in done.out
    (walk / "truth" / "view9_sky.png").unlink()
    assert "1 pictures have no mask in --truth, such as view9" in run("segment", "walk", "--truth", "truth").out


def test_mask_and_view_leave_out_what_they_should(run, walk: Path):
    used = np.full((60, 80), 255, np.uint8)
    used[:, :20] = 0
    write(walk / "used.png", used)
    assert run("segment", "walk", "--mask", "used.png", "--out", "m").code == 0
    assert (read(walk / "m" / "masks" / "view9.png")[:, :20] == 128).all()
    assert run("segment", "walk", "--view", "up", "--radius", "20", "--method", "otsu", "--out", "u").code == 0
    assert ((read(walk / "u" / "masks" / "view9.png") != 128).sum() / (np.pi * 400)) == pytest.approx(1, rel=0.02)


def test_video_is_segmented_and_smoothed(run, walk: Path):
    writer = cv2.VideoWriter(str(walk / "film.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (80, 64))
    scene = hills(64, 80)
    for k in range(6):
        frame = scene.picture.copy()
        frame[5:15, 30:40] = (80, 70, 50) if k == 4 else frame[5:15, 30:40]  # a bird
        writer.write(frame[..., ::-1])
    writer.release()
    assert run("segment", "film.avi", "--step", "2", "--out", "two").code == 0
    assert [row["image"] for row in table(walk / "two" / "table.csv")] == [f"film_{k:06d}" for k in (0, 2, 4)]
    assert (read(walk / "two" / "masks" / "film_000004.png")[7:13, 32:38] == 0).all()
    assert run("segment", "film.avi", "--smooth", "3", "--out", "smooth").code == 0
    assert (read(walk / "smooth" / "masks" / "film_000004.png")[7:13, 32:38] == 255).all()


def test_same_names_do_not_overwrite_each_other(run, walk: Path):
    write(walk / "other" / "view9.png", SCENES[3].picture)
    assert run("segment", "walk/view9.png", "other/view9.png", "--out", "both").code == 0
    assert sorted(path.name for path in (walk / "both" / "masks").iterdir()) == ["view9-1.png", "view9-2.png"]


def test_deep_pictures_have_masks_as_bytes_have(run, walk: Path):
    write(walk / "deep" / "view9.tif", SCENES[1].picture.astype(np.uint16) * 200)
    run("segment", "deep", "--out", "deep-out")
    run("segment", "walk/view9.png", "--out", "out9")
    one, other = read(walk / "deep-out" / "masks" / "view9.png"), read(walk / "out9" / "masks" / "view9.png")
    assert (one != other).mean() < 0.001


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (["nowhere"], "does not exist"),
        (["truth", "--method", "best"], "method 'best' is unknown"),
        (["walk", "--method", "otsu:rgb"], "more than one"),
        (["walk", "--method", "otsu:pink"], "channels 'pink' is unknown"),
        (["walk", "--method", "otsu", "--method", "otsu"], "given twice"),
        (["walk", "--method", "fixed"], "--threshold"),
        (["walk", "--threshold", "3"], "--threshold"),
        (["walk", "--method", "trained"], "--truth"),
        (["walk", "--truth", "nowhere"], "is no folder"),
        (["walk", "--truth", "walk"], "is in colour"),
        (["walk", "--view", "down"], "view 'down' is unknown"),
        (["walk", "--radius", "3"], "--radius"),
        (["walk", "--smooth", "0"], "smooth is 0"),
        (["walk", "--mask", "walk/view9.png"], "is in colour"),
        (["walk", "--out", "walk"], "holds other files"),
        (["walk", "--out", ""], "--out is an empty name"),
        (["empty"], "no photograph"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_sentence(run, walk: Path, line: list[str], words: str):
    (walk / "empty").mkdir()
    if "walk" in line[line.index("--truth") + 1 :] if "--truth" in line else False:
        for scene, name in zip(SCENES, ("view8", "view9", "view10", "view11"), strict=True):
            write(walk / "walk" / f"{name}_sky.png", scene.picture)
    before = everything(walk)
    assert_refused(run("segment", *line), words)
    assert everything(walk) == before


def test_hand_made_masks_are_not_replaced(run, walk: Path):
    write(walk / "mine" / "masks" / "view9.png", mask_picture(SCENES[1].sky))
    assert_refused(run("segment", "walk", "--out", "mine"), "holds other files, such as 'masks'")
    assert_array_equal(read(walk / "mine" / "masks" / "view9.png"), mask_picture(SCENES[1].sky))


@NEEDS_POSIX
@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_killed_run_leaves_nothing_that_looks_finished(walk: Path, how: signal.Signals):
    for k in range(12):
        write(walk / "long" / f"{k}.png", SCENES[1].picture)
    held = "\n".join([
        "import sys, time",
        "from insectnav import cli",
        "from insectnav.experiments import segment_images",
        "usual = segment_images._smoothed",
        "def smoothed(attempts, n_frames):",
        "    for k, attempt in enumerate(usual(attempts, n_frames)):",
        "        if k == 8:",
        "            time.sleep(600.0)",
        "        yield attempt",
        "segment_images._smoothed = smoothed",
        "sys.argv = ['insectnav', 'segment', 'long', '--method', 'kmeans']",
        "cli.program()",
    ])  # fmt: skip
    process = subprocess.Popen(
        [sys.executable, "-c", held], cwd=walk, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=heed_interrupts,
    )  # fmt: skip
    until(lambda: list(walk.glob("out/.segment-long.*.part/masks/*.png")))
    process.send_signal(how)
    process.communicate(timeout=PATIENCE)
    assert not (walk / "out" / "segment-long").exists()
    if how != signal.SIGKILL:
        assert not (walk / "out").exists()


def test_help_names_all_methods(run):
    done: Outcome = run("segment", "--help")
    assert done.code == 0
    for word in ("otsu", "watershed-islands", "skylight", "--truth", "--smooth"):
        assert word in done.out
