"""One V-trace update of the policy, and of the networks of a reward (IMPALA, Espeholt et al., 2018, as C-BET runs it).

Letters: T steps, B unrolls. Losses are summed over T and averaged over B.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn
from torch.optim import rmsprop as functional

from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.cbet.count_log import CountLog
from curionav_cli.agents.cbet.network import Memory, PolicyNetwork, initialise
from curionav_cli.agents.cbet.rewards.choose import reward_class
from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.cbet.rms import RunningRMS
from curionav_cli.agents.cbet.transitions import KINDS
from curionav_cli.agents.cbet.unrolls import Batch
from curionav_cli.agents.cbet.vtrace import vtrace
from curionav_cli.agents.optimiser import ClippedOptimiser, Tensors


class Networks(nn.Module):
    """All networks, the reward's included, and running means: the content of `weights.safetensors`."""

    def __init__(self, hyper: cbet_settings.CBET):
        super().__init__()
        self.policy = PolicyNetwork(hyper)
        self.reward = reward_class(hyper.reward).build(hyper)
        self.rms = RunningRMS(hyper.rms_momentum)


def build_networks(hyper: cbet_settings.CBET, generator: torch.Generator, device: torch.device) -> Networks:
    """Make networks whose first weights come from `generator` alone, the same on every device."""
    with torch.random.fork_rng(devices=[]):  # torch's own first weights; on the meta device it would load its compiler
        networks = Networks(hyper)
    for part in (networks.policy, *networks.reward.values()):
        initialise(part, generator)
    networks.rms.reset()
    return networks.to(device)


class Learner:
    """Updates the networks, each with its optimiser, for a reward; `updates` counts what was done.

    count_log: where the reward's tables that last are kept.
    """

    def __init__(self, hyper: cbet_settings.CBET, networks: Networks, reward: Reward):
        self.hyper, self.networks, self.reward = hyper, networks, reward
        self.updates = 0
        self.count_log = CountLog()
        learning = {"policy": networks.policy, **{f"reward_{name}": part for name, part in networks.reward.items()}}
        self.optimisers = {name: self._optimiser(part) for name, part in learning.items()
                           if any(parameter.requires_grad for parameter in part.parameters())}

    def update(self, batch: Batch) -> dict[str, Tensor]:
        """Take a step with every optimiser on B unrolls; returns scalar metrics on the device."""
        learned_bonus, loss = self.reward.learned_bonus(batch)
        reward, metrics = self.scaled(batch.bonus * learned_bonus)
        policy_loss, more = self.policy_loss(batch, reward)
        (policy_loss + loss).backward()
        metrics |= more | self.by_kind(batch.kind, batch.bonus * learned_bonus)
        for name, optimiser in self.optimisers.items():
            metrics[f"{name}_norm"] = optimiser.apply()
        self.updates += 1
        return {name: value.detach() for name, value in metrics.items()}

    def scaled(self, reward: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Scale rewards (T, B) by their coefficient and clip them: (T, B), and metrics."""
        hyper = self.hyper
        coefficient = hyper.coefficient.get(hyper.reward.value, 1.0)
        scale = coefficient * (hyper.rms_size / self.networks.rms(reward) if hyper.normalise else 1.0)
        raw = scale * reward
        clipped = (raw.abs() > hyper.reward_clip).float().mean()
        return raw.clamp(-hyper.reward_clip, hyper.reward_clip), {
            "reward": raw.mean(), "reward_deviation": raw.std(), "reward_clipped": clipped}

    def policy_loss(self, batch: Batch, reward: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Scalar loss of policy, value and entropy for reward (T, B), and metrics."""
        hyper = self.hyper
        memory = Memory(batch.hidden, batch.cell)
        logits, value = self.networks.policy.unroll(  # (T, B, A), (T + 1, B)
            batch.image, batch.frame, memory, batch.respawned)
        log_policy = F.log_softmax(logits, -1)
        log_prob = log_policy.gather(-1, batch.action[..., None]).squeeze(-1)  # (T, B)
        ratio = (log_prob.detach() - batch.log_policy).exp()  # pi / mu
        target, advantage = vtrace(ratio, reward, torch.full_like(reward, hyper.gamma), value.detach())
        entropy = -(log_policy.exp() * log_policy).sum(-1)
        actor = -(log_prob * advantage).sum(0).mean()
        critic = 0.5 * (target - value[:-1]).square().sum(0).mean()
        loss = actor + hyper.value_cost * critic - hyper.entropy * entropy.sum(0).mean()
        return loss, {
            "policy_loss": actor, "value_loss": critic, "entropy": entropy.mean(), "value": value.mean(),
            "advantage_deviation": advantage.std(), "ratio_off_one": (ratio - 1).abs().max(),
        }

    def by_kind(self, kind: Tensor, reward: Tensor) -> dict[str, Tensor]:
        """The mean of reward (T, B), neither scaled nor clipped, for each kind of step that occurs."""
        return {f"reward_{name}": reward[kind == number].mean()
                for number, name in enumerate(KINDS) if bool((kind == number).any())}

    def _optimiser(self, part: nn.Module) -> ClippedOptimiser:
        return ClippedOptimiser(part, self.hyper.clip, ("square_avg",), self.rmsprop)

    def rmsprop(self, parameters: Tensors, gradients: Tensors, squares: Tensors, steps: Tensors) -> None:
        """Take a step of RMSprop in place."""
        hyper = self.hyper
        functional.rmsprop(parameters, gradients, squares, [], [], steps, lr=hyper.lr, alpha=hyper.rmsprop_decay,
                           eps=hyper.rmsprop_epsilon, weight_decay=0, momentum=0, centered=False)
