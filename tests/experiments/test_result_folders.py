"""Folders of results from strangers: what is broken is noted, what is hostile stays text."""

import html
import json
import os
import re
from pathlib import Path
from urllib.parse import unquote_to_bytes

import pytest

from html_outline import Outline
from insectnav import experiments
from insectnav.experiments.report import write_report
from made_results import PROVENANCE, leave, png, verdict
from track_files import assert_one_sentence

EVIL = "\"'></td></figcaption><script>alert(1)</script><img src=x onerror=alert(2)><!--\u202e\x1b[31m&lt;"


@pytest.fixture(autouse=True)
def small_paper(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiments, "_MODULES", {"needle": "needle_paper.needle", "drum": "needle_paper.drum"})


def page_of(out: Path) -> str:
    page = write_report(out).path.read_text(encoding="utf-8")
    assert not Outline(page).open
    return page


def test_hostile_text_stays_text(tmp_path: Path):
    folder = leave(
        tmp_path, "needle", EVIL.replace("/", "|")[:200], code=EVIL[:90], insectnav=EVIL[:90], python=EVIL[:90],
        machine={"system": EVIL[:90], "processor": [EVIL], "cores": EVIL},
        files={"caption.txt": EVIL.encode()},
        verdicts=[verdict(quantity=EVIL, unit=EVIL, why=EVIL, source=EVIL, how_read=EVIL, verdict="differs")],
    )  # fmt: skip
    (tmp_path / "needle" / "<script>alert(3)<|script>").mkdir()
    page = page_of(tmp_path)
    outline = Outline(page)
    assert not outline.all("script")
    assert len(outline.all("img")) == 1
    assert not [name for _, attributes in outline.elements for name in attributes if name.startswith("on")]
    assert "\u202e" not in page
    assert "\x1b" not in page
    assert html.escape(EVIL[:60]) in page
    assert "<script>alert(3)" not in page
    assert "is left out: provenance.json is missing" in page
    [address] = [a["href"] for a in outline.all("a") if a["href"].startswith("needle/")]
    assert re.fullmatch(r"[\w./~%-]+", address)
    assert os.fsdecode(unquote_to_bytes(address)) == f"needle/{folder.name}/"


@pytest.mark.skipif(os.name != "posix", reason="names of files as POSIX has them")
def test_name_that_is_no_text_is_shown_and_linked(tmp_path: Path):
    leave(tmp_path, "needle", os.fsdecode(b"k\xffey"))
    page = page_of(tmp_path)
    assert 'href="needle/k%FFey/"' in page
    assert "needle/k\ufffdey/" in page


def provenance(**other: object) -> bytes:
    return json.dumps(PROVENANCE | {"experiment": "needle", "key": "bad"} | other).encode()


