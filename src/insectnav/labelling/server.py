"""The page for labelling, served to this machine alone.

It listens on 127.0.0.1, and every address begins with a secret, so that no other program and no page of another site
can ask for a picture or leave a mask. What it gives away are five files of its own and the pictures of the desk, by
number; what it takes are strokes, of no more bytes than the picture has pixels.
"""

import json
import secrets
import sys
import threading
import time
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

from insectnav.checks import InputError
from insectnav.labelling.desk import Desk
from insectnav.labelling.masks import load_kernel

HOSTS = ("127.0.0.1", "localhost")
FILES = {"": "index.html"} | {name: name for name in ("label.js", "painting.js", "talk.js", "label.css")}
TYPES = {"html": "text/html", "js": "text/javascript", "css": "text/css"}
SLACK = 2**16  # [byte] by which packed strokes may be longer than unpacked ones
PATIENCE = 4.0  # [s] after the last page was closed, which may only have been loaded again
BEAT = 0.5  # [s] between signs of life to the page
SILENCE = 30.0  # [s] after which a connection is given up
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class LabelServer(ThreadingHTTPServer):
    """A page for the pictures of a desk, at an address nobody can guess, on a free port.

    Parameters
    ----------
    desk : Desk
    patience_s : how long to wait for a page after the last was closed
    """

    daemon_threads = True
    block_on_close = False
    timeout = 0.1  # [s] between looks at whether to end

    def __init__(self, desk: Desk, patience_s: float = PATIENCE) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.desk = desk
        self.patience_s = patience_s
        self.secret = secrets.token_urlsafe(24)
        self.is_ending = False
        self._pages = 0
        self._closed_at = float("inf")
        self._count = threading.Lock()

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://127.0.0.1:{self.server_port}/{self.secret}/"

    def serve(self) -> None:
        """Serve until the page ends it, or stays closed."""
        threading.Thread(target=load_kernel, daemon=True).start()
        try:
            while not self.is_ending and time.monotonic() < self._closed_at + self.patience_s:
                self.handle_request()
        finally:
            self.is_ending = True
            self.server_close()

    def end(self) -> None:
        """Let `serve` return."""
        self.is_ending = True

    def page_opened(self) -> None:
        """Count a page that listens."""
        with self._count:
            self._pages += 1
            self._closed_at = float("inf")

    def page_closed(self) -> None:
        """Count it off again; from the last one on, time runs."""
        with self._count:
            self._pages -= 1
            if self._pages == 0:
                self._closed_at = time.monotonic()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that hangs up."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    """Answers one browser connection."""

    server: LabelServer
    protocol_version = "HTTP/1.1"
    timeout = SILENCE

    def do_GET(self) -> None:
        """Files of the page, and what is on the desk."""
        match self._place():
            case [name] if name in FILES:
                content = files("insectnav.labelling").joinpath("page", FILES[name]).read_bytes()
                self._answer(content, f"{TYPES[FILES[name].rpartition('.')[2]]}; charset=utf-8")
            case ["desk"]:
                desk = self.server.desk
                self._answer_json({"pictures": desk.contents(), "folder": str(desk.folder)})
            case ["picture", number] if self._is_number(number):
                self._try(lambda: self._answer(self.server.desk.jpeg(int(number)), "image/jpeg"))
            case ["strokes", number] if self._is_number(number):
                self._try(lambda: self._answer_packed(self.server.desk.packed_strokes(int(number))))
            case ["alive"]:
                self._stay()
            case _:
                self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here")

    def do_POST(self) -> None:
        """Strokes to be grown or saved, and the end."""
        match self._place():
            case ["grow", number] if self._is_number(number):
                self._try(lambda: self._answer_packed(self.server.desk.grow(int(number), self._strokes(int(number)))))
            case ["save", number] if self._is_number(number):
                self._try(lambda: self._save(int(number)))
            case ["finish"]:
                self._answer_json({})
                self.server.end()
            case _:
                self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here")

    def log_message(self, format: str, *args: Any) -> None:
        """Keep quiet."""

    def _place(self) -> list[str]:
        """Parts of the address after the secret; none if the request may not be answered."""
        host = (self.headers.get("Host") or "").rpartition(":")[0]
        origin = self.headers.get("Origin")
        is_ours = host in HOSTS and origin in (None, f"http://{self.headers['Host']}")
        _, _, rest = self.path.partition("/")
        secret, _, place = rest.partition("/")
        is_known = secrets.compare_digest(secret.encode(), self.server.secret.encode())
        return place.split("/") if is_ours and is_known and rest != secret else []

    def _is_number(self, text: str) -> bool:
        return text.isascii() and text.isdigit() and len(text) < 8 and int(text) < len(self.server.desk.pictures)

    def _strokes(self, number: int) -> bytes:
        """The body of the request, if it is no longer than strokes can be."""
        length = self.headers.get("Content-Length") or ""
        if not (length.isascii() and length.isdigit() and len(length) < 12):
            raise InputError("strokes come without their length")
        if int(length) > self.server.desk.n_pixels(number) + SLACK:
            raise InputError("strokes have more bytes than the picture has pixels")
        return self.rfile.read(int(length))

    def _save(self, number: int) -> None:
        saved = self.server.desk.save(number, self._strokes(number))
        self._answer_json({"mask": str(saved.mask), **saved.shares._asdict()})

    def _stay(self) -> None:
        """Give signs of life until the page is closed or all ends."""
        self._start(HTTPStatus.OK, "text/event-stream", None)
        self.server.page_opened()
        try:
            while not self.server.is_ending:
                self.wfile.write(b": alive\n\n")
                time.sleep(BEAT)
        finally:
            self.server.page_closed()

    def _try(self, answer: Callable[[], None]) -> None:
        """Answer, or say in a sentence why not."""
        try:
            answer()
        except InputError as error:
            self._refuse(HTTPStatus.BAD_REQUEST, str(error))

    def _refuse(self, status: HTTPStatus, sentence: str) -> None:
        self.close_connection = True  # what else came with the request is not read
        self._answer(json.dumps({"error": sentence}).encode(), "application/json", status)

    def _answer_json(self, value: dict[str, Any]) -> None:
        self._answer(json.dumps(value).encode(), "application/json")

    def _answer_packed(self, content: bytes | None) -> None:
        if content is None:
            self._answer(b"", "application/octet-stream", HTTPStatus.NO_CONTENT)
        else:
            self._answer(content, "application/octet-stream")

    def _answer(self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self._start(status, kind, len(content))
        self.wfile.write(content)

    def _start(self, status: HTTPStatus, kind: str, length: int | None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        if self.close_connection or length is None:
            self.close_connection = True
            self.send_header("Connection", "close")
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.end_headers()
