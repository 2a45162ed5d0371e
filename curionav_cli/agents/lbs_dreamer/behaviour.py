"""Actor and critic, trained on imagined rollouts (paper, equation (3); DreamerV2, section 2.2).

    Actor   pi_expl(a_t | s_t)        maximises lambda returns, by REINFORCE with an entropy bonus
    Critic  v_expl(s_t)               learns lambda returns, computed with a slow copy of itself

The reward is intrinsic: curiosity/ has a file for each (lbs.py: equation (2)), learner.py brings them together.

Letters: H horizon, N rollouts, F features, A actions, S latents, M <= H states that a loss is taken of.
Alignment: a rollout has states s_0 ... s_H; action i leads from s_i to s_{i+1}; reward i is that of arriving in s_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.returns import discount_weights, lambda_return
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State


class Imagined(NamedTuple):
    """N imagined rollouts of H steps, without gradients; the last two fields only save work (kernels/mlp.py)."""

    features: Tensor  # (H + 1, N, F), of s_0 ... s_H
    action: Tensor  # (H, N) int64
    ones: Tensor | None = None  # (H + 1, N, S) int64, RSSM.ones of the states
    actor_layers: Sequence[Tensor] = ()  # MLP.activations of the actor in s_0 ... s_{H-1}, (H, N, ...) each

    def first(self, steps: int) -> Imagined:
        """The first `steps` states, and the actions taken there."""
        return Imagined(self.features[:steps], self.action[:steps], None if self.ones is None else self.ones[:steps],
                        [layer[:steps] for layer in self.actor_layers])


class Behaviour(nn.Module):
    """pi_expl(a | s), v_expl(s), and the slow copy of v_expl.

    features, actions, units, layers: F, A, and the size of the MLPs; hot: how many features are one-hots (S * C).
    """

    def __init__(self, features: int, actions: int, units: int, layers: int, hot: int = 0):
        super().__init__()
        self.actor = MLP(features, units, layers, actions, hot)
        self.critic = MLP(features, units, layers, 1, hot)
        self.slow_critic = MLP(features, units, layers, 1, hot).requires_grad_(False)

    @torch.no_grad()
    def imagine(self, dynamics: RSSM, start: State, noise: Tensor) -> Imagined:
        """Roll out H steps of policy and dynamics from N states.

        noise (H, N, S + 1) uniform in [0, 1): the first S numbers for z, the last for the action.
        """
        state, features, ones, actions, layers = start, [start.features], [dynamics.ones(start)], [], []
        columns = None if ones[0] is None else self.actor.columns()
        for step in noise:  # (N, S + 1)
            layers.append(self.actor.activations(features[-1], ones[-1], columns))
            actions.append(sample_action(layers[-1][-1], step[:, -1]))
            state, index = dynamics.roll(state, actions[-1], step[:, :-1], ones[-1])
            features.append(state.features)
            ones.append(index)
        known = [index for index in ones if index is not None]
        return Imagined(torch.stack(features), torch.stack(actions), torch.stack(known) if known else None,
                        [torch.stack(layer) for layer in zip(*layers, strict=True)])

    @torch.no_grad()
    def update_slow_critic(self) -> None:
        """Copy the critic's weights into the slow critic."""
        for slow, fast in zip(self.slow_critic.parameters(), self.critic.parameters(), strict=True):
            slow.copy_(fast)

    @torch.no_grad()
    def slow_values(self, imagined: Imagined) -> Tensor:
        """The slow critic's values of s_0 ... s_H: (H + 1, N) float32."""
        return self.slow_critic(imagined.features, imagined.ones).squeeze(-1).float()

    def critic_loss(self, imagined: Imagined, target: Tensor, gamma: float) -> Tensor:
        """-log N(target; v, 1) without its constant, weighted by discounts, of M states: target (M, N) -> scalar."""
        states = imagined.first(len(target))
        value = self.critic(states.features, states.ones).squeeze(-1).float()  # (M, N)
        weight = discount_weights(len(target), gamma, target)  # (M, 1)
        return (weight * (value - target).square()).mean() / 2

    def actor_loss(self, imagined: Imagined, advantage: Tensor, gamma: float, scale: float) -> tuple[Tensor, Tensor]:
        """-(log pi(a | s) advantage + scale * entropy), weighted by discounts, of M states: advantage (M, N).

        Returns the scalar loss and the policy's mean entropy in nats.
        """
        states = imagined.first(len(advantage))
        assert states.action.shape == advantage.shape
        log_policy = F.log_softmax(self.actor(states.features, known=states.actor_layers).float(), -1)  # (M, N, A)
        log_prob = log_policy.gather(-1, states.action[..., None]).squeeze(-1)  # (M, N)
        entropy = -(log_policy.exp() * log_policy).sum(-1)  # (M, N)
        weight = discount_weights(len(advantage), gamma, advantage)  # (M, 1)
        return -(weight * (log_prob * advantage.detach() + scale * entropy)).mean(), entropy.mean()


def sample_action(logits: Tensor, noise: Tensor) -> Tensor:
    """Draw actions from a policy's logits (N, A) by uniform noise (N,): (N,) int64."""
    return latent.inverse_cdf(logits.float().softmax(-1), noise)


def targets_and_advantage(reward: Tensor, value: Tensor, gamma: float, lam: float) -> tuple[Tensor, Tensor]:
    """Lambda returns (H, N) of s_0 ... s_{H-1}, and advantages (H - 1, N) of the actions taken in s_0 ... s_{H-2}.

    reward (H + 1, N); value (H + 1, N), of the slow critic. As in DreamerV2 the action taken in s_i has the advantage
    target_{i+1} - v(s_i): that leaves out the reward of arriving in s_i, which no action taken there can change.
    """
    target = lambda_return(reward[:-1], value[:-1], value[-1], gamma, lam)
    return target, target[1:] - value[:-2]
