"""The program where nobody listens: its output or its complaints are closed."""

import subprocess
import sys
from pathlib import Path

import pytest

from command_line import NEEDS_POSIX, PATIENCE, Outcome, assert_refused


def run_in_shell(folder: Path, line: str) -> Outcome:
    whole = f"{sys.executable} -m insectnav.cli {line}"
    done = subprocess.run(["sh", "-c", whole], cwd=folder, capture_output=True, encoding="utf-8", timeout=PATIENCE)
    return Outcome(done.returncode, done.stdout, done.stderr)


@NEEDS_POSIX
@pytest.mark.parametrize(("closed", "is_out"), [(">&-", False), ("2>&-", True), (">&- 2>&-", False)])
def test_what_is_closed_is_not_missed(closed: str, is_out: bool, tmp_path: Path):
    done = run_in_shell(tmp_path, f"--version {closed}")
    assert (done.code, bool(done.out), done.err) == (0, is_out, "")


@NEEDS_POSIX
def test_complaints_do_not_turn_up_in_the_output_where_their_own_place_is_closed(tmp_path: Path):
    refused = "run no-such-experiment"
    assert_refused(run_in_shell(tmp_path, refused), "no-such-experiment")
    assert run_in_shell(tmp_path, f"{refused} 2>&-") == (2, "", "")
