"""logger=wandb: a run of Weights & Biases in the run's folder `wandb`, offline unless WANDB_MODE says otherwise.

Needs the extra wandb. wandb sends telemetry to its makers even when it is offline, unless WANDB_ERROR_REPORTING is
false, which is read when it is imported; so it is set here before that.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from curionav_cli.storage.loggers.logger import Local, identity, settings_of, sweep_of
from curionav_cli.storage.loggers.wandb_file import refuse_lost
from curionav_cli.storage.run_folder import RunFolder

PROJECT = "curionav"
SENDING = ("online", "shared", "run")  # values of WANDB_MODE with which wandb sends what it logs


class WandB(Local):
    """Row n of metrics.jsonl as step n of a run whose name and id stay the same; runs of a sweep are one group."""

    def __init__(self, run: RunFolder):
        mode: Any = os.environ.get("WANDB_MODE", "").strip() or "offline"
        sends = mode in SENDING
        if not sends:
            os.environ["WANDB_ERROR_REPORTING"] = "false"
        import wandb

        self.folder = run.path.resolve() / "wandb"  # whole: what writes there is a process that keeps its first folder
        self.stored = mode == "offline"
        shutil.rmtree(self.folder, ignore_errors=True)
        quiet = wandb.Settings(silent=not sends, console="off", disable_git=True, disable_code=True,
                               save_code=False, x_disable_stats=True, x_disable_machine_info=True)
        self.run = wandb.init(
            project=os.environ.get("WANDB_PROJECT") or PROJECT, dir=str(self.folder.parent), id=identity(run),
            mode=mode, name=self.folder.parent.name, group=os.environ.get("WANDB_RUN_GROUP") or sweep_of(run),
            config=settings_of(run), resume="allow" if sends else None, reinit="create_new", settings=quiet)
        self.image = wandb.Image
        self.index = 0
        self.known = self.run.step if sends and self.run.resumed else 0  # rows that the server has
        for row in run.metrics():
            self.add(row)

    def add(self, row: dict[str, Any]) -> None:
        if not self.index:
            self.run.define_metric("*", step_metric="iterations" if "iterations" in row else "steps")
        if self.index >= self.known:
            self.run.log(row, step=self.index)
        self.index += 1

    def add_figures(self, figures: Sequence[Path]) -> None:
        self.run.log({f"figures/{path.stem}": self.image(str(path)) for path in figures}, step=self.index)
        self.index += 1

    def close(self) -> None:
        self.run.finish()
        name = f"run-{self.run.id}.wandb"
        files = list(self.folder.glob(f"offline-run-*/{name}"))
        if self.stored and not files:
            raise OSError(f"{self.folder} holds no {name}")
        for path in files:
            refuse_lost(path, self.index)
