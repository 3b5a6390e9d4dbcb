"""Bands that look different, laid over each other: known motions are found again, and what cannot be is told."""

import builtins
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from band_scene import moved, photograph
from insectnav.checks import InputError
from insectnav.vision.registration import RegistrationParams, align
from insectnav.vision.warping import warp

pytest.importorskip("SimpleITK")
SHAPE, HOUSE, STREET = (200, 300), (110, 1000), (110, 1500)
TOLERANCE = 0.15  # [pixel] at the corners of the picture
MOTIONS: dict[str, dict[str, Any]] = {
    "translation": {"shift": (7.3, -4.6)},
    "rigid": {"shift": (-9.4, 5.2), "rotation_deg": 2.5},
    "similarity": {"shift": (6.0, 3.3), "rotation_deg": -2.0, "scale": 1.04},
    "affine": {"shift": (3.0, -8.0), "rotation_deg": 1.0, "scale": 0.97, "shear": 0.02},
}


def corner_error(found: np.ndarray, true: np.ndarray, shape: tuple = SHAPE) -> float:
    """Largest error of a coordinate at the corners [pixel]."""
    corners = np.array([[x, y, 1.0] for x in (0, shape[1]) for y in (0, shape[0])])
    return float(np.abs(corners @ (found - true).T).max())


def quick(band: str, matrix: np.ndarray | None = None, **options: Any) -> np.ndarray:
    return photograph(band, SHAPE, matrix, **({"corner": HOUSE} | options))


@pytest.mark.slow
@pytest.mark.parametrize("transform", MOTIONS)
@pytest.mark.parametrize("corner", [HOUSE, STREET])
def test_known_motion_between_ultraviolet_and_green_is_found(transform: str, corner: tuple):
    true = moved(SHAPE, **MOTIONS[transform])
    fixed, moving = quick("green", corner=corner), quick("uv", true, corner=corner, seed=3)
    found = align(fixed, moving, RegistrationParams(transform=transform))
    assert corner_error(found.matrix, true) < TOLERANCE
    assert found.mutual_information > 2.0 * found.mutual_information_before
    assert found.fall > 0.2
    np.testing.assert_allclose(found.shift_px, MOTIONS[transform]["shift"], atol=TOLERANCE)
    if transform != "affine":
        assert found.rotation == pytest.approx(np.deg2rad(MOTIONS[transform].get("rotation_deg", 0.0)), abs=1e-3)
        assert found.scale == pytest.approx(MOTIONS[transform].get("scale", 1.0), abs=1e-3)


@pytest.mark.parametrize("look", [lambda v: 1.0 - v, lambda v: np.abs(v - 0.4) ** 0.7, lambda v: v**3])
def test_brightness_may_be_turned_over_or_bent(look: Any):
    true = moved(SHAPE, shift=(5.4, -3.7), rotation_deg=1.5)
    found = align(quick("green"), look(quick("green", true, seed=9)))
    assert corner_error(found.matrix, true) < TOLERANCE


def test_sixteen_bits_and_colours_keep_their_type():
    true = moved(SHAPE, shift=(8.0, -6.0))
    unmoved, uv = quick("uv"), quick("uv", true, seed=3)
    colours = np.stack([uv, np.zeros(SHAPE), np.full(SHAPE, 0.5)], axis=-1)
    moving = np.rint(colours * 16383).astype(np.uint16)  # 14 bits in 16
    fixed = np.rint(quick("green") * 65535).astype(np.uint16)
    found = align(fixed, moving, RegistrationParams(transform="translation"), moving_band="red")
    assert corner_error(found.matrix, true) < TOLERANCE
    assert found.aligned.dtype == np.uint16
    assert found.aligned.shape == (*SHAPE, 3)
    assert not found.aligned[~found.valid].any()
    assert found.valid.mean() == pytest.approx((1 - 8 / 300) * (1 - 6 / 200), abs=0.01)
    assert (found.aligned[found.valid][:, 1] == 0).all()
    np.testing.assert_allclose(found.aligned[found.valid][:, 2], 8192, atol=1)
    off = np.abs(found.aligned[..., 0] / 16383 - unmoved)[found.valid]
    assert np.median(off) < 0.02  # the noise of the camera, twice


def test_pictures_of_different_sizes():
    fixed, wide = quick("green"), photograph("uv", (220, 330), corner=HOUSE, seed=3)
    found = align(fixed, wide, RegistrationParams(transform="translation"))
    assert corner_error(found.matrix, np.eye(2, 3)) < TOLERANCE
    assert found.aligned.shape == SHAPE
    assert found.valid.mean() > 0.99


