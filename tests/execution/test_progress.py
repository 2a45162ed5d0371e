"""The live line and the plain one, without a terminal and without waiting."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from curionav_cli.config.schema import Keep, Loop
from curionav_cli.execution import progress


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A clock that stands at clock[0] seconds."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now[0])
    return now


def test_a_plain_line_tells_speed_coverage_and_time_left(
        clock: list[float], capsys: pytest.CaptureFixture[str]) -> None:
    report = progress.ExploreProgress(progress.PlainLine("random seed 0", 4, 10), Loop(500, 100, 10, 2, None, Keep.all))
    clock[0] = 2.0
    report.acted(500)
    clock[0] = 60.0
    report.episode_done(2471, 0.25, 25, 100)
    assert capsys.readouterr().out == (
        "random seed 0: episode 5/10, 2471 steps, 250 steps/s, coverage 25.0% (25/100), 5 min 00 s left\n")


def test_a_training_tells_its_iterations(clock: list[float], capsys: pytest.CaptureFixture[str]) -> None:
    report = progress.TrainProgress(progress.PlainLine("lbs_dreamer seed 0", first=100, total=400))
    clock[0] = 50.0
    report.learned(100)
    report.trained(200)
    assert capsys.readouterr().out == (
        "lbs_dreamer seed 0: iteration 200/400, 2.0 iterations/s, 1 min 40 s left\n")


def test_hours_are_written_as_hours(clock: list[float]) -> None:
    report = progress.PlainLine("random seed 0", first=0, total=101)
    clock[0] = 120.0
    report.finished(1, "episode 1")
    assert report.left() == "3 h 20 min"


def test_the_live_line_fits_eighty_columns_and_has_no_colour_if_none_is_wanted(
        clock: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    monkeypatch.setattr(progress, "Console", lambda: Console(file=screen, force_terminal=True, width=80))
    line = progress.LiveLine("lbs_dreamer seed 0", 0, 20)
    report = progress.ExploreProgress(line, Loop(500, 100, 20, 2, None, Keep.all))
    clock[0] = 1.0
    report.acted(250)
    report.learned(40)
    report.episode_done(1000, 0.5, 50, 100)
    report.line.close()
    lines = [line for line in screen.getvalue().splitlines() if "lbs_dreamer" in line]
    assert "coverage 50.0%" in lines[-1] and "steps/s" in lines[-1] and "left" in lines[-1]
    assert "\x1b[3" not in screen.getvalue()  # no colour: the tests run with NO_COLOR


@pytest.mark.parametrize(("terminal", "kind", "said"), [(True, progress.Line, ""), (False, progress.PlainLine, "hm\n")])
def test_jobs_that_run_beside_each_other_leave_a_terminal_to_the_overview(
        monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], terminal: bool, kind: type,
        said: str) -> None:
    monkeypatch.setattr(progress.sys.stdout, "isatty", lambda: terminal, raising=False)
    monkeypatch.setattr(progress.multiprocessing, "parent_process", lambda: object())
    assert type(progress.line("x", 0, 1)) is kind
    progress.say("hm")
    assert capsys.readouterr().out == said
