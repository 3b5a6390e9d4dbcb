"""What tests of several commands start from; those that need another place or state say so themselves."""

from pathlib import Path

import pytest

from command_line import in_process
from place_scenes import two_seasons


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    """Two folders of one route in two seasons."""
    return two_seasons(tmp_path)


@pytest.fixture
def run(walk: Path, monkeypatch, capsys):
    return in_process(walk, monkeypatch, capsys)
