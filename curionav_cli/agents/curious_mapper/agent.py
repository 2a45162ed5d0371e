"""A mapping explorer that is curious: it measures its world model's surprise at every step while it acts, enters it
into its own map, and drives to where most surprise is expected for an action.

    measured  KL[ q(s_t | s_{t-1}, a_{t-1}, x_t) || p(s_t | s_{t-1}, a_{t-1}) ]     agent.py
    where     the cells that the view shows                                         memory.py
    expected  there, and in places not yet seen                                     memory.py, levels.py
    the way   with the most of it for an action                                     foraging.py, driver.py

The world model is LBS Dreamer's and learns as there; no actor, critic or head does.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.curious_mapper import settings
from curionav_cli.agents.curious_mapper.driver import Driver
from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer, Step
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.rssm import State
from curionav_cli.records import FloorPlan


class ModelLearner(Learner):
    """LBS Dreamer's learner without behaviour: every update is one of the world model alone."""

    def count(self) -> bool:
        self.updates += 1
        return False


class CuriousMapper(LBSDreamer):
    """The agent of agent=curious_mapper. driver: the map and the driving; it shares the agent's generator."""

    learner_class = ModelLearner
    acting = ("world_model.encoder.", "world_model.rssm.")

    def __init__(self, hyper: settings.CuriousMapper, seed: int, device: str, plan: FloorPlan, compile: str,
                 driver: Driver):
        self.driver = driver
        super().__init__(hyper, seed, device, plan, compile)
        driver.rng = self.rng

    def begin(self) -> None:
        super().begin()
        self.steps = 0
        self.driver.begin()

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """Filter the image into the model state, enter its surprise into the map, take the next action of the way."""
        surprise = float(self.filtered(observation, info["episode_index"])["surprise"])
        self.driver.add_measurement(surprise if self.steps >= self.hyper.curiosity_burn_in else None)
        self.steps += 1
        action = self.driver.act(observation, info)
        self.action = torch.tensor([action], device=self.device)
        return action

    @torch.inference_mode()
    def _filter(self, step: Step) -> dict[str, Tensor]:
        """s_t ~ q(s_t | s_{t-1}, a_{t-1}, x_t), and the KL of that posterior from the prior, (1,) nats."""
        model, rssm = self.learner.networks.world_model, self.learner.networks.world_model.rssm
        patches = model.patches(step.image.to(self.device))
        state, posterior = rssm.filter(State(step.deter, step.stoch), rssm.action_input(step.action),
                                       rssm.embed_input(model.encoder(patches)), step.noise[:, :-1])
        surprise = latent.kl(posterior, rssm.prior(state.deter))
        return {"deter": state.deter, "stoch": state.stoch, "surprise": surprise}

    def report(self) -> dict[str, float]:
        """What the driver reports, and the Levels: surprise in nats, how it fades after episodes, trust in the map."""
        levels = self.driver.memory.levels
        return {**self.driver.report(), "surprise_usual": levels.usual, "surprise_expected": levels.expected,
                "surprise_fading": levels.fade, "surprise_trust": levels.trust}

    def save(self, folder: Path) -> None:
        """Write what LBS Dreamer's checkpoint has, mapper.json and map.npz."""
        self.driver.save(folder)
        super().save(folder)

    def load(self, folder: Path) -> None:
        self.driver.load(folder)
        super().load(folder)
