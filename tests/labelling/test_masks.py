"""Masks from strokes without a window, and what is refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.datasets.image_folder import read_image
from insectnav.datasets.picture_files import write_picture
from insectnav.labelling.masks import mask_from_strokes, read_strokes, shares
from insectnav.labelling.pictures import list_pictures, on_screen
from insectnav.vision.growcut import grow_cut
from labelling_scene import COLUMNS, ROWS, is_sky, leave, picture, read, strokes


@pytest.mark.parametrize("name", ["street.png", "street.tif"])
def test_mask_is_the_sky(name: str, tmp_path: Path):
    leave(tmp_path, name)
    write_picture(tmp_path / "s.png", strokes())
    told = mask_from_strokes(tmp_path / name, tmp_path / "s.png", tmp_path / "deep" / "m.png")
    mask = read(tmp_path / "deep" / "m.png")
    np.testing.assert_array_equal(mask == 255, is_sky())
    assert set(np.unique(mask)) == {0, 255}
    assert told == (is_sky().mean(), (~is_sky()).mean(), 0)
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["m.png"]


def test_pixels_that_no_stroke_reaches_are_grey_and_told(tmp_path: Path):
    image = np.zeros((6, 8), np.uint8)
    image[:, 4:] = 255  # black against the brightest: g = 0
    write_picture(tmp_path / "i.png", image)
    painted = np.full((6, 8), 128, np.uint8)
    painted[0, 0] = 0
    write_picture(tmp_path / "s.png", painted)
    told = mask_from_strokes(tmp_path / "i.png", tmp_path / "s.png", tmp_path / "m.png")
    np.testing.assert_array_equal(read(tmp_path / "m.png"), np.where(image == 0, 0, 128))
    assert told == (0.0, 0.5, 24)
    assert shares(np.array([[2, 2, 1, 0]], np.uint8)) == (0.5, 0.25, 1)


def test_picture_is_read_as_it_is_stored(tmp_path: Path):
    leave(tmp_path, "a.png", "b.tif")
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), picture())
    np.testing.assert_array_equal(read_image(tmp_path / "b.tif"), picture(np.uint16))
    grey = picture()[..., 1]
    cv2.imwrite(str(tmp_path / "c.png"), grey)
    np.testing.assert_array_equal(read_image(tmp_path / "c.png"), grey)
    transparent = np.dstack([picture()[..., ::-1], np.full((ROWS, COLUMNS), 9, np.uint8)])
    cv2.imwrite(str(tmp_path / "d.png"), transparent)
    np.testing.assert_array_equal(read_image(tmp_path / "d.png"), picture())


@pytest.mark.parametrize("values", [picture(), picture(np.uint16), picture()[..., 0] / 255.0, np.full((4, 5), 3.0)])
def test_screen_shows_all_of_the_picture(values: np.ndarray):
    shown = cv2.imdecode(np.frombuffer(on_screen(values), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == (*values.shape[:2], 3)
    if np.ptp(values):
        dark, bright = shown[~is_sky()[: len(shown)]].mean(), shown[is_sky()[: len(shown)]].mean()
        assert bright > dark + 60


def test_folder_is_listed_without_other_files_masks_and_hidden_ones(tmp_path: Path):
    leave(tmp_path, "b.png", "a.jpg", "a_mask.png", "a_strokes.png", ".hidden.png")
    (tmp_path / "notes.txt").write_text("x")
    (tmp_path / "folder.png").mkdir()
    assert [path.name for path in list_pictures([tmp_path])] == ["a.jpg", "b.png"]
    assert [path.name for path in list_pictures([tmp_path / "b.png", tmp_path])] == ["b.png", "a.jpg"]


@pytest.mark.parametrize(
    ("files", "names", "sentence"),
    [
        ((), ["none.png"], "'none.png' is missing, expected an image or a folder of images"),
        ((), ["."], "no image was found"),
        (("a.png", "a.tif"), ["."], "would share a mask"),
        ((), ["s.txt"], "'s.txt' has no ending of an image"),
    ],
)
def test_wrong_names_are_refused(
    files: tuple, names: list, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    leave(tmp_path, *files)
    (tmp_path / "s.txt").write_text("x")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=sentence):
        list_pictures(names)


@pytest.mark.parametrize(
    ("painted", "sentence"),
    [
        (np.full((ROWS, COLUMNS), 127, np.uint8), "holds the grey 127, expected 255 for sky, 0 for ground, 128 else"),
        (np.full((ROWS, COLUMNS + 1), 128, np.uint8), "has 121 × 90 pixels, the picture 120 × 90: strokes of another"),
        (np.full((ROWS, COLUMNS), 128, np.uint16), "is not an 8-bit grey image"),
        (np.tile(np.array([0, 0, 255], np.uint8), (ROWS, COLUMNS, 1)), "is not an 8-bit grey image"),
    ],
)
def test_what_are_no_strokes_is_refused(painted: np.ndarray, sentence: str, tmp_path: Path):
    cv2.imwrite(str(tmp_path / "s.png"), painted)
    with pytest.raises(InputError, match=sentence):
        read_strokes(tmp_path / "s.png", (ROWS, COLUMNS))


def test_grey_strokes_saved_in_colour_are_taken(tmp_path: Path):
    cv2.imwrite(str(tmp_path / "s.png"), strokes()[..., None].repeat(3, axis=2))
    np.testing.assert_array_equal(
        read_strokes(tmp_path / "s.png", (ROWS, COLUMNS)), np.select([strokes() == 255, strokes() == 0], [2, 1], 0)
    )


def test_labels_are_those_of_grow_cut(tmp_path: Path):
    rng = np.random.default_rng(2)
    image = rng.integers(0, 256, (40, 50, 3), np.uint8)
    painted = rng.choice([128, 0, 255], (40, 50), p=[0.9, 0.05, 0.05]).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "i.png"), image[..., ::-1])
    write_picture(tmp_path / "s.png", painted)
    mask_from_strokes(tmp_path / "i.png", tmp_path / "s.png", tmp_path / "m.png")
    labels = grow_cut(image, np.select([painted == 255, painted == 0], [2, 1], 0)).labels
    np.testing.assert_array_equal(read(tmp_path / "m.png"), np.array([128, 0, 255])[labels])


def test_nothing_painted_and_no_place_to_write_are_told(tmp_path: Path):
    leave(tmp_path, "i.png")
    write_picture(tmp_path / "s.png", np.full((ROWS, COLUMNS), 128, np.uint8))
    with pytest.raises(InputError, match="is 128 everywhere"):
        mask_from_strokes(tmp_path / "i.png", tmp_path / "s.png", tmp_path / "m.png")
    write_picture(tmp_path / "s.png", strokes())
    with pytest.raises(InputError, match="cannot be written"):
        mask_from_strokes(tmp_path / "i.png", tmp_path / "s.png", tmp_path / "i.png" / "m.png")
