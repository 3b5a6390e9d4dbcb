"""The command as a user meets it: what it prints and writes, what it refuses, and what it leaves when interrupted."""

import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
import xarray

from command_line import (
    NEEDS_POSIX,
    PATIENCE,
    Outcome,
    assert_refused,
    command,
    everything,
    heed_interrupts,
    in_process,
    is_running,
    strict,
    until,
)
from insectnav import __version__
from insectnav.central_complex import PRESETS, VARIANTS
from track_files import assert_one_sentence, changed, headed, rows, table

DATA = Path(os.environ.get("INSECTNAV_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
FILES = ["data.zarr", "figure.pdf", "figure.png", "provenance.json", "summary.json", "table.csv"]
QUICK = ("--trials", "3", "--homing-steps", "150")
ANTS = ["trackball_00", "trackball_07", "trackball_21"]
ANTS += ["velox_ant01_route01", "velox_ant04_route14", "velox_ant12_route04"]
NEST = (5.0, -3.0)
HEADINGS = np.linspace(0.4, 1.6, 80)  # [rad] clockwise from +y, of the walk below


@pytest.fixture
def insectnav(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Outcome]:
    """The command in this process, which is faster; works in ``tmp_path``."""
    return in_process(tmp_path, monkeypatch, capsys)


@pytest.fixture
def without_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    """No figure is drawn, which saves a second."""
    monkeypatch.setattr("insectnav.experiments.home.FigureProcess", lambda *_: nullcontext(MagicMock()))


def walk(length_unit: str = "m", scale: float = 1.0, headings: str = "", values: np.ndarray | None = None) -> str:
    """A table of a walk that bends to the right, 80 samples of 0.2 m, perhaps with a column of headings."""
    moves = 0.2 * np.stack([np.sin(HEADINGS), np.cos(HEADINGS)], axis=-1)
    position = scale * (np.array(NEST) + np.cumsum(moves, axis=0) - moves[0])
    cells = [[f"{0.1 * i:.1f}", *map(repr, xy)] for i, xy in enumerate(position.tolist())]
    header = f"t_s,x_{length_unit},y_{length_unit}"
    if values is not None:
        cells, header = [[*row, f"{v:.9f}"] for row, v in zip(cells, values, strict=True)], f"{header},{headings}"
    return table(cells, header)


# Help.


def test_help_and_version(tmp_path: Path):
    helped = command(tmp_path, "--help")
    assert (helped.code, helped.err) == (0, "")
    assert "  home " in helped.out
    assert command(tmp_path, "--version") == (0, f"{__version__}\n", "")
    assert everything(tmp_path) == []


def test_help_names_every_option_and_choice(insectnav: Callable):
    helped = insectnav("home", "--help")
    options = "preset variant noise trials homing-steps seed reverse steps-per-unit heading-convention out json"
    for name in options.split():
        assert f"--{name} " in helped.out
    for choice in (*PRESETS, *VARIANTS, "compass", "math", "TRACK"):
        assert choice in helped.out
    assert (helped.code, helped.err) == (0, "")
    assert insectnav().out.split() == insectnav("--help").out.split()  # nothing asked gets the help


def test_help_loads_nothing_that_is_slow(tmp_path: Path):
    code = "import sys; from insectnav import cli; sys.argv = ['insectnav', '--help']\n"
    code += "try: cli.main()\nfinally: print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=False)
    loaded = set(done.stderr.split())
    assert "insectnav.cli" in loaded
    assert not loaded & {"numba", "llvmlite", "matplotlib", "xarray", "zarr", "scipy", "pandas"}


# Home.


def test_random_trip_as_json(tmp_path: Path):
    done = command(tmp_path, "home", "--json", "--trials", "3", "--homing-steps", "40")
    assert (done.code, done.err) == (0, "")
    told = strict(done.out)
    assert told["folder"] == str(Path("out") / "random-trip")
    assert told["scale"]["outbound_steps"] == 1500
    assert sorted(path.name for path in (tmp_path / "out" / "random-trip").iterdir()) == FILES


def test_track_as_json(tmp_path: Path):
    (tmp_path / "walk.csv").write_text(walk("cm", 100.0))
    done = command(tmp_path, "home", "walk.csv", "--json", *QUICK)
    assert (done.code, done.err) == (0, "")
    told = strict(done.out)
    assert sorted(path.name for path in (tmp_path / "out" / "walk").iterdir()) == FILES
    assert set(told) == {"name", "track", "scale", "heading", "settings", "results", "notes", "folder"}
    assert (told["name"], told["folder"], told["heading"]) == ("walk", "out/walk", "direction of motion")
    assert (told["scale"]["length_unit"], told["scale"]["homing_steps"]) == ("cm", 150)
    assert told["scale"]["steps_per_length_unit"] == pytest.approx(0.85 / 20.0, rel=1e-3)
    assert told["track"]["samples"] == 80
    moves = 20.0 * np.array([np.sin(HEADINGS[1:]).sum(), np.cos(HEADINGS[1:]).sum()])
    results = told["results"]
    assert results["distance_of_turning_point"]["mean"] == pytest.approx(np.hypot(*moves))
    assert results["closest_distance"]["unit"] == "cm"
    assert results["closest_distance"]["n"] == 3
    assert {"median", "sd", "p90"} < set(results["decoded_bearing_error"])
    assert 0.0 < results["straightness"]["mean"] <= 1.0
    assert strict((tmp_path / "out" / "walk" / "summary.json").read_text(encoding="utf-8")) == {
        key: value for key, value in told.items() if key != "folder"
    }


def test_words_say_what_json_says(insectnav: Callable, tmp_path: Path):
    (tmp_path / "walk.csv").write_text(walk())
    (tmp_path / "deep" / "result").mkdir(parents=True)
    (tmp_path / "deep" / "result" / "provenance.json").write_text("{}")  # earlier results, to be replaced
    said = insectnav("home", "walk.csv", *QUICK, "--out", "deep/result")
    assert (said.code, said.err) == (0, "")
    assert sorted(path.name for path in (tmp_path / "deep" / "result").iterdir()) == FILES
    results = strict((tmp_path / "deep" / "result" / "summary.json").read_text(encoding="utf-8"))["results"]
    assert f"median {results['closest_distance']['median']:.3g}" in said.out
    assert f"{results['distance_of_turning_point']['mean']:.4g} m from the nest" in said.out
    assert f"{results['decoded_bearing_error_absolute']['mean']:.3g}° off" in said.out
    assert "heading: direction of motion" in said.out
    assert "note: no heading column" in said.out
    assert said.out.endswith("deep/result\n")
    assert "nan" not in said.out


def test_reverse_starts_at_the_other_end(insectnav: Callable, without_figure: None, tmp_path: Path):
    (tmp_path / "walk.csv").write_text(walk())
    told = strict(insectnav("home", "walk.csv", "--reverse", "--json", "--noise", "0", *QUICK).out)
    with xarray.open_zarr(tmp_path / told["folder"] / "data.zarr", consolidated=False) as data:
        np.testing.assert_allclose(data.position[:, 79], np.tile(NEST, (3, 1)), atol=1e-3)
        # The first move of the track is its last one flown backwards.
        assert math.cos(float(data.heading[0, 0]) - HEADINGS[-1]) < -0.99
    assert any("backwards" in note for note in told["notes"])


def test_headings_in_any_convention_are_the_same_walk(insectnav: Callable, without_figure: None, tmp_path: Path):
    body = HEADINGS + 0.5  # it looks to the right of where it goes
    tables = {
        "rad": (walk(headings="heading_rad", values=body), ()),
        "deg": (walk(headings="heading_deg", values=np.rad2deg(body)), ()),
        "math": (walk(headings="heading_deg", values=90.0 - np.rad2deg(body)), ("--heading-convention", "math")),
        "wrong": (walk(headings="heading_deg", values=90.0 - np.rad2deg(body)), ()),
    }
    heading = {}
    for name, (text, options) in tables.items():
        (tmp_path / f"{name}.csv").write_text(text)
        told = strict(insectnav("home", f"{name}.csv", "--json", "--noise", "0", *QUICK, *options).out)
        assert told["heading"] == "recorded"
        assert told["notes"] == []
        with xarray.open_zarr(tmp_path / told["folder"] / "data.zarr", consolidated=False) as data:
            heading[name] = data.heading.values[0, :80]
    for name in ("rad", "deg", "math"):
        np.testing.assert_allclose(heading[name], body, atol=1e-5)
    assert np.abs(heading["wrong"] - body).max() > 0.5


def test_steps_per_unit_and_gaps_are_reported(insectnav: Callable, without_figure: None, tmp_path: Path):
    lines = walk().splitlines()
    lines[20:23] = [f"{line.split(',')[0]},," for line in lines[20:23]]  # three missing positions
    (tmp_path / "walk.csv").write_text("\n".join(lines))
    told = strict(insectnav("home", "walk.csv", "--json", "--steps-per-unit", "2.5", *QUICK).out)
    assert told["scale"]["steps_per_length_unit"] == 2.5
    assert told["scale"]["time_per_step"] == pytest.approx(0.1 * 0.85 / (0.2 * 2.5), rel=0.02)
    assert told["scale"]["search_radius"] == 8.0
    assert told["track"]["samples_interpolated"] == 3


# Bad input.


def write_bad_tracks(folder: Path) -> None:
    (folder / "walk.csv").write_text(walk())
    (folder / "folder").mkdir()
    (folder / "foreign").mkdir()
    (folder / "foreign" / "thesis.txt").write_text("mine")
    tracks = {
        "image": "PNG\0", "empty": "", "columns": "a,b,c\n1,2,3\n",
        "text": changed(7, 1, "abc"), "back": changed(7, 0, "0.1"),
        "pause": table([[f"{float(t) * 10 + 1.05 * (i > 5):.2f}", x, y] for i, (t, x, y) in enumerate(rows())]),
        "lost": table([[t, "" if 4 < i < 30 else x, y] for i, (t, x, y) in enumerate(rows(60, 0.04))]),
        "frames": table([[str(i + 21 * (i > 5)), x, y] for i, (_, x, y) in enumerate(rows())], "frame,x,y"),
        "short": table(rows(9)), "still": table([[t, "1", "1"] for t, _, _ in rows()]),
        "degrees": headed(["0", "357", *["1"] * 10], "heading_rad"),
        "rests": table([[f"{i}", str(min(i, 2)), "0"] for i in range(100)], "frame,x_m,y_m"),
    }  # fmt: skip
    for name, content in tracks.items():
        (folder / f"{name}.csv").write_text(content)


BAD = [
    ("nowhere.csv", "'nowhere.csv': no such file"),
    ("", "folder"),
    ("folder", "'folder': this is a folder, expected a CSV or TSV file"),
    ("image.csv", "not text"),
    ("empty.csv", "the file is empty"),
    ("columns.csv", "no column for time and x and y among 'a', 'b', 'c'"),
    ("text.csv", "row 7, column 'x_m': 'abc' is not a number"),
    ("pause.csv", "gap of 2.05 s before row 8, at most 1 s is filled: raise --max-gap"),
    ("lost.csv", "gap of 1.04 s before row 32"),
    ("frames.csv", "gap of 22 samples (22 frames) before row 8, at most 20 samples are filled: raise --max-gap-s"),
    ("back.csv", "row 7, column 't_s': the time goes from 0.4 to 0.1, expected it to increase"),
    ("short.csv", "9 of 9 rows hold a position, expected at least 10"),
    ("still.csv", "the animal does not move"),
    ("rests.csv", "stands still in more than 95 %"),
    ("degrees.csv", "'heading_rad' reaches 357, expected radians within ±2π: degrees?"),
    ("walk.csv --preset thesiss", "'thesiss' is unknown: expected one of thesis, code-2017"),
    ("walk.csv --variant ideal", f"'ideal' is unknown: expected one of {', '.join(VARIANTS)}"),
    ("walk.csv --heading-convention maths", "'maths' is unknown: expected one of compass, math"),
    ("--preset thesiss", "'thesiss' is unknown: expected one of thesis, code-2017"),
    ("--heading-convention maths", "'maths' is unknown: expected one of compass, math"),
    ("--max-gap -3", "gap"),
    ("--reverse", "--reverse"),
    ("walk.csv --noise -1", "noise is -1, expected 0 to 10"),
    ("walk.csv --trials 0", "trials is 0, expected a whole number of at least 1"),
    ("walk.csv --trials 1000000000000000", "trials"),
    ("walk.csv --homing-steps 0", "homing steps is 0, expected"),
    ("walk.csv --homing-steps 1000000000000000", "homing"),
    ("walk.csv --seed -1", "seed is -1, expected a whole number of at least 0"),
    ("walk.csv --steps-per-unit 0", "is 0, expected"),
    ("walk.csv --steps-per-unit 1e9", "more than 1000000 steps, expected fewer: lower --steps-per-unit"),
    ("walk.csv --steps-per-unit 1e-9", "a single step, expected more: raise --steps-per-unit"),
    ("walk.csv --max-gap -1", "is -1, expected at least 0 s"),
    ("walk.csv --out walk.csv", "--out 'walk.csv' is a file"),
    ("walk.csv --out foreign", "--out 'foreign' holds other files"),
    ("walk.csv --out walk.csv/below", "--out 'walk.csv/below' cannot be written"),
    ("walk.csv --out " + "a" * 300, "cannot be written"),
]
SLIPS = {
    "--trials": "home walk.csv --trials ten", "--tirals": "home walk.csv --tirals 3", "--out": "home walk.csv --out",
    "second.csv": "home walk.csv second.csv", "hme": "hme",
}  # fmt: skip


@pytest.mark.parametrize("options", [(), ("--json",)], ids=["words", "json"])
@pytest.mark.parametrize(("line", "words"), BAD, ids=[line[:40] or "nothing" for line, _ in BAD])
def test_bad_input_is_refused_in_one_sentence(
    line: str, words: str, options: tuple, insectnav: Callable, without_figure: None, tmp_path: Path
):
    write_bad_tracks(tmp_path)
    before = everything(tmp_path)
    outcome = insectnav("home", *(line.split() or [""]), *options)
    assert_one_sentence(assert_refused(outcome, words))
    assert everything(tmp_path) == before


@pytest.mark.parametrize(("words", "line"), SLIPS.items())
def test_slip_on_the_command_line_is_named(line: str, words: str, insectnav: Callable, tmp_path: Path):
    assert_refused(insectnav(*line.split()), words)
    assert everything(tmp_path) == []


def test_refusal_by_the_real_command(tmp_path: Path):
    write_bad_tracks(tmp_path)
    before = everything(tmp_path)
    assert_refused(command(tmp_path, "home", "text.csv", "--json"), "row 7")
    assert_refused(command(tmp_path, "home", "walk.csv", "--variant", "x", "--out", "new"), ", ".join(VARIANTS))
    assert everything(tmp_path) == before


# Interrupted, watched.


LOSE = """
import ctypes, os, signal, sys, time
from insectnav import cli
from insectnav.cli import commands

@ctypes.CFUNCTYPE(None)  # as compilers call Python: errors of it are told to nobody
def called_back():
    os.kill(os.getpid(), signal.{sent})
    for _ in range(1000):
        pass

class Half:
    def __init__(self):
        called_back()
        time.sleep(600.0)
        self.whole = True

    def __del__(self):
        print(self.whole)  # and complain that it is not

commands.app = lambda **_: Half()
sys.argv = ["insectnav", "list"]
cli.program()
"""
SAID = {"SIGINT": (130, "", "insectnav: interrupted, nothing written\n"), "SIGTERM": (143, "", "")}


@NEEDS_POSIX
@pytest.mark.parametrize("sent", SAID)
def test_interrupt_is_not_lost_while_a_library_calls_back(sent: str):
    line = [sys.executable, "-c", LOSE.format(sent=sent)]
    done = subprocess.run(
        line, capture_output=True, encoding="utf-8", timeout=PATIENCE, check=False, preexec_fn=heed_interrupts
    )
    assert (done.returncode, done.stdout, done.stderr) == SAID[sent]


@NEEDS_POSIX
def test_interrupt_before_anything_has_begun_is_told_in_a_sentence():
    code = "import os, signal, sys\nfrom insectnav import cli\n"
    code += "cli.main = lambda *_: os.kill(os.getpid(), signal.SIGINT)\nsys.argv = ['insectnav', 'list']\ncli.program()"
    line = [sys.executable, "-c", code]
    done = subprocess.run(
        line, capture_output=True, encoding="utf-8", timeout=PATIENCE, check=False, preexec_fn=heed_interrupts
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "insectnav: interrupted\n")


@NEEDS_POSIX
@pytest.mark.parametrize("options", [(), ("--out", "result")])
@pytest.mark.parametrize(("kill", "sent"), [(os.kill, "SIGINT"), (os.killpg, "SIGINT"), (os.kill, "SIGTERM")])
def test_interrupt_leaves_nothing_behind(kill: Callable, sent: str, options: tuple, tmp_path: Path):
    (tmp_path / "walk.csv").write_text(walk())
    line = [sys.executable, "-m", "insectnav.cli", "home", "walk.csv", "--trials", "600", "--homing-steps", "100000"]
    process = subprocess.Popen(
        [*line, *options], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
        start_new_session=True,
        preexec_fn=heed_interrupts,
    )  # fmt: skip
    try:
        until(lambda: [*tmp_path.glob(".*.part"), *tmp_path.glob("out/.*.part")])
        assert process.poll() is None
        kill(process.pid, getattr(signal, sent))
        out, err = process.communicate(timeout=PATIENCE)
        until(lambda: not is_running(process.pid))
    finally:
        if is_running(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
    assert (process.returncode, out, err) == SAID[sent]
    assert everything(tmp_path) == ["walk.csv"]


@NEEDS_POSIX
def test_bar_is_shown_on_a_terminal_alone(tmp_path: Path):
    import pty

    (tmp_path / "walk.csv").write_text(walk())
    ours, theirs = pty.openpty()
    line = [sys.executable, "-m", "insectnav.cli", "home", "walk.csv", "--json", *QUICK]
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    process = subprocess.Popen(line, cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs, env=environment)
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # which is how the end is told
        while block := os.read(ours, 4096):
            shown += block
    os.close(ours)
    assert strict(process.communicate(timeout=PATIENCE)[0].decode())["settings"]["trials"] == 3
    assert process.returncode == 0
    assert b"ways home" in shown


# Tracks of real animals.


@pytest.mark.data
@pytest.mark.skipif(not (DATA / "tracks").is_dir(), reason=f"no folder {DATA / 'tracks'}")
@pytest.mark.parametrize("name", ANTS)
def test_recorded_ants_find_home(name: str, insectnav: Callable, tmp_path: Path):
    done = insectnav("home", str(DATA / "tracks" / f"{name}.csv"), "--json", "--trials", "10")
    assert (done.code, done.err) == (0, "")
    told = strict(done.out)
    assert sorted(path.name for path in (tmp_path / "out" / name).iterdir()) == FILES
    assert told["scale"]["length_unit"] == "m"
    results = told["results"]
    assert all(math.isfinite(row["mean"]) for row in results.values())
    assert results["closest_distance"]["median"] < told["scale"]["search_radius"]
    assert results["decoded_bearing_error_absolute"]["median"] < 30.0
    assert not any("saturated" in note for note in told["notes"])
