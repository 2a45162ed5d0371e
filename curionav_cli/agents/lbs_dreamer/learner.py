"""One update of everything that learns: world model, curiosity, actor and critic, in this order."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.behaviour import Behaviour, targets_and_advantage
from curionav_cli.agents.lbs_dreamer.lbs import LBS
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.rssm import Observed, State
from curionav_cli.agents.lbs_dreamer.stream_norm import StreamNorm
from curionav_cli.agents.lbs_dreamer.world_model import Sequences, WorldModel, choose
from curionav_cli.config import agent_schema

ACTIONS = 3  # forward, left, right


class Networks(nn.Module):
    """Everything with weights; what `weights.safetensors` holds."""

    def __init__(self, hyper: agent_schema.LBSDreamer):
        super().__init__()
        self.world_model = WorldModel(hyper, ACTIONS)
        features, units, layers = self.world_model.rssm.features, hyper.mlp_units, hyper.mlp_layers
        self.curiosity = LBS(features, units, layers, hyper.lbs_burn_in)
        self.behaviour = Behaviour(features, ACTIONS, units, layers)
        self.stream_norm = StreamNorm(hyper.reward_momentum, hyper.reward_centring)


def build_networks(hyper: agent_schema.LBSDreamer, generator: torch.Generator, device: torch.device) -> Networks:
    """Made without drawing from torch's global generator, the same on every device."""
    with torch.device("meta"):
        networks = Networks(hyper)
    networks.to_empty(device="cpu")
    initialise(networks, generator)
    networks.stream_norm.reset()
    networks.behaviour.update_slow_critic()
    return networks.to(device)


class Learner:
    """Networks and their optimisers. `updates` and `behaviour_updates` count what was done."""

    def __init__(self, hyper: agent_schema.LBSDreamer, networks: Networks, generator: torch.Generator):
        self.hyper, self.networks, self.generator = hyper, networks, generator
        self.device = generator.device
        self.updates = self.behaviour_updates = 0
        common = {"epsilon": hyper.adam_epsilon, "decay": hyper.weight_decay, "clip": hyper.clip}
        behaviour = networks.behaviour
        self.optimisers = {
            "model": Optimiser(networks.world_model, hyper.model_lr, **common),
            "curiosity": Optimiser(networks.curiosity, hyper.model_lr, **common),
            "actor": Optimiser(behaviour.actor, hyper.actor_lr, **common),
            "critic": Optimiser(behaviour.critic, hyper.critic_lr, **common),
        }

    def update(self, data: Sequences) -> dict[str, Tensor]:
        """One iteration; scalars of it, still on the device."""
        seen, metrics = self.update_world_model(data)
        metrics |= self.update_curiosity(seen, data.is_start)
        if self.updates % self.hyper.behaviour_interval == 0:
            metrics |= self.update_behaviour(seen.states)
        self.updates += 1
        return {name: value.detach() for name, value in metrics.items()}

    def update_world_model(self, data: Sequences) -> tuple[Observed, dict[str, Tensor]]:
        """Equation (1)."""
        model = self.networks.world_model
        noise = self._noise(*data.action.shape, self.hyper.latent_dimension)
        with self._precision():
            loss, seen, metrics = model.loss(data, noise, self._noise(data.action.numel()))
        metrics["model_norm"] = self.optimisers["model"].step(loss)
        return seen.detach(), metrics

    def update_curiosity(self, seen: Observed, is_start: Tensor) -> dict[str, Tensor]:
        """Equation (2), on the states that the world model has just filtered."""
        with self._precision():
            loss, metrics = self.networks.curiosity.loss(seen, is_start)
        metrics["lbs_norm"] = self.optimisers["curiosity"].step(loss)
        return metrics

    def update_behaviour(self, states: State) -> dict[str, Tensor]:
        """Equation (3): imagine from states (T, B, ...), then a step of the actor and one of the critic."""
        hyper, networks, behaviour = self.hyper, self.networks, self.networks.behaviour
        if self.behaviour_updates % hyper.slow_critic_interval == 0:
            behaviour.update_slow_critic()
        self.behaviour_updates += 1
        with self._precision():
            imagined = behaviour.imagine(networks.world_model.rssm, *self._starts(states))
            features, action = imagined
            reward = networks.curiosity.reward(features).detach()
            scaled = networks.stream_norm(reward)
            value = behaviour.slow_values(features)
            target, advantage = targets_and_advantage(scaled, value, hyper.gamma, hyper.return_lambda)
            actor_loss, entropy = behaviour.actor_loss(
                features[:-2], action[:-1], advantage, hyper.gamma, hyper.entropy)
            critic_loss = behaviour.critic_loss(features[:-1], target, hyper.gamma)
        metrics = {
            "lbs_reward": reward.mean(), "lbs_reward_deviation": reward.std(), "reward": scaled.mean(),
            "reward_deviation": scaled.std(), "reward_magnitude": networks.stream_norm.magnitude.clone(),
            "critic_value": value.mean(), "critic_target": target.mean(), "critic_loss": critic_loss,
            "advantage": advantage.mean(), "advantage_deviation": advantage.std(),
            "actor_loss": actor_loss, "actor_entropy": entropy,
            "imagined_forward": (action == 0).float().mean(), "imagined_left": (action == 1).float().mean(),
            "imagined_right": (action == 2).float().mean(),
        }
        metrics["actor_norm"] = self.optimisers["actor"].step(actor_loss)
        metrics["critic_norm"] = self.optimisers["critic"].step(critic_loss)
        return metrics

    def _starts(self, states: State) -> tuple[State, Tensor]:
        """States (N, ...) to imagine from, chosen among (T, B, ...), and noise (H, N, S + 1)."""
        deter, stoch = (part.flatten(0, 1) for part in states)
        count = min(self.hyper.imagination_starts, len(deter))
        chosen = choose(len(deter), count, self._noise(len(deter)))
        return (State(deter[chosen], stoch[chosen]),
                self._noise(self.hyper.horizon, count, self.hyper.latent_dimension + 1))

    def _noise(self, *shape: int) -> Tensor:
        """Uniform in [0, 1), from the agent's own generator."""
        return torch.rand(shape, generator=self.generator, device=self.device)

    def _precision(self) -> torch.autocast:
        enabled = self.hyper.precision is agent_schema.Precision.bfloat16
        return torch.autocast(self.device.type, torch.bfloat16, enabled=enabled)