def test_same_bits_each_time_whatever_the_number_of_threads():
    code = (
        "import numpy as np\nfrom insectnav.vision.registration import align\n"
        "rng = np.random.default_rng(0)\npicture = np.kron(rng.random((12, 16)), np.ones((9, 9)))\n"
        "found = align(picture, 1.0 - np.roll(picture, (3, -4), (0, 1)) ** 2)\nprint(found.matrix.tobytes().hex())"
    )
    bits = set()
    for n_threads in ("1", "3"):
        environment = os.environ | {"ITK_GLOBAL_DEFAULT_NUMBER_OF_THREADS": n_threads}
        bits.add(subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True).stdout)
    assert len(bits) == 1
    matrix = np.frombuffer(bytes.fromhex(bits.pop().decode()), float).reshape(2, 3)
    np.testing.assert_allclose(matrix, [[1, 0, -4], [0, 1, 3]], atol=0.15)


@pytest.mark.parametrize("seed", [1, 2])
def test_another_scene_is_refused(seed: int):
    with pytest.raises(InputError, match="another scene") as refused:
        align(quick("green"), quick("uv", corner=STREET, seed=seed))
    assert "\n" not in str(refused.value)


def test_pattern_that_repeats_itself_is_refused():
    """Which of the many equal places is meant cannot be known."""
    row, column = np.indices((120, 160))
    stripes = np.sin(row * 2 * np.pi / 12) + np.sin(column * 2 * np.pi / 10)
    with pytest.raises(InputError, match="another place fits almost as well"):
        align(stripes, -stripes, RegistrationParams(transform="translation"))


def test_too_far_is_refused():
    far = moved(SHAPE, shift=(160.0, 0.0))
    with pytest.raises(InputError, match=r"covers .* %|no place stands out|may share too little"):
        align(quick("green"), quick("uv", far), RegistrationParams(transform="translation", largest_shift=0.5))


def test_a_search_that_is_cut_short_is_told():
    true = moved(SHAPE, shift=(7.3, -4.6), rotation_deg=2.0)
    with pytest.raises(InputError, match="has not come to rest after 2 iterations"):
        align(quick("green"), quick("uv", true), RegistrationParams(n_iterations=2))


def test_missing_library_is_told(monkeypatch: pytest.MonkeyPatch):
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == "SimpleITK":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match=r"pip install 'insectnav\[register\]'"):
        align(np.eye(40), np.eye(40))


@pytest.mark.parametrize(
    ("fixed", "moving", "options", "sentence"),
    [
        (np.ones((40, 40)), np.eye(40), {}, "fixed picture has the same brightness everywhere"),
        (np.eye(40), np.eye(20), {}, "moving picture has 20 × 20 pixels, expected at least 32 a side"),
        (np.eye(40), np.zeros((40, 40, 2)), {}, "moving picture has shape (40, 40, 2), expected (rows, columns) or"),
        (np.eye(40), np.full((40, 40), np.nan), {}, "moving picture is nan"),
        (np.eye(40), np.eye(40), {"moving_band": "red"}, "moving picture has no colours, but its band 'red'"),
        (np.eye(40), np.eye(40), {"fixed_band": "uv"}, "band of the fixed picture 'uv' is unknown"),
    ],
)
def test_bad_input_is_told_in_a_sentence(fixed: np.ndarray, moving: np.ndarray, options: dict, sentence: str):
    with pytest.raises(InputError) as refused:
        align(fixed, moving, **options)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    "changes", [{"transform": "rigit"}, {"n_bins": 1}, {"largest_shift": 2.0}, {"seed": 0}, {"n_iterations": 0}]
)
def test_parameters_out_of_range_are_refused(changes: dict):
    with pytest.raises(InputError):
        RegistrationParams(**changes)


def test_warp_moves_whole_pixels_exactly_and_marks_what_is_not_seen():
    picture = np.arange(30, dtype=np.uint8).reshape(5, 6)
    shifted, valid = warp(picture, [[1, 0, 2], [0, 1, -1]], (5, 6))
    assert valid.sum() == 4 * 4
    np.testing.assert_array_equal(shifted[1:, :4], picture[:4, 2:])
    assert not shifted[~valid].any()
    turned, all_valid = warp(picture, [[0, -1, 6], [1, 0, 0]], (6, 5))  # a quarter turn: column, row = 6 − row, column
    np.testing.assert_array_equal(turned, picture[:, ::-1].T)
    assert all_valid.all()
    halfway, _ = warp(picture.astype(float), [[1, 0, 0.5], [0, 1, 0]], (5, 5))
    np.testing.assert_allclose(halfway, picture[:, :5] + 0.5)


def test_importing_loads_no_heavy_library(tmp_path: Path):
    code = "import sys, insectnav.vision.registration\nassert not {'SimpleITK', 'scipy', 'cv2'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)
