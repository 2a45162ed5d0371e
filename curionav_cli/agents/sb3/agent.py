"""What all algorithms of agent=sb3 share: the model, its reward, checkpoints.

SB3's own loop steps an environment; ours calls `act` and, after the episode, `learn`. On-policy algorithms record what
their policy gave in `act` and fill SB3's rollout buffer in `learn` (on_policy.py); off-policy ones draw from our replay
(off_policy.py). Then SB3's train() does the update. A checkpoint holds

    weights.safetensors   the policy, target networks included, and the reward's networks
    training.safetensors  the optimisers' moments
    memory.safetensors    counts of the reward; of off-policy algorithms the rewards of all steps so far
    memory.json           steps, updates
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.device import repeatable, resolve_device
from curionav_cli.agents.sb3 import settings
from curionav_cli.agents.sb3.model import build, metrics, seeded
from curionav_cli.agents.sb3.rewards import REWARDS
from curionav_cli.agents.weights import (
    below,
    load_weights,
    overwrite,
    prefixed,
    read_tensors,
    save_weights,
    write_tensors,
)
from curionav_cli.files import read_json, write_whole

TRAINING, MEMORY, NUMBERS = "training.safetensors", "memory.safetensors", "memory.json"


class Networks(nn.ModuleDict):
    """Networks whose weights are saved once, although SB3's policies name shared ones up to three times."""

    def state_dict(self, *args: Any, **kwargs: Any) -> dict[str, Any]:  # type: ignore[override]
        """Each parameter and buffer under the first of its names."""
        return {name: tensor.detach() for name, tensor in (*self.named_parameters(), *self.named_buffers())}

    def load_state_dict(self, state_dict: Mapping[str, Any], *args: Any, **kwargs: Any) -> None:
        """Copy the values into the networks, in place."""
        overwrite(self.state_dict(), state_dict)


class SB3Agent(Agent):
    """An algorithm of Stable-Baselines3 that acts by images, on the rewards of `reward`."""

    learns = True
    on_policy = True  # also where the algorithm is not: an image's reward depends on all that came before it

    def __init__(self, own: settings.SB3, seed: int, device: str, **fixed: Any):
        super().__init__(seed)
        self.own, self.device = own, resolve_device(device)
        repeatable(self.device)
        with seeded(self.rng):
            self.model = build(own, self.device, **fixed)
            self.reward = REWARDS[own.reward](own, self.rng).to(self.device)
        self.networks = Networks({"policy": self.model.policy, "reward": self.reward})
        self.begin()

    def observed(self, image: np.ndarray) -> Tensor:
        """Images (n, 64, 64, 3) as the policy takes them: (n, 3, 64, 64) uint8 on the device."""
        return torch.from_numpy(channels_first(image)).to(self.device)

    def count(self, steps: int) -> None:
        """Count steps of the environment, by which schedules run."""
        self.model.num_timesteps += steps
        self.model._current_progress_remaining = max(0.0, 1 - self.model.num_timesteps / self.own.schedule_steps)

    def totals(self, rewards: np.ndarray) -> dict[str, float]:
        """Metrics of the last updates, of the episode's rewards (T,), and the number of updates so far."""
        return {**metrics(self.model), "reward_mean": float(rewards.mean(dtype=np.float64)),
                "updates": float(self.model._n_updates)}

    @property
    def optimisers(self) -> dict[str, torch.optim.Optimizer]:
        """The optimisers by name."""
        own = {"policy": self.model.policy.optimizer}
        return own if self.reward.optimiser is None else {**own, "reward": self.reward.optimiser}

    def memory(self) -> dict[str, np.ndarray]:
        """Arrays of a checkpoint beside the networks'."""
        counts = self.reward.counts
        return {} if counts is None else {f"counts/{path}": array for path, array in counts.state().items()}

    def restore_memory(self, arrays: dict[str, np.ndarray]) -> None:
        """Take the arrays that `memory` gave."""
        if self.reward.counts is not None:
            self.reward.counts.load_state({path.removeprefix("counts/"): array for path, array in arrays.items()
                                           if path.startswith("counts/")})

    def save(self, folder: Path) -> None:
        """Write the files that the module lists, and rng.json."""
        super().save(folder)
        save_weights(self.networks, folder)
        training: dict[str, Tensor] = {}
        for name, optimiser in self.optimisers.items():
            training |= prefixed(name, moments(optimiser))
        write_tensors(folder / TRAINING, training)
        write_tensors(folder / MEMORY, {name: torch.from_numpy(array) for name, array in self.memory().items()})
        numbers = {"steps": self.model.num_timesteps, "updates": self.model._n_updates}
        write_whole(folder / NUMBERS, lambda file: file.write(json.dumps(numbers).encode()))

    def load(self, folder: Path) -> None:
        """Restore what `save` wrote. Raises RunFolderError where a file is missing, broken or another network's."""
        super().load(folder)
        load_weights(self.networks, folder)
        training, numbers = read_tensors(folder / TRAINING), read_json(folder / NUMBERS)
        for name, optimiser in self.optimisers.items():
            restore_moments(optimiser, below(name, training))
        self.restore_memory({name: tensor.numpy() for name, tensor in read_tensors(folder / MEMORY).items()})
        self.model.num_timesteps, self.model._n_updates = 0, numbers["updates"]
        self.count(numbers["steps"])
        self.begin()

    def load_weights(self, folder: Path) -> None:
        """Take all networks from a checkpoint; counts begin anew, and schedules are at their end.

        Raises RunFolderError as weights.load_weights does.
        """
        load_weights(self.networks, folder)
        self.count(self.own.schedule_steps)
        self.begin()


def channels_first(image: np.ndarray) -> np.ndarray:
    """Images (..., 64, 64, 3) as SB3 has them, (..., 3, 64, 64)."""
    return np.ascontiguousarray(np.moveaxis(image, -1, -3))


def moments(optimiser: torch.optim.Optimizer) -> dict[str, Tensor]:
    """The state of an optimiser by 'index/moment'; {} before its first step."""
    return {f"{index}/{name}": torch.as_tensor(value) for index, own in optimiser.state_dict()["state"].items()
            for name, value in own.items()}


def restore_moments(optimiser: torch.optim.Optimizer, tensors: dict[str, Tensor]) -> None:
    """Take what `moments` gave."""
    state: dict[int, dict[str, Tensor]] = {}
    for path, tensor in tensors.items():
        index, _, name = path.partition("/")
        state.setdefault(int(index), {})[name] = tensor
    optimiser.load_state_dict({"state": state, "param_groups": optimiser.state_dict()["param_groups"]})
