"""How a running run shows itself: a live line on a terminal, one plain line an episode elsewhere."""

from __future__ import annotations

import multiprocessing
import sys
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from curionav_cli.config.schema import Loop


class Report:
    """Counts steps and time; the subclasses show them."""

    def __init__(self, label: str, loop: Loop, first: int):
        self.label = label
        self.episodes, self.steps, self.iterations = loop.episodes, loop.steps, loop.iterations
        self.first = self.episode = first
        self.began = self.episode_began = time.perf_counter()
        self.rate = 0.0  # steps a second of the running or the last episode's acting

    def acted(self, step: int) -> None:
        self.rate = step / max(1e-9, time.perf_counter() - self.episode_began)

    def learned(self, iteration: int) -> None:
        """One more of the K iterations is done."""

    def lived(self, coverage: float, visited: int, total: int) -> None:
        """An episode and its learning are done."""
        self.episode += 1
        self.episode_began = time.perf_counter()

    def left(self) -> str:
        """The time that the episodes still to come will take, judged by those that this process lived."""
        lived = self.episode - self.first
        if not lived:
            return "?"
        seconds = (time.perf_counter() - self.began) / lived * (self.episodes - self.episode)
        return f"{seconds // 3600:.0f} h {seconds // 60 % 60:02.0f} min" if seconds >= 3600 else \
            f"{seconds // 60:.0f} min {seconds % 60:02.0f} s"

    def close(self) -> None:
        """The run is over."""


class PlainReport(Report):
    """One line an episode on standard output."""

    def lived(self, coverage: float, visited: int, total: int) -> None:
        super().lived(coverage, visited, total)
        print(f"{self.label}: episode {self.episode}/{self.episodes}, {self.episode * self.steps} steps, "
              f"{self.rate:.0f} steps/s, coverage {coverage:.1%} ({visited}/{total}), {self.left()} left",
              flush=True)


class LiveReport(Report):
    """One line that is drawn again as the run goes on."""

    def __init__(self, label: str, loop: Loop, first: int):
        super().__init__(label, loop, first)
        self.coverage = "coverage ?"
        console = Console()
        bar = [BarColumn(bar_width=20)] if console.width >= 120 else []
        self.progress = Progress(*bar, TextColumn("{task.description}"), console=console, refresh_per_second=5)
        self.task = self.progress.add_task(label, total=loop.episodes * loop.steps, completed=first * loop.steps)
        self.progress.start()

    def show(self, step: int, doing: str) -> None:
        episode = min(self.episode + 1, self.episodes)
        self.progress.update(self.task, completed=self.episode * self.steps + step, description=(
            f"{self.label} {episode}/{self.episodes}: {doing}, {self.rate:.0f} steps/s, "
            f"{self.coverage}, {self.left()} left"))

    def acted(self, step: int) -> None:
        super().acted(step)
        self.show(step, f"step {step}")

    def learned(self, iteration: int) -> None:
        self.show(self.steps, f"learning {iteration}/{self.iterations}")

    def lived(self, coverage: float, visited: int, total: int) -> None:
        super().lived(coverage, visited, total)
        self.coverage = f"coverage {coverage:.1%}"
        self.show(0, "done")

    def close(self) -> None:
        self.progress.stop()


def report(label: str, loop: Loop, first: int) -> Report:
    """The live line where a person sees it; jobs that run beside each other print plain lines."""
    alone = multiprocessing.parent_process() is None
    kind = LiveReport if alone and sys.stdout.isatty() else PlainReport
    return kind(label, loop, first)
