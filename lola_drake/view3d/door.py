"""The door to Meshcat: only a page whose address has the token may look and steer.

Meshcat itself takes orders from every page that finds it, also from a stranger's that is open in
the same browser. So it listens where nobody looks, and this server in front of it passes on what
those ask for who know the token, which nobody does who was not told the address.
"""

import hmac
import http.client
import secrets
import socket
import threading
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

from lola_drake.errors import OutputError, shown
from lola_drake.view3d.assets import with_script
from lola_drake.view3d.messages import sound_frames

PORTS = range(7000, 7100)
"""Where Meshcat's pages usually are; the first free one is taken."""

EVERYWHERE = "*"
"""The host that means every address of this machine."""

PAGES = "/", "/index.html", "/meshcat.html"
"""The paths of Meshcat's page."""

REFUSED = "Open the address that the program has printed: it has a token.\n"


class Door:
    """Passes on to a Meshcat what comes with the token.

    Attributes:
        token: the secret part of the address.
        port: where the door is.
        url: the whole address of Meshcat's page.
    """

    def __init__(self, host: str, inside: str):
        """Begin to serve.

        Args:
            host: an address of this machine, or `EVERYWHERE`.
            inside: the address of Meshcat's page.

        Raises:
            OutputError: if the host is none, or has no free port.
        """
        self.token = secrets.token_urlsafe(16)
        page = urlsplit(inside)
        place = page.hostname, page.port
        handler = type("Handler", (_Handler,), {"token": self.token, "inside": place})
        self._server = served(host, PORTS, handler)
        self.port = self._server.server_port
        self.url = f"http://{named(host)}:{self.port}/?token={self.token}"

    def close(self) -> None:
        """End the service."""
        self._server.shutdown()
        self._server.server_close()


def served(host: str, ports: range, handler: type[BaseHTTPRequestHandler]) -> ThreadingHTTPServer:
    """Return a server that runs in a thread, at the first free port.

    Raises:
        OutputError: if there is none, or no such host.
    """
    for port in ports:
        with suppress(OSError, ValueError):
            server = ThreadingHTTPServer(("" if host == EVERYWHERE else host, port), handler)
            server.daemon_threads = True
            threading.Thread(target=server.serve_forever, daemon=True).start()
            return server
    raise OutputError(f"no page can be shown at {shown(host)}: no such address, or no free port")


def named(host: str) -> str:
    """Return what to call a host in an address."""
    return "localhost" if host == EVERYWHERE else host


def knows(token: str, path: str) -> bool:
    """Return whether what is asked for comes with a token."""
    given = parse_qs(urlsplit(path).query).get("token", [""])[0]
    return hmac.compare_digest(given.encode(), token.encode())


class _Handler(BaseHTTPRequestHandler):
    token: str
    inside: tuple[str, int]

    def do_GET(self) -> None:  # noqa: N802 (the library's name)
        """Pass on what a browser asks for: the page and its socket with the token alone."""
        wants_socket = "upgrade" in self.headers.get("Connection", "").lower()
        path = urlsplit(self.path).path
        if (wants_socket or path in PAGES) and not knows(self.token, self.path):
            self.send_error(403, explain=REFUSED)
        elif wants_socket:
            self._pass_socket()
        else:
            self._pass_file(path)

    def _pass_file(self, path: str) -> None:
        """Answer with one of Meshcat's files; the next request is looked at anew."""
        connection = http.client.HTTPConnection(*self.inside, timeout=30)
        try:
            connection.request("GET", path)
            answer = connection.getresponse()
            content = answer.read()
            if path in PAGES and answer.status == HTTPStatus.OK:
                content = with_script(content.decode(), "sky.js").encode()
            self.send_response(answer.status)
            self.send_header("Content-Type", answer.getheader("Content-Type", "text/html"))
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)
        except (OSError, http.client.HTTPException):
            self.close_connection = True  # One of both has left.
        finally:
            connection.close()

    def _pass_socket(self) -> None:
        """Pass on what Meshcat says, and what is sound of what the page says, until one ends."""
        self.close_connection = True
        with suppress(OSError):
            inside = socket.create_connection(self.inside)
            with inside:
                # Without extensions, such as compression, frames are what they look like.
                headers = {n: v for n, v in self.headers.items() if "Extensions" not in n.title()}
                lines = [f"{name}: {value}" for name, value in headers.items()]
                head = "\r\n".join(["GET / HTTP/1.1", *lines, "", ""])
                inside.sendall(head.encode("latin-1"))
                back = threading.Thread(target=_pour, args=(inside, self.connection), daemon=True)
                back.start()
                # Some of it may have come with the head already.
                for frame in sound_frames(self.rfile):
                    inside.sendall(frame)
                inside.shutdown(socket.SHUT_RDWR)
                back.join(1.0)

    def log_message(self, *_) -> None:
        """Write nothing on the terminal."""


def _pour(source: socket.socket, drain: socket.socket) -> None:
    """Send what comes from a socket to another one."""
    with suppress(OSError):
        while data := source.recv(65536):
            drain.sendall(data)
    with suppress(OSError):
        drain.shutdown(socket.SHUT_RDWR)
