"""The command as a user meets it, for the tests of what it does."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import psutil
import pytest

from insectnav import cli

PATIENCE = 300.0  # [s] after which what is waited for counts as never to come; a busy machine takes a tenth of it
NEEDS_POSIX = pytest.mark.skipif(os.name != "posix", reason="signals and terminals as POSIX has them")


class Outcome(NamedTuple):
    code: int
    out: str
    err: str


def command(folder: Path, *arguments: str) -> Outcome:
    """The real command in a process of its own, its output read by a program."""
    line = [sys.executable, "-m", "insectnav.cli", *arguments]
    done = subprocess.run(line, cwd=folder, capture_output=True, encoding="utf-8", timeout=PATIENCE, check=False)
    return Outcome(done.returncode, done.stdout, done.stderr)


def heed_interrupts() -> None:
    """For `preexec_fn`: Ctrl-C is ignored by what a shell runs in the background, and by all that this starts."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def in_process(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Outcome]:
    """The same in this process, which is faster; works in ``folder``."""
    monkeypatch.chdir(folder)

    def run(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["insectnav", *arguments])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            cli.main()
        return Outcome(ended.value.code, *capsys.readouterr())

    return run


def everything(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def table(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def strict(text: str) -> dict:
    """The one JSON object that a text is, without NaN."""

    def refuse(constant: str) -> None:
        raise ValueError(constant)

    value = json.loads(text, parse_constant=refuse)
    assert isinstance(value, dict)
    return value


def assert_refused(outcome: Outcome, words: str) -> str:
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("insectnav: ")
    assert outcome.err.find("\n") == len(outcome.err) - 1
    assert words in outcome.err
    assert "Traceback" not in outcome.err
    return outcome.err.removeprefix("insectnav: ").rstrip("\n")


def is_alive(process: psutil.Process) -> bool:
    """Whether it has not ended; where nobody takes notice of that, it is still known to the system."""
    with suppress(psutil.NoSuchProcess):
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    return False


def is_running(group: int) -> bool:
    """Whether a process of the group has not ended."""

    def is_of_it(process: psutil.Process) -> bool:
        with suppress(OSError):
            return os.getpgid(process.pid) == group
        return False

    return any(is_of_it(process) and is_alive(process) for process in psutil.process_iter())


def until(condition: Callable[[], object], seconds: float = PATIENCE) -> None:
    """Wait for what is to come; fails when it does not come at all."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "this takes too long"
        time.sleep(0.02)
