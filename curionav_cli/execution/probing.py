"""Measure the agent's world model on the fixed probe of its world, every so often: `results.probe_every`."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config, Learner
from curionav_cli.decisions import Every
from curionav_cli.errors import ConfigError
from curionav_cli.execution.progress import say
from curionav_cli.files import file_name
from curionav_cli.probe import Probe
from curionav_cli.results.labels import world_settings
from curionav_cli.storage import probe_cache
from curionav_cli.world import walks
from curionav_cli.world.real_floor import RealFloor
from curionav_cli.world.scene.scene import Scene


class Prober:
    """Measures after every `period` episodes or iterations; never without a probe."""

    def __init__(self, agent: Agent, period: int, probe: Probe | None):
        self.agent, self.period, self.probe = agent, period, probe

    def metrics(self, done: int) -> dict[str, Any]:
        """Metrics after `done` episodes or iterations, with the probe's checksum; {} where it is not yet time."""
        measured = None if self.probe is None or done % self.period else self.agent.probe(self.probe)
        return {**measured.metrics(), "probe": self.probe.checksum} if measured and self.probe else {}


def prober(settings: Config, fixed: dict[str, Any], world: Scene | RealFloor, agent: Agent, folder: Path,
           unit: int = 1) -> Prober:
    """The prober of the run in `folder`. fixed: its fixed.json; unit: episodes or iterations that probe_every counts.

    The probe is in the folder `probes` beside the run. An agent without a world model gets a line, and is not measured.
    Raises ConfigError as `refuse_of_robot` does.
    """
    refuse_of_robot(settings)
    every = settings.results.probe_every
    if every and not agent.has_model:
        say(f"agent={settings.agent.name} has no world model, so results.probe_every={every} measures nothing.")
    if not every or not agent.has_model:
        return Prober(agent, 0, None)
    if not isinstance(world, Scene):
        raise ConfigError(f"results.probe_every={every} needs a simulated world, from whose true map a probe is drawn. "
                          "Set results.probe_every=0.")
    path = folder.parent / "probes" / probe_name(settings.env.name, fixed, agent.every)
    return Prober(agent, every * unit, probe_cache.kept(path, lambda: walks.draw(world, agent.every)))


def refuse_of_robot(settings: Config) -> None:
    """Refuse to measure a world model that the server learns. Raises ConfigError."""
    if settings.results.probe_every and settings.learner is Learner.remote:
        raise ConfigError("results.probe_every measures the world model, which the server learns. Set it there: "
                          f"curionav train storage=... results.probe_every={settings.results.probe_every}")


def probe_name(world: str, fixed: dict[str, Any], every: Every) -> str:
    """The name of a probe's file: the world, a checksum of its settings, and how often the agent chooses."""
    whole = json.dumps([world_settings(fixed), walks.SEQUENCES, walks.LENGTH, walks.REPEAT], sort_keys=True)
    checksum = hashlib.sha256(whole.encode()).hexdigest()[:12]
    return f"{file_name(world)}_{checksum}_{every.held or every.unit}.npz"
