"""One update of everything that learns: world model, curiosity, actor and critic, in this order."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import NamedTuple

import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.behaviour import Behaviour, targets_and_advantage
from curionav_cli.agents.lbs_dreamer.curiosity.choose import curiosity
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import Record, as_it_is
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.rssm import Observed, State
from curionav_cli.agents.lbs_dreamer.stream_norm import StreamNorm
from curionav_cli.agents.lbs_dreamer.world_model import Sequences, WorldModel, choose
from curionav_cli.constants import ACTIONS


class Networks(nn.Module):
    """Everything with weights; what `weights.safetensors` holds."""

    def __init__(self, hyper: lbs_settings.LBSDreamer):
        super().__init__()
        self.world_model = WorldModel(hyper, len(ACTIONS))
        rssm = self.world_model.rssm
        self.curiosity = curiosity(hyper, rssm)
        self.behaviour = Behaviour(rssm.features, len(ACTIONS), hyper.mlp_units, hyper.mlp_layers, rssm.stoch)
        self.stream_norm = StreamNorm(hyper.reward_momentum, hyper.reward_centring)


def build_networks(hyper: lbs_settings.LBSDreamer, generator: torch.Generator, device: torch.device) -> Networks:
    """Made without drawing from torch's global generator, the same on every device."""
    with torch.device("meta"):
        networks = Networks(hyper)
    networks.to_empty(device="cpu")
    initialise(networks, generator)
    networks.stream_norm.reset()
    networks.behaviour.update_slow_critic()
    return networks.to(device)


class Noise(NamedTuple):
    """All that one update leaves to chance, uniform in [0, 1); the last two where behaviour is learned."""

    latents: Tensor  # (T, B, S)
    frames: Tensor  # (T * B,), their order is that of the frames to be decoded
    curiosity: Tensor  # (T, B)
    starts: Tensor | None = None  # (T * B,), their order is that of the states to imagine from
    imagined: Tensor | None = None  # (H, N, S + 1)


