"""Examples run, and so does every Python block of the documentation.

They run one after the other in the process of the tests, which has loaded its libraries; a few run as a user starts
them, each in an interpreter of its own.
"""

import os
import re
import runpy
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import matplotlib
import numpy as np
import pytest

TOP = Path(__file__).parents[1]
EXAMPLES = sorted((TOP / "examples").glob("*.py"))
PAGES = [page for page in [TOP / "README.md", *sorted((TOP / "docs").glob("*.md"))] if "```python" in page.read_text()]
AS_COMMANDS = ("own_experiment", "step_by_step", "README")  # stems: an experiment that is `__main__`, and first steps


@contextmanager
def state_put_back() -> Iterator[None]:
    """Leave no trace of a program in the process: settings, environment, imports' path, random numbers, warnings."""
    path, random_state = list(sys.path), np.random.get_state()
    with warnings.catch_warnings(), matplotlib.rc_context(), mock.patch.dict(os.environ):
        warnings.simplefilter("error")
        try:
            yield
        finally:
            sys.path[:] = path
            np.random.set_state(random_state)


def run_here(script: Path, *arguments: str) -> None:
    """Run a program in this process, as ``python -W error script`` does in its own; whatever it raises is raised."""
    with state_put_back(), mock.patch.object(sys, "argv", [str(script), *arguments]):
        try:
            runpy.run_path(str(script), run_name="__main__")
        except SystemExit as end:
            assert not end.code, end.code


def run_as_command(script: Path, *arguments: str) -> None:
    """Run a program in an interpreter of its own, which inherits the standard output and error."""
    subprocess.run([sys.executable, "-W", "error", script, *arguments], check=True)


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs_and_leaves_what_it_says(
    example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    run = run_as_command if example.stem in AS_COMMANDS else run_here
    run(example, str(tmp_path / "out"))
    output, complaint = capfd.readouterr()
    assert complaint == ""
    assert output
    if "save_figure" in example.read_text():
        assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".png", ".pdf"}


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_python_on_a_page_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    folder, script = tmp_path / "here", tmp_path / "block.py"
    folder.mkdir()
    monkeypatch.chdir(folder)
    run = run_as_command if page.stem in AS_COMMANDS else run_here
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        script.write_text(block, encoding="utf-8")
        run(script)
        assert capfd.readouterr().err == ""
    assert os.listdir(folder) == []


@pytest.mark.parametrize("page", sorted([*TOP.glob("*.md"), *(TOP / "docs").glob("*.md")]), ids=lambda path: path.name)
def test_links_on_a_page_lead_somewhere(page: Path):
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        if not target.startswith(("http://", "https://")):
            assert (page.parent / target).exists(), target
