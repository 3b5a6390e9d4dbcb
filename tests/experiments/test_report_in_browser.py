"""The report in a real browser: it fits a desk and a phone, asks nothing of anyone and runs nothing."""

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

from browser import addresses_asked, opened_browser
from insectnav import experiments
from insectnav.experiments import load
from insectnav.experiments.report import write_report
from insectnav.sweep import executor, run_experiment
from made_results import leave, verdict

SMALL_PAPER = {"needle": "needle_paper.needle", "drum": "needle_paper.drum", "coin": "needle_paper.needle"}
EVIL = "<script>document.title = 'taken over'</script><img src='http://127.0.0.1:9/x.png' onerror='alert(1)'>" * 3
PHONE, DESK = 400, 1280  # [CSS pixel] width

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report on a real run, results with hostile and very long words, and an experiment that was never run."""
    out = tmp_path_factory.mktemp("out") / ("out" * 30)
    out.mkdir()
    with pytest.MonkeyPatch.context() as patched, executor(workers=1) as on:
        patched.setattr(experiments, "_MODULES", SMALL_PAPER)
        run_experiment(load("needle"), "needle", out, on=on)
        hostile = verdict(quantity="a" * 200, unit="m" * 80, why=EVIL, how_read="b" * 500, verdict="differs")
        leave(out, "coin", "k" * 200, verdicts=[hostile], files={"caption.txt": EVIL.encode()})
        return write_report(out).path


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with opened_browser(tmp_path_factory.mktemp("browser")) as chrome:
        yield chrome


@pytest.fixture
def opened(browser: Any, page: Path) -> Any:
    browser.get("about:blank")
    set_width(browser, DESK)
    for kind in ("browser", "performance"):
        browser.get_log(kind)  # forget what was before
    browser.get(page.as_uri())
    return browser


def set_width(browser: Any, width: int) -> None:
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width == PHONE}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def test_page_opens_without_complaint(opened: Any):
    assert opened.title == "insectnav: published numbers and ours"
    assert opened.get_log("browser") == []
    assert opened.execute_script("return document.compatMode") == "CSS1Compat"
    assert opened.execute_script("return document.scripts.length") == 0


def test_nothing_is_asked_of_anyone(opened: Any, page: Path):
    assert addresses_asked(opened) == {page.as_uri()}


def test_every_figure_is_seen(opened: Any):
    pictures = opened.execute_script(
        "return [...document.images].map(i => [i.complete, i.naturalWidth, i.naturalHeight, i.clientWidth, i.alt])"
    )
    assert len(pictures) == len(opened.find_elements("css selector", "figure")) == 2  # experiments with results
    assert [picture[1:3] for picture in pictures] == [[600, 400], [4, 3]]  # 3 × 2 inches at 200 dpi, and the made one
    assert all(complete and width for complete, _, _, width, _ in pictures)
    assert all(picture[4].startswith("Plot for Fig. 1") for picture in pictures)


@pytest.mark.parametrize("width", [320, PHONE, 768, DESK])
def test_nothing_sticks_out(opened: Any, width: int):
    set_width(opened, width)
    assert opened.execute_script("return window.innerWidth") == width
    assert opened.execute_script("return document.documentElement.scrollWidth") <= width
    outside = opened.execute_script(
        """return [...document.querySelectorAll("body *")].filter(element => {
             const box = element.getBoundingClientRect();
             if (element.closest(".plot *") || box.width <= 1) return false;
             return box.right > window.innerWidth + 0.5 || box.left < -0.5;
           }).map(element => element.outerHTML.slice(0, 200))"""
    )
    assert outside == []


def test_no_text_lies_over_another(opened: Any):
    for width in (PHONE, DESK):
        set_width(opened, width)
        crossing = opened.execute_script(
            """const boxes = [...document.querySelectorAll("td, th[scope=row], h2, figure, dd, li")]
                 .filter(element => element.tagName !== "LI").map(element => element.getBoundingClientRect());
               return boxes.flatMap((a, i) => boxes.slice(i + 1).filter(b =>
                 Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
                 Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1).map(b => [a, b])).length"""
        )
        assert crossing == 0
        cut = opened.execute_script(
            """return [...document.querySelectorAll("td, th, dd, code, p, span")]
                 .filter(element => element.scrollWidth > element.clientWidth + 1 && element.clientWidth > 1)
                 .map(element => element.outerHTML.slice(0, 200))"""
        )
        assert cut == []


def test_phone_scrolls_a_wide_figure_alone(opened: Any, page: Path):
    """A figure of a double column at 200 dpi stays legible: its letters are no smaller than on half a desk."""
    set_width(opened, PHONE)
    plot, picture = "document.querySelector('.plot')", "document.querySelector('.plot img')"
    opened.execute_script(f"{picture}.className = 'wide'")
    assert opened.execute_script(f"return {picture}.clientWidth") >= 640
    assert opened.execute_script(f"return {plot}.clientWidth") < PHONE
    assert opened.execute_script(f"{plot}.scrollLeft = 9999; return {plot}.scrollLeft") > 200
    assert opened.execute_script("return document.documentElement.scrollWidth") <= PHONE


def test_narrow_page_names_each_cell_as_a_wide_one_names_its_column(opened: Any):
    names = "return [...document.querySelectorAll('.comparison thead th')].map(cell => cell.textContent)"
    shown = "return getComputedStyle(document.querySelector('.comparison td'), '::before').content"
    assert opened.execute_script(names)[:5] == ["Quantity", "Published", "Ours", "Verdict", "Source"]
    assert opened.execute_script(shown) == "none"
    set_width(opened, PHONE)
    assert opened.execute_script(shown) == '"Published"'


def test_links_of_the_page_lead_somewhere(opened: Any, page: Path):
    targets = opened.execute_script("return [...document.links].map(link => link.getAttribute('href'))")
    assert len(targets) == 4
    for target in targets:
        if target.startswith("#"):
            assert opened.find_elements("id", target[1:])
        else:
            assert (page.parent / unquote(target) / "provenance.json").is_file()


def test_page_prints_on_few_sheets(opened: Any):
    paper = {"paperWidth": 8.27, "paperHeight": 11.69}
    pdf = base64.b64decode(opened.execute_cdp_cmd("Page.printToPDF", paper)["data"])
    assert pdf.startswith(b"%PDF-")
    assert 2 <= pdf.count(b"/Type /Page\n") <= 6  # the hostile words alone take one
