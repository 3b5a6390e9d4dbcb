"""The report: what it shows, which result it chooses, and what it makes of files that strangers left."""

import html
import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from html_outline import Outline
from insectnav import experiments
from insectnav.checks import InputError
from insectnav.experiments import report
from insectnav.experiments.experiment import code_version
from insectnav.experiments.report import write_report
from insectnav.experiments.report_style import STYLE
from insectnav.experiments.verdict_words import counts_text, duration_text, ours_text, published_text
from made_results import leave, verdict
from track_files import assert_one_sentence


@pytest.fixture(autouse=True)
def small_paper(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiments, "_MODULES", {"needle": "needle_paper.needle", "drum": "needle_paper.drum"})


def page_of(out: Path) -> str:
    page = write_report(out).path.read_text(encoding="utf-8")
    assert not Outline(page).open
    return page


def seen(page: str) -> str:
    """What a reader sees, in one line."""
    return " ".join(re.sub(r"<[^>]*>", " ", re.sub("</?(span|code)[^>]*>", "", page[page.index("<body>") :])).split())


def sections(page: str) -> dict[str, str]:
    return dict(re.findall(r'<section id="([^"]*)">(.*?)</section>', page, re.DOTALL))


# What it shows.


def test_page_shows_published_beside_ours(tmp_path: Path):
    later = {"finished": "2026-03-04T05:06:07+00:00", "seconds": 83.4, "cells_from_earlier_run": 3}
    leave(
        tmp_path, "needle", "key1", code=code_version(), **later,
        verdicts=[
            verdict(),
            verdict(quantity="size", published=float("nan"), low=0.0, high=20.0, ours=31.0, uncertainty=0.0, unit="",
                    verdict="differs", why="it grew by 11", source="p. 7", how_read="'small'"),
            verdict(quantity="taste", ours=float("nan"), verdict="not comparable", why="we have no tongue"),
        ],
    )  # fmt: skip
    page = page_of(tmp_path)
    section = html.unescape(seen("<body>" + sections(page)["needle"]))
    assert "Fig. 1: π from needles < 1 & boards" in section
    assert "Buffon 1777 · needle" in section
    assert "What is shown (n = 7 trials)." in section
    assert "speed of light 299.792 Mm/s (299.7 to 299.9) 299.800 ± 0.012 Mm/s ✓ agrees Table 1 printed" in section
    assert "size 0 to 20 31 ≠ differs it grew by 11 p. 7 'small'" in section
    assert "taste 299.792 Mm/s (299.7 to 299.9) – ○ not comparable we have no tongue" in section
    assert "quick, seed 3, 4 cells, 3 of them by an earlier run that was resumed" in section
    assert "1 min 23 s, finished 2026-03-04" in section
    assert "insectnav 0.0.1, Python 3.12.1, Linux, x86_64, 4 cores" in section
    assert "Note" not in section
    assert 'href="needle/key1/"' in page
    again = shlex.join(["insectnav", "run", "needle", "--scale", "quick", "--seed", "3", "--out", str(tmp_path)])
    assert again in section
    head = html.unescape(seen(page[: page.index("<section")]))
    assert "1 of 2 experiments have results" in head
    assert "of their published numbers and claims, 1 agrees, 1 differs, 1 not comparable." in head
    assert f"code {code_version()}" in head
    assert "needle Fig. 1 1 1 1 quick 1 min 23 s" in head


def test_experiments_never_run_are_named_with_their_command(tmp_path: Path):
    out = tmp_path / "it's mine"
    leave(out, "needle")
    section = html.unescape(seen("<body>" + sections(page_of(out))["not-run-yet"]))
    assert "Not run yet Fig. 2: a drum that bursts" in section
    command = section[section.index("insectnav run") :]
    assert shlex.split(command) == ["insectnav", "run", "drum", "--out", str(out)]
    leave(out, "drum")
    assert "not-run-yet" not in sections(page_of(out))


def test_page_is_accessible_and_alone(tmp_path: Path):
    for name in ("needle", "drum"):
        leave(tmp_path, name)
    page = page_of(tmp_path)
    assert page.startswith("<!DOCTYPE html>\n")
    outline = Outline(page)
    assert outline.all("html") == [{"lang": "en"}]
    assert len(outline.all("title")) == len(outline.all("h1")) == len(outline.all("main")) == 1
    identities = [attributes["id"] for _, attributes in outline.elements if "id" in attributes]
    assert len(set(identities)) == len(identities) == 2
    links = [attributes["href"] for attributes in outline.all("a")]
    assert {f"#{name}" for name in identities} <= set(links)
    assert all(attributes["scope"] in {"col", "row"} for attributes in outline.all("th"))
    assert len(outline.all("caption")) == len(outline.all("table")) == 3
    for image in outline.all("img"):
        assert image["src"].startswith("data:image/png;base64,")
        assert image["alt"].startswith("Plot for Fig. ")
        assert (image["width"], image["height"]) == ("4", "3")
    assert not outline.all("script")
    addresses = [attributes.get("src") or attributes.get("href") for _, attributes in outline.elements]
    assert not [address for address in addresses if address and re.match(r"(https?:)?//", address)]
    assert "url(" not in STYLE
    assert "@import" not in STYLE
    [policy] = [meta["content"] for meta in outline.all("meta") if "http-equiv" in meta]
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'unsafe-inline'")


