"""Runs from Python, for notebooks and scripts: `import curionav_cli as cn` (docs/python.md).

    cn.compose(["env=small_room", "seed=1"])   the settings that these words give on the command line
    cn.explore(settings, "folder")             run them
    cn.load_run("folder")                      what a run folder holds, as arrays and rows
    cn.load_runs("sweep")                      the runs of a sweep
    cn.batches("folder", 16, 50)               sequences of stored episodes, for models of your own

A mistake raises a UserError of errors.py, whose message is the line that the command line prints.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import closing
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from curionav_cli.bounds import a_number
from curionav_cli.config.compose import composed
from curionav_cli.config.schema import Config
from curionav_cli.decisions import Steps
from curionav_cli.errors import ConfigError, SoundnessWarning
from curionav_cli.places import place
from curionav_cli.records import Episode, FloorPlan
from curionav_cli.results.coverage import Coverage
from curionav_cli.results.runs import Run
from curionav_cli.storage import episodes as stored
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder

Folder = str | Path


def compose(overrides: Sequence[str] = (), command: str = "explore") -> Config:
    """Return the frozen settings of a command and its words, as in compose(["env=large_lab", "loop.steps=100"]).

    Raises ConfigError for a setting that does not exist or cannot have its value.
    """
    if isinstance(overrides, str):
        raise ConfigError(f"compose takes a list of settings: compose([{overrides!r}]).")
    return composed(command, *overrides)


def explore(settings: Config, folder: Folder) -> StoredRun:
    """Carry out curionav explore in `folder`, or continue what was interrupted there; returns the run.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    from curionav_cli.commands.explore import check  # with all that a run needs, which reading one does not
    from curionav_cli.execution.exploration import explore

    check(settings)
    explore(settings, place(folder))
    return load_run(folder)


def load_run(folder: Folder) -> StoredRun:
    """Open a run folder; nothing is read before it is asked for. Raises RunFolderError where `folder` is no run."""
    return StoredRun(Run.open(place(folder)))


def load_runs(folder: Folder) -> list[StoredRun]:
    """Open the runs of a sweep, or the one run that `folder` is. Raises RunFolderError where there is none."""
    return [StoredRun(Run(run)) for run in RunFolder.found(place(folder))]


class StoredRun:
    """A run folder, read when it is asked for; of a run that goes on, as far as it had come then.

    The part of a run that cannot be read is named in a SoundnessWarning, and what comes before it is given.
    """

    def __init__(self, run: Run):
        self._run = run

    def __repr__(self) -> str:
        return f"<run {self.path}: {self._run.label}, {self.state}>"

    @property
    def path(self) -> Path:
        """The run folder."""
        return self._run.folder.path

    @property
    def state(self) -> str:
        """running, done, failed or interrupted; unknown where status.json is broken."""
        return self._run.state

    @property
    def settings(self) -> dict[str, Any]:
        """env, agent, robot, seed and scale, nested as in config.yaml."""
        return self._run.config

    @property
    def plan(self) -> FloorPlan:
        """The floor plan: cells, obstacles, start. Raises RunFolderError for a run of curionav train, without one."""
        return self._run.plan

    @cached_property
    def coverage(self) -> Coverage:
        """Coverage of the episodes by `landing` on visitable cells: share, visited, total, visits (rows, columns)
        int64, curve(). Raises RunFolderError for a run of curionav train, which runs no episodes."""
        for gap in self._run.readable.gaps:
            warnings.warn(gap, SoundnessWarning, stacklevel=3)
        return self._run.coverage

    @property
    def episodes(self) -> StoredEpisodes:
        """The episodes, each read from the disk when it is asked for. Raises RunFolderError as `coverage` does."""
        _ = self.coverage
        return StoredEpisodes(self._run.episodes)

    @property
    def metrics(self) -> list[dict[str, Any]]:
        """The rows of metrics.jsonl: one an episode; of curionav train, one a save."""
        return self._run.folder.metrics()


class StoredEpisodes(Sequence[Episode]):
    """Episodes of a run in order, each read from the disk when it is asked for, and not kept.

    Of T steps an episode has, as plain arrays:

        image     (T+1, 64, 64, 3) uint8 RGB; image[t + 1] was seen after action[t]
        action    (T,) int64: 0 forward 0.25 m, 1 left 10 degrees, 2 right 10 degrees
        pose      (T+1, 3) float64: x and y in metres, yaw in radians
        collided  (T,) bool: the forward move was cut short or cancelled
        estimate  (T+1, 3) float64 of a robot that drifts, as pose; else None

    Reading raises RunFolderError where the file is broken.
    """

    def __init__(self, paths: Sequence[Path]):
        self.paths = paths

    def __repr__(self) -> str:
        return f"<{len(self)} stored episodes>"

    def __len__(self) -> int:
        return len(self.paths)

    @overload
    def __getitem__(self, index: int) -> Episode: ...

    @overload
    def __getitem__(self, index: slice) -> StoredEpisodes: ...

    def __getitem__(self, index: int | slice) -> Episode | StoredEpisodes:
        return StoredEpisodes(self.paths[index]) if isinstance(index, slice) else Episode.load(self.paths[index])


def batches(data: Folder, batch_size: int = 16, length: int = 50, *, seed: int = 0, action_repeat: int = 1,
            memory: float = 2.0) -> Iterator[dict[str, np.ndarray]]:
    """Draw batches without end of B sequences of L observations, uniformly over all stored steps.

    data: a run, a sweep, or a folder of episodes; what is stored later is not drawn. The same seed gives the same
    batches. action_repeat: of episodes whose actions were held for so many steps, one observation an action.
    memory: GB of images that are kept in memory; the others are read from a scratch file, removed at the end.

        image     (B, L, 64, 64, 3) uint8 RGB
        action    (B, L) int64: the action that led to the observation; -1 at a sequence's first
        pose      (B, L, 3) float64: x and y in metres, yaw in radians
        is_start  (B,) bool: the sequence begins where an episode begins

    Raises, at once, RunFolderError where there are no episodes or one is broken, ConfigError for numbers out of range
    and for a length that no episode has.
    """
    numbers = {"batch_size": (batch_size, 1, 10**5), "length": (length, 2, 10**6), "seed": (seed, 0, 2**64 - 1),
               "action_repeat": (action_repeat, 1, 100), "memory": (memory, 0, 10**6)}
    for name, (number, least, most) in numbers.items():
        refuse_out_of_range(name, number, least, most, whole=name != "memory")
    folder = place(data)
    replay = Replay.open([folder / name for name in stored.names(folder)], memory=memory * 1e9,
                         every=Steps(action_repeat))
    if not replay.holds(length):
        longest = max(len(replay.episode(index)) for index in range(len(replay))) + 1
        replay.close()
        raise ConfigError(f"length={length} does not fit into the longest episode of {folder}, which holds {longest} "
                          f"observations. Set length={longest} or less.")
    return drawn(replay, batch_size, length, np.random.default_rng(seed))


def refuse_out_of_range(name: str, number: float, least: float, most: float, whole: bool) -> None:
    """Raises ConfigError unless a number, whole or not, is from `least` to `most`."""
    try:
        a_number(name, number, least, most)
    except ValueError as error:
        raise ConfigError(f"{error}.") from error
    if whole and not isinstance(number, int):
        raise ConfigError(f"{name} must be a whole number, not {number!r}.")


def drawn(replay: Replay, batch_size: int, length: int, rng: np.random.Generator) -> Iterator[dict[str, np.ndarray]]:
    """Yield batches, and close the replay with the iterator."""
    with closing(replay):
        while True:
            yield replay.sample(batch_size, length, rng)
