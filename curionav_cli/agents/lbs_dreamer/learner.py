"""One update of all that learns, in this order: world model, curiosity, then actor and critic on imagined rollouts.

    update_world_model   equation (1)   world_model.py
    update_curiosity     equation (2)   curiosity/, the intrinsic reward
    update_behaviour     equation (3)   behaviour.py, returns.py

Letters: T steps, B sequences, H horizon, N rollouts, S latents.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict
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
from curionav_cli.options import chosen


class Networks(nn.Module):
    """All networks and running means: the content of `weights.safetensors`. actions: names of the actions (A)."""

    def __init__(self, hyper: lbs_settings.LBSDreamer):
        super().__init__()
        self.actions = chosen(asdict(hyper)).names
        self.world_model = WorldModel(hyper, len(self.actions))
        rssm = self.world_model.rssm
        self.curiosity = curiosity(hyper, rssm)
        self.behaviour = Behaviour(rssm.features, rssm.actions, hyper.mlp_units, hyper.mlp_layers, rssm.stoch)
        self.stream_norm = StreamNorm(hyper.reward_momentum, hyper.reward_centring)


def build_networks(hyper: lbs_settings.LBSDreamer, generator: torch.Generator, device: torch.device) -> Networks:
    """Make networks whose first weights come from `generator` alone, the same on every device."""
    with torch.random.fork_rng(devices=[]):  # torch's own first weights; on the meta device it would load its compiler
        networks = Networks(hyper)
    initialise(networks, generator)
    networks.stream_norm.reset()
    networks.behaviour.update_slow_critic()
    return networks.to(device)


class Noise(NamedTuple):
    """All random numbers of one update, uniform in [0, 1); the last two only where behaviour is learned."""

    latents: Tensor  # (T, B, S)
    frames: Tensor  # (T * B,), their order chooses the frames to be decoded
    curiosity: Tensor  # (T, B)
    starts: Tensor | None = None  # (T * B,), their order chooses the states to imagine from
    imagined: Tensor | None = None  # (H, N, S + 1)


class Learner:
    """Updates the networks, each with its optimiser; `updates` and `behaviour_updates` count what was done.

    generator: of all randomness in updates. record: how `compute` is run (compile.py). Counters and random numbers
    stay in Python; `compute` is tensors only and waits for no value, so that it can be a CUDA graph
    (kernels/cuda_graphs.py).
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
        self.run = {with_behaviour: record(self.compute, state) for with_behaviour in (True, False)}

    def update(self, data: Sequences) -> dict[str, Tensor]:
        """Learn from one batch; returns scalar metrics on the device, which the next update may overwrite."""
        with_behaviour = self.count()
        return self.run[with_behaviour](data, self.draw(data.action.shape, with_behaviour))

    def count(self) -> bool:
        """Count an update, and tell whether it learns behaviour; first copies the slow critic where that is due."""
        acts = self.hyper.behaviour is lbs_settings.BehaviourKind.actor  # a search needs no actor
        with_behaviour = acts and self.updates % self.hyper.behaviour_interval == 0
        if with_behaviour:
            if self.behaviour_updates % self.hyper.slow_critic_interval == 0:
                self.networks.behaviour.update_slow_critic()
            self.behaviour_updates += 1
        self.updates += 1
        return with_behaviour

    def draw(self, shape: torch.Size, with_behaviour: bool) -> Noise:
        """Draw the random numbers of an update for a batch of `shape` (T, B)."""
        frames, latents = shape.numel(), self.hyper.latent_dimension
        noise = Noise(self._uniform(*shape, latents), self._uniform(frames), self._uniform(*shape))
        if not with_behaviour:
            return noise
        count = min(self.hyper.imagination_starts, frames)
        return noise._replace(starts=self._uniform(frames),
                              imagined=self._uniform(self.hyper.horizon, count, latents + 1))

    def compute(self, data: Sequences, noise: Noise) -> dict[str, Tensor]:
        """Run the three parts of an update; metrics on the device."""
        observed, metrics = self.update_world_model(data, noise)
        metrics |= self.update_curiosity(observed, data, noise.curiosity)
        if noise.starts is not None and noise.imagined is not None:
            metrics |= self.update_behaviour(observed.states, noise.starts, noise.imagined)
        return {name: value.detach() for name, value in metrics.items()}

    def update_world_model(self, data: Sequences, noise: Noise) -> tuple[Observed, dict[str, Tensor]]:
        """Equation (1): a step of encoder, RSSM and decoder; returns the filtered steps, detached, and metrics."""
        with self._precision():
            loss, observed, metrics = self.networks.world_model.loss(data, noise.latents, noise.frames)
        metrics["model_norm"] = self.optimisers["model"].step(loss)
        return observed.detach(), metrics

    def update_curiosity(self, observed: Observed, data: Sequences, noise: Tensor) -> dict[str, Tensor]:
        """Equation (2): a step of the network that predicts the intrinsic reward, on the steps just filtered."""
        metrics = {"kl": latent.kl(observed.posterior, observed.prior).mean()}
        if "curiosity" in self.optimisers:
            with self._precision():
                loss, scalars = self.networks.curiosity.loss(observed, data, noise)
            metrics |= scalars | {"curiosity_loss": loss, "curiosity_norm": self.optimisers["curiosity"].step(loss)}
        return metrics

    def update_behaviour(self, states: State, start_noise: Tensor, noise: Tensor) -> dict[str, Tensor]:
        """Equation (3): a step of the actor and one of the critic, on N rollouts imagined from states (T, B, ...).

        The curiosity's reward of arriving in each imagined state, normalised (stream_norm.py), makes lambda returns
        (returns.py): the critic's targets. The actor's advantages are these minus the slow critic's values
        (behaviour.py).
        start_noise (T * B,) chooses the N states; noise (H, N, S + 1) draws latents and actions.
        """
        hyper, networks, behaviour = self.hyper, self.networks, self.networks.behaviour
        with self._precision():
            start = chosen_states(states, noise.shape[1], start_noise)  # (N, ...)
            imagined = behaviour.imagine(networks.world_model.rssm, start, noise)
            intrinsic = networks.curiosity.intrinsic_reward(imagined).detach()  # (H + 1, N)
            reward = networks.stream_norm(intrinsic)
            value = behaviour.slow_values(imagined)  # (H + 1, N)
            target, advantage = targets_and_advantage(reward, value, hyper.gamma, hyper.return_lambda)
            actor_loss, entropy = behaviour.actor_loss(imagined, advantage, hyper.gamma, hyper.entropy)
            critic_loss = behaviour.critic_loss(imagined, target, hyper.gamma)
        metrics = {
            **spread("curiosity_reward", intrinsic), **spread("reward", reward),
            "reward_magnitude": networks.stream_norm.magnitude.clone(), "critic_value": value.mean(),
            "critic_target": target.mean(), "critic_loss": critic_loss, **spread("advantage", advantage),
            "actor_loss": actor_loss, "actor_entropy": entropy, **action_shares(imagined.action, networks.actions),
        }
        metrics["actor_norm"] = self.optimisers["actor"].step(actor_loss)
        metrics["critic_norm"] = self.optimisers["critic"].step(critic_loss)
        return metrics

    def _uniform(self, *shape: int) -> Tensor:
        return torch.rand(shape, generator=self.generator, device=self.device)

    def _precision(self) -> AbstractContextManager:
        assert self.hyper.precision is not lbs_settings.Precision.auto, "build.agent replaces it"
        if self.hyper.precision is lbs_settings.Precision.float32:
            return nullcontext()
        return torch.autocast(self.device.type, torch.bfloat16)


def chosen_states(states: State, count: int, noise: Tensor) -> State:
    """Draw N = `count` of the states (T, B, ...) by the order of `noise` (T * B,): (N, ...)."""
    deter, stoch = (part.flatten(0, 1) for part in states)
    chosen = choose(len(deter), count, noise)
    return State(deter[chosen], stoch[chosen])


def spread(name: str, x: Tensor) -> dict[str, Tensor]:
    """Mean and standard deviation of x, as metrics."""
    return {name: x.mean(), f"{name}_deviation": x.std()}


def action_shares(action: Tensor, names: Sequence[str]) -> dict[str, Tensor]:
    """The share of each action among imagined ones, as metrics."""
    return {f"imagined_{name}": (action == number).float().mean() for number, name in enumerate(names)}