def test_colours_can_be_read():
    """Contrast of at least 4.5 with the palest ground, as WCAG 2.1 (1.4.3) defines and asks."""

    def luminance(colour: str) -> float:
        digits = "".join(2 * digit for digit in colour) if len(colour) == 3 else colour
        parts = [int(digits[i : i + 2], 16) / 255.0 for i in (0, 2, 4)]
        red, green, blue = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    grounds = [luminance(colour) for colour in re.findall(r"background: #(\w+)", STYLE)]
    inks = [luminance(colour) for colour in re.findall(r"[{; ]color: #(\w+)", STYLE)]
    assert len(inks) >= 5
    assert min(grounds) > 0.85
    assert (min(grounds) + 0.05) / (max(inks) + 0.05) >= 4.5


# Which result.


def chosen(out: Path) -> str:
    [(_, result)] = write_report(out).with_results
    return result.run.key


def at(day: int) -> str:
    return f"2026-01-{day:02}T00:00:00+00:00"


def test_newest_result_is_shown(tmp_path: Path):
    leave(tmp_path, "needle", "old", finished="2026-01-03T23:00:00+00:00")
    leave(tmp_path, "needle", "new", finished="2026-01-04T00:30:00+02:00")
    leave(tmp_path, "needle", "older", finished=at(2))
    leave(tmp_path, "needle", ".unfinished", finished=at(9))
    assert chosen(tmp_path) == "old"  # the other was finished at half past ten of that day, by the same clock
    leave(tmp_path, "needle", "newest", finished=at(5))
    assert chosen(tmp_path) == "newest"


def test_full_scale_comes_before_quick_by_the_same_code(tmp_path: Path):
    leave(tmp_path, "needle", "full", scale="full", finished=at(1))
    leave(tmp_path, "needle", "quick", finished=at(2))
    assert chosen(tmp_path) == "full"
    leave(tmp_path, "needle", "changed", code="1" * 12, finished=at(3))
    assert chosen(tmp_path) == "changed"


def test_result_by_other_code_says_so(tmp_path: Path):
    leave(tmp_path, "needle", code="1" * 12)
    page = page_of(tmp_path)
    assert f"another version of the code ({'1' * 12}) than the present one ({code_version()})" in page
    assert "quick (other code)" in page


# Whole or not at all.


def nothing(out: Path) -> None:
    out.mkdir()


def only_broken(out: Path) -> None:
    (out / "needle" / "abc").mkdir(parents=True)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda out: None, "is no folder, expected one that insectnav run wrote to"),
        (lambda out: out.write_text(""), "is no folder"),
        (nothing, "holds no results, expected some"),
        (only_broken, "is left out: provenance.json is missing.*, expected some"),
        (lambda out: leave(out / ".hidden", "needle"), "is no folder|holds no results"),
    ],
)
def test_no_results_are_refused(make: Callable, words: str, tmp_path: Path):
    make(tmp_path / "out")
    with pytest.raises(InputError, match=words) as caught:
        write_report(tmp_path / "out")
    assert_one_sentence(str(caught.value))
    assert not list(tmp_path.rglob("*report*"))


def test_page_is_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    leave(tmp_path, "needle")
    (tmp_path / "report.html").write_text("earlier")

    def refuse(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(report.os, "replace", refuse)
        with pytest.raises(InputError, match=r"cannot be written \(No space left on device\)"):
            write_report(tmp_path)
    assert sorted(os.listdir(tmp_path)) == ["needle", "report.html"]
    assert (tmp_path / "report.html").read_text() == "earlier"
    assert page_of(tmp_path).startswith("<!DOCTYPE html>")
    assert sorted(os.listdir(tmp_path)) == ["needle", "report.html"]


# Words for numbers.


@pytest.mark.parametrize(
    ("ours", "uncertainty", "unit", "text"),
    [
        (25.0353, 2.48858, "deg", "25.0 ± 2.5 deg"),
        (1.14412, 0.00213, "", "1.1441 ± 0.0021"),
        (-12345.6, 321.0, "m", "−1.235e+04 ± 3.2e+02 m"),
        (104.0, 10.4, "steps", "104 ± 10 steps"),
        (3.0, 0.0, "", "3"),
        (3.14159, float("nan"), "rad", "3.142 rad"),
        (float("nan"), 1.0, "deg", "–"),
        (float("-inf"), 1.0, "", "−∞"),
        (1e300, 1.0, "", "1e+300 ± 1"),
        (1.0, 1e-300, "", "1 ± 1e-300"),
    ],
)
def test_error_has_two_digits_and_the_number_as_many_places(ours: float, uncertainty: float, unit: str, text: str):
    assert ours_text(verdict(ours=ours, uncertainty=uncertainty, unit=unit)) == text


def test_published_number_comes_with_what_it_stands_for():
    assert published_text(verdict(published=29.0, low=28.5, high=29.5, unit="deg")) == "29 deg (28.5 to 29.5)"
    assert published_text(verdict(published=-2.0, low=-2.0, high=-2.0, unit="1")) == "−2"
    assert published_text(verdict(published=float("nan"), low=0.0, high=float("inf"), unit="steps")) == "0 to ∞ steps"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.04, "0.0 s"), (59.94, "59.9 s"), (59.96, "1 min 0 s"), (3599.4, "59 min 59 s"), (3600, "1 h 0 min"),
     (90061, "25 h 1 min")],
)  # fmt: skip
def test_durations(seconds: float, text: str):
    assert duration_text(seconds) == text


def test_counts():
    kinds = ["agrees"] * 2 + ["differs"] + ["not comparable"]
    assert counts_text([verdict(verdict=kind) for kind in kinds]) == "2 agree, 1 differs, 1 not comparable"
    assert counts_text([verdict(verdict="differs")] * 2) == "0 agree, 2 differ"
    assert counts_text([]) == "no published number"
