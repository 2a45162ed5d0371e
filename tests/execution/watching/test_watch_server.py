"""The server of curionav watch: this machine alone, GET alone; in a browser quiet, and narrow enough for a phone."""

from __future__ import annotations

import http.client
import json
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser
from entry import Cli
from test_watched import begun, fingerprint, more

from curionav_cli.execution.watching.server import Server
from curionav_cli.execution.watching.watched import Watched


@pytest.fixture
def sweep(tmp_path: Path, a_plan, an_episode) -> Path:
    folder = tmp_path / "a <b> & sweep"
    begun(folder / "0_done", a_plan, 3, an_episode, state="done")
    begun(folder / "1_failed <i>", a_plan, 1, an_episode, state="failed", error="<script>alert(1)</script>")
    (folder / "2_waiting" / ".hydra").mkdir(parents=True)
    return folder


@pytest.fixture
def server(sweep: Path) -> Iterator[Server]:
    opened = Server(Watched(sweep), 0)
    thread = threading.Thread(target=opened.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    yield opened
    opened.shutdown()
    thread.join()
    opened.server_close()


def ask(server: Server, path: str, method: str = "GET", **headers: str) -> tuple[int, dict[str, str], bytes]:
    connection = http.client.HTTPConnection(*server.server_address[:2], timeout=20)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, {name.lower(): value for name, value in answer.getheaders()}, body


def test_it_listens_on_this_machine_alone(server: Server) -> None:
    assert server.server_address[0] == "127.0.0.1"


def test_the_page_and_its_parts(server: Server) -> None:
    status, headers, body = ask(server, "/")
    assert status == 200 and b"a &lt;b&gt; &amp; sweep" in body and b"<style" not in body
    assert headers["content-security-policy"].startswith("default-src 'none'; script-src 'self'; style-src 'self'")
    assert "unsafe" not in headers["content-security-policy"] and headers["x-content-type-options"] == "nosniff"
    for part, kind in (("style.css", "text/css"), ("watch.css", "text/css"), ("sort.js", "text/javascript"),
                       ("watch.js", "text/javascript"), ("state.json", "application/json"),
                       ("heatmap.png?run=0_done", "image/png"), ("camera.png?run=1_failed%20%3Ci%3E", "image/png")):
        status, headers, body = ask(server, f"/{part}")
        assert status == 200 and headers["content-type"].startswith(kind)
        assert len(body) == int(headers["content-length"]) > 0


@pytest.mark.parametrize("path", [
    "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/0_done/config.yaml", "/status.json",
    "/heatmap.png?run=../0_done", "/heatmap.png?run=%2e%2e%2f0_done", "/heatmap.png", "/camera.png?run=2_waiting",
    "/x/heatmap.png?run=0_done", "/heatmap.css", "/style.css/.."])
def test_no_path_names_a_file(server: Server, path: str) -> None:
    status, _, body = ask(server, path)
    assert (status, body) == (404, b"There is nothing here.\n")


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "HEAD", "TRACE", "PROPFIND"])
def test_only_get_is_answered(server: Server, method: str) -> None:
    status, headers, _ = ask(server, "/state.json", method)
    assert status == 405 and headers["allow"] == "GET"


@pytest.mark.parametrize("host, status", [
    ("127.0.0.1:1234", 200), ("localhost", 200), ("LOCALHOST:80", 200), ("evil.example", 421),
    ("evil.example:8787", 421), ("127.0.0.1.evil.example", 421), ("", 421), ("[::1]", 421)])
def test_a_rebound_name_is_refused(server: Server, host: str, status: int) -> None:
    assert ask(server, "/state.json", Host=host)[0] == status


def test_what_the_browser_has_is_not_sent_again(server: Server) -> None:
    tag = ask(server, "/state.json")[1]["etag"]
    status, _, body = ask(server, "/state.json", **{"If-None-Match": tag})
    assert (status, body) == (304, b"")


def test_nothing_is_written(server: Server, sweep: Path) -> None:
    before = fingerprint(sweep)
    for path in ("/", "/state.json", "/heatmap.png?run=0_done", "/camera.png?run=0_done"):
        assert ask(server, path)[0] == 200
    assert ask(server, "/state.json", "DELETE")[0] == 405
    assert fingerprint(sweep) == before


def test_a_taken_port_and_no_run_are_a_line_each(cli: Cli, server: Server, sweep: Path, tmp_path: Path) -> None:
    answer = cli("watch", str(sweep), "--port", str(server.server_address[1]))
    assert answer.code == 2 and "is taken. Name another, or 0 for any" in answer.error
    assert len(answer.error.splitlines()) == 1
    answer = cli("watch", str(tmp_path / "nothing"))
    assert answer.code == 2 and answer.error == f"There is no folder {tmp_path / 'nothing'}.\n"
    assert cli("watch", str(tmp_path)).code == 2
    assert cli("watch", str(sweep), "--port", "70000").code == 2


def test_ctrl_c_ends_it(sweep: Path) -> None:
    with subprocess.Popen([sys.executable, "-m", "curionav_cli", "watch", str(sweep), "--port", "0"],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as process:
        assert process.stdout is not None and process.stderr is not None
        assert process.stdout.readline() == "3 runs: 1 done, 1 failed, 1 waiting\n"
        url = process.stdout.readline().split()[0]
        with socket.create_connection(("127.0.0.1", int(url.strip("/").rpartition(":")[2]))):  # which stays silent
            process.send_signal(signal.SIGINT)
            assert process.wait(20) == 0 and process.stderr.read() == ""


@pytest.mark.browser
def test_in_a_browser_it_grows_is_quiet_and_narrow(browser: Browser, server: Server, sweep: Path, an_episode) -> None:
    shown = browser.new_page(viewport={"width": 375, "height": 812})
    said: list[str] = []
    asked: list[str] = []
    shown.on("console", lambda message: said.append(message.text))
    shown.on("pageerror", lambda error: said.append(str(error)))
    shown.on("request", lambda request: asked.append(request.url))
    shown.goto(server.url)
    shown.wait_for_function("() => document.querySelectorAll('#runs tbody tr').length === 3")
    shown.wait_for_function("() => document.getElementById('heatmap').naturalWidth > 300")
    assert shown.evaluate("document.documentElement.scrollWidth") == 375
    assert shown.evaluate("document.querySelector('h1').innerText") == "a <b> & sweep"
    assert "<script>alert(1)</script>" in shown.locator("#runs").inner_text()
    shown.get_by_role("button", name="1_failed <i>").click()
    assert "failed, 1/10" in shown.locator("#about").inner_text()
    watched: Any = server.watched.runs["1_failed <i>"].folder
    before = shown.evaluate("document.getElementById('heatmap').src")
    more(watched, 1, an_episode)
    watched.set_status(state="done", episode=2)
    shown.wait_for_function("() => document.getElementById('about').innerText.startsWith('done, 2/10')")
    assert shown.evaluate("document.getElementById('heatmap').src") != before
    shown.select_option("#metric", "seconds_acting")
    shown.wait_for_function("() => last.metric === 'seconds_acting'")
    shown.get_by_role("button", name="coverage").click()
    order = "[...document.querySelectorAll('#runs tbody tr')].map(row => row.cells[0].innerText.trim()[0]).join('')"
    assert shown.evaluate(order) == "102"
    assert not said and all(url.startswith((server.url, "data:")) for url in asked)
    assert json.loads(server.watched.state())["newest"] == "1_failed <i>"
