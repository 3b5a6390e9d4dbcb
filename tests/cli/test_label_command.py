"""`insectnav label` as a user meets it."""

import os
import re
import signal
import subprocess
import sys
import urllib.request
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import (
    NEEDS_POSIX,
    PATIENCE,
    Outcome,
    assert_refused,
    everything,
    heed_interrupts,
    in_process,
    strict,
)
from insectnav.datasets.picture_files import write_picture
from labelling_scene import COLUMNS, ROWS, is_sky, leave, read, strokes


@pytest.fixture
def insectnav(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Outcome]:
    leave(tmp_path, "street.png")
    write_picture(tmp_path / "painted.png", strokes())
    return in_process(tmp_path, monkeypatch, capsys)


def test_strokes_become_a_mask(insectnav: Callable, tmp_path: Path):
    done = insectnav("label", "street.png", "--strokes", "painted.png", "--out", "sky.png", "--json")
    assert (done.code, done.err) == (0, "")
    assert strict(done.out) == {
        "masks": [
            {
                "image": "street.png",
                "mask": "sky.png",
                "sky_share": is_sky().mean(),
                "ground_share": (~is_sky()).mean(),
                "unreached_pixels": 0,
            }
        ]
    }
    np.testing.assert_array_equal(read(tmp_path / "sky.png") == 255, is_sky())


def test_mask_has_a_place_of_its_own_and_is_told_in_words(insectnav: Callable, tmp_path: Path):
    done = insectnav("label", "street.png", "--strokes", "painted.png")
    assert done.out == f"out/labels/street_mask.png: {100 * is_sky().mean():.1f} % sky\n"
    assert (tmp_path / "out" / "labels" / "street_mask.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("none.png",), "'none.png' is missing"),
        (("street.png", "--strokes", "none.png"), "'none.png' cannot be read"),
        (("street.png", "painted.png", "--strokes", "painted.png"), "expected one image, but 2 were named"),
        (("street.png", "--strokes", "street.png"), "'street.png' is not an 8-bit grey image"),
        (("street.png", "--strokes", "painted.png", "--out", "mask.jpg"), "is no name of a PNG"),
        (("street.png", "--strokes", "painted.png", "--out", ""), "--out is an empty name"),
        ((), "Missing argument"),
    ],
)
def test_bad_input_is_told_in_a_sentence(insectnav: Callable, tmp_path: Path, arguments: tuple, sentence: str):
    before = everything(tmp_path)
    assert_refused(insectnav("label", *arguments), sentence)
    assert everything(tmp_path) == before


@NEEDS_POSIX
def test_page_is_served_until_interrupted(tmp_path: Path):
    leave(tmp_path, "street.png")
    line = [sys.executable, "-m", "insectnav.cli", "label", "street.png", "--no-browser", "--json", "--out", "masks"]
    with subprocess.Popen(
        line, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts
    ) as program:
        url = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", program.stderr.readline())[0]
        labels = np.select([strokes() == 255, strokes() == 0], [2, 1], 0).astype(np.uint8)
        request = urllib.request.Request(f"{url}save/0", zlib.compress(labels.tobytes()))
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=PATIENCE) as answer:
            assert answer.status == 200
        os.kill(program.pid, signal.SIGINT)
        out, err = program.communicate(timeout=PATIENCE)
    assert (program.returncode, err) == (0, "")
    told = strict(out)
    assert (told["folder"], told["masks"][0]["strokes"]) == ("masks", os.path.join("masks", "street_strokes.png"))
    assert read(tmp_path / "masks" / "street_mask.png").shape == (ROWS, COLUMNS)
