"""What the server of the page answers, and what it does not."""

import http.client
import json
import threading
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from command_line import PATIENCE, until
from insectnav.labelling import desk
from insectnav.labelling.desk import Desk
from insectnav.labelling.server import LabelServer
from insectnav.vision.growcut import grow_cut
from labelling_scene import COLUMNS, ROWS, calls_of, is_sky, leave, picture, read, served, strokes

LABELS = np.select([strokes() == 255, strokes() == 0], [2, 1], 0).astype(np.uint8)
PACKED = zlib.compress(LABELS.tobytes())


@pytest.fixture
def server(tmp_path: Path) -> Iterator[LabelServer]:
    leave(tmp_path, "a.png", "b.tif")
    (tmp_path / "secret.txt").write_text("secret")
    two = Desk([tmp_path / "a.png", tmp_path / "b.tif"], tmp_path / "masks")
    with served(two) as (running, _):
        yield running


def ask(
    server: LabelServer, place: str, body: bytes | None = None, secret: str | None = None, **headers: str
) -> tuple[int, bytes, http.client.HTTPMessage]:
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE)
    path = f"/{server.secret if secret is None else secret}/{place}"
    connection.request("GET" if body is None else "POST", path, body, headers)
    answer = connection.getresponse()
    result = answer.status, answer.read(), answer.headers
    connection.close()
    return result


def test_page_and_pictures(server: LabelServer):
    status, content, headers = ask(server, "")
    assert (status, headers["Content-Type"]) == (200, "text/html; charset=utf-8")
    assert b"<title>insectnav label" in content
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    for name, kind in (("label.js", "javascript"), ("painting.js", "javascript"), ("label.css", "css")):
        status, _, headers = ask(server, name)
        assert (status, headers["Content-Type"]) == (200, f"text/{kind}; charset=utf-8")
    assert json.loads(ask(server, "desk")[1])["pictures"] == [
        {"name": "a.png", "labelled": False},
        {"name": "b.tif", "labelled": False},
    ]
    for number in "01":
        status, content, _ = ask(server, f"picture/{number}")
        assert status == 200
        assert cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR).shape == (ROWS, COLUMNS, 3)
    assert ask(server, "strokes/0")[:2] == (204, b"")


def test_strokes_grow_are_saved_and_come_back(server: LabelServer):
    status, content, _ = ask(server, "grow/1", PACKED)
    labels = np.frombuffer(zlib.decompress(content), np.uint8).reshape(ROWS, COLUMNS)
    assert status == 200
    np.testing.assert_array_equal(labels, grow_cut(picture(np.uint16), LABELS).labels)
    assert not server.desk.folder.exists()
    status, content, _ = ask(server, "save/1", PACKED)
    told = json.loads(content)
    assert told == {"mask": str(server.desk.folder / "b_mask.png"), "unreached": 0} | {
        "sky": is_sky().mean(),
        "ground": (~is_sky()).mean(),
    }
    np.testing.assert_array_equal(read(server.desk.folder / "b_strokes.png"), strokes())
    np.testing.assert_array_equal(read(server.desk.folder / "b_mask.png"), np.where(is_sky(), 255, 0))
    assert zlib.decompress(ask(server, "strokes/1")[1]) == LABELS.tobytes()
    assert [entry["labelled"] for entry in json.loads(ask(server, "desk")[1])["pictures"]] == [False, True]


@pytest.mark.parametrize(
    "place",
    ["secret.txt", "../secret.txt", "picture/../secret.txt", "picture/2", "picture/-1", "picture/a", "picture/",
     "picture/%2e%2e", "picture/0/1", "picture/%b2", "/etc/passwd", "server.py", "grow/0", "../server.py"],
)  # fmt: skip
def test_nothing_else_is_given_away(server: LabelServer, place: str):
    status, content, _ = ask(server, place)
    assert (status, json.loads(content)) == (404, {"error": "there is nothing here"})


@pytest.mark.parametrize(
    ("secret", "headers"),
    [
        ("wrong", {}),
        ("", {}),
        (None, {"Host": "evil.example"}),
        (None, {"Host": "evil.example:80"}),
        (None, {"Origin": "http://evil.example"}),
        (None, {"Origin": "null"}),
    ],
)
def test_who_does_not_know_the_secret_or_comes_from_elsewhere_gets_nothing(
    server: LabelServer, secret: str | None, headers: dict
):
    assert ask(server, "", None, secret, **headers)[0] == 404
    assert ask(server, "finish", b"", secret, **headers)[0] == 404
    assert not server.is_ending


