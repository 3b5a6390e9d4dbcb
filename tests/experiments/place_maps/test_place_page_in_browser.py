"""The page in a real browser: it fits a desk and a phone, by day and by night, and asks nothing of anyone."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from browser import addresses_asked, opened_browser
from insectnav.experiments.place_maps.build import BuildParams, build
from insectnav.experiments.place_maps.locate import LocateParams, TruthParams, locate
from insectnav.experiments.place_maps.report import page_text
from insectnav.matching.places import PlaceMap
from place_scenes import views, write_pictures

PHONE, DESK = 400, 1280  # [CSS pixel] width

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("places")
    summer = write_pictures(folder / "summer", views())
    winter = write_pictures(folder / "winter", views(season=1), "a_name_that_is_longer_than_the_screen_" * 4 + "{}.png")
    build([str(summer)], folder / "m", BuildParams())
    params = LocateParams(truth=TruthParams(same_index=True))
    place_map = PlaceMap.open(folder / "m")
    search = locate(place_map, [str(winter)], params)
    path = folder / "page.html"
    path.write_text(page_text(search, params, place_map, "w" * 200), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with opened_browser(tmp_path_factory.mktemp("browser")) as chrome:
        yield chrome


def opened(browser: Any, page: Path, width: int, scheme: str = "light") -> Any:
    browser.get("about:blank")
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width == PHONE}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    for kind in ("browser", "performance"):
        browser.get_log(kind)  # forget what was before
    browser.get(page.as_uri())
    return browser


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_nothing_is_wider_than_the_screen(browser: Any, page: Path, width: int):
    chrome = opened(browser, page, width)
    assert chrome.execute_script("return document.documentElement.scrollWidth") <= width
    pictures = chrome.execute_script(
        "return [...document.images].map(i => [i.complete, i.naturalWidth, i.clientWidth])"
    )
    assert len(pictures) == 2 + 2 * 3  # two figures, three pairs
    assert all(complete and natural and shown for complete, natural, shown in pictures)


def test_nothing_is_asked_of_anyone(browser: Any, page: Path):
    chrome = opened(browser, page, DESK)
    assert chrome.get_log("browser") == []
    assert chrome.execute_script("return document.scripts.length") == 0
    assert addresses_asked(chrome) == {page.as_uri()}


def test_letters_stand_out_by_day_and_by_night(browser: Any, page: Path):
    for scheme in ("light", "dark"):
        chrome = opened(browser, page, DESK, scheme)
        script = """
            const light = colour => { const c = colour.match(/\\d+/g).slice(0, 3).map(v => v / 255)
                .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
                return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2] };
            const back = light(getComputedStyle(document.body).backgroundColor);
            return [...document.querySelectorAll('p.lead, td, dd, figcaption, dt, .right')].map(one => {
                const front = light(getComputedStyle(one).color);
                return (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05) })"""
        assert min(chrome.execute_script(script)) >= 4.5, scheme  # WCAG 2, level AA
