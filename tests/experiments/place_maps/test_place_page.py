"""The page and what is on it: nothing of HTML comes through, pictures of strangers are checked, files stay small."""

from datetime import datetime

import numpy as np
import pytest

from html_outline import Outline
from insectnav.experiments.place_maps.page import PlacePage, Plot, render_page
from insectnav.experiments.place_maps.pairs import chosen_pairs, shown_pairs
from insectnav.experiments.place_maps.thumbnails import FILE, find_thumbnails, keep_thumbnails, picture_of, thumbnail
from insectnav.experiments.place_maps.truth import same_index
from place_scenes import located

NASTY = '"><script>alert("x")</script><img src=http://example.org/x.png onerror=alert(1)>'


def picture(seed: int, shape=(48, 96)) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def test_nothing_of_html_comes_through():
    found = located([0, 1], None, same_index(np.array([0, 1]), np.zeros(10, np.int64), 1.0))
    found = type(found)(**{**vars(found), "names": [NASTY, NASTY], "place_names": [NASTY] * 10})
    small = thumbnail(picture(0))
    page = render_page(
        PlacePage(
            title=NASTY,
            lead=NASTY,
            tiles=[(NASTY, NASTY)],
            plots=[Plot(name=NASTY, heading=NASTY, caption=[(NASTY, NASTY)], png=b"png", size=(3, 4))],
            pairs=shown_pairs(found, {0: small, 1: small}, {0: small, 1: b"<script>"}),
            numbers=[(NASTY, NASTY, NASTY)],
            settings=[(NASTY, NASTY)],
            notes=[NASTY],
            command=["insectnav", NASTY],
            made=datetime.now().astimezone(),
        )
    )
    outline = Outline(page)
    assert not outline.open
    assert {name for name, _ in outline.elements} & {"script", "iframe", "object", "link"} <= {"link"}
    for name, attributes in outline.elements:
        assert not [key for key in attributes if key.startswith("on")]
        if name == "img":
            assert attributes["src"].startswith("data:image/")


def test_pairs_are_the_best_the_median_the_worst_and_the_wrong():
    reference = np.array([0, 1, 2, 3, 9, 8, 7, 7])
    score = np.array([0.5, 0.1, 0.3, 0.9, 0.4, 0.2, 0.8, 0.6])
    truth = same_index(reference, np.zeros(10, np.int64), 0.0)
    chosen = chosen_pairs(located(reference, score, truth))
    assert [query for _, query in chosen] == [1, 0, 3, 5, 4, 6]
    assert [title.split()[0] for title, _ in chosen] == ["Best", "Median", "Worst", "Wrong", "Wrong", "Wrong"]
    assert [query for _, query in chosen_pairs(located([-1, -1]))] == []
    assert [query for _, query in chosen_pairs(located([4, -1]))] == [0]


@pytest.mark.parametrize("shape", [(32, 64), (3000, 4000, 3), (25, 120, 3), (2000, 100)])
def test_small_pictures_stay_small_and_look_alike(shape):
    rows, columns = shape[:2]
    ramp = np.linspace(0, 255, columns)[None, :] * np.ones((rows, 1))
    given = ramp if len(shape) == 2 else np.repeat(ramp[..., None], 3, axis=2)
    data = thumbnail(given.astype(np.uint8))
    found = picture_of(data)
    assert found is not None
    assert len(data) < 20_000
    assert found.shape[0] <= 192
    assert found.shape[1] <= 288
    assert (
        np.abs(found[found.shape[0] // 2, :, 0] - np.linspace(0, 255, found.shape[1])).max() < 15
    )  # a wide column is a step of 28
    assert thumbnail(np.zeros(7)) == b""


def test_small_pictures_are_kept_and_replaced_from_a_place_on(tmp_path):
    pictures = [thumbnail(picture(k)) for k in range(6)]
    keep_thumbnails(tmp_path, 0, pictures[:4])
    keep_thumbnails(tmp_path, 2, [pictures[5], b""])
    assert find_thumbnails(tmp_path, [0, 1, 2, 3, 99]) == {0: pictures[0], 1: pictures[1], 2: pictures[5]}
    (tmp_path / FILE).write_bytes(b"no store of pictures")
    assert find_thumbnails(tmp_path, [0]) == {}
    assert picture_of(b"GIF89a") is None
    assert picture_of(b"\xff\xd8broken") is None
