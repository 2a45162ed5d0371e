"""Filtering a sequence (RSSM.observe), with the gradient written by hand.

Letters: T steps, B sequences, D GRU units, U hidden units, S latents, C classes. One step, which RSSM.filter has in
modules, with row vectors, p and q for the inputs of an elu, a_t and e_t for the shares of action and image:

    p_t = a_t + z_{t-1} W_z     x = elu(p)      g = [x, h_{t-1}] W_g + b_g       [r, c, u] = LayerNorm(g)
    R = sigmoid(r)     K = tanh(R c)     V = sigmoid(u - 1)                      h_t = h_{t-1} + V (K - h_{t-1})
    q_t = e_t + h_t W_h         o = elu(q)      l_t = o W_l + b_l                z_t one-hot, drawn from softmax(l_t)

Write y' for the loss's derivative by y. Backwards in time, with the gradients of the results h_t, z_t and l_t as
`outside`, and those that step t + 1 sends to h_t and z_t as `early`:

    z' = outside + early        l' = outside + softmax's (z')        q' = (l' W_l^T) elu's
    h' = outside + early + q' W_h^T
    V' = h' (K - h_{t-1})       K' = h' V      r' = K' (1 - K^2) c R (1 - R)      c' = K' (1 - K^2) R
    u' = V' V (1 - V)           g' = LayerNorm's (r', c', u')        [x', j] = g' W_g^T     p' = x' elu's
    early at z_{t-1} = p' W_z^T          early at h_{t-1} = j + h' (1 - V)

and a' = p', e' = q'. A weight's derivative is a sum over steps, W_g' = sum_t [x, h_{t-1}]^T g': one product of
all T * B rows after the loop, where autograd makes T small ones, and no graph of hundreds of nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import torch
import torch.nn.functional as F
from torch import Tensor

from curionav_cli.agents.elu import elu_backward
from curionav_cli.agents.lbs_dreamer.kernels import latent

aten = torch.ops.aten


class Weights(NamedTuple):
    """The weights of a step, transposed as nn.Linear holds them."""

    z: Tensor  # W_z (U, S * C)
    g: Tensor  # W_g (3 D, U + D)
    g_bias: Tensor
    gain: Tensor  # of the LayerNorm (3 D,)
    shift: Tensor
    h: Tensor  # W_h (U, D)
    logits: Tensor  # W_l (S * C, U)
    logits_bias: Tensor

    def cast(self, like: Tensor) -> Weights:
        """The weights in the type of `like`, except those of the LayerNorm."""
        return Weights(*(w.to(like.dtype) for w in self))._replace(gain=self.gain, shift=self.shift)


class Step(NamedTuple):
    """A step's results (the first three) and what its gradient needs, of one step or stacked over T."""

    deter: Tensor  # h_t (B, D)
    stoch: Tensor  # z_t (B, S * C)
    logits: Tensor  # l_t (B, S, C)
    probs: Tensor  # softmax(l_t), as latent.py lays it out
    joined: Tensor  # [x, h_{t-1}] (B, U + D)
    gates: Tensor  # g (B, 3 D)
    normed: Tensor  # [r, c, u] (B, 3 D)
    mean: Tensor  # of g (B, 1)
    scale: Tensor  # one over the deviation of g (B, 1)
    out: Tensor  # o (B, U)


def forward_step(deter: Tensor, stoch: Tensor, action: Tensor, embed: Tensor, noise: Tensor, weights: Weights,
                 epsilon: float) -> Step:
    """Compute a step from h_{t-1} (B, D), z_{t-1} (B, S * C), a_t and e_t (B, U), and noise (B, S)."""
    x = F.elu(torch.addmm(action, stoch.to(embed.dtype), weights.z.t()))
    joined = torch.cat([x, deter.to(embed.dtype)], -1)
    gates = torch.addmm(weights.g_bias, joined, weights.g.t()).to(deter.dtype)
    normed, mean, scale = torch.native_layer_norm(gates, weights.gain.shape, weights.gain, weights.shift, epsilon)
    _, _, proposal, update = parts(normed)
    deter = torch.lerp(deter, proposal, update)
    out = F.elu(torch.addmm(embed, deter.to(embed.dtype), weights.h.t()))
    logits = torch.addmm(weights.logits_bias, out, weights.logits.t()).unflatten(-1, (noise.shape[-1], -1))
    one_hot, probs = latent.draw(logits, noise)
    return Step(deter, one_hot.flatten(-2), logits, probs, joined, gates, normed, mean, scale, out)


