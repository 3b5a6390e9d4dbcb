"""`insectnav list`, `run` and `report` as a user meets them."""

import html
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

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
from insectnav import cli, experiments
from insectnav.experiments import load, names
from made_results import leave, verdict
from track_files import assert_one_sentence

FINDINGS = [
    "caption.txt", "comparison.csv", "data.zarr", "figure.pdf", "figure.png", "provenance.json", "table.csv",
]  # fmt: skip
REAL = "stone2017-fig-5d"


@pytest.fixture
def insectnav(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Outcome]:
    """The command in this process, with the experiments of a small paper; works in ``tmp_path``."""
    monkeypatch.setattr(experiments, "_MODULES", {"needle": "needle_paper.needle", "drum": "needle_paper.drum"})
    return in_process(tmp_path, monkeypatch, capsys)


@pytest.fixture
def needle_alone(monkeypatch: pytest.MonkeyPatch, insectnav: Callable) -> None:
    monkeypatch.setattr(experiments, "_MODULES", {"needle": "needle_paper.needle"})


# List.


def test_list_aligns_what_json_tells(insectnav: Callable):
    said = insectnav("list")
    assert (said.code, said.err) == (0, "")
    assert said.out.splitlines() == [
        "needle  Buffon 1777  Fig. 1  π from needles < 1 & boards",
        "drum    Buffon 1777  Fig. 2  a drum that bursts",
    ]
    told = strict(insectnav("list", "--json").out)
    assert told["experiments"][1] == {
        "name": "drum", "paper": "Buffon 1777", "figure": "Fig. 2", "title": "a drum that bursts",
    }  # fmt: skip


