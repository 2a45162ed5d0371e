"""Evaluate: a trained agent acts in an environment and does not learn; its run folder is like that of explore.

weights=RUN names the trained run. Its newest checkpoint is read by the agent's `load_weights` (networks alone, not
counts, maps or random state); its settings were put in place by commands/evaluate.py. A broken newest checkpoint is an
error: an older one is not taken instead. What was loaded is recorded among the fixed settings by its checksums, so that
a resumed evaluation is refused where RUN has learned on.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.errors import ConfigError
from curionav_cli.execution.exploration import Exploration
from curionav_cli.execution.lifecycle import run_task
from curionav_cli.execution.precision import with_precision
from curionav_cli.execution.trained import trained_in
from curionav_cli.storage.run_folder import RunFolder

CHECKPOINT = "checkpoint (sha256)"  # in fixed.json: of each file of what is evaluated


def evaluate(settings: Config, folder: Path) -> RunFolder:
    """Run an evaluation in `folder` to its end; one that has begun there is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    return run_task("evaluate", Evaluation(with_precision(settings, folder), folder))


class Evaluation(Exploration):
    """Episodes of a trained agent that acts and predicts, and learns from none of them (lifecycle.Task)."""

    def __init__(self, settings: Config, folder: Path):
        super().__init__(settings, folder)
        self.trained = trained = trained_in(Path(settings.init or ""))
        self.fixed["trained"] = {"env": trained.env, trained.unit: trained.done}
        self.fixed["training seed"] = trained.settings.seed
        self.fixed[CHECKPOINT] = trained.checksums

    def initial(self) -> dict[str, Any]:
        """Nothing: the whole checkpoint stands in fixed.json."""
        return {}

    def agent(self) -> Agent:
        """Build an agent of this run's seed, with the weights that were trained."""
        agent = build.agent(self.settings, self.world)
        if not agent.learns:
            raise ConfigError(f"agent={self.settings.agent.name} does not learn, so there is nothing to evaluate. "
                              "Run it with curionav explore.")
        agent.load_weights(self.trained.weights)
        return agent

