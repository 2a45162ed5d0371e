"""The HTTP server of `curionav watch`: on this machine alone, GET alone, and no path of it names a file.

Another site's page cannot read it: answers are for their own origin, and a Host that is not this machine's is refused,
which a name that was rebound to 127.0.0.1 would send.
"""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from html import escape
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from string import Template
from typing import Any
from urllib.parse import parse_qs, urlsplit

from curionav_cli.execution.watching.watched import Watched
from curionav_cli.results.page import part

HERE = "127.0.0.1"
HOSTS = (HERE, "localhost")  # with any port, as an SSH tunnel may have another
PICTURES = ("heatmap", "camera", "observed", "predicted")
TYPES = {"html": "text/html; charset=utf-8", "css": "text/css; charset=utf-8", "js": "text/javascript; charset=utf-8",
         "json": "application/json", "png": "image/png", "txt": "text/plain; charset=utf-8"}
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
                               "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "Cache-Control": "no-cache",
    "Cross-Origin-Resource-Policy": "same-origin", "Cross-Origin-Opener-Policy": "same-origin",
}


class Server(ThreadingHTTPServer):
    """Serve the page of what is watched. port 0: one that is free. Raises OSError where the port is taken."""

    daemon_threads = True

    def __init__(self, watched: Watched, port: int):
        self.watched = watched
        self.parts = {f"/{name}": part(name).encode() for name in ("style.css", "sort.js", "watch.css", "watch.js")}
        self.parts["/"] = Template(part("watch.html")).substitute(title=escape(watched.path.name)).encode()
        super().__init__((HERE, port), Handler)

    @property
    def url(self) -> str:
        return f"http://{HERE}:{self.server_address[1]}/"

    def answer(self, path: str, query: dict[str, str]) -> tuple[str, bytes] | None:
        """The kind and the body of what a path names; None where it names nothing."""
        name, _, kind = path.strip("/").rpartition(".")
        if path in self.parts:
            return kind or "html", self.parts[path]
        if path == "/state.json":
            return kind, self.watched.state(query.get("metric", ""))
        if kind == "png" and path == f"/{name}.png" and name in PICTURES:
            drawn = self.watched.picture(name, query.get("run", ""))
            return (kind, drawn) if drawn else None
        return None


class Handler(BaseHTTPRequestHandler):
    """Answer one connection."""

    server: Server
    server_version, sys_version, protocol_version = "curionav", "", "HTTP/1.1"
    timeout = 30.0  # seconds that a silent connection is kept

    def do_GET(self) -> None:
        """Answer with the page, a part of it, the state or a picture."""
        if self.host() not in HOSTS:
            self.refuse(HTTPStatus.MISDIRECTED_REQUEST, f"This is {HERE}, and no other host.")
            return
        parts = urlsplit(self.path)
        found = self.server.answer(parts.path, {key: values[0] for key, values in parse_qs(parts.query).items()})
        if found is None:
            self.refuse(HTTPStatus.NOT_FOUND, "There is nothing here.")
        else:
            self.send(HTTPStatus.OK, *found)

    def __getattr__(self, name: str) -> Callable[[], None]:
        """Refuse every other method, as do_POST."""
        if name.startswith("do_"):
            return lambda: self.refuse(HTTPStatus.METHOD_NOT_ALLOWED, "Only GET is answered.")
        raise AttributeError(name)

    def host(self) -> str:
        """The name in the Host header, without its port; "" where it is not one name."""
        given = self.headers.get_all("Host") or []
        return given[0].strip().lower().rpartition(":")[0] or given[0].strip().lower() if len(given) == 1 else ""

    def refuse(self, status: HTTPStatus, why: str) -> None:
        self.close_connection = True
        self.send(status, "txt", f"{why}\n".encode())

    def send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        """Send an answer; one that the browser has already is not sent again."""
        tag = f'"{sha256(body).hexdigest()[:24]}"'
        known = status is HTTPStatus.OK and self.headers.get("If-None-Match") == tag
        self.send_response(HTTPStatus.NOT_MODIFIED if known else status)
        for name, value in {**HEADERS, "ETag": tag, "Content-Type": TYPES[kind]}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", "0" if known else str(len(body)))
        if status is HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET")
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        if not known and self.command != "HEAD":
            self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        """Print nothing."""

    def handle(self) -> None:
        """Answer until the browser is gone, which is no error."""
        try:
            super().handle()
        except (ConnectionError, TimeoutError):
            self.close_connection = True
