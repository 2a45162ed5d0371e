"""Imagined rollouts in float32 on a CPU: all steps of Behaviour.imagine in one call of a function by numba.

The same computation but for rounding. Letters: H steps, N rollouts, S latents, C classes, D GRU units, U hidden units
of the RSSM, V units of the actor, L its hidden layers, A actions, F = S * C + D features.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.kernels import one_hot, rows
from curionav_cli.agents.lbs_dreamer.kernels.fused_filter import call
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State


@rows.compiled
def act(h, shares, noise, first, hidden, hidden_bias, last, last_bias, layers, policy, action):
    """The actor's layers (L, N, V), its logits and the actions drawn, from h (N, D) and the latents' shares (N, V)."""
    np.dot(h, first, layers[0])
    rows.add_elu(layers[0], shares)
    for i in range(len(hidden)):
        np.dot(layers[i], hidden[i], layers[i + 1])
        rows.add_bias_elu(layers[i + 1], hidden_bias[i])
    np.dot(layers[-1], last, policy)
    rows.add_bias(policy, last_bias)
    rows.choose(policy, noise, action)


@rows.compiled
def roll_out(h, noise, table, table_bias, actions, first, hidden, hidden_bias, last, last_bias, w_g, g_bias, gain,
             shift, epsilon, w_out, out_bias, w_l, l_bias, features, ones, layers, policy, action):
    """Fill the last five arrays, of which those of s_0 are given: features (H + 1, N, F), ones (H + 1, N, S),
    layers (H, L, N, V), policy (H, N, A) and action (H, N).

    h (N, D) is that of s_0, and is overwritten. table (S * C, V + U): the latents' columns in the first layers of the
    actor and of the RSSM, table_bias (V,) the bias of the former; actions (A, U): the actions' shares of the latter,
    with its bias. Other weights are transposed, (inputs, outputs).
    """
    count, size = h.shape
    hot, units = table.shape[0], first.shape[1]
    shares, x = np.empty((count, units), np.float32), np.empty((count, w_g.shape[0] - size), np.float32)
    joined, new = np.empty((count, w_g.shape[0]), np.float32), np.empty_like(h)
    gates, normed = np.empty((count, 3 * size), np.float32), np.empty((count, 3 * size), np.float32)
    mean, scale = np.empty((count, 1), np.float32), np.empty((count, 1), np.float32)
    out = np.empty((count, w_out.shape[1]), np.float32)
    flat, stoch = np.empty((count, hot), np.float32), np.empty((count, hot), np.float32)
    logits = flat.reshape(count, ones.shape[2], -1)
    for t in range(len(noise)):
        rows.add_columns(ones[t], table, table_bias, shares, x)
        act(h, shares, noise[t, :, -1], first, hidden, hidden_bias, last, last_bias, layers[t], policy[t], action[t])
        for row in range(count):
            x[row] += actions[action[t, row]]
        rows.elu_beside(x, h, joined)
        np.dot(joined, w_g, gates)
        rows.add_bias(gates, g_bias)
        rows.gru(gates, gain, shift, epsilon, h, new, normed, mean, scale)
        h[:] = new
        np.dot(h, w_out, out)
        rows.add_bias_elu(out, out_bias)
        np.dot(out, w_l, flat)
        rows.add_bias(flat, l_bias)
        rows.draw(logits, noise[t], stoch, logits, ones[t + 1])
        features[t + 1, :, :hot] = stoch
        features[t + 1, :, hot:] = h


@torch.no_grad()
def imagine(actor: MLP, rssm: RSSM, start: State, noise: Tensor) -> Imagined:
    """Roll out H steps from N states as Behaviour.imagine does."""
    (steps, count, _), layers = noise.shape, cast(list[nn.Linear], list(actor.layers))
    features = noise.new_empty(steps + 1, count, rssm.features)
    features[0] = start.features
    ones = torch.empty(steps + 1, count, rssm.latents, dtype=torch.int64)
    ones[0] = one_hot.indices(start.stoch, rssm.classes)
    made = noise.new_empty(steps, len(layers), count, actor.out.in_features)
    policy, action = noise.new_empty(steps, count, rssm.actions), torch.empty(steps, count, dtype=torch.int64)
    call(roll_out, start.deter.clone(), noise, *actor_weights(actor, layers, rssm), *dynamics_weights(rssm),
         features, ones, made, policy, action)
    return Imagined(features, action, ones, [*made.unbind(1), policy])


def actor_weights(actor: MLP, layers: list[nn.Linear], rssm: RSSM) -> list[Tensor]:
    """`table` to `last_bias` of `roll_out`."""
    first, *hidden = layers
    table = torch.cat([first.weight[:, :actor.hot].t(), rssm.img_in.weight[:, :rssm.stoch].t()], 1)
    shape = len(hidden), actor.out.in_features
    between = torch.stack([layer.weight.t() for layer in hidden]) if hidden else table.new_empty(*shape, shape[1])
    biases = torch.stack([layer.bias for layer in hidden]) if hidden else table.new_empty(shape)
    return [table, first.bias, rssm.action_input(torch.arange(rssm.actions)), first.weight[:, actor.hot:].t(), between,
            biases, actor.out.weight.t(), actor.out.bias]


def dynamics_weights(rssm: RSSM) -> list[Tensor | np.float32]:
    """`w_g` to `l_bias` of `roll_out`."""
    norm = rssm.gru_norm
    return [rssm.gru.weight.t(), rssm.gru.bias, norm.weight, norm.bias, np.float32(norm.eps),
            rssm.img_out.weight.t(), rssm.img_out.bias, rssm.img_dist.weight.t(), rssm.img_dist.bias]
