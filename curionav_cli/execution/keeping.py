"""Which images a run keeps on its disk: `loop.keep`. Numbers (poses, actions, surprise, errors) are always kept.

    all      every frame of every episode, and every prediction's images
    replay   the newest WHOLE episodes as they are; of the others the frames that the learner may still draw (with
             loop.replay_episodes, of the newest so many), and no image of their predictions
    poses    as replay while the run is going on, and no image once it is done

An image is removed only after the checkpoint that does not need it any more, so that a run killed at any moment, also
while images are being removed, is resumed to the same bytes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config, Keep, Learner, Loop
from curionav_cli.decisions import Every
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.progress import say
from curionav_cli.files import read_arrays
from curionav_cli.storage import checkpoint, pictures
from curionav_cli.storage.run_folder import RunFolder

WHOLE = 5  # newest episodes whose images are all kept, for figures, films and the page that watches
NONE = np.zeros(0, np.int64)
GONE = {
    Keep.replay: "images are kept of the newest {} episodes, and of others those that the learner draws "
                 "(loop.keep=replay). Gone for the others: films, export, their predictions' images.",
    Keep.poses: "no image is kept (loop.keep=poses). Coverage, surprise, weights and figures are there; gone: films, "
                "export, curionav train data=, and more episodes of an agent that learns from stored ones.",
}


def check(settings: Config, agent: Callable[[], Agent]) -> None:
    """Check the settings of what is kept. Raises ConfigError where the agent needs all episodes, or as below."""
    if settings.loop.replay_episodes is not None:
        newest_drawn(agent(), settings.loop)
    refuse_with_storage(settings)


def refuse_with_storage(settings: Config) -> None:
    """Raises ConfigError where images would go that a robot may be asked to send again."""
    if settings.loop.keep is not Keep.all and (settings.storage or settings.learner is Learner.remote):
        raise ConfigError(f"loop.keep={settings.loop.keep.value} removes images, and a robot sends its episodes again "
                          "when its server asks for them. Leave loop.keep=all with a storage.")


def newest_drawn(agent: Agent, loop: Loop) -> int | None:
    """How many of the newest episodes the agent learns from; None for all. Raises ConfigError where it needs all."""
    if not agent.learns:
        return 0
    if agent.on_policy or not loop.iterations:
        return 1
    if loop.replay_episodes is not None and agent.counts:
        raise ConfigError(f"loop.replay_episodes={loop.replay_episodes} does not go with an agent whose reward counts "
                          "over all episodes. Set loop.replay_episodes=null.")
    return loop.replay_episodes


class Keeping:
    """Removes images of a run that are not kept. drawn: of how many newest episodes the learner draws; None: of all.

    Once `done` episodes are saved, the age of episode `index` is done - 1 - index.
    """

    def __init__(self, run: RunFolder, keep: Keep, every: Every, drawn: int | None):
        self.run, self.keep, self.every = run, keep, every
        needed = drawn + checkpoint.KEPT if drawn else drawn  # the older checkpoint is of one episode before
        self.needed = math.inf if needed is None else max(WHOLE, needed)

    def after(self, done: int) -> None:
        """Remove the images that are not needed any more once `done` episodes are saved: of two episodes at most."""
        self.thin({done - 1 - int(age) for age in (WHOLE, self.needed) if age < done}, done)

    def catch_up(self, done: int) -> None:
        """Remove what a kill, or a run begun with another loop.keep, left over; every episode is looked at."""
        self.thin(range(done - WHOLE), done)

    def thin(self, due: Iterable[int], done: int) -> None:
        """Remove images of these episodes and of their predictions."""
        if self.keep is Keep.all:
            return
        for index in due:
            path, prediction = self.run.episode_path(index), self.run.prediction_path(index)
            pictures.thin(path, self.drawn_frames(path) if done - 1 - index < self.needed else NONE)
            if prediction.exists():
                pictures.thin_prediction(prediction)

    def drawn_frames(self, path: Path) -> np.ndarray:
        """The frames of an episode that the learner draws: those at which its agent chose."""
        arrays = read_arrays(path, ("action", "collided"))
        return self.every.decisions(arrays["action"], arrays["collided"], path).frame

    def finish(self) -> None:
        """Remove what is not kept once the run is done, and say what is gone."""
        if self.keep is Keep.poses:
            for path in self.run.episode_paths():
                pictures.thin(path, NONE)
            for path in self.run.prediction_paths().values():
                pictures.thin_prediction(path)
        if self.keep is not Keep.all:
            say(f"{self.run.path}: {GONE[self.keep].format(WHOLE)}")


def refuse_gone(paths: Sequence[Path], loop: Loop, build: Callable[[], Agent]) -> None:
    """Raises RunFolderError where one of these episodes, from which the agent learns when it goes on, has no image."""
    gone = next((path for path in paths if pictures.gone(path)), None)
    if gone and newest_drawn(build(), loop) not in (0, 1):
        raise RunFolderError(f"{gone} holds no image any more (loop.keep), and an agent that learns from it cannot go "
                             f"on. Begin a new run from its weights: init={gone.parent.parent}")
