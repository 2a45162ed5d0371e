"""Every option of every group composes to its dataclass; settings survive their YAML."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, is_dataclass, replace
from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.agents.registry import AGENTS
from curionav_cli.config import schema
from curionav_cli.config.catalogue import groups
from curionav_cli.config.compose import plan
from curionav_cli.config.settings import read_settings, settings_yaml
from curionav_cli.config.sources import conf_dir, opened
from curionav_cli.errors import RunFolderError

LARGE = ("explorers", "apartments", "comparison")  # experiments of a hundred runs
OPTIONS = sorted((path.parent.name, path.stem) for path in conf_dir().glob("*/*.yaml"))


def composed(*words: str) -> schema.Config:
    seen: list[schema.Config] = []
    with opened("explore") as hydra:
        plan(hydra, list(words), False, seen.append)
    return seen[0]


@pytest.mark.parametrize(("group", "option"), [
    pytest.param(*option, marks=[pytest.mark.slow] * (option[1] in LARGE)) for option in OPTIONS])
def test_every_option_is_shown(cli: Cli, group: str, option: str) -> None:
    words = [f"{group}={option}"] + (["env.map=any.yaml"] if option == "map" else [])
    answer = cli("explore", "--cfg", "job", *words, "seed=0")  # one seed of an experiment's sweep
    assert answer.code == 0, answer.error
    assert "seed: 0" in answer.out and "hydra" not in answer.out


@pytest.mark.parametrize("agent", [option for group, option in OPTIONS if group == "agent"])
@pytest.mark.parametrize("scale", ["cpu", "paper"])
def test_every_agent_has_a_dataclass_at_every_scale(agent: str, scale: str) -> None:
    settings = composed(f"agent={agent}", f"scale={scale}")
    name = agent.removesuffix("_ego")  # cbet_ego is cbet, seen from one camera
    assert type(settings.agent) is AGENTS[name].settings and settings.agent.name == name
    assert settings.scale is schema.Scale(scale)


def test_scale_chooses_the_hyperparameters() -> None:
    small, large = composed("scale=cpu").agent, composed("scale=paper").agent
    assert (large.batch_size, large.sequence_length, large.gru_units) == (50, 50, 200)
    assert small.gru_units < large.gru_units
    assert composed("scale=paper", "agent.gru_units=7").agent.gru_units == 7


def test_the_defaults() -> None:
    settings = composed()
    assert (settings.seed, settings.device) == (0, schema.Device.auto)
    assert settings.loop == schema.Loop(steps=500, iterations=100, episodes=10, replay_memory=2, replay_episodes=None,
                                       keep=schema.Keep.all)
    assert (settings.env.name, settings.agent.name) == ("small_room", "lbs_dreamer")


def test_settings_are_frozen() -> None:
    settings = composed("agent=bounce")
    for part in (settings, settings.loop, settings.env, settings.agent, settings.robot):
        assert is_dataclass(part)
        with pytest.raises(FrozenInstanceError):
            part.name = "other"  # type: ignore[union-attr]


@pytest.mark.parametrize("agent", AGENTS)
def test_settings_survive_their_yaml(tmp_path: Path, agent: str) -> None:
    settings = composed(f"agent={agent}", "seed=3", "loop.steps=7")
    file = tmp_path / "config.yaml"
    file.write_text(settings_yaml(settings))
    assert read_settings(file) == settings
    longer = replace(settings, loop=replace(settings.loop, episodes=99))
    file.write_text(settings_yaml(longer))
    assert read_settings(file) == longer != settings


UNREADABLE = [None, "", "{", "seed: 0", "agent: {name: unheard}", "[1, 2]", "!!python/object:os.x"]


@pytest.mark.parametrize("text", UNREADABLE)
def test_settings_that_cannot_be_read(tmp_path: Path, text: str | None) -> None:
    file = tmp_path / "config.yaml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(RunFolderError, match=r"config\.yaml"):
        read_settings(file)


def test_hidden_groups_are_not_offered() -> None:
    with opened("explore") as hydra:
        names = set(groups(hydra))
    assert {"agent", "env", "robot", "scale", "launcher"} <= names
    assert not any(name.startswith(("schema", "hydra")) or "/" in name for name in names)


def test_a_large_sweep_composes_each_value_once() -> None:
    seen: list[schema.Config] = []
    with opened("explore") as hydra:
        todo = plan(hydra, ["agent=random,bounce", "seed=range(0,20)"], True, seen.append)
    assert len(todo.jobs) == 40
    assert {settings.seed for settings in seen} == set(range(20))
    assert {settings.agent.name for settings in seen} == {"random", "bounce"} and len(seen) < 40
