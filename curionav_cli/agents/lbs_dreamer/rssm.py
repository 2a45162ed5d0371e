"""The recurrent state-space model: posterior and dynamics (paper, "World model"; DreamerV2, section 2.1).

The model state s_t = (h_t, z_t) has a deterministic part h_t and S categorical latents z_t. With phi left out:

    Recurrence  h_t = f(h_{t-1}, z_{t-1}, a_{t-1})
    Posterior   q(s_t | s_{t-1}, a_{t-1}, x_t):  z_t ~ q(z_t | h_t, x_t)     `posterior`, drawn in `filter`, `observe`
    Dynamics    p(s_t | s_{t-1}, a_{t-1}):       z_t ~ p(z_t | h_t)          `prior`, drawn in `imagine`

Letters: T steps, B sequences, D GRU units (h), U hidden units, S latents, C classes, E embedding of the image x,
A actions, F = S * C + D features.
Alignment: row t of an action array holds a_{t-1}, the action that led to step t; an episode's first has none (-1).
"""

from __future__ import annotations

from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.kernels import latent, one_hot
from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import PLAIN, Loop, Weights, scan


class State(NamedTuple):
    """Model states s_t = (h_t, z_t), one or a stack of them."""

    deter: Tensor  # h_t (..., D)
    stoch: Tensor  # z_t (..., S * C), S one-hots one after another

    @property
    def features(self) -> Tensor:
        """Input of decoder, actor, critic and curiosity: (..., F), z_t before h_t."""
        return torch.cat([self.stoch, self.deter], -1)

    def detach(self) -> State:
        """The same values without gradients."""
        return State(self.deter.detach(), self.stoch.detach())


class Observed(NamedTuple):
    """T filtered steps of B sequences."""

    states: State  # h (T, B, D) and z (T, B, S * C), z drawn from the posterior
    posterior: Tensor  # logits of q (T, B, S, C)
    prior: Tensor  # logits of p (T, B, S, C)

    def detach(self) -> Observed:
        """The same values without gradients."""
        return Observed(self.states.detach(), self.posterior.detach(), self.prior.detach())


def one_hot_action(action: Tensor, actions: int) -> Tensor:
    """Actions (...) int64 as one-hots (..., A) float32; -1, no action, as zeros."""
    return (action[..., None] == torch.arange(actions, device=action.device)).float()


def gru(x: Tensor, deter: Tensor, dense: nn.Linear, norm: nn.LayerNorm) -> Tensor:
    """DreamerV2's GRU cell, one dense layer and one LayerNorm over all three gates: x (B, U), deter (B, D) -> (B, D).

    The reset gate acts on the candidate, not on the state, and the update gate is biased by -1.
    """
    gates = dense(torch.cat([x, deter.to(x.dtype)], -1)).to(deter.dtype)  # (B, 3 D)
    gates = F.layer_norm(gates, norm.normalized_shape, norm.weight, norm.bias, norm.eps)
    reset, candidate, update = gates.chunk(3, -1)  # (B, D) each
    candidate = torch.tanh(torch.sigmoid(reset) * candidate)
    return torch.lerp(deter, candidate, torch.sigmoid(update - 1))


