"""Photographs from disk: what was written comes back; what is damaged, foreign or ambiguous is named."""

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.datasets.image_folder import find_images, find_truth, natural_order, read_image, read_mask
from insectnav.datasets.picture_headers import read_header

RNG = np.random.default_rng(0)
COLOUR = RNG.integers(0, 256, (13, 21, 3)).astype(np.uint8)
DEEP = RNG.integers(0, 65536, (13, 21, 3)).astype(np.uint16)


def written(path: Path, picture: np.ndarray, *options: int) -> Path:
    assert cv2.imwrite(str(path), picture[..., ::-1] if picture.ndim == 3 else picture, options)
    return path


@pytest.mark.parametrize(
    "picture", [COLOUR, DEEP, COLOUR[..., 0], DEEP[..., 0]], ids=["rgb8", "rgb16", "grey8", "grey16"]
)
@pytest.mark.parametrize("kind", ["png", "tif", "tiff", "PNG"])
def test_what_was_written_comes_back(tmp_path: Path, kind: str, picture: np.ndarray):
    found = read_image(written(tmp_path / f"a.{kind}", np.ascontiguousarray(picture)))
    assert found.dtype == picture.dtype
    assert_array_equal(found, picture)


@pytest.mark.parametrize("options", [(), (cv2.IMWRITE_JPEG_PROGRESSIVE, 1)])
def test_jpeg_comes_back_about(tmp_path: Path, options: tuple):
    smooth = np.repeat(np.linspace(0, 255, 64)[:, None, None], 48, axis=1) * [1.0, 0.5, 0.2]
    path = written(tmp_path / "a.jpg", smooth.astype(np.uint8), *options)
    assert_allclose(read_image(path), smooth, atol=8)
    header = read_header(path.read_bytes())
    assert header == ("JPEG", 64, 48, True)


def with_orientation(jpeg: bytes, orientation: int) -> bytes:
    """The same JPEG with an EXIF segment that says how the camera was held."""
    tiff = b"MM\0*\0\0\0\x08\0\x01" + struct.pack(">HHIHH", 0x0112, 3, 1, orientation, 0) + b"\0\0\0\0"
    body = b"Exif\0\0" + tiff
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + jpeg[2:]


def test_up_is_where_the_camera_says(tmp_path: Path):
    upright = np.zeros((40, 64, 3), np.uint8)
    upright[:20] = 255
    path = written(tmp_path / "a.jpg", np.rot90(upright))
    path.write_bytes(with_orientation(path.read_bytes(), 6))  # to be turned clockwise by a quarter
    assert_allclose(read_image(path), upright, atol=8)


@pytest.mark.parametrize("kind", ["png", "jpg", "tif"])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_truncated_file_is_refused(tmp_path: Path, kind: str, share: float, capfd):
    path = written(tmp_path / f"a.{kind}", RNG.integers(0, 256, (200, 300, 3)).astype(np.uint8))
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(InputError, match=r"'a\.\w+' (ends before|is no PNG|cannot be decoded)"):
        read_image(path)
    assert capfd.readouterr().err == ""


