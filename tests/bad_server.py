"""An S3 service of the tests' own, in memory, that misbehaves on request.

It shows what arrived of an upload that broke off, as s3rver does; ignores conditions and signatures, as many do; and
takes `faults`: what it does with the next requests.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape


@dataclass
class Fault:
    """Applies to `times` requests of `method` whose key contains `part`."""

    kind: str  # truncate, flip, empty, drop, lose, status, slow
    method: str = "PUT"
    part: str = ""
    times: int = 1
    status: int = 503
    code: str = "SlowDown"


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: BadServer

    def log_message(self, format: str, *args: object) -> None:
        self.server.log.append(format % args)

    def handle_one_request(self) -> None:
        try:
            super().handle_one_request()
        except ConnectionError:
            self.close_connection = True

    def do_PUT(self) -> None:
        raw = self.rfile.read(int(self.headers["Content-Length"]))
        fault = self.fault()
        if fault and fault.kind == "lose":
            return self.answer(200)
        spoil: dict[str, Callable[[bytes], bytes]] = {
            "truncate": lambda raw: raw[:len(raw) // 3], "empty": lambda raw: b"",
            "drop": lambda raw: raw[:len(raw) // 2], "flip": flipped}
        if not fault or fault.kind in spoil:
            self.server.objects[self.key] = spoil[fault.kind](raw) if fault else raw
        if fault and fault.kind == "drop":
            return self.hang_up()
        return self.refuse(fault) if fault and fault.kind == "status" else self.answer(200)

    def do_GET(self) -> None:
        fault, query = self.fault(), parse_qs(urlsplit(self.path).query)
        if fault and fault.kind == "status":
            return self.refuse(fault)
        if "list-type" in query:
            return self.list(query.get("prefix", [""])[0])
        raw = self.server.objects.get(self.key)
        if raw is None:
            return self.answer(404, b"<Error><Code>NoSuchKey</Code></Error>")
        if fault and fault.kind == "slow":
            return self.dribble(raw)
        if fault and fault.kind == "flip":
            raw = flipped(raw)
        return self.answer(200, raw)

    do_HEAD = do_GET

    def do_DELETE(self) -> None:
        self.server.objects.pop(self.key, None)
        self.answer(204)

    def list(self, prefix: str) -> None:
        bucket = self.key.partition("/")[0]
        keys = [key.partition("/")[2] for key in sorted(self.server.objects) if key.startswith(f"{bucket}/{prefix}")]
        rows = "".join(f"<Contents><Key>{escape(key)}</Key><Size>{len(self.server.objects[f'{bucket}/{key}'])}</Size>"
                       "<LastModified>2026-01-01T00:00:00.000Z</LastModified></Contents>" for key in keys)
        self.answer(200, f"<ListBucketResult><Name>{bucket}</Name><IsTruncated>false</IsTruncated>{rows}"
                         "</ListBucketResult>".encode())

    @property
    def key(self) -> str:
        return unquote(urlsplit(self.path).path).lstrip("/")

    def fault(self) -> Fault | None:
        for fault in self.server.faults:
            if fault.times and fault.method == self.command and fault.part in self.path:
                fault.times -= 1
                return fault
        return None

    def answer(self, status: int, raw: bytes = b"") -> None:
        self.send_response(status)
        self.send_header("Content-Length", str(len(raw)))
        self.send_header("ETag", '"0"')
        self.send_header("Last-Modified", "Thu, 01 Jan 2026 00:00:00 GMT")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(raw)

    def refuse(self, fault: Fault) -> None:
        self.answer(fault.status, f"<Error><Code>{fault.code}</Code><Message>{self.headers}</Message></Error>".encode())

    def dribble(self, raw: bytes) -> None:
        self.send_response(200)
        self.send_header("Content-Length", str(len(raw)))
        self.send_header("ETag", '"0"')
        self.send_header("Last-Modified", "Thu, 01 Jan 2026 00:00:00 GMT")
        self.end_headers()
        for byte in raw:
            self.wfile.write(bytes([byte]))
            time.sleep(0.02)

    def hang_up(self) -> None:
        self.close_connection = True
        self.connection.close()


def flipped(raw: bytes) -> bytes:
    """One bit of it is another one."""
    at = min(50, len(raw) // 2)
    return raw[:at] + bytes([raw[at] ^ 4]) + raw[at + 1:]


class BadServer(ThreadingHTTPServer):
    """objects: bucket/key -> bytes; log: requests as a server's log has them."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.objects: dict[str, bytes] = {}
        self.faults: list[Fault] = []
        self.log: list[str] = []

    @property
    def endpoint(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"

    @contextmanager
    def running(self):
        thread = threading.Thread(target=self.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
        thread.start()
        try:
            yield self
        finally:
            self.shutdown()
            self.server_close()
            thread.join()
