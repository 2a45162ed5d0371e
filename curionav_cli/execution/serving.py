"""The server's side of a storage, curionav train storage=URL [--follow]: learn from what arrives, publish weights.

Its run folder is that of an exploration, with episodes, metrics, predictions and figures, and in addition
ledger.sqlite and quarantine/.
"""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.errors import Unreachable
from curionav_cli.execution.exploration import Exploration, draw, drawn_figures
from curionav_cli.execution.keeping import newest_drawn
from curionav_cli.execution.lifecycle import run_task
from curionav_cli.execution.precision import with_precision
from curionav_cli.execution.probing import prober
from curionav_cli.execution.progress import ServeProgress, say
from curionav_cli.execution.recorder import Recorder
from curionav_cli.execution.remote_setup import opened, refuse_denied
from curionav_cli.loop import LocalLearner, clocks, spent
from curionav_cli.remote.inbox import Arrival, Inbox
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.protocol import agree_on_settings, fingerprint
from curionav_cli.remote.robot_sync import Time
from curionav_cli.remote.training_server import TrainingServer
from curionav_cli.remote.weight_publisher import WeightPublisher
from curionav_cli.results.coverage import cover
from curionav_cli.storage.loggers import Loggers
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder


def serve(settings: Config, folder: Path) -> RunFolder:
    """Train in `folder` on the episodes that arrive. Raises as training.train does."""
    return run_task("train", Service(with_precision(settings, folder), folder))


class Service(Exploration):
    """Learning from the episodes of a remote robot (lifecycle.Task)."""

    def __init__(self, settings: Config, folder: Path):
        super().__init__(settings, folder)
        self.total = sys.maxsize  # the number of episodes is open
        self.fixed["learner"] = "server"

    def work(self, agent: Agent, first: int) -> None:
        """Learn from episode `first` to the last that arrives, then draw the figures."""
        run, loop = self.run, self.settings.loop
        with ExitStack() as stack:
            ledger = stack.enter_context(closing(Ledger(run.path / "ledger.sqlite")))
            replay = stack.enter_context(closing(Replay.open(
                run.episode_paths(), memory=loop.replay_memory * 1e9, folder=run.path, every=agent.every,
                newest=newest_drawn(agent, loop))))
            logger = stack.enter_context(closing(Loggers(run, self.settings.loggers)))
            recorder = Recorder(run, None, agent, replay, self.fixed, logger,
                                prober(self.settings, self.fixed, self.world, agent, run.path),
                                self.memory, cover(run.plan, run.poses()), ServeProgress(first), self.keeping(agent))
            learn = LocalLearner(agent, replay, loop.iterations, recorder, run.save_episode)
            run.set_status(state="running", error=None, episode=first, **recorder.counts(), **recorder.usage())

            def learned(position: int, arrival: Arrival) -> None:
                began, marker = clocks(), arrival.marker
                metrics = {**learn(position, arrival.episode), "seq": marker.seq, "weights_version": marker.weights}
                seconds = {**spent("acting", began, began), **spent("learning", began, clocks())}  # acted elsewhere
                recorder.episode_done(position, arrival.episode, {**metrics, **seconds})

            self.trainer(agent, ledger, learned, first).serve()
            for name, reason in ledger.refused().items():
                say(f"episode {name} was not learned from: {reason}")
            draw(run)
            logger.add_figures(drawn_figures(run))

    def trainer(self, agent: Agent, ledger: Ledger, learned: Any, first: int) -> TrainingServer:
        """Build the server. Raises RunFolderError where the storage is another run's."""
        settings, remote, shared = self.settings, self.settings.remote, self.shared
        store, mark, timing = opened(settings), fingerprint(shared), Time(time.monotonic, time.sleep)
        inbox = Inbox(store, ledger, self.run.path / "quarantine", settings=mark, steps=settings.loop.steps,
                      gap=remote.gap if remote.follow else 0, clock=timing.clock, say=say, every=agent.every)
        inbox.first = ledger.rewind(first)
        try:
            store.create()
            agree_on_settings(store, shared)
        except Unreachable as error:
            refuse_denied(settings, error)
            say(f"the storage is not reachable ({error})")
        return TrainingServer(inbox, WeightPublisher(store, ledger, mark, say), learned, agent.export_weights, first,
                              remote, timing, say)
