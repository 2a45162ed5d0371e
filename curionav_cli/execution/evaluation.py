"""Evaluate: a trained agent acts in an environment and does not learn; its run folder is like that of explore.

weights=RUN names the trained run. Its newest checkpoint is read by the agent's `load_weights` (networks alone, not
counts, maps or random state); its settings were put in place by commands/evaluate.py. A broken newest checkpoint is an
error: an older one is not taken instead. What was loaded is recorded among the fixed settings by its checksums, so that
a resumed evaluation is refused where RUN has learned on.
"""

from __future__ import annotations

from pathlib import Path

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.exploration import Exploration
from curionav_cli.execution.lifecycle import run_task
from curionav_cli.execution.precision import with_precision
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder


def evaluate(settings: Config, folder: Path) -> RunFolder:
    """Run an evaluation in `folder` to its end; one that has begun there is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    return run_task("evaluate", Evaluation(with_precision(settings, folder), folder))


class Evaluation(Exploration):
    """Episodes of a trained agent that acts and predicts, and learns from none of them (lifecycle.Task)."""

    def __init__(self, settings: Config, folder: Path):
        super().__init__(settings, folder)
        self.trained = trained_in(Path(settings.weights or ""))
        done, self.weights = newest(self.trained)
        before = read_settings(self.trained.config)
        self.fixed["trained"] = {"env": before.env.name, self.trained_unit(): done}
        self.fixed["training seed"] = before.seed
        self.fixed["checkpoint (sha256)"] = checkpoint.checksums(self.weights)

    def trained_unit(self) -> str:
        """What the trained run's checkpoints count."""
        return "episodes" if self.trained.episode_paths() else "iterations"

    def agent(self) -> Agent:
        """Build an agent of this run's seed, with the weights that were trained."""
        agent = super().agent()
        if not agent.learns:
            raise ConfigError(f"agent={self.settings.agent.name} does not learn, so there is nothing to evaluate. "
                              "Run it with curionav explore.")
        agent.load_weights(self.weights)
        return agent


def trained_in(folder: Path) -> RunFolder:
    """The run in `folder`, which has a whole checkpoint. Raises RunFolderError."""
    run = RunFolder.existing(folder)
    newest(run)
    return run


def newest(run: RunFolder) -> tuple[int, Path]:
    """(finished episodes or iterations, folder) of the newest checkpoint. Raises RunFolderError where it is broken."""
    finished = checkpoint.finished(run.checkpoints)
    if not finished:
        raise RunFolderError(f"{run.path} has no checkpoint, so there is no trained agent in it. "
                             f"Finish an episode first: curionav resume {run.path}")
    checkpoint.refuse_broken(finished[-1])
    return int(finished[-1].name), finished[-1]
