"""Actor and critic, trained on imagined lives (paper, equation (3); DreamerV2, section 2.2).

Letters: H horizon, N imagined lives, F features, A actions. States z_0 ... z_H; action i + 1 leads
from z_i to z_{i+1}; reward i is that of arriving in z_i.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer import latent
from curionav_cli.agents.lbs_dreamer.networks import MLP
from curionav_cli.agents.lbs_dreamer.returns import discount_weights, lambda_return
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State


class Imagined(NamedTuple):
    """N lives of H steps, without gradients."""

    features: Tensor  # (H + 1, N, F)
    action: Tensor  # (H, N) int64, action[i] is taken in z_i


class Behaviour(nn.Module):
    """pi_expl(a | s), v_expl(s), and a slow copy of v_expl that returns are computed with."""

    def __init__(self, features: int, actions: int, units: int, layers: int):
        super().__init__()
        self.actor = MLP(features, units, layers, actions)
        self.critic = MLP(features, units, layers, 1)
        self.slow_critic = MLP(features, units, layers, 1).requires_grad_(False)

    def act(self, features: Tensor, noise: Tensor) -> Tensor:
        """Actions drawn by uniform noise: (N, F), (N,) -> (N,) int64."""
        return latent.inverse_cdf(self.actor(features).float().softmax(-1), noise)

    @torch.no_grad()
    def imagine(self, rssm: RSSM, start: State, noise: Tensor) -> Imagined:
        """Live H steps from N states. noise (H, N, S + 1): the last for the action, the others for z."""
        state, features, actions = start, [start.features], []
        for step in noise:
            action = self.act(features[-1], step[:, -1])
            state = rssm.imagine(state, rssm.action_input(action), step[:, :-1])
            features.append(state.features)
            actions.append(action)
        return Imagined(torch.stack(features), torch.stack(actions))

    @torch.no_grad()
    def update_slow_critic(self) -> None:
        for slow, fast in zip(self.slow_critic.parameters(), self.critic.parameters(), strict=True):
            slow.copy_(fast)

    @torch.no_grad()
    def slow_values(self, features: Tensor) -> Tensor:
        """(..., F) -> (...)"""
        return self.slow_critic(features).squeeze(-1).float()

    def critic_loss(self, features: Tensor, target: Tensor, gamma: float) -> Tensor:
        """-log N(target; v, 1) without its constant: features (H, N, F), target (H, N) -> scalar."""
        value = self.critic(features).squeeze(-1).float()
        weight = discount_weights(len(target), gamma, target)
        return (weight * (value - target).square()).mean() / 2

    def actor_loss(self, features: Tensor, action: Tensor, advantage: Tensor, gamma: float, scale: float
                   ) -> tuple[Tensor, Tensor]:
        """REINFORCE with entropy bonus: (M, N, F), (M, N), (M, N) -> loss and mean policy entropy."""
        assert features.shape[:2] == action.shape == advantage.shape
        log_policy = F.log_softmax(self.actor(features).float(), -1)
        chosen = log_policy.gather(-1, action[..., None]).squeeze(-1)
        entropy = -(log_policy.exp() * log_policy).sum(-1)
        weight = discount_weights(len(action), gamma, advantage)
        return -(weight * (chosen * advantage.detach() + scale * entropy)).mean(), entropy.mean()


def targets_and_advantage(reward: Tensor, value: Tensor, gamma: float, lam: float) -> tuple[Tensor, Tensor]:
    """reward, value (H + 1, N), by the slow critic -> target (H, N) of z_0 ... z_{H-1}, advantage (H - 1, N).

    As in DreamerV2 the action taken in z_i is judged by target_{i+1} - v(z_i): that leaves out the
    reward of arriving in z_i, which no action taken there can change.
    """
    target = lambda_return(reward[:-1], value[:-1], value[-1], gamma, lam)
    return target, target[1:] - value[:-2]
