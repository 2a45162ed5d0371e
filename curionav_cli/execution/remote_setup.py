"""The robot's side of a storage, explore learner=remote storage=URL; and the checks that both sides share."""

from __future__ import annotations

import time
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.errors import ConfigError, Denied, RunFailed, RunFolderError, Unreachable
from curionav_cli.execution.progress import say
from curionav_cli.loop import RemoteLearner
from curionav_cli.remote.object_store import EXAMPLES, ObjectStore
from curionav_cli.remote.outbox import Outbox
from curionav_cli.remote.protocol import MARKED, agree_on_settings, fingerprint
from curionav_cli.remote.robot_sync import RobotSync, Time
from curionav_cli.remote.weight_cache import WeightCache
from curionav_cli.storage.run_folder import RunFolder


def remote_learner(settings: Config, run: RunFolder, agent: Agent, shared: dict[str, Any]) -> RemoteLearner:
    """Build what a robot does with its episodes. Raises RunFolderError where the storage is another run's."""
    store, remote = opened(settings), settings.remote
    outbox = Outbox(run.path / "outbox", fingerprint(shared), remote.outbox, remote.disk)
    fresh = not run.episode_paths()
    try:
        store.create()
        agree_on_settings(store, shared)
        if fresh and store.names("episodes", MARKED):
            raise RunFolderError(f"storage: {settings.storage} holds the episodes of another run. Resume that run, "
                                 "or use an empty storage.")
    except Unreachable as error:
        if fresh:
            refuse_denied(settings, error)
        say(f"the storage is not reachable ({error}): the run begins without it")
    sync = RobotSync(store, outbox, WeightCache(run.path / "weights"), agent.import_weights,
                     len(agent.export_weights()), remote, Time(time.monotonic, time.sleep), say, run.episode_path)
    return RemoteLearner(sync, run.save_episode)


def opened(settings: Config) -> ObjectStore:
    """Open the storage of the settings. Raises ConfigError where there is none."""
    if not settings.storage:
        raise ConfigError(f"learner=remote needs a storage for robot and server: {EXAMPLES}.")
    return ObjectStore.at(settings.storage, settings.remote.timeout)


def refuse_denied(settings: Config, error: Unreachable) -> None:
    """Raise ConfigError for a storage that refuses for good, before anything is run for it."""
    if isinstance(error, Denied):
        raise ConfigError(f"storage: {settings.storage} cannot be used: {error}.") from None


def refuse_undelivered(run: RunFolder) -> None:
    """Check the outbox at the end of a run. Raises RunFailed where episodes are still in it."""
    waiting = len(list((run.path / "outbox").glob("*.json")))
    if waiting:
        raise RunFailed(f"{waiting} episode{'s' * (waiting != 1)} could not be delivered and wait in "
                        f"{run.path / 'outbox'}. Nothing is lost; the same command again delivers them.")


def check(settings: Config) -> None:
    """Check that the storage opens and that a server can train the agent. Raises ConfigError."""
    opened(settings)
    agent = build.agent(settings, build.world(settings))
    if not agent.learns or agent.on_policy:
        why = "learns only from the episode it has just run" if agent.learns else "does not learn"
        raise ConfigError(f"agent={settings.agent.name} {why}, so no server can learn for it. "
                          "Choose agent=lbs_dreamer.")
    if not settings.loop.iterations:
        raise ConfigError("loop.iterations=0 trains nothing. Set it to 1 or more.")
