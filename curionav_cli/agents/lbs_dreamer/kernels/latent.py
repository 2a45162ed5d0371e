"""Discrete latents, S categoricals of C classes: samples, KL and entropy (DreamerV2, sections 2.1 and 2.2).

Pure functions of logits (..., S, C) in nats, computed in float32 at least, whatever the networks run in. Where classes
are few (scale=cpu) they are laid out as (..., C, S): over a last dimension that does not fill a vector register torch
works number by number, ten times as slowly; over a longer one (scale=paper) it is faster by half.
"""

from __future__ import annotations

import torch
from torch import Tensor

FEW = 16  # classes below which they do not come last


def laid_out(x: Tensor) -> tuple[Tensor, int]:
    """Numbers (..., S, C) in float32 at least, as (..., C, S) where classes are few; and the classes' dimension."""
    x = x.to(torch.promote_types(x.dtype, torch.float32))
    return (x.transpose(-1, -2), -2) if x.shape[-1] < FEW else (x, -1)


def laid_back(x: Tensor, dim: int) -> Tensor:
    """The inverse of `laid_out`: (..., S, C)."""
    return x.transpose(-1, -2) if dim == -2 else x


def inverse_cdf(probs: Tensor, noise: Tensor, dim: int = -1) -> Tensor:
    """Draw indices (...) int64 from probs (..., C along `dim`, ...) by uniform noise (...) in [0, 1).

    Clamped, because rounding may leave the sum of the probabilities below the noise.
    """
    index = (probs.cumsum(dim) <= noise.unsqueeze(dim)).sum(dim, dtype=torch.int32)
    return index.clamp_(max=probs.shape[dim] - 1).long()


def draw(logits: Tensor, noise: Tensor) -> tuple[Tensor, Tensor]:
    """Draw one-hots (..., S, C) without gradients by noise (..., S); also the probabilities, `laid_out`."""
    assert logits.shape[:-1] == noise.shape, (logits.shape, noise.shape)
    values, dim = laid_out(logits)
    probs = values.softmax(dim)
    index = inverse_cdf(probs, noise, dim)
    return probs.new_zeros(logits.shape).scatter_(-1, index[..., None], 1.0), probs


def straight_through(probs: Tensor, gradient: Tensor) -> Tensor:
    """The logits' gradient (..., S, C) if `gradient` (..., S, C), a sample's, were that of the laid out probs."""
    gradient, dim = laid_out(gradient)
    weighted = probs * gradient
    return laid_back(weighted - probs * weighted.sum(dim, keepdim=True), dim)


class _Sample(torch.autograd.Function):
    """`draw`, with the straight-through gradient."""

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
    """Draw one-hots (..., S, C) with straight-through gradients by noise (..., S) uniform in [0, 1)."""
    return _Sample.apply(logits, noise)


class _KL(torch.autograd.Function):
    """KL and a multiple of its gradient for each side.

    For one latent, with q = softmax(l) and p = softmax(r), and d = log q - log p:

        KL = sum_c q_c d_c      dKL/dl_c = q_c (d_c - KL)      dKL/dr_c = p_c - q_c
    """

    @staticmethod
    def forward(ctx, left: Tensor, right: Tensor, to_left: float, to_right: float) -> Tensor:
        ctx.scales, ctx.dtypes = (to_left, to_right), (left.dtype, right.dtype)
        (left, dim), (right, _) = laid_out(left), laid_out(right)
        log_left, log_right = left.log_softmax(dim), right.log_softmax(dim)
        probs, difference = log_left.exp(), log_left - log_right
        each = (probs * difference).sum(dim, keepdim=True)
        ctx.save_for_backward(probs, difference, each, log_right)
        ctx.dim = dim
        return each.sum((-2, -1))

    @staticmethod
    def backward(ctx, gradient: Tensor):
        probs, difference, each, log_right = ctx.saved_tensors
        gradient = gradient[..., None, None]
        to_left = probs * (difference - each) * (gradient * ctx.scales[0])
        to_right = (log_right.exp() - probs) * (gradient * ctx.scales[1])
        both = zip((to_left, to_right), ctx.dtypes, strict=True)
        return *(laid_back(x, ctx.dim).to(dtype) for x, dtype in both), None, None


def kl(left: Tensor, right: Tensor, to_left: float = 1.0, to_right: float = 1.0) -> Tensor:
    """KL(left || right) in nats, summed over the S latents: (..., S, C) twice -> (...).

    `to_left` and `to_right` multiply the gradient of either side, and not the value.
    """
    assert left.shape == right.shape, (left.shape, right.shape)
    return _KL.apply(left, right, to_left, to_right)


def balanced_kl(posterior: Tensor, prior: Tensor, balance: float, free_nats: float) -> Tensor:
    """KL balancing with free nats (DreamerV2, algorithm 2): logits (..., S, C) -> scalar.

    `balance` of the gradient goes to the prior, the rest to the posterior. The mean over batch and time is clamped from
    below at `free_nats`; the two terms have the same mean, so that is one clamp.
    """
    return kl(posterior, prior, 1 - balance, balance).mean().clamp(min=free_nats)


def entropy(logits: Tensor) -> Tensor:
    """Entropy of each latent in nats: (..., S, C) -> (..., S)."""
    values, dim = laid_out(logits)
    log_probs = values.log_softmax(dim)
    return -(log_probs.exp() * log_probs).sum(dim)
