"""Pictures on disk, read back by another library."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from insectnav.checks import InputError
from insectnav.datasets.image_folder import read_image
from insectnav.datasets.picture_files import check_format, quantised, write_picture

RNG = np.random.default_rng(5)


def test_whole_numbers_are_the_nearest():
    np.testing.assert_array_equal(quantised([0.0, 0.5, 1.0, 1.7, -0.2]), [0, 128, 255, 255, 0])
    np.testing.assert_array_equal(quantised([0.25, 1.0], 16), [16384, 65535])
    assert quantised([0.1]).dtype == np.uint8


@pytest.mark.parametrize("suffix", [".png", ".tiff"])
@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_picture_comes_back(suffix: str, shape: tuple, dtype: type, tmp_path: Path):
    picture = RNG.integers(0, np.iinfo(dtype).max, shape).astype(dtype)
    write_picture(tmp_path / f"a{suffix}", picture)
    np.testing.assert_array_equal(read_image(tmp_path / f"a{suffix}"), picture)
    assert [path.name for path in tmp_path.iterdir()] == [f"a{suffix}"]


@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3)])
def test_floating_point_numbers_come_back(shape: tuple, tmp_path: Path):
    picture = RNG.random(shape).astype(np.float32)
    picture.flat[0] = np.inf
    write_picture(tmp_path / "a.tiff", picture)
    np.testing.assert_array_equal(read_image(tmp_path / "a.tiff"), picture)


def test_other_programs_see_the_same_colours(tmp_path: Path):
    picture = RNG.integers(0, 255, (4, 6, 3)).astype(np.uint8)
    for name in ("a.png", "a.tiff"):
        write_picture(tmp_path / name, picture)
        np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / name)), picture)
    depth = RNG.random((4, 6)).astype(np.float32)
    write_picture(tmp_path / "d.tiff", depth)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "d.tiff")), depth)


def test_nothing_is_left_of_a_file_that_could_not_be_written(tmp_path: Path):
    (tmp_path / "a.png").mkdir()
    with pytest.raises(InputError, match=r"a.png' cannot be written \(Is a directory\)"):
        write_picture(tmp_path / "a.png", np.zeros((2, 2), np.uint8))
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_what_no_format_can_hold_is_refused(tmp_path: Path):
    for name, bits, words in (
        ("png", 32, "--format tiff?"),
        ("jpeg", 8, "format 'jpeg' is unknown"),
        ("tiff", 12, "8 or 16 or 32"),
    ):
        with pytest.raises(InputError, match=words.replace("?", r"\?")):
            check_format(name, bits)
    with pytest.raises(InputError, match="nan"):
        quantised([np.nan])
