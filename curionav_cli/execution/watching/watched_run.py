"""One run that is watched: its state, curve and pictures, read again only where a file has changed."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from curionav_cli.errors import RunFolderError
from curionav_cli.execution.progress import duration
from curionav_cli.execution.sweep_monitor import DONE, PLANNED
from curionav_cli.files import read_arrays
from curionav_cli.records import Prediction
from curionav_cli.results.coverage import Coverage
from curionav_cli.results.labels import scene_name
from curionav_cli.results.watching import pictures
from curionav_cli.results.watching.rows import Rows, stamp
from curionav_cli.storage.pictures import gone, images
from curionav_cli.storage.run_folder import RunFolder


class WatchedRun:
    """A run folder as it grows, also one that is still empty. Nothing is written there."""

    def __init__(self, path: Path):
        self.name, self.folder = path.name, RunFolder(path)
        self.rows = Rows(self.folder.metrics_file)
        self.status: dict[str, Any] = {}
        self.state, self.label, self.seen = "waiting", path.name, (0, 0)
        self.counted: Coverage | None = None
        self.files: list[tuple[int, int]] = []  # stamps of the episodes that were counted
        self.drawn: dict[str, tuple[Any, bytes]] = {}  # kind of a picture -> what it was drawn from, PNG

    def update(self) -> None:
        """Read state and rows again, where they changed."""
        self.rows.update()
        seen = stamp(self.folder.path / "status.json")
        if seen != self.seen or self.state == "running":
            self.read_state()
            self.seen = seen

    def read_state(self) -> None:
        """Read status.json; a broken one is a state too."""
        try:
            self.status = self.folder.status
            self.state = self.folder.state if self.status else "waiting"
        except RunFolderError as error:
            self.status, self.state = {"error": str(error)}, "broken"
        if self.label == self.name and self.folder.config.is_file():
            self.label = label(self.folder) or self.name

    def row(self, metric: str) -> dict[str, Any]:
        """What the page shows of the run in its table and its curve."""
        done, planned = (next((self.status[key] for key in keys if key in self.status), None)
                         for keys in (DONE, PLANNED))
        share, seconds = self.status.get("coverage"), self.seconds_left(done, planned)
        return {"name": self.name, "label": self.label, "state": self.state, "done": done,
                "progress": "" if done is None else f"{done}/{planned}" if planned else str(done),
                "coverage": share, "coverage_text": "" if share is None else f"{share:.1%}",
                "seconds_left": seconds, "left": "" if seconds is None else duration(seconds),
                "error": str(self.status.get("error") or ""), "points": self.rows.points(metric),
                "pictures": self.pictures()}

    def seconds_left(self, done: Any, planned: Any) -> float | None:
        """Seconds that the rest takes at the pace of the last rows; None where that is not known."""
        pace = self.rows.seconds()
        if self.state != "running" or pace is None or not done or not planned:
            return None
        each = pace * len(self.rows.rows) / done  # a row of offline training is of many iterations
        return each * max(0, planned - done)

    # -- pictures ---------------------------------------------------------------------------------

    def newest(self) -> tuple[int, Path] | None:
        """Index and file of the newest episode."""
        index = self.status.get("episode", 0)
        found = [(at, path) for at in (index, index - 1) if at >= 0 and (path := self.folder.episode_path(at)).exists()]
        return found[0] if found and shows(found[0][1], stamp(found[0][1])) else None

    def newest_prediction(self) -> tuple[int, Path] | None:
        """Index and file of the newest prediction whose episode is stored."""
        index = self.status.get("episode", 0)
        for at in range(index, max(-1, index - 11), -1):
            path = self.folder.prediction_path(at)
            if at >= 0 and path.exists() and self.folder.episode_path(at).exists() and shows(path, stamp(path)):
                return at, path
        return None

    def pictures(self) -> dict[str, str | None]:
        """Versions of the pictures, None for one that there is not, and what they show."""
        episode, predicted = self.newest(), self.newest_prediction()
        plan = stamp(self.folder.path / "plan.npz")
        shown = {"heatmap": plan[0] and version(self.folder.metrics_file), "camera": episode and version(episode[1]),
                 "predicted": predicted and version(predicted[1])}
        return {**{kind: found or None for kind, found in shown.items()},
                "heatmap_text": "visits to each cell, logarithmic; blue: start, green: dock" if shown["heatmap"] else
                                "no floor plan yet",
                "camera_text": f"camera, last frame of episode {episode[0]}" if episode else "no episode yet",
                "observed_text": f"observed in episode {predicted[0]}" if predicted else "",
                "predicted_text": "the same frame, predicted before the agent learned from it" if predicted else ""}

    def picture(self, kind: str) -> bytes | None:
        """A picture as PNG: heatmap, camera, observed or predicted; None where there is none.

        Raises RunFolderError where a file is broken.
        """
        source = {"heatmap": version(self.folder.metrics_file), "camera": self.newest()}.get(
            kind, self.newest_prediction() if kind in ("observed", "predicted") else None)
        if source is None:
            return None
        if kind not in self.drawn or self.drawn[kind][0] != source:
            self.drawn[kind] = source, self.draw(kind, source)
        return self.drawn[kind][1]

    def draw(self, kind: str, source: Any) -> bytes:
        if kind == "heatmap":
            return pictures.heatmap(self.coverage())
        if kind == "camera":
            return pictures.png(images(source[1], [-1])[0])
        prediction = Prediction.load(source[1])
        if kind == "predicted":
            return pictures.png(prediction.image[-1, -1])
        return pictures.png(images(self.folder.episode_path(source[0]), prediction.frame[-1, -1:])[0])

    def coverage(self) -> Coverage:
        """Coverage of the stored episodes; those that were counted before are not read again."""
        paths = self.folder.episode_paths()
        stamps = [stamp(path) for path in paths]
        if self.counted is None or stamps[:len(self.files)] != self.files:
            self.counted, self.files = Coverage(self.folder.plan), []
        for path, found in zip(paths[len(self.files):], stamps[len(self.files):]):
            self.counted.add(read_arrays(path, ("pose",))["pose"])
            self.files.append(found)
        return self.counted


@lru_cache(256)
def shows(path: Path, version: tuple[int, int]) -> bool:
    """Whether a file has an image to show (loop.keep), or is broken; version: its stamp, so that it is read once."""
    try:
        return not gone(path)
    except RunFolderError:
        return True


def version(path: Path) -> str:
    """A text that changes when a file does."""
    return "-".join(map(str, stamp(path)))


def label(run: RunFolder) -> str:
    """'small_room, random, seed 0'; "" where config.yaml cannot be read."""
    try:
        settings = run.settings
        return f"{scene_name(settings['env'])}, {settings['agent']['name']}, seed {settings['seed']}"
    except (RunFolderError, LookupError, TypeError):
        return ""
