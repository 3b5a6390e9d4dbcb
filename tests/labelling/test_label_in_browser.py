"""The page in a real browser: painted with the mouse, seen at once, corrected, saved."""

import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from browser import addresses_asked, opened_browser
from command_line import PATIENCE, until
from insectnav.labelling.desk import Desk
from insectnav.labelling.masks import load_kernel
from insectnav.labelling.server import LabelServer
from insectnav.vision.growcut import grow_cut
from labelling_scene import COLUMNS, ROWS, calls_of, is_sky, leave, picture, read, served, strokes

pytestmark = pytest.mark.slow
SKY_SHARE = pytest.approx(100.0 * is_sky().mean(), abs=0.06)  # [%] after both strokes, not while they are painted
SKY_LINE, GROUND_LINE = ((0.15, 0.12), (0.5, 0.16), (0.85, 0.12)), ((0.15, 0.9), (0.85, 0.85))  # shares of the picture
TINTED = """const c = document.getElementById("canvas"), r = devicePixelRatio;
    return [...c.getContext("2d").getImageData(arguments[0] * r, arguments[1] * r, 1, 1).data].slice(0, 3)"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    load_kernel()
    with opened_browser(tmp_path_factory.mktemp("browser")) as chrome:
        yield chrome


@pytest.fixture
def page(browser: Any, tmp_path: Path) -> Iterator[tuple[Any, LabelServer]]:
    """The page with two pictures, the first of them shown; the server ends with the test."""
    leave(tmp_path, "a.png", "b.png")
    with served(Desk([tmp_path / "a.png", tmp_path / "b.png"], tmp_path / "masks")) as (server, thread):
        browser.get_log("browser")
        browser.get_log("performance")
        browser.get(server.url)
        until(lambda: words(browser, "status").startswith("Paint"))
        yield browser, server
        if not browser.find_element("id", "end").is_displayed():
            finish(browser)
        until(lambda: not thread.is_alive())
        browser.get("about:blank")


def words(browser: Any, name: str) -> str:
    return browser.find_element("id", name).text


def click(browser: Any, name: str) -> None:
    browser.find_element("id", name).click()


def finish(browser: Any) -> None:
    click(browser, "finish")
    until(lambda: "You can close this page" in words(browser, "end-words"))


def press(browser: Any, keys: str, *held: str) -> None:
    from selenium.webdriver import ActionChains

    actions = ActionChains(browser)
    for key in held:
        actions.key_down(key)
    actions.send_keys(keys)
    for key in held:
        actions.key_up(key)
    actions.perform()


def on_screen(browser: Any, x: float, y: float) -> tuple[float, float]:
    """Where a place of the picture, in shares of it, is on the canvas; the picture is shown whole."""
    canvas = browser.find_element("id", "canvas").size
    zoom = min((canvas["width"] - 16) / COLUMNS, (canvas["height"] - 16) / ROWS, 4)
    return canvas["width"] / 2 + (x - 0.5) * zoom * COLUMNS, canvas["height"] / 2 + (y - 0.5) * zoom * ROWS


def paint(browser: Any, places: tuple, right: bool = False) -> None:
    """A stroke with the mouse."""
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.actions.mouse_button import MouseButton

    canvas = browser.find_element("id", "canvas")
    actions = ActionChains(browser, duration=40)
    for k, place in enumerate(places):
        x, y = on_screen(browser, *place)
        actions.move_to_element_with_offset(canvas, x - canvas.size["width"] / 2, y - canvas.size["height"] / 2)
        if k == 0:
            actions.w3c_actions.pointer_action.pointer_down(button=MouseButton.RIGHT if right else MouseButton.LEFT)
    actions.w3c_actions.pointer_action.pointer_up(button=MouseButton.RIGHT if right else MouseButton.LEFT)
    actions.perform()


def shown_share(browser: Any) -> float:
    """Sky as the page tells it [%]; NaN before there is a mask."""
    text = words(browser, "shares")
    return float(text.split()[1]) if text else np.nan


def masks_and_strokes(server: LabelServer, number: int) -> tuple[np.ndarray, np.ndarray]:
    until(lambda: server.desk.mask_path(number).exists())
    return read(server.desk.mask_path(number)), read(server.desk.strokes_path(number))


def test_painted_mask_is_seen_and_saved(page: tuple):
    browser, server = page
    paint(browser, SKY_LINE)
    until(lambda: shown_share(browser) == 100.0)
    click(browser, "ground")
    paint(browser, GROUND_LINE)
    until(lambda: shown_share(browser) == SKY_SHARE)
    blue = browser.execute_script(TINTED, *on_screen(browser, 0.5, 0.3))
    brown = browser.execute_script(TINTED, *on_screen(browser, 0.5, 0.7))
    assert blue[2] > blue[0] + 40
    assert brown[0] > brown[2] + 40
    press(browser, "s", "\ue009")  # Control
    mask, painted = masks_and_strokes(server, 0)
    until(lambda: words(browser, "status").startswith("Saved"))
    for line, value in ((SKY_LINE, 255), (GROUND_LINE, 0)):
        for x, y in line:
            assert painted[int(y * ROWS), int(x * COLUMNS)] == value
    assert 0.02 < (painted != 128).mean() < 0.25
    labels = grow_cut(picture(), np.select([painted == 255, painted == 0], [2, 1], 0)).labels
    np.testing.assert_array_equal(mask, np.array([128, 0, 255])[labels])
    np.testing.assert_array_equal(mask == 255, is_sky())


def test_strokes_are_undone_redone_erased_and_painted_by_the_right_button(page: tuple):
    browser, server = page
    paint(browser, SKY_LINE)
    paint(browser, GROUND_LINE, right=True)
    until(lambda: shown_share(browser) == SKY_SHARE)
    press(browser, "z", "\ue009")
    until(lambda: shown_share(browser) == 100.0)
    press(browser, "z", "\ue009")
    until(lambda: words(browser, "shares") == "")
    assert not browser.find_element("id", "undo").is_enabled()
    click(browser, "redo")
    click(browser, "redo")
    until(lambda: shown_share(browser) == SKY_SHARE)
    press(browser, "e")
    paint(browser, GROUND_LINE)
    until(lambda: shown_share(browser) == 100.0)
    click(browser, "save")
    mask, painted = masks_and_strokes(server, 0)
    assert set(np.unique(mask)) == {255}
    assert set(np.unique(painted)) == {128, 255}


def test_brush_grows_and_zoom_keeps_strokes_where_they_are(page: tuple):
    browser, server = page
    before = words(browser, "size-shown")
    press(browser, "]]]]")
    assert int(words(browser, "size-shown").split()[0]) > int(before.split()[0])
    press(browser, "[[[[[[[[")
    press(browser, "+++")
    assert words(browser, "zoom") != "400 %"
    press(browser, "0")
    assert words(browser, "zoom") == "400 %"
    paint(browser, ((0.5, 0.2), (0.5, 0.2)))
    click(browser, "save")
    painted = masks_and_strokes(server, 0)[1]
    rows, columns = np.nonzero(painted == 255)
    assert (rows.mean(), columns.mean()) == pytest.approx((0.2 * ROWS - 0.5, 0.5 * COLUMNS - 0.5), abs=0.6)


def test_going_on_saves_and_coming_back_shows_what_was_saved(page: tuple):
    browser, server = page
    paint(browser, SKY_LINE)
    paint(browser, GROUND_LINE, right=True)
    until(lambda: shown_share(browser) == SKY_SHARE)
    press(browser, "n")
    masks_and_strokes(server, 0)
    until(lambda: browser.title.startswith("b.png"))
    until(lambda: words(browser, "status").startswith("Paint"))
    assert words(browser, "shares") == ""
    assert words(browser, "progress") == "1 of 2 have a mask"
    items = browser.find_elements("css selector", "#list li")
    assert [item.get_attribute("class") for item in items] == ["labelled", ""]
    press(browser, "p")
    until(lambda: words(browser, "shares") != "")
    assert shown_share(browser) == pytest.approx(100.0 * is_sky().mean(), abs=0.06)
    finish(browser)
    assert "1 of 2 pictures have a mask" in words(browser, "end-words")
    until(lambda: server.is_ending)


def test_views_are_picture_tint_and_mask(page: tuple):
    browser, server = page
    shutil.rmtree(server.desk.folder, ignore_errors=True)
    paint(browser, SKY_LINE)
    paint(browser, GROUND_LINE, right=True)
    until(lambda: shown_share(browser) == SKY_SHARE)
    place = on_screen(browser, 0.5, 0.3)
    colours = []
    for view in ("plain", "tint", "mask"):
        click(browser, view)
        browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
        colours.append(browser.execute_script(TINTED, *place))
    assert colours[2] == [255, 255, 255]
    assert abs(colours[0][0] - 120) < 25
    assert colours[0] != colours[1] != colours[2]


def test_page_complains_of_nothing_and_asks_nobody_else(page: tuple):
    browser, server = page
    paint(browser, SKY_LINE)
    until(lambda: shown_share(browser) == 100.0)
    assert browser.get_log("browser") == []
    asked = addresses_asked(browser)
    assert server.url in asked
    assert all(address.startswith(server.url) for address in asked)


def test_message_of_the_program_is_shown(page: tuple):
    browser, server = page
    paint(browser, SKY_LINE)
    server.desk.folder.write_text("in the way")
    click(browser, "save")
    until(lambda: "cannot be written" in words(browser, "status"))
    server.desk.folder.unlink()
    click(browser, "save")
    until(lambda: words(browser, "status").startswith("Saved"))
    assert strokes().shape == masks_and_strokes(server, 0)[0].shape


def test_what_is_said_while_strokes_grow_is_said_again_afterwards(page: tuple):
    browser, server = page
    grow, may_grow = server.desk.grow, threading.Event()
    server.desk.grow = lambda *given: grow(*given) if may_grow.wait(PATIENCE) else b""
    browser.execute_script(
        """const real = setTimeout; window.slow = [];
           window.setTimeout = (action, time) => time === 1500 ? (slow.push(action), 0) : real(action, time)"""
    )
    paint(browser, SKY_LINE)
    click(browser, "save")
    until(lambda: words(browser, "status").startswith("Saved"))
    browser.execute_script("slow.forEach(action => action())")
    assert words(browser, "status").startswith("Growing")
    may_grow.set()
    until(lambda: shown_share(browser) == 100.0)
    until(lambda: not words(browser, "status").startswith("Growing"))
    assert words(browser, "status").startswith("Saved")


def test_nothing_is_painted_before_what_was_saved_is_there(page: tuple):
    browser, server = page
    paint(browser, SKY_LINE)
    paint(browser, GROUND_LINE, right=True)
    press(browser, "n")
    until(lambda: browser.title.startswith("b.png"))
    until(lambda: words(browser, "status").startswith("Paint"))
    strokes_of, is_asked, may_answer = server.desk.packed_strokes, threading.Event(), threading.Event()

    def late(number: int) -> bytes | None:
        is_asked.set()
        return strokes_of(number) if may_answer.wait(PATIENCE) else None

    server.desk.packed_strokes = late
    press(browser, "p")
    assert is_asked.wait(PATIENCE)
    assert words(browser, "status") == "Opening a.png"
    paint(browser, ((0.2, 0.5), (0.8, 0.5)))
    may_answer.set()
    until(lambda: shown_share(browser) == SKY_SHARE)
    until(lambda: words(browser, "status") == "These strokes were saved earlier")
    assert not browser.find_element("id", "undo").is_enabled()


def test_closed_page_ends_the_program(browser: Any, tmp_path: Path):
    leave(tmp_path, "a.png")
    with served(Desk([tmp_path / "a.png"], tmp_path)) as (server, thread):
        opened = calls_of(server, "page_opened")
        browser.get(server.url)
        until(lambda: words(browser, "status").startswith("Paint"))
        assert not browser.find_element("id", "pictures").is_displayed()  # there is but one
        until(lambda: len(opened) == 1)
        browser.refresh()
        until(lambda: len(opened) == 2)
        server.patience_s = 0.0
        thread.join(2.0)
        assert thread.is_alive()
        browser.get("about:blank")
        until(lambda: not thread.is_alive())