@given(
    data=st.binary(max_size=300),
    start=st.sampled_from([b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0", b"MM\0*"]),
)
def test_any_bytes_have_a_header_or_none(data: bytes, start: bytes):
    header = read_header(start + data)
    assert header is None or header.kind in ("PNG", "JPEG", "TIFF")


def test_what_is_no_picture_is_refused(tmp_path: Path):
    (tmp_path / "a.png").write_text("hello")
    (tmp_path / "b.png").write_bytes(b"")
    (tmp_path / "c.nef").write_text("hello")
    for name, words in (("a.png", "is no PNG, JPEG or TIFF"), ("b.png", "0 bytes"), ("c.nef", "decoded as a raw file")):
        with pytest.raises(InputError, match=words):
            read_image(tmp_path / name)
    with pytest.raises(InputError, match="cannot be read"):
        read_image(tmp_path / "missing.png")


def test_size_is_bounded_before_anything_is_allocated(tmp_path: Path):
    path = written(tmp_path / "a.png", COLOUR)
    data = bytearray(path.read_bytes())
    data[16:24] = struct.pack(">II", 100_000, 100_000)
    path.write_bytes(data)
    with pytest.raises(InputError, match="100000 × 100000 pixels"):
        read_image(path)


def raw_file(mosaic: np.ndarray, black: int, white: int) -> bytes:
    """A DNG file of one uncompressed strip, red pixel first (Adobe DNG 1.4)."""
    rows, columns = mosaic.shape
    entries = [  # tag, type, values; types 1 byte, 2 text, 3 short, 4 long, 5 ratio, 10 signed ratio
        (254, 4, [0]), (256, 4, [columns]), (257, 4, [rows]), (258, 3, [16]), (259, 3, [1]), (262, 3, [32803]),
        (271, 2, b"Test\0"), (272, 2, b"Test\0"), (273, 4, [0]), (274, 3, [1]), (277, 3, [1]), (278, 4, [rows]),
        (279, 4, [rows * columns * 2]), (33421, 3, [2, 2]), (33422, 1, bytes([0, 1, 1, 2])),
        (50706, 1, bytes([1, 4, 0, 0])), (50708, 2, b"Test\0"), (50714, 4, [black]), (50717, 4, [white]),
        (50721, 10, [(1, 1), (0, 1), (0, 1), (0, 1), (1, 1), (0, 1), (0, 1), (0, 1), (1, 1)]),
        (50728, 5, [(1, 2), (1, 1), (1, 4)]), (50778, 3, [21]),
    ]  # fmt: skip
    at = 8 + 2 + 12 * len(entries) + 4
    directory, extra = b"", b""
    for tag, kind, values in entries:
        if isinstance(values, bytes):
            data, count = values, len(values)
        else:
            code = {3: "H", 4: "I", 5: "II", 10: "ii"}[kind]
            count = len(values)
            data = b"".join(struct.pack("<" + code, *(v if isinstance(v, tuple) else (v,))) for v in values)
        if tag == 273:
            strip = len(directory) + 8
        if len(data) > 4:
            directory += struct.pack("<HHII", tag, kind, count, at + len(extra))
            extra += data + b"\0" * (len(data) % 2)
        else:
            directory += struct.pack("<HHI", tag, kind, count) + data.ljust(4, b"\0")
    offset = struct.pack("<I", at + len(extra))
    directory = directory[:strip] + offset + directory[strip + 4 :]
    head = b"II*\0" + struct.pack("<IH", 8, len(entries))
    return head + directory + b"\0\0\0\0" + extra + mosaic.astype("<u2").tobytes()


def test_raw_file_keeps_black_level_and_bands(tmp_path: Path):
    pytest.importorskip("rawpy")
    mosaic = np.empty((64, 96), np.uint16)
    mosaic[::2, ::2], mosaic[::2, 1::2], mosaic[1::2, ::2], mosaic[1::2, 1::2] = 2000, 6000, 6000, 3000
    (tmp_path / "a.dng").write_bytes(raw_file(mosaic, black=500, white=16000))
    picture = read_image(tmp_path / "a.dng")
    assert picture.dtype == np.uint16
    middle = picture[20:-20, 20:-20].reshape(-1, 3).mean(axis=0)
    assert_allclose(middle / middle[1], np.array([2000, 6000, 3000]) / 6000, rtol=0.01)
    assert_allclose(middle[1], 6000 / 16000 * 65535, rtol=0.05)  # white of the sensor at the full scale


def test_truncated_raw_file_is_refused(tmp_path: Path):
    pytest.importorskip("rawpy")
    data = raw_file(np.full((64, 96), 3000, np.uint16), 0, 16000)
    (tmp_path / "a.dng").write_bytes(data[:200])
    with pytest.raises(InputError, match="decoded as a raw file"):
        read_image(tmp_path / "a.dng")


def test_folder_gives_photographs_in_natural_order_and_names_the_rest(tmp_path: Path):
    for name in ("f10.png", "f9.jpg", "f9_sky.png", "lonely_mask.png"):
        written(tmp_path / name, COLOUR)
    (tmp_path / "notes.txt").write_text("")
    (tmp_path / ".hidden.png").write_text("")
    (tmp_path / "sub").mkdir()
    found = find_images([tmp_path])
    assert [path.name for path in found.files] == ["f9.jpg", "f10.png", "lonely_mask.png"]
    reasons = dict(found.skipped)
    assert set(reasons) == {"notes.txt", ".hidden.png", "sub", "f9_sky.png"}
    assert "mask of 'f9'" in reasons["f9_sky.png"]
    assert natural_order("a2b") < natural_order("a10b")
    with pytest.raises(InputError, match="does not exist"):
        find_images([tmp_path / "nowhere"])
    with pytest.raises(InputError, match="no photograph"):
        find_images([tmp_path / "sub"])
    with pytest.raises(InputError, match="an empty name is given"):
        find_images([""])


def test_truth_is_found_by_name(tmp_path: Path):
    photograph = written(tmp_path / "a.png", COLOUR)
    assert find_truth(photograph, tmp_path) is None  # not the photograph itself
    written(tmp_path / "a_sky.png", COLOUR[..., 0].copy())
    assert find_truth(photograph, tmp_path) == tmp_path / "a_sky.png"
    written(tmp_path / "a_mask.png", COLOUR[..., 0].copy())
    with pytest.raises(InputError, match="several masks"):
        find_truth(photograph, tmp_path)


def test_mask_is_white_black_and_unknown(tmp_path: Path):
    picture = np.array([[255, 0, 128, 255]] * 4, np.uint8)
    sky, known = read_mask(written(tmp_path / "m.png", picture))
    assert_array_equal(sky, picture == 255)
    assert_array_equal(known, picture != 128)
    ones = read_mask(written(tmp_path / "n.png", (picture == 255).astype(np.uint8)))
    assert_array_equal(ones[0], picture == 255)
    nothing = read_mask(written(tmp_path / "o.png", np.zeros((4, 4), np.uint8)))
    assert not nothing[0].any()
    for wrong, words in ((COLOUR, "in colour"), (COLOUR[..., 0].copy(), "values, such as")):
        with pytest.raises(InputError, match=words):
            read_mask(written(tmp_path / "p.png", wrong))
