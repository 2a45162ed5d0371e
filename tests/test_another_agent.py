"""Another agent is a package, a YAML file and a line in the registry: it explores, goes on, and is compared."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.agents.registry import AGENTS, Registered

pytestmark = pytest.mark.usefixtures("blank_figures")

PACKAGE = '''
from dataclasses import dataclass

from curionav_cli.agents.agent import Agent
from curionav_cli.bounds import within


@dataclass(frozen=True)
class Settings:
    """Turns left every so many steps."""

    name: str
    every: int

    def __post_init__(self):
        within("agent.every", self.every, least=2, most=100)


class Turner(Agent):
    def __init__(self, seed, every):
        super().__init__(seed)
        self.often = every

    def begin(self):
        self.steps = 0

    def act(self, observation, info):
        self.steps += 1
        return 0 if self.steps % self.often else 1


def make(own, setup):
    return Turner(setup.seed, own.every)
'''
YAML = "defaults: [/schema/agent/turner]\nname: turner\nevery: 3\n"
SHORT = ("--config-dir", "mine", "agent=turner", "loop.steps=9", "loop.episodes=2", "hydra.run.dir=run")


@pytest.fixture
def turner(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """The entry point, where three steps have been made."""
    (tmp_path / "turner.py").write_text(PACKAGE)
    monkeypatch.syspath_prepend(str(tmp_path))
    import turner  # type: ignore[import-not-found]

    (tmp_path / "mine" / "agent").mkdir(parents=True)
    (tmp_path / "mine" / "agent" / "turner.yaml").write_text(YAML)
    monkeypatch.setitem(AGENTS, "turner", Registered(turner.Settings, turner.make))
    return cli


def test_it_explores_goes_on_and_is_compared(turner: Cli, tmp_path: Path) -> None:
    assert turner("explore", *SHORT).code == 0
    assert turner("resume", "run", "loop.episodes=3").code == 0
    answer = turner("compare", "run", "out=page")
    assert answer.code == 0 and "turner" in answer.out and (tmp_path / "page" / "report.html").is_file()
    refused = turner("explore", *SHORT[:-1], "agent.every=1")
    assert refused.code == 2 and "agent.every: 1 is not between 2 and 100" in refused.error
