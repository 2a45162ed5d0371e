"""Progress of a run: a live line on a terminal, elsewhere one plain line for each episode or save.

Runs side by side on one terminal print nothing: sweep_monitor.py shows them all.
"""

from __future__ import annotations

import multiprocessing
import sys
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from curionav_cli.config.schema import Loop
from curionav_cli.results.tables import percent

EVERY = 10  # docking requests between two plain lines


class Line:
    """Count what is done of `total`, from `first` on, and the time; subclasses show it."""

    def __init__(self, label: str, first: int, total: int):
        self.label, self.total = label, total
        self.first = self.done = first
        self.began = time.perf_counter()

    def show(self, done: float, text: str) -> None:
        """Show a state in between; plain lines leave it out."""

    def finished(self, done: int, text: str) -> None:
        """Count `done` as finished, and show it."""
        self.done = done

    def left(self) -> str:
        """The time that the rest will take at this process's pace; ? before the first is done."""
        did = self.done - self.first
        if not did:
            return "?"
        return duration((time.perf_counter() - self.began) / did * (self.total - self.done))

    def close(self) -> None:
        """End the display."""


class PlainLine(Line):
    """A new line on standard output for each finished unit."""

    def finished(self, done: int, text: str) -> None:
        super().finished(done, text)
        print(f"{self.label}: {text}, {self.left()} left", flush=True)


class LiveLine(Line):
    """One line on a terminal, redrawn as the run goes on."""

    def __init__(self, label: str, first: int, total: int):
        super().__init__(label, first, total)
        console = Console()
        bar = [BarColumn(bar_width=20)] if console.width >= 120 else []
        self.progress = Progress(*bar, TextColumn("{task.description}"), console=console, refresh_per_second=5)
        self.task = self.progress.add_task(label, total=total, completed=first)
        self.progress.start()

    def show(self, done: float, text: str) -> None:
        self.progress.update(self.task, completed=done, description=f"{self.label} {text}, {self.left()} left")

    def close(self) -> None:
        self.progress.stop()


def line(label: str, first: int, total: int) -> Line:
    """The kind of line for this output: live on a terminal, none for a job of a sweep there, else plain."""
    kind = (Line if beside() else LiveLine) if sys.stdout.isatty() else PlainLine
    return kind(label, first, total)


def beside() -> bool:
    """Whether this process is one of several that a launcher has started."""
    return multiprocessing.parent_process() is not None


def say(text: str) -> None:
    """Print a line, unless it would break the table of a sweep."""
    if not (beside() and sys.stdout.isatty()):
        print(text, flush=True)


def reached(coverage: float | None, visited: int, total: int | None) -> str:
    """The coverage in words; on a real floor without a map, the number of cells."""
    return f"{visited} cells visited" if coverage is None else f"coverage {percent(coverage)} ({visited}/{total})"


def duration(seconds: float) -> str:
    """A time in words, '3 h 07 min' or '2 min 05 s', to the nearest second."""
    whole = round(seconds)
    return f"{whole // 3600} h {whole // 60 % 60:02} min" if whole >= 3600 else f"{whole // 60} min {whole % 60:02} s"


class ExploreProgress:
    """Progress of a run that acts and learns."""

    def __init__(self, line: Line, loop: Loop):
        self.line, self.loop = line, loop
        self.began = time.perf_counter()
        self.rate = 0.0  # steps a second of the running or the last episode's acting
        self.coverage = "coverage ?"

    def acted(self, step: int) -> None:
        self.rate = step / max(1e-9, time.perf_counter() - self.began)
        self.show(step, f"step {step}")

    def learned(self, iteration: int) -> None:
        self.show(self.loop.steps, f"learning {iteration}/{self.loop.iterations}")

    def episode_done(self, steps: int, coverage: float | None, visited: int, total: int | None) -> None:
        """Show that an episode and its learning are done. steps: of the run so far."""
        episode, self.coverage = self.line.done + 1, reached(coverage, visited, total).partition(" (")[0]
        self.line.finished(episode, f"episode {episode}/{self.loop.episodes}, {steps} steps, "
                                    f"{self.rate:.0f} steps/s, {reached(coverage, visited, total)}")
        self.began = time.perf_counter()
        self.show(0, "done")

    def show(self, step: int, doing: str) -> None:
        done = self.line.done
        self.line.show(done + step / self.loop.steps, (
            f"{min(done + 1, self.loop.episodes)}/{self.loop.episodes}: {doing}, {self.rate:.0f} steps/s, "
            f"{self.coverage}"))


class ServeProgress:
    """Progress of a training server: one plain line for each episode, as their number is open."""

    def __init__(self, done: int):
        self.done = done

    def acted(self, step: int) -> None:
        """Do nothing: the robot acts elsewhere."""

    def learned(self, iteration: int) -> None:
        """Do nothing: the line is printed after the last iteration."""

    def episode_done(self, steps: int, coverage: float | None, visited: int, total: int | None) -> None:
        """Print a line for an episode that was learned from."""
        self.done += 1
        print(f"{self.done} episode{'s' * (self.done != 1)} learned, {reached(coverage, visited, total)}",
              flush=True)


class TrainProgress:
    """Progress of offline training."""

    def __init__(self, line: Line):
        self.line = line
        self.began, self.rate = time.perf_counter(), 0.0

    def learned(self, iteration: int) -> None:
        """Show one more iteration since the last save."""
        self.rate = iteration / max(1e-9, time.perf_counter() - self.began)
        self.line.show(self.line.done + iteration, self.text(self.line.done + iteration))

    def trained(self, done: int) -> None:
        """Show a save after `done` iterations."""
        self.line.finished(done, self.text(done))
        self.began = time.perf_counter()

    def text(self, done: int) -> str:
        return f"iteration {done}/{self.line.total}, {self.rate:.1f} iterations/s"


class DockProgress:
    """Progress of a docking trial."""

    def __init__(self, line: Line, docked: int):
        self.line, self.docked = line, docked

    def request_done(self, success: bool) -> None:
        """Count one more docking request."""
        done, self.docked = self.line.done + 1, self.docked + success
        text = f"request {done}/{self.line.total}, {self.docked} docked ({percent(self.docked / done)})"
        if done % EVERY == 0 or done == self.line.total:
            self.line.finished(done, text)
        else:
            self.line.done = done
        self.line.show(done, text)