def parts(normed: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """The gates [r, c, u] (B, 3 D) -> R, c, K, V, (B, D) each."""
    reset, candidate, update = normed.chunk(3, -1)
    reset = torch.sigmoid(reset)
    return reset, candidate, torch.tanh(reset * candidate), torch.sigmoid(update - 1)


def parts_backward(gradient: Tensor, before: Tensor, normed: Tensor) -> tuple[Tensor, Tensor]:
    """The gradient of `parts`: h' (B, D), h_{t-1} and [r, c, u] -> (r', c', u') (B, 3 D), and h' (1 - V)."""
    reset, candidate, proposal, update = parts(normed)
    to_proposal = gradient * update
    inner = aten.tanh_backward.default(to_proposal, proposal)
    to_reset = aten.sigmoid_backward.default(inner * candidate, reset)
    to_update = aten.sigmoid_backward.default(gradient * (proposal - before), update)
    return torch.cat([to_reset, inner * reset, to_update], -1), gradient - to_proposal


class Slope(NamedTuple):
    """The loss's derivatives in one step, or stacked over T."""

    p: Tensor  # p' = a' (B, U)
    n: Tensor  # [r', c', u'] (B, 3 D)
    g: Tensor  # g' (B, 3 D)
    q: Tensor  # q' = e' (B, U)
    logits: Tensor  # l' (B, S * C)


def backward_step(step: Step, before: Tensor, to_deter: Tensor, to_stoch: Tensor, to_logits: Tensor,
                  weights: Weights) -> tuple[Slope, Tensor, Tensor]:
    """The gradient of a step: from h', z' and l' its derivatives, and `early` at h_{t-1} (`before`) and z_{t-1}."""
    to_probs = latent.straight_through(step.probs, to_stoch.view(step.logits.shape))
    logits = (to_logits + to_probs).flatten(-2).to(step.out.dtype)
    q = elu_backward(logits @ weights.logits, step.out)
    n, direct = parts_backward(to_deter + q @ weights.h, before, step.normed)
    g, _, _ = aten.native_layer_norm_backward.default(
        n, step.gates, n.shape[1:], step.mean, step.scale, weights.gain, weights.shift, [True, False, False])
    g = g.to(q.dtype)
    to_x, joined = (g @ weights.g).split([q.shape[-1], before.shape[-1]], -1)
    p = elu_backward(to_x, step.joined[:, :q.shape[-1]])
    return Slope(p, n, g, q, logits), direct + joined, p @ weights.z


def weight_slopes(slope: Slope, kept: Step, stoch: Tensor, weights: Weights) -> Weights:
    """The weights' gradients, summed over steps: from stacks (T, B, ...), and z_{t-1} (T, B, S * C)."""
    p, n, g, q, logits = (x.flatten(0, 1) for x in slope)
    inputs = (x.flatten(0, 1) for x in (stoch, kept.joined, kept.deter, kept.out))
    z, joined, deter, out = (x.to(p.dtype) for x in inputs)
    _, gain, shift = aten.native_layer_norm_backward.default(
        n, kept.gates.flatten(0, 1), n.shape[1:], kept.mean.flatten(0, 1), kept.scale.flatten(0, 1),
        weights.gain, weights.shift, [False, True, True])
    found = Weights(p.t() @ z, g.t() @ joined, g.sum(0), gain, shift, q.t() @ deter,
                    logits.t() @ out, logits.sum(0))
    return Weights(*(x.to(w.dtype) for x, w in zip(found, weights, strict=True)))


class Loop(Protocol):
    """The loop over steps of a scan: `Steps`, or fused for a CPU (fused_filter.py)."""

    def over_time(self, deter: Tensor, stoch: Tensor, action: Tensor, embed: Tensor, noise: Tensor, weights: Weights,
                  epsilon: float) -> Step:
        """All steps, stacked over T; arguments as `scan`."""

    def back_in_time(self, kept: Step, deter: Tensor, to_deter: Tensor, to_stoch: Tensor, to_logits: Tensor,
                     weights: Weights) -> tuple[Slope, Tensor, Tensor]:
        """The gradient: from h', z' and l' (T, B, ...) the derivatives of all steps, and `early` of the first one.

        deter: the state before (B, D).
        """


class Steps(NamedTuple):
    """A Python loop of the functions of a step, forwards and backwards; compile.py replaces them on a GPU."""

    forward: Callable[..., Step] = forward_step
    backward: Callable[..., tuple[Slope, Tensor, Tensor]] = backward_step

    def over_time(self, deter: Tensor, stoch: Tensor, action: Tensor, embed: Tensor, noise: Tensor, weights: Weights,
                  epsilon: float) -> Step:
        steps, state = [], (deter, stoch)
        for inputs in zip(action, embed, noise, strict=True):
            steps.append(self.forward(*state, *inputs, weights, epsilon))
            state = steps[-1].deter, steps[-1].stoch
        return Step(*(torch.stack(tensors) for tensors in zip(*steps, strict=True)))

    def back_in_time(self, kept: Step, deter: Tensor, to_deter: Tensor, to_stoch: Tensor, to_logits: Tensor,
                     weights: Weights) -> tuple[Slope, Tensor, Tensor]:
        before = torch.cat([deter[None], kept.deter[:-1]])
        early_deter, early_stoch, slopes = torch.zeros_like(deter), torch.zeros_like(kept.stoch[0]), []
        for t in reversed(range(len(before))):
            slope, early_deter, early_stoch = self.backward(
                Step(*(x[t] for x in kept)), before[t], to_deter[t] + early_deter, to_stoch[t] + early_stoch,
                to_logits[t], weights)
            slopes.append(slope)
        return Slope(*(torch.stack(x[::-1]) for x in zip(*slopes, strict=True))), early_deter, early_stoch


PLAIN = Steps()


class _Scan(torch.autograd.Function):
    """The loop over steps, forwards and backwards."""

    @staticmethod
    def forward(ctx, do, epsilon, *tensors):
        deter, stoch, action, embed, noise, *weights = (tensor.detach() for tensor in tensors)
        kept = do.over_time(deter, stoch, action, embed, noise, Weights(*weights).cast(embed), epsilon)
        ctx.save_for_backward(deter, stoch, *weights, *kept)
        ctx.do = do
        return kept.deter, kept.stoch, kept.logits

    @staticmethod
    def backward(ctx, to_deter, to_stoch, to_logits):
        deter, stoch, *rest = (tensor.detach() for tensor in ctx.saved_tensors)
        weights, kept = Weights(*rest[:8]), Step(*rest[8:])
        slope, early_deter, early_stoch = ctx.do.back_in_time(kept, deter, to_deter, to_stoch, to_logits,
                                                              weights.cast(kept.out))
        found = weight_slopes(slope, kept, torch.cat([stoch[None], kept.stoch[:-1]]), weights)
        return None, None, early_deter, early_stoch, slope.p, slope.q, None, *found


def scan(deter: Tensor, stoch: Tensor, action: Tensor, embed: Tensor, noise: Tensor, weights: Weights, epsilon: float,
         do: Loop = PLAIN) -> tuple[Tensor, Tensor, Tensor]:
    """Filter T steps: h (T, B, D), z (T, B, S * C) and the posterior's logits l (T, B, S, C).

    From the state before, deter (B, D) and stoch (B, S * C), the shares of actions and images (T, B, U), and uniform
    noise (T, B, S). epsilon: the LayerNorm's. Products are in the type of `embed`, all else in that of `deter`.
    """
    return _Scan.apply(do, epsilon, deter, stoch, action, embed, noise, *weights)
