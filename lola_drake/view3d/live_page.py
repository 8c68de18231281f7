"""The page around a running simulation: Meshcat's scene, and what is told beside it as it runs."""

import json
import threading
from collections.abc import Generator
from html import escape
from http.server import BaseHTTPRequestHandler
from urllib.parse import urlsplit

from lola_drake.view3d.assets import asset
from lola_drake.view3d.door import REFUSED, Door, knows, named, served

QUIET = 5.0
"""After this (s) without news a page is asked whether it is still there."""


class LivePage:
    """Serves one page, and tells all who look at it what is new.

    It only tells: what a user does goes through Meshcat's own controls.

    Attributes:
        url: where the page is.
        token: the secret part of it.
    """

    def __init__(self, host: str, title: str, door: Door, diagram: str = ""):
        """Begin to serve.

        Args:
            host: an address of this machine, the one at which the door is.
            title: of the page.
            door: to Meshcat's scene; this page has the same token.
            diagram: SVG in which ports say their signals.

        Raises:
            OutputError: if the address cannot be used.
        """
        scene = f"{door.port}/?token={door.token}"
        parts = {"TITLE": escape(title), "SCENE": scene, "DIAGRAM": diagram}
        parts |= {"STYLE": asset("live.css"), "SCRIPT": asset("live.js")}
        page = asset("live.html")
        for name, text in parts.items():
            page = page.replace(f"<!--{name}-->", text)
        self._page, self._news = page.encode(), threading.Condition()
        self._told: dict[str, tuple[int, str]] = {}
        self._count = self._watching = 0
        self.token = door.token
        handler = type("Handler", (_Handler,), {"page": self})
        self._server = served(host, range(1), handler)
        self.url = f"http://{named(host)}:{self._server.server_port}/?token={self.token}"

    @property
    def content(self) -> bytes:
        """Return the page."""
        return self._page

    @property
    def watched(self) -> bool:
        """Return whether somebody looks."""
        return self._watching > 0

    def tell(self, kind: str, content: dict) -> None:
        """Tell something to all who look, and the last of its kind to those who come later."""
        text = json.dumps(content, allow_nan=False)
        with self._news:
            self._count += 1
            self._told[kind] = self._count, text
            self._news.notify_all()

    def news(self) -> Generator[str]:
        """Yield what is told, as the events of a stream; an empty one where there is nothing."""
        known = 0
        self._watching += 1
        try:
            while True:
                with self._news:
                    if self._count == known:
                        self._news.wait(QUIET)
                    new = [(n, k, text) for k, (n, text) in self._told.items() if n > known]
                    known = self._count
                yield (
                    "".join(f"event: {k}\ndata: {text}\n\n" for _, k, text in sorted(new))
                    or ":\n\n"
                )
        finally:
            self._watching -= 1

    def close(self) -> None:
        """End the service."""
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    page: LivePage

    def do_GET(self) -> None:  # noqa: N802 (the library's name)
        """Answer what a browser asks for."""
        path = urlsplit(self.path).path
        if path in ("/", "/events") and not knows(self.page.token, self.path):
            self.send_error(403, explain=REFUSED)
        elif path == "/":
            self._head("text/html; charset=utf-8")
            self.wfile.write(self.page.content)
        elif path == "/events":
            self._head("text/event-stream")
            news = self.page.news()
            try:
                for text in news:
                    self.wfile.write(text.encode())
                    self.wfile.flush()
            except OSError:
                pass  # The browser has left.
            finally:
                news.close()
        else:
            self.send_error(404)

    def _head(self, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()

    def log_message(self, *_) -> None:
        """Write nothing on the terminal."""
