"""`insectnav align` as a user meets it."""

import csv
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from command_line import Outcome, assert_refused, everything, in_process, strict

pytest.importorskip("SimpleITK")
ROWS, COLUMNS, SHIFT = 108, 144, (4, -3)  # columns, rows


@pytest.fixture
def insectnav(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Outcome]:
    """A green picture, one in ultraviolet with other brightness, moved, and one of something else."""
    rng = np.random.default_rng(0)
    tiles = np.kron(rng.random((12, 16)), np.ones((9, 9)))
    green = np.rint(65535 * tiles).astype(np.uint16)
    ultraviolet = np.rint(16383 * (1.0 - np.roll(tiles, SHIFT[::-1], (0, 1)) ** 2)).astype(np.uint16)
    nothing = np.zeros_like(ultraviolet)
    cv2.imwrite(str(tmp_path / "green.tif"), green)
    cv2.imwrite(str(tmp_path / "uv.tif"), np.dstack([nothing, nothing, ultraviolet]))  # blue, green, red
    cv2.imwrite(str(tmp_path / "other.png"), np.kron(rng.random((12, 16)) * 255, np.ones((9, 9))).astype(np.uint8))
    return in_process(tmp_path, monkeypatch, capsys)


def test_aligned_images_and_table_are_left(insectnav: Callable, tmp_path: Path):
    done = insectnav("align", "green.tif", "uv.tif", "--moving-band", "red", "--out", "laid", "--json")
    assert (done.code, done.err) == (0, "")
    row = strict(done.out)["images"][0]
    assert (row["columns_px"], row["rows_px"]) == pytest.approx(SHIFT, abs=0.1)
    assert row["rotation_deg"] == pytest.approx(0.0, abs=0.1)
    assert row["mutual_information_nat"] > 2 * row["mutual_information_before_nat"]
    assert everything(tmp_path / "laid") == ["alignment.csv", "uv_aligned.tif", "uv_valid.png"]
    aligned = cv2.imread(str(tmp_path / "laid" / "uv_aligned.tif"), cv2.IMREAD_UNCHANGED)
    valid = cv2.imread(str(tmp_path / "laid" / "uv_valid.png"), cv2.IMREAD_UNCHANGED)
    assert (aligned.dtype, aligned.shape, set(np.unique(valid))) == (np.uint16, (ROWS, COLUMNS, 3), {0, 255})
    assert not aligned[..., :2].any()
    green = cv2.imread(str(tmp_path / "green.tif"), cv2.IMREAD_UNCHANGED) / 65535
    off = np.abs(aligned[..., 2] / 16383 - (1.0 - green**2))[valid == 255]
    assert np.median(off) < 0.01
    with (tmp_path / "laid" / "alignment.csv").open() as file:
        table = list(csv.DictReader(file))
    assert float(table[0]["m02"]) == pytest.approx(row["m02"], abs=1e-3)


def test_it_is_told_in_words(insectnav: Callable):
    done = insectnav("align", "green.tif", "uv.tif", "--moving-band", "red", "--transform", "translation")
    assert done.out.startswith("out/aligned/uv_aligned.tif: +4.0")
    assert " columns, -3.0" in done.out or " columns, -2.9" in done.out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("green.tif", "none.tif"), "'none.tif' cannot be read"),
        (("green.tif", "uv.tif", "other.png"), "'other.png': "),
        (("green.tif", "uv.tif", "--transform", "rigit"), "did you mean rigid?"),
        (("green.tif", "uv.tif", "--moving-band", "uv"), "band of the moving picture 'uv' is unknown"),
        (("green.tif", "uv.tif", "uv.tif"), "two moving pictures are called 'uv'"),
        (("green.tif", "uv.tif", "--out", ""), "--out is an empty name"),
        (("green.tif",), "Missing argument"),
    ],
)
def test_bad_input_is_told_in_a_sentence_and_nothing_is_left(
    insectnav: Callable, tmp_path: Path, arguments: tuple, sentence: str
):
    before = everything(tmp_path)
    assert_refused(insectnav("align", *arguments), sentence)
    assert everything(tmp_path) == before
