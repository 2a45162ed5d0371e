"""Actor and critic, trained on imagined lives (paper, equation (3); DreamerV2, section 2.2).

Letters: H horizon, N imagined lives, F features, A actions. States z_0 ... z_H; action i + 1 leads
from z_i to z_{i+1}; reward i is that of arriving in z_i.
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
    """N lives of H steps, without gradients."""

    features: Tensor  # (H + 1, N, F)
    action: Tensor  # (H, N) int64, action[i] is taken in z_i
    ones: Tensor | None = None  # (H + 1, N, S) int64, RSSM.ones of the states
    actor: Sequence[Tensor] = ()  # what the actor's layers made of z_0 ... z_{H-1}, (H, N, ...) each, its logits last

    def first(self, steps: int) -> Imagined:
        """The first of z_0, z_1 ... and what was done there."""
        return Imagined(self.features[:steps], self.action[:steps], None if self.ones is None else self.ones[:steps],
                        [layer[:steps] for layer in self.actor])


class Behaviour(nn.Module):
    """pi_expl(a | s), v_expl(s), and a slow copy of v_expl that returns are computed with."""

    def __init__(self, features: int, actions: int, units: int, layers: int, hot: int = 0):
        super().__init__()
        self.actor = MLP(features, units, layers, actions, hot)
        self.critic = MLP(features, units, layers, 1, hot)
        self.slow_critic = MLP(features, units, layers, 1, hot).requires_grad_(False)

    def act(self, features: Tensor, noise: Tensor) -> Tensor:
        """Actions drawn by uniform noise: (N, F), (N,) -> (N,) int64."""
        return drawn(self.actor.activations(features)[-1], noise)

    @torch.no_grad()
    def imagine(self, rssm: RSSM, start: State, noise: Tensor) -> Imagined:
        """Live H steps from N states. noise (H, N, S + 1): the last for the action, the others for z."""
        state, features, ones, actions, layers = start, [start.features], [rssm.ones(start)], [], []
        for step in noise:
            layers.append(self.actor.activations(features[-1], ones[-1]))
            action = drawn(layers[-1][-1], step[:, -1])
            state = rssm.imagine(state, rssm.action_input(action), step[:, :-1], ones[-1])
            features.append(state.features)
            ones.append(rssm.ones(state))
            actions.append(action)
        known = [some for some in ones if some is not None]
        return Imagined(torch.stack(features), torch.stack(actions), torch.stack(known) if known else None,
                        [torch.stack(layer) for layer in zip(*layers, strict=True)])

    @torch.no_grad()
    def update_slow_critic(self) -> None:
        for slow, fast in zip(self.slow_critic.parameters(), self.critic.parameters(), strict=True):
            slow.copy_(fast)

    @torch.no_grad()
    def slow_values(self, imagined: Imagined) -> Tensor:
        """(H + 1, N)"""
        return self.slow_critic(imagined.features, imagined.ones).squeeze(-1).float()

    def critic_loss(self, imagined: Imagined, target: Tensor, gamma: float) -> Tensor:
        """-log N(target; v, 1) without its constant, of the first M states: target (M, N) -> scalar."""
        states = imagined.first(len(target))
        value = self.critic(states.features, states.ones).squeeze(-1).float()
        weight = discount_weights(len(target), gamma, target)
        return (weight * (value - target).square()).mean() / 2

    def actor_loss(self, imagined: Imagined, advantage: Tensor, gamma: float, scale: float) -> tuple[Tensor, Tensor]:
        """REINFORCE with entropy bonus, of the first M states: advantage (M, N) -> loss and mean policy entropy."""
        states = imagined.first(len(advantage))
        assert states.action.shape == advantage.shape
        log_policy = F.log_softmax(self.actor(states.features, known=states.actor).float(), -1)
        chosen = log_policy.gather(-1, states.action[..., None]).squeeze(-1)
        entropy = -(log_policy.exp() * log_policy).sum(-1)
        weight = discount_weights(len(advantage), gamma, advantage)
        return -(weight * (chosen * advantage.detach() + scale * entropy)).mean(), entropy.mean()


def drawn(logits: Tensor, noise: Tensor) -> Tensor:
    """Actions of a policy, by uniform noise: (N, A), (N,) -> (N,) int64."""
    return latent.inverse_cdf(logits.float().softmax(-1), noise)


def targets_and_advantage(reward: Tensor, value: Tensor, gamma: float, lam: float) -> tuple[Tensor, Tensor]:
    """reward, value (H + 1, N), by the slow critic -> target (H, N) of z_0 ... z_{H-1}, advantage (H - 1, N).

    As in DreamerV2 the action taken in z_i is judged by target_{i+1} - v(z_i): that leaves out the
    reward of arriving in z_i, which no action taken there can change.
    """
    target = lambda_return(reward[:-1], value[:-1], value[-1], gamma, lam)
    return target, target[1:] - value[:-2]
