"""Trained weights to act with, or to begin from: those of a run's newest checkpoint, or of a model card's folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.files import read_json
from curionav_cli.storage import checkpoint, model_card
from curionav_cli.storage.run_folder import RunFolder

INIT = "initial weights (sha256)"  # in a run's fixed.json


class Trained(NamedTuple):
    """weights: the folder of weights.safetensors. env: where it was trained; unit, done: for how many episodes or
    iterations. config: its config.yaml."""

    config: Path
    weights: Path
    env: str
    unit: str
    done: int

    @property
    def settings(self) -> Config:
        """The settings that it was trained with. Raises RunFolderError where they cannot be read."""
        return read_settings(self.config)

    @property
    def checksums(self) -> dict[str, str]:
        """SHA-256 of each file: of the checkpoint, or of the card's weights."""
        if model_card.is_card(self.weights):
            return {model_card.WEIGHTS: model_card.sha256(self.weights / model_card.WEIGHTS)}
        return checkpoint.checksums(self.weights)


def trained_in(folder: Path) -> Trained:
    """What was trained in a run, or stands in a card. Raises RunFolderError where there is nothing, or it is broken."""
    if model_card.is_card(folder):
        card = model_card.read_card(folder)
        return Trained(folder / "config.yaml", folder, card["env"], card["unit"], card["done"])
    run = RunFolder.existing(folder)
    finished = checkpoint.finished(run.checkpoints)
    if not finished:
        raise RunFolderError(f"{run.path} has no checkpoint, so there is no trained agent in it. "
                             f"Finish an episode first: curionav resume {run.path}")
    checkpoint.refuse_broken(finished[-1])
    unit = "episodes" if run.episode_paths() else "iterations"
    return Trained(run.config, finished[-1], environment(run), unit, int(finished[-1].name))


def environment(run: RunFolder) -> str:
    """The environment that a run was trained in; of curionav train, those in which its episodes were recorded."""
    about = read_json(run.path / "run.json") if (run.path / "run.json").is_file() else {}
    return ", ".join(about.get("environments", ())) or str(run.settings["env"]["name"])


def take_weights(agent: Agent, settings: Config, trained: Trained) -> None:
    """Let the agent take the networks that were trained. Raises ConfigError for one that does not learn,
    RunFolderError where they are of an agent of other settings."""
    if not agent.learns:
        raise ConfigError(f"agent={settings.agent.name} does not learn, so it has no weights to take from "
                          f"{trained.config.parent}. Leave out init=...")
    agent.load_weights(trained.weights)


def initial(settings: Config, run: RunFolder) -> dict[str, Any]:
    """The part of fixed.json that names the weights the run begins with; once it has a checkpoint, what stands there.

    Raises RunFolderError where init=... holds none.
    """
    if not settings.init:
        return {}
    if checkpoint.finished(run.checkpoints):
        return {key: value for key, value in read_json(run.path / "fixed.json").items() if key == INIT}
    return {INIT: trained_in(Path(settings.init)).checksums[model_card.WEIGHTS]}


def begin_from(agent: Agent, settings: Config, run: RunFolder) -> None:
    """Let an agent whose run has no checkpoint yet take the weights of init=..., if there are such."""
    if settings.init and not checkpoint.finished(run.checkpoints):
        take_weights(agent, settings, trained_in(Path(settings.init)))
