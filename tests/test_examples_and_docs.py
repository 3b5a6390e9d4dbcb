"""Examples run, and so does every Python block of the documentation."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
EXAMPLES = sorted((TOP / "examples").glob("*.py"))
PAGES = [page for page in [TOP / "README.md", *sorted((TOP / "docs").glob("*.md"))] if "```python" in page.read_text()]


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs_and_leaves_what_it_says(example: Path, tmp_path: Path):
    run = subprocess.run(
        [sys.executable, "-W", "error", example, tmp_path / "out"], cwd=tmp_path, capture_output=True, encoding="utf-8"
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout
    if "save_figure" in example.read_text():
        assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".png", ".pdf"}


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_python_on_a_page_runs(page: Path, tmp_path: Path):
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        run = subprocess.run([sys.executable, "-W", "error", "-c", block], cwd=tmp_path, capture_output=True, text=True)
        assert (run.returncode, run.stderr) == (0, "")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("page", sorted([*TOP.glob("*.md"), *(TOP / "docs").glob("*.md")]), ids=lambda path: path.name)
def test_links_on_a_page_lead_somewhere(page: Path):
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        if not target.startswith(("http://", "https://")):
            assert (page.parent / target).exists(), target
