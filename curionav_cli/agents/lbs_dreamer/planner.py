"""The policy by which the agent acts: the actor that imagination has trained, or a short search in imagination.

The search follows every sequence a_1 ... a_d of d = agent.plan_depth actions (of options, where agent.options says so)
through the dynamics, in J = agent.plan_samples rollouts each, and values an action by its best sequence:

    Q(a) = max over a_2 ... a_d of 1/J sum_j sum_k gamma^(k-1) r(s_jk),    a_1 = a,    s_jk ~ p(s_k | s_jk-1, a_k)
    pi(a) = softmax(Q(a) / (tau m)),    m = mean over a of |Q(a)|,    tau = agent.plan_temperature

r is the intrinsic reward that curiosity/ gives to imagined states; for LBS a head's prediction of the surprise. m makes
the temperature a share of what an action is worth, the same for every unit of reward. All sequences see the same random
numbers, so that their difference is less noisy than their values. It is exhaustive open-loop planning in latent space
(Hafner et al., 2019, "Learning Latent Dynamics for Planning from Pixels", section 2.2 and algorithm 2, who search among
continuous actions by the cross-entropy method), with Boltzmann exploration on its values (Sutton and Barto, 2018,
section 2.8).

Letters: A actions, J samples, d depth, N = A^k sequences of k actions, S latents.
"""

from __future__ import annotations

from typing import Protocol

import torch
from torch import Tensor

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.learner import Networks
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State

TINY = 1e-8  # keeps a reward of zero everywhere from a division by zero: all actions are then alike


class Policy(Protocol):
    """Prefers actions in a model state. weights: names of networks that it needs, beside encoder and RSSM, begin so.

    noise: shape of the random numbers of one choice, beside those of `sample_action`; () for none.
    """

    weights: str
    noise: tuple[int, ...]

    def logits(self, state: State, noise: Tensor | None) -> Tensor:
        """Logits (1, A) of the actions in a state (1, ...); noise: of that shape, uniform in [0, 1)."""


class Actor:
    """The trained actor."""

    weights = "behaviour.actor."
    noise: tuple[int, ...] = ()

    def __init__(self, networks: Networks):
        self.actor = networks.behaviour.actor

    def logits(self, state: State, noise: Tensor | None) -> Tensor:
        return self.actor.activations(state.features)[-1]


class Planner:
    """The search. Actor and critic stay as they were made."""

    weights = "curiosity."

    def __init__(self, networks: Networks, hyper: lbs_settings.LBSDreamer):
        self.rssm, self.curiosity = networks.world_model.rssm, networks.curiosity
        self.gamma, self.temperature = hyper.gamma, hyper.plan_temperature
        self.noise: tuple[int, ...] = (hyper.plan_depth, hyper.plan_samples, hyper.latent_dimension)

    def logits(self, state: State, noise: Tensor | None) -> Tensor:
        assert noise is not None
        values = search(self.rssm, self.curiosity, state, noise, self.gamma)
        return (values / (self.temperature * values.abs().mean() + TINY))[None]


def policy(networks: Networks, hyper: lbs_settings.LBSDreamer) -> Policy:
    """The policy that agent.behaviour names."""
    return Planner(networks, hyper) if hyper.behaviour is lbs_settings.BehaviourKind.plan else Actor(networks)


@torch.no_grad()
def search(rssm: RSSM, curiosity: Curiosity, start: State, noise: Tensor, gamma: float) -> Tensor:
    """Q (A,) of the actions in a state (1, ...): noise (d, J, S) uniform in [0, 1)."""
    samples = noise.shape[1]
    state = State(*(part.expand(samples, -1) for part in start))  # (N * J, ...), N sequences of no action
    value = noise.new_zeros(1)  # (N,)
    for step, drawn in enumerate(noise):
        state, reward = follow(rssm, curiosity, state, drawn)
        value = value.repeat_interleave(rssm.actions) + gamma**step * reward
    return value.view(rssm.actions, -1).amax(1)


def follow(rssm: RSSM, curiosity: Curiosity, state: State, noise: Tensor) -> tuple[State, Tensor]:
    """Append each of the A actions to N sequences: states (N * J, ...), noise (J, S).

    Returns the states reached (N * A * J, ...), and the mean rewards of arriving there (N * A,).
    """
    samples, actions = len(noise), rssm.actions
    sequences = len(state.deter) // samples
    before = State(*(part.view(sequences, 1, samples, -1).expand(-1, actions, -1, -1).flatten(0, 2) for part in state))
    action = torch.arange(actions, device=noise.device).repeat_interleave(samples).repeat(sequences)  # (N * A * J,)
    ones = rssm.ones(before)
    after = rssm.imagine(before, rssm.action_input(action), noise.repeat(sequences * actions, 1), ones)
    reward = curiosity.of_arriving(before.features, action, after.features)  # (N * A * J,)
    return after, reward.view(-1, samples).mean(1)
