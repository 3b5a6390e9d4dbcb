"""What `insectnav map` says where there is one of a thing: no "1 places", on the page no more than in the terminal."""

import re
from pathlib import Path

import numpy as np
import pytest

from command_line import assert_refused, in_process
from place_scenes import views, write_pictures

SEVERAL = re.compile(
    r"(?<![\d.])1 (?:(?:more )?(?:places|frames|queries|routes|features|notes|steps|files|vectors|are|have|were)"
    r"|of \d+ frames? (?:look|have|were))\b"
)


@pytest.fixture
def run(tmp_path: Path, monkeypatch, capsys):
    run = in_process(tmp_path, monkeypatch, capsys)

    def told(*arguments: str, code: int = 0):
        done = run("map", *arguments)
        assert done.code == code, done.err
        assert not SEVERAL.search(done.out + done.err), done.out + done.err
        return done

    return told


def test_one_frame_one_place_one_query(run, tmp_path: Path):
    write_pictures(tmp_path / "one", views(1))
    (tmp_path / "one" / "notes.txt").write_text("seen from the hill")
    built = run("build", "one", "m")
    assert built.out.startswith("1 frame in ")
    assert "m: 1 place on 1 route, " in built.out
    assert "skipped 1 file that is no frame, such as notes.txt" in built.out
    found = run("locate", "m", "one", "--sequence-length", "1", "--unique-window", "2", "--page", "p.html")
    assert found.out.startswith("1 of 1 frame was found in a map of 1 place.")
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert not SEVERAL.search(re.sub(r"base64,[^\"]*", "", page))
    words = "there is 1 query, expected at least 11 for sequences of 10 steps: fewer frames than a sequence?"
    assert_refused(run("locate", "m", "one", code=2), words)


def test_one_match_that_is_kept_is_right(run, tmp_path: Path):
    header = "query,name,reference,reference_name,route,score,has_sequence\n"
    (tmp_path / "m.csv").write_text(header + "0,a,0,p,0,0.1,1\n1,b,-1,,,,1\n")
    assert run("evaluate", "m.csv", "--same-index").out.startswith(
        "1 of 2 frames was found; of these 1 is right, within 2 frames."
    )


def test_one_frame_that_is_blank_or_alike_or_has_no_position(run, tmp_path: Path):
    pictures = views(30)
    pictures[3] = 77
    pictures[9] = pictures[8]
    write_pictures(tmp_path / "walk", pictures)
    (tmp_path / "where.csv").write_text(
        "\n".join(["file,x_m,y_m", *(f"frame{k}.png,{3 * k if k != 5 else ''},0" for k in range(30))])
    )
    told = run("build", "walk", "m", "--positions", "where.csv", "--every-m", "1").out
    assert "note: 1 frame without a known position is left out, such as frame5" in told
    assert "note: 1 of 29 frames looks just like the one before" in told
    assert "note: 1 of 29 frames has nothing to describe" in told
    np.save(tmp_path / "a.npy", np.arange(30.0)[:, None])
    run("build", "a.npy", "own", "--metric", "euclidean")
    assert (
        "the first and the last query have no match"
        in run("locate", "m", "walk", "--sequence-length", "2", "--out", "n.csv").out
    )