class Learner:
    """Networks and their optimisers. `updates` and `behaviour_updates` count what was done.

    An update is counting and drawing, which stay in Python, and `compute`, which is tensors only: it
    asks nothing of the host, so that `record` can make a CUDA graph of it (cuda_graphs.py).
    """

    def __init__(self, hyper: lbs_settings.LBSDreamer, networks: Networks, generator: torch.Generator,
                 record: Record = as_it_is):
        self.hyper, self.networks, self.generator = hyper, networks, generator
        self.device = generator.device
        self.updates = self.behaviour_updates = 0
        common = {"epsilon": hyper.adam_epsilon, "decay": hyper.weight_decay, "clip": hyper.clip}
        behaviour = networks.behaviour
        self.optimisers = {
            "model": Optimiser(networks.world_model, hyper.model_lr, **common),
            "actor": Optimiser(behaviour.actor, hyper.actor_lr, **common),
            "critic": Optimiser(behaviour.critic, hyper.critic_lr, **common),
        }
        if any(parameter.requires_grad for parameter in networks.curiosity.parameters()):
            self.optimisers["curiosity"] = Optimiser(networks.curiosity, hyper.model_lr, **common)
        state = [*networks.state_dict().values(),
                 *(tensor for optimiser in self.optimisers.values() for tensor in optimiser.state().values())]
        self.run = {imagines: record(self.compute, state) for imagines in (True, False)}

    def update(self, data: Sequences) -> dict[str, Tensor]:
        """One iteration; scalars of it, on the device, where the next update may overwrite them."""
        imagines = self.count()
        return self.run[imagines](data, self.draw(data.action.shape, imagines))

    def count(self) -> bool:
        """Does the update that begins now learn behaviour too? The slow critic follows where it is due."""
        imagines = self.updates % self.hyper.behaviour_interval == 0
        if imagines:
            if self.behaviour_updates % self.hyper.slow_critic_interval == 0:
                self.networks.behaviour.update_slow_critic()
            self.behaviour_updates += 1
        self.updates += 1
        return imagines

    def draw(self, shape: torch.Size, imagines: bool) -> Noise:
        """For a batch of `shape` (T, B), from the agent's own generator."""
        frames, latents = shape.numel(), self.hyper.latent_dimension
        noise = Noise(self._uniform(*shape, latents), self._uniform(frames), self._uniform(*shape))
        if not imagines:
            return noise
        count = min(self.hyper.imagination_starts, frames)
        return noise._replace(starts=self._uniform(frames),
                              imagined=self._uniform(self.hyper.horizon, count, latents + 1))

    def compute(self, data: Sequences, noise: Noise) -> dict[str, Tensor]:
        """Everything of an update that happens on the device."""
        seen, metrics = self.update_world_model(data, noise)
        metrics |= self.update_curiosity(seen, data, noise.curiosity)
        if noise.starts is not None and noise.imagined is not None:
            metrics |= self.update_behaviour(seen.states, noise.starts, noise.imagined)
        return {name: value.detach() for name, value in metrics.items()}

    def update_world_model(self, data: Sequences, noise: Noise) -> tuple[Observed, dict[str, Tensor]]:
        """Equation (1)."""
        with self._precision():
            loss, seen, metrics = self.networks.world_model.loss(data, noise.latents, noise.frames)
        metrics["model_norm"] = self.optimisers["model"].step(loss)
        return seen.detach(), metrics

    def update_curiosity(self, seen: Observed, data: Sequences, noise: Tensor) -> dict[str, Tensor]:
        """Equation (2), on the states that the world model has just filtered."""
        metrics = {"kl": latent.kl(seen.posterior, seen.prior).mean()}
        if "curiosity" in self.optimisers:
            with self._precision():
                loss, scalars = self.networks.curiosity.loss(seen, data, noise)
            metrics |= scalars | {"curiosity_loss": loss, "curiosity_norm": self.optimisers["curiosity"].step(loss)}
        return metrics

    def update_behaviour(self, states: State, start_noise: Tensor, noise: Tensor) -> dict[str, Tensor]:
        """Equation (3): imagine from states (T, B, ...), then a step of the actor and one of the critic."""
        hyper, networks, behaviour = self.hyper, self.networks, self.networks.behaviour
        with self._precision():
            starts = chosen_states(states, noise.shape[1], start_noise)
            imagined = behaviour.imagine(networks.world_model.rssm, starts, noise)
            reward = networks.curiosity.reward(imagined).detach()
            scaled = networks.stream_norm(reward)
            value = behaviour.slow_values(imagined)
            target, advantage = targets_and_advantage(scaled, value, hyper.gamma, hyper.return_lambda)
            actor_loss, entropy = behaviour.actor_loss(imagined, advantage, hyper.gamma, hyper.entropy)
            critic_loss = behaviour.critic_loss(imagined, target, hyper.gamma)
        action = imagined.action
        metrics = {
            "curiosity_reward": reward.mean(), "curiosity_reward_deviation": reward.std(), "reward": scaled.mean(),
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

    def _uniform(self, *shape: int) -> Tensor:
        return torch.rand(shape, generator=self.generator, device=self.device)

    def _precision(self) -> AbstractContextManager:
        assert self.hyper.precision is not lbs_settings.Precision.auto, "build.agent chooses"
        if self.hyper.precision is lbs_settings.Precision.float32:
            return nullcontext()
        return torch.autocast(self.device.type, torch.bfloat16)


def chosen_states(states: State, count: int, noise: Tensor) -> State:
    """`count` of the states (T, B, ...) as (N, ...), by the order of `noise` (T * B,)."""
    deter, stoch = (part.flatten(0, 1) for part in states)
    chosen = choose(len(deter), count, noise)
    return State(deter[chosen], stoch[chosen])
