"""A step of the scan and its gradient in float32 on a CPU: products by torch, the rest by rows.py.

The same functions as rssm_scan.forward_step and backward_step but for rounding. Letters as there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.elu import elu_, elu_backward
from curionav_cli.agents.lbs_dreamer.kernels import rows
from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import Slope, Step, Weights


def call(function: Callable[..., None], *arguments: Tensor | np.float32) -> None:
    """Call a function of rows.py, which writes into its last arguments."""
    function(*(x.numpy() if isinstance(x, Tensor) else x for x in arguments))


def gru(x: Tensor, deter: Tensor, weight: Tensor, bias: Tensor, gain: Tensor, shift: Tensor, epsilon: float
        ) -> tuple[Tensor, ...]:
    """From p_t (B, U) and h_{t-1} (B, D): h_t, [x, h_{t-1}], g, [r, c, u], g's mean and inverse deviation (B, 1)."""
    count = len(x)
    joined = x.new_empty(count, x.shape[1] + deter.shape[1])
    call(rows.elu_beside, x, deter, joined)
    gates = torch.addmm(bias, joined, weight.t())
    normed, new = torch.empty_like(gates), torch.empty_like(deter)
    mean, scale = x.new_empty(count, 1), x.new_empty(count, 1)
    call(rows.gru, gates, gain, shift, np.float32(epsilon), deter, new, normed, mean, scale)
    return new, joined, gates, normed, mean, scale


def forward_step(deter: Tensor, stoch: Tensor, action: Tensor, embed: Tensor, noise: Tensor, weights: Weights,
                 epsilon: float) -> Step:
    """Compute a step as rssm_scan.forward_step does; its probabilities are (B, S, C)."""
    before = torch.addmm(action, stoch, weights.z.t())
    deter, joined, gates, normed, mean, scale = gru(before, deter, weights.g, weights.g_bias, weights.gain,
                                                    weights.shift, epsilon)
    out = elu_(torch.addmm(embed, deter, weights.h.t()))
    logits = torch.addmm(weights.logits_bias, out, weights.logits.t()).unflatten(-1, (noise.shape[-1], -1))
    one_hot, probs = torch.empty_like(logits), torch.empty_like(logits)
    call(rows.draw, logits, noise, one_hot, probs, torch.empty(noise.shape, dtype=torch.int64))
    return Step(deter, one_hot.flatten(-2), logits, probs, joined, gates, normed, mean, scale, out)


def backward_step(step: Step, before: Tensor, to_deter: Tensor, to_stoch: Tensor, to_logits: Tensor,
                  weights: Weights) -> tuple[Slope, Tensor, Tensor]:
    """The gradient of a step, as rssm_scan.backward_step."""
    logits = torch.empty_like(step.logits)
    call(rows.straight_through, step.probs, to_stoch.view(step.logits.shape), to_logits, logits)
    logits = logits.flatten(-2)
    q = elu_backward(logits @ weights.logits, step.out)
    to_normed, to_gates = torch.empty_like(step.normed), torch.empty_like(step.gates)
    direct = torch.empty_like(before)
    call(rows.gru_backward, torch.addmm(to_deter, q, weights.h), before, step.gates, step.normed, step.mean, step.scale,
         weights.gain, to_normed, to_gates, direct)
    to_x, joined = (to_gates @ weights.g).split([q.shape[-1], before.shape[-1]], -1)
    p = elu_backward(to_x, step.joined[:, :q.shape[-1]])
    return Slope(p, to_normed, to_gates, q, logits), direct + joined, p @ weights.z
