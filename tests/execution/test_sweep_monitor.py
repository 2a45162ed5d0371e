"""A sweep as it is shown while it works, read from what its runs write."""

from __future__ import annotations

import io
import threading
import time
from pathlib import Path

import pytest
from rich.console import Console
from rich.live import Live

from curionav_cli.config.compose import Plan
from curionav_cli.execution import sweep_monitor
from curionav_cli.execution.sweep_monitor import SweepMonitor
from curionav_cli.storage.run_folder import RunFolder


def set_status(folder: Path, name: str, **status: object) -> None:
    (folder / name).mkdir(exist_ok=True)
    RunFolder(folder / name).set_status(**status)


@pytest.fixture
def sweep(tmp_path: Path) -> SweepMonitor:
    set_status(tmp_path, "0_a", state="done", episode=4, episodes=4, coverage=0.5)
    set_status(tmp_path, "1_a", state="running", episode=1, episodes=4, coverage=0.125)
    set_status(tmp_path, "2_a", state="failed", iteration=7, iterations=9, error="the disk is full")
    return SweepMonitor(tmp_path, 5)


def drawn(monitor: SweepMonitor, height: int) -> list[str]:
    text = io.StringIO()
    Console(file=text, width=120).print(monitor.table(height))
    return [line.rstrip() for line in text.getvalue().splitlines()]


def test_changes_are_reported_once(sweep: SweepMonitor, tmp_path: Path) -> None:
    assert sweep.update() == ["0_a", "1_a", "2_a"]
    assert sweep.update() == []
    assert sweep.count() == "5 runs: 1 running, 1 failed, 1 done, 2 waiting"
    assert sweep.line("1_a") == "1_a: running, 1/4, coverage 12.5%"
    assert sweep.line("2_a") == "2_a: failed, 7/9: the disk is full"
    set_status(tmp_path, "1_a", state="done", episode=4)
    assert sweep.update() == ["1_a"]


def test_a_status_that_cannot_be_read_just_now_is_read_the_next_time(sweep: SweepMonitor, tmp_path: Path) -> None:
    (tmp_path / "0_a" / "status.json").write_text("{")
    assert sweep.update() == ["1_a", "2_a"]


def test_what_works_and_what_failed_comes_first(sweep: SweepMonitor) -> None:
    sweep.update()
    lines = drawn(sweep, height=40)
    assert [line.split()[0] for line in lines] == ["1_a", "2_a", "0_a", "5"]
    assert lines[0].split() == ["1_a", "running", "1/4", "12.5%", "?", "left"]
    assert "the disk is full" in lines[1]
    assert [line.split()[0] for line in drawn(sweep, height=4)] == ["1_a", "2_a", "5"]


def test_time_left_is_judged_by_what_was_seen(sweep: SweepMonitor, tmp_path: Path,
                                              monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(sweep_monitor.time, "monotonic", lambda: now[0])
    sweep.update()
    now[0] += 60.0
    set_status(tmp_path, "1_a", episode=2)
    sweep.update()
    assert sweep.left("1_a") == "2 min 00 s"


def test_off_a_terminal_a_line_for_each_change(sweep: SweepMonitor, tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    with sweep_monitor.monitored(Plan([], True, tmp_path, [[]] * 5, beside=True)):
        pass
    out = capsys.readouterr().out.splitlines()
    assert out[0] == "0_a: done, 4/4, coverage 50.0%" and out[-1].startswith("5 runs: ")


def test_on_a_terminal_a_table_that_is_drawn_again(sweep: SweepMonitor) -> None:
    screen, over = io.StringIO(), threading.Event()
    with Live(console=Console(file=screen, force_terminal=True, width=120, height=30), auto_refresh=False) as live:
        thread = threading.Thread(target=sweep_monitor.keep_updating, args=(sweep, over, live))
        thread.start()
        while "1_a" not in screen.getvalue():
            time.sleep(0.01)
        over.set()
        thread.join()
    assert "5 runs: 1 running" in screen.getvalue()


def test_a_run_in_this_process_shows_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = threading.active_count()
    with sweep_monitor.monitored(Plan([], True, tmp_path, [[]] * 5)):
        assert threading.active_count() == before
    assert capsys.readouterr().out == ""