class RSSM(nn.Module):
    """The recurrent state-space model: recurrence, posterior and dynamics, with DreamerV2's layers.

    embed, actions, deter, hidden, latents, classes: the letters E, A, D, U, S, C. steps: the loop of `observe`
    over steps (kernels/rssm_scan.py; compile.py replaces it where steps are fused).
    """

    def __init__(self, embed: int, actions: int, deter: int, hidden: int, latents: int, classes: int):
        super().__init__()
        self.actions, self.deter, self.latents, self.classes = actions, deter, latents, classes
        self.stoch = latents * classes
        self.steps: Loop = PLAIN
        self.img_in = nn.Linear(self.stoch + actions, hidden)
        self.gru = nn.Linear(hidden + deter, 3 * deter)
        self.gru_norm = nn.LayerNorm(3 * deter, eps=1e-3)
        self.img_out = nn.Linear(deter, hidden)
        self.img_dist = nn.Linear(hidden, self.stoch)
        self.obs_out = nn.Linear(deter + embed, hidden)
        self.obs_dist = nn.Linear(hidden, self.stoch)

    @property
    def features(self) -> int:
        """F, the size of `State.features`."""
        return self.stoch + self.deter

    def ones(self, state: State) -> Tensor | None:
        """Indices (B, S) of the ones in z (B, S * C), for quicker products (kernels/one_hot.py); None: not worth it."""
        return one_hot.indices(state.stoch, self.classes) if one_hot.pays(state.stoch) else None

    def initial(self, batch: int) -> State:
        """The state before an episode, or before a window of one: zeros, (B, D) and (B, S * C)."""
        weight = self.img_in.weight
        return State(weight.new_zeros(batch, self.deter), weight.new_zeros(batch, self.stoch))

    def action_input(self, action: Tensor) -> Tensor:
        """The action's share of the recurrence's first layer, bias included: (...) int64 -> (..., U)."""
        weight = self.img_in.weight[:, self.stoch:]
        return F.linear(one_hot_action(action, self.actions).to(weight.dtype), weight, self.img_in.bias)

    def embed_input(self, embed: Tensor) -> Tensor:
        """The image's share of the posterior's first layer, bias included: (..., E) -> (..., U)."""
        return F.linear(embed, self.obs_out.weight[:, self.deter:], self.obs_out.bias)

    def recur(self, state: State, action_input: Tensor, ones: Tensor | None = None) -> Tensor:
        """h_t = f(h_{t-1}, z_{t-1}, a_{t-1}): action_input (B, U) -> (B, D). ones: `self.ones(state)`, or None."""
        x = one_hot.elu_of_dense(state.stoch, self.img_in.weight[:, :self.stoch], action_input, ones)  # (B, U)
        return gru(x, state.deter, self.gru, self.gru_norm)

    def prior(self, deter: Tensor) -> Tensor:
        """Logits of p(z_t | h_t): (..., D) -> (..., S, C)."""
        return self.img_dist(F.elu(self.img_out(deter))).unflatten(-1, (self.latents, self.classes))

    def posterior(self, deter: Tensor, embed_input: Tensor) -> Tensor:
        """Logits of q(z_t | h_t, x_t): (B, D), (B, U) -> (B, S, C)."""
        x = F.elu(torch.addmm(embed_input, deter, self.obs_out.weight[:, :self.deter].t()))  # (B, U)
        return self.obs_dist(x).unflatten(-1, (self.latents, self.classes))

    def filter(self, state: State, action_input: Tensor, embed_input: Tensor, noise: Tensor
               ) -> tuple[State, Tensor]:
        """One step with an observation, z_t ~ q: the new state, and the posterior's logits (B, S, C); noise (B, S)."""
        deter = self.recur(state, action_input)
        logits = self.posterior(deter, embed_input)
        return State(deter, latent.sample(logits, noise).flatten(-2)), logits

    def imagine(self, state: State, action_input: Tensor, noise: Tensor, ones: Tensor | None = None) -> State:
        """One step without an observation, z_t ~ p, without a gradient through z_t; noise (B, S) uniform in [0, 1)."""
        deter = self.recur(state, action_input, ones)
        return State(deter, latent.draw(self.prior(deter), noise)[0].flatten(-2))

    def roll(self, state: State, action: Tensor, noise: Tensor, ones: Tensor | None) -> tuple[State, Tensor | None]:
        """`imagine` from an action (B,) int64, and `ones` of the state reached."""
        reached = self.imagine(state, self.action_input(action), noise, ones)
        return reached, self.ones(reached)

    def observe(self, state: State, embed: Tensor, action: Tensor, noise: Tensor) -> Observed:
        """Filter T steps: embed (T, B, E), action (T, B) int64, noise (T, B, S) uniform in [0, 1).

        The same as `filter` step by step, with the gradient written by hand (kernels/rssm_scan.py). What does not
        depend on the state is computed for all steps at once.
        """
        assert embed.shape[:2] == action.shape == noise.shape[:2], (embed.shape, action.shape, noise.shape)
        deter, stoch, posterior = scan(*state, self.action_input(action), self.embed_input(embed), noise,
                                       self.scan_weights(), self.gru_norm.eps, self.steps)
        return Observed(State(deter, stoch), posterior, self.prior(deter))

    def scan_weights(self) -> Weights:
        """The weights of one step of `observe`: first layers without the columns of action and image."""
        return Weights(self.img_in.weight[:, :self.stoch], self.gru.weight, self.gru.bias,
                       self.gru_norm.weight, self.gru_norm.bias, self.obs_out.weight[:, :self.deter],
                       self.obs_dist.weight, self.obs_dist.bias)
