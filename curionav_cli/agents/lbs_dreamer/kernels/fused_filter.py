"""The scan of RSSM.observe and its gradient in float32 on a CPU: all steps in one call of a function by numba.

The same computation as rssm_scan.Steps but for rounding. A step has seven sequences: torch takes longer to start its
thirty operations than to compute them. Products are numpy's of one thread, with weights laid out once. Letters as in
rssm_scan.py.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.kernels import rows
from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import Slope, Step, Weights


@rows.compiled
def over_time(first_deter, first_stoch, action, embed, noise, epsilon, w_z, w_g, g_bias, gain, shift, w_h, w_l, l_bias,
              deter, stoch, logits, probs, joined, gates, normed, mean, scale, out):
    """Fill Step's arrays, the last ten, from inputs as of `scan`; w_z ... w_l are transposed, (inputs, outputs)."""
    index = np.empty(noise.shape[1:], np.int64)
    flat = logits.reshape(len(logits), logits.shape[1], -1)
    x = np.empty(embed.shape[1:], np.float32)
    units = x.shape[1]
    for t in range(len(noise)):
        before = first_deter if t == 0 else deter[t - 1]
        np.dot(first_stoch if t == 0 else stoch[t - 1], w_z, x)
        rows.add_elu(x, action[t])
        joined[t, :, :units] = x
        joined[t, :, units:] = before
        np.dot(joined[t], w_g, gates[t])
        rows.add_bias(gates[t], g_bias)
        rows.gru(gates[t], gain, shift, epsilon, before, deter[t], normed[t], mean[t], scale[t])
        np.dot(deter[t], w_h, out[t])
        rows.add_elu(out[t], embed[t])
        np.dot(out[t], w_l, flat[t])
        rows.add_bias(flat[t], l_bias)
        rows.draw(logits[t], noise[t], stoch[t], probs[t], index)


@rows.compiled
def back_in_time(to_deter, to_stoch, to_logits, w_z, w_g, gain, w_h, w_l, first_deter, deter, probs, joined, gates,
                 normed, mean, scale, out, p, n, g, q, logits, early_deter, early_stoch):
    """Fill Slope's arrays and the two `early`, the last seven, which begin as zeros; weights as in Weights."""
    sloped, inner = np.empty_like(probs[0]), np.empty_like(joined[0])
    h, direct = np.empty_like(early_deter), np.empty_like(early_deter)
    flat = logits.reshape(probs.shape)
    units = p.shape[2]
    for t in range(len(p) - 1, -1, -1):
        before = first_deter if t == 0 else deter[t - 1]
        sloped[:] = (to_stoch[t] + early_stoch).reshape(sloped.shape)
        rows.straight_through(probs[t], sloped, to_logits[t], flat[t])
        np.dot(logits[t], w_l, q[t])
        rows.elu_slope(q[t], out[t])
        np.dot(q[t], w_h, h)
        h += to_deter[t] + early_deter
        rows.gru_backward(h, before, gates[t], normed[t], mean[t], scale[t], gain, n[t], g[t], direct)
        np.dot(g[t], w_g, inner)
        p[t] = inner[:, :units]
        rows.elu_slope(p[t], joined[t, :, :units])
        early_deter[:] = direct + inner[:, units:]
        np.dot(p[t], w_z, early_stoch)


def call(function: Callable[..., None], *arguments: Tensor | np.float32) -> None:
    """Call a compiled function, which writes into its last arguments; all but those are made contiguous."""
    arrays: list[Any] = [x.detach().contiguous().numpy() if isinstance(x, Tensor) else x for x in arguments]
    function(*arrays)


class FusedLoop:
    """rssm_scan.Loop by the two functions."""

    def over_time(self, deter: Tensor, stoch: Tensor, action: Tensor, embed: Tensor, noise: Tensor, weights: Weights,
                  epsilon: float) -> Step:
        (steps, batch, latents), size = noise.shape, deter.shape[-1]

        def made(*shape: int) -> Tensor:
            return deter.new_empty(steps, batch, *shape)

        grid = latents, stoch.shape[-1] // latents
        kept = Step(made(size), made(stoch.shape[-1]), made(*grid), made(*grid), made(embed.shape[-1] + size),
                    made(3 * size), made(3 * size), made(1), made(1), made(embed.shape[-1]))
        laid = weights._replace(z=weights.z.t(), g=weights.g.t(), h=weights.h.t(), logits=weights.logits.t())
        call(over_time, deter, stoch, action, embed, noise, np.float32(epsilon), *laid, *kept)
        return kept

    def back_in_time(self, kept: Step, deter: Tensor, to_deter: Tensor, to_stoch: Tensor, to_logits: Tensor,
                     weights: Weights) -> tuple[Slope, Tensor, Tensor]:
        made = Slope(*(torch.empty_like(x) for x in (kept.out, kept.gates, kept.gates, kept.out, kept.stoch)))
        early = torch.zeros_like(deter), torch.zeros_like(kept.stoch[0])
        call(back_in_time, to_deter, to_stoch, to_logits, weights.z, weights.g, weights.gain, weights.h, weights.logits,
             deter, kept.deter, kept.probs, kept.joined, kept.gates, kept.normed, kept.mean, kept.scale, kept.out,
             *made, *early)
        return made, *early
