"""Discrete latents: S categoricals of C classes (DreamerV2, sections 2.1 and 2.2). Pure functions.

Logits are (..., S, C) in nats; everything is computed in float32 at least, whatever the networks run
in, and class by class, (..., C, S): over a short last dimension torch works number by number, ten
times as slowly.
"""

from __future__ import annotations

import torch
from torch import Tensor


def class_first(x: Tensor) -> Tensor:
    """(..., S, C) -> (..., C, S), in float32 at least."""
    return x.to(torch.promote_types(x.dtype, torch.float32)).transpose(-1, -2)


def inverse_cdf(probs: Tensor, noise: Tensor, dim: int = -1) -> Tensor:
    """Index (...) drawn from probs (..., C along `dim`, ...) by uniform noise (...) in [0, 1).

    Clamped, because rounding may leave the sum of the probabilities below the noise.
    """
    index = (probs.cumsum(dim) <= noise.unsqueeze(dim)).sum(dim)
    return index.clamp_(max=probs.shape[dim] - 1)


def draw(logits: Tensor, noise: Tensor) -> tuple[Tensor, Tensor]:
    """One-hot samples (..., S, C), and the probabilities (..., C, S) they are drawn from; noise (..., S)."""
    assert logits.shape[:-1] == noise.shape, (logits.shape, noise.shape)
    probs = class_first(logits).softmax(-2)
    index = inverse_cdf(probs, noise, -2)
    return probs.new_zeros(logits.shape).scatter_(-1, index[..., None], 1.0), probs


def straight_through(probs: Tensor, gradient: Tensor) -> Tensor:
    """What a sample's gradient (..., S, C) means for the logits, were it that of probs (..., C, S)."""
    weighted = probs * gradient.transpose(-1, -2)
    return (weighted - probs * weighted.sum(-2, keepdim=True)).transpose(-1, -2)


class _Sample(torch.autograd.Function):
    @staticmethod
    def forward(ctx, logits: Tensor, noise: Tensor) -> Tensor:
        one_hot, probs = draw(logits, noise)
        ctx.save_for_backward(probs)
        ctx.dtype = logits.dtype
        return one_hot

    @staticmethod
    def backward(ctx, gradient: Tensor):
        (probs,) = ctx.saved_tensors
        return straight_through(probs, gradient).to(ctx.dtype), None


def sample(logits: Tensor, noise: Tensor) -> Tensor:
    """One-hot samples (..., S, C) with straight-through gradients; noise (..., S) uniform in [0, 1)."""
    return _Sample.apply(logits, noise)


class _KL(torch.autograd.Function):
    """KL and a multiple of its gradient for each side.

    For one latent, with q = softmax(l) and p = softmax(r), and d = log q - log p:

        KL = sum_c q_c d_c      dKL/dl_c = q_c (d_c - KL)      dKL/dr_c = p_c - q_c
    """

    @staticmethod
    def forward(ctx, left: Tensor, right: Tensor, to_left: float, to_right: float) -> Tensor:
        log_left, log_right = (class_first(logits).log_softmax(-2) for logits in (left, right))
        probs, difference = log_left.exp(), log_left - log_right
        each = (probs * difference).sum(-2, keepdim=True)  # (..., 1, S)
        ctx.save_for_backward(probs, difference, each, log_right)
        ctx.scales, ctx.dtypes = (to_left, to_right), (left.dtype, right.dtype)
        return each.sum((-2, -1))

    @staticmethod
    def backward(ctx, gradient: Tensor):
        probs, difference, each, log_right = ctx.saved_tensors
        gradient = gradient[..., None, None]
        to_left = probs * (difference - each) * (gradient * ctx.scales[0])
        to_right = (log_right.exp() - probs) * (gradient * ctx.scales[1])
        left, right = (x.transpose(-1, -2).to(dtype) for x, dtype in zip((to_left, to_right), ctx.dtypes, strict=True))
        return left, right, None, None


def kl(left: Tensor, right: Tensor, to_left: float = 1.0, to_right: float = 1.0) -> Tensor:
    """KL(left || right) in nats, summed over the S latents: (..., S, C) twice -> (...).

    `to_left` and `to_right` multiply the gradient of either side, and not the value.
    """
    assert left.shape == right.shape, (left.shape, right.shape)
    return _KL.apply(left, right, to_left, to_right)


def balanced_kl(posterior: Tensor, prior: Tensor, balance: float, free_nats: float) -> Tensor:
    """KL balancing with free nats (DreamerV2, algorithm 2): logits (..., S, C) -> scalar.

    `balance` of the gradient goes to the prior, the rest to the posterior. The free nats are taken
    off the mean over batch and time; the two terms have the same mean, so that is one clamp.
    """
    return kl(posterior, prior, 1 - balance, balance).mean().clamp(min=free_nats)


def entropy(logits: Tensor) -> Tensor:
    """Entropy in nats over the last dimension: (..., S, C) -> (..., S)."""
    log_probs = class_first(logits).log_softmax(-2)
    return -(log_probs.exp() * log_probs).sum(-2)
