"""The recurrent state-space model (paper, section III-A; DreamerV2, section 2.1).

    Recurrence  h_t = f(h_{t-1}, z_{t-1}, a_{t-1})     Posterior  q(z_t | h_t, x_t)
                                                        Dynamics   p(z_t | h_t)

Letters: T steps, B sequences, D GRU units, U hidden units, S latents, C classes, E embedding, A actions.
The action of step t is the one that led to it; the first step of a life has none (index -1).
"""

from __future__ import annotations

from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.kernels.elu import elu_
from curionav_cli.agents.lbs_dreamer.kernels.mlp import columns_of, summed
from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import PLAIN, Weights, scan

MANY = 500  # rows from which on a sum of a weight's columns, laid out for that, is quicker than a product


class State(NamedTuple):
    """What the model carries from step to step, or a stack of it."""

    deter: Tensor  # (..., D)
    stoch: Tensor  # (..., S * C), S one-hots one after another

    @property
    def features(self) -> Tensor:
        """(..., S * C + D)"""
        return torch.cat([self.stoch, self.deter], -1)

    def detach(self) -> State:
        return State(self.deter.detach(), self.stoch.detach())


class Observed(NamedTuple):
    """T filtered steps of B sequences: states, and the logits (T, B, S, C) they were drawn from."""

    states: State
    posterior: Tensor
    prior: Tensor

    def detach(self) -> Observed:
        return Observed(self.states.detach(), self.posterior.detach(), self.prior.detach())


def one_hot_action(action: Tensor, actions: int) -> Tensor:
    """(...) int -> (..., A) float; index -1, no action, becomes zeros."""
    return (action[..., None] == torch.arange(actions, device=action.device)).float()


def gru(x: Tensor, deter: Tensor, dense: nn.Linear, norm: nn.LayerNorm) -> Tensor:
    """DreamerV2's GRU cell: one dense layer, one LayerNorm over all three gates.

    The reset gate acts on the candidate, not on the state, and the update gate is biased by -1.
    x (B, U), deter (B, D) -> (B, D)
    """
    gates = dense(torch.cat([x, deter.to(x.dtype)], -1)).to(deter.dtype)
    gates = F.layer_norm(gates, norm.normalized_shape, norm.weight, norm.bias, norm.eps)
    reset, candidate, update = gates.chunk(3, -1)
    candidate = torch.tanh(torch.sigmoid(reset) * candidate)
    return torch.lerp(deter, candidate, torch.sigmoid(update - 1))


class RSSM(nn.Module):
    """Recurrence, dynamics and posterior, with DreamerV2's layer sizes."""

    def __init__(self, embed: int, actions: int, deter: int, hidden: int, latents: int, classes: int):
        super().__init__()
        self.actions, self.deter, self.latents, self.classes = actions, deter, latents, classes
        self.stoch = latents * classes
        self.steps = PLAIN
        self.img_in = nn.Linear(self.stoch + actions, hidden)
        self.gru = nn.Linear(hidden + deter, 3 * deter)
        self.gru_norm = nn.LayerNorm(3 * deter, eps=1e-3)
        self.img_out = nn.Linear(deter, hidden)
        self.img_dist = nn.Linear(hidden, self.stoch)
        self.obs_out = nn.Linear(deter + embed, hidden)
        self.obs_dist = nn.Linear(hidden, self.stoch)

    @property
    def features(self) -> int:
        return self.stoch + self.deter

    def ones(self, state: State) -> Tensor | None:
        """Which numbers of stoch are its one-hots' ones, (..., S) int64; None where sums by them would not pay."""
        if state.stoch.device.type != "cpu" or len(state.stoch) < MANY:
            return None
        hot = state.stoch.unflatten(-1, (self.latents, self.classes))
        return (hot @ torch.arange(self.classes, dtype=hot.dtype)).long() + self.classes * torch.arange(self.latents)

    def initial(self, batch: int) -> State:
        """The state before an episode, or before a sequence cut out of one: zeros."""
        weight = self.img_in.weight
        return State(weight.new_zeros(batch, self.deter), weight.new_zeros(batch, self.stoch))

    def action_input(self, action: Tensor) -> Tensor:
        """The action's share of the recurrence's first layer: (...) int -> (..., U)."""
        weight = self.img_in.weight[:, self.stoch:]
        return F.linear(one_hot_action(action, self.actions).to(weight.dtype), weight, self.img_in.bias)

    def embed_input(self, embed: Tensor) -> Tensor:
        """The observation's share of the posterior's first layer: (..., E) -> (..., U)."""
        return F.linear(embed, self.obs_out.weight[:, self.deter:], self.obs_out.bias)

    def recur(self, state: State, action_input: Tensor, ones: Tensor | None = None) -> Tensor:
        """h_t from step t - 1 and the action between: (B, D). ones: of the state, if they are known."""
        weight = self.img_in.weight[:, :self.stoch]
        if ones is None:
            x = F.elu(torch.addmm(action_input, state.stoch, weight.t()))
        else:
            x = elu_(action_input + summed(ones, columns_of(weight)))
        return gru(x, state.deter, self.gru, self.gru_norm)

    def prior(self, deter: Tensor) -> Tensor:
        """Logits of p(z_t | h_t): (..., D) -> (..., S, C)."""
        return self.img_dist(F.elu(self.img_out(deter))).unflatten(-1, (self.latents, self.classes))

    def posterior(self, deter: Tensor, embed_input: Tensor) -> Tensor:
        """Logits of q(z_t | h_t, x_t): (B, D), (B, U) -> (B, S, C)."""
        x = F.elu(torch.addmm(embed_input, deter, self.obs_out.weight[:, :self.deter].t()))
        return self.obs_dist(x).unflatten(-1, (self.latents, self.classes))

    def filter(self, state: State, action_input: Tensor, embed_input: Tensor, noise: Tensor
               ) -> tuple[State, Tensor]:
        """One step that sees the observation: the new state, and the posterior's logits."""
        deter = self.recur(state, action_input)
        logits = self.posterior(deter, embed_input)
        return State(deter, latent.sample(logits, noise).flatten(-2)), logits

    def imagine(self, state: State, action_input: Tensor, noise: Tensor, ones: Tensor | None = None) -> State:
        """One step that does not: z_t is drawn from the dynamics, and carries no gradient."""
        deter = self.recur(state, action_input, ones)
        return State(deter, latent.draw(self.prior(deter), noise)[0].flatten(-2))

    def observe(self, state: State, embed: Tensor, action: Tensor, noise: Tensor) -> Observed:
        """Filter T steps. embed (T, B, E), action (T, B) int, noise (T, B, S) uniform in [0, 1).

        What does not depend on the state is computed for all steps at once, outside the scan (rssm_scan.py).
        """
        assert embed.shape[:2] == action.shape == noise.shape[:2], (embed.shape, action.shape, noise.shape)
        deter, stoch, posterior = scan(*state, self.action_input(action), self.embed_input(embed), noise,
                                       self.scan_weights(), self.gru_norm.eps, self.steps)
        return Observed(State(deter, stoch), posterior, self.prior(deter))

    def scan_weights(self) -> Weights:
        """Of one step of filtering; the first layers without the columns whose share is computed outside."""
        return Weights(self.img_in.weight[:, :self.stoch], self.gru.weight, self.gru.bias,
                       self.gru_norm.weight, self.gru_norm.bias, self.obs_out.weight[:, :self.deter],
                       self.obs_dist.weight, self.obs_dist.bias)