BROKEN = {
    "missing": (None, "provenance.json is missing"),
    "cut": (provenance()[:-20], "provenance.json is not JSON"),
    "bytes": (b"\xff\xfe\x00", "provenance.json is not text"),
    "deep": (b"[" * 100_000, "provenance.json is not JSON"),
    "digits": (b"[" + b"9" * 10_000 + b"]", "provenance.json is not JSON"),
    "list": (b"[]", "provenance.json is not of this experiment"),
    "other": (provenance(experiment="drum"), "provenance.json is not of this experiment"),
    "large": (b" " * 2**20 + provenance(), "provenance.json is larger than 1 MB"),
    "scale": (provenance(scale=["full"]), "provenance.json does not tell scale"),
    "seed": (provenance(seed="<b>"), "provenance.json does not tell seed"),
    "seed and code": (provenance(seed=True, code=7), "provenance.json does not tell seed, code"),
    "long": (provenance(code="a" * 101), "provenance.json does not tell code"),
    "endless": (provenance(seconds=float("inf")), "provenance.json does not tell seconds"),
    "no number": (provenance(seconds=float("nan")), "provenance.json does not tell seconds"),
    "huge": (provenance(seconds=10**400), "provenance.json does not tell seconds"),
    "never": (provenance(finished="yesterday"), "provenance.json does not tell finished"),
    "year 1": (provenance(finished="0001-01-01T00:00:00+14:00"), "provenance.json does not tell finished"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_folder_is_noted_and_left_out(case: str, tmp_path: Path):
    content, words = BROKEN[case]
    leave(tmp_path, "needle", "good")
    broken = leave(tmp_path, "needle", "bad", files={"provenance.json": content or b""})
    if content is None:
        (broken / "provenance.json").unlink()
    written = write_report(tmp_path)
    [note] = written.notes
    assert_one_sentence(note)
    assert note.startswith(f"{str(Path('needle', 'bad'))!r} is left out: {words}")
    assert written.with_results[0][1].run.key == "good"
    assert html.escape(note) in written.path.read_text(encoding="utf-8")


def rows(*lines: str) -> bytes:
    header = "quantity,published,low,high,ours,uncertainty,unit,verdict,why,source,how_read"
    return "\n".join([header, *lines]).encode()


LACKS = {
    "no figure": ("figure.png", None, "is missing"),
    "cut figure": ("figure.png", png()[:-4], "is not a whole PNG image"),
    "other figure": ("figure.png", b"<svg xmlns='http://www.w3.org/2000/svg'/>", "is not a whole PNG image"),
    "large figure": ("figure.png", png() + b"\0" * 20 * 2**20 + png()[-12:], "is larger than 20 MB"),
    "vast figure": ("figure.png", png()[:16] + b"\0\1\0\0" * 2 + png()[24:], "has 65536 × 65536 pixels"),
    "no caption": ("caption.txt", None, "is missing"),
    "no text": ("caption.txt", b"\xff\xff", "is not text"),
    "no table": ("comparison.csv", None, "is missing"),
    "large table": ("comparison.csv", b"," * (2**20 + 1), "is larger than 1 MB"),
    "words for numbers": ("comparison.csv", rows("a,b,c,d,e,f,g,agrees,i,j,k"), "cannot be read"),
    "short row": ("comparison.csv", rows("a,1,1,1,1,1"), "cannot be read"),
    "long row": ("comparison.csv", rows("a,1,1,1,1,1,m,agrees,i,j,k,l"), "cannot be read"),
    "no verdict": ("comparison.csv", rows("a,1,1,1,1,1,m,<i>,i,j,k"), "cannot be read, expected a verdict in each"),
    "other columns": ("comparison.csv", b"a,b\n1,2\n", "has other columns"),
    "no columns": ("comparison.csv", b"\0\0\n", "has other columns"),
    "long cell": ("comparison.csv", rows("a" * 200_000 + ",1,1,1,1,1,m,agrees,i,j,k"), "cannot be read"),
    "many rows": ("comparison.csv", rows(*["a,1,1,1,1,1,m,agrees,,,"] * 1001), "has 1001 rows, expected at most 1000"),
}


@pytest.mark.parametrize("case", LACKS)
def test_what_is_missing_is_noted_and_the_rest_shown(case: str, tmp_path: Path):
    file, content, words = LACKS[case]
    folder = leave(tmp_path, "needle", "abc", files={file: content or b""})
    if content is None:
        (folder / file).unlink()
    written = write_report(tmp_path)
    [note] = written.notes
    assert_one_sentence(note)
    assert note.startswith(f"{str(Path('needle', 'abc', file))!r} {words}")
    page = written.path.read_text(encoding="utf-8")
    assert html.escape(note) in page
    assert ("<img" in page) == (file != "figure.png")
    assert ("What is shown" in page) == (file != "caption.txt")
    assert ("speed of light" in page) == (file != "comparison.csv")
    assert len(page) < 50_000


def test_of_a_huge_file_only_the_beginning_is_read(tmp_path: Path):
    folder = leave(tmp_path, "needle")
    try:
        os.truncate(folder / "figure.png", 2**40)  # a hole, which takes no room on disk but would in memory
    except OSError:
        pytest.skip("no such large files here")
    [note] = write_report(tmp_path).notes
    assert "figure.png' is larger than 20 MB" in note


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with a name")
def test_pipe_is_not_waited_for(tmp_path: Path):
    folder = leave(tmp_path, "needle")
    (folder / "figure.png").unlink()
    os.mkfifo(folder / "figure.png")
    assert write_report(tmp_path).notes == [f"{str(Path('needle', 'abc', 'figure.png'))!r} is missing"]


def test_links_in_a_circle_and_stray_files_do_no_harm(tmp_path: Path):
    leave(tmp_path, "needle")
    (tmp_path / "needle" / "notes.txt").write_text("mine")
    (tmp_path / "needle" / "circle").symlink_to("circle")
    (tmp_path / "drum").write_text("no folder")
    leave(tmp_path, "unknown-experiment")
    assert write_report(tmp_path).notes == []