@NEEDS_POSIX
def test_list_names_every_experiment_at_once(tmp_path: Path):
    """In half of the time of the processor that the libraries take to load which it leaves out."""
    from resource import RUSAGE_CHILDREN, getrusage

    def seconds(*line: str) -> tuple[float, subprocess.CompletedProcess]:
        before = getrusage(RUSAGE_CHILDREN)
        done = subprocess.run(
            [sys.executable, *line], cwd=tmp_path, capture_output=True, encoding="utf-8", timeout=PATIENCE, check=False
        )
        after = getrusage(RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done

    def is_quick() -> bool:
        taken, listed = seconds("-m", "insectnav.cli", "list")
        assert (listed.returncode, listed.stderr) == (0, "")
        assert [line.split()[0] for line in listed.stdout.splitlines()] == list(names())
        return taken < seconds("-c", "import numba, matplotlib.figure, xarray, zarr, scipy.stats")[0] / 2

    assert any(is_quick() for _ in range(5))  # other work on the machine lengthens the one or the other
    assert everything(tmp_path) == []


def test_list_loads_nothing_that_is_slow(tmp_path: Path):
    code = "import sys; from insectnav import cli; sys.argv = ['insectnav', 'list']\n"
    code += "try: cli.main()\nfinally: print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=False)
    loaded = set(done.stderr.split())
    assert "insectnav.experiments.published" in loaded
    assert not loaded & {"numba", "llvmlite", "matplotlib", "xarray", "zarr", "scipy", "pandas"}


# Run.


def test_run_leaves_findings_and_says_what_they_are(insectnav: Callable, tmp_path: Path):
    said = insectnav("run", "needle", "--workers", "1", "--seed", "5")
    assert (said.code, said.err) == (0, "")
    [folder] = (tmp_path / "out" / "needle").iterdir()
    assert sorted(path.name for path in folder.iterdir()) == FINDINGS
    first, second = said.out.splitlines()
    assert first.startswith("needle  ")
    assert first.endswith(f"  1 agrees, 1 differs, 1 not comparable  {folder.relative_to(tmp_path)}")
    assert second.startswith("  differs: π by law: published 3.2, ours 3.1")
    assert second.endswith(": no length of needle gives 3.2")


def test_run_tells_a_program_the_same(insectnav: Callable, tmp_path: Path):
    options = ("--workers", "1", "--scale", "full", "--out", "deep/results", "--json")
    done = insectnav("run", "needle", "needle", *options)  # named twice, run once
    assert (done.code, done.err) == (0, "")
    told = strict(done.out)
    assert told["report"] is None
    [result] = told["runs"]
    assert (result["experiment"], result["scale"], result["seed"], result["cells"]) == ("needle", "full", 0, 3)
    assert result["verdicts"] == {"agrees": 1, "differs": 1, "not comparable": 1}
    assert sorted(path.name for path in (tmp_path / result["folder"]).iterdir()) == FINDINGS
    law = {row["quantity"]: row for row in result["comparison"]}["π by law"]
    assert (law["published"], law["verdict"]) == (3.2, "differs")
    assert abs(law["ours"] - 3.14159265) < 4.0 * law["uncertainty"]
    again = strict(insectnav("run", "needle", *options, "--resume").out)["runs"]
    assert [(row["folder"], row["seconds"]) for row in again] == [(result["folder"], 0.0)]
    assert "was there already" in insectnav("run", "needle", *options[:-1], "--resume").out


def test_run_all_ends_with_the_report(insectnav: Callable, needle_alone: None, tmp_path: Path):
    said = insectnav("run", "--all", "--workers", "1", "--out", "results")
    assert (said.code, said.err) == (0, "")
    assert said.out.endswith(f"report: {Path('results') / 'report.html'}\n")
    assert "π by law" in (tmp_path / "results" / "report.html").read_text(encoding="utf-8")
    told = strict(insectnav("run", "--all", "--workers", "1", "--out", "results", "--resume", "--json").out)
    assert (len(told["runs"]), told["report"]) == (1, str(Path("results") / "report.html"))


def test_experiment_that_breaks_down_is_not_passed_over(
    insectnav: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(sys, "argv", ["insectnav", "run", "--all", "--workers", "1"])
    with pytest.raises(Exception, match="the drum has burst"):
        cli.main()
    assert len(list((tmp_path / "out" / "needle").iterdir())) == 1  # what was finished before stays
    assert not (tmp_path / "out" / "report.html").exists()


BAD = {
    "run": "no experiment is named, expected a name that insectnav list shows, or --all",
    "run needle --all": "both names of experiments and --all are given",
    "run nedle": "experiment 'nedle' is unknown: expected one of needle, drum (did you mean needle?)",
    "run needle nedle": "experiment 'nedle' is unknown",
    "run needle --scale ful": "scale 'ful' is unknown: expected one of quick, full (did you mean full?)",
    "run needle --seed -1": "seed is -1, expected a whole number of at least 0",
    "run needle --seed many": "--seed",
    "run needle --workers 0": "workers is 0, expected a whole number of at least 1",
    "run needle --workers 2 --cluster tcp://127.0.0.1:1": "both workers and cluster are given",
    "run needle --workers 1 --out file": "cannot be written",
    "run needle --workers 1 --out " + "a" * 300: "cannot be written",
    "run needle --out=": "--out is an empty name, expected a folder or '.': a variable that is not set?",
    "report --out=": "--out is an empty name, expected a folder or '.': a variable that is not set?",
    "report --out file": "--out 'file' is no folder",
    "report --out nowhere": "--out 'nowhere' is no folder, expected one that insectnav run wrote to",
    "report --out empty": "--out 'empty' holds no results, expected some: insectnav run NAME makes them",
    "report needle": "needle",
    "list needle": "needle",
}


@pytest.mark.parametrize("as_json", [False, True], ids=["words", "json"])
@pytest.mark.parametrize("line", BAD, ids=[line[:40] for line in BAD])
def test_bad_input_is_refused_in_one_sentence(line: str, as_json: bool, insectnav: Callable, tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "empty").mkdir()
    refused = insectnav(*line.split(), *["--json"][:as_json])
    sentence = assert_refused(refused, BAD[line])
    if "extra argument" not in sentence:  # which is how typer says it
        assert_one_sentence(sentence)
    assert everything(tmp_path) == ["empty", "file"]


def test_unfinished_run_is_not_lost(insectnav: Callable, needle_alone: None, tmp_path: Path, monkeypatch):
    def give_up(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr("needle_paper.needle.summarise", give_up)
        stopped = insectnav("run", "needle", "--workers", "1")
    assert stopped == (130, "", "insectnav: interrupted, finished cells are kept: add --resume to go on\n")
    assert_refused(insectnav("run", "needle", "--workers", "1"), "--resume")
    resumed = insectnav("run", "needle", "--workers", "1", "--resume")
    assert (resumed.code, resumed.err) == (0, "")
    assert len(everything(tmp_path / "out" / "needle")) > len(FINDINGS)


# Report.


def test_report_says_where_it_is_and_what_it_lacks(insectnav: Callable, tmp_path: Path):
    leave(tmp_path / "out", "needle", verdicts=[verdict(), verdict(quantity="size", verdict="differs", why="it grew")])
    (tmp_path / "out" / "drum" / "abc").mkdir(parents=True)
    said = insectnav("report")
    assert (said.code, said.err) == (0, "")
    page, note = said.out.splitlines()
    assert page == f"{Path('out') / 'report.html'}: 1 of 2 experiments, 1 agrees, 1 differs"
    assert note == f"note: {str(Path('drum') / 'abc')!r} is left out: provenance.json is missing"
    told = strict(insectnav("report", "--json").out)
    assert told["report"] == str(Path("out") / "report.html")
    assert (told["experiments"], told["not_run_yet"]) == (["needle"], ["drum"])
    assert told["verdicts"] == {"agrees": 1, "differs": 1, "not comparable": 0}
    assert len(told["notes"]) == 1


def test_commands_of_the_page_make_the_same_results(insectnav: Callable, needle_alone: None, tmp_path: Path):
    assert insectnav("run", "needle", "--workers", "1", "--seed", "12", "--out", "my results").code == 0
    page = Path(strict(insectnav("report", "--out", "my results", "--json").out)["report"]).read_text(encoding="utf-8")
    [line] = re.findall(r"<code>(<span>insectnav</span> .*?)</code>", page)
    program, *arguments = shlex.split(html.unescape(re.sub("<.*?>", "", line)))
    assert program == "insectnav"
    again = insectnav(*arguments, "--resume")
    assert (again.code, again.err) == (0, "")
    assert "was there already" in again.out


# The real command.


@pytest.mark.slow
def test_run_and_report_by_the_real_command(tmp_path: Path):
    done = command(tmp_path, "run", REAL, "--workers", "2", "--json")
    assert (done.code, done.err) == (0, "")
    [result] = strict(done.out)["runs"]
    assert sorted(path.name for path in (tmp_path / result["folder"]).iterdir()) == FINDINGS
    assert result["cells"] == len(load(REAL).grid("quick"))
    assert sum(result["verdicts"].values()) == len(result["comparison"]) > 0
    reported = command(tmp_path, "report")
    assert (reported.code, reported.err) == (0, "")
    assert reported.out.startswith(f"{Path('out') / 'report.html'}: 1 of {len(names())} experiments, ")
    assert REAL in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.fixture
def started(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen]]:
    """Starts the real command in a group of its own, as a terminal does; none outlives the test."""
    processes = []

    def start(*arguments: str, **options: object) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-m", "insectnav.cli", *arguments],
            cwd=tmp_path,
            start_new_session=True,
            preexec_fn=heed_interrupts,
            **options,
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        with process:  # which closes its pipes
            process.wait()


@NEEDS_POSIX
@pytest.mark.slow
def test_interrupted_run_keeps_what_is_finished(started: Callable, tmp_path: Path):
    arguments = ("run", REAL, "--scale", "full", "--workers", "2")
    process = started(*arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8")
    until(lambda: list(tmp_path.glob("out/*/.*.unfinished/finished/*")))
    assert process.poll() is None
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    until(lambda: not is_running(process.pid))
    assert (process.returncode, out) == (130, "")
    assert err == "insectnav: interrupted, finished cells are kept: add --resume to go on\n"
    assert list(tmp_path.glob("out/*/.*.unfinished/finished/*"))
    assert not list(tmp_path.glob("out/*/[!.]*"))


@NEEDS_POSIX
@pytest.mark.slow
def test_bar_names_the_experiment_and_counts_cells(started: Callable):
    import pty

    ours, theirs = pty.openpty()
    process = started(
        "run", REAL, "--workers", "1", "--json", stdout=subprocess.PIPE, stderr=theirs,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "100"},
    )  # fmt: skip
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # which is how the end is told
        while block := os.read(ours, 4096):
            shown += block
    os.close(ours)
    assert strict(process.communicate(timeout=PATIENCE)[0].decode())["runs"][0]["experiment"] == REAL
    assert process.returncode == 0
    assert f"{REAL} (1 of 1)".encode() in shown
    assert f"/{len(load(REAL).grid('quick'))}".encode() in shown