def test_only_this_machine_is_listened_to(server: LabelServer):
    assert server.server_address[0] == "127.0.0.1"
    assert len(server.secret) >= 32
    other = LabelServer(server.desk)
    other.server_close()
    assert other.secret != server.secret


@pytest.mark.parametrize(
    ("body", "headers", "sentence"),
    [
        (b"not packed", {}, "cannot be unpacked"),
        (zlib.compress(bytes(10)), {}, "strokes have 10 bytes or more"),
        (zlib.compress(bytes(60_000_000)), {}, f"have {ROWS * COLUMNS + 1} bytes or more"),
        (zlib.compress(bytes([3]) * ROWS * COLUMNS), {}, "labels above 2"),
        (zlib.compress(bytes(ROWS * COLUMNS)), {}, "strokes are 0 everywhere"),
        (b"", {"Content-Length": "1000000"}, "more bytes than the picture has pixels"),
        (b"", {"Content-Length": "-1"}, "without their length"),
        (b"", {"Content-Length": "9" * 30}, "without their length"),
    ],
)
def test_wrong_strokes_are_refused_in_a_sentence(server: LabelServer, body: bytes, headers: dict, sentence: str):
    for action in ("grow", "save"):
        status, content, _ = ask(server, f"{action}/0", body, **headers)
        assert status == 400
        assert sentence in json.loads(content)["error"]
    assert not server.desk.folder.exists()


def test_unreadable_picture_and_strokes_are_told(server: LabelServer):
    server.desk.pictures[1].write_bytes(b"no image")
    status, content, _ = ask(server, "picture/1")
    assert status == 400
    assert "no PNG, JPEG or TIFF picture" in json.loads(content)["error"]
    server.desk.folder.mkdir()
    server.desk.strokes_path(0).write_bytes(b"no image")
    assert ask(server, "strokes/0")[0] == 400
    assert ask(server, "picture/0")[0] == 200


def test_requests_at_once_do_not_mix(server: LabelServer):
    expected = {number: ask(server, f"grow/{number}", PACKED)[1] for number in (0, 1)}
    found: list[tuple[int, bytes]] = []

    def many(number: int) -> None:
        found.extend((number, ask(server, f"grow/{number}", PACKED)[1]) for _ in range(5))

    threads = [threading.Thread(target=many, args=(number,)) for number in (0, 1, 0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 15
    assert all(content == expected[number] for number, content in found)


def test_what_is_being_saved_at_the_end_is_saved_whole_and_nothing_after_it(
    server: LabelServer, monkeypatch: pytest.MonkeyPatch
):
    is_writing, may_write, write = threading.Event(), threading.Event(), desk.write_labels

    def write_late(*given: Any) -> None:
        is_writing.set()
        assert may_write.wait(PATIENCE)
        write(*given)

    monkeypatch.setattr(desk, "write_labels", write_late)
    with ThreadPoolExecutor(2) as on:
        saved = on.submit(ask, server, "save/0", PACKED)
        assert is_writing.wait(PATIENCE)
        closed = on.submit(server.desk.close)
        with pytest.raises(TimeoutError):
            closed.result(0.2)
        may_write.set()
        closed.result(PATIENCE)
        assert [entry.mask for entry in server.desk.saved.values()] == [server.desk.mask_path(0)]
        assert saved.result(PATIENCE)[0] == 200
    status, content, _ = ask(server, "save/1", PACKED)
    assert (status, server.desk.mask_path(1).exists()) == (400, False)
    assert "nothing is saved any more" in json.loads(content)["error"]


def test_finish_ends_the_server(tmp_path: Path):
    leave(tmp_path, "a.png")
    with served(Desk([tmp_path / "a.png"], tmp_path)) as (server, thread):
        assert ask(server, "finish", b"")[0] == 200
        thread.join(PATIENCE)
        assert not thread.is_alive()
        assert server.socket.fileno() == -1  # closed: nobody else can have taken the port before


def test_closing_the_last_page_ends_the_server_and_loading_it_again_does_not(tmp_path: Path):
    leave(tmp_path, "a.png")
    with served(Desk([tmp_path / "a.png"], tmp_path)) as (server, thread):
        closed = calls_of(server, "page_closed")
        for page in [stream(server) for _ in range(2)]:
            page.close()
        until(lambda: len(closed) == 2)
        again = stream(server)
        server.patience_s = 0.0
        thread.join(1.0)
        assert thread.is_alive()
        again.close()
        until(lambda: not thread.is_alive())


def stream(server: LabelServer) -> http.client.HTTPResponse:
    """What an open page listens to."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE)
    connection.request("GET", f"/{server.secret}/alive")
    answer = connection.getresponse()
    assert answer.readline() == b": alive\n"
    connection.close()  # the answer keeps the socket
    return answer
